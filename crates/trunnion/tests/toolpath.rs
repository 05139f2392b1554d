//! Tool paths against reference cases and against properties any curve through stations has.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, UnitVector3, Vector3};
use proptest::prelude::*;
use std::ops::ControlFlow;
use trunnion::toolpath::{ToolPathError, ToolPathOptions, deviation, great_circle, through};
use trunnion::types::{Leg, Motion, PoseCurve, Progress, Silent, Stage, Station, ToolPose};

fn unit(v: &serde_json::Value) -> UnitVector3<f64> {
    let [x, y, z] = [0, 1, 2].map(|i| v[i].as_f64().unwrap());
    UnitVector3::new_normalize(Vector3::new(x, y, z))
}

#[test]
fn great_circles_agree_with_the_reference_cases() {
    let text = include_str!("../../../fixtures/slerp/slerp.json");
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
        let [start, end] = curve.range();
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
    let path = through(&legs, &ToolPathOptions { lever: 16.0 }, &Silent).unwrap();
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
    let stopped = through(&legs, &ToolPathOptions { lever: 16.0 }, &Stop);
    assert!(matches!(stopped, Err(ToolPathError::Cancelled(_))));
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
}
