//! One piece of a planned motion.

pub(super) use trunnion::program_motion::LETTERS;

/// Coefficients of a letter: a quintic holds position, velocity and acceleration at both ends.
pub(super) const COEFFICIENTS: usize = 6;

/// Piece of a planned motion: every letter is a polynomial of the plan's time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MotionPiece {
    /// Duration at full rate \[s\].
    pub(super) duration: f64,
    /// Coefficients by letter, the constant first: `x(t) = c0 + c1 t + .. + c5 t^5` with t from 0 to `duration`,
    /// in mm or rad, and s.
    pub(super) letters: [[f64; COEFFICIENTS]; LETTERS],
    /// Block that the piece belongs to.
    pub(super) block: u32,
}

impl MotionPiece {
    /// Returns the position of every letter at `time` of the piece \[s\], in mm or rad.
    #[inline]
    pub(super) fn at(&self, time: f64) -> [f64; LETTERS] {
        self.letters.map(|letter| letter.into_iter().rev().fold(0.0, |sum, c| sum * time + c))
    }

    /// Returns the velocity of every letter at `time` of the piece \[s\], in mm/s or rad/s.
    #[inline]
    pub(super) fn velocity(&self, time: f64) -> [f64; LETTERS] {
        self.letters.map(|[_, c1, c2, c3, c4, c5]| {
            (((5.0 * c5 * time + 4.0 * c4) * time + 3.0 * c3) * time + 2.0 * c2) * time + c1
        })
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
    }
}
