//! The machine's side of a path: axes along it, program blocks, setpoints.

use super::tool_path::{Motion, ToolPose};
use crate::math::quintic::Quintic;
use nalgebra::SVector;

/// Number of machine axes: three linear and two rotary.
pub const AXES: usize = 5;

/// Axis coordinates in the order X, Y, Z, then the rotaries in chain order \[mm, mm, mm, rad, rad\].
///
/// Rotary entries are *unwound*: 370° stays 370°, so that differences are travel.
pub type AxisVector = SVector<f64, AXES>;

/// Rounding of an axis position \[mm or rad\]; travel exceeded by less is inside.
///
/// Positions are sums of a few numbers below 1e6, each rounded by 2^-53 of it.
pub const TRAVEL_ROUNDING: f64 = 1e-9;

/// Positions of `N` axes at one point of a path, with derivatives by the path parameter `s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisNode<const N: usize = AXES> {
    /// Path parameter; increasing along a piece \[mm, or the unit that the path is given in\].
    pub s: f64,
    /// `q`, `q'`, `q''`, `q'''` by `s` \[axis unit per s^k\].
    pub q: [SVector<f64, N>; 4],
    /// Speed of the tool tip in the workpiece frame per unit of `s` \[mm\].
    pub tip_rate: f64,
    /// Speed of the programmed point (tip or contact) per unit of `s` \[mm\]; the feed refers to it.
    pub feed_rate: f64,
}

/// A smooth piece: between nodes the path is the quintic through `q`, `q'` and `q''` of both ends.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisPiece<const N: usize = AXES> {
    /// Kind of motion.
    pub motion: Motion,
    /// Index of the tool-path piece it was made from.
    pub source: usize,
    /// Nodes in order of `s`, at least two.
    pub nodes: Vec<AxisNode<N>>,
}

impl<const N: usize> AxisPiece<N> {
    /// Returns the index of the interval between nodes that holds `s`; ends are clamped.
    pub fn interval_at(&self, s: f64) -> usize {
        let after = self.nodes.partition_point(|node| node.s <= s);
        after.saturating_sub(1).min(self.nodes.len().saturating_sub(2))
    }

    /// Returns the quintic from node `interval` to the next, in `s` from that node, and the node's `s`;
    /// `None` if there is no such interval.
    pub fn quintic(&self, interval: usize) -> Option<(f64, Quintic<N>)> {
        let [from, to] = [self.nodes.get(interval)?, self.nodes.get(interval + 1)?];
        let jet = |q: &[SVector<f64, N>; 4]| [q[0], q[1], q[2]];
        Some((from.s, Quintic::new(to.s - from.s, jet(&from.q), jet(&to.q))))
    }

    /// Returns the axes and their first three derivatives by `s`, clamped to the piece; exact at nodes.
    /// `None` for a piece of less than two nodes.
    pub fn axes_at(&self, s: f64) -> Option<[SVector<f64, N>; 4]> {
        let interval = self.interval_at(s);
        let (start, quintic) = self.quintic(interval)?;
        let end = self.nodes.get(interval + 1)?;
        // At its last node the quintic is only right to rounding: the node itself is exact.
        Some(if s < end.s { quintic.at((s - start).max(0.0)) } else { end.q })
    }

    /// Returns the axes at `s`, clamped to the piece; exact at nodes. `None` for a piece of less than two nodes.
    pub fn position_at(&self, s: f64) -> Option<SVector<f64, N>> {
        let interval = self.interval_at(s);
        let (start, quintic) = self.quintic(interval)?;
        let end = self.nodes.get(interval + 1)?;
        Some(if s < end.s { quintic.value((s - start).max(0.0)) } else { end.q[0] })
    }
}

/// Motion of the machine's axes; the machine rests where two pieces meet.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AxisPath<const N: usize = AXES> {
    /// Pieces in the order they are run.
    pub pieces: Vec<AxisPiece<N>>,
}

/// One program block: a move from the block before to here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Kind of motion.
    pub motion: Motion,
    /// Axes at the end of the block.
    pub q: AxisVector,
    /// Pose of the tool at the end, in the workpiece frame.
    pub pose: ToolPose,
    /// Time the block takes \[s\]; 0 for the starting position.
    pub duration: f64,
}
