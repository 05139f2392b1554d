//! Arithmetic as Sinumerik and Klartext write it: `R1 + 2*(3 - SIN(30))`.

use super::log::{Remark, excerpt};
use super::number;
use std::collections::HashMap;

/// Brackets in brackets.
const DEEPEST: u32 = 60;

/// An expression and where it stands.
pub(super) struct Written<'a> {
    pub(super) text: &'a str,
    /// Where in the text it begins.
    pub(super) from: usize,
    /// Byte offset of the text in its line.
    pub(super) at: usize,
    /// Decimal commas are allowed.
    pub(super) comma: bool,
}

/// Its value; `variables` have upper-case names.
pub(super) fn value(
    written: &Written<'_>,
    variables: &HashMap<Box<str>, f64>,
) -> Result<f64, Remark> {
    let Written { text, from, at: offset, comma } = *written;
    let mut scan = Scan { text, at: from, offset, depth: 0, comma, variables };
    let value = scan.sum()?;
    scan.blanks();
    if scan.at < text.len() {
        let message = format!("{} is not understood", excerpt(text));
        return Err(Remark::new(offset, message, "+ - * / ( ) and functions like SIN are"));
    }
    Ok(value)
}

struct Scan<'a> {
    text: &'a str,
    at: usize,
    /// Where the text stands in its line.
    offset: usize,
    depth: u32,
    comma: bool,
    variables: &'a HashMap<Box<str>, f64>,
}

impl Scan<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
    }

    fn remark(&self, message: impl Into<String>, help: &str) -> Remark {
        Remark::new(self.offset + self.at, message, help)
    }

    fn finite(&self, value: f64) -> Result<f64, Remark> {
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.remark("this has no finite value", "look at what it is made of"))
    }

    fn sum(&mut self) -> Result<f64, Remark> {
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

    fn product(&mut self) -> Result<f64, Remark> {
        let mut left = self.factor()?;
        loop {
            self.blanks();
            let times = match self.peek() {
                Some(b'*') => true,
                Some(b'/') => false,
                _ => return Ok(left),
            };
            self.at += 1;
            let right = self.factor()?;
            left = self.finite(if times { left * right } else { left / right })?;
        }
    }

    fn factor(&mut self) -> Result<f64, Remark> {
        if self.depth >= DEEPEST {
            let message = format!("more than {DEEPEST} brackets in each other");
            return Err(self.remark(message, "take the expression apart"));
        }
        self.depth += 1;
        let value = self.atom();
        self.depth -= 1;
        value
    }

    fn atom(&mut self) -> Result<f64, Remark> {
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
            Some(byte) if byte.is_ascii_alphabetic() => self.name(),
            _ => {
                let rest = self.text.get(self.at..).unwrap_or_default();
                let found = number::number(rest, self.comma).ok_or_else(|| {
                    self.remark("a value is missing here", "write a number or a parameter")
                })?;
                self.at += found.length;
                Ok(found.value)
            }
        }
    }

    fn bracket(&mut self) -> Result<f64, Remark> {
        self.at += 1;
        let value = self.sum()?;
        self.blanks();
        if self.peek() != Some(b')') {
            return Err(self.remark(") is missing here", "close the bracket"));
        }
        self.at += 1;
        Ok(value)
    }

    /// `R1`, `SIN(30)`.
    fn name(&mut self) -> Result<f64, Remark> {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let length = rest.bytes().take_while(|b| b.is_ascii_alphanumeric() || *b == b'_').count();
        let name = rest.get(..length).unwrap_or_default().to_ascii_uppercase();
        let start = self.at;
        self.at += length;
        self.blanks();
        if self.peek() == Some(b'(')
            && let Some(function) = function(&name)
        {
            let argument = self.bracket()?;
            return self.finite(function(argument));
        }
        self.variables.get(name.as_str()).copied().ok_or_else(|| {
            let message = format!("{} has no value", excerpt(&name));
            let help = "set it in the program, or give its value when reading";
            Remark::new(self.offset + start, message, help)
        })
    }
}

/// Functions; angles in degrees.
fn function(name: &str) -> Option<fn(f64) -> f64> {
    Some(match name {
        "SIN" => |x| x.to_radians().sin(),
        "COS" => |x| x.to_radians().cos(),
        "TAN" => |x| x.to_radians().tan(),
        "ASIN" => |x| x.asin().to_degrees(),
        "ACOS" => |x| x.acos().to_degrees(),
        "SQRT" => f64::sqrt,
        "ABS" => f64::abs,
        "POT" => |x| x * x,
        "TRUNC" => f64::trunc,
        "ROUND" => f64::round,
        "LN" => f64::ln,
        "EXP" => f64::exp,
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
            let written = Written { text, from: 0, at: 0, comma: true };
            value(&written, &variables).map_err(|remark| remark.message)
        };
        let cases = [
            ("1+2*3", 7.0),
            ("-(1 - 4)/r1", 1.5),
            ("SIN(30)*2,5", 1.25),
            ("+R1 + +5", 7.0),
            ("8-2-1", 5.0),
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
