//! Values: numbers, parameters and expressions in brackets.

use super::parameters;
use super::parameters::{ParameterKey, Parameters};
use super::predefined::ModalView;
use crate::math;
use crate::read::control::COMPUTED;
use crate::read::log::ReadRemark;
use crate::read::number::{self, DecimalMark};

/// Deepest nesting of brackets; deeper is no program for a machine.
const DEEPEST: u32 = 60;

/// Two values closer than this are equal, as `LinuxCNC`'s interpreter compares.
const EQUAL: f64 = 1e-6;

/// Environment of an expression.
pub(super) struct ExpressionEnv<'a> {
    pub(super) parameters: &'a Parameters,
    pub(super) view: ModalView<'a>,
    /// Rounding functions and ATAN as Fanuc has them.
    pub(super) fanuc: bool,
}

/// A cursor on a line.
pub(super) struct ExpressionScan<'a> {
    pub(super) text: &'a str,
    pub(super) at: usize,
    depth: u32,
}

/// A value and the digits behind its point, [`COMPUTED`] if it was no plain number; whether it had a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExpressionValue {
    pub(super) number: f64,
    pub(super) decimals: u8,
    pub(super) point: bool,
}

/// Operators by how tightly they bind, the loosest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operator {
    And,
    Or,
    Xor,
    Equal,
    NotEqual,
    Greater,
    GreaterEqual,
    Less,
    LessEqual,
    Plus,
    Minus,
    Times,
    Over,
    Modulo,
    Power,
}

/// Words that are operators.
const OPERATORS: [(&str, Operator); 15] = [
    ("**", Operator::Power),
    ("*", Operator::Times),
    ("/", Operator::Over),
    ("+", Operator::Plus),
    ("-", Operator::Minus),
    ("MOD", Operator::Modulo),
    ("AND", Operator::And),
    ("XOR", Operator::Xor),
    ("OR", Operator::Or),
    ("EQ", Operator::Equal),
    ("NE", Operator::NotEqual),
    ("GT", Operator::Greater),
    ("GE", Operator::GreaterEqual),
    ("LT", Operator::Less),
    ("LE", Operator::LessEqual),
];

/// Levels of binding.
const TIGHTEST: u8 = 5;

impl Operator {
    fn level(self) -> u8 {
        match self {
            // Precedence of RS274/NGC: ** first, then products, sums, comparisons, and logic last.
            Self::And | Self::Or | Self::Xor => 1,
            Self::Equal
            | Self::NotEqual
            | Self::Greater
            | Self::GreaterEqual
            | Self::Less
            | Self::LessEqual => 2,
            Self::Plus | Self::Minus => 3,
            Self::Times | Self::Over | Self::Modulo => 4,
            Self::Power => TIGHTEST,
        }
    }

    fn apply(self, a: f64, b: f64, at: usize) -> Result<f64, ReadRemark> {
        // True is any value but zero; results are 1 and 0.
        let is = |value: f64| value.abs() > 0.0;
        let value = match self {
            Self::And => f64::from(is(a) && is(b)),
            Self::Or => f64::from(is(a) || is(b)),
            Self::Xor => f64::from(is(a) != is(b)),
            Self::Equal => f64::from((a - b).abs() < EQUAL),
            Self::NotEqual => f64::from((a - b).abs() >= EQUAL),
            Self::Greater => f64::from(a > b),
            Self::GreaterEqual => f64::from(a >= b),
            Self::Less => f64::from(a < b),
            Self::LessEqual => f64::from(a <= b),
            Self::Plus => a + b,
            Self::Minus => a - b,
            Self::Times => a * b,
            Self::Over => a / b,
            Self::Modulo => modulo(a, b),
            Self::Power => math::powf(a, b),
        };
        finite(value, at, || format!("{a} {} {b}", self.name()))
    }

    fn name(self) -> &'static str {
        OPERATORS.iter().find(|(_, operator)| *operator == self).map_or("", |(name, _)| name)
    }
}

/// Returns the remainder, never negative, as `LinuxCNC`'s interpreter has it.
fn modulo(a: f64, b: f64) -> f64 {
    // The result lies in [0, |b|).
    let rest = a % b;
    if rest < 0.0 { rest + b.abs() } else { rest }
}

fn finite(value: f64, at: usize, what: impl FnOnce() -> String) -> Result<f64, ReadRemark> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(ReadRemark::new(
        at,
        format!("{} has no finite value", what()),
        "look at what it is made of",
    ))
}

impl<'a> ExpressionScan<'a> {
    pub(super) fn new(text: &'a str, at: usize) -> Self {
        Self { text, at, depth: 0 }
    }

    pub(super) fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    pub(super) fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }

    /// Passes blanks.
    #[inline]
    pub(super) fn blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\r')) {
            self.at += 1;
        }
    }

    /// Passes blanks and comments; one that is not closed stays.
    pub(super) fn blanks_and_comments(&mut self) {
        loop {
            self.blanks();
            match self.peek() {
                Some(b'(') => match self.rest().find(')') {
                    Some(end) => self.at += end + 1,
                    None => return,
                },
                Some(b';') => self.at = self.text.len(),
                _ => return,
            }
        }
    }

    fn take(&mut self, byte: u8) -> bool {
        self.blanks();
        let found = self.peek() == Some(byte);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, byte: u8) -> Result<(), ReadRemark> {
        if self.take(byte) {
            return Ok(());
        }
        let message = format!("{} is missing here", char::from(byte));
        Err(ReadRemark::new(self.at, message, "look at the brackets of this line"))
    }

    /// Returns the letters from here on.
    fn word(&self) -> &'a str {
        let rest = self.rest();
        let end = rest.bytes().take_while(u8::is_ascii_alphabetic).count();
        rest.get(..end).unwrap_or_default()
    }

    /// Reads a plain number, if one stands here.
    #[inline]
    pub(super) fn plain(&mut self) -> Option<ExpressionValue> {
        self.blanks();
        let rest = self.text.as_bytes().get(self.at..)?;
        let found = number::signed(rest, DecimalMark::Point)?;
        self.at += found.length;
        let number::ScannedNumber { value: number, decimals, point, .. } = found;
        Some(ExpressionValue { number, decimals, point })
    }

    /// Reads a value: number, `[expression]`, `#parameter`, function, with signs.
    #[inline]
    pub(super) fn value(&mut self, env: &ExpressionEnv<'_>) -> Result<ExpressionValue, ReadRemark> {
        // Plain numbers are by far the most frequent values, and keep their digits.
        if let Some(plain) = self.plain() {
            return Ok(plain);
        }
        let number = self.computed(env)?;
        Ok(ExpressionValue { number, decimals: COMPUTED, point: true })
    }

    fn computed(&mut self, env: &ExpressionEnv<'_>) -> Result<f64, ReadRemark> {
        // Each bracket, sign, # and function is one call deeper: bounded, as the stack is.
        if self.depth >= DEEPEST {
            let message = format!("more than {DEEPEST} brackets in each other");
            return Err(ReadRemark::new(self.at, message, "take the expression apart"));
        }
        self.depth += 1;
        let value = self.term(env);
        self.depth -= 1;
        value
    }

    fn term(&mut self, env: &ExpressionEnv<'_>) -> Result<f64, ReadRemark> {
        self.blanks();
        let at = self.at;
        match self.peek() {
            Some(b'-') => {
                self.at += 1;
                Ok(-self.value(env)?.number)
            }
            Some(b'+') => {
                self.at += 1;
                Ok(self.value(env)?.number)
            }
            Some(b'[') => self.bracket(env),
            Some(b'#') => {
                let key = self.key(env)?;
                self.parameter(&key, at, env)
            }
            Some(byte) if byte.is_ascii_alphabetic() => self.function(env),
            _ => Err(ReadRemark::new(
                at,
                "a value is missing here",
                "write a number, #n or [expression]",
            )),
        }
    }

    /// Evaluates `[a + b * c]`.
    pub(super) fn bracket(&mut self, env: &ExpressionEnv<'_>) -> Result<f64, ReadRemark> {
        self.expect(b'[')?;
        let value = self.operations(1, env)?;
        self.expect(b']')?;
        Ok(value)
    }

    /// Evaluates `a + b * c`, which Fanuc allows behind = without brackets.
    pub(super) fn sum(&mut self, env: &ExpressionEnv<'_>) -> Result<f64, ReadRemark> {
        self.operations(1, env)
    }

    /// Evaluates operators from a level on.
    fn operations(&mut self, level: u8, env: &ExpressionEnv<'_>) -> Result<f64, ReadRemark> {
        if level > TIGHTEST {
            return Ok(self.value(env)?.number);
        }
        // Precedence climbing: operands are of the tighter levels, equal levels bind from the left.
        let mut left = self.operations(level + 1, env)?;
        loop {
            self.blanks();
            let at = self.at;
            let Some((length, operator)) = self.operator() else { return Ok(left) };
            if operator.level() != level {
                return Ok(left);
            }
            self.at += length;
            let right = self.operations(level + 1, env)?;
            left = operator.apply(left, right, at)?;
        }
    }

    fn operator(&self) -> Option<(usize, Operator)> {
        let rest = self.rest().as_bytes();
        let matches = |name: &str| {
            rest.get(..name.len()).is_some_and(|head| head.eq_ignore_ascii_case(name.as_bytes()))
        };
        let found = OPERATORS.iter().find(|(name, _)| matches(name));
        found.map(|&(name, operator)| (name.len(), operator))
    }

    /// Reads the parameter after `#`, which is at the cursor.
    pub(super) fn key(&mut self, env: &ExpressionEnv<'_>) -> Result<ParameterKey, ReadRemark> {
        let at = self.at;
        self.expect(b'#')?;
        self.blanks();
        // Names may contain anything but the closing bracket; blanks and case do not count.
        if self.peek() == Some(b'<') {
            let rest = self.text.get(self.at + 1..).unwrap_or_default();
            let Some(end) = rest.find('>') else {
                return Err(ReadRemark::new(at, "parameter name without a closing >", "close it"));
            };
            self.at += end + 2;
            return Ok(ParameterKey::Name(parameters::normal(rest.get(..end).unwrap_or_default())));
        }
        // ##2 is the parameter whose number stands in #2.
        let value =
            if self.peek() == Some(b'#') { self.computed(env)? } else { self.value(env)?.number };
        parameters::key_number(value, at)
    }

    fn parameter(
        &self,
        key: &ParameterKey,
        at: usize,
        env: &ExpressionEnv<'_>,
    ) -> Result<f64, ReadRemark> {
        env.parameters.get(key, &env.view).ok_or_else(|| {
            let text = self.text.get(at..self.at).unwrap_or_default().trim();
            let message = format!("{text} has no value");
            ReadRemark::new(at, message, "set it in the program, or give its value when reading")
        })
    }

    /// Evaluates `sin[30]`, `atan[1]/[2]`, `exists[#<name>]`.
    fn function(&mut self, env: &ExpressionEnv<'_>) -> Result<f64, ReadRemark> {
        let at = self.at;
        let name = self.word().to_ascii_uppercase();
        self.at += name.len();
        // EXISTS asks for the parameter itself, so its argument must not be evaluated.
        if name == "EXISTS" {
            self.expect(b'[')?;
            self.blanks();
            let key = self.key(env)?;
            self.expect(b']')?;
            let exists = env.parameters.get(&key, &env.view).is_some();
            return Ok(f64::from(exists));
        }
        let Some(function) = function(&name) else {
            let message = format!("{} is no function", super::super::log::excerpt(&name));
            let help = "known are ABS ACOS ASIN ATAN COS EXISTS EXP FIX FUP LN ROUND SIN SQRT TAN";
            return Err(ReadRemark::new(at, message, help));
        };
        let argument = self.bracket(env)?;
        self.blanks();
        // ATAN[y]/[x] keeps the quadrant; Fanuc also has ATAN[v] of one argument.
        if name == "ATAN" && !(env.fanuc && self.peek() != Some(b'/')) {
            self.expect(b'/')?;
            self.blanks();
            let below = self.bracket(env)?;
            return Ok(math::atan2(argument, below).to_degrees());
        }
        match name.as_str() {
            "ATAN" => return Ok(math::atan(argument).to_degrees()),
            // Towards zero and away from it; LinuxCNC goes down and up.
            "FIX" if env.fanuc => return Ok(argument.trunc()),
            "FUP" if env.fanuc => return Ok(argument.abs().ceil().copysign(argument)),
            _ => {}
        }
        finite(function(argument), at, || format!("{name}[{argument}]"))
    }
}

/// Returns a function of one argument by its name; angles are in degrees.
fn function(name: &str) -> Option<fn(f64) -> f64> {
    Some(match name {
        // ATAN has two arguments, and is made of them elsewhere.
        "ABS" | "ATAN" => f64::abs,
        "ACOS" => |x| math::acos(x).to_degrees(),
        "ASIN" => |x| math::asin(x).to_degrees(),
        "COS" => |x| math::cos(x.to_radians()),
        "EXP" => math::exp,
        "FIX" => f64::floor,
        "FUP" => f64::ceil,
        "LN" => math::ln,
        "ROUND" => f64::round,
        "SIN" => |x| math::sin(x.to_radians()),
        "SQRT" => f64::sqrt,
        "TAN" => |x| math::tan(x.to_radians()),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::Dialect;
    use crate::read::control::ControlState;
    use crate::read::gcode::reader::GcodeReader;
    use crate::read::samples::{control, options};

    /// Parameters with values, and a control.
    fn env(given: &[(&str, f64)]) -> (Parameters, ControlState) {
        let mut options = options(Dialect::LinuxCnc);
        let owned = |(name, value): &(&str, f64)| ((*name).to_owned(), *value);
        options.parameters = given.iter().map(owned).collect();
        (Parameters::new(&options), control())
    }

    fn value(text: &str) -> Result<f64, String> {
        let (parameters, control) = env(&[("7", 2.0), ("depth", -3.5), ("3", 7.0)]);
        let reader = GcodeReader::new(&options(Dialect::LinuxCnc));
        let view = reader.view(&control, 1);
        let env = ExpressionEnv { parameters: &parameters, view, fanuc: false };
        let mut scan = ExpressionScan::new(text, 0);
        let value = scan.value(&env).map_err(|remark| remark.message)?.number;
        scan.blanks();
        if scan.rest().is_empty() { Ok(value) } else { Err(format!("rest {}", scan.rest())) }
    }

    #[test]
    fn operators_bind_as_the_manual_says() {
        let cases = [
            ("[1 + 2 * 3]", 7.0),
            ("[2 ** 3 ** 2]", 64.0),
            ("[2 * 3 ** 2]", 18.0),
            ("[10 - 4 - 3]", 3.0),
            ("[7 mod 4]", 3.0),
            ("[-7 mod 4]", 1.0),
            ("[1 + 1 eq 2 and 3 gt 2]", 1.0),
            ("[1 xor 1 or 1]", 1.0),
            ("[5 ge 5] ", 1.0),
            ("-[3]", -3.0),
            ("- -3", 3.0),
            ("[#<DEPTH> * -1]", 3.5),
            ("#<de pth>", -3.5),
            ("fix[-2.5]", -3.0),
            ("fup[-2.5]", -2.0),
            ("round[-2.5]", -3.0),
            ("atan[1]/[-1]", 135.0),
            ("sqrt[abs[-16]]", 4.0),
            ("[exists[#<depth>] + exists[#<width>]]", 1.0),
        ];
        for (text, expected) in cases {
            let found = value(text).unwrap();
            assert!((found - expected).abs() < 1e-12, "{text} is {found}");
        }
    }

    #[test]
    fn fanuc_rounds_towards_zero_and_has_one_sided_arc_tangents() {
        let (parameters, control) = env(&[]);
        let reader = GcodeReader::new(&options(Dialect::Fanuc));
        let view = reader.view(&control, 1);
        let env = ExpressionEnv { parameters: &parameters, view, fanuc: true };
        let value = |text: &str| ExpressionScan::new(text, 0).value(&env).unwrap().number;
        for (text, expected) in
            [("FIX[-2.5]", -2.0), ("FUP[-2.5]", -3.0), ("ATAN[1]", 45.0), ("ATAN[1]/[-1]", 135.0)]
        {
            assert!((value(text) - expected).abs() < 1e-12, "{text}");
        }
    }

    #[test]
    fn what_has_no_value_says_so() {
        let cases = [
            ("[1/0]", "no finite value"),
            ("sqrt[-1]", "no finite value"),
            ("#<width>", "has no value"),
            ("[1", "missing"),
            ("sinh[1]", "no function"),
            ("[1 + ]", "missing"),
            ("#[0.5]", "no number of a parameter"),
        ];
        for (text, part) in cases {
            let error = value(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
        assert!(value(&"[".repeat(100_000)).unwrap_err().contains("brackets"));
        assert!(value(&"-".repeat(100_000)).unwrap_err().contains("brackets"));
        assert!(value(&"#".repeat(100_000)).unwrap_err().contains("brackets"));
    }
}
