//! Links round closed parts, looked at without any of the proofs: whole tools at dense places of the way, and
//! points all through the part.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Rotation3, Unit, UnitVector3, Vector3};
use std::f64::consts::TAU;
use trunnion::cover::{LeadKind, LinkOptions, LinkRequest, legs, lever};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::surface::{
    CylinderSurface, Face, FaceIndex, SphereSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop,
};
use trunnion::toolpath::{ToolPathOptions, through};
use trunnion::types::Interval;
use trunnion::types::{Leg, Motion, Pass, PieceGeometry, Silent, Station, ToolPose, Uv};

const RADIUS: f64 = 20.0;
const LENGTH: f64 = 60.0;

fn cutter(shank: Vec<[f64; 2]>) -> Cutter {
    let spec = CutterSpec { length: 80.0, shank, ..CutterSpec::of_radii(5.0, 3.0) };
    Cutter::new(spec).unwrap()
}

/// A shaft about z, or with rounded ends a ball of the same radius.
fn shaft() -> FaceIndex {
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let surface = Surface::Cylinder(CylinderSurface::new(frame, RADIUS).unwrap());
    let rim = |v: f64, forward: bool| {
        let ends = if forward { [0.0, TAU] } else { [TAU, 0.0] };
        let curve = TrimCurve::polyline(&[[ends[0], v], [ends[1], v]]).unwrap();
        TrimLoop::new(vec![curve], surface.periods(), 1e-9).unwrap()
    };
    let loops = vec![rim(0.0, true), rim(LENGTH, false)];
    FaceIndex::new(Face::new(1, surface, loops).unwrap()).unwrap()
}

fn ball() -> FaceIndex {
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let surface = Surface::Sphere(SphereSurface::new(frame, RADIUS).unwrap());
    FaceIndex::new(Face::new(1, surface, Vec::new()).unwrap()).unwrap()
}

/// A pass along the shaft at `angle` round it, the tool leaning ahead.
fn pass(angle: f64, [from, to]: [f64; 2]) -> Pass {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
    let at = |z: f64| {
        let axis = Unit::new_normalize(turn * Vector3::new(1.0, 0.0, 0.1));
        let contact = Point3::from(turn * Vector3::new(RADIUS, 0.0, z));
        // Standing on the corner: as high over the contact as the rounding of the cutter's corner.
        let tip = contact + turn * Vector3::new(0.6, 0.0, 0.0) + axis.scale(0.2);
        Station { pose: ToolPose { tip, axis }, contact }
    };
    let stations = vec![at(from), at(0.5 * (from + to)), at(to)];
    Pass { face: 1, stations, widths: vec![1.0; 3], track: vec![Uv::new(0.0, 0.0); 3] }
}

fn options(part: [Point3<f64>; 2], clearance: f64) -> LinkOptions {
    let (up, lead) = (Vector3::z_axis(), LeadKind::Axis);
    LinkOptions {
        lead,
        approach: 2.0,
        gouge: 0.01,
        ..LinkOptions::above(up, vec![part], clearance)
    }
}

fn shaft_box() -> [Point3<f64>; 2] {
    [Point3::new(-RADIUS, -RADIUS, 0.0), Point3::new(RADIUS, RADIUS, LENGTH)]
}

/// Signed distance of a place from a cylinder of revolution about the tool axis.
fn off(place: &Point3<f64>, pose: &ToolPose, radius: f64, [low, high]: [f64; 2]) -> f64 {
    let way = place - pose.tip;
    let z = way.dot(&pose.axis);
    let rho = (way - pose.axis.scale(z)).norm() - radius;
    let beyond = (low - z).max(z - high);
    if rho.max(beyond) <= 0.0 { rho.max(beyond) } else { rho.max(0.0).hypot(beyond.max(0.0)) }
}

/// Least distance of a tool, taken as a cylinder and one for its holder, from places.
fn nearest(pose: &ToolPose, places: &[Point3<f64>], holder: Option<[f64; 2]>) -> f64 {
    let end = |p: &Point3<f64>| off(p, pose, 8.0, [0.0, 80.0]);
    let wide = |p: &Point3<f64>| {
        holder.map_or(f64::INFINITY, |[from, radius]| off(p, pose, radius, [from, 80.0]))
    };
    places.iter().map(|p| end(p).min(wide(p))).fold(f64::INFINITY, f64::min)
}

/// Poses of all links, dense.
fn link_poses(legs: &[Leg], cutter: &Cutter) -> Vec<Vec<ToolPose>> {
    let path = through(legs, &ToolPathOptions::with_lever(lever(cutter)), &Silent).unwrap();
    let links = path.pieces.iter().filter(|piece| piece.motion == Motion::Link);
    let dense = |geometry: &PieceGeometry| match geometry {
        PieceGeometry::Curve(curve) => {
            let Interval { low: a, high: b } = curve.range();
            (0..=60).map(|k| curve.pose(a + (b - a) * f64::from(k) / 60.0).unwrap()).collect()
        }
        PieceGeometry::Reorient { from, to } => vec![*from, *to],
    };
    links.map(|piece| dense(&piece.geometry)).collect()
}

fn grid(inside: impl Fn(&Point3<f64>) -> bool) -> Vec<Point3<f64>> {
    let mut places = Vec::new();
    for (i, j, k) in (0..9).flat_map(|i| (0..9).flat_map(move |j| (0..17).map(move |k| (i, j, k))))
    {
        let [x, y, z] =
            [5.0 * f64::from(i) - 20.0, 5.0 * f64::from(j) - 20.0, 5.0 * f64::from(k) - 20.0];
        places.push(Point3::new(x, y, z));
    }
    for k in 0..60 {
        let (sin, cos) = (TAU * f64::from(k) / 60.0).sin_cos();
        places
            .extend((0..=12).map(|z| Point3::new(RADIUS * cos, RADIUS * sin, 5.0 * f64::from(z))));
    }
    places.retain(inside);
    places
}

fn in_shaft(p: &Point3<f64>) -> bool {
    p.xy().coords.norm() <= RADIUS + 1e-9 && (0.0..=LENGTH).contains(&p.z)
}

/// Returns `true` for a link on which the tool turns; on the others it climbs or comes down along its axis.
fn goes_round(leg: &Leg) -> bool {
    let axis = |station: Option<&Station>| station.map(|station| station.pose.axis);
    let [first, last] = [leg.stations.first(), leg.stations.last()].map(axis);
    leg.motion == Motion::Link && leg.stations.len() > 2 && first != last
}

/// A way along a leaning axis is one that the axes follow: left to the machine, a rotary could turn whole turns on it, and
/// the tool would swing into the part.
#[test]
fn a_rotary_has_no_room_for_a_whole_turn_beside_the_part() {
    let (faces, cutter) = ([shaft()], cutter(Vec::new()));
    let passes = [0.0, 2.4, 4.0].map(|angle| pass(angle, [5.0, 55.0]));
    let options = LinkOptions { approach: 4.0, ..options(shaft_box(), 10.0) };
    let legs = legs(&LinkRequest::new(&passes, &faces, &cutter, &options), &Silent).unwrap();
    let leaning = |leg: &&Leg| leg.stations.iter().all(|station| station.pose.axis.z < 0.5);
    let links: Vec<&Leg> =
        legs.iter().filter(|leg| leg.motion == Motion::Link).filter(leaning).collect();
    assert!(links.iter().filter(|leg| !goes_round(leg)).count() >= 4, "{}", links.len());
    assert!(links.iter().all(|leg| leg.stations.len() > 2));
}

#[test]
fn a_shaft_is_gone_round_with_the_whole_tool_clear_of_it() {
    let (faces, places) = ([shaft()], grid(in_shaft));
    for (shank, holder, clearance) in [
        (Vec::new(), None, 10.0),
        // A holder much wider than the shaft, 30 mm from the tip.
        (vec![[30.0, 8.0], [30.0, 40.0], [80.0, 40.0]], Some([30.0, 40.0]), 5.0),
    ] {
        let cutter = cutter(shank);
        // Neighbours, the other side, and the place right opposite.
        let angles = [0.0, 0.2, 0.4, 2.4, 2.4 + 0.5 * TAU, 4.0];
        let way = |i: usize| if i.is_multiple_of(2) { [5.0, 55.0] } else { [50.0, 10.0] };
        let passes: Vec<Pass> = angles.iter().enumerate().map(|(i, &a)| pass(a, way(i))).collect();
        let legs = legs(
            &LinkRequest::new(&passes, &faces, &cutter, &options(shaft_box(), clearance)),
            &Silent,
        )
        .unwrap();
        let mut least = f64::INFINITY;
        for poses in link_poses(&legs, &cutter) {
            least = poses.iter().map(|p| nearest(p, &places, holder)).fold(least, f64::min);
        }
        // Leads begin 2 mm above the surface; what is above that keeps off.
        assert!(least > 1.5, "{least}");
        let between = legs.iter().filter(|leg| goes_round(leg));
        let mut count = 0;
        for leg in between {
            let poses = link_poses(std::slice::from_ref(leg), &cutter).concat();
            let kept =
                poses.iter().map(|p| nearest(p, &places, holder)).fold(f64::INFINITY, f64::min);
            assert!(kept > 0.2 * clearance, "{kept}");
            count += 1;
        }
        assert_eq!(count, angles.len() - 1);
    }
}

#[test]
fn neighbouring_passes_are_joined_by_short_links() {
    let (faces, cutter) = ([shaft()], cutter(Vec::new()));
    let passes = [pass(3.0, [5.0, 55.0]), pass(3.2, [55.0, 5.0])];
    let legs =
        legs(&LinkRequest::new(&passes, &faces, &cutter, &options(shaft_box(), 10.0)), &Silent)
            .unwrap();
    let link = legs.iter().find(|leg| goes_round(leg)).unwrap();
    let length: f64 =
        link.stations.windows(2).map(|s| (s[1].pose.tip - s[0].pose.tip).norm()).sum();
    // Up to the corner of the shaft's box, and not to a plane over its end.
    assert!(length < 20.0, "{length}");
    let top = link.stations.iter().map(|s| s.pose.tip.z).fold(f64::NEG_INFINITY, f64::max);
    assert!(top < LENGTH + 12.0, "{top}");
}

#[test]
fn a_ball_is_gone_round_to_its_far_side() {
    let (faces, cutter) = ([ball()], cutter(Vec::new()));
    let standing = |axis: UnitVector3<f64>| {
        let side = Unit::new_normalize(axis.cross(&Vector3::new(0.3, 0.2, 0.9)));
        let at = |way: f64| {
            let turn = Rotation3::from_axis_angle(&side, way);
            let axis = turn * axis;
            let contact = Point3::from(axis.scale(RADIUS));
            Station { pose: ToolPose { tip: contact + axis.scale(0.01), axis }, contact }
        };
        let stations = vec![at(0.0), at(0.1), at(0.2)];
        Pass { face: 1, stations, widths: vec![1.0; 3], track: vec![Uv::new(0.0, 0.0); 3] }
    };
    let ways =
        [[0.0, 0.0, 1.0], [1.0, 0.2, -0.1], [-1.0, 0.0, -0.5], [0.1, 0.1, -1.0], [0.0, 1.0, 0.2]];
    let passes = ways.map(|way| standing(Unit::new_normalize(Vector3::from(way))));
    let corner = Vector3::repeat(RADIUS);
    let part = [Point3::from(-corner), Point3::from(corner)];
    let legs =
        legs(&LinkRequest::new(&passes, &faces, &cutter, &options(part, 8.0)), &Silent).unwrap();
    let places = grid(|p| p.coords.norm() <= RADIUS + 1e-9);
    for leg in legs.iter().filter(|leg| leg.motion == Motion::Link && leg.stations.len() > 2) {
        let poses = link_poses(std::slice::from_ref(leg), &cutter).concat();
        let kept = poses.iter().map(|p| nearest(p, &places, None)).fold(f64::INFINITY, f64::min);
        assert!(kept > 1.6, "{kept}");
    }
}
