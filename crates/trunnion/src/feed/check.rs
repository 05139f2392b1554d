//! What a schedule does: measured densely with another discretisation, and bounded.

use super::profile::{Grid, Profile};
use super::{Binding, Ratios, Reciprocals, refine};
use crate::types::{AxisPiece, SchedulePiece};
use nalgebra::SVector;

/// Samples from a row to the next, evenly in time. Both ends are among them, each seen from inside:
/// jerk jumps at nodes and is often largest there.
const SAMPLES: u32 = 4;

/// Largest values found between and at rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured {
    pub(super) ratios: Ratios,
    pub(super) acceleration_step: f64,
}

/// Samples the schedule evenly in time and evaluates the path in the power basis, so that neither
/// the grid nor the polynomial basis of the planner is used.
pub(super) fn measure<const N: usize>(
    piece: &AxisPiece<N>,
    schedule: &SchedulePiece,
    limits: &Reciprocals<N>,
) -> Measured {
    let start = Ratios { jerk: limits.jerk.map(|_| 0.0), ..Ratios::default() };
    let mut measured = Measured { ratios: start, acceleration_step: 0.0 };
    let mut interval = usize::MAX;
    let mut curve = None;
    let mut before = 0.0;
    for row in 0..schedule.s.len().saturating_sub(1) {
        // Every node is a row, so a row interval lies in one node interval.
        let here = piece.interval_at(schedule.s[row]);
        if here != interval {
            (interval, curve) = (here, piece.quintic(here));
        }
        let Some((origin, quintic)) = curve else { break };
        let [s, v, u] = [schedule.s[row], schedule.speed[row], schedule.acceleration[row]];
        let step = (schedule.t[row + 1] - schedule.t[row]) / f64::from(SAMPLES - 1);
        let rate = quintic.at(s - origin)[1];
        let jump = rate.component_mul(&limits.acceleration).amax() * (u - before).abs();
        measured.acceleration_step = measured.acceleration_step.max(jump);
        before = u;
        for sample in 0..SAMPLES {
            let dt = f64::from(sample) * step;
            let [ds, speed] = [dt * (v + 0.5 * u * dt), v + u * dt];
            let q = quintic.at(s + ds - origin);
            let rates = rates_at(piece, interval, s + ds);
            measured.ratios = measured.ratios.max(ratios(&q, speed, u, rates, limits));
        }
    }
    measured
}

/// Feed rate and tip rate at `s`, linear between nodes.
pub(super) fn rates_at<const N: usize>(piece: &AxisPiece<N>, interval: usize, s: f64) -> [f64; 2] {
    let (Some(from), Some(to)) = (piece.nodes.get(interval), piece.nodes.get(interval + 1)) else {
        return [0.0; 2];
    };
    let t = (s - from.s) / (to.s - from.s);
    let at = |from: f64, to: f64| from + t * (to - from);
    [at(from.feed_rate, to.feed_rate), at(from.tip_rate, to.tip_rate)]
}

/// `q̇ = q' v`, `q̈ = q' u + q'' v²`, `q⃛ = 3 q'' u v + q''' v³` (u constant), over the limits.
fn ratios<const N: usize>(
    q: &[SVector<f64, N>; 4],
    v: f64,
    u: f64,
    [feed_rate, tip_rate]: [f64; 2],
    limits: &Reciprocals<N>,
) -> Ratios {
    let axes = (q[1] * v).component_mul(&limits.velocity).amax();
    let point = v * (feed_rate * limits.feed).max(tip_rate * limits.tip);
    let acceleration = q[1] * u + q[2] * (v * v);
    let jerk = (q[2] * (3.0 * u) + q[3] * (v * v)) * v;
    Ratios {
        velocity: axes.max(point),
        acceleration: acceleration.component_mul(&limits.acceleration).amax(),
        jerk: limits.jerk.map(|inverse| jerk.component_mul(&inverse).amax()),
    }
}

/// Upper bounds of velocity and acceleration ratios over the whole piece.
pub(super) fn bounds<const N: usize>(
    grid: &Grid<N>,
    profile: &Profile,
    limits: &Reciprocals<N>,
) -> Ratios {
    let mut bounds = Ratios::default();
    let mut square = 0.0_f64;
    for (index, cell) in grid.cells.iter().enumerate() {
        let x = profile.ends(index);
        let strips = cell.strips(limits);
        for k in 0..5 {
            bounds.acceleration = bounds.acceleration.max(strips.coefficient(k, x).amax());
        }
        let mut speed = |rate: [f64; 2]| {
            square = square.max(peak_square(x, rate));
        };
        for axis in 0..N {
            speed(cell.speed_line(axis).map(|rate| rate * limits.velocity[axis]));
        }
        speed(cell.feed_rate.map(|rate| rate * limits.feed));
        speed(cell.tip_rate.map(|rate| rate * limits.tip));
    }
    bounds.velocity = square.sqrt();
    bounds
}

/// Maximum of `x rate²` with both linear over a cell: at an end, or where
/// `(x rate²)' = rate (x' rate + 2 x rate') = 0`.
fn peak_square(x: [f64; 2], rate: [f64; 2]) -> f64 {
    let [dx, dr] = [x[1] - x[0], rate[1] - rate[0]];
    let ends = (x[0] * rate[0] * rate[0]).max(x[1] * rate[1] * rate[1]);
    let [above, below] = [-(dx * rate[0] + 2.0 * dr * x[0]), 3.0 * dx * dr];
    // Fraction above / below strictly between 0 and 1; the division only where it is.
    if above * below > 0.0 && above.abs() < below.abs() {
        let t = above / below;
        return ends.max((x[0] + t * dx) * (rate[0] + t * dr).powi(2));
    }
    ends
}

/// What binds from each row to the next; the last entry repeats.
pub(super) fn binding<const N: usize>(
    grid: &Grid<N>,
    profile: &Profile,
    limits: &Reciprocals<N>,
) -> Vec<Binding> {
    let mut binding: Vec<Binding> = grid
        .cells
        .iter()
        .enumerate()
        .map(|(index, cell)| refine::utilisation(cell, limits, profile.ends(index)).1)
        .collect();
    binding.extend(binding.last().copied());
    binding
}
