//! Dialects: the motion of their controls between blocks, and their readers.

use crate::blocks::BlockInterpolation;
use crate::machine::{AxisInterpolation, Kinematics};
use crate::nc::read;
use crate::nc::write::Dialect;

/// Returns the motion between blocks of a dialect's control.
///
/// The machine file decides where it names the same dialect.
pub fn control_of(kinematics: &Kinematics, dialect: Dialect) -> BlockInterpolation {
    let machine = &kinematics.machine().dialect;
    let own = Dialect::from_name(&machine.name) == Some(dialect);
    match dialect {
        Dialect::G93 => BlockInterpolation::Axes,
        Dialect::Apt => BlockInterpolation::GreatCircle,
        of if of.is_vector() => BlockInterpolation::GreatCircle,
        _ if own && machine.interpolation == AxisInterpolation::GreatCircle => {
            BlockInterpolation::GreatCircle
        }
        _ => BlockInterpolation::RotaryLinear,
    }
}

/// Returns the reader of a dialect.
///
/// # Example
///
/// ```
/// use trunnion::nc::{read, write};
/// use trunnion::post::reader_of;
///
/// // Both kinds of Siemens programs, with vectors and with axes, have one reader.
/// assert_eq!(reader_of(write::Dialect::Siemens), read::Dialect::Siemens);
/// assert_eq!(reader_of(write::Dialect::SiemensAxes), read::Dialect::Siemens);
/// ```
pub fn reader_of(dialect: Dialect) -> read::Dialect {
    match dialect {
        Dialect::LinuxCnc | Dialect::G93 => read::Dialect::LinuxCnc,
        Dialect::Fanuc | Dialect::FanucVector => read::Dialect::Fanuc,
        Dialect::Haas => read::Dialect::Haas,
        Dialect::Siemens | Dialect::SiemensAxes => read::Dialect::Siemens,
        Dialect::Heidenhain | Dialect::HeidenhainAxes => read::Dialect::Heidenhain,
        Dialect::Apt => read::Dialect::Apt,
    }
}
