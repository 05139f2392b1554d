//! Rows where the schedule gains from them.
//!
//! Limits hold on any grid; rows only make the schedule faster. The fastest motion uses some limit
//! fully at every point, so the unused share of a cell, times its time, measures what is to gain.

use super::cell::{FeedCell, MIDDLE};
use super::directional::DirectionalLimits;
use super::ends::EndSquares;
use super::grid::{FeedGrid, resolvable};
use super::lower_bound;
use super::numeric::largest;
use super::options::FeedOptions;
use super::profile::SpeedProfile;
use super::reciprocal::ReciprocalLimits;
use crate::types::AxisPiece;
use nalgebra::SVector;

/// Fewest cells of a piece. With one cell from rest to rest nothing would ever move, and the
/// switch from speeding up to slowing down is located by the cells on both sides of it.
pub(super) const FEWEST_CELLS: usize = 8;

/// Most rounds of inserting rows. Halving twelve times turns a cell into 1/4096 of itself.
const ROUNDS: usize = 12;

/// Most rows of a piece: so many per node, and so many at least. They bound memory and time on
/// paths that no grid makes smooth.
const ROWS_PER_NODE: usize = 4;

const ROWS_AT_LEAST: usize = 1024;

/// Cuts nearer to an end than this share of the cell are left out: neighbours that continue one
/// another meet at the end they share, or not, by rounding. Halving brings a true kink away from
/// the ends.
const MARGIN: f64 = 1.0 / 64.0;

/// Plans a piece on a grid that is refined until less than `tolerance` of the time is to gain.
pub(super) fn plan<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &ReciprocalLimits<N>,
    options: &FeedOptions,
    ends: &EndSquares,
) -> (FeedGrid<N>, SpeedProfile) {
    let tolerance = options.time_tolerance;
    let mut grid = initial(piece);
    if !options.guarantee {
        let profile = SpeedProfile::fastest_at_rows(&grid, limits, ends);
        return (grid, profile);
    }
    let mut profile = SpeedProfile::fastest(&grid, limits, ends);
    // Near the lower bound there is nothing to gain, whatever the estimate is.
    let unbeatable = if tolerance < 1.0 { lower_bound::bound(&grid, limits, ends) } else { 0.0 };
    let most = ROWS_AT_LEAST.max(ROWS_PER_NODE * piece.nodes.len());
    let mut before = f64::INFINITY;
    for _ in 0..ROUNDS {
        let gains = CellGains::of(&grid, &profile, limits);
        let [wanted, won] = [tolerance * gains.time, before - gains.time];
        // A round that brings a small part of what is asked for will not be followed by better.
        let to_gain = gains.total.min(gains.time - unbeatable);
        let enough = to_gain <= wanted;
        if enough || grid.s.len() >= most || won <= 0.05 * wanted {
            break;
        }
        before = gains.time;
        grid = split(&grid, &profile, limits, &gains, 0.5 * wanted / to_gain);
        profile = SpeedProfile::fastest(&grid, limits, ends);
    }
    (grid, profile)
}

/// Builds the first grid: the path's nodes, with even cuts where there are too few.
fn initial<const N: usize>(piece: &AxisPiece<N>) -> FeedGrid<N> {
    let intervals = piece.nodes.len().saturating_sub(1).max(1);
    let parts = FEWEST_CELLS.div_ceil(intervals);
    let mut grid = FeedGrid { s: Vec::new(), cells: Vec::with_capacity(intervals * parts) };
    grid.s.reserve(intervals * parts + 1);
    for pair in piece.nodes.windows(2) {
        let [from, to] = [&pair[0], &pair[1]];
        let mut rest = FeedCell::between(from, to);
        let whole = rest.h;
        grid.s.push(from.s);
        for part in 1..parts {
            // One even part is this share of what is left of the interval.
            let [cell, remainder] = rest.split(1.0 / (parts - part + 1) as f64);
            grid.cells.push(cell);
            grid.s.push(from.s + whole * part as f64 / parts as f64);
            rest = remainder;
        }
        grid.cells.push(rest);
    }
    grid.s.extend(piece.nodes.last().map(|node| node.s));
    grid
}

/// Time that each cell could still gain.
struct CellGains {
    cells: Vec<f64>,
    total: f64,
    time: f64,
}

impl CellGains {
    fn of<const N: usize>(
        grid: &FeedGrid<N>,
        profile: &SpeedProfile,
        limits: &ReciprocalLimits<N>,
    ) -> Self {
        let mut gains = Self { cells: Vec::with_capacity(grid.cells.len()), total: 0.0, time: 0.0 };
        for (index, cell) in grid.cells.iter().enumerate() {
            let time = profile.time(grid, index);
            let used = utilisation(cell, limits, profile.ends(index));
            let gain = time * (1.0 - used).max(0.0);
            gains.cells.push(gain);
            gains.total += gain;
            gains.time += time;
        }
        gains
    }
}

impl CellGains {
    /// Returns the gain above which cells are cut: the fewest cells that hold all but the share
    /// `rest` of the total gain. Cells that are alike but for rounding, as on a symmetric path,
    /// are all cut or none.
    fn worth_cutting(&self, rest: f64) -> f64 {
        let mut sorted = self.cells.clone();
        sorted.sort_unstable_by(|a, b| b.total_cmp(a));
        let mut left = self.total;
        for gain in sorted {
            left -= gain;
            // A little below the gain, so that cells alike but for rounding fall on one side.
            if left <= rest * self.total {
                return gain * (1.0 - f64::EPSILON.sqrt());
            }
        }
        0.0
    }
}

/// Returns the mean share of the most used limit over a cell, by its ends and middle. Shares are
/// in time: a path run at this share of the speed limits takes as many times longer.
fn utilisation<const N: usize>(
    cell: &FeedCell<N>,
    limits: &ReciprocalLimits<N>,
    x: [f64; 2],
) -> f64 {
    let [from, middle, to] = SquaredShares::of(cell, limits, x).most().map(f64::sqrt);
    // Trapezoids over both halves.
    0.25 * (from + to) + 0.5 * middle
}

/// Squares of the shares of the limits that are used at the start of a cell, in its middle and at its
/// end. Time goes with the root of the acceleration, so an acceleration's share is its root.
struct SquaredShares<const N: usize> {
    accelerations: [[f64; N]; 3],
    velocities: [[f64; N]; 3],
    feed: [f64; 3],
    tip: [f64; 3],
}

impl<const N: usize> SquaredShares<N> {
    #[inline]
    fn of(cell: &FeedCell<N>, limits: &ReciprocalLimits<N>, x: [f64; 2]) -> Self {
        // x is linear, q' a quartic whose middle is a fixed mean of its coefficients.
        let three = [x[0], 0.5 * (x[0] + x[1]), x[1]];
        let r = &cell.rates;
        let middle: [f64; N] = std::array::from_fn(|axis| {
            MIDDLE[0] * (r[0][axis] + r[4][axis])
                + MIDDLE[1] * (r[1][axis] + r[3][axis])
                + MIDDLE[2] * r[2][axis]
        });
        let velocities: [&[f64; N]; 3] = [&r[0].data.0[0], &middle, &r[4].data.0[0]];
        let accelerations = cell.accelerations(limits).at_three(x);
        let line = |[from, to]: [f64; 2], inverse: f64| -> [f64; 3] {
            let rates = [from, 0.5 * (from + to), to];
            std::array::from_fn(|k| three[k] * (rates[k] * inverse).powi(2))
        };
        Self {
            accelerations,
            velocities: std::array::from_fn(|k| {
                let share = |axis| limits.velocity.share(axis, velocities[k][axis]);
                std::array::from_fn(|axis| three[k] * share(axis).powi(2))
            }),
            feed: line(cell.feed_rate, limits.feed),
            tip: line(cell.tip_rate, limits.tip),
        }
    }

    /// Returns the largest share at each of the three points.
    #[inline]
    fn most(&self) -> [f64; 3] {
        std::array::from_fn(|k| {
            let mut most = largest(self.feed[k], self.tip[k]);
            for axis in 0..N {
                let axis = largest(self.accelerations[k][axis], self.velocities[k][axis]);
                most = largest(most, axis);
            }
            most
        })
    }
}

/// Cuts the cells with the most to gain: where the profiles of both neighbours would meet if there
/// is such a point, else in the middle.
fn split<const N: usize>(
    grid: &FeedGrid<N>,
    profile: &SpeedProfile,
    limits: &ReciprocalLimits<N>,
    gains: &CellGains,
    rest: f64,
) -> FeedGrid<N> {
    let share = gains.worth_cutting(rest);
    let mut finer = FeedGrid { s: Vec::with_capacity(grid.s.len()), cells: Vec::new() };
    for (index, cell) in grid.cells.iter().enumerate() {
        let s = grid.s[index];
        finer.s.push(s);
        let cut = kink(grid, profile, limits, index).unwrap_or(0.5);
        let middle = s + cut * cell.h;
        // No cut where rounding leaves nothing of either side.
        if gains.cells[index] > share && resolvable(s, middle, grid.s[index + 1]) {
            finer.s.push(middle);
            finer.cells.extend(cell.split(cut));
        } else {
            finer.cells.push(*cell);
        }
    }
    finer.s.extend(grid.s.last());
    finer
}

/// Returns the fraction of a cell at which the profiles of its two neighbours, continued, cross
/// above its own. At an end of the piece the fastest start from rest replaces the neighbour.
fn kink<const N: usize>(
    grid: &FeedGrid<N>,
    profile: &SpeedProfile,
    limits: &ReciprocalLimits<N>,
    index: usize,
) -> Option<f64> {
    let cell = grid.cells.get(index)?;
    // Rise of x over this cell if the profile of a neighbour went on.
    let slope = |neighbour: usize| {
        let [from, to] = profile.ends(neighbour);
        grid.cells.get(neighbour).map(|other| (to - from) * cell.h / other.h)
    };
    let from_rest = |rates: &SVector<f64, N>, sides: [&SVector<f64, N>; 2]| {
        let share =
            |axis: usize| largest(rates[axis] * sides[0][axis], -rates[axis] * sides[1][axis]);
        2.0 * cell.h / (0..N).map(share).fold(0.0, f64::max)
    };
    // From rest x rises by at most 2 a h / q' on the axis that allows least; braking to rest takes the
    // limits of the other direction.
    let DirectionalLimits { plus, minus } = &limits.acceleration;
    let rise = match index.checked_sub(1) {
        Some(before) => slope(before)?,
        None => from_rest(&cell.rates[0], [plus, minus]),
    };
    let last = index + 1 == grid.cells.len();
    let fall = if last { -from_rest(&cell.rates[4], [minus, plus]) } else { slope(index + 1)? };
    let [from, to] = profile.ends(index);
    let own = to - from;
    // Both neighbours must lie above: steeper before, steeper downwards after. Then this is in 0..1.
    let cut = (own - fall) / (rise - fall);
    // On a straight stretch of the profile the three differ by rounding alone.
    let straight = rise - fall <= f64::EPSILON.sqrt() * from.max(to);
    let above = rise > own && own > fall && !straight;
    (above && (MARGIN..=1.0 - MARGIN).contains(&cut)).then_some(cut)
}
