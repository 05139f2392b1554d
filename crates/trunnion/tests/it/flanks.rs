//! One pass of the flank on faces whose straight lines twist.
//!
//! The oracle samples the face and the poses of the curve that the tool path follows, and takes the least signed distance to
//! the cutter in closed form.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;
use crate::swept_tool::{SPACING, distance, poses};

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use std::f64::consts::TAU;
use trunnion::cover::{
    CoverError, CoverOptions, CoverRequest, FinishTolerance, FlankRefusal, PassLayout,
    PrismaticUse, cover, flank_fits,
};
use trunnion::cutter::{Cutter, CutterKind, CutterSpec};
use trunnion::positioning::ToleranceBand;
use trunnion::surface::{
    CylinderSurface, Face, FaceIndex, NurbsSurface, PlaneSurface, Surface, SurfaceFrame, TrimCurve,
    TrimLoop,
};
use trunnion::types::Silent;

const EXCESS: f64 = 0.02;
const GOUGE: f64 = 0.002;
const SHARE: f64 = 0.002;

/// Face between two parabolas, the upper one turned and moved against the lower one.
#[derive(Debug, Clone, Copy)]
struct RuledPatch {
    /// Rise of the middle of the lower and of the upper curve over its ends \[mm\].
    rises: [f64; 2],
    /// Turn of the upper curve against the lower one \[rad\].
    turn: f64,
    /// Lean of the face out of the vertical, over its height of 20 mm \[mm\].
    lean: f64,
}

impl RuledPatch {
    fn face(&self) -> FaceIndex {
        let curve = |k: usize| {
            let (sin, cos) = if k == 0 { (0.0, 1.0) } else { self.turn.sin_cos() };
            let (z, lean) = if k == 0 { (0.0, 0.0) } else { (20.0, self.lean) };
            [-1.0, 0.0, 1.0].map(|share: f64| {
                let (x, y) = (15.0 * share, self.rises[k] * 2.0 * (1.0 - share.abs()));
                Point3::new(x * cos - y * sin, x * sin + y * cos - lean, z)
            })
        };
        let (low, high) = (curve(0), curve(1));
        let points = (0..3).map(|i| vec![low[i], high[i]]).collect();
        let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
        let surface = NurbsSurface::new([2, 1], knots, points, None).unwrap();
        FaceIndex::new(Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()).unwrap()
    }
}

fn cutter(radius: f64) -> Cutter {
    let spec =
        CutterSpec { kind: CutterKind::Flat, length: 60.0, ..CutterSpec::of_radii(radius, 0.0) };
    Cutter::new(spec).unwrap()
}

fn options(cutter: &Cutter) -> CoverOptions {
    CoverOptions {
        prismatic: PrismaticUse::Flank,
        band: ToleranceBand { lower: -GOUGE, upper: EXCESS },
        path_share: SHARE,
        ..CoverOptions::finishing(cutter, FinishTolerance { excess: EXCESS, gouge: GOUGE })
    }
}

/// Least signed distance from the cutter of points of the face, and of one at 0.02 mm under the face.
fn deviations(face: &FaceIndex, cutter: &Cutter) -> [f64; 2] {
    let options = options(cutter);
    let request = CoverRequest::new(std::slice::from_ref(face), cutter, &options);
    let covering = cover(&request, &Silent).unwrap();
    assert_eq!(covering.report.layouts[0].layout, PassLayout::Flank);
    assert_eq!(covering.passes.len(), 1);
    let rest: Vec<f64> = covering.report.rest.iter().map(|rest| rest.area).collect();
    assert!(rest.is_empty(), "{rest:?} mm2 are left");
    let poses = poses(&covering.passes, cutter);
    let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
    for i in 0..=40 {
        for j in 0..=16 {
            let point = face.face().point(f64::from(i) / 40.0, f64::from(j) / 16.0);
            let least = poses.iter().map(|pose| distance(&point, pose, cutter));
            let least = least.fold(f64::INFINITY, f64::min);
            ends = [ends[0].min(least), ends[1].max(least)];
        }
    }
    ends
}

/// What poses [`SPACING`] apart may miss over a side of 3 mm radius \[mm\].
const SAMPLING: f64 = 0.5 * (0.5 * SPACING) * (0.5 * SPACING) / 3.0;

proptest! {
    #![proptest_config(property::cases(24))]

    /// A face that twists a little is finished by one pass, and not gouged; one that is refused twists a lot.
    #[test]
    fn one_pass_finishes_a_face_that_twists(
        low in -1.5..4.0_f64, high in -1.5..4.0_f64, turn in -0.5..0.5_f64, lean in -8.0..8.0_f64,
        radius in 3.0..8.0_f64,
    ) {
        let face = RuledPatch { rises: [low, high], turn, lean }.face();
        let cutter = cutter(radius);
        match flank_fits(&face, &cutter, &options(&cutter)) {
            Ok(()) => {
                let [deepest, highest] = deviations(&face, &cutter);
                prop_assert!(deepest >= -GOUGE - 1e-9, "{deepest}");
                prop_assert!(highest <= EXCESS + SHARE + SAMPLING, "{highest}");
            }
            Err(FlankRefusal::Twisted { .. }) => {
                // The face turns its normal along some line by more than the tolerance allows a tangent cylinder at
                // both ends: radius (1 - cos(turn / 2)) over the band.
                let turned = (0..=20).map(|i| f64::from(i) / 20.0).map(|u| {
                    let [a, b] = [0.0, 1.0].map(|v| face.face().normal(u, v).unwrap());
                    a.dot(&b).clamp(-1.0, 1.0).acos()
                });
                let most = turned.fold(0.0, f64::max);
                prop_assert!(radius * (1.0 - (0.5 * most).cos()) > 0.7 * (EXCESS + GOUGE - SHARE), "{most}");
            }
            Err(FlankRefusal::Concave { concave, .. }) => prop_assert!(concave <= radius),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}

/// The line in the asymptotic direction of the offset face stays nearer to it than a line over the ruling.
#[test]
fn the_axis_leaves_the_ruling_where_the_face_twists() {
    let face = RuledPatch { rises: [0.0, 0.0], turn: 0.35, lean: 0.0 }.face();
    let cutter = cutter(6.0);
    // Over the ruling: 6 (1 - cos(0.35 / 2)) = 0.092 mm at the middle of the face.
    let [deepest, highest] = deviations(&face, &cutter);
    assert!(deepest >= -GOUGE && highest <= EXCESS + SHARE + SAMPLING, "{deepest} {highest}");
}

/// A post beside a wall, too near for the tool: the wall is cut to either side of it, by the same geometry in closed form.
#[test]
fn a_wall_is_cut_on_both_sides_of_what_is_in_the_way() {
    let [post, apart, radius] = [3.0, 9.0, 5.0];
    let wall = RuledPatch { rises: [0.0, 0.0], turn: 0.0, lean: 0.0 }.face();
    let normal = wall.face().normal(0.5, 0.5).unwrap().into_inner();
    let foot = Point3::from(normal * apart);
    let frame = SurfaceFrame::new(foot, Vector3::z(), Vector3::x()).unwrap();
    let surface = Surface::Cylinder(CylinderSurface::new(frame, post).unwrap());
    let trims = vec![[[0.0, 0.0], [TAU, 0.0]], [[TAU, 22.0], [0.0, 22.0]]]
        .into_iter()
        .map(|ends| {
            let curve = TrimCurve::polyline(&ends).unwrap();
            TrimLoop::new(vec![curve], [Some(TAU), None], 1e-9).unwrap()
        })
        .collect();
    let post_face = FaceIndex::new(Face::new(2, surface, trims).unwrap()).unwrap();
    let cutter = cutter(radius);
    let options = options(&cutter);
    let request = CoverRequest {
        others: std::slice::from_ref(&post_face),
        ..CoverRequest::new(std::slice::from_ref(&wall), &cutter, &options)
    };
    let covering = cover(&request, &Silent).unwrap();
    assert_eq!(covering.passes.len(), 2);
    let poses = poses(&covering.passes, &cutter);
    let least = |point: &Point3<f64>| {
        poses.iter().map(|pose| distance(point, pose, &cutter)).fold(f64::INFINITY, f64::min)
    };
    for i in 0..60 {
        for j in 0..=5 {
            let (sin, cos) = (TAU * f64::from(i) / 60.0).sin_cos();
            let around = Vector3::new(post * cos, post * sin, 4.0 * f64::from(j));
            assert!(least(&(foot + around)) >= -GOUGE - SHARE);
        }
    }
    // The axis is `radius` off the wall, and `post + radius` off the middle of the post.
    let barred = ((post + radius).powi(2) - (apart - radius).powi(2)).sqrt();
    let beyond = (2.0 * radius * (EXCESS + SHARE)).sqrt();
    for i in 0..=60 {
        let point = wall.face().point(f64::from(i) / 60.0, 0.5);
        let is_free = point.x.abs() >= barred;
        let gap = (point.x.abs() - barred).abs();
        // What lies within `beyond` of the last contact is finished by the roundness of the tool.
        if gap > beyond {
            assert_eq!(least(&point) <= EXCESS + SHARE, is_free, "at {}", point.x);
        }
    }
    let left: f64 = covering.report.rest.iter().map(|rest| rest.area).sum();
    let [few, many] = [barred - beyond, barred].map(|half| 2.0 * half * 20.0);
    assert!(few - 1.0 <= left && left <= many + 1.0, "{few} {left} {many}");
}

#[test]
fn a_face_that_the_flank_cannot_cut_is_refused_with_the_reason() {
    let refused = |face: &FaceIndex, cutter: &Cutter| {
        let options = options(cutter);
        let request = CoverRequest::new(std::slice::from_ref(face), cutter, &options);
        match cover(&request, &Silent) {
            Err(CoverError::NoFlank { face: 1, why }) => why,
            other => panic!("{other:?}"),
        }
    };
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let square = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0], [0.0, 0.0]];
    let curve = TrimCurve::polyline(&square).unwrap();
    let trims = vec![TrimLoop::new(vec![curve], [None, None], 1e-9).unwrap()];
    let floor = Surface::Plane(PlaneSurface { frame });
    let floor = FaceIndex::new(Face::new(1, floor, trims).unwrap()).unwrap();
    assert_eq!(refused(&floor, &cutter(5.0)), FlankRefusal::NoRulings);
    let twisted = RuledPatch { rises: [3.0, 0.0], turn: 1.2, lean: 0.0 }.face();
    assert_eq!(refused(&twisted, &cutter(8.0)), FlankRefusal::Twisted { radius: 8.0 });
    let flat = RuledPatch { rises: [1.0, 1.0], turn: 0.0, lean: 2.0 }.face();
    let short = CutterSpec { length: 15.0, ..cutter(5.0).spec().clone() };
    let short = refused(&flat, &Cutter::new(short).unwrap());
    assert!(matches!(short, FlankRefusal::Short { ruling, .. } if ruling > 20.0), "{short}");
}
