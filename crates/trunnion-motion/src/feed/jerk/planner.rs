//! Jerk-limited plans of whole paths.

use super::solve::{fastest, feasible, lengths, schedule};
use super::speed_spline::{EndMotion, SpeedSpline};
use super::{end_motion, graded_grid, measure};
use crate::feed::ends::EndSquares;
use crate::feed::error::FeedError;
use crate::feed::limits::Limits;
use crate::feed::options::{FeedOptions, PathEnds};
use crate::feed::pieces::{PlannedPiece, assemble, plan_all};
use crate::feed::plan::{FeedPlan, LimitRatios};
use crate::feed::reciprocal::ReciprocalLimits;
use crate::feed::{lower_bound, validate};
use crate::types::{AxisPath, AxisPiece, Progress, SchedulePiece};

/// Plans a schedule within velocity, acceleration, jerk and feed limits, with continuous
/// acceleration. Pieces rest where they meet; the first starts and the last ends with the speeds
/// of `options.end_speeds` and no `d²s/dt²`.
///
/// `q''' = q' J + 3 q'' V A + q''' V³` is kept on every axis, between nodes as well:
/// [`FeedPlan::bounds`] are guaranteed. The problem is not convex, so the schedule is not
/// certainly the fastest; [`FeedPlan::lower_bound`] disregards jerk and bounds how far it can be
/// off. From rest to rest every slow enough profile is allowed, so valid data always has a
/// schedule, whatever its units. Every step of the search keeps all limits.
///
/// The search of a stretch ends when it gains less than `time_tolerance`.
///
/// # Errors
///
/// As [`optimal()`](crate::feed::optimal()), and [`FeedError::NoJerkLimit`]. A speed at an end for which no schedule is
/// found is [`FeedError::StartTooFast`] or [`FeedError::EndTooFast`].
///
/// # Source
///
/// `docs/sources.md#001`: jerk-limited schedules.
///
/// # Example
///
/// 100 mm from rest to rest: at 1000 mm/s² alone it would take 0.1 s to reach 100 mm/s, and jerk adds to that.
///
/// ```
/// use nalgebra::Vector1;
/// use trunnion_motion::feed::{FeedOptions, Limits, jerk};
/// use trunnion_motion::types::{AxisPath, Silent};
///
/// let path = AxisPath::through(&[Vector1::new(0.0), Vector1::new(100.0)])?;
/// let [velocity, acceleration, change] = [100.0, 1e3, 2e4].map(Vector1::new);
/// let limits = Limits::symmetric(velocity, acceleration, change);
/// let plan = jerk(&path, &limits, &FeedOptions::fastest(), &Silent)?;
/// let seconds = plan.schedule.duration();
/// assert!(plan.lower_bound <= seconds && seconds < 1.3);
/// assert!(plan.bounds.jerk.is_some_and(|jerk| jerk <= 1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn jerk<const N: usize>(
    path: &AxisPath<N>,
    limits: &Limits<N>,
    options: &FeedOptions,
    progress: &dyn Progress,
) -> Result<FeedPlan, FeedError> {
    jerk_between(path, limits, options, PathEnds::REST, progress)
}

/// Plans as [`jerk`] does, with `d²s/dt²` at the start and at the end as well.
///
/// # Errors
///
/// As [`jerk`]; [`FeedError::BadEndAcceleration`] for one that is not finite, or not 0 at rest.
pub fn jerk_between<const N: usize>(
    path: &AxisPath<N>,
    limits: &Limits<N>,
    options: &FeedOptions,
    accelerations: PathEnds,
    progress: &dyn Progress,
) -> Result<FeedPlan, FeedError> {
    validate::validate(path, limits, options)?;
    if limits.jerk.is_none() {
        return Err(FeedError::NoJerkLimit);
    }
    let limits = &limits.smaller();
    // Inner pieces rest at both ends.
    let ends = end_motion::borders(options.end_speeds, accelerations)?;
    let count = path.pieces.len();
    let planned = plan_all(path, progress, |index, piece| {
        let at = |here: bool, end: EndMotion| if here { end } else { EndMotion::Rest };
        let ends = [at(index == 0, ends[0]), at(index + 1 == count, ends[1])];
        let limits = ReciprocalLimits::new(piece.motion, limits, options);
        plan_piece(index, piece, &limits, options, ends)
    })?;
    assemble(planned)
}

/// Plans one piece between given end motions.
fn plan_piece<const N: usize>(
    index: usize,
    piece: &AxisPiece<N>,
    limits: &ReciprocalLimits<N>,
    options: &FeedOptions,
    ends: [EndMotion; 2],
) -> Result<PlannedPiece, FeedError> {
    // Where nothing limits anything, nothing moves: the spline at rest is the schedule.
    let grid = graded_grid::graded(piece, limits, &ends);
    if grid.cells.len() < graded_grid::FEWEST_CELLS {
        return Err(FeedError::Unresolved { piece: index });
    }
    let mut spline = SpeedSpline::new(lengths(&grid), vec![0.0; grid.cells.len()], ends);
    let mut bounds = LimitRatios { jerk: Some(0.0), ..LimitRatios::default() };
    if let Some((caps, start)) = feasible(&grid, limits, ends) {
        let start = start.ok_or_else(|| end_motion::refused(piece, limits, ends))?;
        (spline, bounds) = fastest(&grid, limits, caps, start, options.time_tolerance);
    }
    let schedule = schedule(&grid, &spline);
    let [start, end] = ends.map(|end| end.square());
    let lower_bound = lower_bound::bound(&grid, limits, &EndSquares { start, end });
    Ok(PlannedPiece { lower_bound, bounds, ..measured(piece, schedule, limits) })
}

/// Returns a schedule from rest to rest with its measured ratios; its bounds are not known.
pub(crate) fn known_of<const N: usize>(
    piece: &AxisPiece<N>,
    schedule: SchedulePiece,
    limits: &ReciprocalLimits<N>,
) -> PlannedPiece {
    let grid = graded_grid::graded(piece, limits, &[EndMotion::Rest; 2]);
    let lower_bound = lower_bound::bound(&grid, limits, &EndSquares { start: 0.0, end: 0.0 });
    PlannedPiece { lower_bound, ..measured(piece, schedule, limits) }
}

/// Measures a schedule; lower bound and bounds are left for the caller.
fn measured<const N: usize>(
    piece: &AxisPiece<N>,
    schedule: SchedulePiece,
    limits: &ReciprocalLimits<N>,
) -> PlannedPiece {
    PlannedPiece {
        lower_bound: 0.0,
        measured: measure::measure(piece, &schedule, limits),
        bounds: LimitRatios::default(),
        binding: measure::binding(piece, &schedule, limits),
        inserted: schedule.s.len().saturating_sub(piece.nodes.len()),
        schedule,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{AxisNode, Motion, Silent};
    use nalgebra::Vector1;

    const FREE: FeedOptions = FeedOptions::fastest();

    fn limits(velocity: f64, acceleration: f64, jerk: f64) -> Limits<1> {
        let [velocity, acceleration, jerk] = [velocity, acceleration, jerk].map(Vector1::new);
        Limits { velocity, rapid: velocity, acceleration, jerk: Some(jerk), minus: None }
    }

    fn line(length: f64, nodes: u32) -> AxisPath<1> {
        let [zero, one] = [Vector1::zeros(), Vector1::new(1.0)];
        let at = |k: u32| {
            let s = length * f64::from(k) / f64::from(nodes - 1);
            AxisNode { s, q: [Vector1::new(s), one, zero, zero], tip_rate: 1.0, feed_rate: 1.0 }
        };
        let nodes = (0..nodes).map(at).collect();
        AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] }
    }

    /// Shortest time over a straight line from rest to rest: phases of constant jerk, of constant
    /// acceleration and of constant speed, as many as there are.
    fn seven_phases(length: f64, [v, a, j]: [f64; 3]) -> f64 {
        // Time and distance from rest to a speed.
        let rise = |v: f64| if v * j < a * a { 2.0 * (v / j).sqrt() } else { v / a + a / j };
        let way = |v: f64| 0.5 * v * rise(v);
        let [mut slow, mut fast] = [0.0, v];
        for _ in 0..100 {
            let middle = 0.5 * (slow + fast);
            if 2.0 * way(middle) <= length { slow = middle } else { fast = middle }
        }
        2.0 * rise(slow) + (length - 2.0 * way(slow)) / slow
    }

    /// With v = 50, a = 500 and j = 10^4, 0.05 s of jerk, 0.05 s of constant acceleration, 0.05 s of
    /// jerk: 3.75 mm each way. Short moves: four phases of jerk, 32 (T/4)³ j / 16 = L.
    #[test]
    fn a_line_takes_the_time_of_its_phases() {
        let machine = [50.0, 500.0, 1e4];
        assert!((seven_phases(100.0, machine) - 2.15).abs() < 1e-12);
        let short = 4.0 * (0.2_f64 / (2.0 * 1e4)).cbrt();
        assert!((seven_phases(0.2, machine) - short).abs() < 1e-12);
        let [brisk, lazy] = [[100.0, 1000.0, 2e4], [1000.0, 50.0, 1e4]];
        for (length, [v, a, j]) in
            [(100.0, machine), (10.0, machine), (0.2, machine), (1.0, brisk), (1.0, lazy)]
        {
            let want = seven_phases(length, [v, a, j]);
            for nodes in [2, 7, 200] {
                let path = line(length, nodes);
                let plan = jerk(&path, &limits(v, a, j), &FREE, &Silent).unwrap();
                let got = plan.schedule.duration();
                assert!(got >= want * (1.0 - 1e-12), "{length} mm: {got} s below {want} s");
                assert!(got <= want * 1.005, "{length} mm, {nodes} nodes: {got} s, best {want} s");
                assert!(plan.lower_bound <= want);
                assert!(plan.ratios.jerk.unwrap() > 0.98, "{:?}", plan.ratios);
            }
        }
    }

    #[test]
    fn without_jerk_limits_there_is_no_plan() {
        let mut limits = limits(50.0, 500.0, 1e4);
        limits.jerk = None;
        let error = jerk(&line(1.0, 2), &limits, &FREE, &Silent).unwrap_err();
        assert_eq!(error, FeedError::NoJerkLimit);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "exactly nothing")]
    fn a_path_that_stands_still_takes_no_time() {
        let zero = Vector1::zeros();
        let at = |s| AxisNode { s, q: [zero; 4], tip_rate: 0.0, feed_rate: 0.0 };
        let nodes = vec![at(0.0), at(1.0)];
        let still = AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] };
        let plan = jerk(&still, &limits(50.0, 500.0, 1e4), &FREE, &Silent).unwrap();
        assert_eq!(plan.schedule.duration(), 0.0);
    }
}
