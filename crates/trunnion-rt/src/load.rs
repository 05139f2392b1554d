//! A machine file becomes kinematics, once, before the control starts.

use crate::kinematics::MachineKinematics;
use std::path::{Path, PathBuf};
use trunnion::files::machine::{built_in, parse};
use trunnion::inverse::InverseError;
use trunnion::machine::FIRST_ROTARY;
use trunnion::nc::read::AxisWords;
use trunnion::nc::write::WordsError;
use trunnion::types::Diagnostics;

/// Reason why a machine file cannot be used by a control.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file cannot be read.
    #[error("reading machine file {}: {error}; give the path of a machine file, or a name of `trunnion machine list`", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Reason of the system.
        error: std::io::Error,
    },
    /// The text is no machine file.
    #[error("machine file:\n{0}")]
    Faulty(#[from] Diagnostics),
    /// The kinematics cannot be inverted.
    #[error(transparent)]
    Inverse(#[from] InverseError),
    /// The axes have no letters that a program can use.
    #[error(transparent)]
    Words(#[from] WordsError),
    /// A linear axis is not X, Y or Z, or a rotary axis is not A, B or C.
    #[error(
        "axis {axis} has the letter {letter}; tool-centre-point control needs {wanted}: set output.letter of [axis.{axis}]"
    )]
    Letter {
        /// Name of the axis.
        axis: String,
        /// Its letter.
        letter: char,
        /// Letters that it may have.
        wanted: &'static str,
    },
}

/// Reads the machine file at a path, or the built-in machine of that name where there is no such file.
///
/// # Errors
///
/// [`LoadError`].
pub fn machine_named(name: &str) -> Result<MachineKinematics, LoadError> {
    let path = Path::new(name);
    match (std::fs::read_to_string(path), built_in(name)) {
        (Ok(text), _) => machine_from_text(&text),
        (Err(_), Ok(text)) if path.components().count() == 1 => machine_from_text(text),
        (Err(error), _) => Err(LoadError::Unreadable { path: path.to_owned(), error }),
    }
}

/// Reads the text of a machine file.
///
/// # Errors
///
/// [`LoadError`], with every fault of the text.
pub fn machine_from_text(text: &str) -> Result<MachineKinematics, LoadError> {
    let machine = parse(text)?.machine;
    let words = AxisWords::of(&machine)?;
    // A control finds X, Y and Z of the tip by their letters, and the rotaries by theirs.
    for (index, (word, axis)) in words.0.iter().zip(&machine.axes).enumerate() {
        let linear = index < FIRST_ROTARY;
        let wanted = if linear { "X, Y and Z" } else { "A, B or C" };
        if !wanted.contains(word.letter) || (linear && !"XYZ"[index..].starts_with(word.letter)) {
            let axis = axis.name.clone();
            return Err(LoadError::Letter { axis, letter: word.letter, wanted });
        }
    }
    Ok(MachineKinematics::new(&machine)?)
}
