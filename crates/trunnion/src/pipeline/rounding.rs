//! Rounding of the words, estimated before there is a path.

use super::program_format::format_of;
use crate::cover;
use crate::cutter::Cutter;
use crate::import::inspect;
use crate::inverse::Inverse;
use crate::machine::Kinematics;
use crate::math;
use crate::nc::write::{self, AxisWords, OutputFormat};
use crate::surface::FaceIndex;
use crate::types::ToolPose;
use nalgebra::{Point3, Vector3};

/// Tilts of the tool about the mean normal at which rounding is evaluated \[rad\].
const TILTS: [f64; 3] = [-0.35, 0.0, 0.35];

/// Estimates the cutter movement caused by rounding the words of the programs \[mm\].
///
/// It is the worst of tilted tools at the corners of the part; 0 if no such pose is within reach.
pub(super) fn expected_rounding(
    kinematics: &Kinematics,
    faces: &[FaceIndex],
    dialects: &[OutputFormat],
    cutter: Option<&Cutter>,
) -> f64 {
    let lever = cutter.map_or(0.0, cover::lever);
    // A barrel is inclined to one side, far.
    let barrel = cutter.filter(|cutter| cutter.is_barrel());
    let tilts = barrel.map_or(TILTS, |cutter| {
        let most = cutter.contact_arc().inclinations.middle();
        [-most, 0.0, most]
    });
    let (Ok(inverse), Ok(words)) = (Inverse::new(kinematics), AxisWords::of(kinematics.machine()))
    else {
        // Refused later, with a better message.
        return 0.0;
    };
    let home = kinematics.machine().home();
    let of = |pose: ToolPose| {
        let q = inverse.near(&pose, &home).ok()?;
        let bound = |&dialect: &OutputFormat| {
            write::rounding(kinematics, &q, &words, format_of(dialect).dialect.coordinates(), lever)
        };
        dialects.iter().map(bound).reduce(f64::max)
    };
    faces.iter().flat_map(|face| poses(face, tilts)).filter_map(of).fold(0.0, f64::max)
}

/// Returns tools at the corners of a face's box, tilted about its mean normal.
fn poses(face: &FaceIndex, tilts: [f64; 3]) -> Vec<ToolPose> {
    let summary = inspect::summary(face.face());
    let normal = summary.normal.unwrap_or_else(Vector3::z_axis);
    let [low, high] = summary.bounds;
    let mut poses = Vec::new();
    for corner in 0..8_u32 {
        // Bit k of the corner's number selects the upper end of axis k.
        let pick = |axis: u32| if corner >> axis & 1 == 0 { low } else { high };
        let tip = Point3::new(pick(0).x, pick(1).y, pick(2).z);
        for [x, y] in tilts.iter().flat_map(|&x| tilts.map(|y| [x, y])) {
            poses.push(ToolPose { tip, axis: math::rotation_of_xyz([x, y, 0.0].into()) * normal });
        }
    }
    poses
}
