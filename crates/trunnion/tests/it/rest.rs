//! What the tool cannot reach is left and told, and nothing of the part is cut on the way.
//!
//! The oracle takes the curves that the tool path follows, and for points of all faces the least signed distance to
//! the cutter, in closed form.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::swept_tool;

use nalgebra::{Point3, Vector3};
use swept_tool::{SPACING, distance, poses};
use trunnion::cover::{
    CoverError, CoverOptions, CoverRequest, Covering, FeedDirection, FinishTolerance, LeftArea,
    LengthCost, PassCost, PassLayout, PlacementMethod, PrismaticUse, cover,
};
use trunnion::cutter::{Cutter, CutterKind, CutterSpec};
use trunnion::positioning::{ToleranceBand, ToolInclination};
use trunnion::surface::{
    CylinderSurface, Face, FaceIndex, PlaneSurface, SphereSurface, Surface, SurfaceFrame,
    TorusSurface, TrimCurve, TrimLoop,
};
use trunnion::types::{Interval, Pass, Silent, Station, ToolPose, UncutReason, UncutRegion};

const BAND: ToleranceBand = ToleranceBand { lower: 0.0, upper: 0.02 };
const SHARE: f64 = 0.002;

/// What poses [`SPACING`] apart may miss over a corner of 1 mm \[mm\].
const SAMPLING: f64 = 0.5 * (0.5 * SPACING) * (0.5 * SPACING);

fn cutter([major, minor]: [f64; 2]) -> Cutter {
    let kind = match (major > 0.0, minor > 0.0) {
        (false, _) => CutterKind::Ball,
        (_, false) => CutterKind::Flat,
        _ => CutterKind::Bull,
    };
    let spec = CutterSpec { kind, length: 60.0, ..CutterSpec::of_radii(major, minor) };
    Cutter::new(spec).unwrap()
}

fn options(method: PlacementMethod) -> CoverOptions {
    CoverOptions {
        feed_direction: FeedDirection::V,
        method,
        band: BAND,
        link: 25.0,
        path_share: SHARE,
        spacing: Interval::new(0.02, 1.0),
        max_axis_turn: 0.1,
        offset_range: Interval::new(-0.5, 0.5),
        lean: ToolInclination { angle: 0.087, towards: None },
        ..CoverOptions::finishing(
            &cutter([4.0, 1.0]),
            FinishTolerance { excess: BAND.upper, gouge: -BAND.lower },
        )
    }
}

/// Finishing within 0.0165 mm, leaning by 10 degrees.
fn finishing() -> CoverOptions {
    CoverOptions {
        band: ToleranceBand { lower: 0.0015, upper: 0.0165 },
        path_share: 0.001,
        lean: ToolInclination { angle: 0.175, towards: None },
        ..options(PlacementMethod::Inclined)
    }
}

fn face(number: usize, surface: Surface, corners: &[[f64; 2]], flip: bool) -> FaceIndex {
    let closed: Vec<_> = corners.iter().chain(corners.first()).copied().collect();
    let curve = TrimCurve::polyline(&closed).unwrap();
    let trim = TrimLoop::new(vec![curve], [None, None], 1e-9).unwrap();
    FaceIndex::new(Face { flip, ..Face::new(number, surface, vec![trim]).unwrap() }).unwrap()
}

fn plane(origin: Point3<f64>, z: Vector3<f64>, x: Vector3<f64>) -> Surface {
    Surface::Plane(PlaneSurface { frame: SurfaceFrame::new(origin, z, x).unwrap() })
}

/// The floor z = 0 between x = 0 and a wall through (20, 0) that leans by `slope` in x over y, y in 0..12.
fn floor(slope: f64) -> FaceIndex {
    let floor = plane(Point3::origin(), Vector3::z(), Vector3::x());
    let end = 20.0 + 12.0 * slope;
    face(1, floor, &[[0.0, 0.0], [20.0, 0.0], [end, 12.0], [0.0, 12.0]], false)
}

/// The wall on its far side, 12 mm high, and on both sides 4 mm longer.
fn wall(slope: f64) -> FaceIndex {
    let along = Vector3::new(slope, 1.0, 0.0).normalize();
    let surface = plane(Point3::new(20.0, 0.0, 0.0), along.cross(&Vector3::z()), along);
    face(2, surface, &[[-4.0, 0.0], [20.0, 0.0], [20.0, 12.0], [-4.0, 12.0]], true)
}

/// Points of a face, `n` ways across its box, with the distance that any pose comes near.
fn measured(face: &FaceIndex, poses: &[ToolPose], cutter: &Cutter, n: u32) -> Vec<([f64; 2], f64)> {
    let bounds = face.face().bounds();
    let at = |k: usize, i: u32| {
        let Interval { low, high } = bounds[k];
        low + (high - low) * (f64::from(i) + 0.5) / f64::from(n)
    };
    let places = (0..n * n).map(|i| [at(0, i / n), at(1, i % n)]);
    places
        .filter(|[u, v]| face.face().contains(*u, *v))
        .map(|[u, v]| {
            let p = face.face().point(u, v);
            let left = poses.iter().map(|q| distance(&p, q, cutter)).fold(f64::INFINITY, f64::min);
            ([u, v], left)
        })
        .collect()
}

/// Everything beyond the tolerance lies in a part that is told, nothing is cut too deep, and what is told is hardly
/// larger than what is left.
fn agrees(
    covering: &Covering,
    (face, others): (&FaceIndex, &[FaceIndex]),
    cutter: &Cutter,
) -> Vec<UncutRegion> {
    const N: u32 = 90;
    let poses = poses(&covering.passes, cutter);
    let rest = &covering.report.rest;
    let (mut left, mut told, mut both) = (0, 0, 0);
    for (uv, height) in measured(face, &poses, cutter, N) {
        assert!(height >= BAND.lower - SHARE, "gouge of {height} at {uv:?}");
        let held = rest.iter().any(|rest| rest.holds(uv.into()));
        let over = height > BAND.upper + SHARE + SAMPLING;
        assert!(held || !over, "{height} left at {uv:?}, in no part that is told");
        told += u32::from(held);
        left += u32::from(height > BAND.upper + SHARE);
        both += u32::from(held && height > BAND.upper + SHARE);
    }
    assert!(both <= left && f64::from(told) <= 1.05 * f64::from(left) + 12.0, "{told} of {left}");
    for other in others {
        for (uv, height) in measured(other, &poses, cutter, N) {
            let number = other.face().number;
            assert!(height >= BAND.lower - SHARE, "gouge of {height} on face {number} at {uv:?}");
        }
    }
    rest.clone()
}

fn beside_all(
    (faces, others): (&[FaceIndex], &[FaceIndex]),
    cutter: &Cutter,
    options: &CoverOptions,
) -> Result<Covering, CoverError> {
    let request = CoverRequest { others, ..CoverRequest::new(faces, cutter, options) };
    cover(&request, &Silent)
}

fn cut(
    (face, others): (&FaceIndex, &[FaceIndex]),
    cutter: &Cutter,
    options: &CoverOptions,
) -> (Covering, Vec<UncutRegion>) {
    let covering = beside_all((std::slice::from_ref(face), others), cutter, options).unwrap();
    let rest = agrees(&covering, (face, others), cutter);
    (covering, rest)
}

/// The side of the part below the far end of the floor, in a frame that is turned in its plane: its upper edge, which
/// it has in common with the floor, is no line of its parameters.
fn cliff(slope: f64) -> FaceIndex {
    let along = Vector3::new(slope, 1.0, 0.0).normalize();
    let out = along.cross(&Vector3::z());
    let (sin, cos) = 0.5_f64.sin_cos();
    let surface = plane(Point3::new(20.0, 0.0, 0.0), out, along * cos + Vector3::z() * sin);
    let turned = [[-4.0, 0.0], [20.0, 0.0], [20.0, -12.0], [-4.0, -12.0]]
        .map(|[x, z]: [f64; 2]| [x * cos + z * sin, z * cos - x * sin]);
    face(2, surface, &turned, false)
}

/// Width that stays beside a wall for a corner of radius `r`: from where its flank is `r` off the wall, the corner
/// still finishes `sqrt(2 r e)`.
fn beside(minor: f64) -> f64 {
    let e = BAND.upper + SHARE;
    minor - (2.0 * minor * e - e * e).sqrt()
}

/// A machine that gets to some poses only.
struct Fenced(fn(&ToolPose) -> bool);

impl PassCost for Fenced {
    fn feed(&self) -> f64 {
        1.0
    }

    fn pass(&self, stations: &[Station]) -> f64 {
        LengthCost { link: 25.0 }.pass(stations)
    }

    fn link(&self, _: &Station, _: &Station) -> f64 {
        25.0
    }

    fn reaches(&self, pose: &ToolPose) -> bool {
        (self.0)(pose)
    }
}

/// The ball leans otherwise than asked where the machine needs that, and what it gets to in no way is told.
#[test]
fn where_the_machine_does_not_get_to_nothing_is_cut() {
    let (floor, cutter) = (floor(0.2), cutter([0.0, 3.0]));
    let fenced = |cost: &Fenced| {
        let faces = std::slice::from_ref(&floor);
        let options = options(PlacementMethod::Inclined);
        let request =
            CoverRequest { cost: Some(cost), ..CoverRequest::new(faces, &cutter, &options) };
        let covering = cover(&request, &Silent).unwrap();
        let mut stations = covering.passes.iter().flat_map(|pass| &pass.stations);
        assert!(stations.all(|station| cost.reaches(&station.pose)));
        let rest = agrees(&covering, (&floor, &[]), &cutter);
        rest.iter().map(|rest| (rest.area, rest.reason)).collect::<Vec<_>>()
    };
    assert_eq!(fenced(&Fenced(|pose| pose.axis.x < -0.3)), []);
    let beyond = fenced(&Fenced(|pose| pose.tip.x < 14.0));
    assert!(beyond.iter().all(|(_, reason)| *reason == UncutReason::Machine), "{beyond:?}");
    // The floor is 12 mm wide and ends at x = 20 .. 22.4. The ball leans by up to 1.3 rad, touches that far from its tip,
    // and half its strip is beyond that.
    let reached = 14.0 + 3.0 * 1.3_f64.sin() + (2.0 * 3.0 * (BAND.upper + SHARE)).sqrt();
    let least = 12.0 * (21.2 - reached);
    let area: f64 = beyond.iter().map(|(area, _)| area).sum();
    assert!(area >= least && area < 1.2 * least, "{area} {least}");
}

#[test]
fn a_convex_edge_keeps_nothing_back() {
    for (radii, method) in
        [([0.0, 3.0], PlacementMethod::Inclined), ([4.0, 1.0], PlacementMethod::Widest)]
    {
        let cutter = cutter(radii);
        let (floor, sides) = (floor(0.2), [cliff(0.2)]);
        for along in [FeedDirection::V, FeedDirection::U] {
            let options = CoverOptions { feed_direction: along, ..options(method) };
            let (_, rest) = cut((&floor, &sides), &cutter, &options);
            let area: f64 = rest.iter().map(|rest| rest.area).sum();
            assert!(rest.is_empty(), "{radii:?} {along:?}: {area} mm2 in {} parts", rest.len());
        }
    }
}

#[test]
fn beside_a_wall_as_much_stays_as_the_corner_is_wide() {
    for (radii, method) in [
        ([0.0, 3.0], PlacementMethod::Inclined),
        ([0.0, 3.0], PlacementMethod::Widest),
        ([4.0, 1.0], PlacementMethod::Inclined),
        ([4.0, 1.0], PlacementMethod::Widest),
    ] {
        let cutter = cutter(radii);
        let (floor, walls) = (floor(0.0), [wall(0.0)]);
        for along in [FeedDirection::V, FeedDirection::U] {
            let options = CoverOptions { feed_direction: along, ..options(method) };
            let (_, rest) = cut((&floor, &walls), &cutter, &options);
            let expected = 12.0 * beside(radii[1]);
            let area: f64 = rest.iter().map(|rest| rest.area).sum();
            // A cutter that leans a little touches that much farther inside.
            let most = 1.04 * expected + 12.0 * 0.1 * radii[0];
            assert!(area >= 0.999 * expected && area <= most, "{area} {expected}");
            let ball = radii[0] <= 0.0;
            assert!(!ball || rest.len() == 1, "{} parts", rest.len());
            let part = &rest[0];
            // In the edge the corner's circle is (sqrt 2 - 1) r away; a little less where it is looked at.
            let deepest = (2f64.sqrt() - 1.0) * radii[1];
            assert!(part.depth <= deepest + 0.02 || !ball, "{}", part.depth);
            assert!(part.depth > 0.8 * deepest, "{}", part.depth);
            assert_eq!(part.reason, UncutReason::Neighbour(2));
            // A ball on the floor that touches the wall is as far from it as it is large.
            let u = part.deepest.u;
            assert!((part.ball - (20.0 - u)).abs() < 1e-3, "{} {u}", part.ball);
            assert!(
                part.balls.high <= beside(radii[1]) + 0.3 * radii[0] + 0.25,
                "{:?}",
                part.balls
            );
        }
    }
}

/// An upright tool on a floor finishes up to the wall in a few passes; a corner leaves its own width and no more.
#[test]
fn floor_passes_finish_up_to_the_wall() {
    for (radii, slope) in
        [([4.0, 0.0], 0.0), ([4.0, 0.0], 0.6), ([3.0, 1.0], 0.0), ([3.0, 1.0], 0.6)]
    {
        let cutter = cutter(radii);
        let (floor, walls) = (floor(slope), [wall(slope)]);
        let options = CoverOptions {
            prismatic: PrismaticUse::WallsAndFloors,
            ..options(PlacementMethod::Widest)
        };
        let (covering, rest) = cut((&floor, &walls), &cutter, &options);
        assert!(covering.report.layouts.iter().all(|face| face.layout == PassLayout::Floor));
        assert!(covering.passes.len() <= 6, "{} passes", covering.passes.len());
        let area: f64 = rest.iter().map(|rest| rest.area).sum();
        if radii[1] > 0.0 {
            let expected = 12.0 * slope.hypot(1.0) * beside(radii[1]);
            assert!(area >= 0.999 * expected && area <= 1.04 * expected, "{area} {expected}");
        } else {
            assert!(rest.is_empty(), "{area} are left");
        }
    }
}

/// A ball keeps its axis all over a floor, leans by the lead that is asked for, and leaves what its radius leaves.
#[test]
fn a_ball_keeps_its_axis_on_a_floor() {
    for slope in [0.0, 0.6] {
        let cutter = cutter([0.0, 3.0]);
        let (floor, walls) = (floor(slope), [wall(slope)]);
        let options = CoverOptions {
            prismatic: PrismaticUse::WallsAndFloors,
            ..options(PlacementMethod::Inclined)
        };
        let (covering, rest) = cut((&floor, &walls), &cutter, &options);
        assert_eq!(covering.report.layouts[0].layout, PassLayout::Floor);
        // Touches at single spots may lean another way.
        let axes: Vec<Vector3<f64>> = axes(&covering);
        let same = axes.iter().filter(|axis| (*axis - axes[0]).norm() < 1e-12).count();
        assert!(10 * same > 9 * axes.len(), "{same} of {}", axes.len());
        let lean = axes[0].z.acos();
        assert!((lean - options.lean.angle).abs() < 1e-9, "{lean}");
        let area: f64 = rest.iter().map(|rest| rest.area).sum();
        let expected = 12.0 * slope.hypot(1.0) * beside(3.0);
        assert!(area >= 0.999 * expected && area <= 1.04 * expected, "{area} {expected}");
    }
}

/// Returns the axes of all stations.
fn axes(covering: &Covering) -> Vec<Vector3<f64>> {
    let stations = covering.passes.iter().flat_map(|pass| &pass.stations);
    stations.map(|station| station.pose.axis.into_inner()).collect()
}

/// A fillet as wide as the tool, into which no rim fits, is finished by the corner with an axis that holds still.
#[test]
fn a_fillet_is_finished_at_a_fixed_axis() {
    let (floor, mut others) = floor_round_a_post();
    let foot = others.remove(0);
    others.push(floor);
    for radii in [[0.0, 3.0], [3.0, 1.0], [2.0, 2.0]] {
        let options = CoverOptions {
            prismatic: PrismaticUse::WallsAndFloors,
            ..options(PlacementMethod::Widest)
        };
        let (covering, rest) = cut((&foot, &others), &cutter(radii), &options);
        assert_eq!(covering.report.layouts[0].layout, PassLayout::FixedAxis, "{radii:?}");
        let axes: Vec<Vector3<f64>> = axes(&covering);
        let upright = axes.iter().filter(|axis| (axis.z - 1.0).abs() < 1e-12).count();
        assert!(10 * upright > 9 * axes.len(), "{upright} of {}", axes.len());
        let deepest = rest.iter().map(|rest| rest.depth).fold(0.0, f64::max);
        assert!(deepest <= BAND.upper + SHARE + SAMPLING, "{radii:?}: {deepest} in {}", rest.len());
    }
}

/// One pass of the flank finishes a wall down to the floor, and keeps off the floor.
#[test]
fn one_flank_pass_finishes_a_wall() {
    for radii in [[4.0, 0.0], [3.0, 1.0]] {
        let cutter = cutter(radii);
        let (wall, floors) = (wall(0.0), [floor(0.0)]);
        let options = CoverOptions {
            prismatic: PrismaticUse::WallsAndFloors,
            ..options(PlacementMethod::Widest)
        };
        let (covering, rest) = cut((&wall, &floors), &cutter, &options);
        assert_eq!(covering.report.layouts[0].layout, PassLayout::Flank);
        let area: f64 = rest.iter().map(|rest| rest.area).sum();
        if radii[1] > 0.0 {
            // Over the floor, 12 mm of the wall's 20, the corner leaves its own height.
            assert!(covering.passes.len() == 1 || area > 0.0);
            assert!(area <= 1.04 * 20.0 * beside(radii[1]), "{area}");
            assert!(area >= 0.999 * 12.0 * beside(radii[1]), "{area}");
        } else {
            assert!(covering.passes.len() == 1 && rest.is_empty(), "{area} are left");
        }
    }
}

#[test]
fn beside_a_wall_across_the_passes_no_more_stays() {
    let slope = 0.6;
    for radii in [[0.0, 3.0], [4.0, 1.0]] {
        let cutter = cutter(radii);
        let (floor, walls) = (floor(slope), [wall(slope)]);
        for along in [FeedDirection::V, FeedDirection::U] {
            let options =
                CoverOptions { feed_direction: along, ..options(PlacementMethod::Inclined) };
            let (_, rest) = cut((&floor, &walls), &cutter, &options);
            let expected = 12.0 * slope.hypot(1.0) * beside(radii[1]);
            let area: f64 = rest.iter().map(|rest| rest.area).sum();
            let most = 1.05 * expected + 14.0 * 0.16 * radii[0];
            assert!(area >= 0.999 * expected && area <= most, "{area} {expected}");
        }
    }
}

#[test]
fn a_groove_too_narrow_for_the_ball_is_refused_and_one_wide_enough_is_finished() {
    // A tube of 4 mm, a third of its round.
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::x(), Vector3::z()).unwrap();
    let tube = Surface::Cylinder(CylinderSurface::new(frame, 4.0).unwrap());
    let below = [[2.1, 0.0], [4.2, 0.0], [4.2, 10.0], [2.1, 10.0]];
    let tube = face(1, tube, &below, true);
    let faces = (std::slice::from_ref(&tube), &[][..]);
    let refused = beside_all(faces, &cutter([0.0, 5.0]), &options(PlacementMethod::Inclined));
    assert!(matches!(refused, Err(CoverError::NoPose { .. })), "{refused:?}");
    // The third that is there leaves a gap as wide as a tool of 3.46 mm: the larger one has to lean.
    for radius in [2.5, 3.5] {
        let (_, rest) =
            cut((&tube, &[]), &cutter([0.0, radius]), &options(PlacementMethod::Inclined));
        assert!(rest.is_empty(), "{radius} {rest:?}");
    }
}

/// The corner of a block whose edges are rounded with `r`: an eighth of a sphere, and the three cylinders and three planes
/// that go on smoothly from it.
fn rounded_corner(r: f64) -> (FaceIndex, Vec<FaceIndex>) {
    let quarter = std::f64::consts::FRAC_PI_2;
    let frame = |origin, z, x| SurfaceFrame::new(origin, z, x).unwrap();
    let (o, [x, y, z]) = (Point3::origin(), [Vector3::x(), Vector3::y(), Vector3::z()]);
    let sphere = Surface::Sphere(SphereSurface::new(frame(o, z, x), r).unwrap());
    let eighth = [[3.0, -1.0], [4.0, -1.0], [4.0, 0.0], [3.0, 0.0]].map(|p| p.map(|k| k * quarter));
    let edge = |number, z, x| {
        let surface = Surface::Cylinder(CylinderSurface::new(frame(o, z, x), r).unwrap());
        face(number, surface, &[[0.0, 0.0], [quarter, 0.0], [quarter, 9.0], [0.0, 9.0]], false)
    };
    let side = |number, out: Vector3<f64>, x| {
        let square = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]];
        face(number, plane(o + out * r, out, x), &square, false)
    };
    let edges = [edge(2, y, x), edge(3, -x, -z), edge(4, z, -y)];
    let sides = [side(5, x, y), side(6, -y, z), side(7, -z, -x)];
    (face(1, sphere, &eighth, false), edges.into_iter().chain(sides).collect())
}

/// The faces next to it bend less than the corner does: a cutter that touches the corner at its rim goes into them by less
/// than a micrometre, and is raised by as much.
#[test]
fn a_rounded_corner_is_finished_up_to_the_faces_next_to_it() {
    for (r, tool, lower) in [(5.0, [4.0, 2.0], 0.002), (3.0, [4.0, 2.0], 0.0)] {
        let (corner, others) = rounded_corner(r);
        let band = ToleranceBand { lower, upper: 0.016 };
        let options = CoverOptions { band, ..options(PlacementMethod::Widest) };
        let (_, rest) = cut((&corner, &others), &cutter(tool), &options);
        let area: f64 = rest.iter().map(|rest| rest.area).sum();
        assert!(rest.is_empty(), "{r} {tool:?} {lower}: {area} mm2 in {} parts", rest.len());
    }
}

/// The floor z = 0 round a post of radius 5 on a foot rounded with 4 mm, and these two.
fn floor_round_a_post() -> (FaceIndex, Vec<FaceIndex>) {
    use std::f64::consts::{FRAC_PI_2, TAU};
    let frame =
        |z: f64| SurfaceFrame::new(Point3::new(0.0, 0.0, z), Vector3::z(), Vector3::x()).unwrap();
    let loop_of = |corners: &[[f64; 2]]| {
        let closed: Vec<_> = corners.iter().chain(corners.first()).copied().collect();
        TrimLoop::new(vec![TrimCurve::polyline(&closed).unwrap()], [None, None], 1e-9).unwrap()
    };
    let ring: Vec<[f64; 2]> = (0..720)
        .map(|i| (TAU * f64::from(i) / 720.0).sin_cos())
        .map(|(sin, cos)| [9.0 * cos, 9.0 * sin])
        .collect();
    let square = [[-16.0, -16.0], [16.0, -16.0], [16.0, 16.0], [-16.0, 16.0]];
    let floor = plane(Point3::origin(), Vector3::z(), Vector3::x());
    let floor = Face::new(1, floor, vec![loop_of(&square), loop_of(&ring)]).unwrap();
    let foot = Surface::Torus(TorusSurface::new(frame(4.0), 9.0, 4.0).unwrap());
    let foot = face(
        2,
        foot,
        &[
            [0.0, 2.0 * FRAC_PI_2],
            [TAU, 2.0 * FRAC_PI_2],
            [TAU, 3.0 * FRAC_PI_2],
            [0.0, 3.0 * FRAC_PI_2],
        ],
        true,
    );
    let post = Surface::Cylinder(CylinderSurface::new(frame(0.0), 5.0).unwrap());
    let post = face(3, post, &[[0.0, 4.0], [TAU, 4.0], [TAU, 12.0], [0.0, 12.0]], false);
    (FaceIndex::new(floor).unwrap(), vec![foot, post])
}

/// Passes from edge to edge leave spots where the floor goes over into the foot; each is touched on its own.
#[test]
fn a_floor_is_finished_up_to_the_rounded_foot_of_a_post() {
    let (floor, others) = floor_round_a_post();
    let (_, rest) =
        cut((&floor, &others), &cutter([0.0, 3.0]), &options(PlacementMethod::Inclined));
    let deepest = rest.iter().map(|rest| rest.depth).fold(0.0, f64::max);
    assert!(deepest <= BAND.upper + SHARE + SAMPLING, "{deepest} in {} parts", rest.len());
}

/// The rounded corner of a box, an eighth of a sphere of 5 mm with its pole on top, and the fillets and the top beside it.
fn eighth_of_a_sphere() -> (FaceIndex, Vec<FaceIndex>) {
    use std::f64::consts::{FRAC_PI_2, PI};
    let frame = |z, x| SurfaceFrame::new(Point3::origin(), z, x).unwrap();
    let quarter = [[0.0, 0.0], [FRAC_PI_2, 0.0], [FRAC_PI_2, FRAC_PI_2], [0.0, FRAC_PI_2]];
    let sphere = SphereSurface::new(frame(Vector3::z(), Vector3::x()), 5.0).unwrap();
    let fillet = |number, axis: Vector3<f64>, x: Vector3<f64>, from: f64| {
        let surface = CylinderSurface::new(frame(axis, x), 5.0).unwrap();
        let to = from + FRAC_PI_2;
        let corners = [[from, -10.0], [to, -10.0], [to, 0.0], [from, 0.0]];
        face(number, Surface::Cylinder(surface), &corners, false)
    };
    let top = plane(Point3::new(0.0, 0.0, 5.0), Vector3::z(), Vector3::x());
    let others = vec![
        fillet(2, Vector3::z(), Vector3::x(), 0.0),
        fillet(3, Vector3::y(), Vector3::x(), 3.0 * FRAC_PI_2),
        fillet(4, Vector3::x(), -Vector3::y(), PI),
        face(5, top, &[[-10.0, -10.0], [0.0, -10.0], [0.0, 0.0], [-10.0, 0.0]], false),
    ];
    (face(1, Surface::Sphere(sphere), &quarter, false), others)
}

/// At the pole of a small sphere spots lie all round, and the tool cuts the corner between two of them.
#[test]
fn the_pole_of_a_rounded_corner_is_finished() {
    let (corner, others) = eighth_of_a_sphere();
    let options = CoverOptions { path_share: SHARE, ..finishing() };
    let (_, rest) = cut((&corner, &others), &cutter([0.0, 10.0]), &options);
    let area: f64 = rest.iter().map(|rest| rest.area).sum();
    assert!(rest.is_empty(), "{area} mm2 in {} parts", rest.len());
}

/// A quarter of a dome over a floor, 20 mm above the middle of its sphere of 40 mm; the floor goes on round it.
fn dome_on_a_floor() -> (FaceIndex, FaceIndex) {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let sphere = Surface::Sphere(SphereSurface::new(frame, 40.0).unwrap());
    let zone = [[0.0, FRAC_PI_6], [FRAC_PI_2, FRAC_PI_6], [FRAC_PI_2, FRAC_PI_2], [0.0, FRAC_PI_2]];
    let foot = 40.0 * FRAC_PI_6.cos();
    let around = (-10..=100_i32).map(|degree| f64::from(degree).to_radians().sin_cos());
    let inner: Vec<[f64; 2]> = around.map(|(sin, cos)| [foot * cos, foot * sin]).collect();
    let corners = [[-5.0, 70.0], [70.0, 70.0], [70.0, -5.0]];
    let floor = plane(Point3::new(0.0, 0.0, 20.0), Vector3::z(), Vector3::x());
    (face(1, sphere, &zone, false), face(2, floor, &[inner.as_slice(), &corners].concat(), false))
}

/// The edge of a flat end gets to the foot only straight up the slope, and touches it there: a pass a little above it, or at
/// an angle, leaves the foot.
#[test]
fn a_dome_is_finished_down_to_its_foot_by_few_passes() {
    let (dome, floor) = dome_on_a_floor();
    let options = CoverOptions { lean: options(PlacementMethod::Inclined).lean, ..finishing() };
    let faces = (std::slice::from_ref(&dome), std::slice::from_ref(&floor));
    let covering = beside_all(faces, &cutter([10.0, 0.0]), &options).unwrap();
    let rest = &covering.report.rest;
    let area: f64 = rest.iter().map(|rest| rest.area).sum();
    assert!(rest.is_empty(), "{area} mm2 in {} parts", rest.len());
    assert!(covering.passes.len() <= 70, "{} passes", covering.passes.len());
}

/// A ball of 6 mm that touches dome and floor has its centre at 26 of 46 mm, and finishes about 0.4 mm of the dome below its
/// contact. Lines of constant parameters end up to a strip above that, and lines across them would be hundreds of strokes.
#[test]
fn a_ball_goes_along_the_foot_of_a_dome() {
    let (dome, floor) = dome_on_a_floor();
    let options = finishing();
    let faces = (std::slice::from_ref(&dome), std::slice::from_ref(&floor));
    let covering = beside_all(faces, &cutter([0.0, 6.0]), &options).unwrap();
    let lowest = 40.0 * 26.0 / 46.0;
    let top = covering.report.rest.iter().map(|rest| rest.bounds[1].z).fold(0.0, f64::max);
    assert!(top < lowest - 0.25 && top > 20.0, "{top} of {lowest}");
    let contacts = covering.passes.iter().flat_map(|pass| &pass.stations);
    let least = contacts.map(|station| station.contact.z).fold(f64::INFINITY, f64::min);
    assert!((least - lowest).abs() < 0.02, "{least} of {lowest}");
    // The arc along the foot is 51 mm long.
    let along = |pass: &&Pass| {
        let ends = [&pass.stations[0], &pass.stations[pass.stations.len() - 1]];
        ends.iter().all(|station| station.contact.z < lowest + 0.4)
            && (ends[0].contact - ends[1].contact).norm() > 40.0
    };
    assert!(covering.passes.iter().any(|pass| along(&pass)), "no pass along the foot");
    assert!(covering.passes.len() <= 90, "{} passes", covering.passes.len());
}

/// A round floor of radius 32 round a post of radius 10, with the walls of both, 14 mm high.
fn floor_between_cylinders() -> (FaceIndex, Vec<FaceIndex>) {
    use std::f64::consts::TAU;
    let frame = || SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let circle = |radius: f64| {
        let around = (0..=720_i32).map(|half| f64::from(half).to_radians() / 2.0);
        let points: Vec<[f64; 2]> =
            around.map(|turn| [radius * turn.cos(), radius * turn.sin()]).collect();
        TrimLoop::new(vec![TrimCurve::polyline(&points).unwrap()], [None, None], 1e-9).unwrap()
    };
    let plane = Surface::Plane(PlaneSurface { frame: frame() });
    let floor = Face::new(1, plane, vec![circle(32.0), circle(10.0)]).unwrap();
    let wall = |number, radius, flip| {
        let surface = Surface::Cylinder(CylinderSurface::new(frame(), radius).unwrap());
        face(number, surface, &[[0.0, 0.0], [TAU, 0.0], [TAU, 14.0], [0.0, 14.0]], flip)
    };
    (FaceIndex::new(floor).unwrap(), vec![wall(2, 32.0, true), wall(3, 10.0, false)])
}

/// The centre of a tool of 20 mm has 2 mm between a wall and a post that are 22 mm apart: both borders of that ring are found.
#[test]
fn a_floor_barely_wider_than_the_tool_is_finished() {
    let (floor, walls) = floor_between_cylinders();
    let options = CoverOptions {
        prismatic: PrismaticUse::WallsAndFloors,
        ..options(PlacementMethod::Widest)
    };
    let (covering, rest) = cut((&floor, &walls), &cutter([10.0, 0.0]), &options);
    assert!(covering.report.layouts.iter().all(|face| face.layout == PassLayout::Floor));
    let area: f64 = rest.iter().map(|rest| rest.area).sum();
    assert!(rest.is_empty(), "{area} mm2 in {} parts", rest.len());
}

/// A rounded edge of 6 mm that stands upright on a floor, 30 mm long.
fn rounded_edge_on_a_floor() -> (FaceIndex, FaceIndex) {
    use std::f64::consts::FRAC_PI_2;
    let frame = SurfaceFrame::new(Point3::origin(), -Vector3::y(), Vector3::x()).unwrap();
    let edge = Surface::Cylinder(CylinderSurface::new(frame, 6.0).unwrap());
    let edge =
        face(1, edge, &[[0.0, 0.0], [FRAC_PI_2, 0.0], [FRAC_PI_2, 30.0], [0.0, 30.0]], false);
    let floor = plane(Point3::new(6.0, 0.0, 0.0), Vector3::z(), Vector3::x());
    (edge, face(2, floor, &[[0.0, -40.0], [40.0, -40.0], [40.0, 10.0], [0.0, 10.0]], false))
}

/// A ball of 3 mm touches the edge 2 mm above the floor, and leaves what is more than 0.2 mm below that. A flat end that
/// stands on the floor finishes rows of `sqrt(2 * 6 * 0.0165)`, 0.44 mm, up from its edge; short passes follow over spots
/// at their ends.
#[test]
fn a_flat_end_finishes_the_corner_that_a_ball_leaves_in_rows_along_it() {
    let (edge, floor) = rounded_edge_on_a_floor();
    let options = CoverOptions { lean: options(PlacementMethod::Inclined).lean, ..finishing() };
    let (faces, others) = (std::slice::from_ref(&edge), std::slice::from_ref(&floor));
    let by_ball = beside_all((faces, others), &cutter([0.0, 3.0]), &options).unwrap();
    let regions = &by_ball.report.rest;
    assert!(regions.iter().map(|part| part.area).sum::<f64>() > 50.0);
    let flat = cutter([8.0, 0.0]);
    let left = Some(LeftArea { cut: &[1], regions });
    let request = CoverRequest { others, left, ..CoverRequest::new(faces, &flat, &options) };
    let covering = cover(&request, &Silent).unwrap();
    assert!(covering.report.rest.is_empty(), "{:?}", covering.report.rest);
    let long = |pass: &&Pass| {
        (pass.stations[0].contact - pass.stations.last().unwrap().contact).norm() > 25.0
    };
    let rows = covering.passes.iter().filter(long).count();
    assert!((5..=12).contains(&rows), "{rows} rows");
    assert!(covering.passes.len() <= 35, "{} passes", covering.passes.len());
}

/// A machine that gets to poses that lean to one side only: every other pass of a zigzag, along which the tool would lean to
/// the other side, is run the same way as the one before.
#[test]
fn a_lean_that_only_one_feed_direction_has_is_taken() {
    let (floor, cutter) = (floor(0.0), cutter([3.0, 2.0]));
    for cost in [Fenced(|pose| pose.axis.y > 0.05), Fenced(|pose| pose.axis.y < -0.05)] {
        let options =
            CoverOptions { feed_direction: FeedDirection::V, ..options(PlacementMethod::Inclined) };
        let faces = std::slice::from_ref(&floor);
        let request =
            CoverRequest { cost: Some(&cost), ..CoverRequest::new(faces, &cutter, &options) };
        let covering = cover(&request, &Silent).unwrap();
        let mut stations = covering.passes.iter().flat_map(|pass| &pass.stations);
        assert!(stations.all(|station| cost.reaches(&station.pose)));
        let rest = agrees(&covering, (&floor, &[]), &cutter);
        let area: f64 = rest.iter().map(|rest| rest.area).sum();
        assert!(rest.is_empty(), "{area} mm2 in {} parts", rest.len());
    }
}
