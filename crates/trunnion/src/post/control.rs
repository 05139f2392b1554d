//! Dialects: the motion of their controls between blocks, and their readers.

use crate::blocks::BlockInterpolation;
use crate::machine::{AxisInterpolation, Kinematics};
use crate::nc::read::Dialect;
use crate::nc::write::{OutputFormat, Style};

/// Returns how far a control may leave the program by the smoothing that a program of this style asks for \[mm\].
///
/// `LinuxCNC` rounds corners within P of `G64`, and is told by Q0 to join no straight lines before; Heidenhain and Siemens
/// have one tolerance. The other dialects ask for nothing.
///
/// # Example
///
/// ```
/// use trunnion::files::machine::{built_in, parse};
/// use trunnion::machine::{Kinematics, Setup};
/// use trunnion::nc::write::{AxisWords, OutputFormat, Style};
/// use trunnion::post::smoothing_bound;
/// use trunnion::types::PoseTolerance;
///
/// let machine = parse(built_in("ac-trunnion").unwrap_or_default()).map_err(|_| "bad file")?.machine;
/// let kinematics = Kinematics::new(&machine, &Setup::default());
/// let axes = AxisWords::of(&machine)?;
/// let blend = Some(PoseTolerance::new(0.01, 1e-3));
/// let style = |dialect| Style { blend, ..Style::of(&kinematics, dialect, axes) };
/// assert_eq!(smoothing_bound(&style(OutputFormat::LinuxCnc)), 0.01);
/// assert_eq!(smoothing_bound(&style(OutputFormat::Siemens)), 0.01);
/// assert_eq!(smoothing_bound(&style(OutputFormat::Fanuc)), 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn smoothing_bound(style: &Style) -> f64 {
    let tip = style.blend.map_or(0.0, |blend| blend.tip);
    match style.dialect.dialect() {
        Dialect::LinuxCnc | Dialect::Siemens | Dialect::Heidenhain => tip,
        _ => 0.0,
    }
}

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
