//! Origin of a proposed job.

use super::cutters::CutterTrial;
use super::left_out::ProposalError;
use super::part_measure::PartMeasure;
use crate::machine::{FIRST_ROTARY, Kinematics, Machine, MovedBody, Setup};
use crate::pipeline::origin_search::{OriginSearch, TravelNeed};
use crate::types::ToolPose;
use nalgebra::Vector3;

/// Height of the part's bottom above the table, for a vice or a riser \[mm\].
const STANDOFF: f64 = 50.0;

/// Least cosine between tool axis and z at which leads along the axis are taken, as when passes are linked.
const UPRIGHT: f64 = 0.5;

/// Poses by which the origin is found, at most.
const POSES: usize = 240;

/// Returns the origin that keeps the poses of the cutters inside travel, and those in which they lean as passes may have
/// them where that is possible.
pub(super) fn origin(
    machine: &Machine,
    chosen: &[CutterTrial],
    leaning: &[ToolPose],
    part: &PartMeasure,
) -> Result<Vector3<f64>, ProposalError> {
    // The cutters of a proposal are equally long.
    let length = chosen.first().map_or(0.0, |trial| trial.cutter.length());
    let start = first_origin(machine, length) - part.foot().coords;
    let kinematics = Kinematics::new(machine, &Setup::new(start, [0.0; 3], length));
    let upright: Vec<ToolPose> = chosen.iter().flat_map(|trial| &trial.poses).copied().collect();
    let best = |poses: &[ToolPose]| OriginSearch { kinematics: &kinematics, poses }.best();
    // Where leads end: tips above all of the part, by the clearance and a radius.
    let radius = chosen.iter().map(|trial| trial.cutter.radius()).fold(0.0, f64::max);
    let level = part.highest() + part.clearance() + radius;
    let upright = with_approaches(&upright, level, part);
    let all = [upright.clone(), with_approaches(leaning, level, part)].concat();
    best(&all).or_else(|_| best(&upright)).map_err(|TravelNeed { axis, short, .. }| {
        ProposalError::Travel { axis: machine.axes[axis].name.clone(), short }
    })
}

/// Returns some of the poses, each with that from which the tool comes: along its axis from a level above the part
/// \[mm\], or a little off the part where the tool lies.
fn with_approaches(poses: &[ToolPose], level: f64, part: &PartMeasure) -> Vec<ToolPose> {
    let clearance = part.clearance();
    let stride = poses.len().div_ceil(POSES).max(1);
    let both = poses.iter().step_by(stride).flat_map(|pose| {
        [*pose, ToolPose { tip: pose.tip + lead(pose, level, clearance), ..*pose }]
    });
    both.collect()
}

/// Returns the way from a pose to the end of its lead \[mm\].
fn lead(pose: &ToolPose, level: f64, clearance: f64) -> Vector3<f64> {
    if pose.axis.z >= UPRIGHT {
        pose.axis.scale((level - pose.tip.z).max(0.0) / pose.axis.z)
    } else {
        Vector3::z() * clearance + pose.axis.scale(clearance)
    }
}

/// Returns the place of the middle of the part's bottom: above the middle of the table where it turns, else in the
/// middle of the travel \[mm\], machine coordinates with all axes at zero.
fn first_origin(machine: &Machine, length: f64) -> Vector3<f64> {
    if machine.body(FIRST_ROTARY) == MovedBody::Part {
        return machine.axes[FIRST_ROTARY].point.coords + Vector3::z() * STANDOFF;
    }
    let mut middle = machine.home();
    for (index, axis) in machine.axes.iter().take(FIRST_ROTARY).enumerate() {
        if axis.limits.is_bounded() {
            middle[index] = axis.limits.middle();
        }
    }
    let setup = Setup::new(Vector3::zeros(), [0.0; 3], length);
    Kinematics::new(machine, &setup).forward(&middle).tip.coords
}

#[cfg(test)]
mod tests {

    use super::*;

    /// A chamfer low on a part, cut at 45 degrees: the lead runs as far to the side as it rises.
    #[test]
    fn a_lead_ends_at_the_level_of_the_links() {
        let low = ToolPose::new([20.0, 0.0, 5.0], [1.0, 0.0, 1.0]).unwrap();
        let end = low.tip + lead(&low, 45.0, 10.0);
        assert!((end.coords - Vector3::new(60.0, 0.0, 45.0)).norm() < 1e-9, "{end}");
        let lying = ToolPose::new([20.0, 0.0, 5.0], [1.0, 0.0, 0.0]).unwrap();
        assert!((lead(&lying, 45.0, 10.0) - Vector3::new(10.0, 0.0, 10.0)).norm() < 1e-9);
    }
}
