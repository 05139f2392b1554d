//! Deviation map of a curved 120 mm patch: 42 passes of 240 blocks with a bull nose, as a control
//! with TCP runs them. Aim: 0.2 mm grid (360 000 points) in 10 s on two cores.

#![expect(clippy::unwrap_used, reason = "a bench stops on surprise")]

#[path = "../tests/it/posted/mod.rs"]
mod posted;
#[path = "../tests/it/shop/mod.rs"]
mod shop;

use nalgebra::{Point3, Rotation3, Vector3};
use shop::Layout;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::inverse::Inverse;
use trunnion::machine::Kinematics;
use trunnion::nc::read::{self, ClFile, ClMotion, ClPath, ClRecord, Dialect, Program, ReadOptions};
use trunnion::nc::write::AxisWords;
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::{Block, Motion, Silent, ToolPose};
use trunnion::verify::{
    self, BoundMargins, BoundOptions, CheckInput, CheckOptions, ClearanceOptions,
    DeviationTolerance, Fixture, Solid, Stock,
};

fn main() {
    divan::main();
}

const MAJOR: f64 = 10.0;
const MINOR: f64 = 6.0;

fn face() -> Face {
    let row = |i: u8| {
        let point = |j: u8| {
            let [x, y] = [f64::from(i) - 1.0, f64::from(j) - 1.0];
            Point3::new(60.0 * x, 60.0 * y, 12.0 * x * x - 8.0 * y * y + 3.0 * x * y)
        };
        (0..3).map(point).collect()
    };
    let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let net = (0..3).map(row).collect();
    let surface = NurbsSurface::new([2, 2], [knots(), knots()], net, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

/// The tool touching the face at `(u, v)` with its rounding, leaning back along v.
fn pose(face: &Face, [u, v]: [f64; 2], lift: f64) -> ToolPose {
    let normal = face.normal(u, v).unwrap();
    let axis = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.25) * normal;
    let out = normal.dot(&axis) * axis.into_inner() - normal.into_inner();
    let tube = face.point(u, v) + normal.into_inner() * (MINOR + lift);
    ToolPose { tip: tube - out.normalize() * MAJOR - axis.into_inner() * MINOR, axis }
}

fn program(kinematics: &Kinematics, face: &Face) -> Program {
    let mut poses = vec![pose(face, [0.0, 0.0], 40.0)];
    for pass in 0..42 {
        for step in 0..=240 {
            let v = f64::from(step) / 240.0;
            let v = if pass % 2 == 0 { v } else { 1.0 - v };
            poses.push(pose(face, [f64::from(pass) / 41.0, v], 0.0));
        }
    }
    let inverse = Inverse::new(kinematics).unwrap();
    let mut q = kinematics.machine().home();
    let mut blocks: Vec<Block> = Vec::new();
    for pose in poses {
        q = inverse.near(&pose, &q).unwrap();
        blocks.push(Block { motion: Motion::Cut, q, pose, duration: 0.02 });
    }
    let axes = AxisWords::of(kinematics.machine()).unwrap().with_decimals(5, 5);
    let text = posted::plain(kinematics, &blocks, (axes, true));
    read::read(&text, &ReadOptions::new(Dialect::LinuxCnc, axes, 5)).unwrap()
}

/// 1 mm moves of a tilting bull nose through a block of 100 x 60 x 20 mm, 3 mm deep.
fn tilting(moves: u32) -> ClFile {
    let record = |k: u32| {
        let x = f64::from(k);
        let turn = Rotation3::from_euler_angles(0.1 * (0.05 * x).sin(), 0.15 + 0.0035 * x, 0.0);
        let tip = Point3::new(-30.0 + x, 4.0 * (0.1 * x).sin(), -3.0);
        let pose = ToolPose { tip, axis: turn * Vector3::z_axis() };
        ClRecord { line: k, pose, motion: ClMotion::Feed(10.0), way: ClPath::Straight }
    };
    ClFile { records: (0..=moves).map(record).collect(), ..ClFile::default() }
}

/// Rays 0.1 and 0.5 mm apart. Aim: 2000 and 10 000 moves/s on two cores; at least 300 and 3000.
#[divan::bench(args = [0.1, 0.5], sample_count = 3, sample_size = 1)]
fn stock(bencher: divan::Bencher<'_, '_>, cell: f64) {
    let spec = CutterSpec { length: 60.0, ..CutterSpec::bull(MAJOR, MINOR) };
    let (cutter, file) = (Cutter::new(spec).unwrap(), tilting(60));
    let [low, high] = [Point3::new(-50.0, -30.0, -20.0), Point3::new(50.0, 30.0, 0.0)];
    let block = Stock::new(&Solid::Box { low, high }, cell, 10_000_000).unwrap();
    let input = CheckInput::locations(&file, &cutter);
    bencher
        .counter(divan::counter::ItemsCount::new(60usize))
        .with_inputs(|| block.clone())
        .bench_local_values(|mut stock| {
            verify::simulate(
                &input,
                &mut stock,
                &verify::StockOptions::within(0.01 * cell),
                &Silent,
            )
            .unwrap()
        });
}

/// 100 000 tilting moves of 1 mm to and fro, a tool with a holder, past a post of 100 000 triangles; they pass it at
/// 300 mm and at 1 mm at least.
#[divan::bench(args = [300.0, 1.0], sample_count = 3, sample_size = 1)]
fn fixture(bencher: divan::Bencher<'_, '_>, gap: f64) {
    let spec = CutterSpec {
        length: 120.0,
        shank: vec![[40.0, 12.0], [70.0, 25.0], [100.0, 25.0]],
        ..CutterSpec::bull(MAJOR, MINOR)
    };
    let record = |k: u32| {
        let [row, x] = [k / 100, k % 100].map(f64::from);
        let x = if (k / 100).is_multiple_of(2) { x } else { 100.0 - x };
        let turn =
            Rotation3::from_euler_angles(0.1 * (0.05 * x).sin(), 0.1 * (0.01 * x).cos(), 0.0);
        let tip = Point3::new(x, -0.05 * row, 3.0 * (0.1 * x).sin());
        let pose = ToolPose { tip, axis: turn * Vector3::z_axis() };
        ClRecord { line: k, pose, motion: ClMotion::Feed(10.0), way: ClPath::Straight }
    };
    let file = ClFile { records: (0..=100_000).map(record).collect(), ..ClFile::default() };
    let cutter = Cutter::new(spec).unwrap();
    let input = CheckInput::locations(&file, &cutter);
    // The leaning holder reaches farther out than its radius: 33.9 mm, as measured.
    let base = Point3::new(50.0, 40.0 + 33.9 + gap, -100.0);
    let post = Solid::Cylinder { base, radius: 40.0, height: 200.0 };
    let fixtures = [Fixture::new(&post, 3e-7).unwrap()];
    let watch = ClearanceOptions::within(1e-3);
    bencher
        .counter(divan::counter::ItemsCount::new(100_000usize))
        .bench_local(|| verify::clearance(&input, &fixtures, &watch, &Silent).unwrap());
}

#[divan::bench(args = [1.0, 0.2], sample_count = 1, sample_size = 1)]
fn map(bencher: divan::Bencher<'_, '_>, grid: f64) {
    let kinematics = shop::kinematics(Layout::TableTable);
    let face = face();
    let program = program(&kinematics, &face);
    let spec = CutterSpec { length: 120.0, ..CutterSpec::of_radii(MAJOR, MINOR) };
    let cutter = Cutter::new(spec).unwrap();
    let input =
        CheckInput::program(&program, &kinematics, &cutter).faces(std::slice::from_ref(&face));
    let options = CheckOptions {
        reach: 5.0,
        ray_tolerance: 1e-4,
        most_points: 10_000_000,
        bounds: Some(BoundOptions::within(BoundMargins::both(0.01))),
        ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.2, gouge: 0.1 }, grid)
    };
    bencher.bench_local(|| verify::check(&input, &options, &Silent).unwrap());
}
