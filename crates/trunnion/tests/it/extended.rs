//! Heights over points against dense sampling of the motion in doubled precision, to 0.1 um.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;

use nalgebra::{Point3, Rotation3, Unit, Vector3};
use proptest::prelude::*;
use std::ops::{Add, Div, Mul, Sub};
use trunnion::cutter::{Cutter, CutterKind, CutterSpec};
use trunnion::nc::read::{ClFile, ClMotion, ClPath, ClRecord};
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::{Silent, ToolPose};
use trunnion::verify::{self, CheckInput, CheckOptions, DeviationTolerance};

/// What is promised of a height \[mm\].
const CLOSE: f64 = 1e-4;

/// The sum of two doubles, the second of which is below the last place of the first: 106 bits.
#[derive(Debug, Clone, Copy)]
struct Double(f64, f64);

/// Sum and its rounding, exactly (Knuth).
fn two_sum(a: f64, b: f64) -> Double {
    let sum = a + b;
    let part = sum - a;
    Double(sum, (a - (sum - part)) + (b - part))
}

impl From<f64> for Double {
    fn from(value: f64) -> Self {
        Self(value, 0.0)
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let Self(high, low) = two_sum(self.0, other.0);
        two_sum(high, low + self.1 + other.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self(-other.0, -other.1)
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.0 * other.0;
        let low = self.0.mul_add(other.0, -high);
        two_sum(high, low + self.0 * other.1 + self.1 * other.0)
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = Self::from(self.0 / other.0);
        let rest = self - first * other;
        first + Self::from(rest.0 / other.0)
    }
}

impl Double {
    fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Self(0.0, 0.0);
        }
        let first = Self::from(self.0.sqrt());
        first + Self::from((self - first * first).0 / (2.0 * first.0))
    }

    fn max(self, other: Self) -> Self {
        if (self - other).0 > 0.0 { self } else { other }
    }

    /// By its series; angles here are below one.
    fn sin(self) -> Self {
        let square = self * self;
        let (mut term, mut sum) = (self, self);
        for k in 1..16 {
            let by = f64::from(2 * k * (2 * k + 1));
            term = term * square / Self::from(-by);
            sum = sum + term;
        }
        sum
    }
}

type Vector = [Double; 3];

fn vector(v: &Vector3<f64>) -> Vector {
    [v.x, v.y, v.z].map(Double::from)
}

fn zip(a: &Vector, b: &Vector, f: impl Fn(Double, Double) -> Double) -> Vector {
    [0, 1, 2].map(|k| f(a[k], b[k]))
}

fn dot(a: &Vector, b: &Vector) -> Double {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A move with a straight tip and the tool axis on a great circle, at an even rate.
struct Move {
    tip: [Vector; 2],
    axis: [Vector; 2],
    /// Between both axes.
    angle: Double,
}

impl Move {
    fn new([from, to]: [&ToolPose; 2]) -> Self {
        let unit = |pose: &ToolPose| {
            let raw = vector(&pose.axis);
            let length = dot(&raw, &raw).sqrt();
            raw.map(|part| part / length)
        };
        let axis = [unit(from), unit(to)];
        let chord = zip(&axis[1], &axis[0], Double::sub);
        // sin(angle / 2) is half the chord; a Newton step doubles the digits of the arc sine.
        let half = dot(&chord, &chord).sqrt() * Double::from(0.5);
        let first = Double::from(half.0.asin());
        let angle = first + (half - first.sin()) / Double::from(first.0.cos());
        let tip = [from, to].map(|pose| vector(&pose.tip.coords));
        Self { tip, axis, angle: angle * Double::from(2.0) }
    }

    /// Tip and axis at a time in 0..=1.
    fn at(&self, t: f64) -> [Vector; 2] {
        let [t, rest] = [Double::from(t), Double::from(1.0) - Double::from(t)];
        let mean = |ends: &[Vector; 2], a: Double, b: Double| {
            zip(&ends[0], &ends[1], |p, q| p * a + q * b)
        };
        let whole = self.angle.sin();
        let weight = |share: Double| {
            if whole.0 > 1e-12 { (share * self.angle).sin() / whole } else { share }
        };
        [mean(&self.tip, rest, t), mean(&self.axis, weight(rest), weight(t))]
    }

    /// Distance of the cutter from a point at a time.
    fn distance(&self, cutter: &Cutter, p: &Vector, t: f64) -> Double {
        let [tip, axis] = self.at(t);
        let y = zip(p, &tip, Double::sub);
        let height = dot(&axis, &y);
        let rho = (dot(&y, &y) - height * height).sqrt();
        let (zero, minor) = (Double::from(0.0), Double::from(cutter.minor()));
        let [out, down] = [rho - Double::from(cutter.major()), minor - height];
        let [away, below] = [out.max(zero), down.max(zero)];
        let corner = (away * away + below * below).sqrt();
        // Inside the corner region: how far from its nearer side.
        let inside = out.max(down);
        let inside = if inside.0 < 0.0 { inside } else { zero };
        (corner + inside - minor).max(height - Double::from(cutter.length()))
    }

    /// Least distance over the move: sampled densely, then by golden section around every sample that is lowest
    /// among its neighbours and low enough to count.
    fn nearest(&self, cutter: &Cutter, p: &Vector) -> f64 {
        const LOOKS: u16 = 400;
        let at = |t: f64| self.distance(cutter, p, t).0;
        let values: Vec<f64> = (0..=LOOKS).map(|k| at(f64::from(k) / f64::from(LOOKS))).collect();
        let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
        let mut best = lowest;
        for (k, &value) in (0u16..).zip(&values) {
            let [before, after] = [usize::from(k.saturating_sub(1)), usize::from(k + 1)];
            let is_low = values[before] >= value && values.get(after).is_none_or(|v| *v >= value);
            if !is_low || value > lowest + 0.05 {
                continue;
            }
            let time = |k: f64| (k / f64::from(LOOKS)).clamp(0.0, 1.0);
            let [mut from, mut to] = [time(f64::from(k) - 1.0), time(f64::from(k) + 1.0)];
            for _ in 0..40 {
                let [a, b] = [to - 0.618 * (to - from), from + 0.618 * (to - from)];
                if at(a) < at(b) { to = b } else { from = a }
            }
            best = best.min(at(0.5 * (from + to)));
        }
        best
    }
}

fn any_cutter() -> impl Strategy<Value = Cutter> {
    let kinds =
        [(CutterKind::Ball, 0.0, 3.0), (CutterKind::Bull, 5.0, 2.0), (CutterKind::Flat, 4.0, 0.0)];
    prop::sample::select(kinds.to_vec()).prop_map(|(kind, major, minor)| {
        let spec = CutterSpec { kind, length: 60.0, ..CutterSpec::of_radii(major, minor) };
        Cutter::new(spec).unwrap()
    })
}

/// Where the lowest point of the tool runs by the plane, and how the tool leans.
fn any_path() -> impl Strategy<Value = Vec<ToolPose>> {
    let step = (-3.0..3.0, -3.0..3.0, 0.0..0.6, -0.4..0.4, -0.4..0.4);
    prop::collection::vec(step, 2..6).prop_map(|steps| {
        let pose = |(x, y, z, a, b): (f64, f64, f64, f64, f64)| {
            let axis = Rotation3::from_euler_angles(a, b, 0.0) * Vector3::z();
            ToolPose { tip: Point3::new(x, y, z), axis: Unit::new_normalize(axis) }
        };
        steps.into_iter().map(pose).collect()
    })
}

/// The square of 4 mm about the origin in the plane z = 0: points and normals on it are exact.
fn plane() -> Face {
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let point = |x: f64, y: f64| Point3::new(x, y, 0.0);
    let net =
        vec![vec![point(-2.0, -2.0), point(-2.0, 2.0)], vec![point(2.0, -2.0), point(2.0, 2.0)]];
    let surface = NurbsSurface::new([1, 1], [knots(), knots()], net, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { max_shrink_iters: 0, ..property::cases(8) })]

    /// A tenth of a micrometre below what is reported no tool is met, as much above it one is.
    #[test]
    fn heights_are_known_to_a_tenth_of_a_micrometre(cutter in any_cutter(), path in any_path()) {
        let record = |(line, &pose)| {
            ClRecord { line, pose, motion: ClMotion::Feed(10.0), way: ClPath::Straight }
        };
        let file = ClFile { records: (1..).zip(&path).map(record).collect(), ..ClFile::default() };
        let faces = [plane()];
        let input = CheckInput::locations(&file, &cutter).faces(&faces);
        // Heights along the normal alone: no point counts as cut by what is beside it.
        let tolerance = DeviationTolerance { excess: 1e-9, gouge: 0.1 };
        let options = CheckOptions {
            reach: 2.0,
            ray_tolerance: 0.5 * CLOSE,
            most_points: 10_000,
            bounds: None,
            ..CheckOptions::of_tolerance(tolerance, 1.0)
        };
        let report = verify::check(&input, &options, &Silent).unwrap();
        let moves: Vec<Move> = path.windows(2).map(|pair| Move::new([&pair[0], &pair[1]])).collect();
        // With a tolerance, a point that nothing cuts along the normal is as high as the tool is away from it.
        let near = CheckOptions { total: 0.1, ..options };
        let beside = verify::check(&input, &near, &Silent).unwrap();
        for (along, beside) in report.maps[0].samples.iter().flatten().zip(beside.maps[0].samples.iter().flatten()) {
            let same = along.height == beside.height;
            prop_assert!(same || along.height.is_none_or(|height| height > near.total), "{along:?}");
            if let Some(height) = beside.height.filter(|_| !same) {
                let p = vector(&beside.point.coords);
                let away = moves.iter().map(|one| one.nearest(&cutter, &p)).fold(f64::INFINITY, f64::min);
                prop_assert!(height <= near.total, "{height} at {:?}", beside.point);
                prop_assert!(away.max(0.0) <= height + CLOSE, "{away} mm away at {height} at {:?}", beside.point);
            }
        }
        for sample in report.maps[0].samples.iter().flatten() {
            let nearest = |s: f64| {
                let p = vector(&(sample.point.coords + Vector3::z() * s));
                moves.iter().map(|one| one.nearest(&cutter, &p)).fold(f64::INFINITY, f64::min)
            };
            let Some(height) = sample.height else {
                prop_assert!(nearest(options.reach) > -CLOSE, "{:?} is met", sample.point);
                continue;
            };
            if height <= -options.reach {
                continue;
            }
            let met = nearest(height + CLOSE);
            prop_assert!(met <= 0.0, "{met} mm off at {height} over {:?}", sample.point);
            // Below a gouge there may be another tool's flank behind what is cut away: only above the face is
            // what is reported the lowest of all.
            if height > 0.0 {
                let free = nearest(height - CLOSE);
                // A touch that cuts in by a tenth of the ray tolerance may be passed over.
                prop_assert!(free > -0.1 * options.ray_tolerance, "{free} mm inside at {height} over {:?}", sample.point);
            }
        }
    }
}
