//! Stock under a moving tool, against closed forms; what is left ray by ray is tested where it is cut.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::shop;

use nalgebra::Point3;
use shop::Layout;
use std::f64::consts::PI;
use trunnion::cutter::{Cutter, CutterKind, CutterSpec};
use trunnion::machine::Kinematics;
use trunnion::nc::read::{
    self, AxisWords, ClFile, ClMotion, ClPath, ClRecord, Dialect, ReadOptions,
};
use trunnion::types::{Silent, ToolPose};
use trunnion::verify::{self, CheckInput, CollisionKind, Solid, Stock, StockOptions, StockReport};

const CUTTING: StockOptions = StockOptions::within(1e-4);

fn cutter(kind: CutterKind, major: f64, minor: f64, shank: Vec<[f64; 2]>) -> Cutter {
    Cutter::new(CutterSpec { kind, length: 60.0, shank, ..CutterSpec::of_radii(major, minor) })
        .unwrap()
}

fn pose(tip: [f64; 3], axis: [f64; 3]) -> ToolPose {
    ToolPose::new(tip, axis).unwrap()
}

fn file(moves: &[(ToolPose, bool)]) -> ClFile {
    let record = |(line, &(pose, rapid)): (u32, &(ToolPose, bool))| {
        let motion = if rapid { ClMotion::Rapid } else { ClMotion::Feed(10.0) };
        ClRecord { line, pose, motion, way: ClPath::Straight }
    };
    ClFile { records: (1..).zip(moves).map(record).collect(), ..ClFile::default() }
}

fn carve(moves: &[(ToolPose, bool)], cutter: &Cutter, stock: &mut Stock) -> StockReport {
    let file = file(moves);
    let input = CheckInput::locations(&file, cutter);
    verify::simulate(&input, stock, &CUTTING, &Silent).unwrap()
}

fn block(cell: f64) -> Stock {
    let [low, high] = [Point3::new(-20.0, -15.0, -10.0), Point3::new(20.0, 15.0, 0.0)];
    Stock::new(&Solid::Box { low, high }, cell, 10_000_000).unwrap()
}

#[test]
fn a_flat_cutter_plunged_leaves_a_cylinder() {
    let flat = cutter(CutterKind::Flat, 5.0, 0.0, vec![]);
    let mut stock = block(0.1);
    let down = [pose([0.1, 0.2, 5.0], [0.0, 0.0, 1.0]), pose([0.1, 0.2, -4.0], [0.0, 0.0, 1.0])];
    let carving = carve(&down.map(|pose| (pose, false)), &flat, &mut stock);
    let exact = PI * 25.0 * 4.0;
    assert!((carving.removed / exact - 1.0).abs() < 1e-3, "{} {exact}", carving.removed);
    assert_eq!(carving.collisions, []);
    // Again in the same place: nothing is left to cut.
    assert!(carve(&down.map(|pose| (pose, false)), &flat, &mut stock).removed.abs() < 1e-9);
}

#[test]
fn a_ball_through_a_block_leaves_a_tunnel() {
    // Sideways from outside, tilted: under the top, so that rays along z are split in two.
    let ball = cutter(CutterKind::Ball, 0.0, 2.0, vec![[4.0, 1.0]]);
    let mut stock = block(0.1);
    let axis = [0.0, 0.0, 1.0];
    let moves = [pose([-30.0, 0.0, -7.0], axis), pose([30.0, 0.0, -7.0], axis)];
    let carving = carve(&moves.map(|pose| (pose, false)), &ball, &mut stock);
    // Half a disc, above the centre up to the shank's lower end a box, and what the shank goes through.
    let exact = 40.0 * (0.5 * PI * 4.0 + 4.0 * 2.0 + 2.0 * 3.0);
    assert!((carving.removed / exact - 1.0).abs() < 2e-3, "{} {exact}", carving.removed);
    let shank = carving.collisions.iter().find(|hit| hit.kind == CollisionKind::Holder).unwrap();
    assert!(shank.line == 2 && shank.depth > 0.9, "{shank:?}");
}

#[test]
fn a_bull_nose_through_a_block_leaves_its_profile() {
    let [major, minor, deep] = [5.0, 3.0, 2.0f64];
    let mut stock = block(0.1);
    let axis = [0.0, 0.0, 1.0];
    let moves = [pose([-40.0, 0.3, -deep], axis), pose([40.0, 0.3, -deep], axis)];
    let bull = cutter(CutterKind::Bull, major, minor, vec![]);
    let removed = carve(&moves.map(|pose| (pose, false)), &bull, &mut stock).removed;
    // Half the width at height z is R + sqrt(r^2 - (r - z)^2).
    let integral =
        |x: f64| 0.5 * (x * (minor * minor - x * x).sqrt() + minor.powi(2) * (x / minor).asin());
    let exact = 40.0 * 2.0 * (major * deep + integral(deep - minor) - integral(-minor));
    assert!((removed / exact - 1.0).abs() < 5e-4, "{removed} {exact}");
}

/// What a flat cutter sweeps that turns by `angle` about its tip, in slices along the axis of the turn. A slice
/// of the tool is a rectangle `length` high and `2 w` wide that turns about the middle of its lower side; at
/// distance `rho` from there it holds all directions up to `asin(w / rho)` from its own, but where it ends
/// only those from `acos(length / rho)`, a gap that the turn fills.
fn fan(radius: f64, length: f64, angle: f64) -> f64 {
    let sum = |count: u32, low: f64, high: f64, f: &dyn Fn(f64) -> f64| -> f64 {
        let step = (high - low) / f64::from(count);
        (0..count).map(|k| f(low + step * (f64::from(k) + 0.5))).sum::<f64>() * step
    };
    let area = |w: f64| {
        let beyond = |rho: f64| (angle + 2.0 * (w / rho).asin()) * rho;
        0.5 * (angle + PI) * w * w + sum(2000, w, length.hypot(w), &beyond)
    };
    sum(2000, -radius, radius, &|y| area((radius * radius - y * y).sqrt()))
}

#[test]
fn a_cutter_turned_about_its_tip_cuts_a_fan() {
    let flat = Cutter::new(CutterSpec { length: 9.0, ..CutterSpec::flat(4.0) });
    let tip = [0.3, 0.2, -2.0];
    let lean = |angle: f64| pose(tip, [angle.sin(), 0.0, angle.cos()]);
    let moves = [lean(-0.9), lean(0.3), lean(0.9)].map(|pose| (pose, false));
    let [low, high] = [Point3::new(-20.0, -5.0, -10.0), Point3::new(20.0, 5.0, 10.0)];
    let mut stock = Stock::new(&Solid::Box { low, high }, 0.1, 10_000_000).unwrap();
    let removed = carve(&moves, &flat.unwrap(), &mut stock).removed;
    let exact = fan(2.0, 9.0, 1.8);
    assert!((removed / exact - 1.0).abs() < 5e-4, "{removed} {exact}");
}

#[test]
fn rapid_axes_at_their_own_speeds_do_not_run_straight() {
    let flat = cutter(CutterKind::Flat, 3.0, 0.0, vec![]);
    let run = |speed_of_x: f64| {
        let mut machine = shop::machine(Layout::TableHead);
        machine.axes[0].rapid = speed_of_x;
        let kinematics = Kinematics::new(&machine, &shop::setup(Layout::TableHead));
        let axes = AxisWords::of(&machine).unwrap();
        let options = ReadOptions::new(Dialect::LinuxCnc, axes, 5);
        let text = "G21 G90 G94\nG0 Z-1\nG0 X40 Y10\nG1 Y12 F100\nM2\n";
        let program = read::read(text, &options).unwrap();
        let input = CheckInput::program(&program, &kinematics, &flat);
        // Straight, Y is 2.5 where X is 10; at the same speed Y is there before X is.
        let [low, high] = [Point3::new(9.0, 8.0, -5.0), Point3::new(11.0, 9.0, 0.0)];
        let mut stock = Stock::new(&Solid::Box { low, high }, 0.1, 100_000).unwrap();
        verify::simulate(&input, &mut stock, &CUTTING, &Silent).unwrap().collisions
    };
    assert_eq!(run(4.0 * 500.0), []);
    let [hit] = run(500.0)[..] else { panic!("one collision") };
    assert_eq!((hit.kind, hit.line), (CollisionKind::Rapid, 3));
    assert!((hit.depth - 1.0).abs() < 1e-3, "{hit:?}");
}

#[test]
fn a_rapid_through_material_is_named_with_its_depth() {
    let flat = cutter(CutterKind::Flat, 3.0, 0.0, vec![]);
    let axis = [0.0, 0.0, 1.0];
    let moves = [
        (pose([-30.0, 0.0, 10.0], axis), false),
        (pose([-30.0, 0.0, -0.25], axis), false),
        (pose([30.0, 0.0, -0.25], axis), true),
        (pose([30.0, 10.0, 5.0], axis), false),
    ];
    let carving = carve(&moves, &flat, &mut block(0.2));
    let [hit] = carving.collisions[..] else { panic!("{:?}", carving.collisions) };
    assert_eq!((hit.kind, hit.line), (CollisionKind::Rapid, 3));
    assert!((hit.depth - 0.25).abs() < 0.01, "{hit:?}");
}

#[test]
fn of_many_collisions_the_worst_are_kept_and_all_are_counted() {
    let flat = cutter(CutterKind::Flat, 3.0, 0.0, vec![]);
    // Rapid moves across, 0.1 mm deeper every time but the last three.
    let depths = (1..=40).map(|k| if k > 37 { 3.75 } else { 0.1 * f64::from(k) });
    let moves: Vec<_> = std::iter::once((pose([-30.0, 0.0, 9.0], [0.0, 0.0, 1.0]), false))
        .chain(depths.enumerate().map(|(k, depth)| {
            let x = if k % 2 == 0 { 30.0 } else { -30.0 };
            (pose([x, 0.0, -depth], [0.0, 0.0, 1.0]), true)
        }))
        .collect();
    let run = |worst: usize| {
        let file = file(&moves);
        let input = CheckInput::locations(&file, &flat);
        let mut stock = block(0.5);
        verify::simulate(&input, &mut stock, &StockOptions { worst, ..CUTTING }, &Silent).unwrap()
    };
    let (all, some) = (run(1000), run(3));
    let mut deepest = all.collisions.clone();
    deepest.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    deepest.truncate(3);
    deepest.sort_by_key(|hit| hit.line);
    assert!(all.collisions.len() > 20 && all.collisions.len() == all.count());
    assert_eq!((&some.collisions, &some.lines), (&deepest, &all.lines));
    let [(CollisionKind::Rapid, lines)] = some.lines[..] else { panic!("{:?}", some.lines) };
    let [first, last] = [&all.collisions[0], &all.collisions[all.collisions.len() - 1]];
    assert_eq!((lines.first, lines.last), (first.line, last.line));
}

#[test]
fn the_same_stock_on_one_and_two_threads() {
    let bull = cutter(CutterKind::Bull, 5.0, 3.0, vec![]);
    let axis = [0.1, 0.05, 1.0];
    let moves: Vec<_> =
        (0..8).map(|k| (pose([-16.0 + 4.0 * f64::from(k), 0.0, -3.0], axis), k == 5)).collect();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut stock = block(0.3);
            let carving = carve(&moves, &bull, &mut stock);
            (stock, carving)
        })
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn what_is_left_has_a_closed_surface_of_its_volume() {
    let bull = cutter(CutterKind::Bull, 5.0, 3.0, vec![]);
    let axis = [0.1, 0.05, 1.0];
    let moves = [pose([-16.0, 2.0, -3.0], axis), pose([16.0, 0.0, -4.0], axis)];
    let mut stock = block(0.5);
    let left = carve(&moves.map(|pose| (pose, false)), &bull, &mut stock).left;
    let mesh = stock.mesh(CUTTING.tolerance);
    let mut edges = std::collections::BTreeMap::new();
    let mut volume = 0.0;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| mesh.vertices[corner as usize].coords);
        volume += a.dot(&b.cross(&c)) / 6.0;
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            *edges.entry((triangle[from], triangle[to])).or_insert(0) += 1;
        }
    }
    // Every edge is run through as often one way as the other.
    assert!(edges.iter().all(|(&(a, b), count)| edges.get(&(b, a)) == Some(count)));
    // Edges of the block are cut off by a part of a cell.
    assert!((volume / left - 1.0).abs() < 5e-3, "{volume} {left}");
}
