//! Spots of a region that is left, and chains of them.

use crate::cover::layout::region::ChartPoint;
use crate::cover::place::context::FaceContext;
use crate::cover::prove::coverage::CoverageProof;
use crate::cover::prove::face_cell::FaceCell;
use crate::surface::Face;
use crate::types::{Interval, UncutRegion};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Distance of the spots that are touched, in widths of a narrow strip.
pub(crate) const SPACING: f64 = 0.7;

/// Distance over which a pass goes on to the next spot, over that of the spots.
const JOINED: f64 = 2.0;

/// Cost of a step across the long direction of a region, over one along it: passes run along.
const ACROSS: f64 = 3.0;

/// Distance around a cube up to which poses count for the heights in it, as a share of the cutter's radius.
const MARGIN: f64 = 0.125;

/// Parts into which a cell is divided each way, at most.
const PARTS: f64 = 64.0;

/// Spot that is left, as a point of the face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) uv: [f64; 2],
    pub(crate) point: Point3<f64>,
}

/// Spots by the cube of [`SPACING`] that they lie in.
pub(crate) type SpotCubes = BTreeMap<[i64; 3], Vec<Spot>>;

/// Divides a cell to parts of about a size \[mm\].
pub(crate) fn small_cells(face: &Face, [u, v]: [Interval; 2], size: f64) -> Vec<[Interval; 2]> {
    // Step 1: the longest of three lines each way, by halves: an end may be a pole, and a line round the face ends as it begins.
    let length = |ends: [Point3<f64>; 3]| (ends[1] - ends[0]).norm() + (ends[2] - ends[1]).norm();
    let three = |range: Interval| [range.low, range.middle(), range.high];
    let across = three(v).map(|v| length(three(u).map(|u| face.point(u, v))));
    let along = three(u).map(|u| length(three(v).map(|v| face.point(u, v))));
    // Step 2: as many parts as that needs.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let [us, vs] = [across, along].map(|lengths| {
        let longest = lengths.into_iter().fold(0.0, f64::max);
        (longest / size).ceil().clamp(1.0, PARTS) as u32
    });
    let part = |range: Interval, i: u32, count: u32| {
        let [low, high] = [i, i + 1].map(|i| range.at(f64::from(i) / f64::from(count)));
        Interval::new(low, high)
    };
    let of_row = move |i: u32| (0..vs).map(move |j| [part(u, i, us), part(v, j, vs)]);
    (0..us).flat_map(of_row).collect()
}

/// Area of a region in one cube.
pub(crate) struct SpotArea {
    /// Middles of the first, the largest and the last of its cells.
    pub(crate) points: [[f64; 2]; 3],
    /// \[mm²\]
    pub(crate) area: f64,
    largest: f64,
}

impl SpotArea {
    fn new(uv: [f64; 2]) -> Self {
        Self { points: [uv; 3], area: 0.0, largest: 0.0 }
    }

    fn add(&mut self, uv: [f64; 2], area: f64) {
        self.area += area;
        if area > self.largest {
            (self.points[1], self.largest) = (uv, area);
        }
        self.points[2] = uv;
    }
}

/// Distributes the area of a region to cubes of [`SPACING`].
pub(crate) fn spot_areas<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    part: &UncutRegion,
) -> Vec<SpotArea> {
    let face = context.face.face();
    let spacing = SPACING * context.narrow();
    let mut cubes: BTreeMap<[i64; 3], SpotArea> = BTreeMap::new();
    for cell in part.cells.iter().flat_map(|cell| small_cells(face, *cell, spacing)) {
        let uv = cell.map(|range| range.middle());
        let cube = cube_of(&face.point(uv[0], uv[1]), spacing);
        let cell = FaceCell::new(cell.map(Interval::ends), &|[u, v]: [f64; 2]| face.point(u, v));
        cubes.entry(cube).or_insert_with(|| SpotArea::new(uv)).add(uv, cell.area());
    }
    cubes.into_values().collect()
}

/// Returns the cube of a spacing \[mm\] that a point lies in.
fn cube_of(point: &Point3<f64>, spacing: f64) -> [i64; 3] {
    // Positions over a fraction of a millimetre: far below 2^63.
    #[expect(clippy::cast_possible_truncation, reason = "see above")]
    [0, 1, 2].map(|k: usize| (point[k] / spacing).floor() as i64)
}

/// Distributes the spots of a region to cubes.
pub(crate) fn spot_cubes<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    part: &UncutRegion,
) -> SpotCubes {
    let face = context.face.face();
    let spacing = SPACING * context.narrow();
    let spot = |cell: &[Interval; 2]| {
        let [u, v] = cell.map(|range| range.middle());
        face.contains(u, v).then(|| Spot { uv: [u, v], point: face.point(u, v) })
    };
    let deepest = Spot { uv: part.deepest.into(), point: part.point };
    let mut cubes = SpotCubes::new();
    for spot in std::iter::once(deepest).chain(part.cells.iter().filter_map(spot)) {
        cubes.entry(cube_of(&spot.point, spacing)).or_default().push(spot);
    }
    cubes
}

/// Returns the spot of each cube where the region is deepest: in a corner a tool that touches a little beside it
/// leaves the corner itself.
pub(crate) fn deepest_spots<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    cubes: &SpotCubes,
    swept: &CoverageProof<'_, &Inside>,
) -> Vec<Spot> {
    let spacing = SPACING * context.narrow();
    let margin = MARGIN * context.setup.cutter.radius();
    let deepest = |(cube, spots): (&[i64; 3], &Vec<Spot>)| {
        let [first, rest @ ..] = spots.as_slice() else { return None };
        if rest.is_empty() {
            return Some(*first);
        }
        let centre = Point3::from(cube.map(|index| (index as f64 + 0.5) * spacing));
        let near = swept.poses_about(&centre, spacing + margin);
        // Where no pose is near all of them are as high as is known, and the middle one serves.
        let ranked = |spot: &Spot| {
            (swept.nearest(&spot.point, &near), -(spot.point - centre).norm_squared())
        };
        let ranks = spots.iter().map(|spot| (ranked(spot), spot));
        ranks
            .max_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)))
            .map(|best| *best.1)
    };
    let cubes: Vec<_> = cubes.iter().collect();
    cubes.into_par_iter().filter_map(deepest).collect()
}

/// Orders spots to chains, along the long direction of the region where that is possible.
pub(crate) fn chains(mut spots: Vec<Spot>, spacing: f64) -> Vec<Vec<Spot>> {
    let along = long_direction(&spots);
    let cost = |a: &Spot, b: &Spot| {
        let step = b.point - a.point;
        let ahead = along.dot(&step);
        ahead.abs() + ACROSS * (step - along * ahead).norm()
    };
    let mut chains: Vec<Vec<Spot>> = Vec::new();
    while !spots.is_empty() {
        // A chain begins at the end of the region.
        let least = |a: &Spot| along.dot(&a.point.coords);
        let first = index_of_least(&spots, least);
        let mut chain = vec![spots.swap_remove(first)];
        while let Some(last) = chain.last() {
            let near = |spot: &Spot| {
                let apart = (spot.point - last.point).norm();
                if apart <= JOINED * spacing { cost(last, spot) } else { f64::INFINITY }
            };
            let next = index_of_least(&spots, near);
            if !spots.get(next).is_some_and(|spot| near(spot).is_finite()) {
                break;
            }
            chain.push(spots.swap_remove(next));
        }
        chains.push(chain);
    }
    chains
}

fn index_of_least(spots: &[Spot], of: impl Fn(&Spot) -> f64) -> usize {
    let values = spots.iter().map(of).enumerate();
    values.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
}

/// Returns the direction in which points are spread most.
fn long_direction(spots: &[Spot]) -> Vector3<f64> {
    let count = spots.len().max(1) as f64;
    let mean = spots.iter().map(|spot| spot.point.coords).sum::<Vector3<f64>>() / count;
    let spread: Matrix3<f64> =
        spots.iter().map(|spot| spot.point.coords - mean).map(|off| off * off.transpose()).sum();
    let eigen = spread.symmetric_eigen();
    eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned()
}
