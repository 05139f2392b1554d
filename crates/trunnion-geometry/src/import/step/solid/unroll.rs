//! Faces as plain polygons of their parameters: what runs round a period is cut open along a seam.

use super::super::chart::{ChartPole, SurfaceChart};
use super::corner::MeshCorner;
use super::ring::{BoundaryRing, CHORDS, is_chord};
use crate::types::Interval;

/// The outside of a polygon, counter-clockwise, and its holes, clockwise; corners on a seam are
/// there twice.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LoopPolygon {
    pub(super) outer: Vec<MeshCorner>,
    pub(super) holes: Vec<Vec<MeshCorner>>,
}

/// Halvings of a seam.
const HALVINGS: u32 = 10;
/// Pieces of a seam at least: its middle may lie on its chord by chance.
const PIECES: u32 = 4;

/// Returns the polygons of a face, whatever its loops run round; none if its loops enclose nothing.
pub(super) fn polygons(
    chart: &SurfaceChart<'_>,
    rings: Vec<BoundaryRing>,
    chord: f64,
) -> Vec<LoopPolygon> {
    let seams = FaceSeams { chart, chord };
    let runs_round = |ring: &BoundaryRing| ring.advance.iter().any(|by| by.abs() > 0.0);
    let (mut round, plain): (Vec<BoundaryRing>, Vec<BoundaryRing>) =
        rings.into_iter().partition(runs_round);
    let mut outer: Vec<Vec<MeshCorner>> = Vec::new();
    // Loops that run round are cut open in pairs, or up to a pole.
    while let Some(first) = round.pop() {
        let mate = round.iter().position(|other| opposed(&first, other));
        let mate = mate.map(|mate| round.swap_remove(mate));
        outer.extend(match mate {
            Some(mate) => Some(seams.between(first, mate)),
            None => seams.up_to_pole(first),
        });
    }
    if outer.is_empty() && plain.is_empty() {
        outer.extend(seams.whole());
    }
    let polygon = |outer| LoopPolygon { outer: counter_clockwise(outer), holes: Vec::new() };
    let mut polygons: Vec<LoopPolygon> = outer.into_iter().map(polygon).collect();
    // What an odd number of loops encloses is the face: the largest first, what is within one is a
    // hole of it.
    let mut plain: Vec<Vec<MeshCorner>> = plain.into_iter().map(|ring| ring.corners).collect();
    plain.sort_by(|a, b| area(b).abs().total_cmp(&area(a).abs()));
    for ring in plain {
        let mut around = polygons.iter_mut();
        let holder = around.find_map(|polygon| {
            let placed = within(chart, &ring, &polygon.outer)?;
            // A loop within a hole is an island of its own.
            let free = polygon.holes.iter().all(|hole| within(chart, &ring, hole).is_none());
            free.then_some((placed, polygon))
        });
        match holder {
            Some((placed, polygon)) => polygon.holes.push(clockwise(placed)),
            None => polygons.push(polygon(ring)),
        }
    }
    polygons
}

fn opposed(a: &BoundaryRing, b: &BoundaryRing) -> bool {
    (0..2).all(|k| (a.advance[k] + b.advance[k]).abs() <= 1e-9 * a.advance[k].abs())
}

/// Returns twice the area of a polygon of parameters.
fn area(corners: &[MeshCorner]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a.uv[0] * b.uv[1] - a.uv[1] * b.uv[0]).sum()
}

/// Returns the polygon run counter-clockwise.
fn counter_clockwise(mut corners: Vec<MeshCorner>) -> Vec<MeshCorner> {
    if area(&corners) > 0.0 {
        return corners;
    }
    corners.reverse();
    corners
}

/// Returns the polygon run clockwise.
fn clockwise(mut corners: Vec<MeshCorner>) -> Vec<MeshCorner> {
    if area(&corners) > 0.0 {
        corners.reverse();
    }
    corners
}

fn moved(corners: &[MeshCorner], by: [f64; 2]) -> Vec<MeshCorner> {
    let shift = |corner: &MeshCorner| {
        let uv = [corner.uv[0] + by[0], corner.uv[1] + by[1]];
        MeshCorner { uv, ..*corner }
    };
    corners.iter().map(shift).collect()
}

/// Moves a hole to the turn on which it lies in a polygon.
fn within(
    chart: &SurfaceChart<'_>,
    hole: &[MeshCorner],
    outer: &[MeshCorner],
) -> Option<Vec<MeshCorner>> {
    let turns = |k: usize| -> Vec<f64> {
        chart.periods[k].map_or(vec![0.0], |period| {
            [0.0, 1.0, -1.0, 2.0, -2.0].iter().map(|turn| turn * period).collect()
        })
    };
    let first = hole.first()?.uv;
    let shifts = turns(0).into_iter().flat_map(|u| turns(1).into_iter().map(move |v| [u, v]));
    let mut inside = shifts.filter(|by| holds(outer, [first[0] + by[0], first[1] + by[1]]));
    inside.next().map(|by| moved(hole, by))
}

fn holds(outer: &[MeshCorner], [u, v]: [f64; 2]) -> bool {
    let next = outer.iter().cycle().skip(1);
    let crosses = |(a, b): &(&MeshCorner, &MeshCorner)| {
        let ([ua, va], [ub, vb]) = (a.uv, b.uv);
        // Crossing of the side with the ray from the point towards +u, half-open in v.
        (va > v) != (vb > v) && u < ua + (ub - ua) * (v - va) / (vb - va)
    };
    outer.iter().zip(next).filter(crosses).count() % 2 == 1
}

struct FaceSeams<'a> {
    chart: &'a SurfaceChart<'a>,
    chord: f64,
}

impl FaceSeams<'_> {
    /// Returns corners between two, along a straight line of parameters.
    fn seam(&self, from: &MeshCorner, to: &MeshCorner) -> Vec<MeshCorner> {
        let at = |t: f64| {
            let uv = [0, 1].map(|k| from.uv[k] + (to.uv[k] - from.uv[k]) * t);
            MeshCorner { uv, point: self.chart.point(uv) }
        };
        let mut corners = Vec::new();
        for k in 0..PIECES {
            let ends = [k, k + 1].map(|k| f64::from(k) / f64::from(PIECES));
            if k > 0 {
                corners.push(at(ends[0]));
            }
            self.halve(&at, ends, HALVINGS, &mut corners);
        }
        corners
    }

    /// Adds the corners between two shares of a seam.
    fn halve(
        &self,
        at: &dyn Fn(f64) -> MeshCorner,
        [a, b]: [f64; 2],
        left: u32,
        out: &mut Vec<MeshCorner>,
    ) {
        let place = |share: f64| at(a + share * (b - a)).point;
        if left == 0 || is_chord(&place, [&place(0.0), &place(1.0)], CHORDS * self.chord) {
            return;
        }
        let middle = 0.5 * (a + b);
        self.halve(at, [a, middle], left - 1, out);
        out.push(at(middle));
        self.halve(at, [middle, b], left - 1, out);
    }

    /// Cuts open the band between two loops that run round in opposite directions.
    fn between(&self, first: BoundaryRing, mate: BoundaryRing) -> Vec<MeshCorner> {
        let by = first.advance;
        let k = usize::from(by[1].abs() > by[0].abs());
        // From the first corner of one to the corner of the other that is nearest, whichever turn
        // it is on.
        let Some(&start) = first.corners.first() else { return Vec::new() };
        let away = |corner: &MeshCorner| (corner.point - start.point).norm();
        let nearest = (0..mate.corners.len())
            .min_by(|&a, &b| away(&mate.corners[a]).total_cmp(&away(&mate.corners[b])));
        let mut other = mate.corners;
        let at = nearest.unwrap_or(0);
        // What was before it comes a turn later.
        let late = moved(&other[..at], mate.advance);
        other.drain(..at);
        other.extend(late);
        let end = MeshCorner { uv: [start.uv[0] + by[0], start.uv[1] + by[1]], ..start };
        // The other loop on the turn on which its first corner faces the end of this one.
        let turn = other.first().map_or(0.0, |corner| ((end.uv[k] - corner.uv[k]) / by[k]).round());
        let other = moved(&other, by.map(|by| by * turn));
        let Some(&landing) = other.first() else { return Vec::new() };
        // Along the first loop, over the seam, back along the other, and over the seam a period
        // earlier.
        let seam = self.seam(&end, &landing);
        let back = MeshCorner { uv: [0, 1].map(|k| landing.uv[k] - by[k]), ..landing };
        let mut polygon = first.corners;
        polygon.push(end);
        polygon.extend(&seam);
        polygon.extend(other);
        polygon.push(back);
        polygon.extend(moved(&seam, by.map(|by| -by)).into_iter().rev());
        polygon
    }

    /// Cuts open the cap between a loop that runs round and the pole on its left.
    fn up_to_pole(&self, ring: BoundaryRing) -> Option<Vec<MeshCorner>> {
        let by = ring.advance;
        let k = usize::from(by[1].abs() > by[0].abs());
        let start = *ring.corners.first()?;
        // Left of a loop towards +u is +v, left of one towards +v is -u.
        let high = (by[k] > 0.0) == (k == 0);
        let beyond = |pole: &&ChartPole| pole.fixed == 1 - k && (pole.at > start.uv[1 - k]) == high;
        let pole = self.chart.poles.iter().find(beyond)?;
        let end = MeshCorner { uv: [start.uv[0] + by[0], start.uv[1] + by[1]], ..start };
        let top = |corner: &MeshCorner| {
            let mut uv = corner.uv;
            uv[pole.fixed] = pole.at;
            MeshCorner { uv, point: pole.point }
        };
        // Along the loop, up the seam, along the pole, and down the seam a period earlier.
        let seam = self.seam(&end, &top(&end));
        let mut polygon = ring.corners;
        polygon.push(end);
        polygon.extend(&seam);
        polygon.extend([top(&end), top(&start)]);
        polygon.extend(moved(&seam, by.map(|by| -by)).into_iter().rev());
        Some(polygon)
    }

    /// Returns the outline of a surface without a loop: its whole domain.
    fn whole(&self) -> Option<Vec<MeshCorner>> {
        let [Interval { low: u0, high: u1 }, Interval { low: v0, high: v1 }] =
            self.chart.surface.domain();
        if ![u0, u1, v0, v1].iter().all(|x| x.is_finite()) {
            return None;
        }
        let pole = |fixed: usize, at: f64| {
            let same = |pole: &&ChartPole| pole.fixed == fixed && (pole.at - at).abs() < 1e-9;
            self.chart.poles.iter().find(same).map(|pole| pole.point)
        };
        let corner = |u: f64, v: f64| {
            let on = pole(1, v).or_else(|| pole(0, u));
            MeshCorner { uv: [u, v], point: on.unwrap_or_else(|| self.chart.point([u, v])) }
        };
        // Points of opposite sides are the same where the surface closes.
        let closes = self.chart.periods.map(|period| period.is_some());
        let [a, mut b, mut c, mut d] =
            [corner(u0, v0), corner(u1, v0), corner(u1, v1), corner(u0, v1)];
        if closes[0] {
            (b.point, c.point) = (a.point, d.point);
        }
        if closes[1] {
            (d.point, c.point) = (a.point, b.point);
        }
        let side = |from: &MeshCorner, to: &MeshCorner, on_pole: bool| {
            if on_pole { Vec::new() } else { self.seam(from, to) }
        };
        let low = side(&a, &b, pole(1, v0).is_some());
        let left = side(&a, &d, pole(0, u0).is_some());
        let high = if closes[1] {
            moved(&low, [0.0, v1 - v0])
        } else {
            side(&d, &c, pole(1, v1).is_some())
        };
        let right = if closes[0] {
            moved(&left, [u1 - u0, 0.0])
        } else {
            side(&b, &c, pole(0, u1).is_some())
        };
        let mut polygon = vec![a];
        polygon.extend(low);
        polygon.push(b);
        polygon.extend(right);
        polygon.push(c);
        polygon.extend(high.into_iter().rev());
        polygon.push(d);
        polygon.extend(left.into_iter().rev());
        Some(polygon)
    }
}
