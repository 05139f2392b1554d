//! Machines whose description holds where the rotary axes stand at other positions than zero.

use super::draft::{AxisDraft, MachineDraft};
use crate::math;
use nalgebra::{Isometry3, Point3, Translation3, UnitVector3, Vector3};

/// Carries points and directions from the positions `angles` \[deg\] of two axes to all axes at zero.
///
/// From the workpiece to the tool, the joints of the description are `T(q - o)`, so they are `T(-o) T(q)` and `T(q) T(-o)`. The
/// constant turns are moved out of the chain: those of a head towards the tool, those of a table towards the workpiece, which
/// moves the frame that programs count in; a note states it.
pub(super) fn carry_to_zero(draft: &mut MachineDraft, names: &[String; 2], angles: [f64; 2]) {
    let Some(chain) = draft.chain.clone() else { return };
    let bed = chain.iter().position(|word| word == "b").unwrap_or_default();
    let place = |name: &String| chain.iter().position(|word| word == name).unwrap_or_default();
    // From the bed outwards: what is farther out is carried by all before it.
    let mut heads: Vec<(usize, &String, f64)> = Vec::new();
    let mut tables = heads.clone();
    for (name, angle) in names.iter().zip(angles) {
        let side = if place(name) > bed { &mut heads } else { &mut tables };
        side.push((place(name).abs_diff(bed), name, angle));
    }
    heads.sort_by_key(|(distance, ..)| *distance);
    tables.sort_by_key(|(distance, ..)| *distance);
    let mut towards_tool = Isometry3::identity();
    for (_, name, angle) in heads {
        let Some(axis) = draft.axes.iter_mut().find(|axis| axis.name == *name) else { continue };
        let back = turn(axis, -angle);
        move_axis(axis, &towards_tool);
        towards_tool *= back;
    }
    draft.gauge = (towards_tool * Point3::from(draft.gauge)).into();
    draft.tool_axis = (towards_tool.rotation * Vector3::from(draft.tool_axis)).into();
    // A table turns against the motion of the tool: its turns lie the other way round.
    let mut towards_part = Isometry3::identity();
    let mut moved: Vec<String> = Vec::new();
    for (_, name, angle) in tables {
        let Some(axis) = draft.axes.iter_mut().find(|axis| axis.name == *name) else { continue };
        let forward = turn(axis, angle);
        move_axis(axis, &towards_part);
        towards_part *= forward;
        if angle.abs() > 0.0 {
            moved.push(format!("{name} at {angle} deg"));
        }
    }
    if !moved.is_empty() {
        draft.notes.push(format!(
            "The control counts workpiece coordinates as the table stands with {}: measure the part there, and state its place in the \
             job as the table stands with all axes at 0.",
            moved.join(" and ")
        ));
    }
}

/// Returns the turn of the tool against the part by an axis, in the frame in which the axis is written.
fn turn(axis: &AxisDraft, degrees: f64) -> Isometry3<f64> {
    let dir = UnitVector3::try_new(Vector3::from(axis.dir.unwrap_or_default()), 0.0);
    let Some(dir) = dir else { return Isometry3::identity() };
    let angle = (axis.sense * degrees).to_radians();
    let point = Translation3::from(Vector3::from(axis.point.unwrap_or_default()));
    let turn = math::rotation_about(&dir, angle);
    point * Isometry3::from_parts(Translation3::identity(), turn.into()) * point.inverse()
}

fn move_axis(axis: &mut AxisDraft, by: &Isometry3<f64>) {
    axis.dir = axis.dir.map(|dir| (by.rotation * Vector3::from(dir)).into());
    axis.point = axis.point.map(|point| (by * Point3::from(point)).into());
}
