//! Lock-free queue of a fixed size between one planning thread and one servo thread.

use super::piece::{COEFFICIENTS, LETTERS, MotionPiece, PieceError};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// Numbers of a piece in a slot: its letters, duration and block.
const NUMBERS: usize = LETTERS * COEFFICIENTS + 2;

/// Largest step between two pieces that rounding explains \[mm or rad\].
const JOINT_STEP: f64 = 1e-9;

/// Slot of the queue. Its numbers are atomic one by one; the counters say which thread owns the slot.
#[derive(Debug)]
struct PieceSlot([AtomicU64; NUMBERS]);

impl PieceSlot {
    fn empty() -> Self {
        Self([const { AtomicU64::new(0) }; NUMBERS])
    }

    fn store(&self, piece: &MotionPiece) {
        let letters = piece.letters.iter().flatten().map(|number| number.to_bits());
        let numbers = letters.chain([piece.duration.to_bits(), u64::from(piece.block)]);
        // The counter that is published afterwards orders these writes.
        self.0.iter().zip(numbers).for_each(|(slot, number)| slot.store(number, Ordering::Relaxed));
    }

    fn load(&self) -> MotionPiece {
        let mut piece =
            MotionPiece { duration: 0.0, letters: [[0.0; COEFFICIENTS]; LETTERS], block: 0 };
        let mut numbers = self.0.iter().map(|slot| slot.load(Ordering::Relaxed));
        for (number, bits) in piece.letters.iter_mut().flatten().zip(&mut numbers) {
            *number = f64::from_bits(bits);
        }
        piece.duration = numbers.next().map_or(0.0, f64::from_bits);
        piece.block =
            numbers.next().and_then(|block| u32::try_from(block).ok()).unwrap_or_default();
        piece
    }
}

/// Memory that both threads share.
#[derive(Debug)]
struct SharedQueue {
    slots: Box<[PieceSlot]>,
    /// Pieces sent and pieces taken since the start; each is written by one thread.
    sent: AtomicUsize,
    taken: AtomicUsize,
    /// Time of all pieces sent since the start, as bits of a number \[s\]; negative where the plan ends at rest.
    sent_time: AtomicU64,
}

impl SharedQueue {
    fn slot(&self, count: usize) -> Option<&PieceSlot> {
        self.slots.get(count % self.slots.len().max(1))
    }
}

/// End of the plan as far as it was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlanEnd {
    /// Time since the start of the plan \[s\].
    pub(super) time: f64,
    /// The plan itself comes to rest there.
    pub(super) at_rest: bool,
}

/// End of the queue for the planning thread.
#[derive(Debug)]
pub struct PieceSender {
    queue: Arc<SharedQueue>,
    /// End of the last piece \[mm or rad\].
    end: Option<[f64; LETTERS]>,
    time: f64,
}

/// End of the queue for the servo thread.
#[derive(Debug)]
pub struct PieceReceiver {
    queue: Arc<SharedQueue>,
}

/// Makes a queue for `pieces` pieces, at least one. Allocates all its memory here.
pub fn piece_queue(pieces: usize) -> (PieceSender, PieceReceiver) {
    let slots = (0..pieces.max(1)).map(|_| PieceSlot::empty()).collect();
    let (sent, taken) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let sent_time = AtomicU64::new(0.0_f64.to_bits());
    let queue = Arc::new(SharedQueue { slots, sent, taken, sent_time });
    let receiver = PieceReceiver { queue: Arc::clone(&queue) };
    (PieceSender { queue, end: None, time: 0.0 }, receiver)
}

impl PieceSender {
    /// Sends a piece.
    ///
    /// # Errors
    ///
    /// [`PieceError`] for a piece that is no motion, that does not begin where the one before ends, or that finds no
    /// room. The piece is then not sent.
    pub fn send(&mut self, piece: &MotionPiece) -> Result<(), PieceError> {
        piece.check()?;
        self.joins(piece)?;
        let pieces = self.queue.slots.len();
        let sent = self.queue.sent.load(Ordering::Relaxed);
        // Slots up to here are free: the servo thread has read them.
        let taken = self.queue.taken.load(Ordering::Acquire);
        let room = sent.wrapping_sub(taken) < pieces;
        let slot = self.queue.slot(sent).filter(|_| room);
        slot.ok_or(PieceError::QueueFull { pieces })?.store(piece);
        self.end = Some(piece.at(piece.duration));
        self.time += piece.duration;
        // The count publishes the slot, and the time publishes the count: a player that knows of plan time finds it.
        self.queue.sent.store(sent.wrapping_add(1), Ordering::Release);
        let time = if piece.ends_at_rest() { -self.time } else { self.time };
        self.queue.sent_time.store(time.to_bits(), Ordering::Release);
        Ok(())
    }

    fn joins(&self, piece: &MotionPiece) -> Result<(), PieceError> {
        let Some(end) = self.end else { return Ok(()) };
        for (letter, (from, to)) in end.into_iter().zip(piece.at(0.0)).enumerate() {
            let step = (to - from).abs();
            // Positions are as large as their rounding is.
            if step > JOINT_STEP * from.abs().max(1.0) {
                return Err(PieceError::Step { block: piece.block, letter, step });
            }
        }
        Ok(())
    }
}

impl PieceReceiver {
    /// Takes the next piece; `None` where none is waiting.
    pub(super) fn take(&mut self) -> Option<MotionPiece> {
        let taken = self.queue.taken.load(Ordering::Relaxed);
        let sent = self.queue.sent.load(Ordering::Acquire);
        if sent == taken {
            return None;
        }
        let piece = self.queue.slot(taken)?.load();
        // The slot is free from here on.
        self.queue.taken.store(taken.wrapping_add(1), Ordering::Release);
        Some(piece)
    }

    /// Returns the end of the plan that was sent.
    pub(super) fn plan_end(&self) -> PlanEnd {
        let time = f64::from_bits(self.queue.sent_time.load(Ordering::Acquire));
        PlanEnd { time: time.abs(), at_rest: time < 0.0 }
    }

    /// Returns the number of pieces that wait.
    pub fn waiting(&self) -> usize {
        let sent = self.queue.sent.load(Ordering::Acquire);
        sent.wrapping_sub(self.queue.taken.load(Ordering::Relaxed))
    }
}
