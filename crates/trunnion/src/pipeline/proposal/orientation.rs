//! Orientation of a part: the side of it that looks up.

use super::candidates::{FaceView, WALL};
use super::part_measure::HELD;
use crate::drop_cutter::{CuttingEnd, DropIndex};
use crate::import::inspect::{self, FaceSummary};
use crate::math;
use crate::surface::{Face, FaceSample};
use crate::types::Mesh;
use nalgebra::{Matrix3, Point3, Unit, Vector3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::Range;

/// Rotations about x, y and z by which each side of a part comes up \[rad\]; as it is drawn first.
const SIDES: [[f64; 3]; 6] = [
    [0.0; 3],
    [FRAC_PI_2, 0.0, 0.0],
    [-FRAC_PI_2, 0.0, 0.0],
    [PI, 0.0, 0.0],
    [0.0, FRAC_PI_2, 0.0],
    [0.0, -FRAC_PI_2, 0.0],
];

/// Least cosine between the upright and a direction from which a tool cuts: of the upright itself, and up to 60 degrees.
const UPRIGHT: f64 = 0.999;
const LEANING: f64 = 0.499;

/// Ratio of the areas that a tool reaches from which on another side than that of the drawing comes up.
const WORTH_A_TURN: f64 = 1.15;

/// Factor of the areas of a disc that lies flat: an impeller is cut about its axis, though as much of it is seen from the side.
const FLAT: f64 = 1.5;

/// Largest difference of the second moments of a disc across its axis, and largest moment along it, as shares of those.
const ROUND: f64 = 0.02;
const THIN: f64 = 0.5;

/// About as many samples a face.
const SAMPLES: f64 = 60.0;

/// Radius of the ball that is lowered on the samples, and chord of the triangles, as shares of the part's size. The ball
/// is smaller by twice the chord: it would touch the triangles beside the sample otherwise.
const BALL: f64 = 0.01;
const CHORD: f64 = 0.002;

/// Distance from the convex hull of the part within which a point is one of the raw block, as a share of the part's size.
const OUTSIDE: f64 = 1e-3;

/// Returns the angles about x, y and z \[rad\] by which the part is turned so that a tool reaches most of it from above;
/// `None` where no side gains much over that of the drawing.
///
/// Points on the convex hull of the part do not count: raw material has them, whichever way it lies. Of a convex part those
/// count that look up, off the box round it. Walls down to the bottom do not count either: no proposal cuts them, and a
/// plate that is drawn flat is not stood on its edge for them.
pub(super) fn choose(faces: &[Face]) -> Option<[f64; 3]> {
    let part = SampledPart::new(faces)?;
    let reached: Vec<ReachedSamples> =
        directions().into_par_iter().map(|axis| part.reached(axis)).collect();
    let [drawn, others @ ..] = SIDES.map(|angles| (part.area(&angles, &reached), angles));
    let mut best = (WORTH_A_TURN * drawn.0, None);
    for (area, angles) in others {
        if area > best.0 {
            best = (area, Some(angles));
        }
    }
    best.1
}

/// Sample of a face of a part.
#[derive(Clone, Copy)]
struct PartSample {
    sample: FaceSample,
    /// Area for which it stands \[mm²\].
    area: f64,
    /// Index of its face.
    face: usize,
}

/// Normals of a face, and its vertices among those of the part.
struct FaceShape {
    normals: Vec<Vector3<f64>>,
    vertices: Range<usize>,
}

/// Samples of the faces of a part, and triangles of all of them.
struct SampledPart {
    /// Samples that raw material does not have.
    samples: Vec<PartSample>,
    shapes: Vec<FaceShape>,
    /// `true` if all of the part is on its hull: then they are those off the box round it.
    is_convex: bool,
    mesh: Mesh,
    /// Index of the axis of a part that is round and flat.
    axis: Option<usize>,
    /// Diagonal of the box round it \[mm\].
    size: f64,
}

impl SampledPart {
    /// Samples the faces; `None` for a part of no size, and for a sheet that looks down.
    fn new(faces: &[Face]) -> Option<Self> {
        let summaries: Vec<FaceSummary> = faces.par_iter().map(inspect::summary).collect();
        let [low, high] = summaries
            .iter()
            .map(|summary| summary.bounds)
            .reduce(|[a, b], [low, high]| [a.inf(&low), b.sup(&high)])?;
        let size = (high - low).norm();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let chord = CHORD * size;
        let sampled: Vec<(Vec<FaceSample>, Mesh)> = faces
            .par_iter()
            .zip(&summaries)
            .map(|(face, summary)| {
                let samples = face.grid((summary.area / SAMPLES).sqrt()).unwrap_or_default();
                let mesh = face.tessellate(chord).map(|found| found.mesh).unwrap_or_default();
                (samples, mesh)
            })
            .collect();
        let samples = Vec::new();
        let mut part = Self {
            samples,
            shapes: Vec::new(),
            is_convex: false,
            mesh: Mesh::default(),
            axis: None,
            size,
        };
        for (face, ((samples, mesh), summary)) in sampled.into_iter().zip(&summaries).enumerate() {
            let area = summary.area / samples.len().max(1) as f64;
            let normals = samples.iter().map(|sample| sample.normal.into_inner()).collect();
            part.samples.extend(samples.into_iter().map(|sample| PartSample {
                sample,
                area,
                face,
            }));
            let first = part.mesh.vertices.len();
            part.add(mesh);
            part.shapes.push(FaceShape { normals, vertices: first..part.mesh.vertices.len() });
        }
        // No solid looks down all over: these faces are a sheet, which is cut on its other side.
        if part.samples.iter().all(|one| one.sample.normal.z < -WALL) {
            return None;
        }
        part.axis = part.axis_of_disc();
        if lies_flat(&(high - low)) {
            let is_off = part.faces_off_the_bottom(&Vector3::z());
            part.samples.retain(|one| is_off[one.face]);
        }
        let vertices = &part.mesh.vertices;
        let is_inside = |PartSample { sample, .. }: &&PartSample| {
            vertices.iter().any(|v| (v - sample.point).dot(&sample.normal) > OUTSIDE * size)
        };
        let inside: Vec<PartSample> = part.samples.par_iter().filter(is_inside).copied().collect();
        part.is_convex = inside.is_empty();
        if part.is_convex {
            part.samples.retain(|one| !is_on_box(&one.sample, [low, high], OUTSIDE * size));
        } else {
            part.samples = inside;
        }
        Some(part)
    }

    /// Returns the index of the axis about which the second moments of the faces are those of a disc, if there is one.
    fn axis_of_disc(&self) -> Option<usize> {
        let total: f64 = self.samples.iter().map(|one| one.area).sum();
        let mean: Vector3<f64> =
            self.samples.iter().map(|one| one.sample.point.coords * (one.area / total)).sum();
        let moments: Matrix3<f64> = self
            .samples
            .iter()
            .map(|PartSample { sample, area, .. }| {
                let apart = sample.point.coords - mean;
                apart * apart.transpose() * (area / total)
            })
            .sum();
        (0..3).find(|&axis| {
            let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
            let across = 0.5 * (moments[(i, i)] + moments[(j, j)]);
            let uneven = (moments[(i, i)] - moments[(j, j)]).abs();
            let skew = [(i, j), (i, axis), (j, axis)].map(|at| moments[at].abs());
            let most = skew.into_iter().fold(uneven, f64::max);
            most <= ROUND * across && moments[(axis, axis)] <= THIN * across
        })
    }

    /// Adds the triangles of a face.
    fn add(&mut self, mesh: Mesh) {
        let first = self.mesh.vertices.len();
        let corner = |corner: u32| u32::try_from(first).ok()?.checked_add(corner);
        let moved = |[a, b, c]: &[u32; 3]| Some([corner(*a)?, corner(*b)?, corner(*c)?]);
        self.mesh.triangles.extend(mesh.triangles.iter().filter_map(moved));
        self.mesh.vertices.extend(mesh.vertices);
    }

    /// Returns the samples that a ball reaches along an axis.
    fn reached(&self, axis: Vector3<f64>) -> ReachedSamples {
        let rotation = math::quaternion_between(&Unit::new_unchecked(axis), &Vector3::z_axis());
        let vertices = self.mesh.vertices.iter().map(|point| rotation * point).collect();
        let mesh = Mesh { vertices, triangles: self.mesh.triangles.clone() };
        let index = DropIndex::new(&mesh).ok();
        let end = CuttingEnd::round(0.0, (BALL - 2.0 * CHORD) * self.size);
        let one = |PartSample { sample, .. }: &PartSample| {
            let Some(index) = &index else { return false };
            let centre = rotation * (sample.point.coords + sample.normal.scale(BALL * self.size));
            let contact = index.lowered(&end, [centre.x, centre.y]);
            // The ball stands at the sample where nothing holds it up before.
            contact.is_none_or(|contact| contact.tip.z <= centre.z - end.radius())
        };
        ReachedSamples { axis, samples: self.samples.iter().map(one).collect() }
    }

    /// Returns for every face whether it is none of the outer walls down to the bottom, where the part is held.
    fn faces_off_the_bottom(&self, up: &Vector3<f64>) -> Vec<bool> {
        let heights: Vec<f64> =
            self.mesh.vertices.iter().map(|vertex| vertex.coords.dot(up)).collect();
        let low = |of: &[f64]| of.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let bottom = low(&heights);
        let held = bottom + HELD * (high - bottom);
        let is_off = |shape: &FaceShape| {
            let normals: Vec<f64> = shape.normals.iter().map(|normal| normal.dot(up)).collect();
            let view = FaceView::of(&normals, WALL);
            view != FaceView::Wall || low(&heights[shape.vertices.clone()]) > held
        };
        self.shapes.iter().map(is_off).collect()
    }

    /// Returns the sum of the areas that are reached upright and from above at all, once the part is turned \[mm²\]; of a
    /// convex part the area that looks up.
    fn area(&self, angles: &[f64; 3], reached: &[ReachedSamples]) -> f64 {
        let up = math::exact_rotation_of_xyz((*angles).into()).inverse() * Vector3::z();
        let is_cut = self.faces_off_the_bottom(&up);
        let within = |least: f64| {
            let from: Vec<&ReachedSamples> =
                reached.iter().filter(|found| found.axis.dot(&up) >= least).collect();
            let is_reached = |at: usize| from.iter().any(|found| found.samples[at]);
            let all = self.samples.iter().enumerate();
            let cut = all.filter(|(at, one)| is_cut[one.face] && is_reached(*at));
            cut.map(|(_, one)| one.area).sum::<f64>()
        };
        let slopes = || {
            let looks_up = |one: &&PartSample| one.sample.normal.dot(&up) > WALL;
            self.samples.iter().filter(looks_up).map(|one| one.area).sum::<f64>()
        };
        let is_flat = self.axis.is_some_and(|axis| up[axis].abs() >= UPRIGHT);
        let factor = if is_flat { FLAT } else { 1.0 };
        factor * if self.is_convex { slopes() } else { within(UPRIGHT) + within(LEANING) }
    }
}

/// Returns the directions from which a tool is tried: along the axes, the edges and the diagonals of a cube.
fn directions() -> Vec<Vector3<f64>> {
    let steps = || [-1.0, 0.0, 1.0].into_iter();
    let plane =
        move |x: f64| steps().flat_map(move |y| steps().map(move |z| Vector3::new(x, y, z)));
    steps().flat_map(plane).filter_map(|axis| axis.try_normalize(0.5)).collect()
}

/// Samples that a ball reaches along an axis.
struct ReachedSamples {
    axis: Vector3<f64>,
    samples: Vec<bool>,
}

/// Returns `true` if a part of this size, drawn like this, lies on the larger of its sides.
fn lies_flat(size: &Vector3<f64>) -> bool {
    size.z <= size.x.min(size.y)
}

/// Returns `true` if a sample lies on a side of a box, within a distance \[mm\].
fn is_on_box(sample: &FaceSample, [low, high]: [Point3<f64>; 2], within: f64) -> bool {
    let on = |axis: usize, side: &Point3<f64>| (sample.point[axis] - side[axis]).abs() <= within;
    (0..3).any(|axis| on(axis, &low) || on(axis, &high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::Reader;
    use crate::import::step::StepReader;
    use crate::types::Silent;

    fn part(step: &[u8]) -> Vec<Face> {
        StepReader { chord: 0.01, same: 0.01 }.read(step, &Silent).unwrap().faces
    }

    /// Whichever way a part is drawn, what is cut from above comes up.
    #[test]
    fn parts_of_the_corpus_come_up_whichever_way_they_are_drawn() {
        let parts: [(&str, &[u8]); 5] = [
            ("pocket", include_bytes!("../../../../../fixtures/corpus/gate/slanted_pocket.step")),
            ("posts", include_bytes!("../../../../../fixtures/corpus/gate/bosses.step")),
            ("boss", include_bytes!("../../../../../fixtures/corpus/gate/boss.step")),
            ("convex", include_bytes!("../../../../../fixtures/corpus/gate/chamfered_inch.step")),
            ("slot", include_bytes!("../../../../../fixtures/corpus/gate/key_slot.step")),
        ];
        for (name, step) in parts {
            let drawn = part(step);
            assert_eq!(choose(&drawn), None, "{name}");
            for angles in SIDES {
                let lying = math::exact_rotation_of_xyz(angles.into());
                let faces: Vec<Face> =
                    drawn.iter().map(|face| face.clone().turned(&lying)).collect();
                let chosen = math::exact_rotation_of_xyz(choose(&faces).unwrap_or_default().into());
                let up = chosen * lying * Vector3::z();
                assert!((up - Vector3::z()).norm() < 1e-12, "{name} lying by {angles:?}: {up}");
            }
        }
    }

    /// Only its bore is no raw block, and that is a wall down to the table as well. On its edge, half of its flats come up.
    #[test]
    fn a_nut_stays_flat() {
        let step = include_bytes!("../../../../../fixtures/step/nut.step");
        assert_eq!(choose(&part(step)), None);
    }

    /// Lying, its wavy top and bottom are walls down to the table: seen at a slant, they count for both, and no job cuts them.
    #[test]
    fn a_block_with_a_wavy_top_stays_as_it_is_drawn() {
        let step = include_bytes!("../../../../../fixtures/step/wavy_block.step");
        assert_eq!(choose(&part(step)), None);
    }
}
