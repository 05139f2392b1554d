//! Reduction of a program that has more blocks than its tolerance needs.

use super::bend::PoseBend;
use super::deviation::{BlockEnd, ControlledPath, PathPoint, PosePath, block_bend, moved};
use super::error::BlocksError;
use super::options::BlockInterpolation;
use crate::machine::Kinematics;
use crate::types::{Block, Progress, Stage};

/// Options of [`reduce`]. Begin with [`ReduceOptions::within`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ReduceOptions {
    /// Motion of the control between block ends.
    pub control: BlockInterpolation,
    /// Largest deviation from the motion with all blocks \[mm\]: tip distance, plus angle of the tool
    /// axis times `lever`.
    pub tolerance: f64,
    /// Distance from the tip to the point whose position matters, for instance the contact \[mm\].
    pub lever: f64,
    /// Largest travel of a rotary axis in a block that replaces several \[rad\].
    pub max_turn: f64,
}

impl ReduceOptions {
    /// Allows blocks of any length within a tolerance \[mm\] of the tip, however far the rotary axes travel.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::blocks::{BlockInterpolation, ReduceOptions};
    ///
    /// let mut options = ReduceOptions::within(BlockInterpolation::RotaryLinear, 0.01);
    /// options.max_turn = 10_f64.to_radians();
    /// assert_eq!((options.tolerance, options.lever), (0.01, 0.0));
    /// ```
    #[must_use]
    pub const fn within(control: BlockInterpolation, tolerance: f64) -> Self {
        Self { control, tolerance, lever: 0.0, max_turn: f64::INFINITY }
    }
}

/// Program as its control runs it; the parameter counts blocks.
struct BlockProgram<'a> {
    kinematics: &'a Kinematics,
    control: BlockInterpolation,
    blocks: &'a [Block],
}

impl BlockProgram<'_> {
    fn ends(&self, s: f64) -> Option<(usize, [&Block; 2])> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let block = (s.max(0.0) as usize).min(self.blocks.len().checked_sub(2)?);
        Some((block, [&self.blocks[block], &self.blocks[block + 1]]))
    }
}

impl PosePath for BlockProgram<'_> {
    fn at(&self, s: f64) -> PathPoint {
        let Some((block, [from, to])) = self.ends(s) else {
            let only = &self.blocks[0];
            return PathPoint { s, q: only.q, pose: only.pose };
        };
        // Parameter s counts blocks: its fraction is the share of the block.
        let share = s - block as f64;
        let ends = [from, to].map(|end| BlockEnd { q: &end.q, pose: &end.pose });
        // Opposite tool axes: no great circle, and no block that would do for it either.
        let pose = moved(self.kinematics, self.control, ends, share).unwrap_or(from.pose);
        PathPoint { s, q: from.q.lerp(&to.q, share), pose }
    }

    fn bend(&self, [from, to]: [&PathPoint; 2]) -> PoseBend {
        let Some((_, ends)) = self.ends(0.5 * (from.s + to.s)) else {
            return PoseBend { tip: 0.0, axis: 0.0 };
        };
        // The stretch is part of one block, so that its second derivatives scale with the square of
        // its share.
        let square = (to.s - from.s).powi(2);
        let whole = block_bend(self.kinematics, self.control, ends);
        PoseBend { tip: whole.tip * square, axis: whole.axis * square }
    }

    fn inside(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let count = (to - from).round() as usize;
        (1..count).map(|k| from + k as f64).collect()
    }
}

/// Drops blocks of a program that its control does not need. The remaining program stays within
/// [`ReduceOptions::tolerance`] of the motion with all blocks, bounded everywhere.
///
/// Ends that stay are bit for bit those given, and durations add up. A change of the kind of motion
/// stays a block end. Longest block first.
///
/// # Errors
///
/// [`BlocksError::BadOption`], [`BlocksError::Cancelled`].
pub fn reduce(
    kinematics: &Kinematics,
    blocks: &[Block],
    options: &ReduceOptions,
    progress: &dyn Progress,
) -> Result<Vec<Block>, BlocksError> {
    validate(options)?;
    let poses = BlockProgram { kinematics, control: options.control, blocks };
    let controlled =
        ControlledPath { kinematics, control: options.control, poses, lever: options.lever };
    let mut kept: Vec<Block> = blocks.first().copied().into_iter().collect();
    let mut from = 0;
    let mut guess = 1;
    while from + 1 < blocks.len() {
        progress.step(Stage::Program, from as u64, blocks.len() as u64)?;
        let to = longest(&controlled, options, from, guess);
        guess = to - from;
        let duration = blocks[from + 1..=to].iter().map(|block| block.duration).sum();
        kept.push(Block { duration, ..blocks[to] });
        from = to;
    }
    Ok(kept)
}

fn validate(options: &ReduceOptions) -> Result<(), BlocksError> {
    for (name, value) in [("tolerance", options.tolerance), ("max_turn", options.max_turn)] {
        if value.is_nan() || value <= 0.0 {
            return Err(BlocksError::BadOption { name, value, must: "positive" });
        }
    }
    let value = options.lever;
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(BlocksError::BadOption { name: "lever", value, must: "finite and not negative" })
}

/// Returns the last block that one from `from` may replace: doubled from a guess, then bisected.
fn longest(
    controlled: &ControlledPath<'_, BlockProgram<'_>>,
    options: &ReduceOptions,
    from: usize,
    guess: usize,
) -> usize {
    let blocks = controlled.poses.blocks;
    let motion = blocks[from + 1].motion;
    let same = blocks[from + 1..].iter().take_while(|block| block.motion == motion).count();
    let allowed = |to: usize| to == from + 1 || fits(controlled, options, [from, to]);
    // One block is always allowed; `refused` is the first known not to be.
    let [mut best, mut refused] = [from + 1, from + same + 1];
    let mut step = guess.max(1);
    // Invariant: `best` is allowed, `refused` is not, or is the end of this kind of motion.
    while best + 1 < refused {
        let to = (from + step).clamp(best + 1, refused - 1);
        if allowed(to) {
            best = to;
            step = 2 * (to - from);
        } else {
            refused = to;
            step = (best - from + refused - from) / 2;
        }
        if refused <= from + same {
            step = (best - from + refused - from) / 2;
        }
    }
    best
}

fn fits(
    controlled: &ControlledPath<'_, BlockProgram<'_>>,
    options: &ReduceOptions,
    ends: [usize; 2],
) -> bool {
    let [from, to] = ends.map(|at| &controlled.poses.blocks[at]);
    let turn = (to.q - from.q).fixed_rows::<2>(3).amax();
    let [start, end] = ends.map(|at| controlled.at(at as f64));
    turn <= options.max_turn
        && controlled.deviation(&start, &end, options.tolerance) <= options.tolerance
}
