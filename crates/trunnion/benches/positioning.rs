//! One cutter location on the bicubic patch, one core, bounds and tool body included.
//!
//! Budget: below 40 us warm (the neighbour 1 mm further along the feed), some ms cold.

use divan::Bencher;
use nalgebra::Point3;
use trunnion::cutter::{Construction, Cutter, CutterSpec, Kind};
use trunnion::positioning::{
    Band, ContactSide, Look, Request, Setting, StripSide, strip_of_pose, widest,
};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};

fn main() {
    divan::main();
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
    FaceIndex::new(Face::new(1, Surface::Nurbs(surface), Vec::new(), false).ok()?).ok()
}

fn cutter() -> Option<Cutter> {
    Cutter::new(CutterSpec {
        kind: Kind::Bull,
        major: 10.0,
        minor: 6.0,
        length: 120.0,
        construction: Construction::Solid,
        shank: Vec::new(),
    })
    .ok()
}

/// Feed and half range of the offset direction: the widest strips, and the awkward ones whose
/// optimum is not a corner.
const CASES: [([f64; 2], f64); 2] = [([0.0, 1.0], 0.26), ([-1.0, 0.0], 1.3)];

fn request<'a>(face: &'a FaceIndex, cutter: &'a Cutter, case: usize) -> Request<'a> {
    let (feed, range) = CASES[case];
    Request {
        face,
        cutter,
        band: Band { lower: 0.0, upper: 0.01 },
        at: [0.4, 0.5],
        feed,
        strip: StripSide::Right,
        side: ContactSide::Ahead,
        offset_range: [-range, range],
        axis_near: None,
    }
}

#[divan::bench(args = [0, 1])]
fn cold(bencher: Bencher, case: usize) {
    if let (Some(face), Some(cutter)) = (patch(), cutter()) {
        let request = request(&face, &cutter, case);
        bencher.bench_local(|| widest(&request, None));
    }
}

#[divan::bench(args = [0, 1])]
fn warm(bencher: Bencher, case: usize) {
    if let (Some(face), Some(cutter)) = (patch(), cutter()) {
        let request = request(&face, &cutter, case);
        let next = Request {
            at: [0.4 + 0.008 * request.feed[0], 0.5 + 0.008 * request.feed[1]],
            ..request
        };
        if let Ok(first) = widest(&request, None) {
            bencher.bench_local(|| widest(&next, Some(&first)));
        }
    }
}

#[divan::bench]
fn look(bencher: Bencher) {
    if let (Some(face), Some(cutter)) = (patch(), cutter()) {
        let request = request(&face, &cutter, 0);
        if let Ok(found) = widest(&request, None) {
            let setting = Setting { face: &face, cutter: &cutter, band: request.band };
            let feed = nalgebra::Vector3::y();
            let (contact, uv) = (found.contact, found.contact_uv);
            let look = Look { feed, strip: request.strip, contact, uv };
            bencher.bench_local(|| strip_of_pose(&setting, &found.pose, &look));
        }
    }
}
