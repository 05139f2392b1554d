//! The chain of a machine as data for a picture.

use serde::Serialize;
use trunnion::machine::{Axis, AxisKind, Kinematics, Machine, Setup};

/// Link of a chain: an axis with its direction and place when all axes are at zero.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LinkModel {
    /// Name of the axis.
    pub name: String,
    /// Index of the axis in a timeline: X, Y, Z, then the rotaries in chain order.
    pub axis: usize,
    /// True if it turns.
    pub rotary: bool,
    /// Direction of positive motion of the tool relative to the workpiece, its sense included.
    pub direction: [f64; 3],
    /// Point of a rotary axis in machine coordinates \[mm\].
    pub point: [f64; 3],
    /// Ends of travel \[mm or rad\]; `None` for an axis that turns without end.
    pub travel: Option<[f64; 2]>,
    /// Largest velocity while cutting, and in rapid moves \[mm/s or rad/s\].
    pub velocity: [f64; 2],
}

/// Machine with a setup; all places in machine coordinates with all axes at zero.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MachineModel {
    /// Name.
    pub name: String,
    /// Links from the workpiece to the bed, workpiece first.
    pub workpiece_side: Vec<LinkModel>,
    /// Links from the bed to the tool, bed first.
    pub tool_side: Vec<LinkModel>,
    /// Unit vector from tip to spindle.
    pub tool_axis: [f64; 3],
    /// Gauge point \[mm\].
    pub gauge: [f64; 3],
    /// Origin of the workpiece \[mm\].
    pub origin: [f64; 3],
    /// Rotation of the workpiece, row by row.
    pub rotation: [[f64; 3]; 3],
}

impl MachineModel {
    /// Takes the chain of a machine, with the workpiece at the machine's origin.
    pub(crate) fn of(machine: &Machine) -> Self {
        Self::with_setup(&Kinematics::new(machine, &Setup::new([0.0; 3].into(), [0.0; 3], 0.0)))
    }

    /// Takes the chain of a machine with a workpiece on it.
    pub(crate) fn with_setup(kinematics: &Kinematics) -> Self {
        let (machine, setup) = (kinematics.machine(), kinematics.setup());
        let bed = machine.chain.iter().position(|name| name == "b").unwrap_or_default();
        let links = |names: &[String]| -> Vec<LinkModel> {
            let link = |name: &String| {
                let index = machine.index_of(name)?;
                machine.axes.get(index).map(|axis| LinkModel::of(axis, index))
            };
            names.iter().filter_map(link).collect()
        };
        let (workpiece, tool) = machine.chain.split_at(bed);
        let rows = setup.rotation.matrix();
        Self {
            name: machine.name.clone(),
            workpiece_side: links(workpiece),
            tool_side: links(tool),
            tool_axis: machine.tool_axis.into_inner().into(),
            gauge: machine.gauge.coords.into(),
            origin: setup.origin.into(),
            rotation: [0, 1, 2].map(|row| [0, 1, 2].map(|column| rows[(row, column)])),
        }
    }
}

impl LinkModel {
    fn of(axis: &Axis, index: usize) -> Self {
        Self {
            name: axis.name.clone(),
            axis: index,
            rotary: axis.kind == AxisKind::Rotary,
            direction: axis.dir.scale(axis.sense).into(),
            point: axis.point.coords.into(),
            travel: axis.limits.is_bounded().then(|| axis.limits.ends()),
            velocity: [axis.vel, axis.rapid],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion::files::machine::{built_in, parse};

    #[test]
    fn a_chain_is_divided_at_the_bed() {
        let text = built_in("bc-trunnion").unwrap_or_default();
        let machine = parse(text).map(|file| file.machine);
        let model = machine
            .map_or_else(|faults| unreachable!("{faults:?}"), |machine| MachineModel::of(&machine));
        let names = |links: &[LinkModel]| -> Vec<String> {
            links.iter().map(|link| link.name.clone()).collect()
        };
        assert_eq!(names(&model.workpiece_side), ["C", "B"]);
        assert_eq!(names(&model.tool_side), ["X", "Y", "Z"]);
        assert_eq!(model.workpiece_side.first().map(|link| link.rotary), Some(true));
    }
}
