//! Points on the way of the axes, and the move they divide.

use super::constants::SMALLEST_LENGTH;
use crate::blocks::BlockEnd;
use crate::machine::FIRST_ROTARY;
use crate::types::{AxisVector, ToolPose};

/// Axis position with the tool pose it produces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxesPose {
    pub(super) q: AxisVector,
    pub(super) pose: ToolPose,
}

impl AxesPose {
    /// Borrows both parts as an end of a block.
    pub(super) fn block_end(&self) -> BlockEnd<'_> {
        BlockEnd::new(&self.q, &self.pose)
    }
}

/// Words that positions come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PositionSource {
    /// Positions are exact, as those of cutter locations.
    Exact,
    /// Positions come from rounded words of the tip.
    Tip,
    /// Positions come from rounded words of the axes.
    Axes,
}

/// Point that the axes pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisPoint {
    /// Line of the input.
    pub(super) line: u32,
    pub(super) q: AxisVector,
    pub(super) pose: ToolPose,
    /// True if a block ends here.
    pub(super) block: bool,
    /// True for the first point of a retract.
    pub(super) goes_out: bool,
    /// True for the points of a retract, which is no motion of the input.
    pub(super) is_added: bool,
    /// Least time from the point before, as programmed; `None` for rapid \[s\].
    pub(super) least: Option<f64>,
    /// Time from the point before as programmed, whatever the axes can do; `None` for rapid, and without a feed \[s\].
    pub(super) programmed: Option<f64>,
    /// Words that the positions come from.
    pub(super) source: PositionSource,
    /// Travel of the tip from the point before \[mm\].
    pub(super) tip: f64,
    /// Travel of both rotaries from the point before, root of the sum of squares \[rad\].
    pub(super) turn: f64,
    /// Travel of tip and rotaries between the rounded words, as far as F refers to them \[mm, rad\].
    pub(super) written: [f64; 2],
    /// Programmed time per travel of the tip \[s/mm\]; 0 where the input gives a time.
    pub(super) per_way: f64,
    /// Part of the cut, where some parts are smoothed.
    pub(super) part: usize,
    /// Error of X, Y and Z by the rounding of tip words, at the end of a block that has them \[mm\].
    pub(super) linear_error: f64,
    /// Travel from the point before as if each axis kept its largest velocity between them, once it is known.
    pub(super) fastest: Option<AxisVector>,
}

impl AxisPoint {
    /// Returns the axes with their pose.
    pub(super) fn end(&self) -> AxesPose {
        AxesPose { q: self.q, pose: self.pose }
    }

    /// Returns the travel by which a block's time is shared out.
    ///
    /// The tip keeps its speed inside a block; where it stands still, both rotaries together do.
    pub(super) fn size(&self) -> f64 {
        if self.tip > SMALLEST_LENGTH { self.tip } else { self.turn }
    }
}

/// Position of the machine between two moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct MachinePoint {
    pub(super) q: AxisVector,
    pub(super) pose: ToolPose,
    /// Axes of the machine that the input is for.
    pub(super) source: AxisVector,
}

/// End of a part of a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PartEnd {
    /// A block of the program ends.
    Block,
    /// The block goes on.
    Inside,
}

/// Move that is divided into axis points.
pub(super) struct DividedMove<'a> {
    pub(super) line: u32,
    pub(super) rapid: bool,
    /// True if the target control does exactly what the input does.
    pub(super) same: bool,
    /// True for moves of a retract.
    pub(super) is_added: bool,
    pub(super) tolerance: [f64; 2],
    /// Tip tolerance that the way to the poses may have used up \[mm\].
    pub(super) bowed: f64,
    pub(super) per_length: f64,
    pub(super) per_share: f64,
    pub(super) per_way: f64,
    /// Words that the positions come from.
    pub(super) source: PositionSource,
    pub(super) out: &'a mut Vec<AxisPoint>,
}

impl DividedMove<'_> {
    /// Appends the point `to`, which ends a part with this share of the move.
    pub(super) fn push(
        &mut self,
        from: &MachinePoint,
        to: &MachinePoint,
        end: PartEnd,
        share: f64,
    ) {
        let tip = (to.pose.tip - from.pose.tip).norm();
        let turn = (to.q - from.q).fixed_rows::<2>(FIRST_ROTARY).norm();
        let least = self.per_length * tip + self.per_share * share;
        let programmed = (least > 0.0 && !self.rapid).then_some(least);
        self.out.push(AxisPoint {
            line: self.line,
            q: to.q,
            pose: to.pose,
            block: end == PartEnd::Block,
            goes_out: false,
            is_added: self.is_added,
            least: (!self.rapid).then_some(least),
            programmed,
            source: self.source,
            tip,
            turn,
            written: [tip, turn],
            per_way: self.per_way,
            part: 0,
            linear_error: 0.0,
            fastest: None,
        });
    }
}
