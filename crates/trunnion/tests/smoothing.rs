//! Smoothed paths against a dense search for the nearest place of the polyline.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::Vector3;
use proptest::prelude::*;
use trunnion::math::angle::{angle_between, great_circle};
use trunnion::toolpath::{Reference, SmoothError, SmoothOptions, Smoothed, Smoother, smooth};
use trunnion::types::{PoseCurve, Station, ToolPose};

const TIP: f64 = 0.01;
const AXIS: f64 = 5e-4;

fn options() -> SmoothOptions {
    SmoothOptions {
        tip: TIP,
        axis: AXIS,
        reference: Reference::Chords,
        lever: 10.0,
        corner: 0.35,
        step_ratio: 8.0,
        largest_blend: 2.0,
        window: 128,
    }
}

fn station(tip: [f64; 3], axis: [f64; 3]) -> Station {
    let pose = ToolPose::new(tip, axis).unwrap();
    Station { pose, contact: pose.tip }
}

/// Distance of a pose from the move between two stations, the larger of tip and axis in tolerances:
/// the best of many places, the projection of the tip and that of the axis among them.
fn from_move(pose: &ToolPose, [from, to]: [&Station; 2]) -> f64 {
    let chord = to.pose.tip - from.pose.tip;
    let square = chord.norm_squared();
    let by_tip = if square > 0.0 { (pose.tip - from.pose.tip).dot(&chord) / square } else { 0.0 };
    let turn = angle_between(&from.pose.axis, &to.pose.axis);
    let by_axis = if turn > 0.0 { angle_between(&from.pose.axis, &pose.axis) / turn } else { 0.0 };
    let off = |share: f64| {
        let tip = from.pose.tip + chord * share;
        let axis = great_circle(&from.pose.axis, &to.pose.axis, share).unwrap();
        ((pose.tip - tip).norm() / TIP).max(angle_between(&axis, &pose.axis) / AXIS)
    };
    let between = (0..=4).map(|k| by_tip + (by_axis - by_tip) * f64::from(k) / 4.0);
    between.map(|share| off(share.clamp(0.0, 1.0))).fold(f64::INFINITY, f64::min)
}

/// Largest distance of the curves from the polyline, in tolerances.
fn strays(curves: &[PoseCurve], stations: &[Station]) -> f64 {
    let mut worst = 0.0_f64;
    for curve in curves {
        for (span, pair) in curve.knots.windows(2).enumerate() {
            for k in 0..=9 {
                let u = pair[0] + (pair[1] - pair[0]) * f64::from(k) / 9.0;
                let pose = curve.pose_in(span, u).unwrap();
                let near = stations
                    .windows(2)
                    .filter(|pair| {
                        let reach = (pair[1].pose.tip - pair[0].pose.tip).norm() + TIP;
                        (pose.tip - pair[0].pose.tip).norm() <= reach + TIP
                    })
                    .map(|pair| from_move(&pose, [&pair[0], &pair[1]]))
                    .fold(f64::INFINITY, f64::min);
                worst = worst.max(near);
            }
        }
    }
    worst
}

/// Largest distance of stations from the curves, in tolerances.
fn missed(curves: &[PoseCurve], stations: &[Station]) -> f64 {
    let poses: Vec<ToolPose> = curves
        .iter()
        .flat_map(|curve| {
            curve.knots.windows(2).enumerate().flat_map(move |(span, pair)| {
                (0..=40).map(move |k| {
                    let u = pair[0] + (pair[1] - pair[0]) * f64::from(k) / 40.0;
                    curve.pose_in(span, u).unwrap()
                })
            })
        })
        .collect();
    let far = |station: &Station| {
        let move_to = |pair: &[ToolPose]| {
            let [from, to] = [pair[0], pair[1]].map(|pose| Station { pose, contact: pose.tip });
            from_move(&station.pose, [&from, &to])
        };
        poses.windows(2).map(move_to).fold(f64::INFINITY, f64::min)
    };
    stations.iter().map(far).fold(0.0, f64::max)
}

/// Value to third derivative agree on both sides of every knot.
fn check_c3(curve: &PoseCurve) {
    for at in 1..curve.knots.len() - 1 {
        let u = curve.knots[at];
        let [left, right] = [at - 1, at].map(|span| curve.rates_in(span, u));
        let least = (u - curve.knots[at - 1]).min(curve.knots[at + 1] - u);
        for order in 0..4 {
            let size = |v: [Vector3<f64>; 4]| v[order].norm();
            let scale = 1.0 + size(left.tip) + size(left.axis);
            // Coefficients carry the rounding of coordinates of some hundred mm.
            let rounding = 1e-11 / least.powi(i32::try_from(order).unwrap());
            let tip = (left.tip[order] - right.tip[order]).norm();
            let axis = (left.axis[order] - right.axis[order]).norm();
            assert!(
                tip.max(axis) <= 1e-9 * scale + rounding,
                "knot {at}, order {order}: {tip:e} {axis:e} of {scale:e}, span {least:e}"
            );
        }
    }
}

fn check(stations: &[Station]) -> Smoothed {
    let smoothed = smooth(stations, &options()).unwrap();
    let report = smoothed.report;
    assert!(report.deviated.tip_bound <= TIP * (1.0 + 1e-9), "{report:?}");
    assert!(report.deviated.axis_bound <= AXIS * (1.0 + 1e-9), "{report:?}");
    assert!(report.deviated.contact_bound <= TIP * (1.0 + 1e-9), "{report:?}");
    let [there, back] = [strays(&smoothed.curves, stations), missed(&smoothed.curves, stations)];
    assert!(there <= 1.0 + 1e-6 && back <= 1.0 + 1e-3, "{there} {back} {report:?}");
    let bounds = (report.deviated.tip_bound / TIP).max(report.deviated.axis_bound / AXIS);
    assert!(there <= bounds + 1e-6, "{there} {bounds}");
    let mut before: Option<&PoseCurve> = None;
    for curve in &smoothed.curves {
        check_c3(curve);
        if let Some(before) = before {
            let [end, start] = [before.pose(before.range()[1]), curve.pose(curve.range()[0])];
            assert!((end.unwrap().tip - start.unwrap().tip).norm() < 1e-9);
        }
        before = Some(curve);
    }
    assert_eq!(smoothed.curves.len(), report.stops + 1);
    smoothed
}

/// Random walk with features: arcs, noise, corners, duplicates, tiny steps, long moves, pivots.
fn any_path() -> impl Strategy<Value = Vec<Station>> {
    let feature = (0..8_u32, 3..60_usize, 0.0..1.0f64, 0.0..1.0f64, any::<u64>());
    prop::collection::vec(feature, 1..7).prop_map(walk)
}

/// Repeatable noise in -1..1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

fn walk(features: Vec<(u32, usize, f64, f64, u64)>) -> Vec<Station> {
    let (mut tip, mut heading, mut tilt) = (Vector3::new(30.0, -20.0, 5.0), 0.3_f64, [0.1, 0.2]);
    let mut all = vec![];
    for (kind, count, a, b, seed) in features {
        let mut noise = Noise(seed);
        if kind == 1 {
            heading += 0.3 + 2.5 * a;
        }
        for k in 0..count {
            let step = match kind {
                2 => 20.0 * a + 0.1,
                3 => 1e-5 * (1.0 + a),
                4 => 0.02 + 0.3 * a * if k % 2 == 0 { 1.0 } else { 0.1 },
                7 => 0.0,
                _ => 0.05 + 0.5 * a,
            };
            let turn = match kind {
                0 | 5 => step * (b - 0.5) / 2.0,
                6 => step * 0.05,
                _ => 0.0,
            };
            heading += turn;
            tip += Vector3::new(heading.cos(), heading.sin(), 0.2 * b) * step;
            tilt[0] += 0.004 * (b - 0.4) + if kind == 7 { 0.01 } else { 0.0 };
            tilt[1] += if kind == 6 { 0.006 * (0.1 * k as f64).sin() } else { 0.001 };
            let rough = if kind == 5 { [0.15 * TIP, 0.15 * AXIS] } else { [0.0; 2] };
            let mut place = tip;
            let mut axis = Vector3::new(tilt[0].sin(), tilt[1].sin(), 1.0);
            for i in 0..3 {
                place[i] += rough[0] * noise.next();
                axis[i] += rough[1] * noise.next();
            }
            all.push(station(place.into(), axis.into()));
            if kind == 3 && k % 3 == 0 {
                all.extend(all.last().copied());
            }
        }
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    #[test]
    fn random_paths_keep_tolerance_and_are_c3(stations in any_path()) {
        let moved = stations.iter().any(|s| (s.pose.tip - stations[0].pose.tip).norm() > TIP);
        prop_assume!(moved);
        check(&stations);
    }
}

#[test]
fn a_dense_circle_has_few_spans_and_no_corner() {
    let at = |k: u32| {
        let t = f64::from(k) * 0.004;
        station([20.0 * t.cos(), 20.0 * t.sin(), t], [0.3 * t.cos(), 0.3 * t.sin(), 1.0])
    };
    let stations: Vec<_> = (0..1500).map(at).collect();
    let report = check(&stations).report;
    assert_eq!((report.blended, report.stops), (0, 0));
    assert!(report.spans < 150, "{report:?}");
}
