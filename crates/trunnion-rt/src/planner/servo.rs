//! The servo side: evaluates polynomials, answers offers.

use super::block::MotionBlock;
use super::piece::{LETTERS, MotionPiece};
use super::shared::{PlanOffer, PlannerFault, PlannerState, Shared};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Offers taken that wait for their place.
const JUMPS: usize = 64;

/// Overrides of a servo cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSpeeds {
    /// Of the feed, up to 2; 0 holds.
    pub feed: f64,
    /// Of rapid moves, up to 1; 0 holds.
    pub rapid: f64,
}

/// Position and state of one servo cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ServoSample {
    /// Position of X Y Z A B C U V W \[mm or rad\].
    pub position: [f64; LETTERS],
    /// Velocity \[mm/s or rad/s\].
    pub velocity: [f64; LETTERS],
    /// Block that is run; the last one at rest.
    pub block: u32,
    /// True where no piece is played.
    pub rests: bool,
    /// True at rest behind the last block that was pushed.
    pub done: bool,
}

/// Servo side of a planner. A cycle allocates nothing, and waits for nothing.
#[derive(Debug)]
pub struct PlannerServo {
    shared: Arc<Shared>,
    /// Servo period \[s\].
    period: f64,
    round: u32,
    pushed: u32,
    aborts: u32,
    aborting: bool,
    /// Piece that is played, the time in it \[s\], and where the plan ends.
    cursor: usize,
    in_piece: f64,
    end: usize,
    piece: Option<MotionPiece>,
    /// Plan time at the start of the piece \[s\].
    before: f64,
    jumps: [Option<PlanOffer>; JUMPS],
    position: [f64; LETTERS],
    block: u32,
}

impl PlannerServo {
    pub(super) fn new(shared: Arc<Shared>, period: f64) -> Self {
        Self {
            shared,
            period,
            round: 0,
            pushed: 0,
            aborts: 0,
            aborting: false,
            cursor: 0,
            in_piece: 0.0,
            end: 0,
            piece: None,
            before: 0.0,
            jumps: [None; JUMPS],
            position: [0.0; LETTERS],
            block: 0,
        }
    }

    /// Sets the servo period \[s\]; one that is not positive is left out.
    pub fn set_period(&mut self, period: f64) {
        if period > 0.0 {
            self.period = period;
        }
    }

    /// Hands a block over. Returns `None` where the queue is full or an abort is under way.
    pub fn push(&mut self, block: &MotionBlock) -> Option<()> {
        if self.aborting {
            return None;
        }
        self.shared.blocks.send(&(*block, self.round))?;
        self.pushed = self.pushed.wrapping_add(1);
        Some(())
    }

    /// Forgets all blocks and stands at `position` \[mm or rad\] at once: for a machine at rest.
    pub fn reset(&mut self, position: [f64; LETTERS]) {
        self.round = self.round.wrapping_add(1);
        (self.pushed, self.cursor, self.end) = (0, 0, 0);
        (self.in_piece, self.before) = (0.0, 0.0);
        (self.piece, self.jumps, self.position) = (None, [None; JUMPS], position);
        self.aborting = false;
        self.publish();
        self.shared.round.store(self.round, Ordering::Release);
    }

    /// Sets the position of a machine at rest, whose blocks are all run \[mm or rad\].
    pub fn set_position(&mut self, position: [f64; LETTERS]) {
        self.position = position;
    }

    /// Returns the position \[mm or rad\].
    pub fn position(&self) -> [f64; LETTERS] {
        self.position
    }

    /// Begins to stop, and to forget all blocks then.
    pub fn abort(&mut self) {
        if !self.is_done() && !self.aborting {
            self.aborting = true;
            self.aborts = self.aborts.wrapping_add(1);
            self.shared.aborts.store(self.aborts, Ordering::Release);
        }
    }

    /// True until an abort has come to rest.
    pub fn is_aborting(&self) -> bool {
        self.aborting
    }

    /// Ends an abort whose stop is planned and played.
    fn end_abort(&mut self) {
        let planned = self.shared.planned_aborts.load(Ordering::Acquire) == self.aborts;
        if self.aborting && planned && self.cursor == self.end {
            self.aborting = false;
        }
    }

    /// The planning thread is in this round.
    fn is_planned(&self) -> bool {
        self.shared.planned_round.load(Ordering::Acquire) == self.round
    }

    /// True at rest behind the last block.
    pub fn is_done(&self) -> bool {
        let finished = self.shared.finished.load(Ordering::Acquire);
        let planned = self.is_planned() && finished == self.pushed;
        (planned || self.pushed == 0) && self.cursor == self.end && !self.aborting
    }

    /// Returns the next fault of the plan.
    pub fn fault(&mut self) -> Option<PlannerFault> {
        loop {
            let (fault, round) = self.shared.faults.take()?;
            if round == self.round {
                return Some(fault);
            }
        }
    }

    /// Returns the state of the plan.
    pub fn state(&self) -> PlannerState {
        self.shared.state()
    }

    /// Sets the largest deviation of the rotaries at corners \[rad\], from the next run on.
    pub fn set_axis_tolerance(&mut self, tolerance: f64) {
        if tolerance > 0.0 {
            self.shared.axis_tolerance.set(tolerance);
        }
    }

    /// Plays one servo cycle.
    pub fn cycle(&mut self, speeds: ServoSpeeds) -> ServoSample {
        self.shared.feed.set(speeds.feed);
        self.shared.rapid.set(speeds.rapid);
        while let Some(offer) = self.shared.offers.take::<PlanOffer>() {
            if offer.round == self.round {
                self.answer(offer);
            }
        }
        self.advance();
        self.publish();
        self.end_abort();
        let velocity = self.piece.map_or([0.0; LETTERS], |piece| piece.velocity(self.in_piece));
        if let Some(piece) = &self.piece {
            (self.position, self.block) = (piece.at(self.in_piece), piece.block);
        }
        ServoSample {
            position: self.position,
            velocity,
            block: self.block,
            rests: self.piece.is_none(),
            done: self.is_done(),
        }
    }

    /// Takes an offer unless its place is past.
    fn answer(&mut self, offer: PlanOffer) {
        let rests = self.cursor == self.end;
        let ahead = self.cursor < offer.replaces || (rests && self.cursor == offer.replaces);
        let slot = self.jumps.iter_mut().find(|jump| jump.is_none());
        let yes = match slot {
            Some(slot) if ahead => {
                *slot = Some(offer);
                self.end = offer.end;
                1
            }
            _ => 0,
        };
        if yes == 1 && rests {
            self.jump();
        }
        self.shared.answer.store(2 * u64::from(offer.number) + yes, Ordering::Release);
    }

    /// Goes on with the offer for the place at hand, if there is one. Its first piece may be replaced as well.
    fn jump(&mut self) {
        loop {
            let here = self.cursor;
            let found =
                |jump: &&mut Option<PlanOffer>| jump.is_some_and(|offer| offer.replaces == here);
            let Some(jump) = self.jumps.iter_mut().find(found) else { return };
            self.cursor = jump.take().map_or(here, |offer| offer.first);
        }
    }

    /// Moves on by a cycle.
    fn advance(&mut self) {
        if self.cursor == self.end {
            return;
        }
        self.in_piece += self.period;
        // A cycle may be longer than several pieces.
        while let Some(piece) = self.playing() {
            let left = self.in_piece - piece.duration;
            if left < 0.0 {
                return;
            }
            self.before += piece.duration;
            self.in_piece = left;
            self.cursor += 1;
            self.jump();
            self.piece = None;
            if self.cursor == self.end {
                // The plan rests here.
                (self.position, self.block) = (piece.at(piece.duration), piece.block);
                self.in_piece = 0.0;
                return;
            }
        }
    }

    /// Piece under the cursor.
    fn playing(&mut self) -> Option<MotionPiece> {
        if self.piece.is_none() {
            self.piece = self.shared.pieces.load(self.cursor);
        }
        self.piece
    }

    fn publish(&self) {
        self.shared.played.set(self.before + self.in_piece);
        self.shared.cursor.store(self.cursor, Ordering::Release);
    }
}
