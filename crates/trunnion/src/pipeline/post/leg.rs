//! A move on its way to places that the axes pass.

use crate::machine::FIRST_ROTARY;
use crate::nc::write::{BRIEFEST_BLOCK, Style};
use crate::types::{AxisVector, ToolPose};
use std::borrow::Cow;

/// A place the axes pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) q: AxisVector,
    pub(super) pose: ToolPose,
    /// A block ends here.
    pub(super) block: bool,
    /// The first of a retract.
    pub(super) goes_out: bool,
    /// Least time from the place before, by what is programmed; `None` for rapid \[s\].
    pub(super) least: Option<f64>,
    /// Way of the tip, and of both rotaries (the root of the sum of squares), from the place before \[mm, rad\].
    pub(super) tip: f64,
    pub(super) turn: f64,
    /// Part of the cut, where some of them are smoothed.
    pub(super) part: usize,
}

/// Blocks that are quicker than inverse time can say take as long as it can: what comes before and behind them
/// has to know.
pub(super) fn as_written<'a>(style: &Style, places: &'a [Place]) -> Cow<'a, [Place]> {
    let brief = |block: &[Place]| {
        let time = block.iter().map(|place| place.least.unwrap_or(f64::INFINITY)).sum::<f64>();
        (BRIEFEST_BLOCK - time).max(0.0)
    };
    if !style.inverse_time || places.chunk_by(same_block).all(|block| brief(block) <= 0.0) {
        return Cow::Borrowed(places);
    }
    let mut longer = places.to_vec();
    for block in longer.chunk_by_mut(same_block) {
        let more = brief(block);
        let size = |place: &Place| place.tip + place.turn;
        let whole: f64 = block.iter().map(size).sum();
        for place in block.iter_mut().filter(|_| more > 0.0 && whole > 0.0) {
            let by = more * size(place) / whole;
            place.least = place.least.map(|least| least + by);
        }
    }
    Cow::Owned(longer)
}

/// Whether the next place is on the way to the same block end.
fn same_block(place: &Place, _: &Place) -> bool {
    !place.block
}

/// Where the machine is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stop {
    pub(super) q: AxisVector,
    pub(super) pose: ToolPose,
    /// Axes of the machine the input is for.
    pub(super) source: AxisVector,
}

/// A move that becomes places.
pub(super) struct Leg<'a> {
    pub(super) line: u32,
    pub(super) rapid: bool,
    /// The target does just what the input does.
    pub(super) same: bool,
    pub(super) tolerance: [f64; 2],
    /// What the way to poses may have used up of the tolerance of the tip \[mm\].
    pub(super) bowed: f64,
    pub(super) per_length: f64,
    pub(super) per_share: f64,
    pub(super) out: &'a mut Vec<Place>,
}

impl Leg<'_> {
    pub(super) fn push(&mut self, from: &Stop, to: &Stop, (block, share): (bool, f64)) {
        let tip = (to.pose.tip - from.pose.tip).norm();
        let turn = (to.q - from.q).fixed_rows::<2>(FIRST_ROTARY).norm();
        let least = self.per_length * tip + self.per_share * share;
        self.out.push(Place {
            q: to.q,
            pose: to.pose,
            block,
            goes_out: false,
            least: (!self.rapid).then_some(least),
            tip,
            turn,
            part: 0,
        });
    }
}
