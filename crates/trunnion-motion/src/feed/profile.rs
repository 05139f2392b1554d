//! Backward and forward pass over one piece.

use super::accelerations::CellAccelerations;
use super::cell::FeedCell;
use super::cell_program::{WarmStart, backward, forward};
use super::ends::EndSquares;
use super::error::FeedError;
use super::grid::FeedGrid;
use super::numeric::largest;
use super::reciprocal::ReciprocalLimits;
use crate::types::{AccelerationProfile, AxisNode, SchedulePiece};

/// Squared speed `x = (ds/dt)²` at each row, linear in between.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpeedProfile {
    pub(super) x: Vec<f64>,
    /// Upper bound of the accelerations over their limits, where the passes give it for free.
    pub(super) acceleration: Option<f64>,
}

impl SpeedProfile {
    /// Returns the fastest profile: the backward pass finds the speeds from which the path can
    /// still be kept, the forward pass runs as fast as these allow. Ends are slower than asked for
    /// where that is impossible.
    pub(super) fn fastest<const N: usize>(
        grid: &FeedGrid<N>,
        limits: &ReciprocalLimits<N>,
        ends: &EndSquares,
    ) -> Self {
        let caps = caps(grid, |cell| cell.caps(limits));
        Self::through::<N, 5, _>(grid, caps, ends, limits)
    }

    /// Returns the fastest profile by the limits at rows alone: the interpolation scheme of
    /// TOPP-RA.
    pub(super) fn fastest_at_rows<const N: usize>(
        grid: &FeedGrid<N>,
        limits: &ReciprocalLimits<N>,
        ends: &EndSquares,
    ) -> Self {
        let caps = caps(grid, |cell| cell.end_caps(limits));
        Self::through::<N, 2, _>(grid, caps, ends, limits)
    }

    /// Returns the same on the nodes themselves.
    pub(super) fn fastest_at_nodes<const N: usize>(
        nodes: &[AxisNode<N>],
        limits: &ReciprocalLimits<N>,
        ends: &EndSquares,
    ) -> Self {
        let caps = nodes.iter().map(|node| {
            let mut most = largest(node.feed_rate * limits.feed, node.tip_rate * limits.tip);
            for axis in 0..N {
                most = largest(most, limits.velocity.share(axis, node.q[1][axis]));
            }
            // rate sqrt(x) <= limit for the largest of rate / limit.
            1.0 / (most * most)
        });
        let mut caps: Vec<f64> = caps.collect();
        cap_still(&mut caps);
        Self::through::<N, 2, _>(nodes, caps, ends, limits)
    }

    /// Runs both passes below `x`, with `K` constraints an axis and cell.
    fn through<const N: usize, const K: usize, C: ConstraintSource<N> + ?Sized>(
        cells: &C,
        mut x: Vec<f64>,
        ends: &EndSquares,
        limits: &ReciprocalLimits<N>,
    ) -> Self {
        if let Some(last) = x.last_mut() {
            *last = last.min(ends.end);
        }
        let mut guess = WarmStart::default();
        // Backward pass: the largest x at each row from which the next row can be reached.
        for row in (0..cells.count()).rev() {
            let cell = cells.accelerations(row, limits);
            x[row] = backward::<N, K>(&cell, x[row], x[row + 1], &mut guess).0;
        }
        if let Some(first) = x.first_mut() {
            *first = first.min(ends.start);
        }
        // Forward pass: the largest x at the next row that this row can reach.
        guess = WarmStart::default();
        let mut bound = 0.0;
        for row in 0..cells.count() {
            let cell = cells.accelerations(row, limits);
            let (next, most) = forward::<N, K>(&cell, x[row], x[row + 1], &mut guess);
            x[row + 1] = next;
            bound = largest(most, bound);
        }
        // Values at rows alone bound nothing in between.
        Self { x, acceleration: (K == 5).then_some(bound) }
    }

    /// Checks that the profile has the end speeds asked for; it has lower ones where those are
    /// impossible.
    ///
    /// # Errors
    ///
    /// [`FeedError::StartTooFast`] or [`FeedError::EndTooFast`], with the largest possible speed.
    pub(super) fn check_ends(&self, ends: &EndSquares) -> Result<(), FeedError> {
        // Half of a speed's digits: passes lose a few roundings a row.
        let short = |wanted: f64, got: f64| got < wanted * (1.0 - f64::EPSILON.sqrt());
        let [first, last] = [self.x.first(), self.x.last()].map(|x| x.map_or(0.0, |x| *x));
        if short(ends.start, first) {
            return Err(FeedError::StartTooFast { speed: ends.start.sqrt(), most: first.sqrt() });
        }
        if short(ends.end, last) {
            return Err(FeedError::EndTooFast { speed: ends.end.sqrt(), most: last.sqrt() });
        }
        Ok(())
    }

    /// Returns `x` at both ends of a cell.
    pub(super) fn ends(&self, cell: usize) -> [f64; 2] {
        [self.x[cell], self.x[cell + 1]]
    }

    /// Returns the time through a cell \[s\]: `2 h / (sqrt x0 + sqrt x1)`, exact for constant
    /// `d²s/dt²`.
    pub(super) fn time<const N: usize>(&self, grid: &FeedGrid<N>, cell: usize) -> f64 {
        let [from, to] = self.ends(cell).map(f64::sqrt);
        time(grid.cells[cell].h, from + to)
    }

    /// Turns the profile into a schedule over rows at these path parameters.
    pub(super) fn schedule(
        &self,
        s: Vec<f64>,
        lengths: impl Iterator<Item = f64>,
    ) -> SchedulePiece {
        let speed: Vec<f64> = self.x.iter().map(|x| x.sqrt()).collect();
        let mut t = Vec::with_capacity(self.x.len());
        let mut acceleration = Vec::with_capacity(self.x.len());
        let mut now = 0.0;
        for (index, h) in lengths.enumerate() {
            let [from, to] = self.ends(index);
            t.push(now);
            now += time(h, speed[index] + speed[index + 1]);
            // u = x'/2 with x linear over the cell.
            acceleration.push((to - from) / (2.0 * h));
        }
        t.push(now);
        acceleration.push(acceleration.last().copied().unwrap_or(0.0));
        SchedulePiece { s, t, speed, acceleration, profile: AccelerationProfile::Constant }
    }
}

/// Returns the time over `h`. Only a piece on which nothing moves is at rest at both ends of a
/// cell.
fn time(h: f64, sum: f64) -> f64 {
    if sum > 0.0 { 2.0 * h / sum } else { 0.0 }
}

/// Source of the constraints of both passes, cell by cell.
trait ConstraintSource<const N: usize> {
    /// Returns the number of cells.
    fn count(&self) -> usize;

    fn accelerations(&self, cell: usize, limits: &ReciprocalLimits<N>) -> CellAccelerations<N>;
}

impl<const N: usize> ConstraintSource<N> for FeedGrid<N> {
    fn count(&self) -> usize {
        self.cells.len()
    }

    #[inline]
    fn accelerations(&self, cell: usize, limits: &ReciprocalLimits<N>) -> CellAccelerations<N> {
        self.cells[cell].accelerations(limits)
    }
}

impl<const N: usize> ConstraintSource<N> for [AxisNode<N>] {
    fn count(&self) -> usize {
        self.len() - 1
    }

    #[inline]
    fn accelerations(&self, cell: usize, limits: &ReciprocalLimits<N>) -> CellAccelerations<N> {
        FeedCell::at_rows(&self[cell], &self[cell + 1], limits)
    }
}

/// Returns the largest `x` of each row from the speed limits of the cells on both sides.
///
/// Where no limit binds at all (axes and programmed point stand still), the row is passed no
/// faster than the fastest other one. Where none binds anywhere, nothing moves, and `x` is 0
/// throughout.
fn caps<const N: usize>(grid: &FeedGrid<N>, of: impl Fn(&FeedCell<N>) -> [f64; 2]) -> Vec<f64> {
    let mut caps = vec![f64::INFINITY; grid.s.len()];
    for (row, cell) in grid.cells.iter().enumerate() {
        let [from, to] = of(cell);
        caps[row] = caps[row].min(from);
        caps[row + 1] = caps[row + 1].min(to);
    }
    cap_still(&mut caps);
    caps
}

/// Caps rows that nothing limits at the largest cap of the others.
fn cap_still(caps: &mut [f64]) {
    let fastest = caps.iter().copied().filter(|cap| cap.is_finite()).fold(0.0, f64::max);
    for cap in caps {
        *cap = cap.min(fastest);
    }
}
