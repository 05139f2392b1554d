//! A stop from the motion that is under way.

use super::rolling_plan::{PathAhead, RollingPlan, caps};
use super::solve::lengths;
use super::speed_spline::{EndMotion, FeasibleSpline, SpeedSpline};
use super::{graded_grid, restore};
use crate::feed::reciprocal::ReciprocalLimits;
use crate::types::{AxisNode, AxisPiece};
use nalgebra::SVector;

/// Factor of the first length tried over that on a straight line: rows need a little room.
const SLACK: f64 = 1.05;
/// Factor from one length tried to the next.
const LONGER: f64 = 1.2;
/// Rows in each phase of the stop that a search starts from.
const ROWS: u32 = 32;
/// Halvings of the share of the limits that the stop needs.
const HALVINGS: usize = 30;

/// Returns the shortest stop that is found over a piece that begins where this motion is, given by
/// squared speed and `d²s/dt²`; `None` if none is found on it.
///
/// The first length tried is the one that the limits at the start allow on a straight line; each
/// further one is a little longer.
pub(crate) fn stop<const N: usize>(
    piece: &AxisPiece<N>,
    motion: [f64; 2],
    limits: &ReciprocalLimits<N>,
) -> Option<RollingPlan<N>> {
    let [first, last] = [piece.nodes.first()?, piece.nodes.last()?];
    let straight = StraightStop::new(&first.q[1], motion, limits);
    // Lengths in geometric progression, so that few are tried.
    let mut distance = straight.way(1.0) * SLACK;
    while distance < last.s - first.s {
        let part = up_to(piece, first.s + distance)?;
        if let Some(course) = halt(&part, motion, limits, &straight.over(distance)) {
            return Some(course);
        }
        distance *= LONGER;
    }
    halt(piece, motion, limits, &straight.over(last.s - first.s))
}

/// A stop on a straight line: jerk from the deceleration that is under way to a largest one, that, and
/// jerk back.
struct StraightStop {
    speed: f64,
    /// Deceleration under way; negative while it speeds up.
    before: f64,
    largest: f64,
    jerk: f64,
}

impl StraightStop {
    fn new<const N: usize>(
        rate: &SVector<f64, N>,
        [x, u]: [f64; 2],
        limits: &ReciprocalLimits<N>,
    ) -> Self {
        let largest = |inverse: &SVector<f64, N>| rate.component_mul(inverse).amax().recip();
        let jerk = limits.jerk.as_ref().map_or(f64::INFINITY, largest);
        let largest = largest(&limits.acceleration.plus).max(-u);
        Self { speed: x.sqrt(), before: -u, largest, jerk }
    }

    /// Returns the durations of the phases and the deceleration between them, with a share of jerk
    /// and deceleration.
    fn phases(&self, share: f64) -> ([f64; 3], f64) {
        let [most, jerk] = [(share * self.largest).max(self.before), share * self.jerk];
        // The speed falls by (most² - before²) / 2j, most t and most² / 2j.
        let half = 0.5 * self.before * self.before;
        // Without a constant phase, (2 peak² - before²) / 2j is the whole speed.
        let peak = (jerk * self.speed + half).sqrt().max(self.before);
        if peak < most {
            return ([(peak - self.before) / jerk, 0.0, peak / jerk], peak);
        }
        let left = self.speed - (most * most - half) / jerk;
        ([(most - self.before) / jerk, left.max(0.0) / most, most / jerk], most)
    }

    /// Returns the length of the stop.
    fn way(&self, share: f64) -> f64 {
        self.table(share).last().map_or(0.0, |row| row[0])
    }

    /// Returns distance and squared speed at even times.
    fn table(&self, share: f64) -> Vec<[f64; 2]> {
        let (times, peak) = self.phases(share);
        let slopes = [share * self.jerk, 0.0, -share * self.jerk];
        let decelerations = [self.before, peak, peak];
        let [mut way, mut speed] = [0.0, self.speed];
        let mut rows = vec![[0.0, speed * speed]];
        for ((time, slope), deceleration) in times.into_iter().zip(slopes).zip(decelerations) {
            let at = |t: f64| {
                // The deceleration grows by slope t: one integral for the speed, two for the distance.
                let lost = t * (deceleration + 0.5 * slope * t);
                let behind = t * t * (0.5 * deceleration + slope * t / 6.0);
                [way + t * speed - behind, (speed - lost).max(0.0)]
            };
            for row in 1..=ROWS {
                let [way, speed] = at(time * f64::from(row) / f64::from(ROWS));
                rows.push([way, speed * speed]);
            }
            [way, speed] = at(time);
        }
        rows
    }

    /// Returns the stop that is gentle enough to be as long as `distance`.
    fn over(&self, distance: f64) -> Vec<[f64; 2]> {
        // Bisection: the stop becomes shorter as the share grows.
        let [mut gentle, mut hard] = [0.0, 1.0];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (gentle + hard);
            if self.way(middle) > distance { gentle = middle } else { hard = middle }
        }
        self.table(hard)
    }
}

/// Returns the piece as far as `s`.
fn up_to<const N: usize>(piece: &AxisPiece<N>, s: f64) -> Option<AxisPiece<N>> {
    let interval = piece.interval_at(s);
    let [from, to] = [piece.nodes.get(interval)?, piece.nodes.get(interval + 1)?];
    let mut nodes = piece.nodes.get(..=interval)?.to_vec();
    if s <= from.s {
        return (nodes.len() > 1).then_some(AxisPiece { nodes, ..*piece });
    }
    // Value and derivatives at s make a node: the quintic up to there is the same polynomial.
    let share = (s - from.s) / (to.s - from.s);
    let mean = |from: f64, to: f64| from + share * (to - from);
    nodes.push(AxisNode {
        s,
        q: piece.axes_at(s)?,
        tip_rate: mean(from.tip_rate, to.tip_rate),
        feed_rate: mean(from.feed_rate, to.feed_rate),
    });
    Some(AxisPiece { nodes, ..*piece })
}

/// Returns a stop over the whole piece that begins from the profile `rows`.
fn halt<const N: usize>(
    piece: &AxisPiece<N>,
    motion: [f64; 2],
    limits: &ReciprocalLimits<N>,
    rows: &[[f64; 2]],
) -> Option<RollingPlan<N>> {
    let ends = [EndMotion::Moving(motion), EndMotion::Rest];
    let grid = graded_grid::graded(piece, limits, &ends);
    let origin = grid.s.first().copied()?;
    let at = |s: f64| {
        let after = rows.partition_point(|row| row[0] <= s - origin).clamp(1, rows.len() - 1);
        let [from, to] = [rows[after - 1], rows[after]];
        let share = ((s - origin - from[0]) / (to[0] - from[0])).clamp(0.0, 1.0);
        from[1] + share * (to[1] - from[1])
    };
    // A parabola through both ends of a cell and its middle.
    let control = |pair: &[f64]| {
        let [from, to] = [pair[0], pair[1]];
        let middle = at(0.5 * (from + to));
        (2.0 * middle - 0.5 * (at(from) + at(to))).max(0.5 * middle)
    };
    let controls = grid.s.windows(2).map(control).collect();
    let spline = SpeedSpline::new(lengths(&grid), controls, ends);
    let caps = caps(&grid, &spline, limits, PathAhead::Nothing)?;
    let stop = restore::restore(&grid, limits, &caps, FeasibleSpline::unproven(spline))?;
    Some(RollingPlan::halting(grid, stop, caps, limits))
}
