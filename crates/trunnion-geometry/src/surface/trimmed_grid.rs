//! Parts of the cells of a grid in u, v that lie inside the trims of a face.

use super::face::Face;
use crate::types::Interval;
use std::collections::BTreeMap;

/// Coordinates nearer than this share of a cell are one: far above rounding, far below a chord.
const SAME: f64 = 1e-9;

/// Column and row of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct GridCell {
    pub(super) column: usize,
    pub(super) row: usize,
}

/// A grid over the bounds of a face with the chords of its trims.
pub(super) struct TrimmedGrid<'a> {
    face: &'a Face,
    /// Lines of the grid by u and by v, rising.
    lines: [Vec<f64>; 2],
    chords: Vec<Chord>,
    /// Chords that meet a cell, by index.
    met: BTreeMap<GridCell, Vec<usize>>,
}

/// A chord of a trim, from its lower to its higher u.
#[derive(Debug, Clone, Copy)]
struct Chord {
    from: [f64; 2],
    to: [f64; 2],
}

impl Chord {
    fn new(a: [f64; 2], b: [f64; 2]) -> Self {
        if a[0] <= b[0] { Self { from: a, to: b } } else { Self { from: b, to: a } }
    }

    /// Returns its v at a value of u; beyond an end, that of the end. The ends themselves are exact.
    fn v_at(&self, u: f64) -> f64 {
        let ([u0, v0], [u1, v1]) = (self.from, self.to);
        if u <= u0 {
            v0
        } else if u >= u1 {
            v1
        } else {
            v0 + (v1 - v0) * (u - u0) / (u1 - u0)
        }
    }

    /// Returns its u at a value of v between those of its ends.
    fn u_at(&self, v: f64) -> Option<f64> {
        let ([u0, v0], [u1, v1]) = (self.from, self.to);
        let between = (v0 < v && v < v1) || (v1 < v && v < v0);
        between.then(|| u0 + (u1 - u0) * (v - v0) / (v1 - v0))
    }

    /// Returns the v it takes between two values of u.
    fn v_within(&self, u: Interval) -> Interval {
        let [a, b] = [self.v_at(u.low), self.v_at(u.high)];
        Interval::new(a.min(b), a.max(b))
    }
}

impl<'a> TrimmedGrid<'a> {
    /// Lays lines over the bounds of a face, and chords within `tolerance` (by u and by v) along its trims.
    pub(super) fn new(face: &'a Face, cells: [u32; 2], tolerance: [f64; 2]) -> Self {
        let bounds = face.bounds();
        let lines = [0, 1].map(|k| lines_of(bounds[k], cells[k]));
        let mut grid = Self { face, lines, chords: Vec::new(), met: BTreeMap::new() };
        let periods = face.surface.periods();
        for trim in &face.loops {
            let points = trim.polyline(tolerance);
            // The bounds are at most a period wide and lie round the loops: one turn either way reaches all of them.
            for shift in turns(periods) {
                let moved = |[u, v]: [f64; 2]| [u + shift[0], v + shift[1]];
                for pair in points.windows(2) {
                    grid.add(Chord::new(moved(pair[0]), moved(pair[1])));
                }
            }
        }
        grid
    }

    /// Returns all cells.
    pub(super) fn cells(&self) -> impl Iterator<Item = GridCell> + use<> {
        let [columns, rows] = [0, 1].map(|k| self.lines[k].len() - 1);
        (0..columns).flat_map(move |column| (0..rows).map(move |row| GridCell { column, row }))
    }

    /// Returns `true` if a value of v is a line of the grid.
    pub(super) fn is_row_line(&self, v: f64) -> bool {
        self.lines[1].binary_search_by(|line| line.total_cmp(&v)).is_ok()
    }

    fn bounds_of(&self, cell: GridCell) -> [Interval; 2] {
        let along = |k: usize, n: usize| Interval::new(self.lines[k][n], self.lines[k][n + 1]);
        [along(0, cell.column), along(1, cell.row)]
    }

    /// Enters a chord into the cells it meets.
    fn add(&mut self, chord: Chord) {
        let index = self.chords.len();
        for column in meeting(&self.lines[0], Interval::new(chord.from[0], chord.to[0])) {
            let within = Interval::new(self.lines[0][column], self.lines[0][column + 1]);
            for row in meeting(&self.lines[1], chord.v_within(within)) {
                self.met.entry(GridCell { column, row }).or_default().push(index);
            }
        }
        self.chords.push(chord);
    }

    /// Returns the part of a cell inside the trims as convex polygons, counter-clockwise in u, v, each between two
    /// values of u.
    pub(super) fn parts(&self, cell: GridCell) -> Vec<Vec<[f64; 2]>> {
        let [u, v] = self.bounds_of(cell);
        let Some(met) = self.met.get(&cell) else {
            let whole = [[u.low, v.low], [u.high, v.low], [u.high, v.high], [u.low, v.high]];
            let inside = self.face.contains(u.middle(), v.middle());
            return if inside { vec![whole.to_vec()] } else { Vec::new() };
        };
        let chords: Vec<Chord> = met.iter().map(|&index| self.chords[index]).collect();
        let breaks = breaks(&chords, [u, v]);
        let slabs = breaks.windows(2).map(|pair| Interval::new(pair[0], pair[1]));
        slabs.flat_map(|slab| self.slab(&chords, slab, v)).collect()
    }

    /// Returns the parts of a slab of a cell. No chord ends or crosses a row line within it, so chords divide it from
    /// side to side.
    fn slab(&self, chords: &[Chord], slab: Interval, v: Interval) -> Vec<Vec<[f64; 2]>> {
        let middle = slab.middle();
        let snapped = |chord: &Chord, u: f64| snap(chord.v_at(u), v);
        let mut sides = vec![[v.low; 2], [v.high; 2]];
        for chord in chords {
            let at_middle = chord.v_at(middle);
            if chord.from[0] < middle && middle < chord.to[0] && v.contains(at_middle) {
                sides.push([snapped(chord, slab.low), snapped(chord, slab.high)]);
            }
        }
        sides.sort_by(|a, b| (a[0] + a[1]).total_cmp(&(b[0] + b[1])));
        let mut parts = Vec::new();
        for pair in sides.windows(2) {
            let ([a, b], [c, d]) = (pair[0], pair[1]);
            let height = 0.5 * (c + d - a - b);
            // The middle decides: chords and trims differ by less than a part is high, or it is a sliver.
            if height <= SAME * v.width() || !self.face.contains(middle, 0.25 * (a + b + c + d)) {
                continue;
            }
            let mut part = vec![[slab.low, a], [slab.high, b], [slab.high, d], [slab.low, c]];
            part.dedup();
            if part.first() == part.last() {
                part.pop();
            }
            parts.push(part);
        }
        parts
    }
}

/// Returns the values of u between which no chord begins, ends or crosses the rows' lines in a cell.
fn breaks(chords: &[Chord], [u, v]: [Interval; 2]) -> Vec<f64> {
    let mut breaks = vec![u.low, u.high];
    for chord in chords {
        breaks.extend([chord.from[0], chord.to[0]]);
        breaks.extend([v.low, v.high].into_iter().filter_map(|line| chord.u_at(line)));
    }
    breaks.retain(|&at| u.contains(at));
    breaks.sort_by(f64::total_cmp);
    let near = SAME * u.width();
    breaks.dedup_by(|later, kept| *later - *kept <= near);
    // The last line itself ends the cell: its neighbour begins there.
    if let Some(last) = breaks.last_mut().filter(|last| u.high - **last <= near) {
        *last = u.high;
    }
    breaks
}

/// Returns a value within a range, at its ends where it is near them.
fn snap(x: f64, within: Interval) -> f64 {
    let near = SAME * within.width();
    if x - within.low <= near {
        within.low
    } else if within.high - x <= near {
        within.high
    } else {
        x
    }
}

/// Returns the lines between which a range is divided into equal cells.
fn lines_of(range: Interval, cells: u32) -> Vec<f64> {
    let step = (range.high - range.low) / f64::from(cells);
    let mut lines: Vec<f64> = (0..cells).map(|n| range.low + step * f64::from(n)).collect();
    // The last line is the bound itself: a sum could be rounded to beyond the trims.
    lines.push(range.high);
    lines
}

/// Returns the spaces between lines that a range meets.
fn meeting(lines: &[f64], range: Interval) -> std::ops::Range<usize> {
    let spaces = lines.len() - 1;
    let first = lines.partition_point(|&line| line < range.low).saturating_sub(1);
    let end = lines.partition_point(|&line| line <= range.high).min(spaces);
    first..end.max(first)
}

/// Returns the steps by at most one period either way.
fn turns(periods: [Option<f64>; 2]) -> Vec<[f64; 2]> {
    let along = |period: Option<f64>| match period {
        Some(period) => vec![-period, 0.0, period],
        None => vec![0.0],
    };
    let [us, vs] = periods.map(along);
    us.iter().flat_map(|&u| vs.iter().map(move |&v| [u, v])).collect()
}
