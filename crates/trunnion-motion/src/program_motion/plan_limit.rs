//! Limits that keep a plan from being faster.

use crate::feed::Limits;
use crate::types::{AXES, AxisNode, AxisVector, PathState};

/// Share of a limit from which it counts as what limits the speed.
const BINDS: f64 = 0.9;

/// Limit that keeps the plan from being faster. Axes are in the order of joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlanLimit {
    /// None is near: the tool rests, or passes from one to another.
    None,
    /// Programmed feed.
    Feed,
    /// Speed of a rapid move.
    Rapid,
    /// Velocity of an axis.
    Velocity(usize),
    /// Acceleration of an axis.
    Acceleration(usize),
    /// Jerk of an axis.
    Jerk(usize),
}

impl PlanLimit {
    /// Returns its number: 0 none, 1 feed, 2 rapid, 10, 20 or 30 and the axis for velocity, acceleration and jerk.
    pub fn number(self) -> u32 {
        let (kind, axis) = match self {
            Self::None => (0, 0),
            Self::Feed => (1, 0),
            Self::Rapid => (2, 0),
            Self::Velocity(axis) => (10, axis),
            Self::Acceleration(axis) => (20, axis),
            Self::Jerk(axis) => (30, axis),
        };
        kind + u32::try_from(axis).unwrap_or_default()
    }
}

/// Returns the limit that a motion is nearest to, at a node of the path. `programmed` are the seconds per length of a feed and of a
/// rapid move.
pub(super) fn nearest(
    node: &AxisNode,
    state: &PathState,
    limits: &Limits<AXES>,
    programmed: [f64; 2],
) -> PlanLimit {
    let [_, rate, bend, change] = node.q;
    let (v, a, j) = (state.speed, state.acceleration, state.jerk);
    let jerk = rate * j + bend * (3.0 * v * a) + change * v.powi(3);
    let orders = [
        (rate * v).component_div(&limits.velocity),
        (rate * a + bend * (v * v)).component_div(&limits.acceleration),
        limits.jerk.map_or_else(AxisVector::zeros, |limit| jerk.component_div(&limit)),
    ];
    let of_axis = |axis: usize| orders.map(|order| order[axis].abs());
    let axes = (0..AXES).flat_map(|axis| {
        let kinds = [PlanLimit::Velocity, PlanLimit::Acceleration, PlanLimit::Jerk];
        of_axis(axis).into_iter().zip(kinds).map(move |(share, kind)| (share, kind(axis)))
    });
    let [feed, rapid] = programmed;
    let speeds = [(feed * v, PlanLimit::Feed), (rapid * v, PlanLimit::Rapid)];
    let nearest = axes.chain(speeds).max_by(|one, other| one.0.total_cmp(&other.0));
    nearest.filter(|(share, _)| *share >= BINDS).map_or(PlanLimit::None, |(_, limit)| limit)
}
