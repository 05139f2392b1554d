//! Smoothed paths against a dense search for the nearest place of the polyline.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;
use crate::shop;

use nalgebra::Vector3;
use proptest::prelude::*;
use shop::Layout;
use trunnion::inverse::Inverse;
use trunnion::math::angle::{angle_between, great_circle};
use trunnion::toolpath::{PathSmoother, SmoothError, SmoothOptions, SmoothedCurves, smooth};
use trunnion::types::Interval;
use trunnion::types::{AxisVector, PoseCurve, PoseTolerance, Silent, Station, ToolPose};

const TIP: f64 = 0.01;
const AXIS: f64 = 5e-4;

fn options() -> SmoothOptions {
    let mut options = SmoothOptions::within(PoseTolerance { tip: TIP, axis: AXIS });
    options.window = 128;
    options
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
            // Coefficients carry the rounding of some ten mm.
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

fn check(stations: &[Station]) -> SmoothedCurves {
    let smoothed = smooth(stations, &options(), &Silent).unwrap();
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
            let [end, start] = [before.pose(before.range().high), curve.pose(curve.range().low)];
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
    #![proptest_config(property::cases(8))]
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

/// The nose of a blade as the machine of paper 003 cuts it: A turns, B breathes about 12.5 degrees.
fn nose(turn: f64) -> Station {
    let b = (12.5 + 0.4 * turn.sin()).to_radians();
    let axis = [b.sin(), -turn.sin() * b.cos(), turn.cos() * b.cos()];
    station([0.3 * turn, -5.0 * turn.sin(), 5.0 * turn.cos()], axis)
}

#[test]
fn the_nose_of_a_blade_is_met_between_its_stations() {
    let step = 4.93_f64.to_radians();
    let stations: Vec<_> = (0..=28).map(|k| nose(0.4 + step * f64::from(k))).collect();
    let straight = stations.windows(2).enumerate().map(|(k, pair)| {
        let middle = great_circle(&pair[0].pose.axis, &pair[1].pose.axis, 0.5).unwrap();
        angle_between(&middle, &nose(0.4 + step * (k as f64 + 0.5)).pose.axis)
    });
    let straight = straight.fold(0.0, f64::max).to_degrees();
    assert!((straight - 0.0113).abs() < 0.0005, "{straight} deg");
    let mut wide = options();
    wide.axis = 0.03_f64.to_radians();
    let smoothed = smooth(&stations, &wide, &Silent).unwrap();
    let curve = &smoothed.curves[0];
    let Interval { low: start, high: end } = curve.range();
    let worst = (0..=2000).map(|k| {
        let pose = curve.pose(start + (end - start) * f64::from(k) / 2000.0).unwrap();
        // The place of the true curve with this turn, and a little around it.
        let turn = (-pose.tip.y).atan2(pose.tip.z);
        let off = |turn: f64| angle_between(&nose(turn).pose.axis, &pose.axis);
        (-50..=50).map(|i| off(turn + 1e-7 * f64::from(i))).fold(f64::INFINITY, f64::min)
    });
    let worst = worst.fold(0.0, f64::max).to_degrees();
    assert!(worst <= 0.00005, "{worst} deg");
}

#[test]
fn corners_are_blended_or_kept_and_reversed_axes_refused() {
    let line = |from: [f64; 2], way: [f64; 2]| {
        (0..20).map(move |k| {
            let s = 0.5 * f64::from(k);
            station([from[0] + s * way[0], from[1] + s * way[1], 0.0], [0.1, 0.0, 1.0])
        })
    };
    let corner: Vec<_> = line([0.0, 0.0], [1.0, 0.0]).chain(line([9.5, 0.5], [0.0, 1.0])).collect();
    let report = check(&corner).report;
    assert_eq!((report.blended, report.stops), (1, 0), "{report:?}");
    assert!(report.deviated.tip > 0.3 * TIP, "the tolerance is used: {report:?}");
    let back: Vec<_> = line([0.0, 0.0], [1.0, 0.0]).chain(line([9.0, 0.0], [-1.0, 0.0])).collect();
    let report = check(&back).report;
    assert_eq!((report.blended, report.stops), (0, 1), "{report:?}");
    let mut flipped = corner.clone();
    flipped[7].pose.axis = -flipped[7].pose.axis;
    let error = smooth(&flipped, &options(), &Silent);
    assert!(matches!(error, Err(SmoothError::AxisReversal { station: 6, .. })), "{error:?}");
    let error = smooth(&corner[..1], &options(), &Silent);
    assert_eq!(error, Err(SmoothError::Stations(1)));
}

/// The axis turns far in one move, alone and between short ones: straight moves of its vector would be out of step
/// with the great circle by 0.6 of the tolerance and more.
#[test]
fn long_turns_keep_step_with_the_great_circle() {
    let tilted = |x: f64, tilt: f64| station([x, 0.0, 0.0], [tilt.sin(), 0.0, tilt.cos()]);
    for turn in [0.25, 0.4, 1.2, 1.5, 2.0, 3.1] {
        let alone = [tilted(0.0, 0.0), tilted(47.0, turn)];
        assert!(check(&alone).report.deviated.axis_bound > 0.0);
        let mut many: Vec<_> = (0..40).map(|k| tilted(0.3 * f64::from(k), 0.0)).collect();
        many.extend((0..40).map(|k| tilted(50.0 + 0.3 * f64::from(k), turn)));
        let report = check(&many).report;
        assert_eq!(report.stations, 80);
    }
}

/// Noise within a part of the tolerance is not followed: spans stay long.
#[test]
fn noise_is_smoothed() {
    let mut noise = Noise(7);
    let stations: Vec<_> = (0..1200)
        .map(|k| {
            let t = 0.05 * f64::from(k) / 30.0;
            let mut near = || 0.1 * TIP * noise.next();
            let tip = [30.0 * t.cos() + near(), 30.0 * t.sin() + near(), near()];
            station(tip, [0.2 * t.cos(), 0.2, 1.0])
        })
        .collect();
    let smoothed = check(&stations);
    assert!(smoothed.report.spans < 1200 / 6, "{:?}", smoothed.report);
    let curve = &smoothed.curves[0];
    let jerk = (0..4000)
        .map(|k| curve.rates(curve.range().high * f64::from(k) / 4000.0).tip[3].norm())
        .fold(0.0, f64::max);
    // Third differences of the noise itself are some 8 times 0.1 TIP over the cube of the step.
    let raw = 0.8 * TIP / 0.05_f64.powi(3);
    assert!(jerk < 0.05 * raw, "{jerk} against {raw}");
}

/// Spans come while stations go in, and are those of the whole.
#[test]
fn a_long_path_is_smoothed_in_a_window() {
    let at = |k: u32| {
        let s = 0.05 * f64::from(k);
        station([s, (0.3 * s).sin(), (0.11 * s).cos()], [0.2 * (0.2 * s).sin(), 0.1, 1.0])
    };
    let stations: Vec<_> = (0..6000).map(at).collect();
    let mut smoother = PathSmoother::new(&options()).unwrap();
    let mut spans = Vec::new();
    for (k, station) in stations.iter().enumerate() {
        smoother.push(station).unwrap();
        spans.extend(smoother.take());
        let behind = 0.05 * k as f64 * 1.05 - spans.last().map_or(0.0, |last| last.range.high);
        assert!(behind < 3.0 * 128.0 * 0.05 + 0.05 * 0.05 * k as f64, "{behind} mm in memory");
    }
    let (rest, report) = smoother.finish().unwrap();
    spans.extend(rest);
    let whole = smooth(&stations, &options(), &Silent).unwrap();
    assert_eq!(whole.report, report);
    let ends: Vec<f64> = spans.iter().map(|span| span.range.high).collect();
    assert_eq!(whole.curves[0].knots[1..], ends);
    assert_eq!((report.blended, report.stops), (0, 0));
    check_c3(&whole.curves[0]);
}

/// Third derivatives of the axes of a machine along the path, from differences on either side of a
/// knot and over it.
fn jerks(inverse: &Inverse, curve: &PoseCurve, u: f64, h: f64) -> [AxisVector; 3] {
    let home = AxisVector::zeros();
    let middle = inverse.near(&curve.pose(u).unwrap(), &home).unwrap();
    let at = |k: f64| inverse.near(&curve.pose(u + k * h).unwrap(), &middle).unwrap();
    let third = |first: f64| {
        let [a, b, c, d] = [0.0, 1.0, 2.0, 3.0].map(|k| at(first + k));
        (d - a - (c - b) * 3.0) / h.powi(3)
    };
    [third(-3.0), third(-1.5), third(0.0)]
}

proptest! {
    #![proptest_config(property::cases(3))]

    /// Random paths, leant so far that no axis is free: over a join the third difference of every axis is no larger
    /// than beside it. Were the second derivative to jump there, it would grow with the inverse of the step.
    #[test]
    fn jerk_of_the_axes_is_finite_over_every_join_of_random_paths(stations in any_path()) {
        let moved = stations.iter().any(|s| (s.pose.tip - stations[0].pose.tip).norm() > TIP);
        prop_assume!(moved);
        let lean = |s: &Station| {
            let axis = s.pose.axis.into_inner() + Vector3::new(1.5, 0.0, 0.0);
            station(s.pose.tip.into(), axis.into())
        };
        let leant: Vec<Station> = stations.iter().map(lean).collect();
        let kinematics = shop::kinematics(Layout::TableTable);
        let inverse = Inverse::new(&kinematics).unwrap();
        for curve in &smooth(&leant, &options(), &Silent).unwrap().curves {
            for at in 1..curve.knots.len() - 1 {
                let u = curve.knots[at];
                let room = (u - curve.knots[at - 1]).min(curve.knots[at + 1] - u);
                let h = room / 16.0;
                let [left, over, right] = jerks(&inverse, curve, u, h);
                let most = left.amax().max(right.amax());
                let rounding = 2e-11 / (0.5 * h).powi(3);
                prop_assert!(over.amax() <= 2.0 * most + rounding, "at {u}: {over} of {most}");
            }
        }
    }
}

#[test]
fn jerk_of_the_axes_is_finite_and_continuous_over_every_join() {
    let at = |k: u32| {
        let s = 0.05 * f64::from(k);
        station(
            [0.5 * s - 5.0, 4.0 * (0.3 * s).sin(), 3.0 * (0.2 * s).cos()],
            [0.3 + 0.2 * (0.2 * s).sin(), 0.3 * (0.1 * s).cos(), 1.0],
        )
    };
    let mut stations: Vec<_> = (0..700).map(at).collect();
    // A corner to be blended.
    let last = stations[699];
    stations.extend((1..80).map(|k| {
        let tip = last.pose.tip + Vector3::new(1.0, 0.3, 0.2).normalize() * 0.1 * f64::from(k);
        station(tip.into(), last.pose.axis.into_inner().into())
    }));
    let smoothed = smooth(&stations, &options(), &Silent).unwrap();
    assert!(smoothed.report.blended >= 1 && smoothed.report.stops == 0);
    let curve = &smoothed.curves[0];
    for layout in [Layout::TableTable, Layout::HeadHead] {
        let kinematics = shop::kinematics(layout);
        let inverse = Inverse::new(&kinematics).unwrap();
        for at in 1..curve.knots.len() - 1 {
            let u = curve.knots[at];
            let room = (u - curve.knots[at - 1]).min(curve.knots[at + 1] - u);
            let h = room / 16.0;
            let [left, over, right] = jerks(&inverse, curve, u, h);
            let [near_left, _, near_right] = jerks(&inverse, curve, u, 0.5 * h);
            let most = left.amax().max(right.amax());
            let rounding = 2e-11 / (0.5 * h).powi(3);
            assert!(over.iter().all(|x| x.is_finite()));
            assert!(over.amax() <= 2.0 * most + rounding, "{layout:?} at {u}: {over} of {most}");
            // One-sided differences of a continuous third derivative close up with the step.
            let [wide, close] = [(left - right).amax(), (near_left - near_right).amax()];
            assert!(
                close <= 0.7 * wide + rounding + 1e-3 * most,
                "{layout:?} at {u}: {wide} -> {close}, {most}"
            );
        }
    }
}

/// A post that writes every place twice, a few micrometres apart, makes no corners.
#[test]
fn places_written_twice_are_no_corners() {
    let at = |s: f64| {
        let turn = s / 20.0;
        station([20.0 * turn.sin(), 20.0 - 20.0 * turn.cos(), 0.0], [0.1 * turn.sin(), 0.0, 1.0])
    };
    // 0.2 mm steps stray 0.25 µm from the circle; the second of a pair lies 2 µm ahead.
    let pairs: Vec<_> =
        (0..200).flat_map(|k| [0.0, 0.002].map(|ahead| at(0.2 * f64::from(k) + ahead))).collect();
    let smoothed = smooth(&pairs, &options(), &Silent).unwrap();
    assert_eq!((smoothed.report.blended, smoothed.report.stops), (0, 0), "{:?}", smoothed.report);
    assert!(smoothed.report.spans < 100, "{:?}", smoothed.report);
    assert!(strays(&smoothed.curves, &pairs) <= 1.0);
    // Steps that stay short are: a line goes over into an arc in fine steps.
    let line = (0..=5).map(|k| station([f64::from(k) - 5.0, 0.0, 0.0], [0.0, 0.0, 1.0]));
    let fine: Vec<_> = line.chain((1..60).map(|k| at(0.05 * f64::from(k)))).collect();
    let smoothed = smooth(&fine, &options(), &Silent).unwrap();
    let corners = smoothed.report.blended + smoothed.report.stops;
    assert_eq!(corners, 1, "{:?}", smoothed.report);
}
