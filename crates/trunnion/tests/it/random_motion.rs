//! Random tools on random ways through random machines, against the same ways in many poses: the heights that a check
//! measures over a bicubic face, and the volume that is cut from stock. A few by default; `just torture` sets
//! `TRUNNION_TORTURE=1` for thousands. The seed of each is reported where it fails; `TRUNNION_TORTURE_SEED` repeats a run.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "the worst found says how near it is")]

use crate::dice;
use crate::many_poses;
use crate::random_cut;

use dice::{Random, full, seed};
use many_poses::{Course, Mode, Way};
use nalgebra::{Point3, Vector3};
use random_cut::{RAY_TOLERANCE, ROUNDING, Still, any_cutter, any_face, off};
use trunnion::cutter::Cutter;
use trunnion::surface::Face;
use trunnion::types::Silent;
use trunnion::verify::{
    CheckInput, Report, Solid, Stock, StockOptions, StockReport, check, simulate,
};

fn checked(way: &Way, cutter: &Cutter, face: &Face, grid: f64) -> Report {
    let options = random_cut::options(grid);
    let faces = std::slice::from_ref(face);
    if way.mode == Mode::Circle {
        let file = way.file();
        let input = trunnion::verify::CheckInput::locations(&file, cutter).faces(faces);
        return check(&input, &options, &Silent).unwrap();
    }
    let (program, kinematics) = (way.program(), &way.kinematics);
    let (believed, real) = (kinematics, kinematics);
    let input = CheckInput::program(&program, believed, cutter).machine(real).faces(faces);
    check(&input, &options, &Silent).unwrap()
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
        let off = off([&way, &Still], &cutter, &face, &report);
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

fn carved(way: &Way, cutter: &Cutter, stock: &mut Stock) -> StockReport {
    let tolerance = 1e-4;
    if way.mode == Mode::Circle {
        let file = way.file();
        let input = trunnion::verify::CheckInput::locations(&file, cutter);
        return simulate(&input, stock, &StockOptions::within(tolerance), &Silent).unwrap();
    }
    let (program, kinematics) = (way.program(), &way.kinematics);
    let (believed, real) = (kinematics, kinematics);
    let input = CheckInput::program(&program, believed, cutter).machine(real);
    simulate(&input, stock, &StockOptions::within(tolerance), &Silent).unwrap()
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
