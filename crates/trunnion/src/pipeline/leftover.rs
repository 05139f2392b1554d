//! Regions of the faces that the operations of a job leave.

use super::job::Job;
use crate::cover::Covering;
use crate::import::inspect;
use crate::types::{Interval, UncutRegion};
use std::collections::BTreeMap;

/// Regions that the operations so far leave.
#[derive(Debug, Clone, Default)]
pub(super) struct Leftover {
    /// Regions, face after face in the order of their first operation.
    pub(super) regions: Vec<UncutRegion>,
    /// Areas of the faces that were cut, by number \[mm²\].
    areas: BTreeMap<usize, f64>,
}

impl Leftover {
    /// Returns what a single operation leaves.
    pub(super) fn of(job: &Job, covering: &Covering) -> Self {
        let mut left = Self::default();
        left.cut_whole(job, covering);
        left
    }

    /// Returns the area of all faces that were cut \[mm²\].
    pub(super) fn area(&self) -> f64 {
        self.areas.values().sum()
    }

    /// Returns the numbers of the faces that were cut.
    pub(super) fn cut_faces(&self) -> Vec<usize> {
        self.areas.keys().copied().collect()
    }

    /// Returns the regions on the faces of an operation.
    pub(super) fn on(&self, job: &Job) -> Vec<UncutRegion> {
        let regions = self.regions.iter().filter(|region| is_cut(job, region.face));
        regions.cloned().collect()
    }

    /// Takes in an operation over whole faces: of a face that was cut before, only what both leave is left.
    pub(super) fn cut_whole(&mut self, job: &Job, covering: &Covering) {
        let (of_job, others): (Vec<_>, Vec<_>) =
            self.regions.drain(..).partition(|region| is_cut(job, region.face));
        self.regions = others;
        let share = covering.report.area / job.faces.len().max(1) as f64;
        for face in &job.faces {
            let number = face.face().number;
            let before: Vec<&UncutRegion> =
                of_job.iter().filter(|region| region.face == number).collect();
            let was_cut = self.areas.insert(number, share).is_some();
            let now = covering.report.rest.iter().filter(|region| region.face == number);
            if was_cut {
                self.regions.extend(now.filter_map(|region| common(region, &before)));
            } else {
                self.regions.extend(now.cloned());
            }
        }
    }

    /// Takes in an operation over what was left, which is all of a face that was not cut before.
    pub(super) fn cut_rest(&mut self, job: &Job, covering: &Covering) {
        for face in &job.faces {
            let area = || inspect::summary(face.face()).area;
            self.areas.entry(face.face().number).or_insert_with(area);
        }
        self.regions.retain(|region| !is_cut(job, region.face));
        self.regions.extend(covering.report.rest.iter().cloned());
    }
}

/// Returns true for a face that the operation cuts.
fn is_cut(job: &Job, number: usize) -> bool {
    job.faces.iter().any(|face| face.face().number == number)
}

/// Returns the cells of a region that meet one of those before.
fn common(region: &UncutRegion, before: &[&UncutRegion]) -> Option<UncutRegion> {
    let size =
        |cell: &[Interval; 2]| cell.iter().map(|range| range.high - range.low).product::<f64>();
    let meet = |a: &[Interval; 2], b: &[Interval; 2]| {
        (0..2).all(|k| a[k].low < b[k].high && b[k].low < a[k].high)
    };
    let kept = |cell: &&[Interval; 2]| {
        before.iter().any(|other| other.cells.iter().any(|cut| meet(cut, cell)))
    };
    let cells: Vec<[Interval; 2]> = region.cells.iter().filter(kept).copied().collect();
    let [all, some] = [&region.cells, &cells].map(|cells| cells.iter().map(size).sum::<f64>());
    // The area of a cell is not known by itself: parameters stand for it.
    let share = some / all.max(f64::MIN_POSITIVE);
    (!cells.is_empty()).then(|| UncutRegion { cells, area: share * region.area, ..region.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{UncutReason, Uv};
    use nalgebra::Point3;

    fn region(cells: &[[f64; 4]]) -> UncutRegion {
        let cell = |&[a, b, c, d]: &[f64; 4]| [Interval::new(a, b), Interval::new(c, d)];
        UncutRegion {
            face: 1,
            cells: cells.iter().map(cell).collect(),
            area: 8.0,
            uv: [Interval::new(0.0, 1.0); 2],
            bounds: [Point3::origin(); 2],
            depth: 0.1,
            deepest: Uv::new(0.0, 0.0),
            point: Point3::origin(),
            ball: 1.0,
            balls: Interval::point(1.0),
            reason: UncutReason::Hollow,
        }
    }

    #[test]
    fn only_what_both_leave_is_left() {
        let now = region(&[[0.0, 0.25, 0.0, 1.0], [0.25, 1.0, 0.0, 1.0]]);
        let before = region(&[[0.9, 1.0, 0.9, 1.0]]);
        let left = common(&now, &[&before]).unwrap();
        assert_eq!(left.cells, now.cells[1..]);
        assert!((left.area - 6.0).abs() < 1e-12);
        // Cells that share an edge have nothing in common.
        assert_eq!(common(&region(&[[0.0, 0.9, 0.0, 1.0]]), &[&before]), None);
    }
}
