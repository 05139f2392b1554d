//! Values: numbers, `R` parameters, arithmetic, `AC(..)` and its kin.

use super::super::arithmetic::{self, Written};
use super::super::control::COMPUTED;
use super::super::log::Remark;
use super::super::number;
use super::Siemens;
use super::word::{Behind, Item};

/// How a word counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// As `G90` or `G91` says.
    Plain,
    /// `AC`.
    Absolute,
    /// `IC`.
    Incremental,
    /// `DC`.
    Shortest,
    /// `ACP`.
    Positive,
    /// `ACN`.
    Negative,
}

/// A value and its digits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Value {
    pub(super) number: f64,
    pub(super) decimals: u8,
}

const MODES: [(&str, Mode); 5] = [
    ("ACP", Mode::Positive),
    ("ACN", Mode::Negative),
    ("AC", Mode::Absolute),
    ("IC", Mode::Incremental),
    ("DC", Mode::Shortest),
];

/// A whole number.
pub(super) fn natural(value: f64, at: usize) -> Result<u32, Remark> {
    // Counts are reckoned with, too.
    if (value - value.round()).abs() > 1e-6 || !(0.0..=f64::from(u32::MAX)).contains(&value.round())
    {
        return Err(Remark::new(at, format!("{value} must be a whole number from 0"), ""));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    let whole = value.round() as u32;
    Ok(whole)
}

impl Siemens {
    /// The value of a word, and how it counts.
    pub(super) fn value(&self, item: &Item<'_>) -> Result<(Value, Mode), Remark> {
        let (Behind::Number(text) | Behind::Assigned(text)) = item.behind else {
            let message = format!("{} without a value", item.text_name());
            return Err(Remark::new(item.at, message, "write it behind ="));
        };
        if let Some(found) = number::signed(text, false)
            && found.length == text.trim_end().len()
        {
            return Ok((Value { number: found.value, decimals: found.decimals }, Mode::Plain));
        }
        let mode = MODES.iter().find(|(name, _)| {
            let head = text.get(..name.len()).unwrap_or_default();
            let rest = text.get(name.len()..).unwrap_or_default();
            head.eq_ignore_ascii_case(name) && rest.trim_start().starts_with('(')
        });
        let skip = mode.map_or(0, |(name, _)| name.len());
        let written = Written { text, from: skip, at: item.value_at, comma: false };
        let number = arithmetic::value(&written, &self.variables)?;
        // The digits in the brackets of AC(..) are those of the word.
        let inner = text.get(skip..).unwrap_or_default().trim();
        let inner = inner.strip_prefix('(').and_then(|inner| inner.strip_suffix(')'));
        let plain = inner.and_then(|inner| {
            let inner = inner.trim();
            number::signed(inner, false).filter(|found| found.length == inner.len())
        });
        let decimals = plain.map_or(COMPUTED, |found| found.decimals);
        Ok((Value { number, decimals }, mode.map_or(Mode::Plain, |(_, mode)| *mode)))
    }
}
