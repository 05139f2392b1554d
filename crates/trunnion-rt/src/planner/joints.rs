//! Joints along a path of words, with their derivatives.

use super::leg::{LetterVector, SHORTEST};
use super::piece::LETTERS;
use crate::kinematics::MachineKinematics;
use crate::refusal::Refusal;
use crate::switched::KinematicsMode;
use trunnion::inverse::{Inverse, InverseError};
use trunnion::machine::{FIRST_ROTARY, Kinematics, Machine, SECOND_ROTARY, Setup, TravelExcess};
use trunnion::math;
use trunnion::math::jet::Jet;
use trunnion::nalgebra::Vector3;
use trunnion::nc::read::AxisWords;
use trunnion::nc::write::WordsError;
use trunnion::types::{AXES, AxisVector};

/// Letters in the order of a pose.
const NAMES: &str = "XYZABCUVW";

/// Distance outside travel that rounding explains \[mm or rad\]: programs are written with four decimals.
const ROUNDING: f64 = 1e-3;

/// Reason why words have no joints.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum WordsFault {
    /// The kinematics refuses them.
    Refused(Refusal),
    /// A letter moves that the machine has no axis for.
    NoAxis {
        /// Index of the letter in X Y Z A B C U V W.
        letter: usize,
    },
}

/// Maps words to joints, for one kind of kinematics and one tool at a time.
#[derive(Debug, Clone)]
pub(super) struct WordJoints {
    kinematics: MachineKinematics,
    /// Letter of each axis.
    letters: [usize; AXES],
    mode: KinematicsMode,
    length: f64,
    /// With the tool of this length.
    inverse: Inverse,
}

impl WordJoints {
    pub(super) fn new(kinematics: MachineKinematics) -> Result<Self, WordsError> {
        let words = AxisWords::of(kinematics.machine())?;
        let letters = words.0.each_ref().map(|word| NAMES.find(word.letter).unwrap_or(LETTERS));
        let inverse = kinematics.bare().clone();
        let (mode, length) = (KinematicsMode::Axes, 0.0);
        Ok(Self { kinematics, letters, mode, length, inverse })
    }

    pub(super) fn machine(&self) -> &Machine {
        self.kinematics.machine()
    }

    /// True if the mapping is the one of this kind and tool.
    pub(super) fn suits(&self, mode: KinematicsMode, length: f64) -> bool {
        self.mode == mode
            && (mode == KinematicsMode::Axes || self.length.to_bits() == length.to_bits())
    }

    /// Takes another kind of kinematics and tool.
    pub(super) fn set(&mut self, mode: KinematicsMode, length: f64) -> Result<(), InverseError> {
        if self.length.to_bits() != length.to_bits() {
            let setup = Setup { tool_length: length, ..Setup::default() };
            self.inverse = Inverse::new(&Kinematics::new(self.machine(), &setup))?;
        }
        (self.mode, self.length) = (mode, length);
        Ok(())
    }

    fn words(&self, letters: &LetterVector) -> AxisVector {
        AxisVector::from(self.letters.map(|letter| letters.get(letter).copied().unwrap_or(0.0)))
    }

    /// Returns the joints for words, inside travel.
    pub(super) fn at(&self, letters: &LetterVector) -> Result<AxisVector, WordsFault> {
        let words = self.words(letters);
        let reached = match self.mode {
            KinematicsMode::Axes => self.kinematics.judged(words),
            KinematicsMode::ToolCenterPoint => self.kinematics.joints(self.length, &words),
        };
        let reached = reached.map_err(WordsFault::Refused)?;
        let outside = reached.excess.filter(|excess: &TravelExcess| excess.excess > ROUNDING);
        match outside {
            Some(excess) => Err(WordsFault::Refused(excess.into())),
            None => Ok(reached.joints),
        }
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
        if self.mode == KinematicsMode::Axes {
            return Ok(words);
        }
        let mut tip = words.map(|word| Vector3::new(word[0], word[1], word[2]));
        // Words count the length along z.
        tip[0] += self.machine().gauge.coords - Vector3::z() * self.length;
        let rotaries = [FIRST_ROTARY, SECOND_ROTARY]
            .map(|axis| Jet::from_derivatives(words.map(|word| word[axis])));
        self.inverse.with_rotaries(&tip, rotaries)
    }

    /// Returns the largest lever of the rotaries at words: how far the tip moves per angle \[mm/rad\].
    pub(super) fn lever(&self, letters: &LetterVector) -> f64 {
        const TURN: f64 = 1e-5;
        let joints = self.at(letters).unwrap_or_else(|_| self.words(letters));
        let tip = |joints: &AxisVector| self.kinematics.pose(self.length, joints).tip;
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
    use crate::load::machine_named;

    #[test]
    fn derivatives_agree_with_differences() {
        let mut words = WordJoints::new(machine_named("bc-trunnion").unwrap()).unwrap();
        words.set(KinematicsMode::ToolCenterPoint, 120.0).unwrap();
        let letters = |s: f64| {
            let mut at = LetterVector::zeros();
            at[0] = -300.0 + s;
            at[1] = -200.0 + 2.0 * s.sin();
            at[2] = -300.0;
            at[4] = 0.3 + 0.1 * s;
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
