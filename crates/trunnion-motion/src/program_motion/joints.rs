//! Joints along a path of words, with their derivatives.

use super::block::{BlockCoordinates, LETTERS, NAMES};
use super::leg::{LetterVector, SHORTEST};
use crate::inverse::{Inverse, InverseError, PoseRefusal};
use crate::machine::{FIRST_ROTARY, Kinematics, Machine, RotaryPair, SECOND_ROTARY, Setup};
use crate::math;
use crate::math::jet::Jet;
use crate::types::{AXES, AxisVector};
use nalgebra::{Point3, Vector3};

/// Distance outside travel that rounding explains \[mm or rad\]: programs are written with four decimals.
const ROUNDING: f64 = 1e-3;

/// Reason why words have no joints.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum WordsFault {
    /// The kinematics refuses them.
    Refused(PoseRefusal),
    /// A letter moves that the machine has no axis for.
    NoAxis {
        /// Index of the letter in X Y Z A B C U V W.
        letter: usize,
    },
}

/// Maps words to joints, for one kind of coordinates and one tool at a time.
#[derive(Debug, Clone)]
pub struct WordJoints {
    /// Letter of each axis.
    letters: [usize; AXES],
    coordinates: BlockCoordinates,
    length: f64,
    /// With the tool of this length.
    inverse: Inverse,
}

impl WordJoints {
    /// Starts with plain axes, and with a machine without a tool. `letters` are those of the axes; one that no position has
    /// stays at zero.
    pub fn new(inverse: Inverse, letters: [char; AXES]) -> Self {
        let index = |letter| NAMES.iter().position(|name| *name == letter).unwrap_or(LETTERS);
        let (letters, coordinates, length) = (letters.map(index), BlockCoordinates::Axes, 0.0);
        Self { letters, coordinates, length, inverse }
    }

    fn machine(&self) -> &Machine {
        self.inverse.kinematics().machine()
    }

    /// True if the mapping is that of a block with these coordinates and this tool.
    pub(super) fn suits(&self, coordinates: BlockCoordinates, length: f64) -> bool {
        self.coordinates == coordinates
            && (coordinates == BlockCoordinates::Axes || self.length.to_bits() == length.to_bits())
    }

    /// Takes other coordinates, and a tool of `length` \[mm\].
    ///
    /// # Errors
    ///
    /// [`InverseError::NotFinite`].
    pub fn set(&mut self, coordinates: BlockCoordinates, length: f64) -> Result<(), InverseError> {
        if self.length.to_bits() != length.to_bits() {
            let setup = Setup { tool_length: length, ..Setup::default() };
            self.inverse = Inverse::new(&Kinematics::new(self.machine(), &setup))?;
        }
        (self.coordinates, self.length) = (coordinates, length);
        Ok(())
    }

    /// Returns a refusal with the names of the axes.
    pub(super) fn named(&self, refusal: PoseRefusal) -> InverseError {
        self.inverse.named(refusal)
    }

    fn words(&self, letters: &LetterVector) -> AxisVector {
        AxisVector::from(self.letters.map(|letter| letters.get(letter).copied().unwrap_or(0.0)))
    }

    /// Returns the joints for words, inside travel.
    pub(super) fn at(&self, letters: &LetterVector) -> Result<AxisVector, WordsFault> {
        let words = self.words(letters);
        let joints = match self.coordinates {
            BlockCoordinates::Axes => words,
            BlockCoordinates::Tip => {
                let rotaries = RotaryPair::new(words[FIRST_ROTARY], words[SECOND_ROTARY]);
                let tip = Point3::from(self.tip(&words));
                self.inverse.at_rotaries_or_refused(&tip, rotaries).map_err(WordsFault::Refused)?
            }
        };
        if !joints.iter().all(|joint| joint.is_finite()) {
            return Err(WordsFault::Refused(PoseRefusal::NotFinite { what: "words" }));
        }
        let outside = self.machine().travel_excess(&joints);
        match outside.filter(|excess| excess.excess > ROUNDING) {
            Some(excess) => Err(WordsFault::Refused(PoseRefusal::OutOfTravel(excess))),
            None => Ok(joints),
        }
    }

    /// Returns the tip in the table frame for words that are its coordinates.
    fn tip(&self, words: &AxisVector) -> Vector3<f64> {
        // Words count the length along z.
        let xyz = Vector3::new(words[0], words[1], words[2]);
        xyz + self.machine().gauge.coords - Vector3::z() * self.length
    }

    /// Refuses a move of letters that have no axis.
    pub(super) fn has_axes(
        &self,
        from: &LetterVector,
        to: &LetterVector,
    ) -> Result<(), WordsFault> {
        let moves = |letter: &usize| {
            !self.letters.contains(letter) && (to[*letter] - from[*letter]).abs() > SHORTEST
        };
        (0..LETTERS).find(moves).map_or(Ok(()), |letter| Err(WordsFault::NoAxis { letter }))
    }

    /// Returns the joints along words with their derivatives.
    pub(super) fn jets(
        &self,
        letters: &[LetterVector; 4],
    ) -> Result<[AxisVector; 4], InverseError> {
        let words = letters.each_ref().map(|order| self.words(order));
        if self.coordinates == BlockCoordinates::Axes {
            return Ok(words);
        }
        let mut tip = words.map(|word| Vector3::new(word[0], word[1], word[2]));
        tip[0] = self.tip(&words[0]);
        let rotaries = [FIRST_ROTARY, SECOND_ROTARY]
            .map(|axis| Jet::from_derivatives(words.map(|word| word[axis])));
        self.inverse.with_rotaries(&tip, rotaries)
    }

    /// Returns the largest lever of the rotaries at words: how far the tip moves per angle \[mm/rad\].
    pub(super) fn lever(&self, letters: &LetterVector) -> f64 {
        const TURN: f64 = 1e-5;
        let joints = self.at(letters).unwrap_or_else(|_| self.words(letters));
        let tip = |joints: &AxisVector| self.inverse.kinematics().forward(joints).tip;
        let levers = [FIRST_ROTARY, SECOND_ROTARY].map(|axis| {
            let mut turned = joints;
            turned[axis] += TURN;
            (tip(&turned) - tip(&joints)).norm() / TURN
        });
        math::hypot(levers[0], levers[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::samples::ac_trunnion;

    #[test]
    fn derivatives_agree_with_differences() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        let bare = Inverse::new(&Kinematics::new(&machine, &Setup::default())).unwrap();
        let mut words = WordJoints::new(bare, ['X', 'Y', 'Z', 'C', 'A']);
        words.set(BlockCoordinates::Tip, 120.0).unwrap();
        let letters = |s: f64| {
            let mut at = LetterVector::zeros();
            at[0] = s;
            at[1] = 20.0 + 2.0 * s.sin();
            at[2] = -300.0;
            at[3] = 0.3 + 0.1 * s;
            at[5] = 0.2 * s * s;
            at
        };
        let jets = |s: f64| {
            let h = 1e-3;
            let [a, b, c, d, e] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| letters(s + k * h));
            let second = (b - c * 2.0 + d) / (h * h);
            let third = (e - d * 2.0 + b * 2.0 - a) / (2.0 * h.powi(3));
            words.jets(&[c, (d - b) / (2.0 * h), second, third]).unwrap()
        };
        let [low, at, high] = [0.499, 0.5, 0.501].map(jets);
        assert!((at[0] - words.at(&letters(0.5)).unwrap()).amax() < 1e-9);
        for order in 0..2 {
            let slope = (high[order] - low[order]) / 2e-3;
            assert!((slope - at[order + 1]).amax() < 1e-4, "{order}: {slope} {}", at[order + 1]);
        }
    }
}
