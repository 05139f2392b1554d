//! The bound of the rate of curvature against dense sampling of third derivatives.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Matrix2, Point3, Vector2};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};

/// Xorshift numbers in [-1, 1].
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Clamped cubic knots over [0, 1] with these inside.
fn knots(inner: &[f64]) -> Vec<f64> {
    [&[0.0; 4], inner, &[1.0; 4]].concat()
}

/// A bicubic sheet of some 150 mm, waved at random.
fn sheet(inner: [&[f64]; 2], height: f64, random: &mut Random) -> FaceIndex {
    let count = inner.map(|knots| knots.len() + 4);
    let pace = [0, 1].map(|k| 150.0 / (count[k] - 1) as f64);
    let mut point = |i: usize, j: usize| {
        let shift = |random: &mut Random| 0.2 * random.next();
        let [x, y] = [i as f64 + shift(random), j as f64 + shift(random)];
        Point3::new(x * pace[0], y * pace[1], height * random.next())
    };
    let points = (0..count[0]).map(|i| (0..count[1]).map(|j| point(i, j)).collect()).collect();
    let surface = NurbsSurface::new([3, 3], inner.map(knots), points, None).unwrap();
    FaceIndex::new(Face::new(1, Surface::Nurbs(surface), vec![]).unwrap()).unwrap()
}

/// Largest `|(d II)(t, t, t)|` at a place over unit tangents `t`, from the derivatives themselves.
fn rate(face: &FaceIndex, [u, v]: [f64; 2]) -> f64 {
    let d = face.face().surface.jet(u, v);
    let n = d.su.cross(&d.sv).normalize();
    let metric = Matrix2::new(d.su.dot(&d.su), d.su.dot(&d.sv), d.su.dot(&d.sv), d.sv.dot(&d.sv));
    let inverse = metric.try_inverse().unwrap();
    let second = |x: &Vector2<f64>, y: &Vector2<f64>| {
        d.suu * (x.x * y.x) + d.suv * (x.x * y.y + x.y * y.x) + d.svv * (x.y * y.y)
    };
    let value = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let x = Vector2::new(cos, sin);
        let x = x / x.dot(&(metric * x)).sqrt();
        let third = d.suuu * x.x.powi(3)
            + d.suuv * (3.0 * x.x * x.x * x.y)
            + d.suvv * (3.0 * x.x * x.y * x.y)
            + d.svvv * x.y.powi(3);
        let bent = second(&x, &x);
        let along = inverse * Vector2::new(d.su.dot(&bent), d.sv.dot(&bent));
        (n.dot(&third) - 3.0 * n.dot(&second(&along, &x))).abs()
    };
    (0..90).map(|k| value(f64::from(k) * std::f64::consts::PI / 90.0)).fold(0.0, f64::max)
}

/// Bound and largest rate found around `[u, v]` within `reach`.
fn both(face: &FaceIndex, [u, v]: [f64; 2], reach: f64) -> [f64; 2] {
    let p = face.face().surface.point(u, v);
    let foot = face.closest_near(&p, [u, v].into()).unwrap();
    let bound = face.curvature_rate_around(std::iter::once(&foot), reach);
    let mut found = 0.0_f64;
    for i in 0..40 {
        for j in 0..40 {
            let at = [(f64::from(i) + 0.5) / 40.0, (f64::from(j) + 0.5) / 40.0];
            if (face.face().surface.point(at[0], at[1]) - p).norm() < reach {
                found = found.max(rate(face, at));
            }
        }
    }
    [bound, found]
}

#[test]
fn no_rate_exceeds_the_bound() {
    let mut random = Random(7);
    let (mut finite, mut close) = (0, 0);
    for (case, height) in [2.0, 5.0, 10.0, 20.0].into_iter().cycle().take(12).enumerate() {
        let inner: [&[f64]; 2] = [&[], &[0.3, 0.45, 0.8]];
        let face = sheet([inner[case % 2], inner[case / 2 % 2]], height, &mut random);
        for _ in 0..6 {
            let at = [0.5 + 0.2 * random.next(), 0.5 + 0.2 * random.next()];
            for reach in [8.0, 20.0] {
                let [bound, found] = both(&face, at, reach);
                assert!(bound >= found, "{case} {at:?} {reach}: {bound} < {found}");
                finite += i32::from(bound.is_finite());
                close += i32::from(bound < 4.0 * found);
            }
        }
    }
    assert!(finite > 100 && close > 30, "{finite} finite, {close} close");
}

#[test]
fn curvature_that_jumps_has_no_rate() {
    let mut random = Random(3);
    let face = sheet([&[0.5, 0.5], &[]], 5.0, &mut random);
    assert!(both(&face, [0.5, 0.5], 1.0)[0].is_infinite());
    assert!(both(&face, [0.45, 0.5], 20.0)[0].is_infinite());
    let [bound, found] = both(&face, [0.3, 0.5], 8.0);
    assert!(bound.is_finite() && bound >= found, "{bound} {found}");
    // Near a rim the continuation takes over.
    assert!(both(&face, [0.3, 0.01], 8.0)[0].is_infinite());
    // Of flat sheets nothing changes.
    let flat = sheet([&[0.5], &[0.5]], 0.0, &mut random);
    assert!(both(&flat, [0.5, 0.5], 10.0)[0] < 1e-12);
}
