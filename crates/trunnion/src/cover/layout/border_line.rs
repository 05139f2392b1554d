//! Points along the borders of a face.

use crate::surface::{FaceIndex, FaceSample, TrimLoop};
use crate::types::Uv;

/// Distance between a border and the polyline that stands for it, as a share of the face's extent.
const CHORD: f64 = 1e-4;

/// Parts of a segment of that polyline, whose lengths in space are measured: one that is straight in the parameters may go round
/// a cylinder.
const PARTS: u32 = 16;

/// Returns points along each border of a face, evenly, as many as `count` returns for its length \[mm\].
pub(crate) fn border_lines(
    index: &FaceIndex,
    count: impl Fn(f64) -> usize,
) -> Vec<Vec<FaceSample>> {
    let face = index.face();
    let tolerance = face.bounds().map(|range| CHORD * range.width());
    let line = |border: &TrimLoop| {
        let line = divided(&border.polyline(tolerance));
        let points: Vec<_> = line.iter().map(|&[u, v]| face.point(u, v)).collect();
        let length: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let step = length / count(length).max(1) as f64;
        // Halves of the step keep off the ends of the border, where others meet it.
        let mut next = 0.5 * step;
        let mut samples = Vec::new();
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
        samples
    };
    face.loops.iter().map(line).collect()
}

/// Divides the segments of a polyline in the parameters.
fn divided(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let part = |ends: &[[f64; 2]], i: u32| {
        let share = f64::from(i) / f64::from(PARTS);
        [0, 1].map(|k| ends[0][k] + share * (ends[1][k] - ends[0][k]))
    };
    let parts = line.windows(2).flat_map(|ends| (0..PARTS).map(move |i| part(ends, i)));
    parts.chain(line.last().copied()).collect()
}
