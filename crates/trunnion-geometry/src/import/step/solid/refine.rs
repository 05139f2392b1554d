//! Triangles parted inside a face until they are close to its surface.
//!
//! Only sides within the face are parted, in their middle, so that its border stays as its
//! neighbours have it. After each, sides are turned over where that makes triangles rounder
//! (Lawson's flips), in a plane in which a length is what a chord of it would be off.

use super::super::chart::SurfaceChart;
use super::corner::{MeshCorner, PointTriangle};
use super::ears::{PlanarTriangles, turn};
use super::ring::off;
use super::unroll::LoopPolygon;
use crate::math;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Triangles of one face at most.
const MOST: usize = 2_000_000;
/// Sides shorter than this, in chords, are not parted: bends are sampled, and may be sharper
/// between.
const SHORTEST: f64 = 0.1;
/// Triangles less high than this, in chords, are not parted.
const THINNEST: f64 = 0.05;
/// Samples by either parameter from which the scale is taken.
const PROBES: u32 = 8;
/// Share of a straight direction's length that counts as bent: it keeps triangles from becoming
/// needles.
const STRAIGHT: f64 = 0.05;
/// Flips after one parting at most: far more than there ever are, so that rounding cannot turn in
/// circles.
const FLIPS: u32 = 10_000;

/// Returns lengths by u and v in tolerances: the number of chords that a unit of each would take.
pub(super) fn scale(chart: &SurfaceChart<'_>, polygons: &[LoopPolygon], chord: f64) -> [f64; 2] {
    let corners = || polygons.iter().flat_map(|polygon| &polygon.outer);
    let ends = |k: usize| {
        corners().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], corner| {
            [low.min(corner.uv[k]), high.max(corner.uv[k])]
        })
    };
    let ranges = [ends(0), ends(1)];
    let (mut bend, mut speed) = ([0.0f64; 2], [0.0f64; 2]);
    for (i, j) in (0..=PROBES).flat_map(|i| (0..=PROBES).map(move |j| (i, j))) {
        let at =
            |k: u32, [low, high]: [f64; 2]| low + (high - low) * f64::from(k) / f64::from(PROBES);
        let [u, v] = chart.wrapped([at(i, ranges[0]), at(j, ranges[1])]);
        let jet = chart.surface.jet2(u, v);
        speed = [speed[0].max(jet.su.norm()), speed[1].max(jet.sv.norm())];
        let Some(n) = jet.normal() else { continue };
        bend = [bend[0].max(jet.suu.dot(&n).abs()), bend[1].max(jet.svv.dot(&n).abs())];
    }
    // The longer side of the face, so that it has about twenty straight lengths.
    let long = (0..2).map(|k| speed[k] * (ranges[k][1] - ranges[k][0])).fold(0.0, f64::max);
    [0, 1].map(|k| {
        let straight = speed[k] / (STRAIGHT * long).max(chord);
        // A chord over du sags by |S_uu| du^2 / 8: sqrt(|S_uu| / (8 chord)) chords a unit of u.
        let scale = (bend[k] / (8.0 * chord)).sqrt() + straight;
        if scale > 0.0 && scale.is_finite() { scale } else { 1.0 }
    })
}

/// Divides the triangles of a face until they are within about `chord` \[mm\] of its surface.
pub(super) fn refine(
    chart: &SurfaceChart<'_>,
    plain: PlanarTriangles,
    chord: f64,
) -> Vec<PointTriangle> {
    let PlanarTriangles { corners, flat, triangles, scale } = plain;
    let mut mesh = RefinedMesh {
        chart,
        chord,
        corners,
        flat,
        scale,
        triangles: Vec::new(),
        sides: BTreeMap::new(),
    };
    for triangle in triangles {
        mesh.add(triangle);
    }
    let all: Vec<TriangleSide> = mesh.sides.keys().copied().collect();
    mesh.flip(all);
    mesh.part();
    let point = |k: usize| mesh.corners[k].point;
    mesh.triangles.iter().flatten().map(|triangle| triangle.map(point)).collect()
}

/// Triangles under work.
struct RefinedMesh<'a> {
    chart: &'a SurfaceChart<'a>,
    chord: f64,
    corners: Vec<MeshCorner>,
    flat: Vec<[f64; 2]>,
    scale: [f64; 2],
    /// `None` where one was replaced.
    triangles: Vec<Option<[usize; 3]>>,
    /// The triangle on the left of each side.
    sides: BTreeMap<TriangleSide, usize>,
}

/// A directed side between two corners, with a triangle on its left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct TriangleSide {
    from: usize,
    to: usize,
}

impl TriangleSide {
    fn new(from: usize, to: usize) -> Self {
        Self { from, to }
    }

    /// Returns the same side run the other way: that of the neighbour.
    fn opposite(self) -> Self {
        Self { from: self.to, to: self.from }
    }

    fn of_triangle([a, b, c]: [usize; 3]) -> [Self; 3] {
        [Self::new(a, b), Self::new(b, c), Self::new(c, a)]
    }
}

impl RefinedMesh<'_> {
    fn add(&mut self, triangle: [usize; 3]) {
        for side in TriangleSide::of_triangle(triangle) {
            self.sides.insert(side, self.triangles.len());
        }
        self.triangles.push(Some(triangle));
    }

    fn take(&mut self, side: TriangleSide) -> Option<[usize; 3]> {
        let at = *self.sides.get(&side)?;
        let triangle = self.triangles.get_mut(at)?.take()?;
        for side in TriangleSide::of_triangle(triangle) {
            self.sides.remove(&side);
        }
        Some(triangle)
    }

    /// Returns the corner opposite a side of the triangle on its left.
    fn opposite(&self, side: TriangleSide) -> Option<usize> {
        let triangle = (*self.triangles.get(*self.sides.get(&side)?)?)?;
        triangle.into_iter().find(|&k| k != side.from && k != side.to)
    }

    /// Turns over sides while that makes triangles rounder.
    fn flip(&mut self, mut open: Vec<TriangleSide>) {
        let mut left = FLIPS.max(u32::try_from(8 * open.len()).unwrap_or(u32::MAX));
        while let Some(side) = open.pop() {
            let [Some(c), Some(d)] = [side, side.opposite()].map(|side| self.opposite(side)) else {
                continue;
            };
            let TriangleSide { from: a, to: b } = side;
            let [pa, pb, pc, pd] = [a, b, c, d].map(|k| self.flat[k]);
            // Delaunay criterion (Lawson): the other tip inside the circle makes this the wrong
            // diagonal.
            if c == d || !in_circle([pa, pb, pc], pd) || !is_convex([pa, pd, pb, pc]) {
                continue;
            }
            // Another side may be there already, where corners are used twice.
            let turned = TriangleSide::new(c, d);
            let is_there = |side: TriangleSide| self.sides.contains_key(&side);
            if is_there(turned) || is_there(turned.opposite()) || left == 0 {
                continue;
            }
            left -= 1;
            self.take(side);
            self.take(side.opposite());
            self.add([c, a, d]);
            self.add([d, b, c]);
            open.extend([
                TriangleSide::new(a, d),
                TriangleSide::new(d, b),
                TriangleSide::new(b, c),
                TriangleSide::new(c, a),
            ]);
        }
    }

    /// Parts sides until these and the triangles between them are close to the surface.
    fn part(&mut self) {
        let mut at = 0;
        while at < self.triangles.len() && self.triangles.len() < MOST {
            let Some(triangle) = self.triangles[at] else {
                at += 1;
                continue;
            };
            match self.worst(triangle) {
                Some(side) => self.halve(side),
                None => at += 1,
            }
        }
    }

    /// Returns the side of a triangle to be parted: the one that is farthest off the surface, or
    /// the longest if only the middle of the triangle is off.
    fn worst(&self, triangle: [usize; 3]) -> Option<TriangleSide> {
        let length = |side: &TriangleSide| {
            let [p, q] = [side.from, side.to].map(|k| self.flat[k]);
            math::hypot(p[0] - q[0], p[1] - q[1])
        };
        // Beside a border that is not quite on the surface there is no end to parting.
        let sides = TriangleSide::of_triangle(triangle);
        let longest = sides.iter().map(length).fold(0.0, f64::max);
        if turn(triangle.map(|k| self.flat[k])) < THINNEST * longest {
            return None;
        }
        let inner = |side: &TriangleSide| {
            self.sides.contains_key(&side.opposite()) && length(side) > SHORTEST
        };
        let sides = sides.into_iter().filter(inner);
        let gap = |side: &TriangleSide| {
            let ends = [side.from, side.to].map(|k| self.corners[k]);
            let at = |share: f64| {
                let [p, q] = ends.map(|end| end.uv);
                self.chart.point([0, 1].map(|k| p[k] + (q[k] - p[k]) * share))
            };
            let gaps =
                [0.25, 0.5, 0.75].map(|share| off(&at(share), [&ends[0].point, &ends[1].point]));
            gaps.into_iter().fold(0.0, f64::max)
        };
        let worst = sides.clone().map(|side| (gap(&side), side)).max_by(|a, b| a.0.total_cmp(&b.0));
        // Half the tolerance for sides: between two sides that use it up the middle is off by more.
        let worst = worst.filter(|(gap, _)| *gap > 0.5 * self.chord);
        if worst.is_some() {
            return worst.map(|(_, side)| side);
        }
        let [p, q, r] = triangle.map(|k| self.corners[k].point);
        let normal: Vector3<f64> = (q - p).cross(&(r - p)).try_normalize(0.0)?;
        // Of the middle only the height over the triangle counts, not a shift within it.
        let gap = normal.dot(&(self.chart.point(self.middle(&triangle)) - p)).abs();
        if gap <= 0.75 * self.chord {
            return None;
        }
        sides.max_by(|a, b| length(a).total_cmp(&length(b)))
    }

    fn middle(&self, of: &[usize]) -> [f64; 2] {
        [0, 1].map(|k| of.iter().map(|&c| self.corners[c].uv[k]).sum::<f64>() / of.len() as f64)
    }

    fn halve(&mut self, side: TriangleSide) {
        let uv = self.middle(&[side.from, side.to]);
        let new = self.corners.len();
        self.corners.push(MeshCorner { uv, point: self.chart.point(uv) });
        self.flat.push([0, 1].map(|k| uv[k] * self.scale[k]));
        let mut around = Vec::new();
        // Two triangles share a side; at a border there is only one.
        for side in [side, side.opposite()] {
            let Some(tip) = self.opposite(side) else { continue };
            let TriangleSide { from, to } = side;
            self.take(side);
            self.add([from, new, tip]);
            self.add([new, to, tip]);
            around.extend([TriangleSide::new(to, tip), TriangleSide::new(tip, from)]);
        }
        self.flip(around);
    }
}

/// Returns `true` if a point is well inside the circle through three others, counter-clockwise.
fn in_circle(corners: [[f64; 2]; 3], p: [f64; 2]) -> bool {
    let [a, b, c] = corners.map(|q| [q[0] - p[0], q[1] - p[1]]);
    let square = |q: [f64; 2]| q[0] * q[0] + q[1] * q[1];
    let [x, y, z] = [a, b, c].map(square);
    // In-circle determinant with rows (x, y, x^2 + y^2), p at the origin.
    let minor = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let det = x * minor(b, c) - y * minor(a, c) + z * minor(a, b);
    // Rounding of the products does not count.
    let size = (x + y + z).powi(2);
    det > 1e-12 * size
}

/// Returns `true` if a quadrilateral turns left at all its corners.
fn is_convex([a, b, c, d]: [[f64; 2]; 4]) -> bool {
    let square = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
    let least = 1e-10 * (square(a, c) + square(b, d));
    [[a, b, c], [b, c, d], [c, d, a], [d, a, b]].into_iter().all(|three| turn(three) > least)
}
