//! Jerk-limited schedules.
//!
//! The squared speed is a spline (`spline`) whose rows (`rows`) bound velocities, accelerations and
//! jerks everywhere; an interior-point method (`newton`, `local`, `band`) makes it as fast as they
//! allow, from a slow profile (`start`) on a grid that resolves rest at both ends (`grid`).

mod band;
mod caps;
mod check;
mod grid;
mod local;
mod newton;
mod rows;
mod spline;
mod start;

use super::profile::Grid;
use super::{
    Ends, FeedError, FeedOptions, Limits, Plan, PlannedPiece, Ratios, Reciprocals, assemble, lower,
    plan_all,
};
use crate::types::{AxisPath, AxisPiece, Law, Progress, SchedulePiece, Stretch};
use caps::Caps;
use newton::Solver;
use spline::Spline;

/// Barrier weights as shares of each cell's time: the first about balances the time against the 110
/// sides of rows a cell has, the last leaves 2e-4 of it.
const FIRST_WEIGHT: f64 = 5e-3;
const LEVELS: usize = 7;
const LOWER: f64 = 0.3;
/// Newton steps per stretch and sweep.
const STEPS: usize = 3;
/// Controls of a stretch: several times the distance over which a stop is felt.
const STRETCH: usize = 1000;
/// Borders of stretches move by this share of a stretch from sweep to sweep: the golden section
/// never comes near a former place.
const SHIFT: f64 = 0.618_033_988_749_895;
/// Most sweeps at the last weight.
const EXTRA: usize = 4;

/// Plans a schedule within velocity, acceleration, jerk and feed limits, from rest to rest on each
/// piece, with continuous acceleration.
///
/// `q''' = q' J + 3 q'' V A + q''' V³` is kept on every axis, between nodes as well: [`Plan::bounds`]
/// are guaranteed. Not convex, so not certainly the fastest; [`Plan::lower_bound`] disregards jerk and
/// tells how much it can be at most. Every slow enough profile is allowed, so valid data always has a
/// schedule, whatever its units; every step of the search keeps all limits.
///
/// The search ends when a sweep gains less than `time_tolerance`.
///
/// # Errors
///
/// As [`super::optimal`], [`FeedError::NoJerkLimit`] and [`FeedError::NotAtRest`].
///
/// # Source
///
/// `docs/sources.md#001`: jerk-limited schedules.
pub fn jerk<const N: usize>(
    path: &AxisPath<N>,
    limits: &Limits<N>,
    options: &FeedOptions,
    progress: &dyn Progress,
) -> Result<Plan, FeedError> {
    super::error::validate(path, limits, options)?;
    if limits.jerk.is_none() {
        return Err(FeedError::NoJerkLimit);
    }
    for (name, value) in ["start", "end"].into_iter().zip(options.ends) {
        if value > 0.0 {
            return Err(FeedError::NotAtRest { name, value });
        }
    }
    let planned = plan_all(path, progress, |_, piece| {
        Ok(plan_piece(piece, &Reciprocals::new(piece.motion, limits, options), options))
    })?;
    Ok(assemble(planned))
}

fn plan_piece<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &Reciprocals<N>,
    options: &FeedOptions,
) -> PlannedPiece {
    let grid = grid::graded(piece, limits);
    let lengths: Vec<f64> = grid.cells.iter().map(|cell| cell.h).collect();
    let mut spline = Spline { controls: vec![0.0; lengths.len()], lengths };
    let mut bounds = Ratios { jerk: Some(0.0), ..Ratios::default() };
    if let Some(caps) = Caps::new(&grid, &spline, limits) {
        start::feasible(&grid, limits, &caps, &mut spline);
        (spline, bounds) = fastest(&grid, limits, caps, (spline, options.time_tolerance));
    }
    let schedule = schedule(&grid, &spline);
    PlannedPiece {
        lower_bound: lower::bound(&grid, limits, &Ends { start: 0.0, end: 0.0 }),
        measured: check::measure(piece, &schedule, limits),
        bounds,
        binding: check::binding(piece, &schedule, limits),
        inserted: schedule.s.len() - piece.nodes.len(),
        schedule,
    }
}

/// The spline made fast, and the bounds it keeps.
fn fastest<const N: usize>(
    grid: &Grid<N>,
    limits: &Reciprocals<N>,
    caps: Caps,
    (start, tolerance): (Spline, f64),
) -> (Spline, Ratios) {
    let slow = start.clone();
    let mut weight = FIRST_WEIGHT;
    let mut solver = Solver::new(grid, limits, caps, start, weight);
    let mut border = 0.5;
    let mut time = f64::INFINITY;
    for sweep in 0..LEVELS + EXTRA {
        solver.sweep(weight, STEPS, [1 + share_of_stretch(border), STRETCH]);
        border = (border + SHIFT).fract();
        if sweep + 1 < LEVELS {
            weight *= LOWER;
        } else {
            let now = solver.spline.time();
            if now > (1.0 - tolerance) * time {
                break;
            }
            time = now;
        }
    }
    let bounds = solver.bounds();
    let kept = |bound: f64| bound <= 1.0;
    if kept(bounds.velocity) && kept(bounds.acceleration) && bounds.jerk.is_some_and(kept) {
        return (solver.spline, bounds);
    }
    // Steps stay off the limits by far more than rounding, so this is not expected to be reached.
    solver.restart(slow);
    let bounds = solver.bounds();
    (solver.spline, bounds)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share in 0..1 of a small number"
)]
fn share_of_stretch(share: f64) -> usize {
    (share * STRETCH as f64) as usize
}

fn schedule<const N: usize>(grid: &Grid<N>, spline: &Spline) -> SchedulePiece {
    let mut t = vec![0.0];
    let mut now = 0.0;
    let [speed, acceleration] = spline.motion();
    for (cell, length) in spline.lengths.iter().enumerate() {
        let stretch = Stretch {
            length: *length,
            speed: [speed[cell], speed[cell + 1]],
            acceleration: [acceleration[cell], acceleration[cell + 1]],
        };
        now += stretch.time();
        t.push(now);
    }
    SchedulePiece { s: grid.s.clone(), t, speed, acceleration, law: Law::Ramps }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{AxisNode, Motion, Silent};
    use nalgebra::Vector1;

    const FREE: FeedOptions = FeedOptions {
        feed: None,
        link_feed: None,
        tip: None,
        time_tolerance: 1e-3,
        ends: [0.0; 2],
        guarantee: true,
    };

    fn limits(velocity: f64, acceleration: f64, jerk: f64) -> Limits<1> {
        let [velocity, acceleration, jerk] = [velocity, acceleration, jerk].map(Vector1::new);
        Limits { velocity, rapid: velocity, acceleration, jerk: Some(jerk) }
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
