//! Memory that both threads of a planner share.

use super::block::BLOCK_NUMBERS;
use super::numbers::{AtomicReal, NumberQueue, Packed, Slots};
use super::piece::{COEFFICIENTS, LETTERS, MotionPiece};
use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering};

/// Numbers of a piece.
const PIECE_NUMBERS: usize = LETTERS * COEFFICIENTS + 2;

/// Numbers of an offer and of a fault.
const OFFER_NUMBERS: usize = 5;
const FAULT_NUMBERS: usize = 5;

impl Packed<PIECE_NUMBERS> for MotionPiece {
    fn pack(&self) -> [u64; PIECE_NUMBERS] {
        let letters = self.letters.iter().flatten().map(|number| number.to_bits());
        let mut numbers = [0; PIECE_NUMBERS];
        let all = letters.chain([self.duration.to_bits(), u64::from(self.block)]);
        numbers.iter_mut().zip(all).for_each(|(slot, number)| *slot = number);
        numbers
    }

    fn unpack(numbers: &[u64; PIECE_NUMBERS]) -> Self {
        let mut piece = Self { duration: 0.0, letters: [[0.0; COEFFICIENTS]; LETTERS], block: 0 };
        let mut rest = numbers.iter().copied();
        for (number, bits) in piece.letters.iter_mut().flatten().zip(&mut rest) {
            *number = f64::from_bits(bits);
        }
        piece.duration = rest.next().map_or(0.0, f64::from_bits);
        piece.block = rest.next().and_then(|block| u32::try_from(block).ok()).unwrap_or_default();
        piece
    }
}

/// Offer to go on with other pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PlanOffer {
    /// Number of the offer, and the round that it belongs to.
    pub(super) number: u32,
    pub(super) round: u32,
    /// First piece of the present plan that is replaced; one behind its last to follow it.
    pub(super) replaces: usize,
    /// First piece that takes its place, and one behind the last: the plan rests there.
    pub(super) first: usize,
    pub(super) end: usize,
}

impl Packed<OFFER_NUMBERS> for PlanOffer {
    fn pack(&self) -> [u64; OFFER_NUMBERS] {
        let [replaces, first, end] =
            [self.replaces, self.first, self.end].map(|number| number as u64);
        [u64::from(self.number), u64::from(self.round), replaces, first, end]
    }

    fn unpack(numbers: &[u64; OFFER_NUMBERS]) -> Self {
        let small = |at: usize| u32::try_from(numbers[at]).unwrap_or_default();
        let [replaces, first, end] =
            [2, 3, 4].map(|at: usize| usize::try_from(numbers[at]).unwrap_or_default());
        Self { number: small(0), round: small(1), replaces, first, end }
    }
}

/// Reason why a program cannot go on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PlannerFault {
    /// Block that is refused; the tool stops before it.
    pub block: u32,
    /// Number of the reason, as [`RefusalCode`](crate::RefusalCode).
    pub code: i32,
    /// Axis that is outside its travel, or letter without an axis; -1 for none.
    pub axis: i32,
    /// Distance outside \[mm or rad\].
    pub excess: f64,
}

impl Packed<FAULT_NUMBERS> for (PlannerFault, u32) {
    fn pack(&self) -> [u64; FAULT_NUMBERS] {
        let (fault, round) = self;
        [
            u64::from(fault.block),
            u64::from(fault.code.cast_unsigned()),
            u64::from(fault.axis.cast_unsigned()),
            fault.excess.to_bits(),
            u64::from(*round),
        ]
    }

    fn unpack(numbers: &[u64; FAULT_NUMBERS]) -> Self {
        let small = |at: usize| u32::try_from(numbers[at]).unwrap_or_default();
        let [code, axis] = [1, 2].map(|at| small(at).cast_signed());
        let excess = f64::from_bits(numbers[3]);
        (PlannerFault { block: small(0), code, axis, excess }, small(4))
    }
}

/// State of the plan for people.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct PlannerState {
    /// Plan time ahead of the servo thread, down to rest \[s\].
    pub ahead: f64,
    /// Longest turn of the planning thread \[s\].
    pub longest_turn: f64,
    /// Time that the planning thread has worked \[s\].
    pub worked: f64,
    /// Number of plans that came too late to be taken.
    pub late: u32,
    /// Limit that binds a little ahead of the tool, as [`PlanLimit::number`](super::PlanLimit::number).
    pub limit: u32,
}

/// Both ends' memory.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) blocks: NumberQueue<BLOCK_NUMBERS>,
    pub(super) pieces: Slots<PIECE_NUMBERS>,
    pub(super) offers: NumberQueue<OFFER_NUMBERS>,
    pub(super) faults: NumberQueue<FAULT_NUMBERS>,
    /// The last offer that was answered, and whether it was taken: twice its number, one more for a yes.
    pub(super) answer: AtomicU64,
    /// Round that the servo thread is in, and the one that the planning thread is in. A round ends with a reset.
    pub(super) round: AtomicU32,
    pub(super) planned_round: AtomicU32,
    /// Aborts asked for, and those whose stop is planned.
    pub(super) aborts: AtomicU32,
    pub(super) planned_aborts: AtomicU32,
    /// Overrides of feed and rapid moves; 0 or below is a hold.
    pub(super) feed: AtomicReal,
    pub(super) rapid: AtomicReal,
    /// Plan time played in this round, and the piece that is played.
    pub(super) played: AtomicReal,
    pub(super) cursor: AtomicUsize,
    /// Blocks of this round whose plan is complete, down to rest.
    pub(super) finished: AtomicU32,
    pub(super) ahead: AtomicReal,
    pub(super) longest_turn: AtomicReal,
    pub(super) worked: AtomicReal,
    pub(super) late: AtomicU32,
    pub(super) limit: AtomicU32,
    /// Largest deviation of the rotaries at corners \[rad\].
    pub(super) axis_tolerance: AtomicReal,
}

impl Shared {
    pub(super) fn new(blocks: usize, pieces: usize, axis_tolerance: f64) -> Self {
        Self {
            blocks: NumberQueue::new(blocks),
            pieces: Slots::new(pieces),
            offers: NumberQueue::new(4),
            faults: NumberQueue::new(4),
            answer: AtomicU64::new(0),
            round: AtomicU32::new(0),
            planned_round: AtomicU32::new(0),
            aborts: AtomicU32::new(0),
            planned_aborts: AtomicU32::new(0),
            feed: AtomicReal::new(1.0),
            rapid: AtomicReal::new(1.0),
            played: AtomicReal::new(0.0),
            cursor: AtomicUsize::new(0),
            finished: AtomicU32::new(0),
            ahead: AtomicReal::new(0.0),
            longest_turn: AtomicReal::new(0.0),
            worked: AtomicReal::new(0.0),
            late: AtomicU32::new(0),
            limit: AtomicU32::new(0),
            axis_tolerance: AtomicReal::new(axis_tolerance),
        }
    }

    pub(super) fn state(&self) -> PlannerState {
        PlannerState {
            ahead: self.ahead.get(),
            longest_turn: self.longest_turn.get(),
            worked: self.worked.get(),
            late: self.late.load(Ordering::Relaxed),
            limit: self.limit.load(Ordering::Relaxed),
        }
    }
}
