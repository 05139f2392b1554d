//! Passes over a small face, with the proof that they finish it and gouge nowhere.
//!
//! The face is the 36 x 30 mm patch of `tests/cover.rs`, hollow across and waved along.

#![expect(clippy::unwrap_used, reason = "a bench stops on surprise")]

use divan::{Bencher, black_box};
use nalgebra::Point3;
use trunnion::cover::{Along, CoverOptions, Direction, Method, cover};
use trunnion::cutter::{Construction, Cutter, CutterSpec, Kind};
use trunnion::positioning::{Band, ContactSide};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
use trunnion::types::Silent;

fn main() {
    divan::main();
}

fn face() -> FaceIndex {
    let heights = [
        [0.0, -1.5, -1.0, 0.5],
        [-1.0, -2.5, -2.0, -0.5],
        [-1.2, -2.0, -2.2, -0.8],
        [0.4, -1.0, -1.4, 0.2],
    ];
    let points = (0..4)
        .map(|i| {
            (0..4).map(|j| Point3::new(12.0 * i as f64, 10.0 * j as f64, heights[i][j])).collect()
        })
        .collect();
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([3, 3], [knots(), knots()], points, None).unwrap();
    FaceIndex::new(Face::new(1, Surface::Nurbs(surface), Vec::new(), false).unwrap()).unwrap()
}

/// Budget: seconds a face, so that a user waits for the machine and not for the planner.
#[divan::bench(args = [Method::Widest, Method::Inclined], sample_count = 5)]
fn small_face(bencher: Bencher<'_, '_>, method: Method) {
    let cutter = Cutter::new(CutterSpec {
        kind: Kind::Bull,
        major: 4.0,
        minor: 3.0,
        length: 60.0,
        construction: Construction::Solid,
        shank: Vec::new(),
    })
    .unwrap();
    let options = CoverOptions {
        along: Along::V,
        direction: Direction::ZigZag,
        method,
        side: ContactSide::Ahead,
        band: Band { lower: 0.0, upper: 0.02 },
        link: 80.0,
        path_share: 0.002,
        spacing: [0.021, 0.875],
        max_axis_turn: 0.05,
        offset_range: [-0.5, 0.5],
        lead: 0.087,
        effort: 3.0,
        ahead: 1,
    };
    let faces = [face()];
    bencher.bench(|| cover(black_box(&faces), &cutter, &options, &Silent).unwrap().report.length);
}
