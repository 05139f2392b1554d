//! Values of words, and their modes: `AC(..)` and its kin.

use crate::read::log::ReadRemark;

/// Mode of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ValueMode {
    /// Absolute or incremental, by the `G90` or `G91` that is active.
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
pub(super) struct SiemensValue {
    pub(super) number: f64,
    pub(super) decimals: u8,
}

pub(super) const MODES: [(&str, ValueMode); 5] = [
    ("ACP", ValueMode::Positive),
    ("ACN", ValueMode::Negative),
    ("AC", ValueMode::Absolute),
    ("IC", ValueMode::Incremental),
    ("DC", ValueMode::Shortest),
];

/// Returns a value as a count.
pub(super) fn natural(value: f64, at: usize) -> Result<u32, ReadRemark> {
    // Counts are reckoned with, too.
    if (value - value.round()).abs() > 1e-6 || !(0.0..=f64::from(u32::MAX)).contains(&value.round())
    {
        return Err(ReadRemark::new(at, format!("{value} must be a whole number from 0"), ""));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    let whole = value.round() as u32;
    Ok(whole)
}
