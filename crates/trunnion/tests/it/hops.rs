//! Hops from pass to pass: taken where they are quicker, as high as they must be, and clear of the part.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Unit, Vector3};
use trunnion::cover::{HopOptions, LeadKind, LinkOptions, LinkRequest, legs, lever};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
use trunnion::toolpath::{ToolPathOptions, through};
use trunnion::types::Interval;
use trunnion::types::{Leg, Motion, Pass, PieceGeometry, Silent, Station, ToolPath, ToolPose, Uv};

const MAJOR: f64 = 4.0;
const MINOR: f64 = 2.0;
const LENGTH: f64 = 40.0;
const HEIGHT: f64 = 6.0;
const CLEAR: f64 = 3.0;
const GOUGE: f64 = 0.01;

fn cutter() -> Cutter {
    Cutter::new(CutterSpec { length: LENGTH, ..CutterSpec::bull(MAJOR, MINOR) }).unwrap()
}

/// A floor 80 mm long and wide with a ridge along y in the middle, whose control points are `ridge` high.
fn floor(ridge: f64) -> FaceIndex {
    let heights = [0.0, 0.0, 0.0, 0.0, ridge, ridge, 0.0, 0.0, 0.0, 0.0];
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 7.0, 7.0, 7.0];
    let xs = [-40.0, -30.0, -20.0, -12.0, -3.0, 3.0, 12.0, 20.0, 30.0, 40.0];
    let points = xs.iter().zip(heights);
    let points = points.map(|(x, z)| [-40.0, 40.0].map(|y| Point3::new(*x, y, z)).to_vec());
    let across = vec![0.0, 0.0, 1.0, 1.0];
    let surface = NurbsSurface::new([3, 1], [knots, across], points.collect(), None).unwrap();
    FaceIndex::new(Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()).unwrap()
}

/// A pass along y on the floor at `x`, the tool leaning by `lean` towards +y.
fn pass(x: f64, lean: f64, back: bool) -> Pass {
    let axis = Unit::new_normalize(Vector3::new(0.0, lean, 1.0));
    let low = MINOR * (1.0 - axis.z) + MAJOR * (1.0 - axis.z * axis.z).sqrt();
    let at = |y: f64| Station {
        pose: ToolPose { tip: Point3::new(x, y, low), axis },
        contact: Point3::new(x, y - MAJOR, 0.0),
    };
    let mut stations = [-20.0, -10.0, 0.0, 10.0, 20.0].map(at).to_vec();
    if back {
        stations.reverse();
    }
    let many = stations.len();
    Pass { face: 1, stations, widths: vec![1.0; many], track: vec![Uv::new(0.0, 0.0); many] }
}

fn link() -> LinkOptions {
    let up = Vector3::z_axis();
    let boxes = vec![[Point3::new(-40.0, -40.0, 0.0), Point3::new(40.0, 40.0, 30.0)]];
    let (clearance, lead) = (30.0, LeadKind::Axis);
    LinkOptions { lead, approach: 3.0, gouge: GOUGE, ..LinkOptions::above(up, boxes, clearance) }
}

/// Length of the way of the tip: a machine that is as fast in every direction and turns at once.
fn way(poses: &[ToolPose]) -> f64 {
    poses.windows(2).map(|pair| (pair[1].tip - pair[0].tip).norm()).sum()
}

fn joined(
    passes: &[Pass],
    face: FaceIndex,
    seconds: &(dyn Fn(&[ToolPose]) -> f64 + Sync),
) -> Vec<Leg> {
    joined_by(passes, face, &HopOptions { clear: CLEAR, ..HopOptions::new(HEIGHT, seconds) })
}

fn joined_by(passes: &[Pass], face: FaceIndex, hops: &HopOptions<'_>) -> Vec<Leg> {
    let hops = Some(*hops);
    let (faces, cutter, link) = ([face], cutter(), link());
    let request = LinkRequest { hops, ..LinkRequest::new(passes, &faces, &cutter, &link) };
    legs(&request, &Silent).unwrap()
}

fn curves(legs: &[Leg]) -> ToolPath {
    through(legs, &ToolPathOptions::with_lever(lever(&cutter())), &Silent).unwrap()
}

/// Distance of a place from the tool, below 0 inside: the rounded corner, the flat end, the flank.
fn distance(pose: &ToolPose, place: &Point3<f64>) -> f64 {
    let from = place - pose.tip;
    let z = from.dot(&pose.axis);
    let rho = (from - pose.axis.scale(z)).norm();
    if z > MINOR {
        return rho - MAJOR - MINOR;
    }
    let out = (rho - MAJOR).max(0.0);
    out.hypot(z - MINOR) - MINOR
}

/// Least distance from the floor over a hop, and over its middle third, by sampling.
fn clearance(path: &ToolPath, piece: usize, face: &FaceIndex) -> [f64; 2] {
    let PieceGeometry::Curve(curve) = &path.pieces[piece].geometry else { return [f64::NAN; 2] };
    let Interval { low: start, high: end } = curve.range();
    let mut least = [f64::INFINITY; 2];
    for i in 0..=60 {
        let share = f64::from(i) / 60.0;
        let pose = curve.pose(start + (end - start) * share).unwrap();
        for j in 0..=200 {
            for k in 0..=40 {
                let [u, v] = [7.0 * f64::from(j) / 200.0, f64::from(k) / 40.0];
                let gap = distance(&pose, &face.face().point(u, v));
                least[0] = least[0].min(gap);
                if (1.0 / 3.0..=2.0 / 3.0).contains(&share) {
                    least[1] = least[1].min(gap);
                }
            }
        }
    }
    least
}

#[test]
fn passes_side_by_side_are_joined_by_one_sweep() {
    let passes = [pass(-12.0, 0.1, false), pass(-8.0, -0.1, true), pass(-4.0, 0.1, false)];
    let legs = joined(&passes, floor(0.0), &way);
    let kinds: Vec<Motion> = legs.iter().map(|leg| leg.motion).collect();
    let (cut, hop) = (Motion::Cut, Motion::Hop);
    let ends =
        [Motion::Link, Motion::LeadIn, cut, hop, cut, hop, cut, Motion::LeadOut, Motion::Link];
    assert_eq!(kinds, ends);
    let path = curves(&legs);
    let index = path.pieces.iter().position(|piece| piece.motion == hop).unwrap();
    let [all, middle] = clearance(&path, index, &floor(0.0));
    assert!(all > -GOUGE && middle > CLEAR, "{all} {middle}");
    // Half an ellipse of this height: no longer than up, over and down.
    let hop = &legs[3].stations;
    let poses: Vec<ToolPose> = hop.iter().map(|station| station.pose).collect();
    assert!(way(&poses) < 2.0 * HEIGHT + 4.0, "{}", way(&poses));
    let high = poses.iter().map(|pose| pose.tip.z).fold(0.0, f64::max);
    assert!((high - HEIGHT - poses[0].tip.z).abs() < 0.05 * HEIGHT, "{high}");
}

#[test]
fn a_ridge_is_passed_higher_and_a_wall_over_the_plane() {
    let passes = [pass(-28.0, 0.0, false), pass(28.0, 0.0, true)];
    let hops = [6.0, 16.0, 45.0].map(|ridge| (ridge, Motion::Hop));
    for (ridge, expected) in hops.into_iter().chain([(75.0, Motion::Link)]) {
        let legs = joined(&passes, floor(ridge), &way);
        let between = legs.iter().filter(|leg| leg.motion == Motion::Hop).count();
        assert_eq!(between, usize::from(expected == Motion::Hop), "ridge {ridge}");
        let path = curves(&legs);
        if let Some(index) = path.pieces.iter().position(|piece| piece.motion == Motion::Hop) {
            let [all, middle] = clearance(&path, index, &floor(ridge));
            assert!(all > -GOUGE && middle > CLEAR, "ridge {ridge}: {all} {middle}");
        }
    }
}

/// Blocks may be off a hop by a tenth of the way from its ends. So where the tool leaves the face, beside a slope that it
/// runs up, it is clear by as much.
#[test]
fn a_hop_up_a_slope_is_clear_by_a_share_of_the_way() {
    /// Spans at either end in which the tool leaves the face.
    const NEAR: usize = 3;
    let mut hops = 0;
    for (x, ridge) in (26..36).flat_map(|x| [4.0, 9.0, 16.0].map(|ridge| (x, ridge))) {
        let (x, face) = (f64::from(x), floor(ridge));
        let passes = [pass(-x, 0.0, false), pass(x, 0.0, true)];
        let legs = joined(&passes, floor(ridge), &way);
        let path = curves(&legs);
        let Some(index) = path.pieces.iter().position(|piece| piece.motion == Motion::Hop) else {
            continue;
        };
        let PieceGeometry::Curve(curve) = &path.pieces[index].geometry else { panic!("no curve") };
        hops += 1;
        let at = |knot: usize| curve.pose(curve.knots[knot]).unwrap().tip;
        let spans = curve.spans.len();
        for span in (0..NEAR).chain(spans - NEAR..spans) {
            let away = |knot: usize| (at(knot) - at(0)).norm().min((at(knot) - at(spans)).norm());
            let least = 0.1 * away(span).min(away(span + 1)) - GOUGE;
            for i in 0..=8 {
                let [low, high] = [curve.knots[span], curve.knots[span + 1]];
                let pose = curve.pose(low + (high - low) * f64::from(i) / 8.0).unwrap();
                let places = (0..=200).map(|j| face.face().point(7.0 * f64::from(j) / 200.0, 0.5));
                let gap = places.map(|place| distance(&pose, &place)).fold(f64::INFINITY, f64::min);
                assert!(gap >= least - 1e-9, "x {x}, ridge {ridge}, span {span}: {gap} of {least}");
            }
        }
    }
    assert!(hops > 10, "{hops} hops");
}

/// Pass along y at `x` whose tool stands upright on the face, found by bisection.
fn standing(x: f64, back: bool, face: &FaceIndex) -> Pass {
    let mut pass = pass(x, 0.0, back);
    let places: Vec<Point3<f64>> =
        (0..=1400).map(|j| face.face().point(7.0 * f64::from(j) / 1400.0, 0.5)).collect();
    let gap = |z: f64| {
        let pose = ToolPose { tip: Point3::new(x, 0.0, z), axis: Vector3::z_axis() };
        places.iter().map(|place| distance(&pose, place)).fold(f64::INFINITY, f64::min)
    };
    let (mut low, mut high) = (-1.0, 60.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if gap(middle) > 0.0 { high = middle } else { low = middle }
    }
    for station in &mut pass.stations {
        station.pose.tip.z = high;
        station.contact = Point3::new(x, station.pose.tip.y, high);
    }
    pass.track.fill(Uv::new(3.5 + 3.5 * x / 40.0, 0.5));
    pass
}

/// Beside each other passes are joined along the face, over a bulge as well; farther apart, and where the feed is slower
/// than the way off the face, they are not.
#[test]
fn neighbours_are_joined_by_a_step_at_the_feed() {
    let seconds = |poses: &[ToolPose]| way(poses) / 20.0;
    let kinds = |passes: &[Pass], face: FaceIndex, feed: f64| {
        let hops = HopOptions { feed: Some(feed), ..HopOptions::new(HEIGHT, &seconds) };
        joined_by(passes, face, &hops)
    };
    let between = |legs: &[Leg]| -> Vec<Motion> {
        let all = legs.iter().map(|leg| leg.motion);
        all.filter(|motion| matches!(motion, Motion::Step | Motion::Hop)).collect()
    };
    let beside = [pass(-12.0, 0.1, false), pass(-10.5, 0.1, true)];
    assert_eq!(between(&kinds(&beside, floor(0.0), 10.0)), [Motion::Step]);
    assert_eq!(between(&kinds(&beside, floor(0.0), 1.0)), [Motion::Hop]);
    let apart = [pass(-12.0, 0.1, false), pass(-9.5, 0.1, true)];
    assert_eq!(between(&kinds(&apart, floor(0.0), 10.0)), [Motion::Hop]);
    let mut steps = 0;
    for (ridge, x) in
        [6.0, 16.0, 30.0].into_iter().flat_map(|ridge| (-12..12).map(move |x| (ridge, x)))
    {
        let x = f64::from(x);
        let face = floor(ridge);
        let passes = [standing(x, false, &face), standing(x + 0.9, true, &face)];
        let legs = kinds(&passes, floor(ridge), 10.0);
        let path = curves(&legs);
        let Some(index) = path.pieces.iter().position(|piece| piece.motion == Motion::Step) else {
            continue;
        };
        steps += 1;
        let [least, _] = clearance(&path, index, &face);
        assert!(least >= -GOUGE, "ridge {ridge}, x {x}: {least}");
    }
    assert!(steps > 30, "{steps} steps");
    // A pass that begins at the end of the one before goes on; beside it by less than a curve could show, the step is straight.
    for (gap, expected) in [
        (0.0, None),
        (1e-14, None),
        (1e-9, None),
        (1e-5, Some(Motion::Step)),
        (0.004, Some(Motion::Step)),
    ] {
        let mut next = pass(-12.0, 0.1, true);
        for station in &mut next.stations {
            station.pose.tip.x += gap;
        }
        let legs = kinds(&[pass(-12.0, 0.1, false), next], floor(0.0), 10.0);
        assert_eq!(between(&legs), Vec::from_iter(expected), "gap {gap}");
        let cuts: Vec<&Leg> = legs.iter().filter(|leg| leg.motion == Motion::Cut).collect();
        let met = cuts[0].stations.last().map(|end| end.pose)
            == cuts[1].stations.first().map(|start| start.pose);
        assert_eq!(met, expected.is_none(), "gap {gap}");
        curves(&legs);
    }
}

#[test]
fn a_slow_hop_is_not_taken() {
    let passes = [pass(-12.0, 0.1, false), pass(-8.0, -0.1, true)];
    // A machine that takes a second for each pose: five straight ways beat sixteen steps.
    let count = |poses: &[ToolPose]| poses.len() as f64;
    for legs in [
        joined(&passes, floor(0.0), &count),
        legs(&LinkRequest::new(&passes, &[floor(0.0)], &cutter(), &link()), &Silent).unwrap(),
    ] {
        assert!(legs.iter().all(|leg| leg.motion != Motion::Hop));
        assert_eq!(legs.iter().filter(|leg| leg.motion == Motion::Cut).count(), 2);
    }
}
