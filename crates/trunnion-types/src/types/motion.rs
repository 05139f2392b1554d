//! The machine's side of a path: axes, schedule, blocks, setpoints.

use super::path::{Motion, ToolPose};
use super::{AXES, AxisVector};
use nalgebra::SVector;

/// `N` axes at one point of a path, with derivatives by the path parameter `s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisNode<const N: usize = AXES> {
    /// Path parameter; increasing along a piece \[mm, or whatever the path is given in\].
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

/// Motion of the machine's axes; the machine rests where two pieces meet.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AxisPath<const N: usize = AXES> {
    /// Pieces in the order they are run.
    pub pieces: Vec<AxisPiece<N>>,
}

/// How speed runs between two rows of a [`SchedulePiece`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Law {
    /// `d²s/dt²` is constant from each row to the next, and steps at rows.
    #[default]
    Steps,
    /// `d²s/dt²` is continuous: linear in `s` between rows, and jerk is constant in time between a
    /// row at rest (no speed, no acceleration) and its neighbour, where `s` goes with `t³`.
    Ramps,
}

/// When the nodes of one [`AxisPiece`] are passed. All vectors have one entry per row; rows are the
/// nodes, and any the planner inserted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SchedulePiece {
    /// Path parameter of each row.
    pub s: Vec<f64>,
    /// Time since the start of the schedule \[s\].
    pub t: Vec<f64>,
    /// `ds/dt` at each row.
    pub speed: Vec<f64>,
    /// `d²s/dt²`: from this row to the next under [`Law::Steps`] (the last entry repeats), at the row
    /// under [`Law::Ramps`].
    pub acceleration: Vec<f64>,
    /// How speed runs between rows.
    pub law: Law,
}

/// A speed schedule for an axis path, piece by piece.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Schedule {
    /// One per piece of the axis path.
    pub pieces: Vec<SchedulePiece>,
}

impl Schedule {
    /// Time at the end of the last piece \[s\].
    pub fn duration(&self) -> f64 {
        self.pieces.last().and_then(|piece| piece.t.last()).copied().unwrap_or(0.0)
    }
}

/// One program block: a move from the block before to here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Kind of motion.
    pub motion: Motion,
    /// Axes at the end of the block.
    pub q: AxisVector,
    /// The same as a pose in the workpiece frame.
    pub pose: ToolPose,
    /// Time the block takes \[s\]; 0 for the starting position.
    pub duration: f64,
}

/// `N` axes at one servo tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoint<const N: usize = AXES> {
    /// Time \[s\].
    pub t: f64,
    /// Positions \[mm, rad\].
    pub position: SVector<f64, N>,
    /// Velocities \[mm/s, rad/s\].
    pub velocity: SVector<f64, N>,
    /// Accelerations \[mm/s², rad/s²\].
    pub acceleration: SVector<f64, N>,
    /// Jerks \[mm/s³, rad/s³\]; where the acceleration steps, without the step.
    pub jerk: SVector<f64, N>,
}
