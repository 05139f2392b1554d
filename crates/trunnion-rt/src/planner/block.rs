//! Blocks of a program in the queue between both threads.

use super::numbers::Packed;
use super::piece::LETTERS;
use trunnion::program_motion::{BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart};

pub(super) use trunnion::program_motion::MotionBlock;

/// Numbers of a block in a slot of the queue, the round of the queue among them.
pub(super) const BLOCK_NUMBERS: usize = 2 * LETTERS + 16;

impl Packed<BLOCK_NUMBERS> for (MotionBlock, u32) {
    fn pack(&self) -> [u64; BLOCK_NUMBERS] {
        let (block, round) = self;
        let (center, normal, turns) = match block.shape {
            BlockShape::Line => ([0.0; 3], [0.0; 3], i32::MAX),
            BlockShape::Arc { center, normal, turns } => (center, normal, turns),
        };
        let reals = block.start.iter().chain(&block.end).chain(&center).chain(&normal).chain([
            &block.speed,
            &block.tolerance,
            &block.tool_length,
        ]);
        let begins = match block.begins {
            BlockStart::Flow => 0,
            BlockStart::Marked => 1,
            BlockStart::Rest => 2,
        };
        let ending = match block.ending {
            BlockEnding::Stop => 0,
            BlockEnding::Exact => 1,
            BlockEnding::Blend => 2,
        };
        let whole = [
            u64::from(block.number),
            u64::from(*round),
            u64::from(turns.cast_unsigned()),
            match block.kind {
                BlockKind::Feed => 0,
                BlockKind::Rapid => 1,
                BlockKind::Timed => 2,
            },
            begins,
            ending,
            u64::from(block.coordinates == BlockCoordinates::Tip),
        ];
        let mut numbers = [0; BLOCK_NUMBERS];
        let all = reals.map(|real| real.to_bits()).chain(whole);
        numbers.iter_mut().zip(all).for_each(|(slot, number)| *slot = number);
        numbers
    }

    fn unpack(numbers: &[u64; BLOCK_NUMBERS]) -> Self {
        let mut rest = numbers.iter().copied();
        let mut next = || rest.next().unwrap_or_default();
        let mut reals = [0.0; 2 * LETTERS + 9];
        for real in &mut reals {
            *real = f64::from_bits(next());
        }
        let small = |number: u64| u32::try_from(number).unwrap_or_default();
        let (number, round, turns) = (small(next()), small(next()), small(next()).cast_signed());
        let kind = match next() {
            0 => BlockKind::Feed,
            1 => BlockKind::Rapid,
            _ => BlockKind::Timed,
        };
        let begins = match next() {
            0 => BlockStart::Flow,
            1 => BlockStart::Marked,
            _ => BlockStart::Rest,
        };
        let ending = match next() {
            0 => BlockEnding::Stop,
            1 => BlockEnding::Exact,
            _ => BlockEnding::Blend,
        };
        let coordinates = if next() == 1 { BlockCoordinates::Tip } else { BlockCoordinates::Axes };
        let letters = |at: usize| std::array::from_fn(|letter| reals[at + letter]);
        let triple = |at: usize| std::array::from_fn(|letter| reals[at + letter]);
        let at = 2 * LETTERS;
        let shape = match turns {
            i32::MAX => BlockShape::Line,
            _ => BlockShape::Arc { center: triple(at), normal: triple(at + 3), turns },
        };
        let block = MotionBlock {
            number,
            start: letters(0),
            end: letters(LETTERS),
            shape,
            kind,
            speed: reals[at + 6],
            begins,
            ending,
            tolerance: reals[at + 7],
            coordinates,
            tool_length: reals[at + 8],
        };
        (block, round)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_survives_its_slot() {
        let arc = BlockShape::Arc { center: [1.0, 2.0, 3.0], normal: [0.0, 0.0, -1.0], turns: -2 };
        for (shape, kind) in [(BlockShape::Line, BlockKind::Rapid), (arc, BlockKind::Timed)] {
            let block = MotionBlock {
                number: 7,
                start: std::array::from_fn(|letter| letter as f64),
                end: std::array::from_fn(|letter| -0.5 * letter as f64),
                shape,
                kind,
                speed: 50.0,
                begins: BlockStart::Rest,
                ending: BlockEnding::Exact,
                tolerance: 0.01,
                coordinates: BlockCoordinates::Tip,
                tool_length: 120.0,
            };
            assert_eq!(<(MotionBlock, u32)>::unpack(&(block, 3).pack()), (block, 3));
        }
    }
}
