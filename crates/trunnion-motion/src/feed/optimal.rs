//! The fastest schedule within velocity and acceleration limits.

use super::ends::EndSquares;
use super::error::FeedError;
use super::limits::Limits;
use super::options::FeedOptions;
use super::pieces::{PlannedPiece, assemble, plan_all, planned};
use super::plan::FeedPlan;
use super::profile::SpeedProfile;
use super::reciprocal::ReciprocalLimits;
use super::{lower_bound, refine, validate};
use crate::types::{AxisPath, AxisPiece, Progress, Schedule, SchedulePiece};

/// Plans the fastest schedule within velocity, acceleration and feed limits.
///
/// Backward and forward reachability over the rows in closed form. The constraints of a cell are
/// the Bernstein coefficients of its axis accelerations, so the limits hold between rows as well.
/// The method is greedy: next to points where an axis reverses, the schedule can be up to about
/// 1e-5 slower than the optimum of the same grid. Zero speed is always allowed, so valid data
/// always has a schedule, whatever its units.
///
/// # Errors
///
/// [`FeedError`] names the limit, or piece, node and axis that is wrong; [`FeedError::Cancelled`].
///
/// # Source
///
/// `docs/sources.md#001`: time-optimal path parametrisation by reachability (Pham and Pham, 2018).
///
/// # Example
///
/// A line of 100 mm at 50 mm/s and 500 mm/s²: 0.1 s up, 1.9 s at full speed, 0.1 s down.
///
/// ```
/// use nalgebra::Vector1;
/// use trunnion_motion::feed::{FeedOptions, Limits, optimal};
/// use trunnion_motion::types::{AxisPath, Silent};
///
/// let path = AxisPath::through(&[Vector1::new(0.0), Vector1::new(100.0)])?;
/// let [velocity, acceleration, jerk] = [50.0, 500.0, 1e4].map(Vector1::new);
/// let limits = Limits::symmetric(velocity, acceleration, jerk).without_jerk();
/// let plan = optimal(&path, &limits, &FeedOptions::fastest(), &Silent)?;
/// assert!((plan.schedule.duration() - 2.1).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn optimal<const N: usize>(
    path: &AxisPath<N>,
    limits: &Limits<N>,
    options: &FeedOptions,
    progress: &dyn Progress,
) -> Result<FeedPlan, FeedError> {
    validate::validate(path, limits, options)?;
    let count = path.pieces.len();
    let planned = plan_all(path, progress, |index, piece| {
        let limits = ReciprocalLimits::new(piece.motion, limits, options);
        plan_piece(piece, &limits, options, &EndSquares::of(index, count, options))
    })?;
    assemble(planned)
}

/// Plans the schedule of [`optimal`] alone, in half the time: without lower bound, dense check and
/// binding limits.
///
/// # Errors
///
/// As [`optimal`].
pub fn optimal_schedule<const N: usize>(
    path: &AxisPath<N>,
    limits: &Limits<N>,
    options: &FeedOptions,
    progress: &dyn Progress,
) -> Result<Schedule, FeedError> {
    validate::validate(path, limits, options)?;
    let count = path.pieces.len();
    let mut pieces = plan_all(path, progress, |index, piece| {
        let limits = ReciprocalLimits::new(piece.motion, limits, options);
        schedule_piece(piece, &limits, options, &EndSquares::of(index, count, options))
    })?;
    // Pieces were planned side by side, each from time 0.
    let mut start = 0.0;
    for piece in &mut pieces {
        piece.t.iter_mut().for_each(|t| *t += start);
        start = piece.t.last().copied().unwrap_or(start);
    }
    Ok(Schedule { pieces })
}

/// Plans the schedule of one piece, with times from 0.
fn schedule_piece<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &ReciprocalLimits<N>,
    options: &FeedOptions,
    ends: &EndSquares,
) -> Result<SchedulePiece, FeedError> {
    // Limits at rows alone need no grid: the nodes are the rows.
    if !options.guarantee && piece.nodes.len() > refine::FEWEST_CELLS {
        let profile = SpeedProfile::fastest_at_nodes(&piece.nodes, limits, ends);
        profile.check_ends(ends)?;
        let s = piece.nodes.iter().map(|node| node.s).collect();
        let lengths = piece.nodes.windows(2).map(|pair| pair[1].s - pair[0].s);
        return Ok(profile.schedule(s, lengths));
    }
    let (grid, profile) = refine::plan(piece, limits, options, ends);
    profile.check_ends(ends)?;
    Ok(profile.schedule(grid.s, grid.cells.iter().map(|cell| cell.h)))
}

/// Plans one piece with its lower bound and measured ratios.
fn plan_piece<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &ReciprocalLimits<N>,
    options: &FeedOptions,
    ends: &EndSquares,
) -> Result<PlannedPiece, FeedError> {
    let (grid, profile) = refine::plan(piece, limits, options, ends);
    profile.check_ends(ends)?;
    let lower_bound = lower_bound::bound(&grid, limits, ends);
    Ok(planned(piece, &grid, &profile, limits, lower_bound))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::plan::BindingLimit;
    use crate::types::{AxisNode, Motion, Silent};
    use nalgebra::{SVector, Vector1, Vector2};

    fn node<const N: usize>(s: f64, q: [SVector<f64, N>; 4]) -> AxisNode<N> {
        AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
    }

    fn path<const N: usize>(nodes: Vec<AxisNode<N>>) -> AxisPath<N> {
        AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] }
    }

    fn limits<const N: usize>(velocity: f64, acceleration: f64) -> Limits<N> {
        Limits {
            velocity: SVector::repeat(velocity),
            rapid: SVector::repeat(2.0 * velocity),
            acceleration: SVector::repeat(acceleration),
            jerk: None,
            minus: None,
        }
    }

    const FREE: FeedOptions = FeedOptions { time_tolerance: 1e-4, ..FeedOptions::fastest() };

    /// A straight line of `length` by one axis, from two nodes.
    fn line(length: f64) -> AxisPath<1> {
        let [zero, one] = [Vector1::zeros(), Vector1::new(1.0)];
        let at = |s: f64| node(s, [Vector1::new(s), one, zero, zero]);
        path(vec![at(0.0), at(length)])
    }

    fn duration<const N: usize>(
        path: &AxisPath<N>,
        limits: &Limits<N>,
        o: &FeedOptions,
    ) -> FeedPlan {
        optimal(path, limits, o, &Silent).unwrap()
    }

    #[test]
    fn a_line_is_a_trapezoid_or_a_triangle() {
        // 100 mm at 50 mm/s, 500 mm/s²: 0.1 + 1.9 + 0.1 s; 2 mm: a triangle.
        for (length, time) in [(100.0, 2.1), (5.0, 0.2), (2.0, 2.0 * (2.0f64 / 500.0).sqrt())] {
            let plan = duration(&line(length), &limits(50.0, 500.0), &FREE);
            let got = plan.schedule.duration();
            assert!((got - time).abs() < 1e-9 * time, "{length} mm: {got} s");
            assert!((plan.lower_bound - time).abs() < 1e-9 * time, "{}", plan.lower_bound);
            assert!(plan.bounds.velocity <= 1.0 + 1e-12);
            assert!(plan.bounds.acceleration <= 1.0 + 1e-12);
            assert!(plan.acceleration_step <= 2.0 + 1e-12);
        }
    }

    #[test]
    fn feed_limits_cuts_and_rapids_limit_links() {
        let options = FREE.with_feed(20.0);
        let cut = duration(&line(100.0), &limits(50.0, 500.0), &options);
        assert!((cut.schedule.duration() - (100.0 / 20.0 + 20.0 / 500.0)).abs() < 1e-9);
        assert_eq!(cut.binding[0][cut.binding[0].len() / 2], BindingLimit::Feed);
        let mut link = line(100.0);
        link.pieces[0].motion = Motion::Link;
        let link = duration(&link, &limits(50.0, 500.0), &options);
        assert!((link.schedule.duration() - (100.0 / 100.0 + 100.0 / 500.0)).abs() < 1e-9);
        assert_eq!(link.binding[0][0], BindingLimit::Acceleration(0));
    }

    #[test]
    fn a_circle_is_limited_by_centripetal_acceleration() {
        // Half a turn about (0, 0): v² / r = a at the places where one axis takes it all.
        let radius = 40.0;
        let nodes = (0..=64).map(|k| {
            let s = f64::from(k) / 64.0 * radius * std::f64::consts::PI;
            let (sin, cos) = (s / radius).sin_cos();
            let at = |x: f64, y: f64| Vector2::new(x, y);
            let (r, rr) = (1.0 / radius, 1.0 / (radius * radius));
            let q = [at(radius * cos, radius * sin), at(-sin, cos), at(-cos, -sin) * r];
            node(s, [q[0], q[1], q[2], at(sin, -cos) * rr])
        });
        let plan = duration(&path(nodes.collect()), &limits(1e6, 1000.0), &FREE);
        let piece = &plan.schedule.pieces[0];
        let top = piece.time_at(radius * std::f64::consts::FRAC_PI_2);
        let speed = piece.at_time(top).unwrap().speed;
        assert!(speed <= 200.0 * (1.0 + 1e-12) && speed > 199.0, "{speed}");
        assert!(plan.ratios.acceleration <= 1.0 + 1e-12);
        assert!(plan.lower_bound <= plan.schedule.duration());
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn a_path_that_stands_still_takes_no_time() {
        let zero = Vector1::zeros();
        let mut still = path(vec![node(0.0, [zero; 4]), node(1.0, [zero; 4])]);
        for node in &mut still.pieces[0].nodes {
            (node.tip_rate, node.feed_rate) = (0.0, 0.0);
        }
        let plan = duration(&still, &limits(50.0, 500.0), &FREE);
        assert_eq!(plan.schedule.duration(), 0.0);
        assert_eq!(plan.binding[0][0], BindingLimit::Still);
    }

    #[test]
    fn wrong_data_is_named() {
        let good = line(1.0);
        let ok = limits(50.0, 500.0);
        let error = |path: &AxisPath<1>, limits: &Limits<1>, options: &FeedOptions| {
            optimal(path, limits, options, &Silent).unwrap_err().to_string()
        };
        let mut bad = ok;
        bad.rapid[0] = 0.0;
        assert!(error(&good, &bad, &FREE).contains("rapid velocity limit of axis 0 is 0"));
        bad = ok;
        bad.acceleration[0] = f64::INFINITY;
        assert!(error(&good, &bad, &FREE).contains("acceleration limit of axis 0 is inf"));
        let options = FREE.with_feed(-1.0);
        assert!(error(&good, &ok, &options).contains("feed is -1 mm/s"));
        let mut path = good.clone();
        path.pieces[0].nodes[1].s = 0.0;
        assert!(error(&path, &ok, &FREE).contains("piece 0, node 1: s = 0 does not increase"));
        path = good.clone();
        path.pieces[0].nodes[1].q[2][0] = f64::NAN;
        assert!(error(&path, &ok, &FREE).contains("node 1: derivative 2 of axis 0 is NaN"));
        path.pieces[0].nodes.truncate(1);
        assert!(error(&path, &ok, &FREE).contains("piece 0 has 1 node(s)"));
    }
}
