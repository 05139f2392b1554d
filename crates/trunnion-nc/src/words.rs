//! Letters, decimals and signs of axis words; shared by [`read`](super::read) and [`write`](mod@super::write).

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
    /// The words of a machine's axes, as its file asks for them.
    ///
    /// `rotary_reversed`: the control turns its rotaries against ISO 841, whatever the machine file
    /// says (`LinuxCNC`'s trunnion kinematics with `conventional-directions = 0`).
    ///
    /// # Errors
    ///
    /// [`WordsError`]: a letter that is no axis letter or is used twice, too many decimals.
    pub fn of(machine: &Machine, rotary_reversed: bool) -> Result<Self, WordsError> {
        let blank = AxisWord { letter: ' ', rotary: false, decimals: 0, reversed: false };
        let mut words = [blank; AXES];
        for (word, axis) in words.iter_mut().zip(&machine.axes) {
            let name = || axis.name.clone();
            let text = axis.output.letter.as_deref().unwrap_or(&axis.name);
            let letter = axis_letter(text)
                .ok_or_else(|| WordsError::Letter { name: name(), letter: text.to_owned() })?;
            let decimals = axis.output.decimals;
            if decimals > MOST_DECIMALS {
                return Err(WordsError::Decimals { name: name(), decimals });
            }
            let rotary = axis.kind == AxisKind::Rotary;
            *word = AxisWord { letter, rotary, decimals, reversed: rotary && rotary_reversed };
        }
        for (index, word) in words.iter().enumerate() {
            if words.iter().take(index).any(|other| other.letter == word.letter) {
                return Err(WordsError::Twice { letter: word.letter });
            }
        }
        Ok(Self(words))
    }

    /// The same with `mm` decimals on linear and `degrees` decimals on rotary axes, at most
    /// [`MOST_DECIMALS`].
    #[must_use]
    pub fn with_decimals(mut self, mm: u8, degrees: u8) -> Self {
        for word in &mut self.0 {
            word.decimals = if word.rotary { degrees } else { mm }.min(MOST_DECIMALS);
        }
        self
    }

    /// Largest error that rounding leaves in each word \[mm, rad\]: half of its last digit.
    pub fn rounding(&self) -> AxisVector {
        AxisVector::from_iterator(self.0.iter().map(|word| word.rounding()))
    }

    /// Returns the index of the axis that a letter names.
    pub fn index_of(&self, letter: char) -> Option<usize> {
        self.0.iter().position(|word| word.letter == letter)
    }
}

impl AxisWord {
    /// Half of the last digit \[mm or rad\].
    fn rounding(self) -> f64 {
        let unit = 10f64.powi(-i32::from(self.decimals));
        0.5 * if self.rotary { unit.to_radians() } else { unit }
    }

    /// From mm or rad to what the program says (mm or degrees, the control's sign).
    pub fn written(&self, value: f64) -> f64 {
        let value = if self.rotary { value.to_degrees() } else { value };
        if self.reversed { -value } else { value }
    }

    /// Back from what the program says to mm or rad.
    pub fn meant(&self, written: f64) -> f64 {
        let value = if self.rotary { written.to_radians() } else { written };
        if self.reversed { -value } else { value }
    }
}

impl fmt::Display for AxisWords {
    /// The letters, `X Y Z B C`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, word) in self.0.iter().enumerate() {
            let gap = if index == 0 { "" } else { " " };
            write!(f, "{gap}{}", word.letter)?;
        }
        Ok(())
    }
}

/// The upper-case axis letter a text consists of.
fn axis_letter(text: &str) -> Option<char> {
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
