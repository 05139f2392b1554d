//! Random tools on random ways through random machines, against the same ways in many poses: the heights that a check
//! measures over a bicubic face, and the volume that is cut from stock. A few by default; `just torture` sets
//! `TRUNNION_TORTURE=1` for thousands. The seed of each is told where it fails; `TRUNNION_TORTURE_SEED` repeats a run.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "the worst found says how near it is")]

mod dice;
mod many_poses;
mod posted;

use dice::{Random, full, seed};
use many_poses::{Mode, Way};
use nalgebra::{Point3, Rotation3, Vector3};
use trunnion::cutter::{Construction, Cutter, CutterSpec, Kind};
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::Silent;
use trunnion::verify::{
    Carving, Cutting, Input, Options, Report, Solid, Stock, check, check_cl, simulate, simulate_cl,
};

const RAY_TOLERANCE: f64 = 1e-5;
const REACH: f64 = 2.0;
/// What words of nine decimals are off, at levers of a metre, and rounding of the measure itself \[mm\].
const ROUNDING: f64 = 1e-7;
/// Length of all tools \[mm\].
const LENGTH: f64 = 60.0;

fn any_cutter(random: &mut Random) -> Cutter {
    let [major, minor] = [random.within(0.5, 6.0), random.within(0.3, 4.0)];
    let (kind, major, minor) = match random.below(3) {
        0 => (Kind::Flat, major, 0.0),
        1 => (Kind::Ball, 0.0, minor + 1.0),
        _ => (Kind::Bull, major, minor),
    };
    let construction = Construction::Solid;
    let spec = CutterSpec { kind, major, minor, length: LENGTH, construction, shank: vec![] };
    Cutter::new(spec).unwrap()
}

/// A bicubic patch below the tool where it starts, leaning and waved.
fn any_face(random: &mut Random, way: &Way, cutter: &Cutter) -> Face {
    let start = way.pose(0, 0.0);
    let up = Rotation3::rotation_between(&Vector3::z(), &start.axis).unwrap();
    let [a, b] = [random.within(-0.5, 0.5), random.within(-0.5, 0.5)];
    let turn = up * Rotation3::from_euler_angles(a, b, 0.0);
    // About as far below the tip as the lean lifts its edge.
    let gap = random.within(-0.4, 0.4) + 0.3 * a.hypot(b) * cutter.radius();
    let place = start.tip - start.axis.into_inner() * gap;
    let size = random.within(2.0, 6.0);
    let mut point = |i: usize, j: usize| {
        let along = |k: usize| size * (k as f64 / 3.0 - 0.5);
        let waved = random.point(0.07 * size);
        place + turn * (Vector3::new(along(i), along(j), 0.0) + waved)
    };
    let net = (0..4).map(|i| (0..4).map(|j| point(i, j)).collect()).collect();
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([3, 3], [knots(), knots()], net, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new(), false).unwrap()
}

fn checked(way: &Way, cutter: &Cutter, face: &Face, grid: f64) -> Report {
    let options = Options {
        grid,
        reach: REACH,
        ray_tolerance: RAY_TOLERANCE,
        total: 0.02,
        gouge: 0.002,
        most_points: 10_000,
        promise: None,
    };
    let faces = std::slice::from_ref(face);
    if way.mode == Mode::Circle {
        let file = way.file();
        let input = trunnion::verify::ClInput { file: &file, faces, cutter, rest: &[] };
        return check_cl(&input, &options, &Silent).unwrap();
    }
    let (program, kinematics) = (way.program(), &way.kinematics);
    let (believed, real) = (kinematics, kinematics);
    let input = Input {
        program: &program,
        believed,
        real,
        faces,
        cutter,
        rest: &[],
        tables: trunnion::verify::Tables::NONE,
    };
    check(&input, &options, &Silent).unwrap()
}

/// How far the check is above what poses show at most, and how far from the tool the place is that it names \[mm\].
fn off(way: &Way, cutter: &Cutter, face: &Face, report: &Report) -> [f64; 2] {
    let mut worst = [f64::NEG_INFINITY; 2];
    let poses = way.poses(many_poses::SPACING);
    for sample in report.maps[0].samples.iter().flatten() {
        let normal = face.normal(sample.uv[0], sample.uv[1]).unwrap().into_inner();
        let ray = (sample.point, normal);
        let seen = many_poses::lowest(&poses, cutter, ray, REACH, 0.2 * RAY_TOLERANCE);
        let found = sample.height;
        worst[0] = worst[0].max(match (seen, found) {
            (Some(seen), found) => found.unwrap_or(REACH) - seen,
            (None, _) => f64::NEG_INFINITY,
        });
        if let Some(found) = found {
            let place = (found, RAY_TOLERANCE);
            worst[1] = worst[1].max(many_poses::nearest((way, &poses), cutter, ray, place));
        }
    }
    worst
}

/// No pose gets lower than the check says, and what it says is touched at some time.
#[test]
fn heights_are_those_of_many_poses() {
    let (first, count) = (seed(), if full() { 3000 } else { 12 });
    let (mut points, mut reached, mut worst) = (0, 0, [f64::NEG_INFINITY; 2]);
    for case in 0..count {
        let seed = first.wrapping_add(case);
        let random = &mut Random(seed);
        let cutter = any_cutter(random);
        let way = many_poses::any_way(random);
        let face = any_face(random, &way, &cutter);
        let grid = random.within(0.7, 1.5);
        let report = checked(&way, &cutter, &face, grid);
        assert_eq!(report.deviation.unmeasured, 0, "seed {seed}");
        points += report.deviation.points;
        reached += report.deviation.points - report.deviation.uncut;
        let off = off(&way, &cutter, &face, &report);
        let kind = (cutter.kind(), way.mode, way.machine);
        assert!(off[0] <= RAY_TOLERANCE + ROUNDING, "seed {seed} {kind:?}: missed by {:e}", off[0]);
        assert!(off[1] <= RAY_TOLERANCE + ROUNDING, "seed {seed} {kind:?}: {:e} away", off[1]);
        worst = [0, 1].map(|k| worst[k].max(off[k]));
    }
    assert!(3 * reached > points, "{reached} of {points}");
    let [above, away] = worst;
    println!(
        "{count} ways, {reached} of {points} points reached: at most {above:e} mm above poses, {away:e} mm off the tool"
    );
}

fn carved(way: &Way, cutter: &Cutter, stock: &mut Stock) -> Carving {
    let tolerance = 1e-4;
    if way.mode == Mode::Circle {
        let file = way.file();
        let input = trunnion::verify::ClInput { file: &file, faces: &[], cutter, rest: &[] };
        return simulate_cl(&input, stock, &Cutting { tolerance, worst: 100 }, &Silent).unwrap();
    }
    let (program, kinematics) = (way.program(), &way.kinematics);
    let (believed, real) = (kinematics, kinematics);
    let input = Input {
        program: &program,
        believed,
        real,
        faces: &[],
        cutter,
        rest: &[],
        tables: trunnion::verify::Tables::NONE,
    };
    simulate(&input, stock, &Cutting { tolerance, worst: 100 }, &Silent).unwrap()
}

/// The volume that is cut is that of the poses, by rays of their own with their own statistical error.
#[test]
fn volumes_are_those_of_many_poses() {
    let (first, count) = (seed(), if full() { 200 } else { 4 });
    let lines = if full() { 60 } else { 40 };
    let (mut sum, mut squares) = (0.0, 0.0);
    let mut worst = 0.0_f64;
    for case in 0..count {
        let seed = first.wrapping_add(case);
        let random = &mut Random(seed);
        let cutter = any_cutter(random);
        let way = many_poses::any_way(random);
        let half = Vector3::repeat(random.within(2.0, 8.0));
        let centre = way.pose(0, 0.0).tip + random.point(3.0);
        let [low, high]: [Point3<f64>; 2] = [centre - half, centre + half];
        let cell = half.x / 50.0;
        let mut stock = Stock::new(&Solid::Box { low, high }, cell, 10_000_000).unwrap();
        let removed = carved(&way, &cutter, &mut stock).removed;
        let along = random.below(3);
        let poses = way.poses(0.3 * cell);
        let (seen, error) =
            many_poses::volume(&poses, &cutter, [low, high], (along, lines), random);
        // Each ray stands for a cell, of which it knows the edge to a part; walls are four sides of the block long.
        let size = 2.0 * half.x;
        let own = 0.1 * cell * cell * size * (4.0 * size / cell).sqrt();
        let likely = error.hypot(own);
        let z = (removed - seen) / likely;
        assert!(z.abs() < 5.0, "seed {seed}: {removed} mm3 cut, poses show {seen} +- {likely}");
        sum += z;
        squares += z * z;
        worst = worst.max((removed - seen).abs() / size.powi(3));
    }
    let mean = sum / count as f64;
    println!(
        "{count} ways: mean {mean:.3} and rms {:.3} of the expected error, worst {worst:e} of the block",
        (squares / count as f64).sqrt()
    );
    assert!(mean.abs() < 5.0 / (count as f64).sqrt(), "{mean}");
}
