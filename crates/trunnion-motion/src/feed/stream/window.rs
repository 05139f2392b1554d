//! The rows ahead of a stream and the backward pass over them.

use super::options::MOST_OVERRIDE;
use crate::feed::cell::FeedCell;
use crate::feed::cell_program::{WarmStart, backward};
use crate::feed::numeric::{scaled, tangent};
use crate::feed::reciprocal::ReciprocalLimits;
use crate::types::Motion;
use std::collections::VecDeque;

/// Row at which a cell ends and the next one starts.
#[derive(Debug, Clone, Copy)]
pub(super) struct WindowRow {
    pub(super) piece: usize,
    /// Interval between nodes that ends here, or in which this row lies.
    pub(super) interval: usize,
    pub(super) s: f64,
    /// Kind of motion of the piece.
    pub(super) motion: Motion,
    /// Largest squared speed by the axes and the tip, and by the programmed feed.
    hard: f64,
    feed: f64,
    /// Largest squared speed from which what follows can be run within feed and limits: at the
    /// override, and at whatever feed.
    reach: f64,
    most: f64,
}

impl WindowRow {
    /// Makes a row without limits yet.
    pub(super) fn at([piece, interval]: [usize; 2], s: f64, motion: Motion) -> Self {
        let [free, rest] = [f64::INFINITY, 0.0];
        Self { piece, interval, s, motion, hard: free, feed: free, reach: rest, most: rest }
    }

    fn lower(&mut self, hard: f64, feed: f64) {
        (self.hard, self.feed) = (self.hard.min(hard), self.feed.min(feed));
    }
}

/// Rows ahead, the first of them where the committed schedule ends, and the cells between them;
/// `None` from the end of a piece to the start of the next.
#[derive(Debug, Clone)]
pub(super) struct RowWindow<const N: usize> {
    rows: VecDeque<WindowRow>,
    cells: VecDeque<Option<FeedCell<N>>>,
    factor: f64,
    /// Largest finite squared speed so far: where nothing moves, no more is of use.
    fastest: f64,
    /// Rows of the last backward pass; those before `settled` do not depend on what is pushed later;
    /// cells that may be committed before the next pass, if there is something new.
    planned: usize,
    settled: usize,
    good: usize,
    /// `true` if a pass from scratch is due: another override, or other rows.
    stale: bool,
    /// `true` if the speed was above the reach at the last pass, and `most` is up to date.
    braking: bool,
}

impl<const N: usize> RowWindow<N> {
    pub(super) fn new() -> Self {
        Self {
            rows: VecDeque::new(),
            cells: VecDeque::new(),
            factor: 1.0,
            fastest: 0.0,
            planned: 0,
            settled: 0,
            good: 0,
            stale: false,
            braking: false,
        }
    }

    /// Returns the number of cells ahead.
    pub(super) fn ahead(&self) -> usize {
        self.cells.len()
    }

    pub(super) fn holds(&self) -> bool {
        self.factor <= 0.0
    }

    pub(super) fn set_override(&mut self, factor: f64) {
        // Every cap changes with the override, so that no row of the last pass is of use.
        self.stale |= factor.to_bits() != self.factor.to_bits();
        self.factor = factor;
    }

    /// Starts a piece: rest at the last row and at this one.
    pub(super) fn rest(&mut self, mut row: WindowRow) {
        row.lower(0.0, 0.0);
        if let Some(last) = self.rows.back_mut() {
            last.lower(0.0, 0.0);
            self.cells.push_back(None);
        }
        self.rows.push_back(row);
    }

    /// Appends a cell and the row at its end.
    pub(super) fn push(
        &mut self,
        cell: FeedCell<N>,
        mut row: WindowRow,
        limits: &ReciprocalLimits<N>,
    ) {
        let [hard, feed] = caps(&cell, limits);
        if let Some(last) = self.rows.back_mut() {
            last.lower(hard[0], feed[0]);
        }
        row.lower(hard[1], feed[1]);
        // The feed may be raised by the override up to its largest value.
        for cap in [row.hard, row.feed * (MOST_OVERRIDE * MOST_OVERRIDE)] {
            self.fastest = if cap.is_finite() { self.fastest.max(cap) } else { self.fastest };
        }
        self.rows.push_back(row);
        self.cells.push_back(Some(cell));
    }

    /// Returns the row where the committed schedule ends, and the cell after it.
    pub(super) fn first(&self) -> Option<(&WindowRow, Option<&FeedCell<N>>)> {
        Some((self.rows.front()?, self.cells.front()?.as_ref()))
    }

    /// Returns the squared speeds possible at the end of the first cell: the one wanted, and the
    /// largest.
    pub(super) fn next_reach(&self) -> [f64; 2] {
        let Some(row) = self.rows.get(1) else { return [0.0; 2] };
        [row.reach, if self.braking { row.most } else { row.reach }]
    }

    /// Drops the first cell and returns the row at its end.
    pub(super) fn commit(&mut self) -> Option<WindowRow> {
        self.rows.pop_front();
        self.cells.pop_front();
        for count in [&mut self.planned, &mut self.settled, &mut self.good] {
            *count = count.saturating_sub(1);
        }
        self.rows.front().copied()
    }

    /// Cuts the first cell into so many parts.
    pub(super) fn cut(&mut self, parts: usize, limits: &ReciprocalLimits<N>) -> Option<()> {
        let (from, cell) = (*self.rows.front()?, (*self.cells.front()?)?);
        let to = *self.rows.get(1)?;
        // The parts go between the first row and the rest, which is taken off and put back.
        let tail = (self.rows.split_off(1), self.cells.split_off(1));
        self.cells.clear();
        for (cell, share) in pieces(cell, parts) {
            let s = from.s + share * (to.s - from.s);
            self.push(cell, WindowRow::at([to.piece, to.interval], s, to.motion), limits);
        }
        // The last row pushed is the one that was there, with the limits of both sides.
        if let (Some(end), Some(mut kept)) = (self.rows.pop_back(), tail.0.front().copied()) {
            kept.lower(end.hard, end.feed);
            self.rows.push_back(kept);
        }
        self.rows.extend(tail.0.into_iter().skip(1));
        self.cells.extend(tail.1);
        self.stale = true;
        Some(())
    }

    /// Brings the backward pass up to date where it is due: from rest at the last row to where it
    /// meets the one before, or settled rows.
    pub(super) fn plan(&mut self, x: f64, limits: &ReciprocalLimits<N>) {
        let last = self.cells.len();
        // Rows were appended, and the cells that the last pass vouched for are run.
        let new = self.planned <= last && self.good == 0;
        if !(self.stale || new) {
            return;
        }
        if self.stale {
            (self.planned, self.settled) = (0, 0);
        }
        self.backward(last, limits);
        (self.planned, self.stale) = (last + 1, false);
        // At least a quarter of the window is committed before the next pass: a constant cost for each row.
        self.good = self.settled.max(last / 4).max(1);
        self.braking = self.rows.front().is_some_and(|row| x > row.reach);
        if self.braking {
            self.backward_at_any_feed(last, limits);
        }
    }

    fn backward(&mut self, last: usize, limits: &ReciprocalLimits<N>) {
        let mut guess = WarmStart::default();
        let mut settled = None;
        let mut next = 0.0;
        if let Some(row) = self.rows.get_mut(last) {
            row.reach = 0.0;
        }
        for index in (self.settled..last).rev() {
            let cap = self.cap(index);
            let (Some(cell), Some(row)) = (self.cells.get(index), self.rows.get_mut(index)) else {
                return;
            };
            let (reach, alone) = match cell {
                Some(cell) => backward::<N, 5>(&cell.accelerations(limits), cap, next, &mut guess),
                None => (0.0, true),
            };
            // The answer does not depend on what follows: rows up to here will stay as they are.
            if alone && settled.is_none() {
                settled = Some(index);
            }
            let met = index < self.planned && reach.to_bits() == row.reach.to_bits();
            row.reach = reach;
            next = reach;
            // A row that only rested because the window ended there does not count as met.
            if met && reach > 0.0 {
                break;
            }
        }
        self.settled = settled.unwrap_or(self.settled);
    }

    /// Runs the same pass without feed and override, which a braking motion is above.
    fn backward_at_any_feed(&mut self, last: usize, limits: &ReciprocalLimits<N>) {
        let mut guess = WarmStart::default();
        let mut next = 0.0;
        if let Some(row) = self.rows.get_mut(last) {
            row.most = 0.0;
        }
        for (row, cell) in self.rows.iter_mut().zip(&self.cells).rev() {
            let cap = if row.hard.is_finite() { row.hard } else { self.fastest };
            row.most = cell.as_ref().map_or(0.0, |cell| {
                backward::<N, 5>(&cell.accelerations(limits), cap, next, &mut guess).0
            });
            next = row.most;
        }
    }

    /// Returns the largest squared speed at a row with the override: below 1 it scales the limits
    /// too, above 1 the feed alone.
    fn cap(&self, index: usize) -> f64 {
        let Some(row) = self.rows.get(index) else { return 0.0 };
        let square = self.factor * self.factor;
        let finite = |cap: f64| if cap.is_finite() { cap } else { self.fastest };
        if self.factor <= 1.0 {
            square * finite(row.hard.min(row.feed))
        } else {
            finite(row.hard.min(row.feed * square))
        }
    }
}

/// Returns the largest squared speeds at both ends of a cell by axes and tip, and by the feed.
fn caps<const N: usize>(cell: &FeedCell<N>, limits: &ReciprocalLimits<N>) -> [[f64; 2]; 2] {
    // Kept apart, because an override above 1 raises the feed alone.
    let axes = ReciprocalLimits { feed: 0.0, ..*limits };
    [cell.caps(&axes), tangent(scaled(cell.feed_rate, limits.feed))]
}

/// Returns `true` if nothing moves in a cell.
pub(super) fn still<const N: usize>(cell: &FeedCell<N>, limits: &ReciprocalLimits<N>) -> bool {
    caps(cell, limits).as_flattened().iter().all(|cap| cap.is_infinite())
}

/// Cuts a cell into even parts, with the share of it at which each ends.
pub(super) fn pieces<const N: usize>(
    whole: FeedCell<N>,
    parts: usize,
) -> impl Iterator<Item = (FeedCell<N>, f64)> {
    let mut rest = whole;
    (1..=parts).map(move |part| {
        let share = part as f64 / parts as f64;
        if part == parts {
            return (rest, share);
        }
        let [cell, remainder] = rest.split(1.0 / (parts - part + 1) as f64);
        rest = remainder;
        (cell, share)
    })
}
