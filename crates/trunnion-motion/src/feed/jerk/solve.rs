//! The search for a fast profile.

use super::barrier::FIRST_WEIGHT;
use super::newton::BarrierSolver;
use super::speed_caps::SpeedCaps;
use super::speed_spline::{EndMotion, FeasibleSpline, SpeedSpline};
use super::{initial, restore};
use crate::feed::grid::FeedGrid;
use crate::feed::plan::LimitRatios;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::types::{AccelerationProfile, LinearSegment, SchedulePiece};

/// Returns the lengths of the cells.
pub(super) fn lengths<const N: usize>(grid: &FeedGrid<N>) -> Vec<f64> {
    grid.cells.iter().map(|cell| cell.h).collect()
}

/// Returns a spline to start from, if there is one; `None` altogether where nothing is limited, so
/// that nothing moves.
pub(super) fn feasible<const N: usize>(
    grid: &FeedGrid<N>,
    limits: &ReciprocalLimits<N>,
    ends: [EndMotion; 2],
) -> Option<(SpeedCaps, Option<FeasibleSpline>)> {
    let mut spline = SpeedSpline::new(lengths(grid), vec![0.0; grid.cells.len()], ends);
    let caps = SpeedCaps::new(grid, &spline, limits)?;
    initial::feasible(grid, limits, &caps, &mut spline);
    // From rest to rest a slow enough profile is inside all limits; an end that moves may have to be restored.
    let start = if ends.iter().any(EndMotion::moves) {
        restore::restore(grid, limits, &caps, FeasibleSpline::unproven(spline))
    } else {
        Some(FeasibleSpline::unproven(spline))
    };
    Some((caps, start))
}

/// Makes a spline fast, and returns the bounds it keeps.
pub(super) fn fastest<const N: usize>(
    grid: &FeedGrid<N>,
    limits: &ReciprocalLimits<N>,
    caps: SpeedCaps,
    start: FeasibleSpline,
    tolerance: f64,
) -> (SpeedSpline, LimitRatios) {
    let slow = start.clone();
    // Multipliers of the central path first; then the weight of the barrier falls stretch by stretch.
    let mut solver = BarrierSolver::new(grid, limits, caps, &[], start.spline);
    solver.keep_references(&start.references);
    solver.centre(FIRST_WEIGHT, solver.spline.cells());
    solver.hurry(1..solver.spline.len() - 1, FIRST_WEIGHT, tolerance);
    let bounds = solver.bounds();
    if kept(&bounds) {
        return (solver.spline, bounds);
    }
    // Steps stay off the limits by far more than rounding, so this is not expected to be reached.
    solver.restart(slow);
    let bounds = solver.bounds();
    (solver.spline, bounds)
}

/// Returns `true` if the bounds prove that all limits hold.
pub(super) fn kept(bounds: &LimitRatios) -> bool {
    let kept = |bound: f64| bound <= 1.0;
    kept(bounds.velocity) && kept(bounds.acceleration) && bounds.jerk.is_some_and(kept)
}

/// Adds up the times through the cells, in which acceleration is linear in `s`.
pub(super) fn schedule<const N: usize>(grid: &FeedGrid<N>, spline: &SpeedSpline) -> SchedulePiece {
    let mut t = vec![0.0];
    let mut now = 0.0;
    let [speed, acceleration] = spline.motion();
    for (cell, length) in spline.lengths.iter().enumerate() {
        let stretch = LinearSegment {
            length: *length,
            speed: [speed[cell], speed[cell + 1]],
            acceleration: [acceleration[cell], acceleration[cell + 1]],
        };
        now += stretch.time();
        t.push(now);
    }
    SchedulePiece {
        s: grid.s.clone(),
        t,
        speed,
        acceleration,
        profile: AccelerationProfile::Linear,
    }
}
