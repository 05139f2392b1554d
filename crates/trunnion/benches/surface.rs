//! Evaluation and closest points on a bicubic B-spline of 20 x 20 control points, beside curvo on
//! the same surface and queries in the same run.

use curvo::prelude::NurbsSurface3D;
use divan::Bencher;
use divan::black_box;
use nalgebra::Point3;
use nalgebra::Point4;
use trunnion::surface::Face;
use trunnion::surface::FaceIndex;
use trunnion::surface::NurbsSurface;
use trunnion::surface::Surface;

fn main() {
    divan::main();
}

const COUNT: usize = 20;

fn control_point(i: usize, j: usize) -> Point3<f64> {
    let [x, y] = [5.0 * i as f64, 5.0 * j as f64];
    Point3::new(x, y, 6.0 * (0.09 * x).sin() * (0.07 * y + 0.4).cos())
}

fn knots() -> Vec<f64> {
    let inner = COUNT - 3;
    let at = |k: usize| (k.saturating_sub(3)).min(inner) as f64 / inner as f64;
    (0..COUNT + 4).map(at).collect()
}

fn weight(i: usize, j: usize, rational: bool) -> f64 {
    if rational { 1.0 + 0.3 * ((7 * i + 3 * j) as f64).sin() } else { 1.0 }
}

fn ours(rational: bool) -> Option<Surface> {
    let row = |i: usize| (0..COUNT).map(|j| control_point(i, j)).collect();
    let weights = |i: usize| (0..COUNT).map(|j| weight(i, j, rational)).collect();
    let weights = rational.then(|| (0..COUNT).map(weights).collect());
    let points = (0..COUNT).map(row).collect();
    NurbsSurface::new([3, 3], [knots(), knots()], points, weights).ok().map(Surface::Nurbs)
}

fn theirs(rational: bool) -> NurbsSurface3D<f64> {
    let lift = |i: usize, j: usize| {
        let (p, w) = (control_point(i, j), weight(i, j, rational));
        Point4::new(p.x * w, p.y * w, p.z * w, w)
    };
    let points = (0..COUNT).map(|i| (0..COUNT).map(|j| lift(i, j)).collect()).collect();
    NurbsSurface3D::new(3, 3, knots(), knots(), points)
}

/// Parameters spread over the patches, none remembered from one call to the next.
fn places() -> impl FnMut() -> [f64; 2] {
    let mut k = 0_u32;
    move || {
        k = k.wrapping_add(1);
        let spread = |step: f64| (f64::from(k) * step).fract();
        [spread(0.618_033_988_7), spread(0.754_877_666_2)]
    }
}

#[divan::bench(args = [1, 2, 3], consts = [false, true])]
fn derivatives<const RATIONAL: bool>(bencher: Bencher, order: usize) {
    let Some(surface) = ours(RATIONAL) else { return };
    let bencher = bencher.with_inputs(places());
    match order {
        1 => bencher.bench_local_values(|[u, v]| surface.jet1(black_box(u), v)),
        2 => bencher.bench_local_values(|[u, v]| surface.jet2(black_box(u), v)),
        _ => bencher.bench_local_values(|[u, v]| surface.jet(black_box(u), v)),
    }
}

#[divan::bench(args = [1, 2, 3], consts = [false, true])]
fn derivatives_curvo<const RATIONAL: bool>(bencher: Bencher, order: usize) {
    let surface = theirs(RATIONAL);
    bencher
        .with_inputs(places())
        .bench_local_values(|[u, v]| surface.rational_derivatives(black_box(u), v, order));
}

/// Points `height` above the surface with their parameters.
fn queries(surface: &Surface, height: f64) -> Vec<([f64; 2], Point3<f64>)> {
    let mut next = places();
    let query = |_| {
        let [u, v] = next();
        let jet = surface.jet1(u, v);
        ([u, v], jet.s + jet.normal().map_or_else(Default::default, |n| n.scale(height)))
    };
    (0..256).map(query).collect()
}

/// In turn, for as long as asked.
fn turns<T: Copy>(all: Vec<T>) -> impl FnMut() -> Option<T> {
    let mut k = 0;
    move || {
        k = (k + 1) % all.len().max(1);
        all.get(k).copied()
    }
}

#[divan::bench(args = [2.0, 20.0])]
fn closest_cold(bencher: Bencher, height: f64) {
    let Some(surface) = ours(false) else { return };
    let queries = queries(&surface, height);
    let face = Face::new(1, surface, Vec::new()).and_then(FaceIndex::new);
    let Ok(index) = face else { return };
    bencher
        .with_inputs(turns(queries))
        .bench_local_values(|query| query.map(|(_, p)| index.closest(&p)));
}

#[divan::bench(args = [2.0, 20.0])]
fn closest_cold_curvo(bencher: Bencher, height: f64) {
    let Some(surface) = ours(false) else { return };
    let peer = theirs(false);
    bencher
        .with_inputs(turns(queries(&surface, height)))
        .bench_local_values(|query| query.map(|(_, p)| peer.find_closest_parameter(&p, None)));
}

#[divan::bench]
fn closest_warm(bencher: Bencher) {
    let Some(surface) = ours(false) else { return };
    let queries = queries(&surface, 2.0);
    let face = Face::new(1, surface, Vec::new()).and_then(FaceIndex::new);
    let Ok(index) = face else { return };
    bencher.with_inputs(turns(queries)).bench_local_values(|query| {
        query.map(|([u, v], p)| index.closest_near(&p, [u + 2e-3, v - 2e-3].into()))
    });
}

#[divan::bench]
fn closest_warm_curvo(bencher: Bencher) {
    let Some(surface) = ours(false) else { return };
    let peer = theirs(false);
    bencher.with_inputs(turns(queries(&surface, 2.0))).bench_local_values(|query| {
        query.map(|([u, v], p)| peer.find_closest_parameter(&p, Some((u + 2e-3, v - 2e-3))))
    });
}
