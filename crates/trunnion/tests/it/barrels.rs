//! Barrels and conical barrels: locations, passes, and what is refused before any pass is planned.
//!
//! The oracle is a profile of revolution sampled from the radii alone, and distances from quadrics of its own: it knows
//! no arcs and no strips.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::brute_force::Shape;
use crate::property::cases;

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::files::{job, machine};
use trunnion::pipeline::{self, Job, PipelineError};
use trunnion::positioning::{
    CutterLocation, LocationRequest, PlacementMethod, PositioningError, StripSide, ToleranceBand,
    ToolInclination, place, with_inclination,
};
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::{Silent, ToolPose, Uv};

const BAND: ToleranceBand = ToleranceBand { lower: 0.002, upper: 0.012 };

/// Radii of tip and barrel, half angle at the upper end, half the diameter there \[mm, rad\].
#[derive(Debug, Clone, Copy)]
struct Radii {
    tip: f64,
    barrel: f64,
    taper: f64,
    outer: f64,
}

impl Radii {
    fn cutter(&self) -> Cutter {
        let Self { tip, barrel, taper, outer } = *self;
        let spec = CutterSpec::conical_barrel(tip, barrel, taper, 2.0 * outer);
        Cutter::new(CutterSpec { length: 60.0, ..spec }).unwrap()
    }

    /// Angle from the axis, seen from the centre of either arc, at which one goes over into the other: the distance of
    /// both centres is the difference of the radii.
    fn joint(&self) -> f64 {
        let Self { tip, barrel, taper, outer } = *self;
        ((barrel * taper.cos() - outer) / (barrel - tip)).asin()
    }

    /// The profile as points `[rho, z]`, up to 40 mm along the flank.
    fn profile(&self, steps: u32) -> Vec<[f64; 2]> {
        let Self { tip, barrel, taper, outer } = *self;
        let share = |k: u32| f64::from(k) / f64::from(steps);
        let joint = self.joint();
        let low = |k: u32| {
            let angle = joint * share(k);
            [tip * angle.sin(), tip - tip * angle.cos()]
        };
        let centre = [
            tip * joint.sin() - barrel * joint.sin(),
            tip - tip * joint.cos() + barrel * joint.cos(),
        ];
        let side = |k: u32| {
            let angle = joint + (FRAC_PI_2 - taper - joint) * share(k);
            [centre[0] + barrel * angle.sin(), centre[1] - barrel * angle.cos()]
        };
        let [_, end] = side(steps);
        let flank = (0..=40).map(|k| [outer, end + f64::from(k)]);
        (0..=steps).map(low).chain((0..=steps).map(side)).chain(flank).collect()
    }

    /// Radius of the tool at a height above the tip, 0 below it.
    fn radius_at(profile: &[[f64; 2]], z: f64) -> f64 {
        let above = profile.partition_point(|[_, height]| *height <= z);
        match (above.checked_sub(1).and_then(|i| profile.get(i)), profile.get(above)) {
            (Some([r0, z0]), Some([r1, z1])) => r0 + (r1 - r0) * (z - z0) / (z1 - z0),
            _ => 0.0,
        }
    }
}

/// Least signed distance of the tool from a surface, by samples.
fn nearest(radii: &Radii, pose: &ToolPose, shape: Shape) -> f64 {
    let axis = pose.axis.into_inner();
    let across = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
    let beside = axis.cross(&across);
    let mut least = f64::INFINITY;
    for [rho, z] in radii.profile(400) {
        for k in 0..240 {
            let (sin, cos) = (TAU * f64::from(k) / 240.0).sin_cos();
            let p = pose.tip + axis * z + (across * cos + beside * sin) * rho;
            // Quadrics are meant near the origin, where no slope comes near a right angle: a point high above is not near.
            let Shape::Quadric([k1, k2]) = shape else { unreachable!() };
            let high = p.z - 0.5 * (k1 * p.x * p.x + k2 * p.y * p.y) > 1.0;
            if !high && p.x.abs().max(p.y.abs()) < 25.0 {
                least = least.min(shape.distance(&p));
            }
        }
    }
    least
}

/// Returns `true` if a point lies inside the tool, or at most 1e-6 mm outside.
fn holds(profile: &[[f64; 2]], pose: &ToolPose, p: &Point3<f64>) -> bool {
    let out = p - pose.tip;
    let z = out.dot(&pose.axis);
    let rho = (out - pose.axis.scale(z)).norm();
    rho <= Radii::radius_at(profile, z) + 1e-6
}

/// Side and inclination of a location along a heading of a quadric.
#[derive(Debug, Clone, Copy)]
struct Task {
    radii: Radii,
    shape: Shape,
    degrees: f64,
    strip: StripSide,
    /// Point of the arc, as a share of it; negative: inclined away from the strip.
    share: f64,
}

impl Task {
    fn location(&self, cutter: &Cutter) -> Result<CutterLocation, PositioningError> {
        let (face, at, feed) = self.shape.face(self.degrees);
        let request = LocationRequest {
            strip: self.strip,
            ..LocationRequest::new(&face, cutter, BAND, at.into(), feed)
        };
        let angle = cutter.contact_arc().inclinations.at(self.share.abs());
        let towards = Some(FRAC_PI_2.copysign(self.share));
        with_inclination(&request, ToolInclination { angle, towards }, None)
    }

    fn check(&self, location: &CutterLocation) {
        let Self { radii, shape, degrees, strip, .. } = *self;
        let pose = &location.pose;
        // The tool touches at the lower end of the band, and goes nowhere deeper. Samples lie beside the contact.
        let least = nearest(&radii, pose, shape);
        assert!(least >= BAND.lower - 1e-6, "{self:?}: {least}");
        assert!(least <= BAND.lower + 1e-3, "{self:?}: {least}");
        // Over the strip the material above the face is cut.
        let profile = radii.profile(20_000);
        let (face, at, _) = shape.face(degrees);
        let point = |uv: Uv| face.face().point(uv.u, uv.v);
        let (near, far) = (point(location.near), point(location.far));
        assert!((near - point(at.into())).norm() < 0.05 * location.strip_width, "{self:?}");
        for k in 0..=40 {
            let share = f64::from(k) / 40.0;
            let middle = near + (far - near) * share;
            let foot = face.closest(&middle).unwrap();
            let raised = foot.point + foot.normal.scale(BAND.upper + 1e-5);
            assert!(holds(&profile, pose, &raised), "{self:?} at {share}");
        }
        // Square to the feed, on the side asked for.
        let (sin, cos) = degrees.to_radians().sin_cos();
        let out = (far - near).dot(&Vector3::new(sin, -cos, 0.0)) * strip.sign();
        assert!(
            (out - location.strip_width).abs() < 0.02 * location.strip_width,
            "{self:?}: {out}"
        );
    }
}

/// A conical barrel of radius 85 mm and 8 mm across, of a catalogue's shape.
const CONICAL: Radii = Radii { tip: 1.0, barrel: 85.0, taper: 0.35, outer: 4.0 };

#[test]
fn a_strip_on_a_plane_is_that_of_the_large_arc() {
    let cutter = CONICAL.cutter();
    let task = Task {
        radii: CONICAL,
        shape: Shape::Quadric([0.0, 0.0]),
        degrees: 0.0,
        strip: StripSide::Right,
        share: 0.5,
    };
    let location = task.location(&cutter).unwrap();
    // Pythagoras, with the circle at the lower end of the band where the error is the band.
    let band = BAND.upper - BAND.lower;
    let wide = 2.0 * (2.0 * 85.0 * band - band * band).sqrt();
    assert!((location.strip_width - wide).abs() < 1e-6, "{} {wide}", location.strip_width);
    let inclination = location.pose.axis.angle(&Vector3::z());
    assert!((inclination - cutter.contact_arc().inclinations.middle()).abs() < 1e-9);
    task.check(&location);
}

#[test]
fn a_strip_wider_than_the_arc_ends_with_it() {
    // Nearly the radius of the arc: the strip would be 8.2 mm wide, and the arc is 8 mm long.
    let hollow = Task {
        radii: CONICAL,
        shape: Shape::Quadric([0.0, 0.9 / 85.0]),
        degrees: 0.0,
        strip: StripSide::Left,
        share: -0.5,
    };
    let cutter = CONICAL.cutter();
    let arc = cutter.contact_arc();
    let location = hollow.location(&cutter).unwrap();
    let length = arc.radius * arc.inclinations.width();
    assert!(location.strip_width > 0.8 * length && location.strip_width < length, "{location:?}");
    hollow.check(&location);
    // A strip at the end of the arc is moved onto it, and keeps its width.
    let plane = |share: f64| Task { shape: Shape::Quadric([0.0; 2]), share, ..hollow };
    let [middle, end] = [0.5, 1.0].map(|share| plane(share).location(&cutter).unwrap());
    assert!((middle.strip_width - end.strip_width).abs() < 1e-6);
    plane(1.0).check(&end);
}

/// The parabola bends less beside its vertex: a lower band shortens the strip less than on a circle.
#[test]
fn a_strip_in_a_hollow_that_opens_ends_with_the_arc() {
    let slim = Radii { tip: 0.5, barrel: 108.186_845_427_040_57, taper: 0.15, outer: 2.0 };
    let hollows = [0.93, 0.96, 0.98].map(|share| (CONICAL, share / CONICAL.barrel));
    let mut placed = 0;
    for (radii, k) in hollows.into_iter().chain([(slim, 0.008_742_539_192_495_51)]) {
        for share in [-0.2, 0.2, -0.8, 0.8] {
            let shape = Shape::Quadric([0.0, k]);
            let task = Task { radii, shape, degrees: 0.0, strip: StripSide::Left, share };
            match task.location(&radii.cutter()) {
                Ok(location) => task.check(&location),
                // The flank over the hollow that rises beside the tool.
                Err(PositioningError::Body { .. }) => continue,
                Err(error) => panic!("{task:?}: {error}"),
            }
            placed += 1;
        }
    }
    assert!(placed > 0);
}

#[test]
fn a_lens_ends_its_strip_with_its_large_arc() {
    let spec = CutterSpec { length: 60.0, ..CutterSpec::lens(100.0, 1.0, 10.0) };
    let cutter = Cutter::new(spec).unwrap();
    let (face, at, feed) = Shape::Quadric([0.0, 0.0]).face(0.0);
    let band = ToleranceBand { lower: 0.0, upper: 0.2 };
    let request = LocationRequest::new(&face, &cutter, band, at.into(), feed);
    let location = place(&request, &PlacementMethod::Ball { lead: 0.0 }).unwrap();
    // sqrt(8 R e) is 12.6 mm, the large arc 2 * 99 sin(angle) = 8.1 mm wide.
    let wide = 2.0 * 100.0 * cutter.contact_arc().inclinations.high.sin();
    assert!(location.strip_width <= wide && location.strip_width > 0.9 * wide, "{location:?}");
}

#[test]
fn a_face_that_bends_more_than_the_arc_is_refused_with_both_radii() {
    let cutter = CONICAL.cutter();
    let refused = |k: [f64; 2], degrees: f64| {
        let shape = Shape::Quadric(k);
        let task = Task { radii: CONICAL, shape, degrees, strip: StripSide::Right, share: 0.5 };
        task.location(&cutter)
    };
    let error = refused([0.0, 1.0 / 60.0], 0.0).unwrap_err();
    assert!(matches!(error, PositioningError::ConcaveArc { .. }), "{error}");
    let message = error.to_string();
    assert!(message.contains("60.000 mm") && message.contains("85.000 mm"), "{message}");
    // Fed across the hollow, the barrel turns its slim side to it.
    assert!(refused([0.0, 1.0 / 60.0], 90.0).is_ok());
    // A saddle whose directions lie aslant twists under the tool.
    assert!(refused([0.08, -0.08], 45.0).is_err());
    assert!(refused([0.01, -0.01], 45.0).is_ok());
}

#[test]
fn methods_for_the_tip_refuse_a_barrel() {
    let cutter = CONICAL.cutter();
    let (face, at, feed) = Shape::Quadric([0.0, 0.0]).face(0.0);
    let request = LocationRequest::new(&face, &cutter, BAND, at.into(), feed);
    for method in [PlacementMethod::Sturz { lead: 0.1 }, PlacementMethod::CurvatureMatched] {
        assert_eq!(place(&request, &method), Err(PositioningError::BarrelArc));
    }
    // The free search and the ball's method find the arc themselves.
    let [free, ball] = [PlacementMethod::EndPoint, PlacementMethod::Ball { lead: 0.0 }]
        .map(|method| place(&request, &method).unwrap().strip_width);
    assert!((free - ball).abs() < 1e-9);
}

proptest! {
    #![proptest_config(cases(24))]

    /// Any barrel on any saddle, hill or hollow that it fits: it touches, it goes no deeper, and it cuts all of its strip.
    #[test]
    fn locations_agree_with_the_sampled_profile(
        (tip, barrel, taper, more) in (0.5..2.0f64, 30.0..120.0f64, 0.15..0.5f64, 1.5..4.0f64),
        (k1, k2) in (-0.03..0.012f64, -0.03..0.012f64),
        degrees in 0.0..180.0f64,
        (share, right, over) in (0.2..0.8f64, any::<bool>(), any::<bool>()),
    ) {
        let radii = Radii { tip, barrel, taper, outer: tip + more };
        // Not every set of radii closes.
        prop_assume!(radii.joint() < FRAC_PI_2 - taper - 0.05);
        let task = Task {
            radii,
            shape: Shape::Quadric([k1, k2]),
            degrees,
            strip: if right { StripSide::Right } else { StripSide::Left },
            share: if over { share } else { -share },
        };
        match task.location(&radii.cutter()) {
            Ok(location) => task.check(&location),
            Err(PositioningError::ConcaveArc { concave, radius, .. }) => {
                prop_assert!(concave <= radius * (1.0 + 1e-9));
            }
            // The flank over a hollow that rises beside the tool.
            Err(PositioningError::Body { .. }) => prop_assert!(k1.max(k2) > 0.0, "{task:?}"),
            Err(error) => prop_assert!(false, "{task:?}: {error}"),
        }
    }
}

const JOB: &str = r#"schema = "trunnion-job/1"
name = "saddle"
[part]
file = "part.json"
[setup]
origin = [-381, -254, -505]
clearance = 10
[tool]
number = 1
kind = "conical-barrel"
tip_radius = 1
barrel_radius = 85
taper_angle = 20
diameter = 8
length = 80
[tolerance]
total = 0.02
gouge = 0.002
[strategy]
along = "u"
[cutting]
feed = 3000
spindle = 8000
[machine]
file = "machine.toml"
[motion]
servo_period = 0.004
[output]
dialects = ["linuxcnc"]
[verify]
grid = 0.5
"#;

/// A patch of 16 mm by 12 mm with the curvatures along both, u along x.
fn patch([k1, k2]: [f64; 2]) -> Face {
    let [wide, deep] = [8.0, 6.0];
    // Bezier ordinates of x^2 over [-h, h] are h^2, -h^2, h^2.
    let ordinate = |half: f64, i: usize| if i == 1 { -half * half } else { half * half };
    let at = |half: f64, i: usize| [-half, 0.0, half][i];
    let height = |i, j| 0.5 * (k1 * ordinate(wide, i) + k2 * ordinate(deep, j));
    let point = |i, j| Point3::new(at(wide, i), at(deep, j), height(i, j));
    let points = (0..3).map(|i| (0..3).map(|j| point(i, j)).collect()).collect();
    let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([2, 2], [knots(), knots()], points, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

fn planned(text: &str, curvatures: [f64; 2], limits: &str) -> Job {
    let machine = include_str!("../../../../machines/bc-trunnion.toml");
    let whole = "limits = [-35.0, 120.0]";
    assert!(machine.contains(whole));
    let machine = machine::parse(&machine.replace(whole, limits)).unwrap().machine;
    Job::new(job::parse(text).unwrap(), &[patch(curvatures)], &machine).unwrap()
}

const WIDE: &str = "limits = [-35.0, 120.0]";

#[test]
fn a_saddle_is_finished_in_a_few_wide_passes() {
    let job = planned(JOB, [-0.015, 0.005], WIDE);
    let outcome = pipeline::run(&job, &Silent).unwrap();
    assert!(outcome.summary.passed, "{:#?}", outcome.summary.failures);
    assert!(outcome.left_out.is_empty(), "{:#?}", outcome.left_out);
    let length = outcome.summary.cover.cutting_length;
    let ball = JOB
        .replace("conical-barrel", "ball")
        .replace("tip_radius = 1\nbarrel_radius = 85\ntaper_angle = 20\n", "");
    let ball = planned(&ball, [-0.015, 0.005], WIDE);
    let ball = pipeline::run(&ball, &Silent).unwrap();
    assert!(ball.summary.passed);
    // By the curvatures across the feed, sqrt((1 / 85 - 0.005) / (1 / 4 - 0.005)) is 0.17; run-outs add to both.
    let ratio = length / ball.summary.cover.cutting_length;
    assert!(ratio < 0.3, "{ratio}");
}

#[test]
fn a_bowl_is_refused_with_its_radius_and_that_of_the_arc() {
    let job = planned(JOB, [1.0 / 40.0, 1.0 / 50.0], WIDE);
    let error = pipeline::run(&job, &Silent).unwrap_err();
    let PipelineError::TooConcave(tight) = &error else { panic!("{error}") };
    assert!((tight.corner - 85.0).abs() < 1e-12, "{tight:?}");
    // The less concave direction decides: the arc may lie along it.
    assert!((tight.radius - 50.0).abs() < 0.5, "{tight:?}");
    let message = error.to_string();
    assert!(message.contains("large arc has a radius of 85 mm"), "{message}");
    assert!(message.contains("a ball or a corner of at most 50."), "{message}");
}

#[test]
fn a_machine_that_does_not_lean_far_enough_is_refused() {
    let job = planned(JOB, [-0.015, 0.005], "limits = [-35.0, 40.0]");
    let error = pipeline::run(&job, &Silent).unwrap_err();
    let PipelineError::OutOfReach(out) = &error else { panic!("{error}") };
    let arc = job.cutter.contact_arc().inclinations;
    assert!((out.inclinations.low - arc.low.to_degrees()).abs() < 1e-9);
    let message = error.to_string();
    assert!(message.contains("from 64.6 to 70.0 deg"), "{message}");
    assert!(message.contains("turn the workpiece"), "{message}");
    // Turned on edge, the workpiece is within reach.
    let turned = JOB.replace("clearance = 10", "clearance = 10\nrotation = [0, 60, 0]");
    pipeline::reach(&planned(&turned, [-0.015, 0.005], "limits = [-35.0, 40.0]")).unwrap();
}
