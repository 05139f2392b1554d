//! Moves of the input, as programmed: their times and the load on the axes.

use super::tally::FeedTally;
use crate::machine::Kinematics;
use crate::nc::write::Style;
use crate::post::axis_point::{AxesPose, PositionSource};
use crate::post::options::PostPace;
use crate::post::timing::{position_error, word_travel};

/// Move of the input, or a standstill behind its moves.
#[derive(Debug, Clone, Copy)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all items are moves, and a hot path allocates nothing"
)]
pub(super) enum ReadItem {
    /// Move with its programmed speed.
    Move(ReadMove),
    /// The axes come to rest.
    Rest,
    /// The axes and the control come to rest.
    Stop,
    /// The control comes to rest.
    StopClock,
}

/// Move of the input on the machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReadMove {
    pub(super) from: AxesPose,
    pub(super) to: AxesPose,
    pub(super) asked: PostPace,
    pub(super) source: PositionSource,
    /// Error of X, Y and Z at its end by the rounding of tip words, where it has them \[mm\].
    pub(super) linear_error: f64,
}

impl ReadItem {
    /// Adds it to the tally of the input.
    pub(super) fn count(&self, tally: &mut FeedTally, kinematics: &Kinematics, style: &Style) {
        match self {
            Self::Move(one) => one.count(tally, kinematics, style),
            Self::Rest => tally.rest(),
            Self::Stop => tally.stop(),
            Self::StopClock => tally.stop_clock(),
        }
    }
}

impl ReadMove {
    fn count(&self, tally: &mut FeedTally, kinematics: &Kinematics, style: &Style) {
        let Self { from, to, asked, source, linear_error } = self;
        let words = word_travel(kinematics, style.dialect, from, to);
        let programmed = match asked {
            PostPace::Rapid => return tally.rapid(&words),
            PostPace::Feed(feed) => (to.pose.tip - from.pose.tip).norm() / feed,
            PostPace::Seconds(seconds) => *seconds,
        };
        let travel = to.q - from.q;
        // Without a programmed time the axes run as fast as they can.
        let seconds = if programmed > 0.0 { programmed } else { tally.load.least(&travel) };
        let error = position_error(&style.axes, *source, *linear_error);
        tally.block(&travel, &error, seconds);
        tally.feed(&words, seconds);
    }
}
