//! Units of feeds, and where a value begins.

use crate::read::state::ReaderState;

/// Returns the unit of F in mm or inches a minute: tenths of an inch in INCH programs.
pub(super) fn feed_unit(state: &ReaderState) -> f64 {
    if state.control.inch { 0.1 } else { 1.0 }
}

/// Returns the byte at which the value behind a name begins: `V.ZEIT0.5`, `DEPTH -20`, `DWELL Q5`.
pub(super) fn value_begins(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    (0..bytes.len()).find(|at| {
        let behind = bytes.get(at + 1).copied().unwrap_or(0).to_ascii_uppercase();
        let starts_name = at
            .checked_sub(1)
            .is_none_or(|before| bytes.get(before).is_some_and(|byte| !byte.is_ascii_alphabetic()));
        match bytes.get(*at) {
            Some(b'0'..=b'9' | b'+' | b'-') => true,
            // A point may be that of an abbreviation.
            Some(b'.') => behind.is_ascii_digit(),
            Some(b'Q' | b'q') => {
                behind.is_ascii_digit() || starts_name && matches!(behind, b'L' | b'R')
            }
            _ => false,
        }
    })
}
