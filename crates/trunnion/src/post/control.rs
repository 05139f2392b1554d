//! Dialects: the motion of their controls between blocks, and their readers.

use crate::blocks::BlockInterpolation;
use crate::machine::{AxisInterpolation, Kinematics};
use crate::nc::write::OutputFormat;

/// Returns the motion between blocks of a dialect's control.
///
/// The machine file decides where it names the same dialect.
pub fn control_of(kinematics: &Kinematics, dialect: OutputFormat) -> BlockInterpolation {
    let machine = &kinematics.machine().dialect;
    let own = OutputFormat::from_name(&machine.name) == Some(dialect);
    match dialect {
        OutputFormat::G93 => BlockInterpolation::Axes,
        OutputFormat::Apt => BlockInterpolation::GreatCircle,
        of if of.is_vector() => BlockInterpolation::GreatCircle,
        _ if own && machine.interpolation == AxisInterpolation::GreatCircle => {
            BlockInterpolation::GreatCircle
        }
        _ => BlockInterpolation::RotaryLinear,
    }
}
