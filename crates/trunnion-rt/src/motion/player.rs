//! Plays a plan in the servo cycle.

use super::piece::{LETTERS, MotionPiece};
use super::queue::{PieceReceiver, PlanEnd};
use super::rate::{PlanRate, RateBounds, RateError};

/// Position and state of one servo cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct MotionSample {
    /// Position of X Y Z A B C U V W \[mm or rad\].
    pub position: [f64; LETTERS],
    /// Velocity \[mm/s or rad/s\].
    pub velocity: [f64; LETTERS],
    /// Rate of the plan: 1 as planned, 0 at rest.
    pub rate: f64,
    /// Block that is played.
    pub block: u32,
    /// Plan time ahead in the queue, before this cycle \[s\].
    pub ahead: f64,
    /// The plan is slowed down because too little of it is in the queue.
    pub starved: bool,
}

/// Player of a plan. Belongs to the servo thread; a cycle allocates nothing and waits for nothing.
///
/// # Example
///
/// ```
/// use trunnion_rt::motion::{LETTERS, MotionPiece, MotionPlayer, RateBounds, piece_queue};
///
/// let (mut sender, receiver) = piece_queue(16);
/// let mut letters = [[0.0; 6]; LETTERS];
/// letters[0] = [0.0, 10.0, 0.0, 0.0, 0.0, 0.0]; // X at 10 mm/s
/// sender.send(&MotionPiece { duration: 2.0, letters, block: 1 })?;
/// let bounds = RateBounds { change: 20.0, bend: 400.0 };
/// let mut player = MotionPlayer::new(receiver, [0.0; LETTERS], bounds, 0.001)?;
/// let mut x = 0.0;
/// for _ in 0..4000 {
///     let sample = player.cycle(1.0);
///     x = sample.position[0];
/// }
/// // The plan ends at 20 mm at full speed, and nothing follows: the player came to rest just before its end.
/// assert!(x > 19.9 && x <= 20.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MotionPlayer {
    receiver: PieceReceiver,
    bounds: RateBounds,
    period: f64,
    rate: PlanRate,
    piece: Option<MotionPiece>,
    /// Time inside the piece \[s\].
    in_piece: f64,
    /// End of the piece, as the sender counts it: the same sum in the same order \[s\].
    piece_end: f64,
    /// Position while no piece was taken yet \[mm or rad\].
    start: [f64; LETTERS],
}

impl MotionPlayer {
    /// Begins at rest at `start` \[mm or rad\], with a servo period \[s\] and the bounds that the plan allows for.
    ///
    /// # Errors
    ///
    /// [`RateError`] for bounds or a period that cannot be kept.
    pub fn new(
        receiver: PieceReceiver,
        start: [f64; LETTERS],
        bounds: RateBounds,
        period: f64,
    ) -> Result<Self, RateError> {
        bounds.check(period)?;
        let rate = PlanRate::REST;
        Ok(Self {
            receiver,
            bounds,
            period,
            rate,
            piece: None,
            in_piece: 0.0,
            piece_end: 0.0,
            start,
        })
    }

    /// Plays one servo cycle with a wanted rate: the feed override, 0 for a feed hold. Rates outside 0 to 1 are
    /// brought inside, and no number is a stop.
    pub fn cycle(&mut self, wanted: f64) -> MotionSample {
        let wanted = if wanted.is_nan() { 0.0 } else { wanted.clamp(0.0, 1.0) };
        let end = self.receiver.plan_end();
        let ahead = self.ahead(end);
        if end.at_rest && ahead <= 0.0 {
            // Nothing moves here whatever the rate: the next plan begins at the wanted one.
            self.rate = PlanRate { rate: wanted, change: 0.0 };
            return self.sample(0.0, false);
        }
        let Self { rate, bounds, period, .. } = *self;
        let asked = rate.toward(wanted, bounds, period);
        // The wanted rate is taken if the plan can still be stopped behind it. Where not, the stop begins, which the cycle
        // before has left room for. A plan that ends at rest stops by itself.
        let step = rate.passed(asked, period);
        let plenty = end.at_rest || ahead >= step + bounds.longest_stop(period);
        let starved = !plenty && step + asked.stopping_time(bounds, period) > ahead;
        let next = if starved { rate.toward(0.0, bounds, period) } else { asked };
        self.advance(rate.passed(next, period).min(ahead));
        self.rate = next;
        self.sample(ahead, starved && wanted > 0.0)
    }

    /// Plan time between here and the end of what was sent \[s\].
    fn ahead(&self, end: PlanEnd) -> f64 {
        let piece = self.piece.map_or(0.0, |piece| piece.duration - self.in_piece);
        (end.time - self.piece_end + piece).max(0.0)
    }

    /// Moves on in the plan by `time` \[s\].
    fn advance(&mut self, time: f64) {
        self.in_piece += time;
        // A cycle may be longer than several pieces.
        while let Some(left) = self.left() {
            let Some(next) = self.receiver.take() else {
                self.in_piece -= left;
                return;
            };
            self.in_piece = left;
            self.piece_end += next.duration;
            self.piece = Some(next);
        }
    }

    /// Time that the plan is past the end of its piece \[s\]; `None` inside the piece.
    fn left(&self) -> Option<f64> {
        let duration = self.piece.map_or(0.0, |piece| piece.duration);
        let left = self.in_piece - duration;
        let moving = self.piece.is_some() || self.in_piece > 0.0;
        (moving && left > 0.0).then_some(left)
    }

    fn sample(&self, ahead: f64, starved: bool) -> MotionSample {
        let rate = self.rate.rate;
        let (position, velocity, block) = match &self.piece {
            Some(piece) => {
                let velocity = piece.velocity(self.in_piece).map(|value| value * rate);
                (piece.at(self.in_piece), velocity, piece.block)
            }
            None => (self.start, [0.0; LETTERS], 0),
        };
        MotionSample { position, velocity, rate, block, ahead, starved }
    }
}
