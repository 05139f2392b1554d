//! Stock under a moving tool, against closed forms and against counting points.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Rotation3, Unit, Vector3};
use std::f64::consts::PI;
use trunnion::cutter::{Construction, Cutter, CutterSpec, Kind};
use trunnion::nc::read::{ClFile, ClMotion, ClRecord, ClWay};
use trunnion::types::{Silent, ToolPose};
use trunnion::verify::{self, Carving, ClInput, CollisionKind, Solid, Stock};

fn cutter(kind: Kind, major: f64, minor: f64, shank: Vec<[f64; 2]>) -> Cutter {
    let construction = Construction::Solid;
    Cutter::new(CutterSpec { kind, major, minor, length: 60.0, construction, shank }).unwrap()
}

fn pose(tip: [f64; 3], axis: [f64; 3]) -> ToolPose {
    ToolPose::new(tip, axis).unwrap()
}

fn file(moves: &[(ToolPose, bool)]) -> ClFile {
    let record = |(line, &(pose, rapid)): (u32, &(ToolPose, bool))| {
        let motion = if rapid { ClMotion::Rapid } else { ClMotion::Feed(10.0) };
        ClRecord { line, pose, motion, way: ClWay::Straight }
    };
    ClFile { records: (1..).zip(moves).map(record).collect(), ..ClFile::default() }
}

fn carve(moves: &[(ToolPose, bool)], cutter: &Cutter, stock: &mut Stock) -> Carving {
    let file = file(moves);
    let input = ClInput { file: &file, faces: &[], cutter, rest: &[] };
    verify::simulate_cl(&input, stock, &[], 1e-4, &Silent).unwrap()
}

fn block(cell: f64) -> Stock {
    let [low, high] = [Point3::new(-20.0, -15.0, -10.0), Point3::new(20.0, 15.0, 0.0)];
    Stock::new(&Solid::Box { low, high }, cell, 10_000_000).unwrap()
}

#[test]
fn a_flat_cutter_plunged_leaves_a_cylinder() {
    let flat = cutter(Kind::Flat, 5.0, 0.0, vec![]);
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
    let ball = cutter(Kind::Ball, 0.0, 2.0, vec![[4.0, 1.0]]);
    let mut stock = block(0.1);
    let axis = [0.0, 0.0, 1.0];
    let moves = [pose([-30.0, 0.0, -7.0], axis), pose([30.0, 0.0, -7.0], axis)];
    let carving = carve(&moves.map(|pose| (pose, false)), &ball, &mut stock);
    // Half a disc, and above the centre up to the shank's lower end a box.
    let exact = 40.0 * (0.5 * PI * 4.0 + 4.0 * 2.0);
    assert!((carving.removed / exact - 1.0).abs() < 2e-3, "{} {exact}", carving.removed);
    let shank = carving.collisions.iter().find(|hit| hit.kind == CollisionKind::Holder).unwrap();
    assert!(shank.line == 2 && shank.depth > 0.9, "{shank:?}");
}

/// Whether a point is inside the cutting part of a bull nose.
fn inside(cutter: &Cutter, pose: &ToolPose, p: &Point3<f64>) -> bool {
    let y = p - pose.tip;
    let z = pose.axis.dot(&y);
    let rho = (y - pose.axis.into_inner() * z).norm();
    let out = (rho - cutter.major()).max(0.0);
    let down = (cutter.minor() - z).max(0.0);
    z <= cutter.length() && out.hypot(down) <= cutter.minor()
}

/// Volume of a sweep inside the block by counting points of a low-discrepancy sequence over dense
/// instants: no code in common with the rays.
fn counted(moves: &[(ToolPose, bool)], cutter: &Cutter, points: u32) -> f64 {
    let [a, b, c] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];
    let mut hits = 0u32;
    for k in 0..points {
        let k = f64::from(k) + 0.5;
        let [x, y, z] = [(a * k).fract(), (b * k).fract(), (c * k).fract()];
        let p = Point3::new(-20.0 + 40.0 * x, -15.0 + 30.0 * y, -10.0 + 10.0 * z);
        let hit = moves.windows(2).any(|pair| {
            let [from, to] = [pair[0].0, pair[1].0];
            (0..=24).any(|step| {
                let t = f64::from(step) / 24.0;
                let axis = Unit::new_normalize(from.axis.lerp(&to.axis, t));
                inside(cutter, &ToolPose { tip: from.tip + (to.tip - from.tip) * t, axis }, &p)
            })
        });
        hits += u32::from(hit);
    }
    f64::from(hits) / f64::from(points) * 12_000.0
}

#[test]
fn tilting_moves_take_away_what_points_counted_say() {
    let bull = cutter(Kind::Bull, 5.0, 3.0, vec![]);
    let moves: Vec<(ToolPose, bool)> = (0..14)
        .map(|k| {
            let k = f64::from(k);
            let turn = Rotation3::from_euler_angles(0.15 + 0.01 * k, 0.1 * (0.4 * k).sin(), 0.0);
            let tip = Point3::new(-14.0 + 2.0 * k, 3.0 * (0.3 * k).sin(), -3.0 - (0.5 * k).cos());
            (ToolPose { tip, axis: Unit::new_normalize(turn * Vector3::z()) }, false)
        })
        .collect();
    let mut stock = block(0.1);
    let removed = carve(&moves, &bull, &mut stock).removed;
    let counted = counted(&moves, &bull, 100_000);
    // 100 000 points are 0.5 mm apart: some 4000 of them decide at the surface, by the toss of a coin.
    assert!((removed / counted - 1.0).abs() < 0.015, "{removed} {counted}");
    // All three families say the same, so do other rays.
    let mut coarse = block(0.23);
    let other = carve(&moves, &bull, &mut coarse).removed;
    assert!((other / removed - 1.0).abs() < 2e-3, "{other} {removed}");
}

#[test]
fn a_rapid_through_material_is_named_with_its_depth() {
    let flat = cutter(Kind::Flat, 3.0, 0.0, vec![]);
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
fn the_same_stock_on_one_and_two_threads() {
    let bull = cutter(Kind::Bull, 5.0, 3.0, vec![]);
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
    let bull = cutter(Kind::Bull, 5.0, 3.0, vec![]);
    let axis = [0.1, 0.05, 1.0];
    let moves = [pose([-16.0, 2.0, -3.0], axis), pose([16.0, 0.0, -4.0], axis)];
    let mut stock = block(0.5);
    let left = carve(&moves.map(|pose| (pose, false)), &bull, &mut stock).left;
    let mesh = stock.mesh();
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

#[test]
fn a_holder_that_grazes_a_fixture_is_seen() {
    let bull = cutter(Kind::Bull, 2.0, 1.0, vec![[20.0, 8.0]]);
    let axis = [0.0, 0.0, 1.0];
    let file =
        file(&[(pose([-30.0, 0.0, -2.0], axis), false), (pose([30.0, 0.0, -2.0], axis), false)]);
    let input = ClInput { file: &file, faces: &[], cutter: &bull, rest: &[] };
    let clamp = |y: f64| {
        let [low, high] = [Point3::new(-3.0, y, 0.0), Point3::new(3.0, y + 5.0, 30.0)];
        Stock::new(&Solid::Box { low, high }, 0.25, 1_000_000).unwrap()
    };
    let hits = |y: f64| {
        let carving = verify::simulate_cl(&input, &mut block(0.5), &[clamp(y)], 1e-4, &Silent);
        carving.unwrap().collisions
    };
    assert_eq!(hits(8.001), []);
    let grazed = hits(7.995);
    assert!(matches!(grazed[..], [hit] if hit.kind == CollisionKind::Fixture && hit.line == 2));
    assert!((grazed[0].depth - 0.005).abs() < 5e-4, "{grazed:?}");
}
