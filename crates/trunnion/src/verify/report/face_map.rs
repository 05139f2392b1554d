//! Heights over a face, at the points of a grid.

use crate::types::{UncutRegion, Uv};
use nalgebra::Point3;

/// Height left over a face at the points of a grid.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FaceMap {
    /// Number of the face.
    pub face: usize,
    /// Values of u, increasing.
    pub u: Vec<f64>,
    /// Values of v, increasing.
    pub v: Vec<f64>,
    /// `samples[i * v.len() + j]` at `(u[i], v[j])`; `None` outside the trims.
    pub samples: Vec<Option<HeightSample>>,
    /// Points that could not be measured: no surface normal, or a search that was given up.
    pub unmeasured: usize,
    /// Flags of cells that meet known rest material: that of cell `u[i]..u[i + 1]`, `v[j]..v[j + 1]` is at
    /// `[i * (v.len() - 1) + j]`. Empty if no cell does.
    pub unfinished: Vec<bool>,
}

/// Height of the machined surface over one point of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HeightSample {
    /// Parameters.
    pub uv: Uv,
    /// Point of the face, workpiece frame \[mm\].
    pub point: Point3<f64>,
    /// Lowest the tool gets on the normal \[mm\]: below 0 a gouge, above 0 excess, `None` if no tool
    /// comes within the reach searched. A gouge as deep as that reach is at least that deep.
    pub height: Option<f64>,
    /// Line of the program that gets there.
    pub line: Option<u32>,
    /// That line is a rapid move on a control that runs each axis at its own speed.
    pub dog_leg: bool,
    /// Area of the face that the point stands for \[mm²\].
    pub area: f64,
    /// The point lies in known rest material.
    pub rest: bool,
}

impl FaceMap {
    /// Marks the samples in known rest material, and the cells that meet it.
    pub(in crate::verify) fn note(&mut self, rest: &[UncutRegion]) {
        let here = || rest.iter().filter(|part| part.face == self.face);
        if here().next().is_none() {
            return;
        }
        let [rows, columns] = [self.u.len(), self.v.len()].map(|n| n.saturating_sub(1));
        self.unfinished = vec![false; rows * columns];
        for [u, v] in here().flat_map(|part| &part.cells) {
            let [i, j] = [held(&self.u, u.ends()), held(&self.v, v.ends())];
            for index in i.clone().flat_map(|i| j.clone().map(move |j| i * (columns + 1) + j)) {
                if let Some(Some(sample)) = self.samples.get_mut(index) {
                    sample.rest = true;
                }
            }
            // A rectangle between two grid lines holds no sample, but meets the cell around it: cells count from the value
            // before the range to that behind it.
            let [i, j] = [i, j].map(|range| range.start.saturating_sub(1)..range.end);
            for (i, j) in i.flat_map(|i| j.clone().map(move |j| (i, j))) {
                if i < rows && j < columns {
                    self.unfinished[i * columns + j] = true;
                }
            }
        }
    }
}

impl FaceMap {
    /// Takes over the deeper gouges of another map. Uncut points stay uncut.
    pub(in crate::verify) fn deepen(&mut self, other: &Self) {
        for (sample, other) in self.samples.iter_mut().zip(&other.samples) {
            let (Some(sample), Some(other)) = (sample, other) else { continue };
            // `None`, uncut, compares below every height and is kept.
            if sample.height > other.height && other.height.is_some_and(|height| height < 0.0) {
                (sample.height, sample.line) = (other.height, other.line);
                sample.dog_leg = other.dog_leg;
            }
        }
    }

    /// Returns a line of the other map that finishes a point over which this one leaves more than `total` \[mm\], outside
    /// known rest material.
    pub(in crate::verify) fn finished_by(&self, other: &Self, total: f64) -> Option<u32> {
        let pairs = self.samples.iter().flatten().zip(other.samples.iter().flatten());
        let mut open = pairs.filter(|(sample, _)| {
            !sample.rest && sample.height.is_none_or(|height| height > total)
        });
        open.find_map(|(_, other)| other.line.filter(|_| other.height <= Some(total)))
    }
}

/// Returns the indices of increasing values that lie in a range.
fn held(values: &[f64], [low, high]: [f64; 2]) -> std::ops::Range<usize> {
    values.partition_point(|value| *value < low)..values.partition_point(|value| *value <= high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tongue of the rest between two grid lines meets the cells it runs through, and no sample.
    #[test]
    fn a_rest_thinner_than_the_grid_is_noted() {
        assert_eq!(held(&[0.0, 1.0, 2.0, 3.0], [0.5, 2.0]), 1..3);
        assert!(held(&[0.0, 1.0, 2.0, 3.0], [1.2, 1.4]).is_empty());
        let axis = vec![0.0, 1.0, 2.0, 3.0];
        let (u, v) = (axis.clone(), axis);
        let samples = vec![None; 16];
        let mut map = FaceMap { face: 1, u, v, samples, unmeasured: 0, unfinished: Vec::new() };
        let rest = crate::types::UncutRegion {
            face: 1,
            cells: vec![[[1.2, 1.4].into(), [0.5, 2.5].into()]],
            area: 0.4,
            uv: [[1.2, 1.4].into(), [0.5, 2.5].into()],
            bounds: [Point3::origin(); 2],
            depth: 1.0,
            deepest: [1.3, 1.0].into(),
            point: Point3::origin(),
            ball: 1.0,
            balls: [1.0; 2].into(),
            reason: crate::types::UncutReason::Hollow,
        };
        map.note(&[rest]);
        let cells: Vec<usize> = (0..9).filter(|i| map.unfinished[*i]).collect();
        assert_eq!(cells, [3, 4, 5]);
    }
}
