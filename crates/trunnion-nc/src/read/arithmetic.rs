//! Arithmetic and conditions as Sinumerik and Klartext write them: `R1 + 2*(3 - SIN(30))`, `R1 < 5 AND NOT R2 == 3`.

use super::log::{ReadRemark, excerpt};
use super::number::{self, DecimalMark};
use crate::math;
use std::collections::HashMap;

/// Deepest nesting of brackets.
const DEEPEST: u32 = 60;

/// Two values closer than this share of the larger, or of 1, are equal: a thousand sums of numbers such as 0.1 differ
/// by less.
const EQUAL: f64 = 1e-10;

/// An expression and where it stands.
pub(super) struct FormulaText<'a> {
    pub(super) text: &'a str,
    /// Offset in the text at which it begins.
    pub(super) from: usize,
    /// Byte offset of the text in its line.
    pub(super) at: usize,
    pub(super) mark: DecimalMark,
}

/// Evaluates an expression; a condition is 1 if it holds, else 0. `variables` have upper-case
/// names.
pub(super) fn value(
    written: &FormulaText<'_>,
    variables: &HashMap<Box<str>, f64>,
) -> Result<f64, ReadRemark> {
    let FormulaText { text, from, at: offset, mark } = *written;
    let mut scan = FormulaScan { text, at: from, offset, depth: 0, mark, variables };
    // Recursive descent, the loosest operator first: OR, AND, comparison, sum, product, factor.
    let value = scan.any()?;
    scan.blanks();
    if scan.at < text.len() {
        let message = format!("{} is not understood", excerpt(text));
        return Err(ReadRemark::new(offset, message, "+ - * / ( ) and functions like SIN are"));
    }
    Ok(value)
}

struct FormulaScan<'a> {
    text: &'a str,
    at: usize,
    /// Offset of the text in its line.
    offset: usize,
    depth: u32,
    mark: DecimalMark,
    variables: &'a HashMap<Box<str>, f64>,
}

impl FormulaScan<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
    }

    fn remark(&self, message: impl Into<String>, help: &str) -> ReadRemark {
        ReadRemark::new(self.offset + self.at, message, help)
    }

    fn finite(&self, value: f64) -> Result<f64, ReadRemark> {
        // A control stops with an alarm here, and no axis word can be infinite.
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.remark("this has no finite value", "look at what it is made of"))
    }

    /// Passes a word if it stands here.
    fn takes(&mut self, word: &str) -> bool {
        self.blanks();
        let rest = self.text.get(self.at..).unwrap_or_default();
        // A word ends with its letters and digits, so that OR is not found in ORIGIN.
        let length = rest.bytes().take_while(|b| b.is_ascii_alphanumeric() || *b == b'_').count();
        let found = rest.get(..length).is_some_and(|name| name.eq_ignore_ascii_case(word));
        self.at += if found { length } else { 0 };
        found
    }

    /// Evaluates `a OR b`.
    fn any(&mut self) -> Result<f64, ReadRemark> {
        let mut left = self.all()?;
        while self.takes("OR") {
            let right = self.all()?;
            left = f64::from(left.abs() > 0.0 || right.abs() > 0.0);
        }
        Ok(left)
    }

    /// Evaluates `a AND b`.
    fn all(&mut self) -> Result<f64, ReadRemark> {
        let mut left = self.comparison()?;
        while self.takes("AND") {
            let right = self.comparison()?;
            left = f64::from(left.abs() > 0.0 && right.abs() > 0.0);
        }
        Ok(left)
    }

    /// Evaluates `a < b`, `NOT a == b`.
    fn comparison(&mut self) -> Result<f64, ReadRemark> {
        // NOT binds looser than a comparison: NOT a == b denies the equality.
        let mut not = false;
        while self.takes("NOT") {
            not = !not;
        }
        let left = self.sum()?;
        self.blanks();
        let rest = self.text.get(self.at..).unwrap_or_default();
        let Some((sign, holds)) = COMPARISONS.iter().find(|(sign, _)| rest.starts_with(sign))
        else {
            return Ok(if not { f64::from(left.abs() <= 0.0) } else { left });
        };
        self.at += sign.len();
        let right = self.sum()?;
        // Values that differ by rounding only are equal, so that a loop up to 0.3 by 0.1 ends.
        let equal = (left - right).abs() <= EQUAL * left.abs().max(right.abs()).max(1.0);
        Ok(f64::from(not != holds(left - right, equal)))
    }

    fn sum(&mut self) -> Result<f64, ReadRemark> {
        let mut left = self.product()?;
        loop {
            self.blanks();
            let sign = match self.peek() {
                Some(b'+') => 1.0,
                Some(b'-') => -1.0,
                _ => return Ok(left),
            };
            self.at += 1;
            let right = self.product()?;
            left = self.finite(left + sign * right)?;
        }
    }

    fn product(&mut self) -> Result<f64, ReadRemark> {
        let mut left = self.factor()?;
        loop {
            // DIV is the quotient without its fraction, MOD the remainder with the sign of the
            // dividend.
            let [whole, rest] = [self.takes("DIV"), self.takes("MOD")];
            let sign = self.peek().filter(|byte| matches!(byte, b'*' | b'/'));
            if sign.is_none() && !whole && !rest {
                return Ok(left);
            }
            self.at += usize::from(sign.is_some());
            let right = self.factor()?;
            left = self.finite(match sign {
                Some(b'*') => left * right,
                Some(_) => left / right,
                None if whole => (left / right).trunc(),
                None => left % right,
            })?;
        }
    }

    fn factor(&mut self) -> Result<f64, ReadRemark> {
        // Each bracket, sign and function is one call deeper: bounded, so that no text overflows
        // the stack.
        if self.depth >= DEEPEST {
            let message = format!("more than {DEEPEST} brackets in each other");
            return Err(self.remark(message, "take the expression apart"));
        }
        self.depth += 1;
        let value = self.atom();
        self.depth -= 1;
        value
    }

    fn atom(&mut self) -> Result<f64, ReadRemark> {
        self.blanks();
        match self.peek() {
            Some(b'-') => {
                self.at += 1;
                Ok(-self.factor()?)
            }
            Some(b'+') => {
                self.at += 1;
                self.factor()
            }
            Some(b'(') => self.bracket(),
            Some(byte) if byte.is_ascii_alphabetic() || byte == b'_' => self.name(),
            Some(b'$') => {
                let help =
                    "what a control measures or stores is not in the program; write the value";
                Err(self.remark("a system variable", help))
            }
            _ => {
                let rest = self.text.get(self.at..).unwrap_or_default();
                let found = number::number(rest.as_bytes(), self.mark).ok_or_else(|| {
                    self.remark("a value is missing here", "write a number or a parameter")
                })?;
                self.at += found.length;
                Ok(found.value)
            }
        }
    }

    fn bracket(&mut self) -> Result<f64, ReadRemark> {
        self.at += 1;
        let value = self.any()?;
        self.blanks();
        if self.peek() != Some(b')') {
            return Err(self.remark(") is missing here", "close the bracket"));
        }
        self.at += 1;
        Ok(value)
    }

    /// Evaluates `ATAN2(y, x)` from behind its name.
    fn arc_tangent(&mut self) -> Result<f64, ReadRemark> {
        let mut arguments = [0.0; 2];
        // Both arguments are read alike: the first behind the bracket, the second behind the comma.
        for (place, mark) in arguments.iter_mut().zip([b'(', b',']) {
            self.blanks();
            if self.peek() != Some(mark) {
                return Err(self.remark("ATAN2 needs two values", "write ATAN2(y, x)"));
            }
            self.at += 1;
            *place = self.any()?;
        }
        self.blanks();
        if self.peek() != Some(b')') {
            return Err(self.remark(") is missing here", "close the bracket"));
        }
        self.at += 1;
        Ok(math::atan2(arguments[0], arguments[1]).to_degrees())
    }

    /// Evaluates `R1`, `SIN(30)`.
    fn name(&mut self) -> Result<f64, ReadRemark> {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let length = rest.bytes().take_while(|b| b.is_ascii_alphanumeric() || *b == b'_').count();
        let name = rest.get(..length).unwrap_or_default().to_ascii_uppercase();
        let start = self.at;
        self.at += length;
        self.blanks();
        // Functions take and return degrees; PI is the plain number.
        if name == "PI" {
            return Ok(std::f64::consts::PI);
        }
        if name == "ATAN2" {
            return self.arc_tangent();
        }
        if let Some(function) = function(&name) {
            // Klartext writes SIN 30, too.
            let argument = if self.peek() == Some(b'(') { self.bracket() } else { self.factor() };
            return self.finite(function(argument?));
        }
        self.variables.get(name.as_str()).copied().ok_or_else(|| {
            let message = format!("{} has no value", excerpt(&name));
            let help = "set it in the program, or give its value when reading";
            ReadRemark::new(self.offset + start, message, help)
        })
    }
}

/// By the difference of both sides, and whether they are equal.
type Comparison = fn(f64, bool) -> bool;

/// The longer sign first.
const COMPARISONS: [(&str, Comparison); 6] = [
    ("==", |_, equal| equal),
    ("<>", |_, equal| !equal),
    ("<=", |by, equal| by < 0.0 || equal),
    (">=", |by, equal| by > 0.0 || equal),
    ("<", |by, equal| by < 0.0 && !equal),
    (">", |by, equal| by > 0.0 && !equal),
];

/// Returns a function by its name; angles are in degrees.
fn function(name: &str) -> Option<fn(f64) -> f64> {
    Some(match name {
        "SIN" => |x| math::sin(x.to_radians()),
        "COS" => |x| math::cos(x.to_radians()),
        "TAN" => |x| math::tan(x.to_radians()),
        "ASIN" => |x| math::asin(x).to_degrees(),
        "ACOS" => |x| math::acos(x).to_degrees(),
        "SQRT" => f64::sqrt,
        "ABS" => f64::abs,
        "POT" | "SQ" => |x| x * x,
        "TRUNC" | "INT" => f64::trunc,
        "FRAC" => f64::fract,
        "NEG" => |x| -x,
        "ROUND" => f64::round,
        "LN" => math::ln,
        "EXP" => math::exp,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_bind_before_sums() {
        let variables = HashMap::from([("R1".into(), 2.0)]);
        let found = |text: &str| {
            // The comma of ATAN2 parts its arguments.
            let arguments = text.contains("ATAN2");
            let mark = if arguments { DecimalMark::Point } else { DecimalMark::PointOrComma };
            let written = FormulaText { text, from: 0, at: 0, mark };
            value(&written, &variables).map_err(|remark| remark.message)
        };
        let cases = [
            ("1+2*3", 7.0),
            ("-(1 - 4)/r1", 1.5),
            ("SIN(30)*2,5", 1.25),
            ("+R1 + +5", 7.0),
            ("8-2-1", 5.0),
            ("SIN 30 * 2", 1.0),
            ("7 MOD 4 + 9 DIV 2", 7.0),
            ("ATAN2(1, -1)", 135.0),
            ("0.1 + 0.2 == 0.3", 1.0),
            ("R1 < 2 OR NOT R1 <> 2", 1.0),
            ("(R1 >= 2) AND (R1 + 1 <= 2)", 0.0),
            ("NOT 1", 0.0),
        ];
        for (text, expected) in cases {
            assert!((found(text).unwrap() - expected).abs() < 1e-12, "{text}");
        }
        for (text, part) in
            [("1/0", "finite"), ("R2", "no value"), ("(1", "missing"), ("1)", "not understood")]
        {
            assert!(found(text).unwrap_err().contains(part), "{text}");
        }
        assert!(found(&"(".repeat(9999)).unwrap_err().contains("brackets"));
        assert!(found(&"-".repeat(9999)).unwrap_err().contains("brackets"));
    }
}
