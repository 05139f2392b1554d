//! Advice for regions that stay uncut because linear axes reach the ends of their travel.

use super::job::Job;
use super::origin_search::OriginSearch;
use super::reach::{lacks_linear_travel, upright_poses};
use crate::machine::{Kinematics, Setup};
use crate::types::{ToolPose, UncutReason, UncutRegion};
use nalgebra::Vector3;

/// Returns the origin nearest to that of the job with which the tools reach their faces, if linear travel keeps them from
/// some of the regions now.
pub(super) fn origin_in_reach(job: &Job, regions: &[UncutRegion]) -> Option<Vector3<f64>> {
    if regions.iter().all(|region| region.reason != UncutReason::Machine) {
        return None;
    }
    let lacks = |origin: &Vector3<f64>| {
        let at = |one: &Job| placed(&one.kinematics, origin);
        job.operations().any(|one| lacks_linear_travel(one, &at(one)))
    };
    if !lacks(&job.kinematics.setup().origin) {
        return None;
    }
    // Only the gauge point counts for the axes: poses of other tools are those of the first one at the same gauge point.
    let of_first = |one: &Job| {
        let longer = one.cutter.length() - job.cutter.length();
        let moved =
            move |pose: ToolPose| ToolPose { tip: pose.tip + pose.axis.scale(longer), ..pose };
        upright_poses(one).into_iter().map(moved).collect::<Vec<ToolPose>>()
    };
    let poses: Vec<ToolPose> = job.operations().flat_map(of_first).collect();
    let search = OriginSearch { kinematics: &job.kinematics, poses: &poses };
    search.best().ok().filter(|origin| !lacks(origin))
}

fn placed(kinematics: &Kinematics, origin: &Vector3<f64>) -> Kinematics {
    Kinematics::new(kinematics.machine(), &Setup { origin: *origin, ..*kinematics.setup() })
}
