//! Speeds at the ends of a piece.

use super::error::FeedError;
use super::options::FeedOptions;
use super::profile::Profile;

/// Squared speeds at the ends of a piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends {
    pub(super) start: f64,
    pub(super) end: f64,
}

impl Ends {
    /// Those of piece `index` of `count`: inner ones rest.
    pub(super) fn of(index: usize, count: usize, options: &FeedOptions) -> Self {
        let [start, end] = options.ends;
        let at = |here: bool, speed: f64| if here { speed * speed } else { 0.0 };
        Self { start: at(index == 0, start), end: at(index + 1 == count, end) }
    }

    /// Whether a profile has the speeds asked for; it has lower ones where those are impossible.
    pub(super) fn reached(&self, profile: &Profile) -> Result<(), FeedError> {
        // Half of a speed's digits: passes lose a few roundings a row.
        let short = |wanted: f64, got: f64| got < wanted * (1.0 - f64::EPSILON.sqrt());
        let [first, last] = [profile.x.first(), profile.x.last()].map(|x| x.map_or(0.0, |x| *x));
        if short(self.start, first) {
            return Err(FeedError::StartTooFast { speed: self.start.sqrt(), most: first.sqrt() });
        }
        if short(self.end, last) {
            return Err(FeedError::EndTooFast { speed: self.end.sqrt(), most: last.sqrt() });
        }
        Ok(())
    }
}
