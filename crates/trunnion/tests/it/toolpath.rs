//! Tool paths against reference cases and against properties any curve through stations has.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::shop;

use nalgebra::{Point3, UnitVector3, Vector3};
use num_dual::{Dual3_64, DualNum};
use proptest::prelude::*;
use shop::Layout;
use std::ops::ControlFlow;
use std::sync::Mutex;
use trunnion::inverse::Inverse;
use trunnion::math::angle::angle_between;
use trunnion::toolpath::{
    GreatCircle, InterpolationError, PathResolution, SmoothError, SmoothOptions, SmoothReference,
    ToolPathError, ToolPathOptions, densify, deviation, great_circle, local_cubic, smooth,
    smoothed, through,
};
use trunnion::types::Interval;
use trunnion::types::{
    AxisVector, Leg, Motion, PoseCurve, PoseTolerance, Progress, Silent, Stage, Station, ToolPose,
};

fn unit(v: &serde_json::Value) -> UnitVector3<f64> {
    let [x, y, z] = [0, 1, 2].map(|i| v[i].as_f64().unwrap());
    UnitVector3::new_normalize(Vector3::new(x, y, z))
}

#[test]
fn great_circles_agree_with_the_reference_cases() {
    let text = include_str!("../../../../fixtures/slerp/slerp.json");
    let cases: serde_json::Value = serde_json::from_str(text).unwrap();
    for case in cases["slerp"].as_array().unwrap() {
        let got = great_circle(&unit(&case["a"]), &unit(&case["b"]), case["t"].as_f64().unwrap());
        if case["expect"].is_string() {
            assert_eq!(got, None, "{case}");
            continue;
        }
        let (got, tolerance) = (got.unwrap(), case["tol"].as_f64().unwrap());
        for i in 0..3 {
            assert!((got[i] - case["expect"][i].as_f64().unwrap()).abs() <= tolerance, "{case}");
        }
    }
}

fn numbers(v: &serde_json::Value) -> AxisVector {
    AxisVector::from_fn(|i, _| {
        let value = v[i].as_f64().unwrap();
        if i < 3 { value } else { value.to_radians() }
    })
}

/// Largest distance in mm and in degrees.
fn apart(a: &AxisVector, b: &AxisVector) -> [f64; 2] {
    let d = (a - b).abs();
    [d.fixed_rows::<3>(0).amax(), d.fixed_rows::<2>(3).amax().to_degrees()]
}

/// Every inserted block of the paper's listing is the middle of straight tip and great circle.
#[test]
fn inserting_reproduces_the_listing_of_paper_003() {
    let text = include_str!("../../../../fixtures/paper-003/listing.json");
    let cases: serde_json::Value = serde_json::from_str(text).unwrap();
    let kinematics = shop::kinematics(Layout::TableHead);
    let inverse = Inverse::new(&kinematics).unwrap();
    for case in cases["listing"].as_array().unwrap() {
        let [from, to] = ["from_XYZAB", "to_XYZAB"].map(|key| numbers(&case[key]));
        let ends = [from, to].map(|q| kinematics.forward(&q));
        let turn = angle_between(&ends[0].axis, &ends[1].axis).to_degrees();
        assert!((turn - case["angle_deg"].as_f64().unwrap()).abs() < 1e-9);
        let limit = PathResolution { max_step: f64::INFINITY, max_turn: 0.08 };
        let fine = densify(&ends, limit, &Silent).unwrap();
        assert_eq!(fine.len(), 3, "5 degrees are more than 0.08 rad, half of it is not");
        let middle = inverse.near(&fine[1], &from).unwrap();
        let [mm, deg] = apart(&middle, &numbers(&case["mid_XYZAB"]));
        assert!(mm <= 1e-9 && deg <= 1e-9, "{mm:e} mm {deg:e} deg");
        let mut printed = numbers(&case["paper_inserted"]);
        if case["paper_misprint"].as_bool().unwrap() {
            assert!(apart(&middle, &printed)[0] > 0.4);
            (printed[1], printed[2]) = (35.705, 53.415); // N105 put right
        }
        let [mm, deg] = apart(&middle, &printed);
        // Half a unit of the last of three digits, printed in both ends and in the middle; of A at 64 mm.
        assert!(mm <= 0.0013 && deg <= 0.0013, "{mm} mm {deg} deg");
        let eta = (0..=2000).map(|k| {
            let t = f64::from(k) / 2000.0;
            let even = kinematics.forward(&from.lerp(&to, t)).axis;
            angle_between(&even, &great_circle(&ends[0].axis, &ends[1].axis, t).unwrap())
        });
        let eta = eta.fold(0.0, f64::max).to_degrees();
        assert!((eta - case["eta_linear_max_deg"].as_f64().unwrap()).abs() < 1e-7, "{eta}");
    }
}

/// The formula of great circles, put right, differentiated by dual numbers.
fn slerp(a: &Vector3<f64>, b: &Vector3<f64>, t: f64) -> [Vector3<f64>; 4] {
    let (t, angle) = (Dual3_64::from(t).derivative(), a.angle(b));
    let weights = [((-t + 1.0) * angle).sin(), (t * angle).sin()];
    let parts = [0, 1, 2].map(|i| (weights[0] * a[i] + weights[1] * b[i]) / angle.sin());
    let order = |of: fn(&Dual3_64) -> f64| Vector3::from(parts.map(|part| of(&part)));
    [order(|p| p.re), order(|p| p.v1), order(|p| p.v2), order(|p| p.v3)]
}

/// A tool that rolls over a nose: contact on a circle, axis along its normal, tip on the contact.
fn nose(angle: f64, radius: f64) -> Station {
    let axis = UnitVector3::new_normalize(Vector3::new(angle.sin(), 0.2, angle.cos()));
    let contact = Point3::new(radius * angle.sin(), 0.0, radius * angle.cos());
    Station { pose: ToolPose { tip: contact, axis }, contact }
}

#[test]
fn the_spline_falls_with_the_fourth_power_of_the_step() {
    let worst = |steps: u32| {
        let stations: Vec<_> =
            (0..=steps).map(|i| nose(1.2 * f64::from(i) / f64::from(steps), 20.0)).collect();
        let curve = PoseCurve::through(&stations, 16.0);
        let Interval { low: start, high: end } = curve.range();
        let middle = start + 0.5 * (end - start);
        (0..=200)
            .map(|i| middle + 0.1 * (end - start) * f64::from(i) / 200.0)
            .map(|u| (curve.rates(u).contact[0].norm() - 20.0).abs())
            .fold(0.0, f64::max)
    };
    let [coarse, fine] = [worst(10), worst(20)];
    assert!(coarse < 1e-3 && coarse / fine > 12.0, "{coarse:e} -> {fine:e}");
}

#[test]
fn deviation_of_a_circle_is_its_sagitta() {
    let stations: Vec<_> = (0..=12).map(|i| nose(0.1 * f64::from(i), 20.0)).collect();
    let legs = [Leg { motion: Motion::Cut, stations }];
    let path = through(&legs, &ToolPathOptions::with_lever(16.0), &Silent).unwrap();
    let found = deviation(&path, 9);
    let sagitta = 20.0 * (1.0 - (0.05f64).cos());
    // The end spans are off the circle by O(step⁴), here 5e-5 mm.
    assert!((found.tip - sagitta).abs() < 1e-4, "{found:?}");
    assert!(found.axis > 0.0 && found.axis < 0.01, "{found:?}");
}

#[test]
fn a_stop_is_a_typed_error() {
    struct Stop;
    impl Progress for Stop {
        fn report(&self, stage: Stage, _: u64, _: u64) -> ControlFlow<()> {
            assert_eq!(stage, Stage::ToolPath);
            ControlFlow::Break(())
        }
    }
    let legs = [Leg { motion: Motion::Cut, stations: vec![nose(0.0, 9.0), nose(0.1, 9.0)] }];
    let stopped = through(&legs, &ToolPathOptions::with_lever(16.0), &Stop);
    assert!(matches!(stopped, Err(ToolPathError::Cancelled(_))));
}

/// Stops when so many steps are done, and keeps the last report.
struct StopAt {
    done: u64,
    last: Mutex<(u64, u64)>,
}

impl Progress for StopAt {
    fn report(&self, stage: Stage, done: u64, total: u64) -> ControlFlow<()> {
        assert_eq!(stage, Stage::ToolPath);
        let mut last = self.last.lock().unwrap();
        assert!(last.0 <= done && done <= total);
        *last = (done, total);
        if done >= self.done { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn long_paths_are_stopped_in_the_middle() {
    let stop_at = |done| StopAt { done, last: Mutex::new((0, 0)) };
    let stations: Vec<_> = (0..2000).map(|i| nose(0.001 * f64::from(i), 20.0)).collect();
    let within = PoseTolerance { tip: 0.005, axis: 1e-4 };
    for reference in [SmoothReference::Chords, SmoothReference::Curve] {
        let mut options = SmoothOptions::within(within);
        options.reference = reference;
        let stop = stop_at(700);
        assert!(matches!(smooth(&stations, &options, &stop), Err(SmoothError::Cancelled(_))));
        let (done, total) = *stop.last.lock().unwrap();
        assert!((700..1000).contains(&done) && total == 2000, "{done} of {total}");
        // Legs count as their stations, and the second is stopped in its middle.
        let legs = [0, 1].map(|_| Leg { motion: Motion::Cut, stations: stations.clone() });
        let legs = [
            legs[0].clone(),
            Leg { motion: Motion::Link, stations: vec![stations[1999], stations[0]] },
            legs[1].clone(),
        ];
        let (stop, path) = (stop_at(2700), ToolPathOptions::with_lever(16.0));
        let stopped = smoothed(&legs, &path, &options, &stop);
        assert!(matches!(stopped, Err(ToolPathError::Cancelled(_))), "{stopped:?}");
        let (done, total) = *stop.last.lock().unwrap();
        assert!((2700..3000).contains(&done) && total == 4002, "{done} of {total}");
    }
    let poses: Vec<_> = stations.iter().map(|station| station.pose).collect();
    // One move of many parts is stopped as well.
    for (path, done) in [(&poses[..], 1000), (&poses[..2], 0)] {
        let stop = stop_at(done);
        let stopped = densify(path, PathResolution { max_step: 1e-6, max_turn: 1.0 }, &stop);
        assert!(matches!(stopped, Err(InterpolationError::Cancelled(_))));
        assert_eq!(*stop.last.lock().unwrap(), (done, path.len() as u64 - 1));
    }
}

proptest! {
    /// The curve passes through every station, is C2 at each, and its axis is unit there.
    #[test]
    fn curves_pass_through_their_stations(
        steps in prop::collection::vec((0.1..9.0f64, -3.0..3.0f64, -0.2..0.2f64), 1..30),
    ) {
        let (mut x, mut stations) = (0.0, vec![nose(0.0, 50.0)]);
        for (dx, y, turn) in steps {
            x += dx;
            let contact = Point3::new(x, y, 0.0);
            let axis = UnitVector3::new_normalize(Vector3::new(turn, -turn, 1.0));
            stations.push(Station { pose: ToolPose { tip: contact - *axis, axis }, contact });
        }
        let curve = PoseCurve::through(&stations, 16.0);
        for (i, (station, &knot)) in stations.iter().zip(&curve.knots).enumerate() {
            let here = curve.rates(knot);
            prop_assert!((here.tip[0] - station.pose.tip.coords).norm() < 1e-9);
            prop_assert!((here.axis[0] - *station.pose.axis).norm() < 1e-11);
            prop_assert!((here.contact[0] - station.contact.coords).norm() < 1e-9);
            if i > 0 && i + 1 < stations.len() {
                let before = curve.rates_in(i - 1, knot);
                for order in 0..3 {
                    let size = 1.0 + before.tip[order].norm();
                    prop_assert!((before.tip[order] - here.tip[order]).norm() < 1e-8 * size);
                    prop_assert!((before.axis[order] - here.axis[order]).norm() < 1e-8 * size);
                }
            }
        }
    }

    /// Derivatives of great circles against dual numbers.
    #[test]
    fn great_circles_have_exact_derivatives(
        a in prop::array::uniform3(-1.0..1.0f64),
        b in prop::array::uniform3(-1.0..1.0f64),
        t in -0.2..1.2f64,
    ) {
        let [a, b] = [a, b].map(|v| UnitVector3::try_new(Vector3::from(v), 1e-3));
        let (Some(a), Some(b)) = (a, b) else { return Ok(()) };
        let angle = angle_between(&a, &b);
        prop_assume!(angle > 1e-2 && angle < 3.1);
        let got = GreatCircle::new(&a, &b).unwrap().derivatives(t);
        for (order, (got, want)) in got.iter().zip(slerp(&a, &b, t)).enumerate() {
            prop_assert!((got - want).norm() < 1e-11, "order {order}: {got} {want}");
        }
    }

    /// However small the turn, the end is met and the derivatives are those of even turning; nothing
    /// is divided by the angle.
    #[test]
    fn small_turns_keep_their_digits(exponent in -17.0..-1.0f64, way in 0.0..6.3f64, t in 0.0..1.0f64) {
        let angle = 10f64.powf(exponent);
        let a = UnitVector3::new_normalize(Vector3::new(0.3, -0.4, 0.8));
        let side = UnitVector3::new_normalize(a.cross(&Vector3::new(way.cos(), way.sin(), 0.1)));
        let b = UnitVector3::new_normalize(*a + *side * angle.tan());
        let turn = GreatCircle::new(&a, &b).unwrap();
        prop_assert!((turn.derivatives(1.0)[0] - *b).norm() < 1e-15);
        let [axis, rate, second, third] = turn.derivatives(t);
        let whole = turn.angle();
        prop_assert!((axis.norm() - 1.0).abs() < 1e-15 && rate.dot(&axis).abs() <= 1e-15 * whole);
        prop_assert!((rate.norm() - whole).abs() <= 1e-14 * whole);
        prop_assert!((second + axis * (whole * whole)).norm() <= 1e-14 * whole * whole);
        prop_assert!((third + rate * (whole * whole)).norm() <= 1e-14 * whole.powi(3));
    }

    /// Derivatives of the local cubic against dual numbers in the same polynomial, and its value
    /// against finite differences.
    #[test]
    fn local_cubics_have_exact_derivatives(t in 0.0..1.0f64, radius in 5.0..50.0f64) {
        let stations: Vec<_> = (0..7).map(|k| nose(0.12 * f64::from(k), radius)).collect();
        let curve = local_cubic(&stations, 16.0).unwrap();
        let u = curve.knots[2] + t * (curve.knots[4] - curve.knots[2]);
        let span = curve.span_at(u);
        let x = Dual3_64::from(u - curve.knots[span]).derivative();
        let rates = curve.rates(u);
        for i in 0..3 {
            let c = curve.spans[span].coefficients.map(|c| c[3 + i]);
            let value = c.iter().rev().fold(Dual3_64::from(0.0), |sum, &c| sum * x + c);
            for (got, want) in rates.axis.iter().zip([value.re, value.v1, value.v2, value.v3]) {
                prop_assert!((got[i] - want).abs() < 1e-14 * (1.0 + want.abs()));
            }
        }
        let h = 1e-4;
        let [before, after] = [u - h, u + h].map(|u| curve.rates_in(span, u).tip[0]);
        prop_assert!(((after - before) / (2.0 * h) - rates.tip[1]).norm() < 1e-6);
    }
}
