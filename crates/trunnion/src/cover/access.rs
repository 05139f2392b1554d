//! Access of a tool to single points of a part, without planning passes.

use super::cost::PassCost;
use super::place::sharp_corner::SharpCorner;
use super::place::tool_fit::{
    ContactPoint, PoseOrder, PoseSearch, fitting_pose_along, fitting_pose_flush, fitting_pose_near,
    is_hollow, largest_ball,
};
use super::prove::part_faces::{KeepOff, PartFaces};
use crate::cutter::{Cutter, ToolBody};
use crate::surface::{FaceIndex, FaceSample};
use crate::types::{ToolPose, UncutReason};
use nalgebra::UnitVector3;

/// Precision of the distances, as a share of the excess into the part that counts as touching.
const PRECISION: f64 = 0.5;

/// Distance of the other face at a sharp corner, as a share of the cutter's corner radius: edges are known as well as files know
/// them.
const NEAR: f64 = 0.05;

/// Faces of a part, and the tool that is to touch them one point at a time.
pub struct ToolAccess<'a> {
    part_faces: PartFaces<'a>,
    cutter: &'a Cutter,
    tool: ToolBody,
    cost: &'a dyn PassCost,
    /// Depth into the part that still counts as touching \[mm\].
    depth: f64,
}

impl std::fmt::Debug for ToolAccess<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { cutter, depth, .. } = self;
        f.debug_struct("ToolAccess")
            .field("cutter", cutter)
            .field("depth", depth)
            .finish_non_exhaustive()
    }
}

impl<'a> ToolAccess<'a> {
    /// Prepares the faces for a cutter; a tool that goes into them by `depth` \[mm\] or less counts as touching,
    /// and `cost` knows the reach of the machine.
    pub fn new(
        faces: &'a [FaceIndex],
        cutter: &'a Cutter,
        cost: &'a dyn PassCost,
        depth: f64,
    ) -> Self {
        let part_faces = PartFaces::new(faces.iter(), cutter);
        Self { part_faces, cutter, tool: ToolBody::new(cutter), cost, depth }
    }

    /// Returns the pose nearest to an axis in which the cutter touches a sample of the face at `index` and all of the
    /// tool keeps off the part, within reach of the machine.
    ///
    /// Some tens of directions are tried, not all there are.
    ///
    /// # Errors
    ///
    /// The reason why there is none.
    pub fn pose_along(
        &self,
        axis: &UnitVector3<f64>,
        index: usize,
        sample: &FaceSample,
    ) -> Result<ToolPose, UncutReason> {
        fitting_pose_along(&self.keep_off(index), &contact(sample), self.cutter, axis)
    }

    /// Returns the pose nearest to an axis in which the flank or the flat underside of the cutter lies along a plane, the face at
    /// `index`, at a sample and all of the tool keeps off the part, within reach of the machine.
    ///
    /// # Errors
    ///
    /// The reason why there is none.
    pub fn pose_flush(
        &self,
        axis: &UnitVector3<f64>,
        index: usize,
        sample: &FaceSample,
    ) -> Result<ToolPose, UncutReason> {
        fitting_pose_flush(&self.keep_off(index), &contact(sample), self.cutter, axis)
    }

    /// Returns `true` if a ball of a radius \[mm\] that touches a sample of the face at `index` goes into that face
    /// elsewhere.
    pub fn is_hollow(&self, radius: f64, index: usize, sample: &FaceSample) -> bool {
        is_hollow(&self.keep_off(index), &contact(sample), radius)
    }

    /// Returns the radius of the largest ball that touches a sample of the face at `index` and keeps off all faces \[mm\].
    pub fn largest_ball(&self, index: usize, sample: &FaceSample) -> f64 {
        let precision = self.keep_off(index).precision;
        largest_ball(&self.part_faces, &contact(sample), self.cutter, precision)
    }

    /// Returns the normal of the other face at a sample on the border of the face at `index`, if the two meet in a sharp
    /// corner there.
    pub fn corner_normal(&self, index: usize, sample: &FaceSample) -> Option<UnitVector3<f64>> {
        let near = NEAR * self.cutter.minor();
        let corner = SharpCorner::find(&self.keep_off(index), &contact(sample), near);
        corner.map(|corner| corner.other)
    }

    /// Returns a pose in which the cutter touches a sample at a sharp corner of the face at `index` and all of the tool keeps
    /// off the part, within reach of the machine.
    pub fn pose_in_corner(&self, index: usize, sample: &FaceSample) -> Option<ToolPose> {
        let search = PoseSearch { room: self.depth, before: None, order: PoseOrder::Square };
        fitting_pose_near(&self.keep_off(index), &contact(sample), self.cutter, search)
    }

    fn keep_off(&self, own: usize) -> KeepOff<'_> {
        KeepOff {
            cost: self.cost,
            part_faces: &self.part_faces,
            own,
            tool: &self.tool,
            least: -self.depth,
            precision: PRECISION * self.depth,
        }
    }
}

fn contact(sample: &FaceSample) -> ContactPoint {
    ContactPoint { point: sample.point, normal: sample.normal }
}
