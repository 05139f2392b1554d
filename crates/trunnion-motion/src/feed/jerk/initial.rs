//! A profile inside all limits to start from, within a small factor of the fastest everywhere.
//!
//! In `y = x^(3/4)` constant jerk from rest is a straight line, so a steady speed that some point
//! allows may grow from there along a line of limited slope: two passes make the largest profile
//! below all of them. Its kinks are then rounded off by means over a share of the distance in which it
//! could have come to rest, which bounds the jerk they need. What still breaks a limit is lowered at
//! its place a few times, then everywhere: every profile that is slow enough keeps all limits.

use super::rows::{CellRows, reference};
use super::speed_caps::SpeedCaps;
use super::speed_spline::{EndMotion, SpeedSpline};
use crate::feed::grid::FeedGrid;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::math;
use nalgebra::SVector;

/// Share of each limit that the start aims at.
const SHARE: f64 = 0.5;
/// Share of speed limits where an end moves: it may well do so at its limit.
const CAP_SHARE: f64 = 0.97;
/// Share of the limits after the last resort.
const AT_MOST: f64 = 0.9;
/// Slopes are this much below that of constant jerk at the limit: half is for rounding off kinks.
const GENTLE: f64 = 1.0 / 3.0;
/// Half-widths of the means, as a share of the distance to rest.
const WIDTHS: [f64; 2] = [0.4, 0.2];
/// Most rounds of lowering the cells that break a limit.
const ROUNDS: usize = 6;

/// Limits of `y = x^(3/4)` in a cell.
#[derive(Debug, Clone, Copy)]
struct GrowthBound {
    /// Its value.
    steady: f64,
    /// `dy/ds` from jerk.
    slope: f64,
    /// `y^(1/3) dy/ds` from acceleration.
    by_acceleration: f64,
    /// `y dy/ds` from the jerk of a curved path.
    by_curvature: f64,
}

/// Returns `x^(3/4)` by roots, which are exact everywhere and cost less than a power.
fn three_quarters(x: f64) -> f64 {
    let root = x.sqrt();
    root * root.sqrt()
}

impl GrowthBound {
    /// Returns the largest `dy/ds` at `y`.
    fn growth(&self, y: f64) -> f64 {
        self.slope.min(self.by_acceleration / math::cbrt(y)).min(self.by_curvature / y)
    }
}

/// Computes the controls of a feasible spline from rest to rest; near one where an end moves.
pub(super) fn feasible<const N: usize>(
    grid: &FeedGrid<N>,
    limits: &ReciprocalLimits<N>,
    caps: &SpeedCaps,
    spline: &mut SpeedSpline,
) {
    let moving = spline.ends.iter().any(EndMotion::moves);
    let of_cap = if moving { CAP_SHARE } else { SHARE };
    let mut bounds: Vec<GrowthBound> =
        (0..grid.cells.len()).map(|cell| bound(grid, limits, caps, of_cap, cell)).collect();
    for round in 0..=ROUNDS {
        // Step 1: the largest profile below all lines. Step 2: round off its kinks.
        let y = envelope(grid, &bounds, &spline.ends);
        let y = WIDTHS.iter().fold(y, |y, share| smooth(grid, &bounds, &y, *share));
        let controls = y.iter().map(|y| math::cbrt(*y).powi(4)).collect();
        *spline = SpeedSpline::new(std::mem::take(&mut spline.lengths), controls, spline.ends);
        // Step 3: lower the cells that break a limit, and at last all of them.
        let excess = excess(grid, limits, caps, spline);
        let worst = excess.iter().copied().fold(0.0, f64::max);
        if worst <= AT_MOST || moving {
            return;
        }
        if round == ROUNDS {
            // NaN would need a NaN in the path, which is refused.
            let scale = AT_MOST / worst;
            spline.controls.iter_mut().for_each(|control| *control *= scale);
            return;
        }
        for (bound, excess) in bounds.iter_mut().zip(excess) {
            if excess > AT_MOST {
                bound.steady *= three_quarters(SHARE / excess);
                let gentler = (SHARE / excess).sqrt();
                bound.slope *= gentler;
                bound.by_acceleration *= gentler;
                bound.by_curvature *= gentler;
            }
        }
    }
}

/// Returns the limits of `y` in one cell; `of_cap` is the share of speed limits to aim at.
fn bound<const N: usize>(
    grid: &FeedGrid<N>,
    limits: &ReciprocalLimits<N>,
    caps: &SpeedCaps,
    of_cap: f64,
    index: usize,
) -> GrowthBound {
    let cell = &grid.cells[index];
    let jerk = limits.jerk.unwrap_or_else(SVector::zeros);
    let [mut rate, mut brisk, mut bend] = [0.0_f64; 3];
    for k in 0..5 {
        rate = rate.max(cell.rates[k].component_mul(&limits.acceleration.plus).amax());
        brisk = brisk.max(cell.rates[k].component_mul(&jerk).amax());
        if k < 4 {
            // Bernstein coefficients of q'': 4 D / h.
            let rise = (cell.rates[k + 1] - cell.rates[k]).component_mul(&jerk);
            bend = bend.max(4.0 / cell.h * rise.amax());
        }
    }
    let [accelerations, jerks] = CellRows::new(cell, limits).shares([1.0; 3], 1.0);
    let cap = caps.control[index].min(caps.row[index]).min(caps.row[index + 1]);
    // At constant x accelerations go with x, jerks with x^(3/2).
    let steady = (of_cap * cap).min(SHARE / accelerations).min(math::cbrt(SHARE / jerks).powi(2));
    GrowthBound {
        steady: three_quarters(steady),
        // Constant jerk from rest: 2/9 q' (dy/ds)² = J.
        slope: GENTLE * (4.5 / brisk).sqrt(),
        // u = 2/3 y^(1/3) y' and 3 q'' u v: a third of the limits.
        by_acceleration: 0.5 / rate,
        by_curvature: 1.0 / (6.0 * bend),
    }
}

/// Returns the largest `y` per cell below its own bound and all lines from others. Where an end
/// moves, `y` starts above its bound and comes down along such a line.
fn envelope<const N: usize>(
    grid: &FeedGrid<N>,
    bounds: &[GrowthBound],
    ends: &[EndMotion; 2],
) -> Vec<f64> {
    let mut y: Vec<f64> = bounds.iter().map(|bound| bound.steady).collect();
    let last = y.len() - 1;
    for (end, motion) in [0, last].into_iter().zip(ends) {
        y[end] = match motion {
            EndMotion::Rest => y[end].min(0.5 * grid.cells[end].h * bounds[end].slope),
            EndMotion::Moving([x, _]) => three_quarters(*x),
        };
    }
    let mut pass = |from: usize, to: usize| {
        let distance = 0.5 * (grid.cells[from].h + grid.cells[to].h);
        // Growth allowed by both cells, at the lower end of the line.
        let growth = bounds[from].growth(y[from]).min(bounds[to].growth(y[from]));
        y[to] = y[to].min(y[from] + distance * growth);
    };
    (0..last).for_each(|cell| pass(cell, cell + 1));
    (0..last).rev().for_each(|cell| pass(cell + 1, cell));
    let mut down = |cells: &mut dyn Iterator<Item = usize>, motion: &EndMotion| {
        let EndMotion::Moving([x, _]) = motion else { return };
        let mut line = three_quarters(*x);
        let mut left = grid.s[last + 1] - grid.s[0];
        for cell in cells {
            if line <= y[cell] {
                break;
            }
            y[cell] = line;
            // Steeper where the path would end before.
            let h = grid.cells[cell].h;
            line -= h * bounds[cell].growth(line).max(line / left);
            left -= h;
        }
    };
    down(&mut (0..=last), &ends[0]);
    down(&mut (0..=last).rev(), &ends[1]);
    y
}

/// Returns means over `share` of the distance in which `y` could have come to rest.
fn smooth<const N: usize>(
    grid: &FeedGrid<N>,
    bounds: &[GrowthBound],
    y: &[f64],
    share: f64,
) -> Vec<f64> {
    let middle = |cell: usize| grid.s[cell] + 0.5 * grid.cells[cell].h;
    let last = y.len() - 1;
    let mut width: Vec<f64> = (0..y.len())
        .map(|cell| {
            let to_end = (middle(cell) - grid.s[0]).min(grid.s[last + 1] - middle(cell));
            share * to_end.min(y[cell] / bounds[cell].slope)
        })
        .collect();
    let mut pass = |from: usize, to: usize| {
        // Widths change slower than the middles, so the ends of the means keep their order.
        width[to] = width[to].min(width[from] + share * (middle(to) - middle(from)).abs());
    };
    (0..last).for_each(|cell| pass(cell, cell + 1));
    (0..last).rev().for_each(|cell| pass(cell + 1, cell));
    // Integral of the piecewise constant y: each mean is a difference of two of its values.
    let mut area = vec![0.0];
    for (cell, y) in grid.cells.iter().zip(y) {
        area.push(area.last().copied().unwrap_or(0.0) + cell.h * y);
    }
    let area_to = |s: f64, hint: &mut usize| {
        while *hint < last && grid.s[*hint + 1] < s {
            *hint += 1;
        }
        area[*hint] + (s - grid.s[*hint]) * y[*hint]
    };
    let mut hints = [0; 2];
    (0..y.len())
        .map(|cell| {
            let half = width[cell].max(0.5 * grid.cells[cell].h);
            let [from, to] = [middle(cell) - half, middle(cell) + half];
            (area_to(to, &mut hints[1]) - area_to(from, &mut hints[0])) / (to - from)
        })
        .collect()
}

/// Returns for each cell the factor by which `x` would have to be divided to keep its limits.
fn excess<const N: usize>(
    grid: &FeedGrid<N>,
    limits: &ReciprocalLimits<N>,
    caps: &SpeedCaps,
    spline: &SpeedSpline,
) -> Vec<f64> {
    let inner = spline.cells();
    let excess = inner.clone().map(|cell| {
        let x = spline.coefficients(cell);
        let [acceleration, jerk] = CellRows::new(&grid.cells[cell], limits).shares(x, reference(x));
        let speed = (x[1] / caps.control[cell]).max(x[2] / caps.row[cell + 1]);
        // Accelerations go with x, jerks with x^(3/2).
        acceleration.max(math::cbrt(jerk).powi(2)).max(speed)
    });
    // Rest cells are limited by the controls next to them.
    let [before, after] = [inner.start, grid.cells.len() - inner.end];
    let none = |count: usize| std::iter::repeat_n(0.0, count);
    none(before).chain(excess).chain(none(after)).collect()
}
