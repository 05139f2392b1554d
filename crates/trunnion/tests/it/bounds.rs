//! What is promised between the measured points, against dense measuring elsewhere.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Rotation3, Unit, Vector3};
use trunnion::cutter::{Cutter, CutterKind, CutterSpec};
use trunnion::nc::read::{ClFile, ClMotion, ClPath, ClRecord};
use trunnion::surface::{
    ExtrusionSurface, Face, NurbsCurve, NurbsSurface, RevolutionSurface, SpaceCurve, Surface,
    TrimCurve, TrimLoop,
};
use trunnion::types::{Silent, ToolPose};
use trunnion::verify::{
    self, BoundMargins, BoundOptions, CheckInput, CheckOptions, Deviation, DeviationTolerance,
    Finding,
};

const RADIUS: f64 = 4.0;

fn patch(loops: Vec<TrimLoop>) -> Face {
    let row = |i: i32| {
        let point = |j: i32| {
            let [x, y] = [f64::from(i) - 1.5, f64::from(j) - 1.5];
            Point3::new(4.0 * x, 4.0 * y, 0.3 * x * x - 0.25 * y * y + 0.1 * x * y)
        };
        (0..4).map(point).collect()
    };
    let knots = || vec![0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0];
    let surface =
        NurbsSurface::new([2, 2], [knots(), knots()], (0..4).map(row).collect(), None).unwrap();
    Face::new(1, Surface::Nurbs(surface), loops).unwrap()
}

fn cutter(kind: CutterKind) -> Cutter {
    let length = 60.0;
    let (major, minor) = if kind == CutterKind::Ball { (0.0, RADIUS) } else { (RADIUS, 0.0) };
    Cutter::new(CutterSpec { kind, length, ..CutterSpec::of_radii(major, minor) }).unwrap()
}

/// A profile with a bend that jumps, extruded.
fn extruded() -> Face {
    let points = [[-6.0, 0.0, 0.4], [-2.0, 0.0, 0.0], [2.0, 0.0, 0.3], [6.0, 0.0, 0.2]];
    let knots = vec![0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0];
    let curve = NurbsCurve::new(2, knots, &points.map(Point3::from), None).unwrap();
    let surface =
        ExtrusionSurface::new(SpaceCurve::Nurbs(curve), Vector3::new(0.0, 2.0, 0.1)).unwrap();
    Face::new(1, Surface::Extrusion(surface), vec![rectangle([0.0, 1.0], [-3.0, 3.0])]).unwrap()
}

/// An arc of a rational profile, turned about an axis.
fn revolved() -> Face {
    let points = [[12.0, 0.0, -5.0], [10.0, 0.0, 0.0], [12.5, 0.0, 5.0]];
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let weights = Some(&[1.0, 0.8, 1.0][..]);
    let curve = NurbsCurve::new(2, knots, &points.map(Point3::from), weights).unwrap();
    let surface =
        RevolutionSurface::new(SpaceCurve::Nurbs(curve), Point3::origin(), Vector3::z_axis())
            .unwrap();
    let trim = rectangle([0.5, 1.3], [0.0, 1.0]);
    Face::new(1, Surface::Revolution(surface), vec![trim]).unwrap()
}

fn rectangle([a, b]: [f64; 2], [c, d]: [f64; 2]) -> TrimLoop {
    let corners = [[a, c], [b, c], [b, d], [a, d], [a, c]];
    TrimLoop::new(vec![TrimCurve::polyline(&corners).unwrap()], [None, None], 1e-9).unwrap()
}

/// A ball over a point of a face, leaning.
fn ball(face: &Face, [u, v]: [f64; 2], [lean, lift]: [f64; 2]) -> ToolPose {
    let n = face.normal(u, v).unwrap();
    let lean = Rotation3::from_axis_angle(&Vector3::y_axis(), lean);
    let axis = Unit::new_normalize(lean * n.into_inner());
    let centre = face.point(u, v) + n.into_inner() * (RADIUS + lift);
    ToolPose { tip: centre - axis.into_inner() * RADIUS, axis }
}

/// A flat end mill touching a point of a face with its edge.
fn edge(face: &Face, [u, v]: [f64; 2], [lean, lift]: [f64; 2]) -> ToolPose {
    let n = face.normal(u, v).unwrap().into_inner();
    let axis = Unit::new_normalize(Rotation3::from_axis_angle(&Vector3::x_axis(), lean) * n);
    let out = (axis.into_inner() * n.dot(&axis) - n).normalize();
    ToolPose { tip: face.point(u, v) + n * lift - out * RADIUS, axis }
}

/// Rows over a face, leaning, 0.6 mm apart; `deeper` at one place between grid points.
fn rows(face: &Face, deeper: f64) -> ClFile {
    rows_of(face, deeper, ball)
}

fn rows_of(face: &Face, deeper: f64, pose: fn(&Face, [f64; 2], [f64; 2]) -> ToolPose) -> ClFile {
    let mut records = Vec::new();
    let at =
        |k: usize, share: f64| face.bounds()[k].low * (1.0 - share) + face.bounds()[k].high * share;
    let mut line = 0;
    for row in 0..=21 {
        for step in 0..=30 {
            let [u, v] = [f64::from(row) / 20.0 - 0.025, f64::from(step) / 30.0];
            let v = if row % 2 == 0 { v } else { 1.0 - v };
            let lift = if row == 9 && step == 13 { -deeper } else { 0.001 };
            let pose = pose(face, [at(0, u), at(1, v)], [0.3 + 0.1 * v, lift]);
            line += 1;
            records.push(ClRecord {
                line,
                pose,
                motion: ClMotion::Feed(10.0),
                way: ClPath::Straight,
            });
        }
    }
    ClFile { records, ..ClFile::default() }
}

fn measure(face: &Face, file: &ClFile, grid: f64, promise: Option<BoundOptions>) -> Deviation {
    measure_with(&cutter(CutterKind::Ball), (face, file), grid, promise)
}

fn measure_with(
    cutter: &Cutter,
    (face, file): (&Face, &ClFile),
    grid: f64,
    promise: Option<BoundOptions>,
) -> Deviation {
    let faces = std::slice::from_ref(face);
    let input = CheckInput::locations(file, cutter).faces(faces);
    let options = CheckOptions {
        reach: 1.0,
        ray_tolerance: 1e-5,
        most_points: 1_000_000,
        bounds: promise,
        ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.05, gouge: 0.002 }, grid)
    };
    verify::check(&input, &options, &Silent).unwrap().deviation
}

const PROMISE: BoundOptions = BoundOptions::within(BoundMargins::both(1e-3));

fn heights(deviation: &Deviation) -> [f64; 2] {
    [deviation.lowest.unwrap().height, deviation.highest.unwrap().height]
}

#[test]
fn bounds_hold_on_a_finer_grid_and_are_near() {
    let face = patch(Vec::new());
    for deeper in [0.0, 0.004] {
        let file = rows(&face, deeper);
        let coarse = measure(&face, &file, 0.37, Some(PROMISE));
        let bounds = coarse.bounds.unwrap();
        let [lowest, highest] = heights(&measure(&face, &file, 0.07, None));
        assert!(bounds.open <= 0.0, "{bounds:?}");
        assert!(lowest >= -bounds.gouge - 1e-5, "{lowest} {bounds:?}");
        let excess = bounds.excess.unwrap();
        assert!(highest <= excess + 1e-5, "{highest} {bounds:?}");
        // Near the truth, which the fine grid nearly sees.
        assert!(bounds.gouge <= -lowest.min(0.0) + 1.2e-3, "{lowest} {bounds:?}");
        assert!(excess <= highest + 1.2e-3, "{highest} {bounds:?}");
        if deeper > 0.0 {
            assert!(bounds.gouge > 0.0035, "{bounds:?}");
        }
    }
}

/// Where a dent lies between the points, either its bound keeps the tolerance or a place beyond it is found, however
/// wide the margin.
#[test]
fn a_dent_between_the_points_is_found_or_bounded_within_the_tolerance() {
    let face = patch(Vec::new());
    for (exact, deeper, found) in [
        (1e-5, 0.0019, false),
        (1e-5, 0.0025, true),
        (1e-5, 0.008, true),
        (2.5e-4, 0.0019, false),
        (2.5e-4, 0.003, true),
        (2.5e-4, 0.008, true),
    ] {
        let file = rows(&face, deeper);
        let (file, cutter) = (&file, &cutter(CutterKind::Ball));
        let faces = std::slice::from_ref(&face);
        let input = CheckInput::locations(file, cutter).faces(faces);
        let options = CheckOptions {
            reach: 1.0,
            ray_tolerance: exact,
            most_points: 1_000_000,
            bounds: Some(BoundOptions::within(BoundMargins::both(8e-3))),
            ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.05, gouge: 0.002 }, 0.9)
        };
        let dented = verify::check(&input, &options, &Silent).unwrap().deviation;
        let (gouge, bounds) = (-heights(&dented)[0], dented.bounds.unwrap());
        assert!(bounds.open <= 0.0, "{bounds:?}");
        // The bound may stay beyond by a twentieth of the margin, or twice what is measured inexactly.
        let beyond = 4e-4f64.max(2.0 * exact);
        assert!(
            if found { gouge > 0.002 } else { bounds.gouge <= 0.002 + beyond },
            "{gouge} {bounds:?}"
        );
        assert!(bounds.gouge >= deeper - 1e-5 && gouge <= deeper + 1e-5, "{gouge} {bounds:?}");
    }
}

/// Bounds hold on a finer grid, are within `near` \[mm\] of it, and leave nothing open.
fn bound(cutter: &Cutter, face: &Face, file: &ClFile, near: f64) {
    let bounds = measure_with(cutter, (face, file), 0.37, Some(PROMISE)).bounds.unwrap();
    let [lowest, highest] = heights(&measure_with(cutter, (face, file), 0.07, None));
    assert!(bounds.open <= 0.0, "{bounds:?}");
    let excess = bounds.excess.unwrap();
    assert!(
        lowest >= -bounds.gouge - 1e-5 && highest <= excess + 1e-5,
        "{lowest} {highest} {bounds:?}"
    );
    assert!(bounds.gouge <= -lowest.min(0.0) + 1.2e-3, "{lowest} {bounds:?}");
    assert!(excess <= highest + near, "{highest} {bounds:?}");
}

#[test]
fn extruded_and_revolved_faces_are_bounded() {
    for face in [extruded(), revolved()] {
        for deeper in [0.0, 0.004] {
            bound(&cutter(CutterKind::Ball), &face, &rows(&face, deeper), 1.2e-3);
        }
    }
}

#[test]
fn what_a_sharp_edge_leaves_is_bounded() {
    let face = patch(Vec::new());
    // Ridges as steep as the tool leans, half a diagonal of the fine grid off its points.
    bound(&cutter(CutterKind::Flat), &face, &rows_of(&face, 0.0, edge), 1.2e-3 + 0.05 * 0.4);
}

#[test]
fn beyond_a_trim_nothing_counts() {
    // The gouge and the rim of the patch are cut away.
    let corners = [[0.55, 0.1], [0.9, 0.15], [0.85, 0.9], [0.5, 0.8], [0.55, 0.1]];
    let trim = TrimLoop::new(vec![TrimCurve::polyline(&corners).unwrap()], [None, None], 1e-9);
    let face = patch(vec![trim.unwrap()]);
    let file = rows(&patch(Vec::new()), 0.02);
    let trimmed = measure(&face, &file, 0.37, Some(PROMISE)).bounds.unwrap();
    let [lowest, highest] = heights(&measure(&face, &file, 0.07, None));
    assert!(trimmed.open <= 0.0, "{trimmed:?}");
    assert!(trimmed.gouge <= -lowest.min(0.0) + 1.2e-3, "{lowest} {trimmed:?}");
    assert!(highest <= trimmed.excess.unwrap() + 1e-5, "{highest} {trimmed:?}");
    // The rim itself lies between the points of the fine grid.
    assert!(trimmed.excess.unwrap() <= highest + 3e-3, "{highest} {trimmed:?}");
}

#[test]
fn a_promise_is_the_same_on_one_and_two_threads() {
    let face = patch(Vec::new());
    let file = rows(&face, 0.004);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| measure(&face, &file, 0.37, Some(PROMISE)))
    };
    assert_eq!(on(1), on(2));
}

/// With room for much excess and little gouge, rows that only touch do not gouge, and a dent does.
#[test]
fn a_small_gouge_counts_where_much_may_stand() {
    let face = patch(Vec::new());
    let cutter = cutter(CutterKind::Ball);
    for (deeper, gouges) in [(0.0, 0), (0.004, 1)] {
        let file = rows(&face, deeper);
        let faces = std::slice::from_ref(&face);
        let input = CheckInput::locations(&file, &cutter).faces(faces);
        let options = CheckOptions::of_tolerance(
            trunnion::verify::DeviationTolerance { excess: 0.9, gouge: 0.002 },
            0.9,
        );
        let report = verify::check(&input, &options, &Silent).unwrap();
        let found = report.findings.iter().filter(|f| matches!(f, Finding::Gouge(_)));
        assert_eq!(found.count(), gouges, "{:?}", report.findings);
    }
}

/// A flat end runs along a wall, 3 um from it: the points at its foot are beside the tool, and finished within the
/// tolerance. Over widths, so that rows of the grid at the foot are measured alone and with others.
#[test]
fn points_just_beside_a_flat_end_are_finished() {
    let cutter = cutter(CutterKind::Flat);
    for width in [7.6, 7.8, 8.0] {
        let corner = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let net = [0.0, 30.0].map(|x| vec![corner(x, 0.0), corner(x, width)]).to_vec();
        let knots = || vec![0.0, 0.0, 1.0, 1.0];
        let surface = NurbsSurface::new([1, 1], [knots(), knots()], net, None).unwrap();
        let faces = [Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()];
        let ends = [-5.0, 35.0].into_iter().zip(1..);
        let records = ends.map(|(x, line)| ClRecord {
            line,
            pose: ToolPose {
                tip: Point3::new(x, width - RADIUS - 0.003, 0.001),
                axis: Vector3::z_axis(),
            },
            motion: ClMotion::Feed(10.0),
            way: ClPath::Straight,
        });
        let file = ClFile { records: records.collect(), ..ClFile::default() };
        let input = CheckInput::locations(&file, &cutter).faces(&faces);
        let tolerance = DeviationTolerance { excess: 0.02, gouge: 0.002 };
        let report =
            verify::check(&input, &CheckOptions::of_tolerance(tolerance, 0.2), &Silent).unwrap();
        assert_eq!(report.deviation.uncut, 0, "{width}");
    }
}
