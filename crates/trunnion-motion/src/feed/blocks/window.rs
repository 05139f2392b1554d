//! Speeds at the junctions of blocks, looked ahead for over a window.

use super::options::{LookAhead, LookAheadOptions, TinyBlocks};
use nalgebra::SVector;

/// Data of one block for the look-ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BlockRow<const N: usize> {
    /// Length in the path's measure.
    pub(super) length: f64,
    /// Axis travel per unit of length: the axis coefficients.
    pub(super) coefficients: SVector<f64, N>,
    /// Largest speed.
    pub(super) feed: f64,
    /// Largest acceleration, and deceleration.
    pub(super) acceleration: f64,
}

/// Returns feed and acceleration of a block from its axis coefficients, (14) and (15).
pub(super) fn row<const N: usize>(
    coefficients: SVector<f64, N>,
    length: f64,
    feed: f64,
    velocity: SVector<f64, N>,
    acceleration: SVector<f64, N>,
) -> BlockRow<N> {
    // An axis that does not move divides by zero: an infinite limit, which binds nothing.
    let least = |limits: SVector<f64, N>| limits.component_div(&coefficients.abs()).min();
    let feed = feed.min(least(velocity));
    BlockRow { length, coefficients, feed, acceleration: least(acceleration) }
}

/// Plans the speeds at all junctions.
pub(super) fn plan_rows<const N: usize>(
    rows: &mut [BlockRow<N>],
    acceleration: &SVector<f64, N>,
    options: &LookAheadOptions,
    ends: [f64; 2],
) -> Vec<f64> {
    if let Some(tiny) = options.tiny {
        join_tiny(rows, tiny);
    }
    let junctions = junctions(rows, acceleration, options.period);
    speeds(rows, &junctions, ends, options.ahead, options.period)
}

/// Gives runs of tiny blocks the feed and the acceleration of their slowest, so that they are
/// passed through like one block.
pub(super) fn join_tiny<const N: usize>(rows: &mut [BlockRow<N>], tiny: TinyBlocks) {
    let is_tiny = |row: &BlockRow<N>| row.length < tiny.length;
    for run in rows.chunk_by_mut(|a, b| is_tiny(a) == is_tiny(b)) {
        // Short runs keep limits of their own.
        if run.len() <= tiny.count || !run.first().is_some_and(is_tiny) {
            continue;
        }
        let least = |of: fn(&BlockRow<N>) -> f64| run.iter().map(of).fold(f64::INFINITY, f64::min);
        let [feed, acceleration] = [least(|row| row.feed), least(|row| row.acceleration)];
        for row in run {
            (row.feed, row.acceleration) = (feed, acceleration);
        }
    }
}

/// Returns the largest speed at every junction: both feeds, and no axis velocity may step by more
/// than its acceleration changes it in one servo period.
pub(super) fn junctions<const N: usize>(
    rows: &[BlockRow<N>],
    acceleration: &SVector<f64, N>,
    period: f64,
) -> Vec<f64> {
    // |c_to - c_from| v <= a T on every axis.
    let step = acceleration * period;
    let between = rows.windows(2).map(|pair| {
        let [from, to] = [&pair[0], &pair[1]];
        let turn = (to.coefficients - from.coefficients).abs();
        let allowed = step.zip_map(&turn, |step, turn| step / turn);
        allowed.min().min(from.feed).min(to.feed)
    });
    between.collect()
}

/// Returns the speeds at the start of every block and at the end of the last one.
///
/// The planner goes block by block: it brings the backward pass from rest at the window's end up
/// to date, and commits the end speed of the block. A longer window only raises what the backward
/// pass allows, and the pass ends where it raises nothing. So every block is visited a few
/// times, however long the window.
pub(super) fn speeds<const N: usize>(
    rows: &[BlockRow<N>],
    junctions: &[f64],
    ends: [f64; 2],
    ahead: LookAhead,
    period: f64,
) -> Vec<f64> {
    // Nothing moves, as where a program has a position and no move: there are no junctions either.
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return Vec::new() };
    let count = rows.len();
    let mut caps = vec![0.0; count + 1];
    // Largest speed at each junction; the inner ones stay 0 where every block ends at rest.
    caps[0] = ends[0].min(first.feed);
    caps[count] = ends[1].min(last.feed);
    if ahead != LookAhead::Stops {
        caps[1..count].copy_from_slice(junctions);
    }
    let mut window =
        BlockWindow { rows, caps: &caps, reach: vec![0.0; count + 1], end: 0, time: 0.0 };
    let mut speeds = Vec::with_capacity(count + 1);
    for (block, row) in rows.iter().enumerate() {
        window.extend(block, ahead, period);
        let before = *speeds.last().unwrap_or(&caps[0].min(window.reach[0]));
        if speeds.is_empty() {
            speeds.push(before);
        }
        // Forward pass: as fast as the block allows, and no faster than the window can follow.
        speeds.push(reached(before, row).min(window.reach[block + 1]));
        window.time -= row.length / row.feed;
    }
    speeds
}

/// Returns the speed after (or, backwards, before) a block that ends with `speed`.
fn reached<const N: usize>(speed: f64, row: &BlockRow<N>) -> f64 {
    (speed * speed + 2.0 * row.acceleration * row.length).sqrt()
}

/// The window of blocks ahead.
struct BlockWindow<'a, const N: usize> {
    rows: &'a [BlockRow<N>],
    caps: &'a [f64],
    /// Largest speed at each junction from which the window's end is reached at rest.
    reach: Vec<f64>,
    /// Junction at which the window ends.
    end: usize,
    /// Time of its blocks at their feed \[s\].
    time: f64,
}

impl<const N: usize> BlockWindow<'_, N> {
    /// Extends the window from `block` as far as it must reach.
    fn extend(&mut self, block: usize, ahead: LookAhead, period: f64) {
        let before = self.end;
        while self.end < self.rows.len() && !self.suffices(block, ahead, period) {
            self.time += self.rows[self.end].length / self.rows[self.end].feed;
            self.end += 1;
        }
        if self.end == before {
            return;
        }
        // The window ends at rest, except at the end of the path.
        self.reach[self.end] = if self.end == self.rows.len() { self.caps[self.end] } else { 0.0 };
        for junction in (block..self.end).rev() {
            let row = &self.rows[junction];
            let speed = self.caps[junction].min(reached(self.reach[junction + 1], row));
            // From here on the pass before this one found the same.
            if junction < before && speed <= self.reach[junction] {
                break;
            }
            self.reach[junction] = speed;
        }
    }

    fn suffices(&self, block: usize, ahead: LookAhead, period: f64) -> bool {
        let blocks = self.end - block;
        match ahead {
            LookAhead::Stops => blocks >= 1,
            LookAhead::Blocks(count) => blocks >= count.max(1),
            LookAhead::Dynamic { blocks: first, periods } => {
                blocks >= first.max(1) && self.time >= periods * period
            }
            LookAhead::Whole => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use proptest::prelude::*;

    fn rows(lengths: &[f64]) -> Vec<BlockRow<2>> {
        let row = |(index, &length): (usize, &f64)| {
            let (sin, cos) = (index as f64 * 0.7).sin_cos();
            let coefficients = Vector2::new(cos, sin);
            BlockRow { length, coefficients, feed: 100.0, acceleration: 500.0 + 10.0 * cos }
        };
        lengths.iter().enumerate().map(row).collect()
    }

    /// The window's passes all anew for each block.
    fn plainly(rows: &[BlockRow<2>], caps: &[f64], count: usize) -> Vec<f64> {
        let mut speeds = vec![caps[0]];
        for block in 0..rows.len() {
            let end = (block + count).min(rows.len());
            let mut reach = if end == rows.len() { caps[end] } else { 0.0 };
            for junction in (block + 1..end).rev() {
                reach = caps[junction].min(reached(reach, &rows[junction]));
            }
            speeds.push(reach.min(reached(speeds[block], &rows[block])));
        }
        speeds
    }

    proptest! {
        #[test]
        fn a_window_brought_up_to_date_is_the_window_anew(
            lengths in prop::collection::vec(0.01..5.0f64, 1..60),
            caps in prop::collection::vec(0.0..90.0f64, 60),
            count in 1_usize..20,
        ) {
            let rows = rows(&lengths);
            let mut all = vec![0.0];
            all.extend(&caps[..rows.len() - 1]);
            all.push(0.0);
            let got = speeds(&rows, &all[1..rows.len()], [0.0; 2], LookAhead::Blocks(count), 1e-3);
            prop_assert_eq!(&got, &plainly(&rows, &all, count));
            // The whole way is the longest window.
            let whole = speeds(&rows, &all[1..rows.len()], [0.0; 2], LookAhead::Whole, 1e-3);
            prop_assert_eq!(&whole, &plainly(&rows, &all, rows.len()));
            for (short, long) in got.iter().zip(&whole) {
                prop_assert!(short <= long);
            }
        }
    }

    #[test]
    fn no_blocks_have_no_speeds() {
        for ahead in [LookAhead::Whole, LookAhead::Stops, LookAhead::Blocks(3)] {
            assert!(speeds::<2>(&[], &[], [1.0; 2], ahead, 1e-3).is_empty());
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "copies")]
    fn only_long_runs_of_tiny_blocks_are_joined() {
        let mut all = rows(&[5.0, 0.1, 0.1, 5.0, 0.1, 0.1, 0.1]);
        let before = all.clone();
        join_tiny(&mut all, TinyBlocks { length: 1.0, count: 2 });
        assert_eq!(all[..4], before[..4]);
        let least = before[4..].iter().map(|row| row.acceleration).fold(f64::INFINITY, f64::min);
        assert!(all[4..].iter().all(|row| row.acceleration == least));
    }
}
