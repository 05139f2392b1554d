//! How near a tool comes to fixtures, against many places at many times with a distance of the test's own.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;
use crate::shop;

use nalgebra::{Point3, Rotation3, Unit, Vector3};
use property::cases;
use proptest::prelude::*;
use shop::Layout;
use trunnion::cutter::{Cutter, CutterKind, CutterSpec};
use trunnion::machine::Kinematics;
use trunnion::nc::read::{
    self, AxisWords, ClFile, ClMotion, ClPath, ClRecord, Dialect, ReadOptions,
};
use trunnion::types::{Mesh, Silent, ToolPose};
use trunnion::verify::{
    self, CheckInput, ClearanceOptions, ClearanceReport, CollisionKind, Fixture, Solid,
};

const TOLERANCE: f64 = 1e-3;
/// Of the depth of a body in a fixture, what is exact enough.
const DEEP: f64 = 0.01;

fn cutter(kind: CutterKind, major: f64, minor: f64, shank: Vec<[f64; 2]>) -> Cutter {
    Cutter::new(CutterSpec { kind, length: 60.0, shank, ..CutterSpec::of_radii(major, minor) })
        .unwrap()
}

fn file(path: &[ToolPose]) -> ClFile {
    let record = |(line, &pose)| ClRecord {
        line,
        pose,
        motion: ClMotion::Feed(10.0),
        way: ClPath::Straight,
    };
    ClFile { records: (1..).zip(path).map(record).collect(), ..ClFile::default() }
}

fn clearance(
    path: &[ToolPose],
    cutter: &Cutter,
    solids: &[Solid],
    clearance: f64,
) -> ClearanceReport {
    let file = file(path);
    let input = CheckInput::locations(&file, cutter);
    let fixture = |solid| Fixture::new(solid, 0.1 * TOLERANCE).unwrap();
    let fixtures: Vec<Fixture> = solids.iter().map(fixture).collect();
    let watch = ClearanceOptions { clearance, ..ClearanceOptions::within(TOLERANCE) };
    verify::clearance(&input, &fixtures, &watch, &Silent).unwrap()
}

/// From a segment of the half plane of the axis.
fn from_segment([rho, z]: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let [u, v] = [b[0] - a[0], b[1] - a[1]];
    let share = ((rho - a[0]) * u + (z - a[1]) * v) / (u * u + v * v).max(1e-300);
    let share = share.clamp(0.0, 1.0);
    (rho - a[0] - share * u).hypot(z - a[1] - share * v)
}

/// Signed distance of a point from a tool: below 0 how deep it is in one of its bodies.
fn distance(cutter: &Cutter, pose: &ToolPose, p: &Point3<f64>) -> f64 {
    let y = p - pose.tip;
    let at = [pose.axis.cross(&y).norm(), pose.axis.dot(&y)];
    let [rho, z] = at;
    let [major, minor] = [cutter.major(), cutter.minor()];
    let shank = &cutter.spec().shank;
    let top = shank.first().map_or(60.0, |entry| entry[0]);
    let wide = major + minor;
    let round = if z < minor {
        major + (minor * minor - (minor - z).powi(2)).max(0.0).sqrt()
    } else {
        wide
    };
    let lines =
        [[[0.0, 0.0], [major, 0.0]], [[wide, minor], [wide, top]], [[wide, top], [0.0, top]]];
    let mut away = lines.iter().map(|line| from_segment(at, *line)).fold(f64::INFINITY, f64::min);
    if rho >= major && z <= minor {
        away = away.min(((rho - major).hypot(z - minor) - minor).abs());
    }
    let sign = |inside: bool, away: f64| if inside { -away } else { away };
    let mut least = sign(rho <= round && (0.0..=top).contains(&z), away);
    let ends = shank.iter().skip(1).copied().chain(shank.last().map(|last| [60.0, last[1]]));
    for ([low, a], [high, b]) in shank.iter().copied().zip(ends) {
        if high > low {
            let lines = [[[0.0, low], [a, low]], [[a, low], [b, high]], [[b, high], [0.0, high]]];
            let all = lines.iter().map(|line| from_segment(at, *line));
            let width = a + (b - a) * (z - low) / (high - low);
            let inside = (low..=high).contains(&z) && rho <= width;
            least = least.min(sign(inside, all.fold(f64::INFINITY, f64::min)));
        }
    }
    least
}

fn between([from, to]: &[ToolPose; 2], t: f64) -> ToolPose {
    ToolPose { tip: from.tip + (to.tip - from.tip) * t, axis: from.axis.slerp(&to.axis, t) }
}

/// Least distance of a tool from a triangle over a move: many places at many times, and from the best of them on
/// to better ones with ever smaller steps.
fn from_triangle(cutter: &Cutter, ends: &[ToolPose; 2], [a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let value = |&[t, u, v]: &[f64; 3]| {
        // A square folded into the triangle.
        let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
        distance(cutter, &between(ends, t), &(a + (b - a) * u + (c - a) * v))
    };
    let mut samples = Vec::new();
    for i in 0..=24 {
        for j in 0..=8 {
            for k in 0..=8 - j {
                let at = [f64::from(i) / 24.0, f64::from(j) / 8.0, f64::from(k) / 8.0];
                samples.push((value(&at), at));
            }
        }
    }
    samples.sort_by(|x, y| x.0.total_cmp(&y.0));
    let refined = samples.iter().take(4).map(|&(mut best, mut at)| {
        let mut step = 0.1;
        while step > 1e-7 {
            let mut moved = false;
            for (x, y, z) in (0..27).map(|k| (k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)) {
                let by = [x, y, z].map(|sign| f64::from(sign) * step);
                let next = [0, 1, 2].map(|k| (at[k] + by[k]).clamp(0.0, 1.0));
                if value(&next) < best {
                    (best, at, moved) = (value(&next), next, true);
                }
            }
            if !moved {
                step *= 0.5;
            }
        }
        best
    });
    refined.fold(f64::INFINITY, f64::min)
}

/// Least distance from a place over a move.
fn from_place(cutter: &Cutter, ends: &[ToolPose; 2], p: &Point3<f64>) -> f64 {
    let at = |t: f64| distance(cutter, &between(ends, t), p);
    let best = (0..=400).map(|k| f64::from(k) / 400.0).min_by(|a, b| at(*a).total_cmp(&at(*b)));
    let [mut low, mut high] =
        [best.unwrap() - 0.0025, best.unwrap() + 0.0025].map(|t| t.clamp(0.0, 1.0));
    for _ in 0..40 {
        let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if at(a) < at(b) { high = b } else { low = a }
    }
    at(low).min(at(best.unwrap()))
}

fn cutters() -> impl Strategy<Value = Cutter> {
    let holder = vec![[12.0, 2.5], [25.0, 2.5], [25.0, 6.0], [40.0, 11.0]];
    prop_oneof![
        Just(cutter(CutterKind::Bull, 3.0, 2.0, vec![[15.0, 4.0], [30.0, 9.0]])),
        Just(cutter(CutterKind::Ball, 0.0, 2.5, holder)),
        Just(cutter(CutterKind::Flat, 4.0, 0.0, vec![])),
        Just(cutter(CutterKind::Bull, 6.0, 4.0, vec![[20.0, 14.0], [50.0, 7.0]])),
    ]
}

fn poses() -> impl Strategy<Value = [ToolPose; 2]> {
    let vector = |size: f64| [-size..size, -size..size, -size..size].prop_map(Vector3::from);
    let step = prop_oneof![vector(3.0), vector(30.0), Just(Vector3::zeros())];
    let turn = prop_oneof![vector(0.02), vector(0.5), Just(Vector3::zeros())];
    (vector(15.0), step, vector(0.7), turn).prop_map(|(tip, step, lean, turn)| {
        let axis = Rotation3::new(lean) * Vector3::z();
        let to = Rotation3::new(turn) * axis;
        let pose = |tip: Vector3<f64>, axis| ToolPose {
            tip: Point3::from(tip),
            axis: Unit::new_normalize(axis),
        };
        [pose(tip, axis), pose(tip + step, to)]
    })
}

/// Tetrahedra, some as thin as needles.
fn tetrahedra() -> impl Strategy<Value = [Point3<f64>; 4]> {
    let size = prop_oneof![Just([15.0, 15.0]), Just([25.0, 0.01]), Just([3.0, 0.5])];
    let share = || -1.0..1.0f64;
    let middle = [-30.0..30.0, -30.0..30.0, -10.0..60.0f64];
    let corners =
        [[share(), share(), share()], [share(), share(), share()], [share(), share(), share()]];
    (middle, size, corners).prop_filter_map("flat", |(middle, [long, thick], [a, b, c])| {
        let base = Point3::from(middle);
        let a = Vector3::from(a) * long;
        let [b, c] = [b, c].map(|v| Vector3::from(v) * thick);
        (a.dot(&b.cross(&c)).abs() > 1e-3 * long * thick * thick)
            .then(|| [base, base + a, base + b, base + c])
    })
}

fn faces(corners: &[Point3<f64>; 4]) -> [[Point3<f64>; 3]; 4] {
    [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]].map(|face: [usize; 3]| face.map(|k| corners[k]))
}

fn mesh(corners: &[Point3<f64>; 4]) -> Solid {
    let triangles = vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
    Solid::Mesh(Mesh { vertices: corners.to_vec(), triangles })
}

fn exact_enough(distance: f64) -> f64 {
    TOLERANCE.max(-DEEP * distance)
}

proptest! {
    #![proptest_config(cases(60))]

    /// No place at any time is nearer than reported, and at the place reported the tool is as near as reported.
    #[test]
    fn nothing_is_nearer_than_reported(cutter in cutters(), ends in poses(), corners in tetrahedra()) {
        let found = clearance(&ends, &cutter, &[mesh(&corners)], 0.0);
        let least = found.least.unwrap();
        let sampled = faces(&corners).map(|face| from_triangle(&cutter, &ends, &face));
        let sampled = sampled.into_iter().fold(f64::INFINITY, f64::min);
        let reported = least.distance;
        prop_assert!(reported <= sampled + exact_enough(reported), "reported {reported}, sampled {sampled}");
        let there = from_place(&cutter, &ends, &least.point);
        prop_assert!((there - reported).abs() <= exact_enough(reported), "reported {reported}, there {there}");
        prop_assert_eq!(least.line, 2);
        match &found.near[..] {
            [] => prop_assert!(reported > -TOLERANCE),
            [hit] => prop_assert!(hit.distance < 0.0 && hit.line == 2),
            more => prop_assert!(false, "{more:?}"),
        }
    }
}

fn upright(x: f64, y: f64, z: f64) -> ToolPose {
    ToolPose { tip: Point3::new(x, y, z), axis: Vector3::z_axis() }
}

/// A holder that turns past the edge of a clamp, 5 um deep or 5 um clear of it, in one of many blocks.
#[test]
fn a_holder_that_grazes_an_edge_is_found_at_its_block() {
    let bull = cutter(CutterKind::Bull, 3.0, 2.0, vec![[20.0, 2.0], [30.0, 8.0]]);
    // Along x with a lean of 20 degrees to the side: the lower rim of the holder passes an edge along x.
    let lean = 20f64.to_radians();
    let axis = Unit::new_normalize(Vector3::new(0.0, lean.sin(), lean.cos()));
    let path: Vec<ToolPose> = (0..=40)
        .map(|k| ToolPose { tip: Point3::new(f64::from(k) - 20.0, 0.0, 0.0), axis })
        .collect();
    // Across the axis, and a place of the holder's side: there the upper edge of the clamp, at x in 4.13..4.17.
    let way = [lean.cos(), -lean.sin()];
    let side = [35.0 * lean.sin() + 8.0 * way[0], 35.0 * lean.cos() + 8.0 * way[1]];
    let clamp = |deep: f64| {
        let [y, z] = [0, 1].map(|k| side[k] - deep * way[k]);
        Solid::Box { low: Point3::new(4.13, y, -5.0), high: Point3::new(4.17, y + 30.0, z) }
    };
    let clear = clearance(&path, &bull, &[clamp(-0.005)], 0.0);
    assert_eq!(clear.near, []);
    let least = clear.least.unwrap();
    assert!(least.distance > 0.0 && least.distance <= 0.005 + TOLERANCE, "{least:?}");
    let grazed = clearance(&path, &bull, &[clamp(0.005)], 0.0).near;
    // From x = 4 to x = 5, on line 26.
    let hit = grazed.iter().find(|hit| hit.line == 26).unwrap();
    assert!(
        hit.distance < -0.004 && hit.collision().unwrap().kind == CollisionKind::Fixture,
        "{grazed:?}"
    );
}

#[test]
fn flat_beside_flat_is_a_pencil_calculation() {
    let bull = cutter(CutterKind::Bull, 2.0, 1.0, vec![[20.0, 8.0]]);
    let path = [upright(-30.0, 0.0, -2.0), upright(30.0, 0.0, -2.0), upright(30.0, 0.0, 8.0)];
    let clamp = |y: f64| {
        let [low, high] = [Point3::new(-3.0, y, 0.0), Point3::new(3.0, y + 5.0, 30.0)];
        Solid::Box { low, high }
    };
    for (y, lines) in [(7.995, vec![2]), (8.005, vec![])] {
        let found = clearance(&path, &bull, &[clamp(y)], 0.0);
        let least = found.least.unwrap();
        assert!((least.distance - (y - 8.0)).abs() < TOLERANCE && least.line == 2, "{least:?}");
        assert_eq!(found.near.iter().map(|hit| hit.line).collect::<Vec<_>>(), lines);
    }
    // Lines that come nearer than asked for, each with how near: the next one begins 27 and 2 from the edge.
    let near = clearance(&path, &bull, &[clamp(10.0)], 27.5).near;
    let [pass, up] = near[..] else { panic!("{near:?}") };
    assert!((pass.distance - 2.0).abs() < TOLERANCE && pass.line == 2, "{pass:?}");
    let exact = 27f64.hypot(10.0) - 8.0;
    assert!((up.distance - exact).abs() < TOLERANCE && up.line == 3, "{up:?} {exact}");
}

#[test]
fn a_needle_in_the_way_is_found() {
    let flat = cutter(CutterKind::Flat, 4.0, 0.0, vec![]);
    let path = [upright(-50.0, 0.0, 1.0), upright(50.0, 0.0, 1.0)];
    // 0.1 um thick, straight up through the way of the tool.
    let [x, y, d] = [0.1235, 1.7654, 1e-4];
    let corners = [[x, y, 1.5], [x + d, y, -9.0], [x, y + d, -9.0], [x - d, y - d, -9.0]];
    let hit = clearance(&path, &flat, &[mesh(&corners.map(Point3::from))], 0.0).near[0];
    // As deep as it is high above the tip's face.
    assert!(hit.line == 2 && (hit.distance + 0.5).abs() < DEEP, "{hit:?}");
}

#[test]
fn a_tool_wholly_inside_is_found() {
    let flat = cutter(CutterKind::Flat, 4.0, 0.0, vec![]);
    let path = [upright(0.0, 0.0, 0.0), upright(1.0, 0.0, 0.0)];
    let solids = [
        Solid::Box { low: Point3::new(-50.0, -50.0, -50.0), high: Point3::new(50.0, 50.0, 150.0) },
        Solid::Cylinder { base: Point3::new(0.0, 0.0, -50.0), radius: 40.0, height: 200.0 },
    ];
    for solid in solids {
        let hit = clearance(&path, &flat, &[solid], 0.0).near[0];
        assert!((hit.distance + 4.0).abs() < TOLERANCE, "{hit:?}");
    }
}

#[test]
fn a_cylinder_is_as_near_as_its_radius_says() {
    let ball = cutter(CutterKind::Ball, 0.0, 3.0, vec![]);
    let path = [upright(-40.0, -30.0, 5.0), upright(40.0, -30.0, 5.0)];
    for by in [-0.005, 0.005] {
        let solid = Solid::Cylinder {
            base: Point3::new(7.0, 20.0 + by, -10.0),
            radius: 47.0,
            height: 30.0,
        };
        let found = clearance(&path, &ball, &[solid], 0.0);
        let least = found.least.unwrap();
        assert!((least.distance - by).abs() < TOLERANCE, "{least:?}");
        assert_eq!(found.near.len(), usize::from(by < 0.0));
    }
}

/// Rapid moves are run as each axis runs at its own speed, too.
#[test]
fn rapid_axes_at_their_own_speeds_do_not_run_straight() {
    let flat = cutter(CutterKind::Flat, 3.0, 0.0, vec![]);
    let hits = |speed_of_x: f64| {
        let mut machine = shop::machine(Layout::TableHead);
        machine.axes[0].rapid = speed_of_x;
        let kinematics = Kinematics::new(&machine, &shop::setup(Layout::TableHead));
        let axes = AxisWords::of(&machine).unwrap();
        let options = ReadOptions::new(Dialect::LinuxCnc, axes, 5);
        let program = read::read("G21 G90 G94\nG0 Z-1\nG0 X40 Y10\nM2\n", &options).unwrap();
        let input = CheckInput::program(&program, &kinematics, &flat);
        // Straight, Y is 2.5 where X is 10; at the same speed Y is there before X is.
        let [low, high] = [Point3::new(9.0, 8.0, -5.0), Point3::new(11.0, 9.0, 0.0)];
        let fixture = Fixture::new(&Solid::Box { low, high }, 1e-4).unwrap();
        let watch = ClearanceOptions::within(1e-3);
        verify::clearance(&input, &[fixture], &watch, &Silent).unwrap().near
    };
    assert_eq!(hits(4.0 * 500.0), []);
    assert!(matches!(hits(500.0)[..], [hit] if hit.line == 3));
}

#[test]
fn what_triangles_may_be_off_is_added() {
    let flat = cutter(CutterKind::Flat, 4.0, 0.0, vec![]);
    let file = file(&[upright(0.0, 0.0, 0.0), upright(9.0, 0.0, 0.0)]);
    let input = CheckInput::locations(&file, &flat);
    let [low, high] = [Point3::new(-9.0, -9.0, -9.0), Point3::new(20.0, 9.0, -0.02)];
    let solid = Solid::Box { low, high };
    let watch = ClearanceOptions::within(1e-3);
    for (allowance, lines) in [(0.01, 0), (0.03, 1)] {
        let fixture = Fixture::new(&solid, 1e-4).unwrap().grown(allowance);
        let found = verify::clearance(&input, &[fixture], &watch, &Silent).unwrap();
        assert!((found.least.unwrap().distance - (0.02 - allowance)).abs() < 1e-3);
        assert_eq!(found.near.len(), lines);
    }
}

#[test]
fn a_fixture_that_is_not_closed_is_refused() {
    let corners = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 9.0]];
    let corners = corners.map(Point3::from).to_vec();
    let open = Mesh { vertices: corners, triangles: vec![[0, 1, 2], [0, 1, 3], [0, 2, 3]] };
    let error = Fixture::new(&Solid::Mesh(open), 1e-3).unwrap_err().to_string();
    assert!(error.contains("not closed"), "{error}");
}
