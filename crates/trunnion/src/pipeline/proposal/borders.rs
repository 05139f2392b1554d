//! Ball for strips along the borders of faces, which samples inside the faces do not see.
//!
//! Where a fillet ends above a floor, or a wall begins, the largest ball that touches the border is as high above the floor.

use super::request::TOLERANCE;
use crate::cover::{LengthCost, ToolAccess};
use crate::cutter::Cutter;
use crate::surface::{FaceIndex, FaceSample};
use crate::types::Uv;
use rayon::prelude::*;

/// Points of the borders of a face, at most.
const POINTS: usize = 96;

/// Distance between a border and the polyline that stands for it, as a share of the face's extent.
const CHORD: f64 = 0.01;

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

/// Returns points of the borders of a face, evenly along polylines.
fn border_samples(index: &FaceIndex) -> Vec<FaceSample> {
    let face = index.face();
    let tolerance = face.bounds().map(|range| CHORD * range.width());
    let few = POINTS / face.loops.len().max(1);
    let mut samples = Vec::new();
    for border in &face.loops {
        let line = border.polyline(tolerance);
        let points: Vec<_> = line.iter().map(|&[u, v]| face.point(u, v)).collect();
        let length: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let step = length / few.max(1) as f64;
        // Halves of the step keep off the ends of the border, where others meet it.
        let mut next = 0.5 * step;
        for (ends, at) in points.windows(2).zip(line.windows(2)) {
            let along = (ends[1] - ends[0]).norm();
            while next < along {
                let share = next / along;
                let [u, v] = [0, 1].map(|k| at[0][k] + share * (at[1][k] - at[0][k]));
                if let Some(normal) = face.normal(u, v) {
                    samples.push(FaceSample { uv: Uv::new(u, v), point: face.point(u, v), normal });
                }
                next += step;
            }
            next -= along;
        }
    }
    samples
}
