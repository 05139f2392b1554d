//! Feed words: inverse times, and speeds of the tip or of the rotaries.

use super::number::FixedNumber;

/// Largest inverse-time word; a quicker block is written with it, and takes longer.
const LARGEST_FEED: f64 = 99_999.999;

/// Time of the quickest block that inverse time can express \[s\].
pub const BRIEFEST_BLOCK: f64 = 60.0 / LARGEST_FEED;

/// Decimals of feed words.
const FEED_DECIMALS: u8 = 3;

/// Decimals of inverse-time words below 1, of blocks longer than a minute: three would be too coarse.
const SLOW_DECIMALS: u8 = 6;

/// Share of a planned travel by which rounded words may differ before F counts along the words. Within it F stays
/// as planned, so that it can be left out of the blocks that follow.
const ROUNDED: f64 = 0.01;

/// Travel along which a control counts F.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FeedTravel {
    /// As planned \[mm or degrees\].
    pub(super) planned: f64,
    /// Between the words that are written \[mm or degrees\].
    pub(super) written: f64,
}

impl FeedTravel {
    /// Returns the travel that F is reckoned from.
    fn counted(self) -> f64 {
        let Self { planned, written } = self;
        if written > 0.0 && (written - planned).abs() > ROUNDED * planned {
            written
        } else {
            planned
        }
    }
}

/// Returns the word of a block in inverse time; `None` for a time that has none.
pub(super) fn inverse_time(seconds: f64) -> Option<FixedNumber> {
    // F = 60 / t. Below 1 three decimals would be a coarse time, so there are six.
    let value = (60.0 / seconds).min(LARGEST_FEED);
    let decimals = if value < 1.0 { SLOW_DECIMALS } else { FEED_DECIMALS };
    // The quotient itself was rounded, maybe up.
    let feed = FixedNumber::down(value, decimals)?.lowered_to(|value| 60.0 / value >= seconds);
    (!feed.is_zero()).then_some(feed)
}

/// Returns the word of a speed per minute, rounded down: not faster than planned, or by less than a last digit.
///
/// A block that would stand nearly still has the last digit alone, and ends sooner than planned.
pub(super) fn per_minute(travel: FeedTravel, seconds: f64) -> Option<FixedNumber> {
    let feed = FixedNumber::down(60.0 * travel.counted() / seconds, FEED_DECIMALS)?;
    if feed.is_zero() {
        return Some(FixedNumber::last_digit(FEED_DECIMALS));
    }
    // A feed that is kept all the way is to be written as it was: its time is a sum of some thousand rounded ones.
    Some(feed.up_to_whole())
}
