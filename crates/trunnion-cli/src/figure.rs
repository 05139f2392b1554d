//! Numbers of a page.

use trunnion_report::{Number, State};

/// Place of a number on the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Prominence {
    /// Large, at the top of the page.
    Headline,
    /// In the table below.
    Body,
}

/// Returns a number without a limit.
pub(crate) fn plain(label: &str, value: String, unit: &str, note: String) -> Number {
    Number {
        label: label.to_owned(),
        value,
        unit: unit.to_owned(),
        note,
        state: State::Plain,
        headline: false,
    }
}

/// Returns a number that is good or bad.
pub(crate) fn judged(state: State, number: Number, prominence: Prominence) -> Number {
    Number { state, headline: prominence == Prominence::Headline, ..number }
}

/// Judges a value by its upper limit; a value that is not a number is bad.
pub(crate) fn within(value: f64, limit: f64) -> State {
    if value <= limit { State::Good } else { State::Bad }
}

/// Judges a count of which every one is a defect.
pub(crate) fn none(count: usize) -> State {
    if count == 0 { State::Good } else { State::Bad }
}
