//! Bounds of smoothed paths: with rounding, against numbers of twice the digits; and against the pass itself.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;

use proptest::prelude::*;
use trunnion::math::angle::angle_between;
use trunnion::toolpath::{
    PathSmoother, SmoothError, SmoothOptions, SmoothReference, local_cubic, smooth,
};
use trunnion::types::Interval;
use trunnion::types::{PoseCoordinates, PoseCurve, PoseTolerance, Silent, Station, ToolPose};

const LEVER: f64 = 10.0;

fn options(tip: f64, axis: f64, reference: SmoothReference) -> SmoothOptions {
    let mut options = SmoothOptions::within(PoseTolerance { tip, axis });
    options.reference = reference;
    options.lever = LEVER;
    options.window = 128;
    options
}

fn station(tip: [f64; 3], axis: [f64; 3]) -> Station {
    let pose = ToolPose::new(tip, axis).unwrap();
    Station { pose, contact: pose.tip }
}

/// A number as a sum of two: 106 bits (Dekker, Knuth).
#[derive(Debug, Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn of(x: f64) -> Self {
        Self(x, 0.0)
    }

    fn normal(a: f64, b: f64) -> Self {
        let sum = a + b;
        Self(sum, b - (sum - a))
    }

    fn plus(self, other: Self) -> Self {
        let sum = self.0 + other.0;
        let part = sum - self.0;
        let error = (self.0 - (sum - part)) + (other.0 - part);
        Self::normal(sum, error + self.1 + other.1)
    }

    fn minus(self, other: Self) -> Self {
        self.plus(Self(-other.0, -other.1))
    }

    fn times(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let error = self.0.mul_add(other.0, -product);
        Self::normal(product, error + self.0 * other.1 + self.1 * other.0)
    }

    fn over(self, other: Self) -> Self {
        let first = self.0 / other.0;
        let rest = self.minus(other.times(Self::of(first)));
        let second = rest.0 / other.0;
        let rest = rest.minus(other.times(Self::of(second)));
        Self::normal(first, second).plus(Self::of(rest.0 / other.0))
    }
}

/// A polynomial in exact steps.
fn exact(coefficients: &[PoseCoordinates; 6], row: usize, x: f64) -> Double {
    let x = Double::of(x);
    let sum = |sum: Double, c: &PoseCoordinates| sum.times(x).plus(Double::of(c[row]));
    coefficients.iter().rev().fold(Double::of(0.0), sum)
}

/// Largest distances of the spans from the polyline, of the polynomials and of their values as computed, over the
/// bound of the span; and the largest bound.
fn worst(stations: &[Station], options: &SmoothOptions) -> [f64; 2] {
    let mut smoother = PathSmoother::new(options).unwrap();
    for station in stations {
        smoother.push(station).unwrap();
    }
    let (spans, report) = smoother.finish().unwrap();
    assert_eq!((report.merged, report.blended, report.stops), (0, 0, 0), "{report:?}");
    let mut u = vec![0.0];
    for pair in stations.windows(2) {
        u.push(u[u.len() - 1] + pair[0].advance(&pair[1], options.lever));
    }
    let mut worst = [0.0_f64; 2];
    for span in spans {
        for part in 0..=23 {
            let x = (span.range.high - span.range.low) * f64::from(part) / 23.0;
            let at = Double::of(span.range.low).plus(Double::of(x));
            let step = u.partition_point(|&u| u <= at.0).clamp(1, u.len() - 1) - 1;
            let share = at
                .minus(Double::of(u[step]))
                .over(Double::of(u[step + 1]).minus(Double::of(u[step])));
            let [from, to] = [&stations[step], &stations[step + 1]].map(Station::coordinates);
            let value = span.span.value(x);
            let mut squares = [0.0_f64; 2];
            for row in 0..3 {
                let way = Double::of(to[row]).minus(Double::of(from[row]));
                let path = Double::of(from[row]).plus(way.times(share));
                let off = exact(&span.span.coefficients, row, x).minus(path);
                let computed = Double::of(value[row]).minus(path);
                squares = [squares[0] + off.0.powi(2), squares[1] + computed.0.powi(2)];
            }
            for square in squares {
                worst[0] = worst[0].max(square.sqrt() / span.deviated.tip_bound);
            }
        }
        worst[1] = worst[1].max(span.deviated.tip_bound);
    }
    worst
}

proptest! {
    #![proptest_config(property::cases(24))]

    /// Far from the origin, on lines and nearly on lines, where rounding is all there is.
    #[test]
    fn bounds_hold_to_the_last_digit(
        far in prop::array::uniform3(-1e6..1e6f64),
        way in prop::array::uniform3(-1.0..1.0f64),
        wave in prop_oneof![Just(0.0), 1e-12..1e-7f64],
        count in 3..300_u32,
        step in 0.05..3.0f64,
    ) {
        prop_assume!(way.iter().map(|x| x * x).sum::<f64>() > 0.1);
        let at = |k: u32| {
            let s = step * f64::from(k);
            let tip = std::array::from_fn(|i| far[i] + s * way[i] + wave * (3.0 * s + i as f64).sin());
            station(tip, [0.1, 0.2, 1.0])
        };
        let stations: Vec<_> = (0..count).map(at).collect();
        let [share, bound] = worst(&stations, &options(1e-3, 1e-3, SmoothReference::Chords));
        prop_assert!(share <= 1.0, "{share} of the bound");
        prop_assert!(bound < 1e-5, "{bound} mm");
    }

    /// A pass is smoothed within bounds of its own curve, the spline through its stations, at equal parameters.
    #[test]
    fn passes_are_compared_with_their_own_curve(
        waves in prop::array::uniform4(-1.0..1.0f64),
        step in 0.3..2.0f64,
        uneven in 0.0..0.4f64,
        tip in 2e-4..5e-3f64,
    ) {
        let at = |k: u32| {
            let s = step * (f64::from(k) + uneven * (7.0 * f64::from(k)).sin());
            station(
                [s, 6.0 * waves[0] * (0.15 * s).sin(), 4.0 * waves[1] * (0.2 * s).cos()],
                [0.3 * waves[2] * (0.1 * s).sin(), 0.2 * waves[3] * (0.13 * s).cos(), 1.0],
            )
        };
        let stations: Vec<_> = (0..200).map(at).collect();
        let options = options(tip, 0.1 * tip, SmoothReference::Curve);
        let smoothed = smooth(&stations, &options, &Silent).unwrap();
        let pass = PoseCurve::through(&stations, LEVER);
        let report = smoothed.report;
        prop_assert_eq!((report.stops, report.merged), (0, 0));
        prop_assert!(report.deviated.tip_bound <= tip && report.deviated.axis_bound <= 0.1 * tip);
        for (curve, deviated) in smoothed.curves.iter().zip(&smoothed.deviated) {
            for (span, pair) in curve.knots.windows(2).enumerate() {
                for k in 0..=40 {
                    let u = pair[0] + (pair[1] - pair[0]) * f64::from(k) / 40.0;
                    let [mine, its] = [curve.pose_in(span, u), pass.pose(u)].map(Option::unwrap);
                    prop_assert!((mine.tip - its.tip).norm() <= deviated[span].tip_bound);
                    prop_assert!(angle_between(&mine.axis, &its.axis) <= deviated[span].axis_bound);
                }
            }
        }
    }
}

/// Where stations are uneven, the local cubic is another curve: by more than the tolerance here.
#[test]
fn the_local_cubic_is_not_the_pass() {
    let at = |k: u32| {
        let s = 1.5 * (f64::from(k) + 0.3 * (7.0 * f64::from(k)).sin());
        station([s, 5.0 * (0.25 * s).sin(), 0.0], [0.2 * (0.2 * s).sin(), 0.1, 1.0])
    };
    let stations: Vec<_> = (0..200).map(at).collect();
    let tolerance = 1e-3;
    let [pass, cubic] =
        [PoseCurve::through(&stations, LEVER), local_cubic(&stations, LEVER).unwrap()];
    let end = pass.range().high;
    let apart = (0..4000).map(|k| {
        let u = end * f64::from(k) / 4000.0;
        (pass.pose(u).unwrap().tip - cubic.pose(u).unwrap().tip).norm()
    });
    let apart = apart.fold(0.0, f64::max);
    assert!(apart > 2.0 * tolerance, "{apart} mm apart");
    let smoothed =
        smooth(&stations, &options(tolerance, 1e-3, SmoothReference::Curve), &Silent).unwrap();
    let off = smoothed.curves.iter().flat_map(|curve| {
        let Interval { low: from, high: to } = curve.range();
        (0..4000).map(move |k| from + (to - from) * f64::from(k) / 4000.0).map(|u| {
            let [mine, its] = [curve.pose(u), pass.pose(u)].map(Option::unwrap);
            (mine.tip - its.tip).norm()
        })
    });
    assert!(off.fold(0.0, f64::max) <= smoothed.report.deviated.tip_bound);
    assert!(smoothed.report.deviated.tip_bound <= tolerance);
}

#[test]
fn a_pass_with_a_repeated_station_is_refused() {
    let a = station([0.0; 3], [0.0, 0.0, 1.0]);
    let b = station([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let options = options(1e-3, 1e-3, SmoothReference::Curve);
    assert_eq!(smooth(&[a, b, b], &options, &Silent).unwrap_err(), SmoothError::Repeated(1));
    assert_eq!(smooth(&[a], &options, &Silent).unwrap_err(), SmoothError::Stations(1));
}
