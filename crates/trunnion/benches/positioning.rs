//! One cutter location on the bicubic patch, one core, bounds and tool body included.
//!
//! Budget: below 40 us warm (the neighbour 1 mm further along the feed), some ms cold.

#![expect(clippy::print_stdout, reason = "a bench tells what it measured")]

use divan::{Bencher, black_box};
use nalgebra::Point3;
use rayon::prelude::*;
use std::time::Instant;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::positioning::{
    CutterLocation, CuttingContext, LocationRequest, StripQuery, ToleranceBand, strip_of_pose,
    widest_strip,
};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
use trunnion::types::{Interval, Uv};

fn main() {
    // Not under `cargo test`, which passes `--test`.
    if std::env::args().any(|argument| argument == "--bench") {
        summary();
    }
    divan::main();
}

/// Asked of a warm location, one core, bounds and body included, and aimed at \[us\].
const ASKED: f64 = 40.0;
const AIM: f64 = 15.0;

/// Closest-point queries that the nested search of paper 004 spends on a location, at least.
const NESTED: f64 = 61_000.0;

/// What is asked and what is reached, and how two threads share 10^5 locations. The least of many
/// times is told: it is what a busy machine disturbs least.
fn summary() {
    let (Some(face), Some(cutter)) = (patch(), cutter()) else { return };
    for (case, (feed, _)) in CASES.iter().enumerate() {
        let Some((first, next)) = neighbours(&face, &cutter, case) else { continue };
        let mut least = f64::INFINITY;
        let mut queries = f64::INFINITY;
        for _ in 0..500 {
            let start = Instant::now();
            let found = black_box(widest_strip(black_box(&next), Some(&first)));
            least = least.min(1e6 * start.elapsed().as_secs_f64());
            queries = found.map_or(queries, |found| f64::from(found.queries));
        }
        println!(
            "warm, feed {feed:?}: {least:.1} us, {:.2} of the {ASKED} us asked ({AIM} aimed at); \
             {queries} queries, the nested search {:.0} times as many and more",
            least / ASKED,
            NESTED / queries
        );
    }
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let once = || {
            let start = Instant::now();
            let work = || many(&face, &cutter);
            let width = pool.as_ref().map_or(0.0, |pool| pool.install(work));
            (start.elapsed().as_secs_f64(), width)
        };
        let (a, b) = (once(), once());
        if b.0 < a.0 { b } else { a }
    });
    println!(
        "{ROWS} rows of {STATIONS} locations: {:.2} s on one thread, {:.2} s on two: {:.2} times as \
         fast, results {}",
        one.0,
        two.0,
        one.0 / two.0,
        if one.1.to_bits() == two.1.to_bits() { "the same" } else { "DIFFERENT" }
    );
}

/// Rows run in parallel, each location from the one before.
const ROWS: u32 = 100;
const STATIONS: u32 = 1000;

/// Sum of all widths \[mm\].
fn many(face: &FaceIndex, cutter: &Cutter) -> f64 {
    let row = |row: u32| {
        let u = 0.1 + 0.8 * f64::from(row) / f64::from(ROWS);
        let mut warm: Option<CutterLocation> = None;
        let mut width = 0.0;
        for station in 0..STATIONS {
            let v = 0.1 + 0.8 * f64::from(station) / f64::from(STATIONS);
            let request = LocationRequest { at: Uv::new(u, v), ..request(face, cutter, 0) };
            warm = widest_strip(&request, warm.as_ref()).ok();
            width += warm.as_ref().map_or(0.0, |found| found.chord_width);
        }
        width
    };
    let widths: Vec<f64> = (0..ROWS).into_par_iter().map(row).collect();
    widths.iter().sum()
}

/// A location and the request 1 mm further along the feed.
fn neighbours<'a>(
    face: &'a FaceIndex,
    cutter: &'a Cutter,
    case: usize,
) -> Option<(CutterLocation, LocationRequest<'a>)> {
    let request = request(face, cutter, case);
    let Uv { u, v } = request.at;
    let at = Uv::new(u + 0.008 * request.feed[0], v + 0.008 * request.feed[1]);
    let first = widest_strip(&request, None).ok()?;
    Some((first, LocationRequest { at, ..request }))
}

const PLACES: [f64; 4] = [-60.0, -30.0, 30.0, 60.0];
const HEIGHTS: [[f64; 4]; 4] = [
    [0.0, -20.0, -20.0, 5.0],
    [-5.0, -15.0, -25.0, -5.0],
    [-5.0, -25.0, -20.0, -5.0],
    [5.0, -15.0, -15.0, 0.0],
];

fn patch() -> Option<FaceIndex> {
    let point = |i: usize, j: usize| Point3::new(PLACES[i], PLACES[j], HEIGHTS[j][i]);
    let points = (0..4).map(|i| (0..4).map(|j| point(i, j)).collect()).collect();
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([3, 3], [knots(), knots()], points, None).ok()?;
    FaceIndex::new(Face::new(1, Surface::Nurbs(surface), Vec::new()).ok()?).ok()
}

fn cutter() -> Option<Cutter> {
    Cutter::new(CutterSpec { length: 120.0, ..CutterSpec::bull(10.0, 6.0) }).ok()
}

/// Feed and half range of the offset direction: the widest strips, and the awkward ones whose
/// optimum is not a corner.
const CASES: [([f64; 2], f64); 2] = [([0.0, 1.0], 0.26), ([-1.0, 0.0], 1.3)];

fn request<'a>(face: &'a FaceIndex, cutter: &'a Cutter, case: usize) -> LocationRequest<'a> {
    let (feed, range) = CASES[case];
    LocationRequest {
        offset_range: Interval::new(-range, range),
        ..LocationRequest::new(
            face,
            cutter,
            ToleranceBand { lower: 0.0, upper: 0.01 },
            Uv::new(0.4, 0.5),
            feed,
        )
    }
}

#[divan::bench(args = [0, 1])]
fn cold(bencher: Bencher, case: usize) {
    if let (Some(face), Some(cutter)) = (patch(), cutter()) {
        let request = request(&face, &cutter, case);
        bencher.bench_local(|| widest_strip(&request, None));
    }
}

#[divan::bench(args = [0, 1])]
fn warm(bencher: Bencher, case: usize) {
    if let (Some(face), Some(cutter)) = (patch(), cutter())
        && let Some((first, next)) = neighbours(&face, &cutter, case)
    {
        bencher.bench_local(|| widest_strip(&next, Some(&first)));
    }
}

#[divan::bench]
fn look(bencher: Bencher) {
    if let (Some(face), Some(cutter)) = (patch(), cutter()) {
        let request = request(&face, &cutter, 0);
        if let Ok(found) = widest_strip(&request, None) {
            let setting = CuttingContext { face: &face, cutter: &cutter, band: request.band };
            let feed = nalgebra::Vector3::y();
            let (contact, uv) = (found.contact, found.contact_uv);
            let look = StripQuery { feed, strip: request.strip, contact, uv };
            bencher.bench_local(|| strip_of_pose(&setting, &found.pose, &look));
        }
    }
}
