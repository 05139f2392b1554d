//! Faces that may be cut, with samples, and the kind of cutter that suits them.

use super::left_out::{FaceReason, LeftOutFace};
use super::part_measure::PartMeasure;
use super::request::TOLERANCE;
use crate::cover::{flank_axis, rulings_fit};
use crate::cutter::CutterKind;
use crate::import::inspect::{self, FaceSummary};
use crate::pipeline::fit::curvatures;
use crate::positioning::ToleranceBand;
use crate::surface::{FaceIndex, FaceSample, Surface};
use rayon::prelude::*;

/// About as many samples a face.
const SAMPLES: f64 = 60.0;

/// Share of a face's samples that the tool has to reach; the rest is what no pass gets to, such as its corners.
pub(super) const REACHED: f64 = 0.5;

/// Cosine between normal and z up to which a face is a wall: two degrees to either side of the horizon.
pub(super) const WALL: f64 = 0.035;

/// The same for planes and straight walls, which a tool that leans under them may cut: 30 degrees below the horizon.
const OVERHANG: f64 = 0.5;

/// Least z of the straight lines of a wall, of unit length: 30 degrees above the horizon.
const STEEP: f64 = 0.5;

/// Radius of the tool whose side has to lie on walls that twist \[mm\], and the band for it: half of the usual excess, since
/// a job keeps shares of it for the motion.
const FLANK: f64 = 8.0;
const BAND: ToleranceBand = ToleranceBand { lower: 0.0, upper: 0.5 * TOLERANCE.excess };

/// Distance in height within which a face stands on a floor, and beyond which it rises from it \[mm\].
const FOOT: f64 = 0.01;

/// Faces that may be cut, with samples.
pub(super) struct CandidateFaces<'a> {
    pub(super) faces: &'a [FaceIndex],
    /// Index of each candidate, its area \[mm²\] and samples.
    pub(super) candidates: Vec<SampledFace>,
}

pub(super) struct SampledFace {
    pub(super) index: usize,
    pub(super) area: f64,
    /// Height of its lowest point \[mm\].
    pub(super) low: f64,
    pub(super) samples: Vec<FaceSample>,
}

/// Direction in which most of a face looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FaceView {
    Up,
    Wall,
    Down,
}

impl FaceView {
    /// Returns the view of a face by its normals, their sines above the horizon; it looks down where they are below that by
    /// more than `overhang`.
    pub(super) fn of(normals: &[f64], overhang: f64) -> Self {
        let most = |looks: &dyn Fn(f64) -> bool| {
            let found = normals.iter().filter(|sine| looks(**sine)).count();
            found as f64 >= REACHED * normals.len() as f64
        };
        // A dome that goes a little below its equator is still worth cutting.
        if most(&|sine| sine < -overhang) {
            Self::Down
        } else if most(&|sine| sine > WALL) {
            Self::Up
        } else {
            Self::Wall
        }
    }
}

impl<'a> CandidateFaces<'a> {
    /// Samples the faces; those that look down are left out.
    pub(super) fn new(
        faces: &'a [FaceIndex],
        wanted: Option<&[usize]>,
        part: &PartMeasure,
        left_out: &mut Vec<LeftOutFace>,
    ) -> Self {
        let asked = |face: &FaceIndex| wanted.is_none_or(|all| all.contains(&face.face().number));
        let sampled: Vec<SampledFace> = faces
            .par_iter()
            .enumerate()
            .filter(|(_, face)| asked(face))
            .map(|(index, face)| {
                let FaceSummary { area, bounds: [low, _], .. } = inspect::summary(face.face());
                let samples = face.face().grid((area / SAMPLES).sqrt()).unwrap_or_default();
                SampledFace { index, area, low: low.z, samples }
            })
            .collect();
        let mut candidates = Vec::new();
        for face in sampled {
            let overhang = if is_prismatic(&faces[face.index]) { OVERHANG } else { WALL };
            let normals: Vec<f64> = face.samples.iter().map(|sample| sample.normal.z).collect();
            let reason = match FaceView::of(&normals, overhang) {
                FaceView::Up => None,
                FaceView::Down => Some(FaceReason::Down),
                FaceView::Wall if wanted.is_some() || !part.holds_at(face.low) => None,
                FaceView::Wall => Some(FaceReason::Wall),
            };
            match reason {
                None => candidates.push(face),
                Some(reason) => {
                    let number = faces[face.index].face().number;
                    left_out.push(LeftOutFace { number, reason });
                }
            }
        }
        Self { faces, candidates }
    }

    /// Returns the area of the candidates \[mm²\].
    pub(super) fn area(&self) -> f64 {
        self.candidates.iter().map(|candidate| candidate.area).sum()
    }

    /// Returns the area of the candidates that is rounder than a radius \[mm\], by samples \[mm²\].
    pub(super) fn fillet_area(&self, radius: f64) -> f64 {
        let rounder = |candidate: &SampledFace| {
            let is_rounder = |sample: &&FaceSample| {
                let face = &self.faces[candidate.index];
                curvatures(face, sample.uv).is_some_and(|[least, _]| -least * radius > 1.0)
            };
            let found = candidate.samples.iter().filter(is_rounder).count() as f64;
            candidate.area * found / candidate.samples.len().max(1) as f64
        };
        self.candidates.iter().map(rounder).sum()
    }

    /// Separates planes and upright walls, which a flat end mill cuts, from the other faces.
    pub(super) fn prismatic_and_others(self) -> [Self; 2] {
        let faces = self.faces;
        let (prismatic, others) =
            self.candidates.into_iter().partition(|face| is_prismatic(&faces[face.index]));
        [prismatic, others].map(|candidates| Self { faces, candidates })
    }

    /// Adds candidates.
    pub(super) fn join(&mut self, others: impl IntoIterator<Item = SampledFace>) {
        self.candidates.extend(others);
        self.candidates.sort_by_key(|candidate| candidate.index);
    }
}

/// Shape of the cutting end that suits the faces.
pub(super) fn kind(faces: &[FaceIndex], candidates: &[SampledFace]) -> CutterKind {
    let all = || candidates.iter().map(|candidate| &faces[candidate.index]);
    if all().all(is_prismatic) {
        CutterKind::Flat
    } else if !all().all(|face| face.smallest_concave_radius().is_infinite()) {
        CutterKind::Ball
    } else if has_foot(faces, candidates) {
        // The rounded corner of another cutter leaves the foot of what stands on the floor.
        CutterKind::Flat
    } else {
        CutterKind::Bull
    }
}

/// Returns `true` if a face that is cut stands with a sharp edge on a floor that is cut.
fn has_foot(faces: &[FaceIndex], candidates: &[SampledFace]) -> bool {
    let height = |face: &FaceIndex| inspect::summary(face.face()).bounds.map(|corner| corner.z);
    let floors: Vec<f64> = candidates
        .iter()
        .filter(|face| matches!(faces[face.index].face().surface, Surface::Plane(_)))
        .map(|face| height(&faces[face.index]))
        .filter(|[low, high]| high - low <= FOOT)
        .map(|[low, _]| low)
        .collect();
    let stands = |[low, high]: [f64; 2]| {
        floors.iter().any(|floor| (low - floor).abs() <= FOOT && high - floor > FOOT)
    };
    candidates.iter().any(|face| stands(height(&faces[face.index])))
}

/// Returns `true` for planes, and for walls that the flank of a steep tool finishes.
fn is_prismatic(index: &FaceIndex) -> bool {
    let face = index.face();
    match face.surface {
        Surface::Plane(_) => true,
        Surface::Cylinder(_) | Surface::Cone(_) | Surface::Extrusion(_) => {
            let [u, v] = face.bounds().map(|range| range.middle());
            let ruling = face.surface.jet1(u, v).sv;
            ruling.z.abs() >= STEEP * ruling.norm()
        }
        // Walls with a draft are often lofts between two outlines.
        _ => {
            let is_steep = || flank_axis(index).is_some_and(|axis| axis.z >= STEEP);
            rulings_fit(index, FLANK, BAND) && is_steep()
        }
    }
}
