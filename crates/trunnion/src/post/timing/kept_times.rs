//! Programmed times, kept wherever the axes can follow them.
//!
//! The planner's own times hold along a smooth path that rounds corners, which is slower than a control may run. Where
//! the mean motion of the blocks keeps the limits at the programmed times, these stay; a program that was posted before
//! is therefore posted again with the same times. Elsewhere the planner's times are used, and the programmed speed is
//! scaled from one to the other as quickly as the axes allow.

use super::block_motion::{BlockMotion, MeanChange, position_error};
use super::timed_point::TimedPoint;
use crate::machine::Machine;
use crate::nc::write::AxisWords;
use crate::post::options::{PostMethod, PostOptions};
use crate::types::AxisVector;
use std::collections::VecDeque;

/// Most blocks of one cut that are judged as a whole, for their jerks.
const LONGEST: usize = 1 << 16;

/// Rounds of lowering speeds where two blocks still break a limit.
const ROUNDS: usize = 24;

/// Rounding of times, which are sums of some thousand numbers, as a share of a limit.
const SUMS: f64 = 1e-7;

/// Block whose time is to be chosen.
#[derive(Debug, Clone, Copy)]
struct ChosenBlock {
    /// Number of its points.
    points: usize,
    travel: AxisVector,
    /// Error of its ends by rounding.
    error: AxisVector,
    /// Shortest time: as programmed, or as planned where nothing is programmed \[s\].
    base: f64,
    /// Time by the planner \[s\].
    planned: f64,
}

impl ChosenBlock {
    /// Returns the motion in a time.
    fn motion(&self, seconds: f64) -> BlockMotion {
        BlockMotion::new(&self.travel, &self.error, seconds)
    }

    /// Returns the square of the planner's speed over that of the shortest time.
    fn planned_square(&self) -> f64 {
        (self.base / self.planned).powi(2).min(1.0)
    }
}

/// Pair of neighbouring blocks at their shortest times.
#[derive(Debug, Clone, Copy)]
struct BlockPair {
    /// Largest acceleration over its limit.
    load: f64,
    /// Largest change of the squared speed ratio with no other load on the axes.
    change: f64,
}

/// Stage behind the planner that returns to programmed times.
#[derive(Debug, Clone)]
pub(crate) struct KeptTimes {
    words: AxisWords,
    acceleration: AxisVector,
    /// Jerk limits, if they are kept.
    jerk: Option<AxisVector>,
    /// True if programmed times are kept: the feeds are not to be raised.
    keeps: bool,
    window: usize,
    at: AxisVector,
    points: VecDeque<TimedPoint>,
    /// Points of the block that is not ended yet.
    open: usize,
    blocks: VecDeque<ChosenBlock>,
    /// Last block whose time is chosen, and the square of its speed ratio; `None` at rest.
    before: Option<(ChosenBlock, f64)>,
    /// True where a cut is too long to be judged as a whole.
    overlong: bool,
}

impl KeptTimes {
    /// Creates the stage for axes that rest at `at`.
    pub(crate) fn new(
        machine: &Machine,
        words: &AxisWords,
        options: &PostOptions,
        at: AxisVector,
    ) -> Self {
        let keeps_jerk = options.method == PostMethod::Jerk;
        Self {
            words: *words,
            acceleration: machine.vector(|axis| axis.acc),
            jerk: keeps_jerk.then(|| machine.vector(|axis| axis.jerk)),
            keeps: options.max_feed.is_none(),
            window: options.window,
            at,
            points: VecDeque::new(),
            open: 0,
            blocks: VecDeque::new(),
            before: None,
            overlong: false,
        }
    }

    /// Takes in planned points, and appends those whose time is chosen.
    pub(crate) fn take(&mut self, timed: &mut Vec<TimedPoint>, out: &mut Vec<TimedPoint>) {
        for one in timed.drain(..) {
            if one.point.least.is_none() {
                // The axes stop between moves with feed and rapid moves.
                self.rest(out);
                self.at = one.point.q;
                out.push(one);
                continue;
            }
            self.points.push_back(one);
            self.open += 1;
            if one.point.block {
                self.close();
            }
            if self.jerk.is_some() {
                // A cut that does not fit is run as planned.
                self.overlong |= self.blocks.len() >= LONGEST;
                if self.overlong {
                    self.emit(self.blocks.len(), None, out);
                }
            } else if self.blocks.len() >= 2 * self.window {
                // The second half has room for a stop.
                let squares = self.squares();
                self.emit(self.window, Some(&squares), out);
            }
        }
    }

    /// Chooses all times, up to a standstill.
    pub(crate) fn rest(&mut self, out: &mut Vec<TimedPoint>) {
        self.close();
        let squares = if self.jerk.is_some() { self.all_or_none() } else { Some(self.squares()) };
        self.emit(self.blocks.len(), squares.as_deref(), out);
        self.before = None;
        self.overlong = false;
    }

    /// Ends a block.
    fn close(&mut self) {
        let count = std::mem::take(&mut self.open);
        let Some(end) = self.points.back().filter(|_| count > 0) else { return };
        let (q, source, linear) = (end.point.q, end.point.source, end.point.linear_error);
        let block = self.points.range(self.points.len() - count..);
        let planned: f64 = block.clone().map(|one| one.seconds).sum();
        let paced = self.keeps && block.clone().all(|one| one.point.programmed.is_some());
        let least: f64 = block.map(|one| one.point.least.unwrap_or(0.0)).sum();
        let base = if paced && least > 0.0 { least.min(planned) } else { planned };
        self.blocks.push_back(ChosenBlock {
            points: count,
            travel: q - self.at,
            error: position_error(&self.words, source, linear),
            base,
            planned,
        });
        self.at = q;
    }

    /// Returns the load and the freedom of two neighbours at their shortest times; `None` is a standstill.
    fn pair(&self, from: Option<&ChosenBlock>, to: Option<&ChosenBlock>) -> BlockPair {
        let at_base = |block: Option<&ChosenBlock>| {
            block.map_or_else(BlockMotion::rest, |block| block.motion(block.base))
        };
        let [a, b] = [at_base(from), at_base(to)];
        let load = a.to(&b).over(&self.acceleration);
        // With a speed ratio r the axes have the acceleration r² of the program, and v d(r²)/dt / 2 of the change.
        let fastest = a.velocity.abs().sup(&b.velocity.abs());
        let change = (a.seconds + b.seconds) / fastest.component_div(&self.acceleration).amax();
        BlockPair { load, change }
    }

    /// Returns the squares of the speed ratios of all blocks that wait: 1 keeps the shortest time.
    fn squares(&self) -> Vec<f64> {
        let blocks: Vec<&ChosenBlock> =
            self.before.iter().map(|(block, _)| block).chain(&self.blocks).collect();
        let fixed = self.before.map(|(_, square)| square);
        let start = usize::from(fixed.is_some());
        let pairs: Vec<BlockPair> =
            blocks.windows(2).map(|pair| self.pair(Some(pair[0]), Some(pair[1]))).collect();
        let mut most = vec![1.0_f64; blocks.len()];
        let lower = |most: &mut Vec<f64>, index: usize| {
            if let (Some(most), Some(block)) = (most.get_mut(index), blocks.get(index)) {
                *most = block.planned_square();
            }
        };
        // Step 1: where programmed times break a limit, those of the planner hold; so do they at both ends.
        for (index, pair) in pairs.iter().enumerate() {
            if pair.load > 1.0 + SUMS {
                lower(&mut most, index);
                lower(&mut most, index + 1);
            }
        }
        if fixed.is_none() && self.pair(None, blocks.first().copied()).load > 1.0 + SUMS {
            lower(&mut most, 0);
        }
        if self.pair(blocks.last().copied(), None).load > 1.0 + SUMS {
            lower(&mut most, blocks.len().saturating_sub(1));
        }
        if let (Some(first), Some(square)) = (most.first_mut(), fixed) {
            *first = square;
        }
        // Step 2: from one to the other no quicker than the axes can; repeated where a limit is still broken.
        for _ in 0..ROUNDS {
            let mut squares = follow(&most, &pairs, &blocks, start);
            let mut broken = false;
            for (index, pair) in blocks.windows(2).enumerate() {
                let motion = |k: usize| {
                    pair[k].motion(pair[k].base / squares[index + k].max(f64::MIN_POSITIVE).sqrt())
                };
                if motion(0).to(&motion(1)).over(&self.acceleration) > 1.0 + SUMS {
                    broken = true;
                    for k in [index, index + 1] {
                        let planned = blocks[k].planned_square();
                        most[k] = if k >= start { planned.max(0.7 * most[k]) } else { most[k] };
                    }
                }
            }
            if !broken {
                return squares.split_off(start);
            }
        }
        let mut squares: Vec<f64> = blocks.iter().map(|block| block.planned_square()).collect();
        squares.split_off(start)
    }

    /// Returns ratios of 1 if the cut keeps all limits as programmed.
    fn all_or_none(&self) -> Option<Vec<f64>> {
        let jerk = self.jerk.as_ref().filter(|_| !self.overlong)?;
        let rest = [BlockMotion::rest()];
        let programmed = self.blocks.iter().map(|block| block.motion(block.base));
        let mut last = BlockMotion::rest();
        let mut acceleration =
            MeanChange { value: AxisVector::zeros(), slack: AxisVector::zeros() };
        let mut first = 0.0;
        for motion in programmed.chain(rest) {
            let next = last.to(&motion);
            let time = first + last.seconds + motion.seconds;
            let kept = next.over(&self.acceleration) <= 1.0 + SUMS
                && acceleration.to(&next, time).over(jerk) <= 1.0 + SUMS;
            if !kept {
                return None;
            }
            (first, last, acceleration) = (last.seconds, motion, next);
        }
        Some(vec![1.0; self.blocks.len()])
    }

    /// Passes on the first blocks with the chosen speed ratios; without them as planned.
    fn emit(&mut self, count: usize, squares: Option<&[f64]>, out: &mut Vec<TimedPoint>) {
        for (index, block) in self.blocks.drain(..count).enumerate() {
            let square = squares.and_then(|squares| squares.get(index)).copied();
            let square = square.unwrap_or_else(|| block.planned_square());
            let seconds = block.base / square.sqrt();
            let chosen = seconds < block.planned;
            let whole: f64 = self.points.range(..block.points).map(|one| one.point.size()).sum();
            for one in self.points.drain(..block.points) {
                let share = one.point.size() / whole;
                let seconds =
                    if chosen && share.is_finite() { seconds * share } else { one.seconds };
                out.push(TimedPoint { seconds, ..one });
            }
            self.before = Some((block, square));
        }
    }
}

/// Returns the largest squared ratios below `most` that change no quicker than the axes allow, but never below those
/// of the planner; the first `start` are given.
fn follow(most: &[f64], pairs: &[BlockPair], blocks: &[&ChosenBlock], start: usize) -> Vec<f64> {
    let mut squares = most.to_vec();
    let next = |from: f64, pair: &BlockPair, most: f64| {
        if !pair.change.is_finite() {
            return f64::INFINITY;
        }
        // x' - x <= c (1 - l x'), with no more load than the planner's own times have.
        let load = pair.load.min(1.0 / most);
        (from + pair.change) / (1.0 + pair.change * load)
    };
    let limited = |squares: &mut Vec<f64>, index: usize, by: f64| {
        let planned = blocks.get(index).map_or(0.0, |block| block.planned_square());
        if let Some(square) = squares.get_mut(index).filter(|_| index >= start) {
            *square = square.min(by.max(planned.min(*square)));
        }
    };
    for (index, pair) in pairs.iter().enumerate().rev() {
        let by = next(squares[index + 1], pair, most[index].max(most[index + 1]));
        limited(&mut squares, index, by);
    }
    for (index, pair) in pairs.iter().enumerate() {
        let by = next(squares[index], pair, most[index].max(most[index + 1]));
        limited(&mut squares, index + 1, by);
    }
    squares
}
