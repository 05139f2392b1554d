//! Weights of the barrier, lowered stretch by stretch.
//!
//! A weight that falls before the profile has followed leaves the profile against rows that are
//! not its last ones, and steps are short from there on: a path that bends to and fro would stall
//! a fifth above the time it needs. So each stretch lowers its weight after steps that were long
//! and changed little, and raises it after those that were cut short.

use super::newton::BarrierSolver;
use crate::math;
use std::ops::Range;

/// Barrier weights as shares of each cell's time: the first about balances the time against the 110
/// sides of rows a cell has, the last leaves 4e-4 of it.
pub(super) const FIRST_WEIGHT: f64 = 5e-3;

pub(super) const LAST_WEIGHT: f64 = 3.6e-6;

/// Newton steps per stretch and sweep.
pub(super) const STEPS: usize = 3;

/// Controls of a stretch: many times the distance over which a stop is felt, so that little of the
/// path waits at a border.
const STRETCH: usize = 2000;
/// Borders of stretches move by this share of a stretch from sweep to sweep: the golden section
/// never comes near a former border.
const SHIFT: f64 = 0.618_033_988_749_895;
/// Most sweeps. Paths take 8 to 12, those that bend to and fro 20.
const SWEEPS: usize = 48;

/// A step of at least this length lowers the weight by this factor.
const LONG: [f64; 2] = [0.8, 0.2];
/// A step of at least this length lowers it by this factor.
const FAIR: [f64; 2] = [0.4, 0.5];
/// Largest change of the time through the stretch after which the weight falls: above it the
/// profile is still moving.
const STEADY: f64 = 0.02;
/// A shorter step raises it.
const SHORT: [f64; 2] = [0.1, 1.3];
/// A stretch is done after full steps at the last weight of which the last gained less.
const LITTLE: f64 = 1e-4;

/// A mean below this is the last weight, whatever its rounding.
const NEXT_TO_LAST: f64 = 1.001 * LAST_WEIGHT;

/// Weight of the barrier in each cell, as a share of the cell's time, and whether the cell is done.
#[derive(Debug)]
pub(super) struct BarrierWeights {
    weights: Vec<f64>,
    done: Vec<bool>,
}

impl BarrierWeights {
    /// Sets a first weight in a range of cells, which are to be searched; the last one elsewhere.
    fn over(range: Range<usize>, first: f64, cells: usize) -> Self {
        let mut barrier = Self { weights: vec![LAST_WEIGHT; cells], done: vec![true; cells] };
        barrier.weights[range.clone()].fill(first);
        barrier.done[range].fill(false);
        barrier
    }

    /// Returns `true` if all cells are done.
    fn is_done(&self) -> bool {
        self.done.iter().all(|done| *done)
    }

    fn multiply(&mut self, range: Range<usize>, factor: f64) {
        for weight in &mut self.weights[range] {
            *weight = (*weight * factor).clamp(LAST_WEIGHT, FIRST_WEIGHT);
        }
    }

    /// Sets one weight for a range: cells of stretches that are behind go on with the others.
    fn even_out(&mut self, range: Range<usize>) {
        // The geometric mean: weights fall and rise by factors.
        let weights = &mut self.weights[range];
        let sum = weights.iter().map(|weight| math::ln(*weight)).sum::<f64>();
        let mean = math::exp(sum / weights.len() as f64);
        let last = mean < NEXT_TO_LAST;
        weights.fill(if last { LAST_WEIGHT } else { mean.min(FIRST_WEIGHT) });
    }
}

impl<const N: usize> BarrierSolver<'_, N> {
    /// Makes a range of controls as fast as it can be while the others stay, but for the share
    /// `tolerance` of its time. The weight of the barrier falls from `first`. Sweeps of stretches
    /// follow one another, the borders of one inside those of the one before.
    pub(super) fn hurry(&mut self, range: Range<usize>, first: f64, tolerance: f64) {
        let mut barrier = BarrierWeights::over(range.clone(), first, self.spline.len());
        let mut border = 0.5;
        for _ in 0..SWEEPS {
            // Caps that the motion is below by now hold from here on.
            self.brake_on(FIRST_WEIGHT);
            let first = 1 + share_of_stretch(border);
            self.descend(&mut barrier, range.clone(), first, tolerance);
            border = (border + SHIFT).fract();
            if barrier.is_done() {
                break;
            }
        }
    }

    /// Sweeps over the stretches of a range that are not done, the first of them of `first` cells.
    fn descend(
        &mut self,
        barrier: &mut BarrierWeights,
        range: Range<usize>,
        first: usize,
        tolerance: f64,
    ) {
        let mut from = range.start;
        let mut to = (from + first).min(range.end);
        while from < range.end {
            if barrier.done[from..to].contains(&false) {
                self.lower(barrier, from..to, tolerance);
            }
            (from, to) = (to, (to + STRETCH).min(range.end));
        }
    }

    /// Takes steps on one stretch; the weight falls as they allow.
    fn lower(&mut self, barrier: &mut BarrierWeights, range: Range<usize>, tolerance: f64) {
        barrier.even_out(range.clone());
        let mut work = self.open(range.clone());
        let start = self.time_through(range.clone());
        let [mut before, mut full] = [start, 0.0];
        for _ in 0..STEPS {
            self.weigh(&mut work, |cell| barrier.weights[cell]);
            let Some(length) = self.step(&mut work) else { break };
            let now = self.time_through(range.clone());
            // Share of the time that the step gained; negative if the barrier pushed the profile back.
            let gain = 1.0 - now / before;
            before = now;
            if length >= LONG[0] && barrier.weights[range.start] <= LAST_WEIGHT {
                full += 1.0;
                if full > 1.0 && gain < LITTLE {
                    break;
                }
            }
            // Lower the weight after long steps of a settled profile, raise it after short ones.
            let steady = gain < STEADY;
            let factor = if steady && length >= LONG[0] {
                LONG[1]
            } else if steady && length >= FAIR[0] {
                FAIR[1]
            } else if length < SHORT[0] {
                SHORT[1]
            } else {
                1.0
            };
            barrier.multiply(range.clone(), factor);
        }
        self.close(work);
        // Done: a full step at the last weight, or a whole sweep that gained too little.
        let at_last = barrier.weights[range.start] <= LAST_WEIGHT;
        if full > 0.0 || (at_last && before > (1.0 - tolerance) * start) {
            barrier.done[range].fill(true);
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share in 0..1 of a small number"
)]
fn share_of_stretch(share: f64) -> usize {
    (share * STRETCH as f64) as usize
}
