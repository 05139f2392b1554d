//! Connected parts of a set of parameter boxes.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

/// Ranges across and along of a cell.
pub(crate) type ParameterBox = [[f64; 2]; 2];

/// Returns the box around some boxes.
pub(crate) fn hull(ranges: &[ParameterBox]) -> ParameterBox {
    let mut hull = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for range in ranges {
        for k in 0..2 {
            hull[k] = [hull[k][0].min(range[k][0]), hull[k][1].max(range[k][1])];
        }
    }
    hull
}

/// Groups cells into connected parts; cells that touch at an edge or a corner are connected.
///
/// A sweep along the first parameter with union-find.
pub(crate) fn parts(cells: &[ParameterBox]) -> Vec<Vec<ParameterBox>> {
    let mut order: Vec<usize> = (0..cells.len()).collect();
    order.sort_by(|&i, &j| cells[i][0][0].total_cmp(&cells[j][0][0]).then(i.cmp(&j)));
    let mut parent: Vec<usize> = (0..cells.len()).collect();
    let mut front = CellFront::default();
    for &i in &order {
        front.touching(cells, i, |j| {
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            // The lower index becomes the root, whatever the order of joining.
            parent[a.max(b)] = a.min(b);
        });
        front.add(cells, i);
    }
    // Collect the cells by root, in the order of the first cell of each part.
    let mut parts: Vec<(usize, Vec<ParameterBox>)> = Vec::new();
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

/// Cells that the sweep line of constant first parameter meets. Cells of like height, within a
/// factor of two, are ordered by their lower end: only a few of each kind can touch a cell.
#[derive(Default)]
struct CellFront {
    /// By the exponent of their height: the largest height, and the lower ends with their indices.
    kinds: BTreeMap<u64, (f64, BTreeSet<(TotalOrder, usize)>)>,
}

impl CellFront {
    fn add(&mut self, cells: &[ParameterBox], i: usize) {
        let [low, high] = cells[i][1];
        let height = high - low;
        // The exponent bits of the height group heights within a factor of two.
        let kind = self.kinds.entry(height.to_bits() >> (f64::MANTISSA_DIGITS - 1)).or_default();
        kind.0 = kind.0.max(height);
        kind.1.insert((TotalOrder(low), i));
    }

    /// Calls `found` for each cell that touches cell `i`, which begins no earlier than any before
    /// it. Cells that end before it are dropped.
    fn touching(&mut self, cells: &[ParameterBox], i: usize, mut found: impl FnMut(usize)) {
        let [[start, _], [low, high]] = cells[i];
        for (most, kind) in self.kinds.values_mut() {
            // A sum is rounded, so cells that begin a little lower are tried as well.
            let first = low - *most * (1.0 + f64::EPSILON) - low.abs() * f64::EPSILON;
            let near = (TotalOrder(first), 0)..=(TotalOrder(high), usize::MAX);
            let mut ended = Vec::new();
            for &(begin, j) in kind.range(near) {
                // Halves of one range share their ends exactly.
                if cells[j][0][1] < start {
                    ended.push((begin, j));
                } else if cells[j][1][1] >= low {
                    found(j);
                }
            }
            for one in ended {
                kind.remove(&one);
            }
        }
    }
}

/// Number in total order.
#[derive(Clone, Copy)]
struct TotalOrder(f64);

impl PartialEq for TotalOrder {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for TotalOrder {}

impl PartialOrd for TotalOrder {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for TotalOrder {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        // Path halving keeps the trees flat.
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
            let mut cells: Vec<ParameterBox> = Vec::new();
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
            let touch = |a: &ParameterBox, b: &ParameterBox| {
                (0..2).all(|k| a[k][0] <= b[k][1] && b[k][0] <= a[k][1])
            };
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
            let of = |cell: &ParameterBox| cells.iter().position(|c| c == cell).unwrap();
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
}
