//! Regions in which a tolerance is broken: connected points of a grid, and what the proof found between them.

use super::options::CheckOptions;
use super::report::{ExtremeHeight, FaceMap, HeightSample};
use std::collections::BTreeSet;

/// Tolerance that a height breaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BrokenTolerance {
    /// The tool cuts deeper than allowed.
    Gouge,
    /// More material is left than allowed.
    Excess,
}

impl BrokenTolerance {
    /// Tests if a height \[mm\] breaks the tolerance. A gouge is judged with the ray tolerance against it.
    fn is_broken_by(self, height: f64, options: &CheckOptions) -> bool {
        match self {
            Self::Gouge => height - options.ray_tolerance < -options.gouge,
            Self::Excess => height > options.total,
        }
    }

    /// Returns the height of a sample if it breaks the tolerance. Known rest material may keep any height.
    fn breach(
        self,
        face: usize,
        sample: &HeightSample,
        options: &CheckOptions,
    ) -> Option<ExtremeHeight> {
        let counts = self == Self::Gouge || !sample.rest;
        let height = sample.height.filter(|height| counts && self.is_broken_by(*height, options));
        // At the end of the search range a depth is only a lower bound.
        let or_deeper = height? <= -options.reach;
        ExtremeHeight::of(face, sample).map(|region| ExtremeHeight { or_deeper, ..region })
    }
}

/// Returns the regions of all faces in which a tolerance is broken, each by its worst height, the worst first; `between` are heights found between
/// the points of the maps.
///
/// Points that touch on the grid are one region. A wrong location makes two moves wrong, so what one line makes worst on a
/// face and what the next does are one region, too.
pub(super) fn broken<'a>(
    by: BrokenTolerance,
    maps: impl IntoIterator<Item = &'a FaceMap>,
    between: &[ExtremeHeight],
    options: &CheckOptions,
) -> Vec<ExtremeHeight> {
    let of = |map: &FaceMap| MapBreaches::new(by, map, between, options).regions();
    let mut regions: Vec<ExtremeHeight> = maps.into_iter().flat_map(of).collect();
    // Heights of one kind have one sign. A stable sort: equal regions keep the order of the faces.
    regions.sort_by(|a, b| b.height.abs().total_cmp(&a.height.abs()));
    let mut stated = BTreeSet::new();
    regions.retain(|ExtremeHeight { face, line, .. }| {
        let lines = line.saturating_sub(1)..=line.saturating_add(1);
        let is_new = !lines.into_iter().any(|line| stated.contains(&(*face, line)));
        stated.insert((*face, *line));
        is_new
    });
    regions
}

/// Broken heights over one face.
struct MapBreaches<'a> {
    map: &'a FaceMap,
    /// By point of the grid: the height there breaks the tolerance.
    marked: Vec<bool>,
    /// Broken heights, with the marked point at which each lies, if there is one.
    heights: Vec<(Option<usize>, ExtremeHeight)>,
}

impl<'a> MapBreaches<'a> {
    fn new(
        by: BrokenTolerance,
        map: &'a FaceMap,
        between: &[ExtremeHeight],
        options: &CheckOptions,
    ) -> Self {
        let at_point = |(index, sample): (usize, &Option<HeightSample>)| {
            Some((index, by.breach(map.face, sample.as_ref()?, options)?))
        };
        let points: Vec<(usize, ExtremeHeight)> =
            map.samples.iter().enumerate().filter_map(at_point).collect();
        let mut marked = vec![false; if points.is_empty() { 0 } else { map.samples.len() }];
        for (index, _) in &points {
            marked[*index] = true;
        }
        let is_marked = |index: &usize| marked.get(*index).is_some_and(|marked| *marked);
        let broken = |e: &&ExtremeHeight| e.face == map.face && by.is_broken_by(e.height, options);
        let found = between.iter().filter(broken);
        let found = found.map(|height| (corners(map, height).find(is_marked), *height));
        let points = points.into_iter().map(|(index, height)| (Some(index), height));
        Self { map, heights: points.chain(found).collect(), marked }
    }

    /// Returns the worst height of each group of marked points that touch, and all heights away from them.
    fn regions(mut self) -> Vec<ExtremeHeight> {
        // Worst first: a height whose point has lost its mark belongs to a region that is known.
        self.heights.sort_by(|(_, a), (_, b)| b.height.abs().total_cmp(&a.height.abs()));
        let heights = std::mem::take(&mut self.heights);
        let mut regions = Vec::new();
        for (index, height) in heights {
            let is_new = index.is_none_or(|index| self.marked[index]);
            if is_new {
                regions.push(height);
            }
            if let Some(index) = index.filter(|_| is_new) {
                self.unmark_all_touching(index);
            }
        }
        regions
    }

    /// Takes the marks off a point and off all that are connected to it.
    fn unmark_all_touching(&mut self, index: usize) {
        let mut open = vec![index];
        while let Some(index) = open.pop() {
            let Some(marked) = self.marked.get_mut(index).filter(|marked| **marked) else {
                continue;
            };
            *marked = false;
            open.extend(neighbours(self.map, index));
        }
    }
}

/// Returns the points of the grid around a point, including itself.
fn neighbours(map: &FaceMap, index: usize) -> impl Iterator<Item = usize> + use<> {
    let [rows, columns] = [map.u.len(), map.v.len()];
    let [i, j] = [index / columns, index % columns];
    let along = move |k: usize, count: usize| k.saturating_sub(1)..(k + 2).min(count);
    along(i, rows).flat_map(move |i| along(j, columns).map(move |j| i * columns + j))
}

/// Returns the corners of the cell that holds a height.
fn corners(map: &FaceMap, height: &ExtremeHeight) -> impl Iterator<Item = usize> + use<> {
    let columns = map.v.len();
    let cell = |values: &[f64], at: f64| {
        let next = values.partition_point(|value| *value <= at);
        next.saturating_sub(1)..(next + 1).min(values.len())
    };
    let [i, j] = [cell(&map.u, height.uv.u), cell(&map.v, height.uv.v)];
    i.flat_map(move |i| j.clone().map(move |j| i * columns + j))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::DeviationTolerance;
    use nalgebra::Point3;
    use proptest::prelude::*;

    const ROWS: usize = 9;
    const COLUMNS: usize = 7;

    fn options() -> CheckOptions {
        CheckOptions::of_tolerance(DeviationTolerance { excess: 0.02, gouge: 0.002 }, 1.0)
    }

    /// A grid with these heights at some of its points; elsewhere 0.
    fn map(heights: &[([usize; 2], f64)]) -> FaceMap {
        let sample = |index: usize| {
            let [i, j] = [index / COLUMNS, index % COLUMNS];
            let found = heights.iter().find(|(at, _)| *at == [i, j]);
            let height = Some(found.map_or(0.0, |(_, height)| *height));
            // Each point is made by a line of its own, none next to that of another.
            let line = u32::try_from(2 * index).ok();
            let [u, v] = [i, j].map(|k| k as f64);
            let point = Point3::new(u, v, 0.0);
            let uv = [u, v].into();
            Some(HeightSample { uv, point, height, line, dog_leg: false, area: 1.0, rest: false })
        };
        FaceMap {
            face: 1,
            u: (0..ROWS).map(|i| i as f64).collect(),
            v: (0..COLUMNS).map(|j| j as f64).collect(),
            samples: (0..ROWS * COLUMNS).map(sample).collect(),
            unmeasured: 0,
            unfinished: Vec::new(),
        }
    }

    fn gouge(u: f64, v: f64, height: f64, line: u32) -> ExtremeHeight {
        let point = Point3::new(u, v, 0.0);
        let uv = [u, v].into();
        ExtremeHeight { face: 1, uv, point, height, or_deeper: false, line, dog_leg: false }
    }

    fn heights(map: &FaceMap, between: &[ExtremeHeight]) -> Vec<f64> {
        let regions =
            broken(BrokenTolerance::Gouge, std::slice::from_ref(map), between, &options());
        regions.iter().map(|region| region.height).collect()
    }

    #[test]
    fn points_that_touch_are_one_place() {
        let apart = [([1, 1], -0.003), ([2, 2], -0.005), ([2, 3], -0.004), ([5, 1], -0.006)];
        assert_eq!(heights(&map(&apart), &[]), [-0.006, -0.005]);
        // What keeps the tolerance is no region, and the last column does not touch the first of the next row.
        let ends = [([1, 6], -0.003), ([2, 0], -0.004), ([4, 4], -0.001)];
        assert_eq!(heights(&map(&ends), &[]), [-0.004, -0.003]);
    }

    #[test]
    fn what_is_found_between_the_points_belongs_to_the_place_around_it() {
        let map = map(&[([2, 2], -0.005)]);
        // In a cell at the point: the same region, by its deeper height.
        assert_eq!(heights(&map, &[gouge(2.5, 2.5, -0.006, 900)]), [-0.006]);
        // In the next cell: another region.
        assert_eq!(heights(&map, &[gouge(3.5, 2.5, -0.006, 900)]), [-0.006, -0.005]);
        // Of the same line, as the point at (2, 2) is made by line 32, or of the next: no further region.
        for line in [31, 32, 33] {
            assert_eq!(heights(&map, &[gouge(6.5, 2.5, -0.004, line)]), [-0.005]);
        }
        // At the last corner of the grid.
        assert_eq!(heights(&map, &[gouge(8.0, 6.0, -0.004, 900)]), [-0.005, -0.004]);
    }

    #[test]
    fn known_rest_is_no_excess_and_a_depth_at_the_end_of_the_search_may_be_deeper() {
        let mut map = map(&[([2, 2], 0.03), ([5, 5], 0.04), ([7, 1], -1.0)]);
        map.samples[2 * COLUMNS + 2].as_mut().unwrap().rest = true;
        let maps = std::slice::from_ref(&map);
        let excess = broken(BrokenTolerance::Excess, maps, &[], &options());
        assert_eq!(excess.iter().map(|region| region.height).collect::<Vec<_>>(), [0.04]);
        let gouges = broken(BrokenTolerance::Gouge, maps, &[], &options());
        assert!(gouges.len() == 1 && gouges[0].or_deeper, "{gouges:?}");
    }

    proptest! {
        /// As many regions as a search from point to point by brute force finds.
        #[test]
        fn places_are_the_connected_groups(marks in proptest::collection::vec(any::<bool>(), ROWS * COLUMNS)) {
            let at = |index: usize| [index / COLUMNS, index % COLUMNS];
            let marked: Vec<[usize; 2]> =
                marks.iter().enumerate().filter(|(_, is)| **is).map(|(k, _)| at(k)).collect();
            // Join labels until nothing changes.
            let mut labels: Vec<usize> = (0..marked.len()).collect();
            let mut changed = true;
            while changed {
                changed = false;
                for a in 0..marked.len() {
                    for b in 0..marked.len() {
                        let touch = (0..2).all(|k| marked[a][k].abs_diff(marked[b][k]) <= 1);
                        if touch && labels[b] < labels[a] {
                            labels[a] = labels[b];
                            changed = true;
                        }
                    }
                }
            }
            let groups: BTreeSet<usize> = labels.into_iter().collect();
            let low: Vec<_> = marked.iter().map(|at| (*at, -0.01)).collect();
            prop_assert_eq!(heights(&map(&low), &[]).len(), groups.len());
        }
    }
}
