//! Letters, decimals and signs of axis words; shared by [`read`](crate::read) and [`write`](mod@crate::write).

use crate::machine::{AxisKind, Machine};
use crate::types::{AXES, AxisVector};
use std::fmt;

/// Word of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisWord {
    /// Upper-case letter.
    pub letter: char,
    /// Written in degrees (`true`) or millimetres (`false`).
    pub rotary: bool,
    /// Digits after the point.
    pub decimals: u8,
    /// The control counts this axis the other way round.
    pub reversed: bool,
}

/// Reason why a machine's axes cannot be written as words.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WordsError {
    /// A letter that is no axis letter, or means something else in a program.
    #[error("axis {name} is written as {letter:?}; use one of X Y Z U V W A B C")]
    Letter {
        /// Axis of the machine.
        name: String,
        /// Its letter.
        letter: String,
    },
    /// Two axes with one letter.
    #[error("two axes are written as {letter}; give each its own output letter")]
    Twice {
        /// The letter.
        letter: char,
    },
    /// More digits than a number can hold.
    #[error("axis {name} asks for {decimals} decimals; at most {MOST_DECIMALS} can be written")]
    Decimals {
        /// Axis of the machine.
        name: String,
        /// Decimals requested.
        decimals: u8,
    },
}

/// Most digits after the point: 1e6 mm at nine decimals is 1e15, still an integer in `f64`.
pub const MOST_DECIMALS: u8 = 9;

/// The five axis words of a program, in the order of [`AxisVector`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisWords(pub [AxisWord; AXES]);

impl AxisWords {
    /// Returns the words of a machine's axes, as its file asks for them.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_motion::machine::{KinematicChain, Machine, MachineSpec};
    /// use trunnion_nc::read::AxisWords;
    ///
    /// let chain = KinematicChain::new()
    ///     .rotary("C", [0.0, 0.0, 1.0], [0.0; 3])
    ///     .rotary("A", [1.0, 0.0, 0.0], [0.0; 3])
    ///     .bed()
    ///     .linear("X", [1.0, 0.0, 0.0])
    ///     .linear("Y", [0.0, 1.0, 0.0])
    ///     .linear("Z", [0.0, 0.0, 1.0]);
    /// let machine = Machine::new(MachineSpec::from(chain))?;
    /// assert_eq!(AxisWords::of(&machine)?.index_of('Z'), Some(2));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`WordsError`]: a letter that is no axis letter or is used twice, too many decimals.
    pub fn of(machine: &Machine) -> Result<Self, WordsError> {
        let blank = AxisWord { letter: ' ', rotary: false, decimals: 0, reversed: false };
        let mut words = [blank; AXES];
        for (word, axis) in words.iter_mut().zip(&machine.axes) {
            let name = || axis.name.clone();
            // An axis is written with its own name unless the machine file gives another letter.
            let text = axis.output.letter.as_deref().unwrap_or(&axis.name);
            let letter = axis_letter(text)
                .ok_or_else(|| WordsError::Letter { name: name(), letter: text.to_owned() })?;
            let decimals = axis.output.decimals;
            if decimals > MOST_DECIMALS {
                return Err(WordsError::Decimals { name: name(), decimals });
            }
            let rotary = axis.kind == AxisKind::Rotary;
            *word = AxisWord { letter, rotary, decimals, reversed: false };
        }
        // Two axes with one letter could not be distinguished when the program runs.
        for (index, word) in words.iter().enumerate() {
            if words.iter().take(index).any(|other| other.letter == word.letter) {
                return Err(WordsError::Twice { letter: word.letter });
            }
        }
        Ok(Self(words))
    }

    /// Reverses all rotary words: the control counts its rotaries against ISO 841, whatever the
    /// machine file states (`LinuxCNC`'s trunnion kinematics with `conventional-directions = 0`).
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_nc::read::{AxisWord, AxisWords};
    ///
    /// let word = |letter: char| {
    ///     AxisWord { letter, rotary: "AC".contains(letter), decimals: 3, reversed: false }
    /// };
    /// let axes = AxisWords(['X', 'Y', 'Z', 'A', 'C'].map(word)).with_reversed_rotaries();
    /// assert_eq!(axes.0[0].written(10.0), 10.0);
    /// assert_eq!(axes.0[3].written(std::f64::consts::PI), -180.0);
    /// ```
    #[must_use]
    pub fn with_reversed_rotaries(mut self) -> Self {
        for word in &mut self.0 {
            word.reversed = word.rotary;
        }
        self
    }

    /// Sets `mm` decimals on linear and `degrees` decimals on rotary axes, at most
    /// [`MOST_DECIMALS`].
    #[must_use]
    pub fn with_decimals(mut self, mm: u8, degrees: u8) -> Self {
        for word in &mut self.0 {
            word.decimals = if word.rotary { degrees } else { mm }.min(MOST_DECIMALS);
        }
        self
    }

    /// Returns the largest rounding error of each word \[mm, rad\]: half of its last digit.
    pub fn rounding(&self) -> AxisVector {
        AxisVector::from_iterator(self.0.iter().map(|word| word.rounding()))
    }

    /// Returns the index of the axis that a letter names.
    pub fn index_of(&self, letter: char) -> Option<usize> {
        self.0.iter().position(|word| word.letter == letter)
    }
}

impl AxisWord {
    /// Returns half of the last digit \[mm or rad\].
    fn rounding(self) -> f64 {
        /// Units of the first digits; the table spares a power for each word of a program.
        const UNITS: [f64; 10] = [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
        // A number rounded to a unit is off by half of it at most.
        let unit = match UNITS.get(usize::from(self.decimals)) {
            Some(unit) => *unit,
            None => 10f64.powi(-i32::from(self.decimals)),
        };
        0.5 * if self.rotary { unit.to_radians() } else { unit }
    }

    /// Converts mm or rad to the number in the program: mm or degrees, with the control's sign.
    pub fn written(&self, value: f64) -> f64 {
        let value = if self.rotary { value.to_degrees() } else { value };
        if self.reversed { -value } else { value }
    }

    /// Converts the number in the program back to mm or rad.
    pub fn meant(&self, written: f64) -> f64 {
        let value = if self.rotary { written.to_radians() } else { written };
        if self.reversed { -value } else { value }
    }
}

impl fmt::Display for AxisWords {
    /// Writes the letters, `X Y Z B C`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, word) in self.0.iter().enumerate() {
            let gap = if index == 0 { "" } else { " " };
            write!(f, "{gap}{}", word.letter)?;
        }
        Ok(())
    }
}

/// Returns the upper-case axis letter that a text consists of.
fn axis_letter(text: &str) -> Option<char> {
    // Other letters are addresses with a meaning of their own: F feed, R radius, T tool and so on.
    let mut letters = text.chars().map(|c| c.to_ascii_uppercase());
    let letter = letters.next()?;
    (letters.next().is_none() && "XYZUVWABC".contains(letter)).then_some(letter)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reversed_rotary_word_comes_back_in_radians() {
        let word = AxisWord { letter: 'A', rotary: true, decimals: 3, reversed: true };
        assert!((word.written(std::f64::consts::FRAC_PI_2) + 90.0).abs() < 1e-12);
        assert!((word.meant(-90.0) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!((word.rounding() - 0.0005f64.to_radians()).abs() < 1e-18);
    }

    #[test]
    fn only_single_axis_letters_are_letters() {
        assert_eq!(axis_letter("b"), Some('B'));
        assert_eq!(axis_letter("B1"), None);
        assert_eq!(axis_letter("F"), None);
    }
}
