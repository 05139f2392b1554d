//! Cutter locations against the reference cases, brute force, and symmetry.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
use crate::brute_force;

use brute_force::{Shape, Task, bezier, quadric};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use serde_json::Value;
use trunnion::cutter::{Cutter, CutterConstruction, CutterKind, CutterSpec};
use trunnion::positioning::{
    ActiveConstraint, AxisCone, ContactSide, CutterLocation, CuttingContext, LocationRequest,
    PositioningError, StripQuery, StripSide, ToleranceBand, error_curve, error_picture,
    strip_of_pose, trace, widest_strip, with_lead,
};
use trunnion::surface::FaceIndex;
use trunnion::types::{Interval, Uv};

const CASES: &str = include_str!("../../../../fixtures/positioning/cases.json");

/// The bicubic patch of the reference cases: printed rows are y, columns x; u along x.
fn patch(cases: &Value) -> FaceIndex {
    let number = |value: &Value| value.as_f64().unwrap();
    let places = &cases["patch"]["places"];
    let heights = &cases["patch"]["heights"];
    let point = |i: usize, j: usize| {
        Point3::new(number(&places[i]), number(&places[j]), number(&heights[j][i]))
    };
    bezier((0..4).map(|i| (0..4).map(|j| point(i, j)).collect()).collect())
}

fn cutter(major: f64, minor: f64) -> Cutter {
    let kind = match (major > 0.0, minor > 0.0) {
        (true, true) => CutterKind::Bull,
        (true, false) => CutterKind::Flat,
        (false, _) => CutterKind::Ball,
    };
    let shank = Vec::new();
    Cutter::new(CutterSpec { kind, length: 120.0, shank, ..CutterSpec::of_radii(major, minor) })
        .unwrap()
}

fn request<'a>(face: &'a FaceIndex, cutter: &'a Cutter, feed: [f64; 2]) -> LocationRequest<'a> {
    LocationRequest {
        offset_range: Interval::new(-0.4, 0.4),
        ..LocationRequest::new(
            face,
            cutter,
            ToleranceBand { lower: 0.0, upper: 0.01 },
            Uv::new(0.5, 0.5),
            feed,
        )
    }
}

fn heading(degrees: f64) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [cos, sin]
}

fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected}");
}

#[test]
fn the_reference_cases_are_reached() {
    let cases: Value = serde_json::from_str(CASES).unwrap();
    let face = patch(&cases);
    let bull = cutter(10.0, 6.0);
    let pair = |value: &Value| [0, 1].map(|k| value[k].as_f64().unwrap());
    for case in cases["cases"].as_array().unwrap() {
        let number = |name: &str| case[name].as_f64().unwrap();
        let ahead = number("side") > 0.0;
        let side = if ahead { ContactSide::Ahead } else { ContactSide::Behind };
        let request = LocationRequest {
            at: pair(&case["at"]).into(),
            side,
            offset_range: pair(&case["offset_range_deg"]).map(f64::to_radians).into(),
            ..request(&face, &bull, pair(&case["feed"]))
        };
        let found = widest_strip(&request, None).unwrap();
        let name = case["id"].as_str().unwrap();
        close(name, found.chord_width, number("width"), number("width_tolerance"));
        assert!(found.strip_width >= found.chord_width - 1e-3, "{name}");
        close(name, found.offset_direction.to_degrees(), number("alpha_deg"), 0.2);
        close(name, found.rotation.to_degrees(), number("theta_deg"), 0.01);
        close(name, found.arc, number("arc"), 5e-4);
        for k in 0..3 {
            close(name, found.center[k], case["center"][k].as_f64().unwrap(), 5e-3);
            close(name, found.pose.axis[k], case["axis"][k].as_f64().unwrap(), 1e-4);
        }
        for (zero, angle) in case["zeros"].as_array().unwrap().iter().zip(&found.contact_angles) {
            close(name, *angle, zero.as_f64().unwrap(), 1e-3);
        }
        assert!(found.front_min >= 0.0 && found.rear_min >= 0.0, "{name}: {found:?}");
        assert!(found.front_max <= 0.01 && found.front_max_bound >= found.front_max, "{name}");
        let warm = widest_strip(&request, Some(&found)).unwrap();
        close(name, warm.chord_width, found.chord_width, 1e-5);
        assert!(warm.queries < 250, "{name}: {} queries warm", warm.queries);
    }
}

/// Mirrored in the plane y = 0, the quadric is itself, the heading turns round and the strip
/// changes sides.
#[test]
fn a_mirrored_problem_has_the_mirrored_answer() {
    let bull = cutter(9.0, 4.0);
    for (k1, k2, degrees) in [(0.002, 0.006, 100.0), (-0.004, 0.003, 15.0), (0.0, 0.01, 70.0)] {
        let face = quadric(k1, k2);
        for side in [ContactSide::Ahead, ContactSide::Behind] {
            let right = LocationRequest { side, ..request(&face, &bull, heading(degrees)) };
            let left = LocationRequest { strip: StripSide::Left, feed: heading(-degrees), ..right };
            let (right, left) =
                (widest_strip(&right, None).unwrap(), widest_strip(&left, None).unwrap());
            close("width", left.chord_width, right.chord_width, 1e-5);
            close("alpha", left.offset_direction, right.offset_direction, 1e-4);
            close("theta", left.rotation, right.rotation, 1e-5);
            let mirror = Vector3::new(1.0, -1.0, 1.0);
            let tip = right.pose.tip.coords.component_mul(&mirror);
            assert!((left.pose.tip.coords - tip).norm() < 1e-3, "{left:?} {right:?}");
            let axis = right.pose.axis.component_mul(&mirror);
            assert!((left.pose.axis.into_inner() - axis).norm() < 1e-4);
            // The strip lies on the side asked for.
            let n = Vector3::z();
            for (location, sign, angle) in [(&right, 1.0, degrees), (&left, -1.0, -degrees)] {
                let [x, y] = heading(angle);
                let across = Vector3::new(x, y, 0.0).cross(&n) * sign;
                let far = face.face().surface.point(location.far.u, location.far.v);
                assert!(far.coords.dot(&across) > 0.9 * location.chord_width);
                let ahead = Vector3::new(x, y, 0.0).dot(&(location.contact - location.center));
                assert_eq!(ahead > 0.0, location.side == ContactSide::Ahead);
            }
        }
    }
}

/// A band that starts above zero is a larger corner radius and a narrower band.
#[test]
fn a_shifted_band_is_a_thicker_cutter() {
    let face = quadric(0.001, 0.006);
    let (thin, thick) = (cutter(8.0, 5.0), cutter(8.0, 5.004));
    let shifted = LocationRequest {
        band: ToleranceBand { lower: 0.004, upper: 0.018 },
        ..request(&face, &thin, heading(80.0))
    };
    let plain = LocationRequest {
        band: ToleranceBand { lower: 0.0, upper: 0.014 },
        ..request(&face, &thick, heading(80.0))
    };
    let (shifted, plain) =
        (widest_strip(&shifted, None).unwrap(), widest_strip(&plain, None).unwrap());
    close("width", shifted.chord_width, plain.chord_width, 1e-5);
    assert!((shifted.center - plain.center).norm() < 1e-4);
    assert!(shifted.front_min >= 0.004 && shifted.rear_min >= 0.004, "{shifted:?}");
}

#[test]
fn a_dense_look_finds_the_strip_again() {
    let face = quadric(0.002, 0.005);
    let bull = cutter(10.0, 6.0);
    let request = request(&face, &bull, heading(95.0));
    let found = widest_strip(&request, None).unwrap();
    let setting = CuttingContext { face: &face, cutter: &bull, band: request.band };
    let [x, y] = heading(95.0);
    let (feed, strip) = (Vector3::new(x, y, 0.0), request.strip);
    let look = StripQuery { feed, strip, contact: found.contact, uv: found.contact_uv };
    let strip = strip_of_pose(&setting, &found.pose, &look).unwrap();
    close("near u", strip.near.uv.u, found.near.u, 1e-5);
    close("far v", strip.far.uv.v, found.far.v, 1e-5);
    assert!(strip.front_min >= 0.0 && strip.rear_min >= 0.0);
    // Sunk by 2 um it gouges, and the check says so.
    let mut sunk = found.pose;
    sunk.tip -= sunk.axis.scale(0.002);
    let strip = strip_of_pose(&setting, &sunk, &look).unwrap();
    close("gouge", strip.front_min, -0.002, 1e-5);
}

#[test]
fn on_a_plane_the_cutter_is_as_wide_as_its_circle() {
    let face = quadric(0.0, 0.0);
    for bull in [cutter(10.0, 6.0), cutter(10.0, 0.0)] {
        let found = widest_strip(&request(&face, &bull, heading(30.0)), None).unwrap();
        assert!(found.chord_width > 0.995 * 20.0 && found.chord_width <= 20.0, "{found:?}");
        assert!(found.rear_min >= 0.0 && found.rear_min_bound > -1e-3, "{found:?}");
    }
}

#[test]
fn a_ball_on_a_plane_leaves_its_chord() {
    let face = quadric(0.0, 0.0);
    let ball = cutter(0.0, 8.0);
    let found = with_lead(&request(&face, &ball, heading(0.0)), 0.1, None).unwrap();
    // Where the cusp is 0.01 mm high: 0.01 mm above the plane the ball is that wide.
    let half = (8.0_f64.powi(2) - 7.99_f64.powi(2)).sqrt();
    close("width", found.strip_width, 2.0 * half, 1e-6);
    close("start", found.near.u, 0.5, 1e-9);
    // Strip on the right of +x: towards -y, the ball half way.
    close("contact", found.contact.y, -half, 1e-6);
    close("height", found.center.z, 8.0, 1e-9);
    // Contact ahead: the tool leans forward.
    close("lean", found.pose.axis.x, 0.1_f64.sin(), 1e-12);
}

/// A ball of 0.9 mm under 0.08 mm of excess: across its strip the normals turn by tens of degrees.
#[test]
fn the_strip_of_a_small_ball_ends_where_it_leaves_the_excess_allowed() {
    let band = ToleranceBand { lower: 0.0, upper: 0.08 };
    let ball = cutter(0.0, 0.9);
    for (k1, k2) in [(0.0, 0.0), (0.02, -0.3), (-0.4, -0.1), (0.03, 0.03)] {
        let face = quadric(k1, k2);
        for degrees in [0.0, 70.0, 200.0] {
            let request = LocationRequest { band, ..request(&face, &ball, heading(degrees)) };
            let found = with_lead(&request, 0.1, None).unwrap();
            for Uv { u, v } in [found.near, found.far] {
                let normal = face.face().normal(u, v).unwrap();
                let raised = face.face().point(u, v) + normal.scale(band.upper);
                close("reach", (raised - found.center).norm(), 0.9, 1e-8);
            }
        }
    }
}

#[test]
fn a_given_lead_is_kept() {
    let cases: Value = serde_json::from_str(CASES).unwrap();
    let face = patch(&cases);
    let bull = cutter(10.0, 6.0);
    let request = LocationRequest { at: Uv::new(0.4, 0.5), ..request(&face, &bull, [0.0, 1.0]) };
    let lead = 5.0_f64.to_radians();
    let found = with_lead(&request, lead, None).unwrap();
    close("lead", found.rotation, lead, 1e-12);
    // Inclined by 5 degrees at a contact there, the strip is 5.436 mm wide (baseline of the
    // reference cases); here the strip begins there, and the contact lies 2.7 mm beside.
    close("width", found.chord_width, 5.436, 0.03 * 5.436);
    let across = LocationRequest { offset_range: Interval::point(0.0), ..request };
    let across = with_lead(&across, lead, Some(&found)).unwrap();
    assert!(across.chord_width <= found.chord_width, "{across:?}");
    close("alpha", across.offset_direction, 0.0, 0.0);
    assert!(found.active.contains(&ActiveConstraint::GivenLead), "{:?}", found.active);
    assert!(found.front_min >= 0.0 && found.rear_min >= 0.0);
}

#[test]
fn the_tool_axis_can_be_held_near_a_direction() {
    let face = quadric(0.002, 0.005);
    let bull = cutter(10.0, 6.0);
    let free = request(&face, &bull, heading(95.0));
    let found = widest_strip(&free, None).unwrap();
    let [x, y] = heading(95.0);
    let tilt = nalgebra::Rotation3::new(Vector3::new(-y, x, 0.0) * 0.03);
    let axis = tilt * found.pose.axis;
    let held = LocationRequest { axis_cone: Some(AxisCone { axis, max_turn: 0.01 }), ..free };
    let held = widest_strip(&held, None).unwrap();
    assert!(held.pose.axis.angle(&axis) <= 0.01 + 1e-6, "{held:?}");
    assert!(held.chord_width < found.chord_width);
    assert!(held.active.contains(&ActiveConstraint::AxisTurn), "{:?}", held.active);
    assert!(held.front_min >= 0.0 && held.rear_min >= 0.0);
}

/// At the rim of a trough of 12 mm the circle of the corner keeps the band where it is sampled, and the rest of the tool goes
/// into the other wall.
#[test]
fn a_tool_far_too_wide_for_a_trough_is_refused_with_the_depth_of_its_gouge() {
    let row = |x: f64, z: f64| [-3.0, 0.0, 3.0].map(|y| Point3::new(x, y, z)).to_vec();
    let trough = bezier(vec![row(-6.0, 9.0), row(0.0, -9.0), row(6.0, 9.0)]);
    let bull = cutter(10.0, 6.0);
    let at = Uv::new(0.0, 0.5);
    let request = LocationRequest { at, ..request(&trough, &bull, [0.0, 1.0]) };
    let refused = widest_strip(&request, None).unwrap_err();
    let PositioningError::NoStrip { excess, .. } = refused else { panic!("{refused}") };
    assert!(excess > 1.0, "{excess}");
}

#[test]
fn what_does_not_fit_is_refused_with_the_reason() {
    let bull = cutter(10.0, 6.0);
    let steep = quadric(0.0, 0.2);
    let refused = widest_strip(&request(&steep, &bull, heading(0.0)), None).unwrap_err();
    assert!(matches!(refused, PositioningError::ConcaveRadius { .. }), "{refused}");
    assert!(refused.to_string().contains("5.000 mm"), "{refused}");
    // A trough of 7 mm radius holds the corner of 6 mm, but not the whole cutter across it.
    let trough = quadric(0.0, 1.0 / 7.0);
    let refused = widest_strip(&request(&trough, &bull, heading(0.0)), None).unwrap_err();
    let fits_not =
        matches!(refused, PositioningError::NoStrip { .. } | PositioningError::Body { .. });
    assert!(fits_not, "{refused}");
    let flat = quadric(0.0, 0.0);
    let feed = LocationRequest { feed: [0.0, 0.0], ..request(&flat, &bull, heading(0.0)) };
    assert!(matches!(widest_strip(&feed, None), Err(PositioningError::NoDirection { .. })));
    let band = ToleranceBand { lower: 0.01, upper: 0.01 };
    let empty = LocationRequest { band, ..request(&flat, &bull, heading(0.0)) };
    assert!(matches!(widest_strip(&empty, None), Err(PositioningError::EmptyBand { .. })));
    let spec = CutterSpec {
        construction: CutterConstruction::Insert { inner_cutting_radius: 8.0 },
        ..bull.spec().clone()
    };
    let insert = Cutter::new(spec).unwrap();
    let behind =
        LocationRequest { side: ContactSide::Either, ..request(&flat, &insert, heading(0.0)) };
    assert!(matches!(widest_strip(&behind, None), Err(PositioningError::NotCentreCutting { .. })));
}

/// Inserts cut outside their inner cutting radius only: a contact inside is refused.
#[test]
fn contacts_that_do_not_cut_are_refused() {
    let cases: Value = serde_json::from_str(CASES).unwrap();
    let face = patch(&cases);
    let insert = |inner_cutting_radius: f64| {
        let construction = CutterConstruction::Insert { inner_cutting_radius };
        Cutter::new(CutterSpec { construction, ..cutter(10.0, 6.0).spec().clone() }).unwrap()
    };
    // Leaning by 2.4 degrees over a nearly flat place, the corner touches a little outside its
    // circle of 10 mm.
    let (cuts, idle) = (insert(9.5), insert(11.5));
    let at = Uv::new(0.4, 0.5);
    assert!(
        widest_strip(&LocationRequest { at, ..request(&face, &cuts, [0.0, 1.0]) }, None).is_ok()
    );
    let refused = widest_strip(&LocationRequest { at, ..request(&face, &idle, [0.0, 1.0]) }, None)
        .unwrap_err();
    assert!(matches!(refused, PositioningError::NotCutting { .. }), "{refused}");
    assert!(refused.to_string().contains("11.5 mm"), "{refused}");
}

/// Under the disc and the rear as well, where the strip itself lies under the inserts.
#[test]
fn inserts_do_not_touch_with_what_does_not_cut() {
    let bull = cutter(9.0, 4.0);
    let mut refused = 0;
    for k in [[-0.002, -0.02], [-0.01, -0.02], [-0.02, -0.002], [-0.01, 0.002], [0.004, 0.01]] {
        for degrees in [0.0, 40.0, 90.0] {
            let face = quadric(k[0], k[1]);
            let solid = request(&face, &bull, heading(degrees));
            let Ok(found) = widest_strip(&solid, None) else { continue };
            if !found
                .active
                .iter()
                .any(|a| matches!(a, ActiveConstraint::Disc | ActiveConstraint::Rear))
            {
                continue;
            }
            // As far from the axis as the strip's own points, less a hair.
            let out = |Uv { u, v }: Uv| {
                let from_tip = face.face().surface.point(u, v) - found.pose.tip;
                found.pose.axis.cross(&from_tip).norm()
            };
            let strip = [found.near, found.contact_uv, found.far].map(out);
            let inner_cutting_radius = strip.into_iter().fold(f64::INFINITY, f64::min) - 1e-3;
            let construction = CutterConstruction::Insert { inner_cutting_radius };
            let insert = Cutter::new(CutterSpec { construction, ..bull.spec().clone() }).unwrap();
            let answer = widest_strip(&LocationRequest { cutter: &insert, ..solid }, None);
            match answer {
                Ok(_) => {}
                Err(PositioningError::NotCutting { radius, inner, .. }) => {
                    assert!(radius < inner - 1e-3, "{radius} {inner}");
                    refused += 1;
                }
                Err(error) => panic!("{error}"),
            }
        }
    }
    assert!(refused > 0);
}

/// The error curves of paper 004, figures 10 (U: feed u) and 11 (W: feed v), drawn again.
#[test]
fn the_error_curves_look_as_they_did() {
    let cases: Value = serde_json::from_str(CASES).unwrap();
    let face = patch(&cases);
    let bull = cutter(10.0, 6.0);
    let figures = [
        ("figure-10.svg", [1.0, 0.0], ContactSide::Behind, 75.0_f64),
        ("figure-11.svg", [0.0, 1.0], ContactSide::Ahead, 15.0),
    ];
    for (name, feed, side, range) in figures {
        let range = range.to_radians();
        let offset_range = Interval::new(-range, range);
        let at = Uv::new(0.4, 0.5);
        let request = LocationRequest { at, side, offset_range, ..request(&face, &bull, feed) };
        let found = widest_strip(&request, None).unwrap();
        let trace = trace(&request, &found, "end-point").unwrap();
        let setting = CuttingContext { face: &face, cutter: &bull, band: request.band };
        let jet = face.face().surface.jet1(at.u, at.v);
        let look = StripQuery {
            feed: jet.su * feed[0] + jet.sv * feed[1],
            strip: request.strip,
            contact: found.contact,
            uv: found.contact_uv,
        };
        let curve = error_curve(&setting, &found.pose, &look, 360).unwrap();
        assert_eq!(curve.len(), trace.points.len());
        for (point, expected) in trace.points.iter().zip(curve) {
            assert!(expected.error >= -1e-9, "{name}: {}", expected.error);
            close("angle", point.angle, expected.angle, 1e-9);
            close("error", point.error, expected.error, 1e-9);
        }
        let title =
            format!("Feed ({}, {}): strip of {:.3} mm", feed[0], feed[1], found.strip_width);
        let drawn = error_picture(&trace, request.band, &title);
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/positioning");
        let path = format!("{folder}/{name}");
        if std::env::var_os("UPDATE_EXPECT").is_some() {
            std::fs::write(&path, &drawn).unwrap();
        }
        let kept = std::fs::read_to_string(&path).unwrap();
        assert!(same_picture(&drawn, &kept), "{name} has changed; UPDATE_EXPECT=1 redraws it");
    }
}

/// Word for word the same but for numbers, which may differ by a pixel: the optimum is found to
/// its rounding only.
fn same_picture(a: &str, b: &str) -> bool {
    let words = |text: &str| -> Vec<String> {
        text.split([' ', ',', '"', '<', '>', 'V', 'M']).map(str::to_owned).collect()
    };
    let (a, b) = (words(a), words(b));
    let alike = |(x, y): (&String, &String)| match (x.parse::<f64>(), y.parse::<f64>()) {
        (Ok(x), Ok(y)) => (x - y).abs() <= 1.0,
        _ => x == y,
    };
    a.len() == b.len() && a.iter().zip(&b).all(alike)
}

#[test]
fn a_wall_near_the_shank_is_seen() {
    // A trough of 40 mm radius: the cutter of 16 mm fits, a holder of 45 mm radius does not.
    let trough = quadric(0.0, 0.025);
    let spec = CutterSpec { shank: vec![[20.0, 45.0]], ..cutter(10.0, 6.0).spec().clone() };
    let wide = Cutter::new(spec).unwrap();
    let slim = cutter(10.0, 6.0);
    assert!(widest_strip(&request(&trough, &slim, heading(0.0)), None).is_ok());
    let refused = widest_strip(&request(&trough, &wide, heading(0.0)), None).unwrap_err();
    assert!(matches!(refused, PositioningError::Body { .. }), "{refused}");
}

#[test]
fn strips_may_run_off_the_edge() {
    let cases: Value = serde_json::from_str(CASES).unwrap();
    let face = patch(&cases);
    let bull = cutter(10.0, 6.0);
    for at in [[0.0, 0.5], [-0.1, 0.3], [0.5, 1.1]] {
        let request = LocationRequest { at: at.into(), ..request(&face, &bull, [0.0, 1.0]) };
        let found = widest_strip(&request, None).unwrap();
        assert!(found.front_min >= 0.0 && found.rear_min >= 0.0, "{at:?} {found:?}");
        assert!(found.chord_width > 1.0, "{at:?} {}", found.chord_width);
    }
}

/// Strips that a search once fell into too narrow a one of.
const NARROW: [Task; 2] = [
    Task {
        shape: Shape::Quadric([0.011_111_500_713_671_231, 0.013_945_881_755_982_64]),
        major: 8.631_714_266_910_894,
        minor: 5.761_660_641_670_808,
        band: ToleranceBand { lower: 0.0, upper: 0.029_318_862_650_584_83 },
        degrees: 236.602_902_304_506,
        left: false,
        behind: false,
    },
    Task {
        shape: Shape::Quadric([0.013_466_585_050_743_832, -0.028_640_868_884_778_514]),
        major: 7.138_297_535_191_571,
        minor: 7.772_753_930_648_177,
        band: ToleranceBand { lower: 0.0, upper: 0.022_611_551_953_383_39 },
        degrees: 63.520_245_259_565_2,
        left: true,
        behind: false,
    },
];

/// What is wrong with the answer to a task, if anything is: cold against brute force, and warm,
/// from the answer a millimetre behind, against a dense look.
fn complaint(task: &Task, trials: u32) -> Option<String> {
    let (face, at, feed) = task.shape.face(task.degrees);
    let cutter = cutter(task.major, task.minor);
    let strip = if task.left { StripSide::Left } else { StripSide::Right };
    let side = if task.behind { ContactSide::Behind } else { ContactSide::Ahead };
    let request = LocationRequest {
        strip,
        side,
        band: task.band,
        at: at.into(),
        ..request(&face, &cutter, feed)
    };
    let found = widest_strip(&request, None);
    let (best, x) = task.best(request.offset_range.ends(), trials);
    let found = match found {
        Ok(found) => found,
        // Of the shank the trials know nothing.
        Err(PositioningError::Body { .. }) if task.shank_touches(x) => return None,
        Err(error) => return Some(format!("{task:?}: {error}; brute force {best} at {x:?}")),
    };
    if let Some(wrong) = breach(task, &found) {
        return Some(format!("{task:?}: {wrong}"));
    }
    let behind = LocationRequest { at: [0, 1].map(|k| at[k] - feed[k]).into(), ..request };
    let neighbour = widest_strip(&behind, None).ok();
    let warm = neighbour.and_then(|neighbour| widest_strip(&request, Some(&neighbour)).ok());
    if let Some(wrong) = warm.as_ref().and_then(|warm| breach(task, warm)) {
        return Some(format!("{task:?}: warm: {wrong}"));
    }
    // An error above the band next to an end point ends the strip before it.
    let kept = found.chord_width * (1.0 - shortfall(task, &found) / found.offset);
    (found.chord_width < 0.995 * best || kept < 0.995 * best.max(found.chord_width)).then(|| {
        let CutterLocation { chord_width, offset, offset_direction, rotation, active, .. } = &found;
        let own = [*offset, *offset_direction, *rotation];
        let shares = [chord_width / best, kept / best];
        format!("{task:?}: {shares:?}, {chord_width} {own:?} < {best} {x:?}: {active:?}")
    })
}

/// By how much the strip ends short of the end points \[mm\]; 0 where it goes beyond them.
fn shortfall(task: &Task, found: &CutterLocation) -> f64 {
    let (face, at, _) = task.shape.face(task.degrees);
    let at = Uv::from(at);
    let point = |uv: Uv| face.face().surface.point(uv.u, uv.v);
    let chord = point(found.end) - point(at);
    let short = |from: Uv, to: Uv, sign: f64| {
        (sign * chord.dot(&(point(to) - point(from)))).max(0.0) / chord.norm()
    };
    short(at, found.near, 1.0) + short(found.end, found.far, -1.0)
}

/// Whether a dense look finds errors outside the band, or outside the bounds given.
fn breach(task: &Task, found: &CutterLocation) -> Option<String> {
    // Rounding of the trials' own distances \[mm\].
    const ROUNDING: f64 = 1e-7;
    let own = [found.offset, found.offset_direction, found.rotation];
    let least = task.deepest(&found.pose.tip, &found.pose.axis);
    let most = task.highest(own);
    let kept = least >= task.band.lower - ROUNDING;
    // An error above the band cuts the strip short, which its ends tell.
    let whole = shortfall(task, found) <= 1e-4 * found.chord_width;
    let bounded = least >= found.rear_min_bound - ROUNDING
        && (!whole || most <= found.front_max_bound + ROUNDING);
    (!kept || !bounded).then(|| format!("error {least} .. {most}: {found:?}"))
}

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).ok().and_then(|n| n.parse().ok()).unwrap_or(otherwise)
}

/// `POSITIONING_CASES` tasks of the seed `POSITIONING_SEED`; one alone: `POSITIONING_CASE`.
#[test]
fn never_a_gouge_and_hardly_ever_wider_by_brute_force() {
    let [seed, count] =
        [("POSITIONING_SEED", 1), ("POSITIONING_CASES", 12)].map(|(n, x)| number(n, x));
    let trials = u32::try_from(number("POSITIONING_TRIALS", 6000)).unwrap();
    eprintln!("seed {seed}, {count} cases, {trials} trials each");
    let only = number("POSITIONING_CASE", u64::MAX);
    let cases =
        (0..u32::try_from(count).unwrap()).filter(|c| only == u64::MAX || u64::from(*c) == only);
    let failures: Vec<String> = cases
        .collect::<Vec<u32>>()
        .into_par_iter()
        .filter_map(|case| {
            let wrong = complaint(&brute_force::task(seed, case), trials)?;
            Some(format!("{case}: {wrong}"))
        })
        .collect();
    assert!(failures.is_empty(), "{} of {count}\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn strips_once_found_too_narrow_are_wide() {
    let failures: Vec<String> = NARROW.iter().filter_map(|task| complaint(task, 6000)).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
