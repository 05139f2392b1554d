//! Blocks of a whole path.

use super::error::BlocksError;
use super::options::BlockOptions;
use super::{deviation, search, smooth_piece, validate};
use crate::machine::Kinematics;
use crate::types::{AxisPath, AxisPiece, Block, Progress, Schedule, SchedulePiece, Stage};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Breaks a path into the fewest blocks between which the control stays within tolerance.
///
/// The first block is the starting position, with duration 0; every other ends on the path, and
/// every piece ends with a block. Longest block first, which gives the fewest: part of an allowed
/// block is allowed. The deviation is measured from the path to the curve of the control, whatever
/// the speeds along both, and bounded everywhere: between samples by how much path and control can bend,
/// from the Bernstein coefficients of the axes' derivatives and the tip's arms about the rotaries.
///
/// A block's mean axis velocity is the schedule's mean over the block, and the difference of two of
/// them over the distance of the blocks' middles in time is a weighted mean of the schedule's
/// acceleration: a program at block-mean speed keeps limits that the schedule keeps.
///
/// # Errors
///
/// [`BlocksError`].
///
/// # Source
///
/// `docs/sources.md#003` for the deviations of the three kinds of control.
pub fn blocks(
    kinematics: &Kinematics,
    path: &AxisPath,
    schedule: &Schedule,
    options: &BlockOptions,
    progress: &dyn Progress,
) -> Result<Vec<Block>, BlocksError> {
    let pieces = by_piece(kinematics, path, schedule, options, progress)?;
    Ok(pieces.into_iter().flatten().collect())
}

/// Breaks a path as [`blocks`] does. Returns first the starting position, then the blocks of each piece of the path.
///
/// # Errors
///
/// [`BlocksError`].
pub fn by_piece(
    kinematics: &Kinematics,
    path: &AxisPath,
    schedule: &Schedule,
    options: &BlockOptions,
    progress: &dyn Progress,
) -> Result<Vec<Vec<Block>>, BlocksError> {
    validate::validate(path, schedule, options)?;
    let done = AtomicU64::new(0);
    let total = path.pieces.len() as u64;
    progress.step(Stage::Program, 0, total)?;
    // Pieces begin and end with a block, so that each is broken independently of the others.
    let pieces: Vec<(usize, (&AxisPiece, &SchedulePiece))> =
        path.pieces.iter().zip(&schedule.pieces).enumerate().collect();
    let broken: Vec<Vec<Block>> = pieces
        .into_par_iter()
        .map(|(index, (piece, rows))| {
            let controlled = deviation::ControlledPath {
                kinematics,
                poses: smooth_piece::SmoothPiece::new(kinematics, piece),
                control: options.control,
                lever: options.lever,
            };
            let ends = search::ends(&controlled, rows, options).map_err(|fault| {
                BlocksError::Tolerance {
                    piece: index,
                    s: fault.s,
                    deviation: fault.deviation,
                    tolerance: fault.tolerance,
                }
            })?;
            progress.step(Stage::Program, 1 + done.fetch_add(1, Ordering::Relaxed), total)?;
            Ok(controlled.blocks(&ends, rows))
        })
        .collect::<Result<_, BlocksError>>()?;
    let mut blocks: Vec<Vec<Block>> = vec![start(kinematics, path).into_iter().collect()];
    blocks.extend(broken);
    Ok(blocks)
}

/// Returns the starting position of a path as a block of duration 0.
fn start(kinematics: &Kinematics, path: &AxisPath) -> Option<Block> {
    let piece = path.pieces.first()?;
    let q = piece.nodes.first()?.q[0];
    Some(Block { motion: piece.motion, q, pose: kinematics.forward(&q), duration: 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::options::BlockInterpolation;
    use crate::machine::{Machine, Setup};
    use crate::sample_machine::ac_trunnion;
    use crate::types::{AxisNode, AxisVector, Motion, Silent};
    use nalgebra::Vector3;

    const OPTIONS: BlockOptions = BlockOptions::within(BlockInterpolation::RotaryLinear, 0.01);

    fn kinematics() -> Kinematics {
        let machine = Machine::new(ac_trunnion()).unwrap();
        Kinematics::new(&machine, &Setup::new(Vector3::zeros(), [0.0; 3], 100.0))
    }

    /// One axis from 0 to `travel` with unit speed, the others at `rest`.
    fn run(axis: usize, travel: f64, rest: AxisVector) -> (AxisPath, Schedule) {
        let mut rate = AxisVector::zeros();
        rate[axis] = 1.0;
        let zero = AxisVector::zeros();
        let at = |s: f64| AxisNode {
            s,
            q: [rest + rate * s, rate, zero, zero],
            tip_rate: 1.0,
            feed_rate: 1.0,
        };
        let nodes = vec![at(0.0), at(travel)];
        let rows = SchedulePiece {
            s: vec![0.0, travel],
            t: vec![0.0, travel],
            speed: vec![1.0; 2],
            acceleration: vec![0.0; 2],
            ..SchedulePiece::default()
        };
        let piece = AxisPiece { motion: Motion::Cut, source: 0, nodes };
        (AxisPath { pieces: vec![piece] }, Schedule { pieces: vec![rows] })
    }

    fn broken((path, schedule): &(AxisPath, Schedule), options: BlockOptions) -> Vec<Block> {
        blocks(&kinematics(), path, schedule, &options, &Silent).unwrap()
    }

    #[test]
    fn a_straight_move_is_one_block_whatever_the_control() {
        let line = run(0, 30.0, AxisVector::zeros());
        for control in [
            BlockInterpolation::Axes,
            BlockInterpolation::RotaryLinear,
            BlockInterpolation::GreatCircle,
        ] {
            let blocks = broken(&line, BlockOptions { control, ..OPTIONS });
            let durations: Vec<f64> = blocks.iter().map(|block| block.duration).collect();
            assert_eq!(durations, [0.0, 30.0]);
            assert_eq!(blocks[1].q, line.0.pieces[0].nodes[1].q[0]);
        }
    }

    /// The table turns under a tip 50 mm off its centre: chords of a circle, bow `R (1 - cos φ/2)`.
    #[test]
    fn a_turning_table_is_broken_where_the_chord_bows_by_the_tolerance() {
        let rest = AxisVector::from([50.0, 0.0, 0.0, 0.0, 0.0]);
        let turn = run(crate::machine::FIRST_ROTARY, 1.0, rest);
        let longest = 2.0 * (1.0 - 0.01 / 50.0_f64).acos();
        let blocks = broken(&turn, OPTIONS);
        let length = blocks[1].q[crate::machine::FIRST_ROTARY];
        assert!(length <= longest && length > 0.93 * longest, "{length} of {longest}");
        assert_eq!(blocks.len() - 1, 26);
        let axes = broken(&turn, BlockOptions { control: BlockInterpolation::Axes, ..OPTIONS });
        assert_eq!(axes.len() - 1, 1);
    }

    #[test]
    fn steps_and_times_are_limited_and_the_rest_is_shared() {
        let line = run(0, 10.0, AxisVector::zeros());
        let blocks = broken(&line, BlockOptions { max_step: 3.0, ..OPTIONS });
        assert!(blocks.iter().all(|block| block.duration <= 3.0));
        assert_eq!(blocks.len() - 1, 4);
        let shared = BlockOptions { max_duration: 3.0, min_duration: 1.5, ..OPTIONS };
        let blocks = broken(&line, shared);
        assert!(blocks[1..].iter().all(|block| block.duration >= 1.5));
        let total: f64 = blocks.iter().map(|block| block.duration).sum();
        assert!((total - 10.0).abs() < 1e-12);
    }

    #[test]
    fn a_link_that_is_rotary_linear_is_one_block() {
        let mut link = run(0, 10.0, AxisVector::zeros());
        link.0.pieces[0].motion = Motion::Link;
        assert_eq!(broken(&link, BlockOptions { max_step: 0.1, ..OPTIONS }).len() - 1, 1);
    }

    #[test]
    fn wrong_options_are_named() {
        let (path, schedule) = run(0, 10.0, AxisVector::zeros());
        let options = BlockOptions { max_turn: 0.0, ..OPTIONS };
        let error = blocks(&kinematics(), &path, &schedule, &options, &Silent).unwrap_err();
        assert!(error.to_string().contains("max_turn is 0"), "{error}");
    }
}
