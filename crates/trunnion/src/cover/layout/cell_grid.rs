//! Cells of a face that are left out of the region that passes finish.

use super::chart::Chart;
use super::region::{ChartPoint, TrimmedRegion};
use super::trims::{region, shifts};
use crate::cover::prove::face_tree::edge;
use crate::surface::FaceIndex;
use crate::types::Interval;
use std::sync::Arc;

/// Margin round the ranges of cells, as a share of a cell. On a bent chart an edge bows by far less.
const BESIDE: f64 = 0.25;

/// Even grid over the box of a face, with the cells that are left out.
#[derive(Debug, Clone)]
pub(crate) struct CellGrid {
    bounds: [Interval; 2],
    /// `[u, v]`-periods of the surface.
    periods: [Option<f64>; 2],
    /// Cells along u and along v.
    counts: [usize; 2],
    /// By u, then by v.
    cells: Vec<bool>,
}

impl CellGrid {
    /// Leaves out the cells for which `is_out` is true; `None` where there are none.
    pub(crate) fn new(
        face: &FaceIndex,
        counts: [usize; 2],
        is_out: impl Fn([usize; 2]) -> bool,
    ) -> Option<Self> {
        let (bounds, periods) = (face.face().bounds(), face.face().surface.periods());
        let [wide, high] = counts;
        let cells: Vec<bool> = (0..wide * high).map(|i| is_out([i / high, i % high])).collect();
        cells.contains(&true).then_some(Self { bounds, periods, counts, cells })
    }

    /// Returns `true` if a point lies in a cell that is left out.
    pub(crate) fn holds(&self, uv: [f64; 2]) -> bool {
        let index = |k: usize| {
            let Interval { low, high } = self.bounds[k];
            // Parameters beyond the box of a periodic surface are brought back by whole periods.
            let by = self.periods[k].map_or(0.0, |p| ((uv[k] - low) / p).floor() * p);
            let share = (uv[k] - by - low) / (high - low);
            // The end of a closed face is its start.
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "within the box: small and positive"
            )]
            let index = (share * self.counts[k] as f64) as usize;
            (0.0..=1.0).contains(&share).then_some(index.min(self.counts[k] - 1))
        };
        index(0).zip(index(1)).is_some_and(|(i, j)| self.is_out(i, j))
    }

    fn is_out(&self, i: usize, j: usize) -> bool {
        self.cells.get(i * self.counts[1] + j).copied().unwrap_or(false)
    }

    fn line(&self, k: usize, i: usize) -> f64 {
        edge(self.bounds[k].ends(), i as f64 / self.counts[k] as f64)
    }

    /// Returns ranges of u and v that together hold all cells that are left out, each a little larger: on a bent chart the
    /// edges of the region are chords, and a sliver beside them belongs to neither.
    pub(crate) fn ranges(&self) -> Vec<[[f64; 2]; 2]> {
        let around = |k: usize, first: usize, last: usize| {
            let margin = BESIDE * self.bounds[k].width() / self.counts[k] as f64;
            let (low, high) = (self.line(k, first) - margin, self.line(k, last) + margin);
            [low.max(self.bounds[k].low), high.min(self.bounds[k].high)]
        };
        let mut ranges = Vec::new();
        for i in 0..self.counts[0] {
            let u = around(0, i, i + 1);
            for [first, last] in runs(self.counts[1], |j| self.is_out(i, j)) {
                ranges.push([u, around(1, first, last)]);
            }
        }
        ranges
    }

    /// Returns the edges between these cells and the others, in local parameters.
    fn edges(&self, chart: &Chart, shift: [f64; 2]) -> Vec<[ChartPoint; 2]> {
        let mut edges = Vec::new();
        for k in 0..2 {
            let place = |i: usize, j: usize| {
                let at = [self.line(k, i), self.line(1 - k, j)];
                let uv = if k == 0 { at } else { [at[1], at[0]] };
                chart.local([uv[0] + shift[0], uv[1] + shift[1]])
            };
            let out = |i: usize, j: usize| {
                if k == 0 { self.is_out(i, j) } else { self.is_out(j, i) }
            };
            for line in 1..self.counts[k] {
                let changes = |j| out(line - 1, j) != out(line, j);
                for [first, last] in runs(self.counts[1 - k], changes) {
                    edges.extend((first..last).map(|j| [place(line, j), place(line, j + 1)]));
                }
            }
        }
        edges
    }
}

/// Returns the trimmed region of a face without some cells.
pub(crate) fn region_without<'a>(
    face: &'a FaceIndex,
    chart: &Chart,
    out: Option<&Arc<CellGrid>>,
) -> TrimmedRegion<impl Fn(ChartPoint) -> bool + Sync + use<'a>> {
    let region = region(face, chart);
    let Some(out) = out else { return region };
    let surface = &face.face().surface;
    let [pu, pv] = surface.periods().map(|period| shifts(period, chart));
    let shifts = pu.iter().flat_map(|du| pv.iter().map(|dv| [*du, *dv]));
    let edges = shifts.flat_map(|shift| out.edges(chart, shift)).collect();
    let (out, chart) = (Arc::clone(out), chart.clone());
    region.without(move |local| out.holds(chart.uv(local)), edges)
}

/// Returns the runs of `count` cells for which something holds, each from its first to behind its last.
fn runs(count: usize, holds: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for j in (0..count).filter(|j| holds(*j)) {
        match runs.last_mut() {
            Some(last) if last[1] == j => last[1] = j + 1,
            _ => runs.push([j, j + 1]),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::FeedDirection;

    #[test]
    fn half_a_box_by_pencil() {
        // The upper half of the box 0..64 x 0..32, from v = 16 on; u is periodic.
        let (bounds, periods) =
            ([Interval::new(0.0, 64.0), Interval::new(0.0, 32.0)], [Some(64.0), None]);
        let counts = [64, 8];
        let cells = (0..64 * 8).map(|index| index % 8 >= 4).collect();
        let out = CellGrid { bounds, periods, counts, cells };
        assert!(out.holds([10.0, 17.0]) && out.holds([-3.0, 17.0]) && out.holds([64.0, 32.0]));
        assert!(!out.holds([10.0, 15.9]) && !out.holds([10.0, 33.0]));
        let ranges = out.ranges();
        assert_eq!(ranges.len(), 64);
        assert_eq!(ranges[3], [[2.75, 4.25], [15.0, 32.0]]);
        assert_eq!(ranges[0], [[0.0, 1.25], [15.0, 32.0]]);
        let edges = out.edges(&Chart::straight(FeedDirection::V), [0.0, 0.0]);
        assert_eq!(edges.len(), 64);
        assert!(edges.iter().flatten().all(|place| (place[1] - 16.0).abs() < 1e-12));
    }
}
