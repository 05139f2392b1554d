//! A time no schedule within the limits can beat.
//!
//! Everything here is an inequality that *every* valid motion between the given end speeds obeys, evaluated so
//! that rounding and coarse cells only make the bound smaller:
//! * speed of an axis whose direction does not change in a cell: `q̇²` grows by at most `2 a |dq|`;
//! * two axes at one place: eliminating `u` from `|s_j u + c_j x| <= a_j` and
//!   `|s_k u + c_k x| <= a_k` leaves `x <= (a_j |s_k| + a_k |s_j|) / |s_j c_k - s_k c_j|`;
//! * speed limits, integrated over the cell: `dt >= |dq_j| / v_j`.

use super::cell::FeedCell;
use super::ends::EndSquares;
use super::grid::FeedGrid;
use super::numeric::largest;
use super::reciprocal::ReciprocalLimits;
use nalgebra::SVector;

/// Returns a lower bound of the time with the given speeds at the ends \[s\].
pub(super) fn bound<const N: usize>(
    grid: &FeedGrid<N>,
    limits: &ReciprocalLimits<N>,
    ends: &EndSquares,
) -> f64 {
    // A bound for the larger limit of both directions is a bound for both.
    let limits = &ReciprocalLimits { acceleration: limits.acceleration.loosest(), ..*limits };
    // Step 1: upper bounds of x at the rows, forwards from the start.
    let x = reachable(grid, limits, ends);
    // Step 2: lower them backwards from the end, and add up the time of each cell.
    let mut sum = 0.0;
    let mut ahead = x.last().map_or(0.0, |x| x.min(ends.end));
    let mut to = ahead.sqrt();
    for (cell, here) in grid.cells.iter().zip(&x).rev() {
        let travel = AxisTravel::of(cell, limits);
        let here = travel.gain(ahead, *here, [1, 0]);
        let from = here.sqrt();
        sum += cell_time(cell, &travel, [here, ahead], [from, to], limits);
        (ahead, to) = (here, from);
    }
    // Each cell's time is right to a few dozen roundings, their sum to one per cell.
    sum * (1.0 - (grid.cells.len() + 64) as f64 * f64::EPSILON)
}

/// Returns upper bounds of `x` at the rows, going forwards.
fn reachable<const N: usize>(
    grid: &FeedGrid<N>,
    limits: &ReciprocalLimits<N>,
    ends: &EndSquares,
) -> Vec<f64> {
    let mut x = Vec::with_capacity(grid.cells.len() + 1);
    let mut here = ends.start;
    for cell in &grid.cells {
        // Speed limits, then the two-axis cap where it can be lower.
        let cap = speed_cap(cell, limits);
        here = if cap < here { cap } else { here };
        if bent(&[cell.rates[0], cell.bend_at_start()], &cell.blur(), limits, here) {
            let pairs = pair_cap([cell.rates[0], cell.bend_at_start()], &cell.blur(), limits);
            here = here.min(pairs);
        }
        x.push(here);
        here = AxisTravel::of(cell, limits).gain(here, f64::INFINITY, [0, 1]);
    }
    x.push(here);
    x
}

/// Returns the largest `x` at the start of a cell by the speed limits.
#[inline]
fn speed_cap<const N: usize>(cell: &FeedCell<N>, limits: &ReciprocalLimits<N>) -> f64 {
    let mut most = largest(cell.feed_rate[0] * limits.feed, cell.tip_rate[0] * limits.tip);
    for axis in 0..N {
        most = largest(limits.velocity.share(axis, cell.rates[0][axis]), most);
    }
    1.0 / (most * most)
}

/// Travel of each axis in a cell.
struct AxisTravel<const N: usize> {
    /// Squared rates at both ends over the acceleration limit.
    squares: [[f64; N]; 2],
    /// Twice the distance; infinite for an axis that may reverse, which bounds nothing then.
    twice: [f64; N],
    /// Signed travel from one end to the other, and its size.
    signed: [f64; N],
    net: [f64; N],
}

impl<const N: usize> AxisTravel<N> {
    #[inline]
    fn of(cell: &FeedCell<N>, limits: &ReciprocalLimits<N>) -> Self {
        let mut travel =
            Self { squares: [[0.0; N]; 2], twice: [0.0; N], signed: [0.0; N], net: [0.0; N] };
        // The integral of a quartic is the mean of its Bernstein coefficients times the length.
        let share = 0.2 * cell.h;
        for axis in 0..N {
            let rate = |k: usize| cell.rates[k][axis];
            let sum = (rate(0) + rate(1)) + (rate(2) + rate(3)) + rate(4);
            let sizes =
                (rate(0).abs() + rate(1).abs()) + (rate(2).abs() + rate(3).abs()) + rate(4).abs();
            travel.signed[axis] = share * sum;
            travel.net[axis] = share * sum.abs();
            // The same sum where all rates agree in direction, to the last bit.
            let one_way = sum.abs() >= sizes;
            travel.twice[axis] = if one_way { 2.0 * travel.net[axis] } else { f64::INFINITY };
            let inverse = limits.acceleration.plus[axis];
            travel.squares[0][axis] = rate(0) * rate(0) * inverse;
            travel.squares[1][axis] = rate(4) * rate(4) * inverse;
        }
        travel
    }

    /// Returns an upper bound of `x` at end `to` of the cell from the one at end `from`; at most
    /// `most`.
    #[inline]
    fn gain(&self, x: f64, most: f64, [from, to]: [usize; 2]) -> f64 {
        // (q' v)² grows by 2 a |dq| at most: x_to <= (r_from² x + 2 a dq) / r_to².
        let mut bound = most;
        for axis in 0..N {
            let energy = self.squares[from][axis] * x + self.twice[axis];
            let end = self.squares[to][axis];
            // The quotient only where it is less than the bound.
            if bound * end > energy {
                bound = energy / end;
            }
        }
        bound
    }

    /// Returns the axis that needs longest, judged by its largest possible speed half-way from
    /// either end: the one with the least `x` there.
    #[inline]
    fn slowest(&self, x: [f64; 2], limits: &ReciprocalLimits<N>) -> Option<usize> {
        let [mut least, mut weight] = [f64::INFINITY, 1.0];
        let mut slowest = None;
        for axis in 0..N {
            let [from, to] = [0, 1].map(|end| self.squares[end][axis] * x[end]);
            let energy = (if from < to { from } else { to }) + 0.5 * self.twice[axis];
            let square = self.net[axis] * self.net[axis] * limits.acceleration.plus[axis];
            // Quotients compared as products.
            if energy * weight < least * square {
                (least, weight, slowest) = (energy, square, Some(axis));
            }
        }
        slowest
    }
}

/// Returns `true` if the two-axis cap at one point is below `x`, up to rounding.
#[inline]
fn bent<const N: usize>(
    [s, c]: &[SVector<f64, N>; 2],
    blur: &SVector<f64, N>,
    limits: &ReciprocalLimits<N>,
    x: f64,
) -> bool {
    let inverse = &limits.acceleration.plus;
    let s: [f64; N] = std::array::from_fn(|axis| s[axis] * inverse[axis]);
    let c: [f64; N] = std::array::from_fn(|axis| c[axis] * inverse[axis]);
    // Where no centripetal term alone is at its limit, no two are: x |s_j c_k| <= |s_j|.
    if c.iter().fold(0.0, |most, c| largest(c.abs(), most)) * x <= 1.0 {
        return false;
    }
    let mut above = f64::NEG_INFINITY;
    for j in 0..N {
        for k in 0..j {
            let cross = (s[j] * c[k] - s[k] * c[j]).abs();
            above = largest(x * cross - (s[j].abs() + s[k].abs()), above);
        }
        // An axis that only turns round.
        if s[j] == 0.0 && x * (c[j].abs() - blur[j] * inverse[j]) > 1.0 {
            return true;
        }
    }
    above > 0.0
}

/// Returns the two-axis cap at one point. The intervals of `u` of all axes share a point if and
/// only if those of any two do (Helly's theorem on a line), so the cap is the exact largest `x`.
/// Where `c` is only known to within `blur`, nothing above it.
pub(super) fn pair_cap<const N: usize>(
    [s, c]: [SVector<f64, N>; 2],
    blur: &SVector<f64, N>,
    limits: &ReciprocalLimits<N>,
) -> f64 {
    let sides = &limits.acceleration;
    let [s, c, blur] = [s, c, *blur].map(|rate| rate.component_mul(&sides.plus));
    // Turned so that the axis moves towards plus: its rate, its bend, its limits ahead and behind.
    let turned = |axis: usize| {
        let minus = sides.plus[axis] / sides.minus[axis];
        if s[axis] < 0.0 {
            ([-s[axis], -c[axis]], [minus, 1.0])
        } else {
            ([s[axis], c[axis]], [1.0, minus])
        }
    };
    let mut cap = f64::INFINITY;
    for j in 0..N {
        let ([sj, cj], limit) = turned(j);
        // An axis that only turns round: no u helps it.
        if sj == 0.0 && cj.abs() > blur[j] {
            cap = cap.min(limit[usize::from(cj < 0.0)] / (cj.abs() - blur[j]));
        }
        for k in 0..j {
            let ([sk, ck], other) = turned(k);
            let cross = sk * cj - sj * ck;
            // Axis j needs less u than axis k, or the other way round.
            let room = if cross > 0.0 {
                limit[0] * sk + other[1] * sj
            } else {
                other[0] * sj + limit[1] * sk
            };
            let cross = cross.abs() - (sj * blur[k] + sk * blur[j]);
            if cap * cross > room {
                cap = room / cross;
            }
        }
    }
    cap
}

/// Returns a lower bound of the time in a cell whose ends are passed with at most the given `x`
/// and `ds/dt`.
#[inline]
fn cell_time<const N: usize>(
    cell: &FeedCell<N>,
    travel: &AxisTravel<N>,
    squares: [f64; 2],
    ends: [f64; 2],
    limits: &ReciprocalLimits<N>,
) -> f64 {
    // Speed limits: mean rates of the programmed point and tip, travel of each axis.
    let mean = |rate: [f64; 2]| 0.5 * (rate[0] + rate[1]);
    let mut time =
        cell.h * largest(mean(cell.feed_rate) * limits.feed, mean(cell.tip_rate) * limits.tip);
    for axis in 0..N {
        time = largest(limits.velocity.share(axis, travel.signed[axis]), time);
    }
    // Acceleration: the slowest axis from its end speeds over its travel.
    if let Some(axis) = travel.slowest(squares, limits) {
        let speeds = [0, 1].map(|end| ends[end] * cell.rates[end * 4][axis].abs());
        let v = travel.net[axis] / limits.velocity.share(axis, travel.signed[axis]);
        let a = 1.0 / limits.acceleration.plus[axis];
        time = largest(ramp_time(travel.net[axis], speeds, v, a), time);
    }
    // The two-axis cap of the whole cell is expensive: only where the one in the middle is below
    // x.
    let x = (cell.h / time).powi(2);
    if bent(&cell.rates_in_the_middle(), &cell.blur(), limits, x) {
        time = time.max(cell.h / cell_pair_cap(cell, limits).sqrt());
    }
    time
}

/// Returns the shortest time over `distance` with at most the given end speeds, speed limit and
/// acceleration.
fn ramp_time(distance: f64, ends: [f64; 2], v: f64, a: f64) -> f64 {
    if distance <= 0.0 {
        return 0.0;
    }
    // Trapezoid or triangle: the peak is where both ramps meet, or the speed limit.
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

/// Returns an upper bound of the two-axis cap over a whole cell, from Bernstein coefficients.
fn cell_pair_cap<const N: usize>(cell: &FeedCell<N>, limits: &ReciprocalLimits<N>) -> f64 {
    let s = cell.rates.map(|rate| rate.component_mul(&limits.acceleration.plus));
    let blur = cell.blur().component_mul(&limits.acceleration.plus);
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

/// Returns a lower bound of `|s_j c_k - s_k c_j|` over a cell: the smallest Bernstein coefficient
/// of this polynomial of degree 7, or 0 if they differ in sign.
fn smallest_cross(s: &[[f64; 2]; 5], h: f64) -> f64 {
    const CHOOSE_4: [f64; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];
    const CHOOSE_3: [f64; 4] = [1.0, 3.0, 3.0, 1.0];
    const CHOOSE_7: [f64; 8] = [1.0, 7.0, 21.0, 35.0, 35.0, 21.0, 7.0, 1.0];
    // Product in Bernstein form: weighted by the binomials of both factors, divided by those of
    // degree 7.
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
