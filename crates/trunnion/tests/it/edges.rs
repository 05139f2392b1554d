//! Tools that go down beside a wall: what they take off it counts, and not how deep they go down beside the next face.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Unit, Vector3};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::nc::read::{ClFile, ClMotion, ClPath, ClRecord};
use trunnion::surface::{Face, NurbsSurface, Surface, TrimCurve, TrimLoop};
use trunnion::types::{Silent, ToolPose};
use trunnion::verify::{
    self, BoundMargins, BoundOptions, CheckInput, CheckOptions, DeviationTolerance, Report,
};

const RADIUS: f64 = 4.0;

/// Returns a plane face with corners at `origin`, and at `along` and `across` from there, trimmed all round.
fn plane(number: usize, origin: [f64; 3], along: [f64; 3], across: [f64; 3]) -> Face {
    let all = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
    plane_within(number, [origin, along, across], &[&all])
}

/// Returns a plane face within loops, by shares of both directions.
fn plane_within(
    number: usize,
    [origin, along, across]: [[f64; 3]; 3],
    loops: &[&[[f64; 2]]],
) -> Face {
    let at = |i: f64, j: f64| {
        Point3::from(origin) + Vector3::from(along) * i + Vector3::from(across) * j
    };
    let rows = [0.0, 1.0].map(|i| [0.0, 1.0].map(|j| at(i, j)).to_vec()).to_vec();
    let knots = vec![0.0, 0.0, 1.0, 1.0];
    let surface = NurbsSurface::new([1, 1], [knots.clone(), knots], rows, None).unwrap();
    let trim = |corners: &&[[f64; 2]]| {
        let border = TrimCurve::polyline(corners).unwrap();
        TrimLoop::new(vec![border], [None, None], 1e-9).unwrap()
    };
    Face::new(number, Surface::Nurbs(surface), loops.iter().map(trim).collect()).unwrap()
}

/// Returns the top of a block, which looks up and ends at x = 0, and its wall, which looks along x.
fn block() -> [Face; 2] {
    [
        plane(1, [-12.0, -10.0, 0.0], [12.0, 0.0, 0.0], [0.0, 20.0, 0.0]),
        plane(2, [0.0, -10.0, -8.0], [0.0, 20.0, 0.0], [0.0, 0.0, 8.0]),
    ]
}

fn path(points: &[[f64; 3]]) -> ClFile {
    let record = |(line, tip): (u32, &[f64; 3])| {
        let pose = ToolPose { tip: Point3::from(*tip), axis: Vector3::z_axis() };
        ClRecord { line, pose, motion: ClMotion::Feed(10.0), way: ClPath::Straight }
    };
    ClFile { records: (1..).zip(points).map(record).collect(), ..ClFile::default() }
}

/// Returns the path of a flat end mill along the wall, which it overcuts by `depth`, up and down twice on its way.
fn along_the_wall(depth: f64) -> ClFile {
    let x = RADIUS - depth;
    let at = |y: f64, z: f64| [x, y, z];
    path(&[
        at(-16.0, -8.0),
        at(-3.0, -8.0),
        at(-3.0, 6.0),
        at(1.7, 6.0),
        at(1.7, -8.0),
        at(16.0, -8.0),
    ])
}

fn check(faces: &[Face], file: &ClFile, grid: f64) -> Report {
    check_with(CutterSpec::of_radii(RADIUS, 0.0), faces, file, grid)
}

fn check_with(spec: CutterSpec, faces: &[Face], file: &ClFile, grid: f64) -> Report {
    let cutter = Cutter::new(CutterSpec { length: 60.0, ..spec }).unwrap();
    let input = CheckInput::locations(file, &cutter).faces(faces);
    let options = CheckOptions {
        ray_tolerance: 1e-5,
        bounds: Some(BoundOptions::within(BoundMargins::both(1e-3))),
        ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.02, gouge: 0.002 }, grid)
    };
    verify::check(&input, &options, &Silent).unwrap()
}

#[test]
fn beside_a_wall_a_gouge_is_as_deep_as_the_wall_is_overcut() {
    for depth in [0.0, 0.0008, 0.01, 0.03] {
        for grid in [0.7, 2.0] {
            for faces in [&block()[..], &block()[..1]] {
                let report = check(faces, &along_the_wall(depth), grid);
                let Some(bounds) = report.deviation.bounds else { panic!("no bounds") };
                let named = format!("{depth} on {} faces, every {grid}", faces.len());
                // Beyond the tolerance of 0.002 mm the first digits suffice: a tenth of the excess.
                let margin = 2e-3 + 0.1 * (depth - 0.002).max(0.0);
                assert!(bounds.gouge <= depth + margin, "{named}: {}", bounds.gouge);
                assert!(bounds.open <= 0.0, "{named}: {} open", bounds.open);
                let lowest = report.deviation.lowest.map_or(0.0, |lowest| lowest.height);
                assert!(lowest >= -depth - 2e-5, "{named}: {lowest}");
                if faces.len() == 2 {
                    assert!((lowest.min(0.0) + depth).abs() <= 2e-5, "{named}: {lowest}");
                }
            }
        }
    }
}

/// A flat end comes down beside a wall that it touches, to the plane of the face below, in a slot of that face. Over the slot
/// its distance from the plane changes little with time, and not with the place: cut into ever shorter times, a tenth of
/// these rows took half a minute, and the moves of a bored hole filled the memory.
#[test]
fn an_end_that_comes_to_the_plane_of_the_face_below_is_bounded() {
    let below = [[-12.0, -10.0, -8.0], [0.0, 20.0, 0.0], [24.0, 0.0, 0.0]];
    let around = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
    let slot = [[0.1, 0.5], [0.1, 0.9], [0.9, 0.9], [0.9, 0.5], [0.1, 0.5]];
    let [_, wall] = block();
    let faces = [wall, plane_within(3, below, &[&around, &slot])];
    let rows = (0..160_i32).flat_map(|row| {
        let z = -8.0 + 1e-2 * f64::from(159 - row);
        let y = if row % 2 == 0 { 3.5 } else { -3.5 };
        [[RADIUS, -y, z], [RADIUS, y, z - 1e-2]]
    });
    let report = check(&faces, &path(&rows.collect::<Vec<_>>()), 0.7);
    let bounds = report.deviation.bounds.unwrap();
    assert!(bounds.gouge <= 1.1e-3, "{}", bounds.gouge);
    assert!(bounds.open <= 0.0, "{} open", bounds.open);
}

/// The tool stands over the edge and 0.05 mm too deep, or cuts a groove across the face from its border on.
#[test]
fn a_gouge_that_goes_on_beyond_the_edge_is_as_deep_as_the_tool_comes() {
    let over_the_edge = path(&[[2.0, -16.0, -0.05], [2.0, 16.0, -0.05]]);
    let groove = path(&[[8.0, 1.0, -0.3], [-5.0, 1.0, -0.3]]);
    for (file, depth) in [(over_the_edge, 0.05), (groove, 0.3)] {
        let report = check(&block()[..1], &file, 0.5);
        let lowest = report.deviation.lowest.unwrap().height;
        assert!((lowest + depth).abs() <= 2e-5, "{lowest} in place of {}", -depth);
        assert!(report.deviation.bounds.unwrap().gouge >= depth);
    }
}

/// A ball that rocks cuts the top beside its edge deeper than the width of the border, so that it goes through the material
/// behind the wall: it gouges the points of the wall that it holds, and no others. Searched piece by piece until each is too
/// small, the others had no end.
#[test]
fn a_tool_that_goes_through_the_material_behind_a_wall_gouges_what_it_holds_of_the_wall() {
    let swaying = [0.0, 2.52, 2.73, 0.42, -2.27, -2.88, 0.0, 2.5, 2.7, 0.4, -2.3, -2.9_f64];
    let records = (1..).zip(swaying).map(|(line, lean): (u32, f64)| {
        let row = if line <= 6 { -1.4 } else { -0.8 };
        let along = f64::from(if line <= 6 { line } else { 13 - line });
        // The machine turns the tool about a point far above: the tip goes aside, and down.
        let turn = lean.to_radians();
        let tip = Point3::new(row, 3.0 * along - 10.0 + 50.0 * turn, -0.15 - 0.03 * lean);
        let pose = ToolPose { tip, axis: Unit::new_normalize(Vector3::new(0.0, -turn, 1.0)) };
        ClRecord { line, pose, motion: ClMotion::Feed(10.0), way: ClPath::Straight }
    });
    let file = ClFile { records: records.collect(), ..ClFile::default() };
    let ball = CutterSpec::of_radii(0.0, RADIUS);
    let report = check_with(ball, &block(), &file, 0.2);
    let bounds = report.deviation.bounds.unwrap();
    let lowest = -report.deviation.lowest.unwrap().height;
    assert!(lowest > 0.2, "{lowest}");
    assert!((lowest..=1.15 * lowest).contains(&bounds.gouge), "{} of {lowest}", bounds.gouge);
    let wall = &report.maps[1];
    let held = wall.samples.iter().flatten().filter_map(|sample| sample.height);
    let gouged = held.filter(|height| *height < -0.002).count();
    assert!(gouged > 20, "{gouged}");
}

/// Every point of the map by brute force: at the border by the distance inside the cylinder, elsewhere by the depth.
#[test]
fn heights_at_a_border_are_distances_inside_the_tool() {
    let depth = 0.06;
    let report = check(&block()[..1], &along_the_wall(depth), 0.013);
    let mut at_border = 0;
    for sample in report.maps[0].samples.iter().flatten() {
        let Some(height) = sample.height.filter(|height| *height < 0.0) else { continue };
        // Below the top the axis of the tool is at x = 4 - depth, and at all y but those between -3 and 1.7.
        let y = sample.point.y;
        let axis = if y <= -3.0 || y >= 1.7 { y } else { [-3.0, 1.7][usize::from(y > -0.65)] };
        let inside = RADIUS - (RADIUS - depth - sample.point.x).hypot(y - axis);
        assert!(inside > -1e-6 && (height + inside).abs() < 5e-5, "{sample:?}");
        at_border += 1;
    }
    assert!(at_border > 100, "{at_border}");
}
