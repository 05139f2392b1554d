//! One position as the words of a program.

use super::apt;
use super::error_bound::Coordinates;
use super::format::OutputFormat;
use super::number::FixedNumber;
use super::position::WrittenPosition;
use super::style::Style;
use crate::machine::{FIRST_ROTARY, Kinematics};
use crate::types::ToolPose;
use nalgebra::Vector3;

/// Decimals of tool vectors in programs.
const VECTOR_DECIMALS: u8 = 7;

/// Tip and tool of one position, each word rounded as a program writes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceWords {
    tip: [FixedNumber; 3],
    /// Rotary words, or components of the tool vector.
    tool: [FixedNumber; 3],
    /// True if `tool` has rotary words.
    rotaries: bool,
}

impl PlaceWords {
    /// Returns the words of one position in a program of tip positions; `None` where it writes axes, or for a
    /// number that no word can hold.
    pub fn new(kinematics: &Kinematics, style: &Style, at: WrittenPosition<'_>) -> Option<Self> {
        let WrittenPosition { q, pose } = at;
        let dialect = style.dialect;
        if dialect.coordinates() != Coordinates::Tip {
            return None;
        }
        let [x, y, z, first, second] = &style.axes.0;
        let [i, j, k]: [f64; 3] = tip(kinematics, dialect, pose).into();
        let tip = [(x, i), (y, j), (z, k)];
        // CL files and vector formats write the tool axis, all others the rotary angles.
        let rotaries = !dialect.is_vector() && dialect != OutputFormat::Apt;
        let tool = if rotaries {
            let word = |of: usize| {
                [first, second]
                    .get(of)
                    .map(|word| (word.written(q[of + FIRST_ROTARY]), word.decimals))
            };
            let [a, b] = [word(0)?, word(1)?];
            [a, b, (0.0, 0)]
        } else {
            let decimals = vector_decimals(dialect);
            let [i, j, k]: [f64; 3] = vector(kinematics, dialect, pose).into();
            [i, j, k].map(|of| (of, decimals))
        };
        // Rounded as in a block, so that distances are those the control sees.
        let [x, y, z] = tip.map(|(word, of)| FixedNumber::nearest(word.written(of), word.decimals));
        let [i, j, k] = tool.map(|(of, decimals)| FixedNumber::nearest(of, decimals));
        Some(Self { tip: [x?, y?, z?], tool: [i?, j?, k?], rotaries })
    }

    /// Returns the distance of the tip to another position \[mm\].
    pub fn way(&self, to: &Self) -> f64 {
        norm(&self.tip, &to.tip)
    }

    /// Returns the rotation of both rotaries to another position, the root of the sum of squares \[rad\];
    /// `None` where vectors are written.
    pub fn turn(&self, to: &Self) -> Option<f64> {
        self.rotaries.then(|| norm(&self.tool, &to.tool).to_radians())
    }
}

fn norm(from: &[FixedNumber; 3], to: &[FixedNumber; 3]) -> f64 {
    let by = |k: usize| to[k].value() - from[k].value();
    Vector3::new(by(0), by(1), by(2)).norm()
}

/// Returns the tip as written in X Y Z: in the table frame, in a CL file in the workpiece frame \[mm\].
pub(super) fn tip(kinematics: &Kinematics, dialect: OutputFormat, pose: &ToolPose) -> Vector3<f64> {
    match dialect {
        OutputFormat::Apt => pose.tip.coords,
        _ => kinematics.setup().rotation * pose.tip.coords,
    }
}

/// Returns the tool vector in the same frames.
pub(super) fn vector(
    kinematics: &Kinematics,
    dialect: OutputFormat,
    pose: &ToolPose,
) -> Vector3<f64> {
    match dialect {
        OutputFormat::Apt => pose.axis.into_inner(),
        _ => kinematics.setup().rotation * pose.axis.into_inner(),
    }
}

/// Returns the decimals of its components.
pub(super) fn vector_decimals(dialect: OutputFormat) -> u8 {
    if dialect == OutputFormat::Apt { apt::AXIS_DECIMALS } else { VECTOR_DECIMALS }
}
