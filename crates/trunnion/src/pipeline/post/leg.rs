//! A move on its way to places that the axes pass.

use super::pace::LEAST;
use crate::machine::FIRST_ROTARY;
use crate::types::{AxisVector, ToolPose};

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
    /// The same between the words, as far as F is of them.
    pub(super) written: [f64; 2],
    /// Programmed time by the way of the tip \[s/mm\]; 0 where the input says a time.
    pub(super) per_way: f64,
    /// Part of the cut, where some of them are smoothed.
    pub(super) part: usize,
}

impl Place {
    /// What the time of a block goes by: the tip keeps its speed inside a block; where it stands, both rotaries together do.
    pub(super) fn size(&self) -> f64 {
        if self.tip > LEAST { self.tip } else { self.turn }
    }
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
    pub(super) per_way: f64,
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
            written: [tip, turn],
            per_way: self.per_way,
            part: 0,
        });
    }
}
