//! Cells of a face that the machine reaches at no inclination. No passes are placed there.

use crate::cover::cost::PassCost;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::{ChartPoint, TrimmedRegion};
use crate::cover::layout::trims::{region, shifts};
use crate::cover::place::tool_fit::{self, ContactPoint};
use crate::cover::prove::face_tree::edge;
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use rayon::prelude::*;
use std::sync::Arc;

/// Cells each way of the grid.
const CELLS: usize = 64;

/// Cells of a face's box that the machine does not reach.
#[derive(Debug, Clone)]
pub(crate) struct UnreachableCells {
    bounds: [[f64; 2]; 2],
    /// `[u, v]`-periods of the surface.
    periods: [Option<f64>; 2],
    /// By u, then by v.
    cells: Vec<bool>,
}

impl UnreachableCells {
    /// Finds the cells without reach at all their corners; `None` where there are none.
    ///
    /// A pose that is inclined a little more than any tool would be counts as reached. So a cell
    /// that is left out holds nothing that a pass could finish, but for slivers far smaller than a
    /// cell.
    pub(crate) fn of(face: &FaceIndex, cutter: &Cutter, cost: &dyn PassCost) -> Option<Self> {
        let (bounds, periods) = (face.face().bounds(), face.face().surface.periods());
        let line = |k: usize, i: usize| edge(bounds[k], i as f64 / CELLS as f64);
        let wide = CELLS + 1;
        let out: Vec<bool> = (0..wide * wide)
            .into_par_iter()
            .map(|i| {
                let contact = ContactPoint::new(face, [line(0, i / wide), line(1, i % wide)]);
                contact.is_some_and(|contact| !tool_fit::reached(cost, &contact, cutter))
            })
            .collect();
        let at = |i: usize, j: usize| out.get(i * wide + j).copied().unwrap_or(true);
        let cell = |index: usize| {
            let (i, j) = (index / CELLS, index % CELLS);
            [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)].iter().all(|out| *out)
        };
        let cells: Vec<bool> = (0..CELLS * CELLS).map(cell).collect();
        cells.contains(&true).then_some(Self { bounds, periods, cells })
    }

    /// Returns `true` if a point lies in such a cell.
    pub(crate) fn holds(&self, uv: [f64; 2]) -> bool {
        let index = |k: usize| {
            let [low, high] = self.bounds[k];
            // Parameters beyond the box of a periodic surface are brought back by whole periods.
            let by = self.periods[k].map_or(0.0, |p| ((uv[k] - low) / p).floor() * p);
            let share = (uv[k] - by - low) / (high - low);
            // The end of a closed face is its start.
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "within the box: small and positive"
            )]
            let index = (share * CELLS as f64) as usize;
            (0.0..=1.0).contains(&share).then_some(index.min(CELLS - 1))
        };
        index(0).zip(index(1)).is_some_and(|(i, j)| self.out(i, j))
    }

    fn out(&self, i: usize, j: usize) -> bool {
        self.cells.get(i * CELLS + j).copied().unwrap_or(false)
    }

    fn line(&self, k: usize, i: usize) -> f64 {
        edge(self.bounds[k], i as f64 / CELLS as f64)
    }

    /// Returns ranges of u and v that together make up all cells.
    pub(crate) fn ranges(&self) -> Vec<[[f64; 2]; 2]> {
        let mut ranges = Vec::new();
        for i in 0..CELLS {
            let u = [self.line(0, i), self.line(0, i + 1)];
            for [first, last] in runs(|j| self.out(i, j)) {
                ranges.push([u, [self.line(1, first), self.line(1, last)]]);
            }
        }
        ranges
    }

    /// Returns the edges between these cells and the others, in local parameters.
    pub(crate) fn edges(&self, chart: &Chart, shift: [f64; 2]) -> Vec<[ChartPoint; 2]> {
        let mut edges = Vec::new();
        for k in 0..2 {
            let place = |i: usize, j: usize| {
                let at = [self.line(k, i), self.line(1 - k, j)];
                let uv = if k == 0 { at } else { [at[1], at[0]] };
                chart.local([uv[0] + shift[0], uv[1] + shift[1]])
            };
            let out = |i: usize, j: usize| if k == 0 { self.out(i, j) } else { self.out(j, i) };
            for line in 1..CELLS {
                for [first, last] in runs(|j| out(line - 1, j) != out(line, j)) {
                    edges.extend((first..last).map(|j| [place(line, j), place(line, j + 1)]));
                }
            }
        }
        edges
    }
}

/// Returns the trimmed region without the cells that the machine does not reach.
pub(crate) fn within_reach<'a>(
    face: &'a FaceIndex,
    chart: &Chart,
    beyond: Option<&Arc<UnreachableCells>>,
) -> TrimmedRegion<impl Fn(ChartPoint) -> bool + Sync + use<'a>> {
    let region = region(face, chart);
    let Some(beyond) = beyond else { return region };
    let surface = &face.face().surface;
    let [pu, pv] = surface.periods().map(|period| shifts(period, chart));
    let shifts = pu.iter().flat_map(|du| pv.iter().map(|dv| [*du, *dv]));
    let edges = shifts.flat_map(|shift| beyond.edges(chart, shift)).collect();
    let (beyond, chart) = (Arc::clone(beyond), chart.clone());
    region.without(move |local| beyond.holds(chart.uv(local)), edges)
}

/// Returns the runs of cells for which something holds, each from its first to behind its last.
fn runs(holds: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for j in (0..CELLS).filter(|j| holds(*j)) {
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

    fn beyond() -> UnreachableCells {
        // The upper half of the box 0..64 x 0..32, from v = 16 on.
        let cells = (0..CELLS * CELLS).map(|index| index % CELLS >= 32).collect();
        UnreachableCells { bounds: [[0.0, 64.0], [0.0, 32.0]], periods: [Some(64.0), None], cells }
    }

    #[test]
    fn half_a_box_by_pencil() {
        let beyond = beyond();
        assert!(
            beyond.holds([10.0, 17.0]) && beyond.holds([-3.0, 17.0]) && beyond.holds([64.0, 32.0])
        );
        assert!(!beyond.holds([10.0, 15.9]) && !beyond.holds([10.0, 33.0]));
        let ranges = beyond.ranges();
        assert_eq!(ranges.len(), CELLS);
        assert_eq!(ranges[3], [[3.0, 4.0], [16.0, 32.0]]);
        let edges = beyond.edges(&Chart::straight(FeedDirection::V), [0.0, 0.0]);
        assert_eq!(edges.len(), CELLS);
        assert!(edges.iter().flatten().all(|place| (place[1] - 16.0).abs() < 1e-12));
    }
}
