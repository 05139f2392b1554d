//! One piece of a planned motion.

/// Letters of a pose in the order of `LinuxCNC`: X Y Z A B C U V W.
pub const LETTERS: usize = 9;

/// Coefficients of a letter: a quintic holds position, velocity and acceleration at both ends.
pub(crate) const COEFFICIENTS: usize = 6;

/// Velocity and acceleration that count as none \[mm or rad, and s\]: rounding of a quintic's ends.
const REST: f64 = 1e-6;

/// Piece of a planned motion: every letter is a polynomial of the plan's time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionPiece {
    /// Duration at full rate \[s\].
    pub duration: f64,
    /// Coefficients by letter, the constant first: `x(t) = c0 + c1 t + .. + c5 t^5` with t from 0 to `duration`,
    /// in mm or rad, and s.
    pub letters: [[f64; COEFFICIENTS]; LETTERS],
    /// Block that the piece belongs to.
    pub block: u32,
}

/// Reason why a piece cannot be played.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PieceError {
    /// The duration is not a positive finite number.
    #[error("a piece of block {block} lasts {duration} s; a piece needs a positive duration")]
    Duration {
        /// Block of the piece.
        block: u32,
        /// Its duration \[s\].
        duration: f64,
    },
    /// A coefficient is NaN or infinite.
    #[error(
        "a piece of block {block} has a coefficient of letter {letter} that is no finite number"
    )]
    NotFinite {
        /// Block of the piece.
        block: u32,
        /// Index of the letter in X Y Z A B C U V W.
        letter: usize,
    },
    /// The piece does not begin where the piece before ends.
    #[error(
        "a piece of block {block} begins {step} mm or rad away from the end of the piece before it, along letter {letter}"
    )]
    Step {
        /// Block of the piece.
        block: u32,
        /// Index of the letter in X Y Z A B C U V W.
        letter: usize,
        /// Distance between both \[mm or rad\].
        step: f64,
    },
    /// The queue has no free slot; the piece was not taken.
    #[error(
        "the motion queue is full with {pieces} pieces; send the piece again after the servo thread has taken one"
    )]
    QueueFull {
        /// Number of slots.
        pieces: usize,
    },
}

impl MotionPiece {
    /// Returns the position of every letter at `time` of the piece \[s\], in mm or rad.
    #[inline]
    pub fn at(&self, time: f64) -> [f64; LETTERS] {
        self.letters.map(|letter| letter.into_iter().rev().fold(0.0, |sum, c| sum * time + c))
    }

    /// Returns the velocity of every letter at `time` of the piece \[s\], in mm/s or rad/s.
    #[inline]
    pub fn velocity(&self, time: f64) -> [f64; LETTERS] {
        self.letters.map(|[_, c1, c2, c3, c4, c5]| {
            (((5.0 * c5 * time + 4.0 * c4) * time + 3.0 * c3) * time + 2.0 * c2) * time + c1
        })
    }

    /// True if velocity and acceleration vanish at the end, so that the rate of the plan moves nothing there.
    pub(super) fn ends_at_rest(&self) -> bool {
        let time = self.duration;
        let acceleration = self.letters.map(|[_, _, c2, c3, c4, c5]| {
            ((20.0 * c5 * time + 12.0 * c4) * time + 6.0 * c3) * time + 2.0 * c2
        });
        self.velocity(time).iter().chain(&acceleration).all(|value| value.abs() <= REST)
    }

    /// Checks the numbers of a piece.
    ///
    /// # Errors
    ///
    /// [`PieceError::Duration`], [`PieceError::NotFinite`].
    pub(super) fn check(&self) -> Result<(), PieceError> {
        let Self { duration, letters, block } = *self;
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(PieceError::Duration { block, duration });
        }
        let none = |letter: &[f64; COEFFICIENTS]| !letter.iter().all(|c| c.is_finite());
        letters
            .iter()
            .position(none)
            .map_or(Ok(()), |letter| Err(PieceError::NotFinite { block, letter }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_by_hand() {
        let mut letters = [[0.0; COEFFICIENTS]; LETTERS];
        letters[1] = [1.0, -2.0, 0.0, 4.0, 0.0, 1.0];
        let piece = MotionPiece { duration: 2.0, letters, block: 7 };
        // 1 - 4 + 32 + 32 and -2 + 48 + 80.
        assert_eq!(piece.at(2.0)[1].to_bits(), 61.0_f64.to_bits());
        assert_eq!(piece.velocity(2.0)[1].to_bits(), 126.0_f64.to_bits());
        assert!(piece.check().is_ok());
        let bad = MotionPiece { duration: 0.0, ..piece };
        assert_eq!(bad.check(), Err(PieceError::Duration { block: 7, duration: 0.0 }));
    }
}
