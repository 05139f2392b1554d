//! Speeds that the user gives: motion of the axes, and broken limits.

use super::cell::FeedCell;
use super::directional::DirectionalLimits;
use super::ends::EndSquares;
use super::error::FeedError;
use super::grid::FeedGrid;
use super::limits::Limits;
use super::options::FeedOptions;
use super::pieces::{assemble, plan_all, planned};
use super::plan::{BindingLimit, FeedPlan};
use super::profile::SpeedProfile;
use super::reciprocal::ReciprocalLimits;
use super::{lower_bound, measure, validate as feed_validate};
use crate::types::{AxisPath, AxisPiece, Interval, Progress, SchedulePiece};
use nalgebra::SVector;

/// Samples from a row to the next, both ends among them.
const SAMPLES: u32 = 9;

/// Relative difference that counts as rounding: a ratio, or a position on the path, is right to a
/// few dozen roundings.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Rows nearer to a node than this share of the distance to the next are taken for the node: half
/// the digits. Derivatives of the path over a shorter distance would be lost in rounding.
const LEAST_SHARE: f64 = 1.5e-8;

/// `ds/dt` along one piece; its square is linear in `s` between rows, so acceleration is constant.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GivenSpeed {
    /// Path parameter of each row, increasing, from the start of the piece or before to its end or
    /// after.
    pub s: Vec<f64>,
    /// `ds/dt` there.
    pub speed: Vec<f64>,
}

/// Interval on which a limit does not hold.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LimitBreach {
    /// Index of the piece.
    pub piece: usize,
    /// Interval of `s`, to an eighth of the distance between rows.
    pub s: Interval,
    /// The limit.
    pub limit: BindingLimit,
    /// Largest value over the limit.
    pub ratio: f64,
    /// `s` at the largest value.
    pub worst: f64,
}

/// Runs a path at given speeds, one [`GivenSpeed`] a piece, and reports where they break limits.
///
/// `q' = t V`, `q'' = t A + K V²`, `q''' = t J + 3 K V A + L V³` with the derivatives of the path;
/// the time between rows is `2 ds / (V0 + V1)`. Breaches are in order of `s`. `options.end_speeds` does
/// not count, because the speeds give the ends.
///
/// # Errors
///
/// As [`optimal()`](crate::feed::optimal()); speeds that are negative, infinite, not in order, do not cover their piece,
/// or are zero where the path goes on.
///
/// # Source
///
/// `docs/sources.md#000`: (40)-(43), with (43) free of its singularity at V = 0.
///
/// # Example
///
/// 50 mm/s over 100 mm where the axis is allowed 40 mm/s:
///
/// ```
/// use nalgebra::Vector1;
/// use trunnion_motion::feed::{FeedOptions, GivenSpeed, Limits, given};
/// use trunnion_motion::types::{AxisPath, Silent};
///
/// let path = AxisPath::through(&[Vector1::new(0.0), Vector1::new(100.0)])?;
/// let [velocity, acceleration, jerk] = [40.0, 500.0, 1e4].map(Vector1::new);
/// let limits = Limits::symmetric(velocity, acceleration, jerk);
/// let speed = GivenSpeed { s: vec![0.0, 100.0], speed: vec![50.0; 2] };
/// let (plan, breaches) = given(&path, &[speed], &limits, &FeedOptions::fastest(), &Silent)?;
/// assert!((plan.schedule.duration() - 2.0).abs() < 1e-12);
/// assert!((breaches[0].ratio - 1.25).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn given<const N: usize>(
    path: &AxisPath<N>,
    speeds: &[GivenSpeed],
    limits: &Limits<N>,
    options: &FeedOptions,
    progress: &dyn Progress,
) -> Result<(FeedPlan, Vec<LimitBreach>), FeedError> {
    feed_validate::validate(path, limits, options)?;
    if speeds.len() != path.pieces.len() {
        return Err(FeedError::GivenPieces { path: path.pieces.len(), given: speeds.len() });
    }
    for (index, (piece, given)) in path.pieces.iter().zip(speeds).enumerate() {
        validate(index, piece, given)?;
    }
    let planned = plan_all(path, progress, |index, piece| {
        let inverse = ReciprocalLimits::new(piece.motion, limits, options);
        let (nodes, grid, profile) =
            grid(piece, speeds.get(index).unwrap_or(&GivenSpeed::default()));
        moving(index, &grid, &profile)?;
        let ends = [profile.x.first(), profile.x.last()].map(|x| x.copied().unwrap_or_default());
        let ends = EndSquares { start: ends[0], end: ends[1] };
        // The bound depends on the path and the end speeds alone: the grid of the nodes is enough.
        let lower_bound = lower_bound::bound(&nodes, &inverse, &ends);
        Ok(planned(piece, &grid, &profile, &inverse, lower_bound))
    })?;
    let plan = assemble(planned)?;
    let pieces = path.pieces.iter().zip(&plan.schedule.pieces).enumerate();
    let breaches = pieces.flat_map(|(index, (piece, schedule))| {
        breaches(index, piece, schedule, &ReciprocalLimits::new(piece.motion, limits, options))
    });
    let breaches = breaches.collect();
    Ok((plan, breaches))
}

/// Returns the grid of the nodes alone, then the grid with the given rows, and the squared speeds
/// there.
fn grid<const N: usize>(
    piece: &AxisPiece<N>,
    given: &GivenSpeed,
) -> (FeedGrid<N>, FeedGrid<N>, SpeedProfile) {
    let mut nodes = FeedGrid { s: Vec::new(), cells: Vec::new() };
    let mut grid = nodes.clone();
    for pair in piece.nodes.windows(2) {
        let [from, to] = [pair[0].s, pair[1].s];
        let mut rest = FeedCell::between(&pair[0], &pair[1]);
        nodes.cells.push(rest);
        let mut last = from;
        grid.s.push(from);
        let first = given.s.partition_point(|&s| s <= from);
        for &s in given.s.iter().skip(first).take_while(|&&s| s < to) {
            // Cut what is left of the interval where the given row lies.
            let share = (s - last) / rest.h;
            if (LEAST_SHARE..=1.0 - LEAST_SHARE).contains(&share) {
                let [cell, remainder] = rest.split(share);
                grid.cells.push(cell);
                grid.s.push(s);
                (last, rest) = (s, remainder);
            }
        }
        grid.cells.push(rest);
    }
    grid.s.extend(piece.nodes.last().map(|node| node.s));
    let x = grid.s.iter().map(|&s| square_at(given, s)).collect();
    (nodes, grid, SpeedProfile { x, acceleration: None })
}

/// Returns the squared speed at `s`.
fn square_at(given: &GivenSpeed, s: f64) -> f64 {
    // The interval of the given rows that holds s; the first or last one beyond them.
    let next = given.s.partition_point(|&row| row < s).clamp(1, given.s.len() - 1);
    let [from, to] = [given.s[next - 1], given.s[next]];
    let [before, after] = [given.speed[next - 1], given.speed[next]].map(|speed| speed * speed);
    let s = s.clamp(from, to);
    // Weighted so that both ends are met exactly.
    (before * (to - s) + after * (s - from)) / (to - from)
}

/// Checks that the speed is not zero where the path goes on.
fn moving<const N: usize>(
    piece: usize,
    grid: &FeedGrid<N>,
    profile: &SpeedProfile,
) -> Result<(), FeedError> {
    for (index, cell) in grid.cells.iter().enumerate() {
        let [from, to] = profile.ends(index);
        // At rest at both ends a cell is never passed; that is right only where nothing moves.
        let goes_on = cell.rates.iter().any(|rate| rate.amax() > 0.0) || cell.feed_rate[0] > 0.0;
        if from <= 0.0 && to <= 0.0 && goes_on {
            return Err(FeedError::GivenStop { piece, from: grid.s[index], to: grid.s[index + 1] });
        }
    }
    Ok(())
}

/// Returns the intervals on which a limit does not hold, in order of `s`.
fn breaches<const N: usize>(
    index: usize,
    piece: &AxisPiece<N>,
    schedule: &SchedulePiece,
    limits: &ReciprocalLimits<N>,
) -> Vec<LimitBreach> {
    let names = names::<N>();
    // One slot for each limit: open while the limit is broken at consecutive samples.
    let mut open: Vec<Option<LimitBreach>> = vec![None; names.len()];
    let mut closed = Vec::new();
    for row in 0..schedule.s.len().saturating_sub(1) {
        let interval = piece.interval_at(schedule.s[row]);
        let Some((origin, quintic)) = piece.quintic(interval) else { break };
        let duration = schedule.t[row + 1] - schedule.t[row];
        for sample in 0..SAMPLES {
            let dt = duration * f64::from(sample) / f64::from(SAMPLES - 1);
            let Some([ds, v, u, _]) = schedule.advance(row, dt) else { continue };
            let s = schedule.s[row] + ds;
            let points = measure::rates_at(piece, interval, s);
            let ratios = ratios(&quintic.at(s - origin), [v, u], points, limits);
            for ((slot, ratio), limit) in open.iter_mut().zip(ratios).zip(&names) {
                if ratio <= 1.0 + ROUNDING {
                    closed.extend(slot.take());
                    continue;
                }
                let here = Interval::point(s);
                let fresh = LimitBreach { piece: index, s: here, limit: *limit, ratio, worst: s };
                let breach = slot.get_or_insert(fresh);
                breach.s.high = s;
                if ratio > breach.ratio {
                    (breach.ratio, breach.worst) = (ratio, s);
                }
            }
        }
    }
    closed.extend(open.into_iter().flatten());
    // Stable: breaches that begin at the same point stay in order of limits.
    closed.sort_by(|a, b| a.s.low.total_cmp(&b.s.low));
    closed
}

/// Returns the limits in the order of [`ratios`].
fn names<const N: usize>() -> Vec<BindingLimit> {
    let axis = |axis: usize| u8::try_from(axis).unwrap_or(u8::MAX);
    let kinds = [BindingLimit::Velocity, BindingLimit::Acceleration, BindingLimit::Jerk];
    let axes = kinds.into_iter().flat_map(|kind| (0..N).map(move |index| kind(axis(index))));
    axes.chain([BindingLimit::Feed, BindingLimit::Tip]).collect()
}

/// Returns everything over its limit, at one moment; `d²s/dt²` is constant.
fn ratios<const N: usize>(
    q: &[SVector<f64, N>; 4],
    [v, u]: [f64; 2],
    [feed, tip]: [f64; 2],
    limits: &ReciprocalLimits<N>,
) -> Vec<f64> {
    // Chain rule: q' v, q' u + q'' v², and 3 q'' u v + q''' v³ since du/dt = 0.
    let velocity = q[1] * v;
    let acceleration = q[1] * u + q[2] * (v * v);
    let jerk = q[2] * (3.0 * u * v) + q[3] * v.powi(3);
    let over = |values: SVector<f64, N>, sides: &DirectionalLimits<N>| {
        SVector::<f64, N>::from_fn(|axis, _| sides.share(axis, values[axis]))
    };
    let all = [
        over(velocity, &limits.velocity),
        over(acceleration, &limits.acceleration),
        over(jerk, &DirectionalLimits::both(limits.jerk.unwrap_or_else(SVector::zeros))),
    ];
    let axes = all.iter().flat_map(|values| values.iter().copied());
    axes.chain([v * feed * limits.feed, v * tip * limits.tip]).collect()
}

/// Checks that the given speeds increase in `s`, are finite, and cover the piece.
fn validate<const N: usize>(
    piece: usize,
    path: &AxisPiece<N>,
    given: &GivenSpeed,
) -> Result<(), FeedError> {
    let mut before = f64::NEG_INFINITY;
    for (row, (&s, &speed)) in given.s.iter().zip(&given.speed).enumerate() {
        if !(s > before && s.is_finite() && speed.is_finite() && speed >= 0.0) {
            return Err(FeedError::GivenRow { piece, row, s, before, speed });
        }
        before = s;
    }
    // NaN for what is missing: it covers nothing.
    let ends = |s: Option<f64>| s.unwrap_or(f64::NAN);
    let from = ends(path.nodes.first().map(|node| node.s));
    let to = ends(path.nodes.last().map(|node| node.s));
    let [first, last] = [ends(given.s.first().copied()), ends(given.s.last().copied())];
    let rows = [given.s.len(), given.speed.len()];
    let slack = ROUNDING * from.abs().max(to.abs());
    let covers = first <= from + slack && last >= to - slack;
    if rows[0] >= 2 && rows[0] == rows[1] && covers {
        return Ok(());
    }
    Err(FeedError::GivenCover { piece, from, to, first, last, rows })
}
