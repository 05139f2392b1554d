//! What passes leave: connected parts of the face, how much stands on them, and why.

use super::fit::{self, Spot};
use super::left::Swept;
use super::region::{Local, Region};
use super::sheet::{Cell, edge};
use super::site::Site;
use super::state::State;
use super::sweep::Sweep;
use crate::types::{UncutReason, UncutRegion};
use nalgebra::Point3;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

/// Size of the cells at the edges of what is left, as a share of a narrow strip.
const CELL: f64 = 1.0 / 16.0;

/// Size of the cells of a closer look, where a cell is finished at its middle, as a share of the least spacing.
const FINEST: f64 = 0.125;

/// Places of one part at which is looked how much stands there and what fits, about.
const LOOKS: usize = 48;

/// Places a way across a cell at the face's edge, by which its area is told; parts a way of a range on a bent chart.
const PARTS: u32 = 4;

/// To what share of the path's tolerance a ball keeps off the faces.
const PRECISION: f64 = 0.05;

/// Ranges across and along of a cell.
type Range = [[f64; 2]; 2];

impl<Inside: Fn(Local) -> bool + Sync> Site<'_, Inside> {
    /// What is unfinished in the end of what was missed, the largest part first: passes further on may have swept
    /// over it.
    pub(super) fn rest(&self, state: &State) -> Vec<UncutRegion> {
        let boxes: Vec<Range> = state.missed.iter().map(|uv| self.local_range(*uv)).collect();
        if boxes.is_empty() {
            return Vec::new();
        }
        let sweeps: Vec<&Sweep> =
            state.swept.iter().chain(&state.recent).map(AsRef::as_ref).collect();
        let region = self.whole.complete();
        let swept = self.over(&region, &sweeps);
        let sizes = [CELL * self.narrow(), FINEST * self.options.spacing[0]];
        let open = swept.open(&boxes, sizes);
        let mut rest: Vec<UncutRegion> = parts(&open)
            .into_par_iter()
            .filter_map(|cells| self.part(&region, &swept, &cells))
            .collect();
        rest.sort_by(|a, b| b.area.total_cmp(&a.area));
        rest
    }

    /// To what the area of what is left is told \[mm²\]: cells on its rim count in full, and the rim of each part
    /// is about as long as that of its box.
    pub(super) fn resolved(&self, rest: &[UncutRegion]) -> f64 {
        let rim = |[low, high]: &[Point3<f64>; 2]| 2.0 * (high - low).sum();
        CELL * self.narrow() * rest.iter().map(|part| rim(&part.bounds)).sum::<f64>()
    }

    /// Ranges of u and v that hold a range across and along.
    pub(super) fn uv_range(&self, range: Range) -> Range {
        image(range, self.chart.is_straight(), &|local| self.chart.uv(local))
    }

    /// Ranges across and along that hold a range of u and v.
    pub(super) fn local_range(&self, range: Range) -> Range {
        image(range, self.chart.is_straight(), &|uv| self.chart.local(uv))
    }

    /// One connected part.
    fn part(
        &self,
        region: &Region<&Inside>,
        swept: &Swept<'_, &Inside>,
        cells: &[Range],
    ) -> Option<UncutRegion> {
        let chart = &self.chart;
        let at = |local: Local| {
            let [u, v] = chart.uv(local);
            self.face.face().point(u, v)
        };
        let mut area = 0.0;
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &range in cells {
            let cell = Cell::new(range, &at);
            area += cell.area() * inside(region, range);
            for corner in cell.corners() {
                low = [0, 1, 2].map(|k: usize| low[k].min(corner[k]));
                high = [0, 1, 2].map(|k: usize| high[k].max(corner[k]));
            }
        }
        let looks = self.looks(region, swept, cells);
        let ball = |look: &LookedAt| look.ball;
        let deepest = looks.iter().max_by(|a, b| a.depth.total_cmp(&b.depth))?;
        let balls = looks.iter().map(ball);
        let uv: Vec<Range> = cells.iter().map(|range| self.uv_range(*range)).collect();
        Some(UncutRegion {
            face: self.face.face().number,
            area,
            uv: hull(&uv),
            cells: uv,
            bounds: [Point3::from(low), Point3::from(high)],
            depth: deepest.depth,
            deepest: chart.uv(deepest.place),
            point: at(deepest.place),
            ball: deepest.ball,
            balls: [balls.clone().fold(f64::INFINITY, f64::min), balls.fold(0.0, f64::max)],
            reason: self.reason(deepest.place),
        })
    }

    /// Places of some cells, spread over them.
    fn looks(
        &self,
        region: &Region<&Inside>,
        swept: &Swept<'_, &Inside>,
        cells: &[Range],
    ) -> Vec<LookedAt> {
        let middle = |range: &Range| range.map(|[low, high]| 0.5 * (low + high));
        let held = |range: &&Range| region.holds(middle(range));
        let inside: Vec<&Range> = cells.iter().filter(held).collect();
        // Where no middle of a cell is inside, the first is as good as any.
        let places = if inside.is_empty() {
            vec![middle(cells.first().unwrap_or(&[[0.0; 2]; 2]))]
        } else {
            spread(&inside).into_iter().map(middle).collect()
        };
        let precision = PRECISION * self.options.path_share;
        let look = |&place: &Local| {
            let spot = Spot::new(self.face, self.chart.uv(place))?;
            let ball = fit::largest_ball(self.guards.0, &spot, self.cutter, precision);
            Some(LookedAt { place, depth: swept.height(&spot.point), ball })
        };
        places.par_iter().filter_map(look).collect()
    }

    fn reason(&self, place: Local) -> UncutReason {
        let spot = Spot::new(self.face, self.chart.uv(place));
        let reason = |spot: Spot| fit::reason(&self.around(), &spot, self.cutter);
        spot.map_or(UncutReason::Passes, reason)
    }
}

/// A place, what stands there, and the largest ball that fits.
struct LookedAt {
    place: Local,
    depth: f64,
    ball: f64,
}

/// About [`LOOKS`] of some cells, as many from each stretch of the list as it has of their area by parameters.
fn spread<'a>(cells: &[&'a Range]) -> Vec<&'a Range> {
    let area = |range: &Range| range.iter().map(|[low, high]| high - low).product::<f64>();
    let step = cells.iter().map(|range| area(range)).sum::<f64>() / LOOKS as f64;
    let (mut sum, mut next) = (0.0, 0.0);
    let mut chosen = Vec::new();
    for range in cells {
        sum += area(range);
        if sum > next {
            chosen.push(*range);
            next = (next + step).max(sum);
        }
    }
    chosen
}

/// Share of a cell that lies inside the region.
fn inside<Inside: Fn(Local) -> bool>(region: &Region<Inside>, range: Range) -> f64 {
    if region.edges(range).is_empty() {
        return 1.0;
    }
    let at = |k: usize, i: u32| {
        let [low, high] = range[k];
        low + (high - low) * (f64::from(i) + 0.5) / f64::from(PARTS)
    };
    let all = PARTS * PARTS;
    let held = (0..all).filter(|i| region.holds([at(0, i / PARTS), at(1, i % PARTS)])).count();
    held as f64 / f64::from(all)
}

/// The box around the image of a range: by its corners where the map exchanges parameters at most, else by parts
/// of it, each with what it bows.
fn image(range: Range, exchanged: bool, map: &dyn Fn([f64; 2]) -> [f64; 2]) -> Range {
    if exchanged {
        let [[a, b], [c, d]] = range;
        let [low, high] = [map([a, c]), map([b, d])];
        return [0, 1].map(|k| [low[k], high[k]]);
    }
    let at = |local: Local| {
        let [a, b] = map(local);
        Point3::new(a, b, 0.0)
    };
    let part =
        |k: usize, i: u32| [i, i + 1].map(|i| edge(range[k], f64::from(i) / f64::from(PARTS)));
    let of = |i: u32| {
        let cell = Cell::new([part(0, i / PARTS), part(1, i % PARTS)], &at);
        let corners = cell.corners().map(|p| [[p.x, p.x], [p.y, p.y]]);
        let bow = cell.sag(0) + cell.sag(1);
        hull(&corners).map(|[low, high]| [low - bow, high + bow])
    };
    hull(&(0..PARTS * PARTS).map(of).collect::<Vec<_>>())
}

/// The box around some ranges.
fn hull(ranges: &[Range]) -> Range {
    let mut hull = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for range in ranges {
        for k in 0..2 {
            hull[k] = [hull[k][0].min(range[k][0]), hull[k][1].max(range[k][1])];
        }
    }
    hull
}

/// Cells by connected parts, those that touch at an edge or a corner being connected.
fn parts(cells: &[Range]) -> Vec<Vec<Range>> {
    let mut order: Vec<usize> = (0..cells.len()).collect();
    order.sort_by(|&i, &j| cells[i][0][0].total_cmp(&cells[j][0][0]).then(i.cmp(&j)));
    let mut parent: Vec<usize> = (0..cells.len()).collect();
    let mut front = Front::default();
    for &i in &order {
        front.touching(cells, i, |j| {
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            parent[a.max(b)] = a.min(b);
        });
        front.add(cells, i);
    }
    let mut parts: Vec<(usize, Vec<Range>)> = Vec::new();
    let mut known = std::collections::HashMap::new();
    for (i, cell) in cells.iter().enumerate() {
        let first = root(&mut parent, i);
        let part = *known.entry(first).or_insert_with(|| {
            parts.push((first, Vec::new()));
            parts.len() - 1
        });
        parts[part].1.push(*cell);
    }
    parts.into_iter().map(|(_, cells)| cells).collect()
}

/// The cells that a line of constant first parameter meets while it moves on. Those of like height, within a factor of
/// two, are ordered by where they begin: only a few of each kind can touch a cell.
#[derive(Default)]
struct Front {
    /// By the exponent of their height: the largest height, and where they begin with their indices.
    kinds: BTreeMap<u64, (f64, BTreeSet<(Ordered, usize)>)>,
}

impl Front {
    fn add(&mut self, cells: &[Range], i: usize) {
        let [low, high] = cells[i][1];
        let height = high - low;
        let kind = self.kinds.entry(height.to_bits() >> (f64::MANTISSA_DIGITS - 1)).or_default();
        kind.0 = kind.0.max(height);
        kind.1.insert((Ordered(low), i));
    }

    /// Tells of each cell that touches cell `i`, which begins no earlier than any before it; those that end before it are
    /// dropped.
    fn touching(&mut self, cells: &[Range], i: usize, mut tell: impl FnMut(usize)) {
        let [[start, _], [low, high]] = cells[i];
        for (most, kind) in self.kinds.values_mut() {
            // A sum is rounded: what begins a little lower is looked at as well.
            let first = low - *most * (1.0 + f64::EPSILON) - low.abs() * f64::EPSILON;
            let near = (Ordered(first), 0)..=(Ordered(high), usize::MAX);
            let mut ended = Vec::new();
            for &(begin, j) in kind.range(near) {
                // Halves of one range share their ends exactly.
                if cells[j][0][1] < start {
                    ended.push((begin, j));
                } else if cells[j][1][1] >= low {
                    tell(j);
                }
            }
            for one in ended {
                kind.remove(&one);
            }
        }
    }
}

/// A number by its total order.
#[derive(Clone, Copy)]
struct Ordered(f64);

impl PartialEq for Ordered {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Ordered {}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halves of halves of a square, some of them left out, against every pair.
    #[test]
    fn parts_are_those_of_all_pairs() {
        let mut state = 7_u64;
        let mut roll = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state >> 40
        };
        for _ in 0..20 {
            let mut cells: Vec<Range> = Vec::new();
            let mut waiting = vec![([[-0.3, 1.1], [0.7, 2.9]], 0_u32)];
            while let Some(([a, b], depth)) = waiting.pop() {
                let halves = |[low, high]: [f64; 2]| {
                    let middle = 0.5 * (low + high);
                    [[low, middle], [middle, high]]
                };
                match roll() % 8 {
                    0 if depth > 3 => {}
                    1 | 2 if depth > 3 => cells.push([a, b]),
                    n if depth < 11 => {
                        let split = if n % 2 == 0 {
                            halves(a).map(|a| [a, b])
                        } else {
                            halves(b).map(|b| [a, b])
                        };
                        waiting.extend(split.map(|cell| (cell, depth + 1)));
                    }
                    _ => cells.push([a, b]),
                }
            }
            cells.retain(|_| roll() % 2 == 0);
            let touch =
                |a: &Range, b: &Range| (0..2).all(|k| a[k][0] <= b[k][1] && b[k][0] <= a[k][1]);
            let mut parent: Vec<usize> = (0..cells.len()).collect();
            for i in 0..cells.len() {
                for j in (0..i).filter(|j| touch(&cells[i], &cells[*j])) {
                    let (a, b) = (root(&mut parent, i), root(&mut parent, j));
                    parent[a.max(b)] = a.min(b);
                }
            }
            let roots = (0..cells.len()).filter(|i| parent[*i] == *i).count();
            let found = parts(&cells);
            assert_eq!(found.len(), roots);
            let of = |cell: &Range| cells.iter().position(|c| c == cell).unwrap();
            for part in &found {
                let first = root(&mut parent, of(&part[0]));
                assert!(part.iter().all(|cell| root(&mut parent, of(cell)) == first));
            }
        }
    }

    #[test]
    fn cells_that_touch_are_one_part() {
        let cell = |a: f64, b: f64| [[a, a + 1.0], [b, b + 1.0]];
        let found = parts(&[cell(0.0, 0.0), cell(5.0, 0.0), cell(1.0, 1.0), cell(0.0, 3.0)]);
        let sizes: Vec<usize> = found.iter().map(Vec::len).collect();
        assert_eq!(sizes, [2, 1, 1]);
        assert_eq!(hull(&found[0]), [[0.0, 2.0], [0.0, 2.0]]);
    }

    #[test]
    fn the_share_of_a_cell_inside_by_pencil() {
        let half = vec![[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.0, 1.0]];
        let region = Region::new([[0.0, 1.0]; 2], vec![half], |[x, _]: Local| x < 0.5);
        assert!((inside(&region, [[0.0, 1.0]; 2]) - 0.5).abs() < 1e-12);
        assert!((inside(&region, [[0.1, 0.2], [0.1, 0.2]]) - 1.0).abs() < 1e-12);
    }
}
