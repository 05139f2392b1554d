//! A time no schedule within the limits can beat.
//!
//! Everything here is an inequality that *every* valid motion between the given end speeds obeys, evaluated so
//! that rounding and coarse cells only make the bound smaller:
//! * speed of an axis whose direction does not change in a cell: `q̇²` grows by at most `2 a |dq|`;
//! * two axes at one place: eliminating `u` from `|s_j u + c_j x| <= a_j` and
//!   `|s_k u + c_k x| <= a_k` leaves `x <= (a_j |s_k| + a_k |s_j|) / |s_j c_k - s_k c_j|`;
//! * speed limits, integrated over the cell: `dt >= |dq_j| / v_j`.

use super::cell::Cell;
use super::profile::Grid;
use super::{Ends, Reciprocals};
use nalgebra::SVector;

/// Lower bound of the time with the given speeds at the ends \[s\].
pub(super) fn bound<const N: usize>(grid: &Grid<N>, limits: &Reciprocals<N>, ends: &Ends) -> f64 {
    let x = reachable(grid, limits, ends);
    let cells = grid.cells.iter().enumerate();
    let sum: f64 = cells.map(|(i, cell)| cell_time(cell, [x[i], x[i + 1]], limits)).sum();
    // Each cell's time is right to a few dozen roundings, their sum to one per cell.
    sum * (1.0 - (grid.cells.len() + 64) as f64 * f64::EPSILON)
}

/// Upper bounds of `x` at the rows.
fn reachable<const N: usize>(grid: &Grid<N>, limits: &Reciprocals<N>, ends: &Ends) -> Vec<f64> {
    let mut x: Vec<f64> = grid.cells.iter().map(|cell| start_cap(cell, limits)).collect();
    x.push(ends.end);
    if let Some(first) = x.first_mut() {
        *first = ends.start;
    }
    for (row, cell) in grid.cells.iter().enumerate() {
        x[row + 1] = x[row + 1].min(gain(cell, x[row], limits, [0, 4]));
    }
    for (row, cell) in grid.cells.iter().enumerate().rev() {
        x[row] = x[row].min(gain(cell, x[row + 1], limits, [4, 0]));
    }
    x
}

/// Largest `x` at the start of a cell, whatever happens elsewhere.
fn start_cap<const N: usize>(cell: &Cell<N>, limits: &Reciprocals<N>) -> f64 {
    let speeds = cell.rates[0].component_mul(&limits.velocity).amax();
    let point = (cell.feed_rate[0] * limits.feed).max(cell.tip_rate[0] * limits.tip);
    speeds.max(point).powi(-2).min(pair_cap(cell.rates_at(0.0), &cell.blur(), limits))
}

/// The two-axis cap at one place: the intervals of `u` of all axes share a point iff those of any
/// two do (Helly's theorem on a line), so it is the exact largest `x`; where `c` is only known to within
/// `blur`, nothing above it.
pub(super) fn pair_cap<const N: usize>(
    [s, c]: [SVector<f64, N>; 2],
    blur: &SVector<f64, N>,
    limits: &Reciprocals<N>,
) -> f64 {
    let [s, c, blur] = [s, c, *blur].map(|rate| rate.component_mul(&limits.acceleration));
    let mut cap = f64::INFINITY;
    for j in 0..N {
        // An axis that only turns round: no u helps it.
        if s[j] == 0.0 && c[j].abs() > blur[j] {
            cap = cap.min(1.0 / (c[j].abs() - blur[j]));
        }
        for k in 0..j {
            let doubt = s[j].abs() * blur[k] + s[k].abs() * blur[j];
            let cross = (s[j] * c[k] - s[k] * c[j]).abs() - doubt;
            let room = s[j].abs() + s[k].abs();
            if cap * cross > room {
                cap = room / cross;
            }
        }
    }
    cap
}

/// Upper bound of `x` at end `to` of a cell from the one at end `from` (0 is the start, 4 the end).
fn gain<const N: usize>(
    cell: &Cell<N>,
    x: f64,
    limits: &Reciprocals<N>,
    [from, to]: [usize; 2],
) -> f64 {
    let mut bound = f64::INFINITY;
    for axis in 0..N {
        let Some(travel) = one_way_travel(cell, axis) else { continue };
        let [start, end] = [cell.rates[from][axis], cell.rates[to][axis]].map(|rate| rate * rate);
        if end > 0.0 {
            let energy = start * x + 2.0 * travel / limits.acceleration[axis];
            bound = bound.min(energy / end);
        }
    }
    bound
}

/// Distance an axis travels in a cell, if all coefficients of its rate agree in direction.
fn one_way_travel<const N: usize>(cell: &Cell<N>, axis: usize) -> Option<f64> {
    let rates = cell.rates.map(|rate| rate[axis]);
    let one_way = rates.iter().all(|&rate| rate >= 0.0) || rates.iter().all(|&rate| rate <= 0.0);
    one_way.then(|| cell.h * rates.iter().sum::<f64>().abs() / 5.0)
}

/// Lower bound of the time in a cell whose ends are passed with at most the given `x`.
fn cell_time<const N: usize>(cell: &Cell<N>, x: [f64; 2], limits: &Reciprocals<N>) -> f64 {
    let mean = |rate: [f64; 2]| 0.5 * (rate[0] + rate[1]);
    let point = (mean(cell.feed_rate) * limits.feed).max(mean(cell.tip_rate) * limits.tip);
    let mut time = cell.h * point;
    for axis in 0..N {
        let speed = |end: usize| x[end.min(1)].sqrt() * cell.rates[end * 4][axis].abs();
        let [v, a] = [1.0 / limits.velocity[axis], 1.0 / limits.acceleration[axis]];
        let axis_time = match one_way_travel(cell, axis) {
            Some(travel) => ramp_time(travel, [speed(0), speed(1)], v, a),
            None => cell.h * cell.rates.iter().map(|rate| rate[axis]).sum::<f64>().abs() / 5.0 / v,
        };
        time = time.max(axis_time);
    }
    // The two-axis cap of the whole cell costs most: only where the one in the middle says it helps.
    let middle = pair_cap(cell.rates_at(0.5), &cell.blur(), limits);
    if cell.h > time * middle.sqrt() {
        time = time.max(cell.h / cell_pair_cap(cell, limits).sqrt());
    }
    time
}

/// Shortest time over `distance` with at most the given end speeds, speed limit and acceleration.
fn ramp_time(distance: f64, ends: [f64; 2], v: f64, a: f64) -> f64 {
    if distance <= 0.0 {
        return 0.0;
    }
    let square = ends.map(|end| end.min(v).powi(2));
    let gain = 2.0 * a * distance;
    let [from, to] = [square[0].min(square[1] + gain), square[1].min(square[0] + gain)];
    let peak = (0.5 * (from + to + gain)).min(v * v);
    let ramps = (2.0 * peak - from - to) / (2.0 * a);
    let top = peak.sqrt();
    // (p - from) / (sqrt p + sqrt from) = sqrt p - sqrt from without cancellation.
    let ramp = |end: f64| (peak - end).max(0.0) / (a * (top + end.sqrt()));
    ramp(from) + ramp(to) + (distance - ramps).max(0.0) / top
}

/// Upper bound of the two-axis cap over a whole cell, from Bernstein coefficients.
fn cell_pair_cap<const N: usize>(cell: &Cell<N>, limits: &Reciprocals<N>) -> f64 {
    let s = cell.rates.map(|rate| rate.component_mul(&limits.acceleration));
    let blur = cell.blur().component_mul(&limits.acceleration);
    let largest = |axis: usize| s.iter().map(|rate| rate[axis].abs()).fold(0.0, f64::max);
    let mut cap = f64::INFINITY;
    for j in 0..N {
        for k in 0..j {
            let doubt = largest(j) * blur[k] + largest(k) * blur[j];
            let cross = smallest_cross(&s.map(|rate| [rate[j], rate[k]]), cell.h) - doubt;
            let room = largest(j) + largest(k);
            if cap * cross > room {
                cap = room / cross;
            }
        }
    }
    cap
}

/// Lower bound of `|s_j c_k - s_k c_j|` over a cell: the smallest Bernstein coefficient of this
/// polynomial of degree 7, or 0 if they differ in sign.
fn smallest_cross(s: &[[f64; 2]; 5], h: f64) -> f64 {
    const CHOOSE_4: [f64; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];
    const CHOOSE_3: [f64; 4] = [1.0, 3.0, 3.0, 1.0];
    const CHOOSE_7: [f64; 8] = [1.0, 7.0, 21.0, 35.0, 35.0, 21.0, 7.0, 1.0];
    let mut product = [0.0; 8];
    for (i, [sj, sk]) in s.iter().enumerate() {
        for l in 0..4 {
            let [cj, ck] = [s[l + 1][0] - s[l][0], s[l + 1][1] - s[l][1]];
            product[i + l] += CHOOSE_4[i] * CHOOSE_3[l] * (sj * ck - sk * cj);
        }
    }
    let coefficients = product.iter().zip(CHOOSE_7).map(|(sum, choose)| sum / choose);
    let [low, high] = coefficients
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)]);
    4.0 / h * low.max(-high).max(0.0)
}
