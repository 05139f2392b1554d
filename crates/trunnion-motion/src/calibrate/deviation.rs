//! The thirteen deviations of a chain.

use crate::machine::{FIRST_ROTARY, Machine, SECOND_ROTARY};
use nalgebra::{UnitVector3, Vector3};

/// Number of deviations of a chain of five axes and a tool.
pub const CHAIN_DEVIATIONS: usize = 13;

/// Kind of a deviation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DeviationKind {
    /// Offset of a rotary axis line along a direction \[mm\].
    Offset,
    /// Tilt of an axis, or of the tool, about a direction \[rad\].
    Tilt,
}

/// One deviation of a real chain from the machine file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChainDeviation {
    /// Offset or tilt.
    pub kind: DeviationKind,
    /// Index of the axis; `None` for the tool axis.
    pub axis: Option<usize>,
    /// Direction of the offset, or direction about which the tilt turns; machine frame.
    pub direction: UnitVector3<f64>,
}

impl ChainDeviation {
    /// Returns a short name, such as `C.offset.x` or `tool.tilt.y`.
    pub fn name(&self, machine: &Machine) -> String {
        let kind = match self.kind {
            DeviationKind::Offset => "offset",
            DeviationKind::Tilt => "tilt",
        };
        format!("{}.{kind}.{}", self.subject(machine), self.letter())
    }

    /// Describes the deviation in words.
    pub fn words(&self, machine: &Machine) -> String {
        let (subject, letter) = (self.subject(machine), self.letter());
        match (self.kind, self.axis) {
            (DeviationKind::Offset, _) => format!("place of the line of {subject} in {letter}"),
            (_, None) => format!("tilt of the tool axis about {letter}"),
            (_, Some(axis)) if axis < FIRST_ROTARY => {
                format!("squareness: tilt of {subject} about {letter}")
            }
            _ => format!("tilt of the line of {subject} about {letter}"),
        }
    }

    /// Returns the name of the axis, or `tool`.
    fn subject<'a>(&self, machine: &'a Machine) -> &'a str {
        let axis = self.axis.and_then(|axis| machine.axes.get(axis));
        axis.map_or("tool", |axis| axis.name.as_str())
    }

    /// Returns the coordinate that the direction is nearest to.
    fn letter(&self) -> char {
        ['x', 'y', 'z'].get(self.direction.iamax()).copied().unwrap_or('z')
    }
}

/// Returns the deviations of a machine: each rotary axis, Y, Z, tool.
pub(super) fn deviations(machine: &Machine) -> [ChainDeviation; CHAIN_DEVIATIONS] {
    let [x, y, z, first, second] = &machine.axes;
    let offset = |axis, direction| ChainDeviation {
        kind: DeviationKind::Offset,
        axis: Some(axis),
        direction,
    };
    let tilt = |axis, direction| ChainDeviation { kind: DeviationKind::Tilt, axis, direction };
    let [a1, b1] = across(&first.dir);
    let [a2, b2] = across(&second.dir);
    let [az, bz] = across(&z.dir);
    let [at, bt] = across(&machine.tool_axis);
    // X defines the frame, and Y its plane: turning all of it is no deviation.
    let normal = UnitVector3::new_normalize(x.dir.cross(&y.dir));
    [
        offset(FIRST_ROTARY, a1),
        offset(FIRST_ROTARY, b1),
        tilt(Some(FIRST_ROTARY), a1),
        tilt(Some(FIRST_ROTARY), b1),
        offset(SECOND_ROTARY, a2),
        offset(SECOND_ROTARY, b2),
        tilt(Some(SECOND_ROTARY), a2),
        tilt(Some(SECOND_ROTARY), b2),
        tilt(Some(1), normal),
        tilt(Some(2), az),
        tilt(Some(2), bz),
        tilt(None, at),
        tilt(None, bt),
    ]
}

/// Returns the two coordinate axes that lie most across a direction: offsets and tilts by them are those of a drawing.
fn across(dir: &UnitVector3<f64>) -> [UnitVector3<f64>; 2] {
    let [x, y, z] = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
    match dir.iamax() {
        0 => [y, z],
        1 => [x, z],
        _ => [x, y],
    }
}
