//! Numbers of a page.

use trunnion_report::{Number, State};

/// A number that nothing is asked of.
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

/// A number that is good or bad; `headline`: it stands large at the top of the page.
pub(crate) fn judged(good: bool, number: Number, headline: bool) -> Number {
    Number { state: if good { State::Good } else { State::Bad }, headline, ..number }
}
