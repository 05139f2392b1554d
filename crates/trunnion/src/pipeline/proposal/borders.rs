//! Ball for strips along the borders of faces, which samples inside the faces do not see.
//!
//! A rounded edge that begins 3 mm above a floor leaves room for a ball of 3 mm radius at its border, and for no larger one.

use super::request::TOLERANCE;
use crate::cover::{LengthCost, ToolAccess, border_lines};
use crate::cutter::Cutter;
use crate::surface::{FaceIndex, FaceSample};
use rayon::prelude::*;

/// Points of the borders of a face, at most.
const POINTS: usize = 96;

/// Share of the points of a face that are too narrow for a cutter, from which they are a strip and no corner.
const STRIP: f64 = 0.1;

/// Excess of a ball over the largest one that fits, as a share of it: that of the measurement.
const AS_LARGE: f64 = 1.001;

/// Narrow borders of faces.
pub(super) struct NarrowBorders {
    /// Indices of the faces.
    pub(super) faces: Vec<usize>,
    /// Radius of the ball that fits along all of them \[mm\].
    radius: f64,
}

impl NarrowBorders {
    /// Finds the faces with borders along which the corner of a cutter does not fit, and a ball of a least radius \[mm\] does.
    pub(super) fn find(
        faces: &[FaceIndex],
        cut: &[usize],
        cutter: &Cutter,
        least: f64,
    ) -> Option<Self> {
        // Balls alone are measured: the machine does not matter.
        let cost = LengthCost { link: 0.0 };
        let access = ToolAccess::new(faces, cutter, &cost, TOLERANCE.excess);
        let narrow = |&index: &usize| {
            let samples = border_samples(&faces[index]);
            let radius = |sample: &FaceSample| access.largest_ball(index, sample);
            let mut radii: Vec<f64> = samples.par_iter().map(radius).collect();
            // Corners are as narrow as one likes: no ball finishes them.
            radii.retain(|radius| AS_LARGE * radius >= least && AS_LARGE * radius < cutter.minor());
            radii.sort_by(f64::total_cmp);
            let is_strip = radii.len() as f64 >= STRIP * samples.len().max(1) as f64;
            is_strip.then(|| (index, radii[radii.len() / 2]))
        };
        let found: Vec<(usize, f64)> = cut.iter().filter_map(narrow).collect();
        let radius = found.iter().map(|(_, radius)| *radius).reduce(f64::min)?;
        Some(Self { faces: found.into_iter().map(|(index, _)| index).collect(), radius })
    }

    /// Returns `true` if a ball fits along all of the borders.
    pub(super) fn fits(&self, ball: &Cutter) -> bool {
        ball.minor() <= AS_LARGE * self.radius
    }
}

/// Returns points of the borders of a face, evenly along them.
pub(super) fn border_samples(index: &FaceIndex) -> Vec<FaceSample> {
    let few = POINTS / index.face().loops.len().max(1);
    border_lines(index, |_| few).into_iter().flatten().collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::cutter::CutterSpec;
    use crate::surface::{
        CylinderSurface, Face, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop,
    };
    use nalgebra::{Point3, Vector3};
    use std::f64::consts::FRAC_PI_2;

    fn face(number: usize, surface: Surface, [u, v]: [f64; 2]) -> FaceIndex {
        let corners = [[0.0, 0.0], [u, 0.0], [u, v], [0.0, v], [0.0, 0.0]];
        let border =
            TrimLoop::new(vec![TrimCurve::polyline(&corners).unwrap()], [None, None], 1e-9);
        FaceIndex::new(Face::new(number, surface, vec![border.unwrap()]).unwrap()).unwrap()
    }

    /// An edge of 2 mm radius and 40 mm length that begins at a height above a floor beside it.
    pub(in crate::pipeline::proposal) fn rounded_edge(height: f64) -> [FaceIndex; 2] {
        let frame = |origin: Point3<f64>, normal: Vector3<f64>, x: Vector3<f64>| {
            SurfaceFrame::new(origin, normal, x).unwrap()
        };
        let floor = frame(Point3::new(0.0, 2.0, 0.0), Vector3::z(), Vector3::x());
        let floor = Surface::Plane(PlaneSurface { frame: floor });
        let edge = frame(Point3::new(0.0, 0.0, height), Vector3::x(), Vector3::y());
        let edge = Surface::Cylinder(CylinderSurface::new(edge, 2.0).unwrap());
        [face(1, floor, [40.0, 30.0]), face(2, edge, [FRAC_PI_2, 40.0])]
    }

    fn ball(diameter: f64) -> Cutter {
        Cutter::new(CutterSpec::ball(diameter)).unwrap()
    }

    #[test]
    fn an_edge_close_above_a_floor_asks_for_a_ball_that_fits_between() {
        let faces = rounded_edge(3.0);
        let found = NarrowBorders::find(&faces, &[1], &ball(12.0), 1.0).unwrap();
        assert_eq!(found.faces, [1]);
        assert!((found.radius - 3.0).abs() < 0.01, "{}", found.radius);
        assert!(found.fits(&ball(6.0)) && !found.fits(&ball(8.0)));
        // The ball that fits asks for no other, and in a sharp corner none does.
        assert!(NarrowBorders::find(&faces, &[1], &ball(5.9), 1.0).is_none());
        assert!(NarrowBorders::find(&rounded_edge(0.0), &[1], &ball(12.0), 1.0).is_none());
    }
}
