//! Flat end mill for sharp corners between faces, which cutters with a round end leave.

use super::borders::border_samples;
use super::cutters::RotaryReach;
use super::request::TOLERANCE;
use crate::cover::ToolAccess;
use crate::cutter::Cutter;
use crate::surface::{FaceIndex, FaceSample};
use crate::types::ToolPose;
use nalgebra::Point3;
use rayon::prelude::*;

/// Share of the border of a face that is a sharp corner, from which a cutter for it is worth a change of tool.
const LONG: f64 = 0.1;

/// Share of a corner along which a cutter has to get into it.
const GETS_IN: f64 = 0.8;

/// Sharp corners of the faces that a cutter with a round end finishes otherwise.
pub(super) struct SharpCorners<'a> {
    faces: &'a [FaceIndex],
    /// Points of the corners, by the index of the face.
    corners: Vec<(usize, Vec<FaceSample>)>,
}

/// Cutter in some corners.
pub(super) struct CornerFit {
    /// Indices of the faces along whose corners it gets in.
    pub(super) faces: Vec<usize>,
    /// Points of the corners that it touches.
    pub(super) poses: Vec<ToolPose>,
}

impl<'a> SharpCorners<'a> {
    /// Finds the corners of the faces of indices `cut` in which a cutter leaves more than the tolerance; `None` without any.
    pub(super) fn find(
        faces: &'a [FaceIndex],
        cut: &[usize],
        cutter: &Cutter,
        reach: &RotaryReach,
    ) -> Option<Self> {
        let access = ToolAccess::new(faces, cutter, reach, TOLERANCE.excess);
        let sharp = |&index: &usize| {
            let samples = border_samples(&faces[index]);
            let all = samples.len().max(1) as f64;
            let leaves = |sample: &FaceSample| {
                let other = access.corner_normal(index, sample);
                other.is_some_and(|other| {
                    left_in_corner(cutter.minor(), sample.normal.dot(&other)) > TOLERANCE.excess
                })
            };
            let corner: Vec<FaceSample> = samples.into_par_iter().filter(leaves).collect();
            (corner.len() as f64 >= LONG * all).then_some((index, corner))
        };
        let corners: Vec<_> = cut.iter().filter_map(sharp).collect();
        (!corners.is_empty()).then_some(Self { faces, corners })
    }

    /// Returns `true` if a point of the face at `index` is within a distance \[mm\] of one of its corners.
    pub(super) fn is_near(&self, index: usize, point: &Point3<f64>, within: f64) -> bool {
        let near = |sample: &FaceSample| (sample.point - point).norm() <= within;
        self.corners.iter().any(|(face, corner)| *face == index && corner.iter().any(near))
    }

    /// Tries a cutter in the corners.
    pub(super) fn fit(&self, cutter: &Cutter, reach: &RotaryReach) -> CornerFit {
        let access = ToolAccess::new(self.faces, cutter, reach, TOLERANCE.excess);
        let mut fit = CornerFit { faces: Vec::new(), poses: Vec::new() };
        for (index, corner) in &self.corners {
            let pose = |sample: &FaceSample| access.pose_in_corner(*index, sample);
            let poses: Vec<ToolPose> = corner.par_iter().filter_map(pose).collect();
            if poses.len() as f64 >= GETS_IN * corner.len() as f64 {
                fit.faces.push(*index);
                fit.poses.extend(poses);
            }
        }
        fit
    }
}

/// Returns what a ball of a radius leaves in the corner of two planes whose normals have this product \[mm\]: its centre is as
/// far from both, `radius / cos(angle / 2)` from their line.
fn left_in_corner(radius: f64, product: f64) -> f64 {
    let half = (0.5 * (1.0 + product)).max(0.0).sqrt();
    radius / half.max(f64::MIN_POSITIVE) - radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::CutterSpec;
    use crate::machine::Machine;
    use crate::pipeline::proposal::borders::tests::rounded_edge;

    #[test]
    fn a_ball_leaves_as_much_in_a_corner_as_geometry_says() {
        // The diagonal of a square less the radius; nothing where the faces go over into each other.
        assert!((left_in_corner(3.0, 0.0) - 3.0 * (2.0_f64.sqrt() - 1.0)).abs() < 1e-12);
        assert!(left_in_corner(3.0, 1.0).abs() < 1e-12);
        // Of 60 degrees between the faces: twice the radius from the edge.
        assert!((left_in_corner(3.0, -0.5) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_flat_end_gets_into_the_corner_of_an_edge_that_stands_on_a_floor() {
        let machine = Machine::new(crate::sample_machine::ac_trunnion()).unwrap();
        let ball = Cutter::new(CutterSpec::ball(6.0)).unwrap();
        let reach = RotaryReach::new(&machine, &ball);
        let flat = Cutter::new(CutterSpec { length: 100.0, ..CutterSpec::flat(12.0) }).unwrap();
        let faces = rounded_edge(0.0);
        let corners = SharpCorners::find(&faces, &[1], &ball, &reach).unwrap();
        assert_eq!(corners.fit(&flat, &RotaryReach::new(&machine, &flat)).faces, [1]);
        // Nor is there a corner 3 mm above the floor, or where a cutter leaves less than the tolerance.
        assert!(SharpCorners::find(&rounded_edge(3.0), &[1], &ball, &reach).is_none());
        let fine = Cutter::new(CutterSpec::ball(0.09)).unwrap();
        let reach = RotaryReach::new(&machine, &fine);
        assert!(SharpCorners::find(&faces, &[1], &fine, &reach).is_none());
    }
}
