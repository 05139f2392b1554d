//! Bounds of the error between the readings, against dense sampling with another closest point, on
//! sheets whose curvature jumps under the cutter.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::Point3;
use rayon::prelude::*;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::positioning::{
    CutterLocation, CuttingContext, LocationRequest, StripQuery, StripSide, ToleranceBand,
    strip_of_pose, widest_strip,
};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
use trunnion::types::{Interval, Uv};

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

/// A sheet of 150 mm with these inner knots, waved at random.
fn sheet(degree: usize, inner: [&[f64]; 2], height: f64, random: &mut Random) -> FaceIndex {
    let count = inner.map(|knots| knots.len() + degree + 1);
    let pace = [0, 1].map(|k| 150.0 / (count[k] - 1) as f64);
    let mut point = |i: usize, j: usize| {
        let mut near = |k: usize| (k as f64 + 0.1 * random.next()) * pace[0].min(pace[1]);
        let [x, y] = [near(i), near(j)];
        Point3::new(x, y, height * random.next())
    };
    let points = (0..count[0]).map(|i| (0..count[1]).map(|j| point(i, j)).collect()).collect();
    let ends = |end: f64| vec![end; degree + 1];
    let knots = inner.map(|inner| [ends(0.0), inner.to_vec(), ends(1.0)].concat());
    let surface = NurbsSurface::new([degree; 2], knots, points, None).unwrap();
    FaceIndex::new(Face::new(1, Surface::Nurbs(surface), vec![]).unwrap()).unwrap()
}

fn cutter() -> Cutter {
    Cutter::new(CutterSpec { length: 120.0, ..CutterSpec::bull(8.0, 4.0) }).unwrap()
}

/// Angle round the tool axis from the direction to the contact.
fn angle(found: &CutterLocation, p: &Point3<f64>) -> f64 {
    let axis = found.pose.axis;
    let flat = |p: &Point3<f64>| {
        let out = p - found.center;
        out - axis.scale(axis.dot(&out))
    };
    let (x, out) = (flat(&found.contact).normalize(), flat(p));
    out.dot(&axis.cross(&x)).atan2(out.dot(&x))
}

/// What is wrong with the bounds of a location, by `samples` distances round the circle.
fn complaint(
    face: &FaceIndex,
    found: &CutterLocation,
    request: &LocationRequest,
    samples: u32,
) -> Option<String> {
    // Rounding of distances \[mm\].
    const ROUNDING: f64 = 1e-7;
    let point = |Uv { u, v }: Uv| face.face().surface.point(u, v);
    let (near, far) = (angle(found, &point(found.near)), angle(found, &point(found.far)));
    let (low, high) = (near.min(far), near.max(far));
    let axis = found.pose.axis;
    let x = axis.cross(&nalgebra::Vector3::new(0.3, 1.0, 0.1)).normalize();
    let y = axis.cross(&x);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..samples {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / f64::from(samples)).sin_cos();
        let q = found.center + (x * cos + y * sin) * request.cutter.major();
        let foot = face.closest(&q).unwrap();
        let error = foot.distance - request.cutter.minor();
        least = least.min(error);
        let at = angle(found, &foot.point);
        // Feet of the ends themselves lie a little aside of the circle.
        if at > low + 1e-3 && at < high - 1e-3 {
            most = most.max(error);
        }
    }
    let kept = least >= request.band.lower - ROUNDING && most <= request.band.upper + ROUNDING;
    let bounded =
        least >= found.rear_min_bound - ROUNDING && most <= found.front_max_bound + ROUNDING;
    let tight = found.rear_min_bound >= request.band.lower - 0.06 * request.band.upper;
    let said = format!("{least} .. {most}: {found:?}");
    (!(kept && bounded && tight)).then_some(said)
}

/// Warm locations across the sheet; how many there were, and what is wrong with them.
fn pass(case: u32, face: &FaceIndex, samples: u32) -> (u32, Vec<String>) {
    let cutter = cutter();
    let strip = if case.is_multiple_of(2) { StripSide::Right } else { StripSide::Left };
    let slant = 0.3 * f64::from(case % 3);
    let request = LocationRequest {
        strip,
        offset_range: Interval::new(-0.4, 0.4),
        ..LocationRequest::new(
            face,
            &cutter,
            ToleranceBand { lower: 0.0, upper: 0.02 },
            Uv::new(0.5, 0.5),
            [1.0, slant],
        )
    };
    let (mut count, mut wrong) = (0, Vec::new());
    let mut warm: Option<CutterLocation> = None;
    for station in 0..14 {
        let along = 0.012 * f64::from(station);
        let at = [0.4 + along, 0.42 + slant * along];
        let request = LocationRequest { at: at.into(), ..request };
        warm = widest_strip(&request, warm.as_ref()).ok();
        let Some(found) = &warm else { continue };
        count += 1;
        if let Some(said) = complaint(face, found, &request, samples) {
            wrong.push(format!("{case}, {at:?}: {said}"));
        }
        let setting = CuttingContext { face, cutter: &cutter, band: request.band };
        let jet = face.face().surface.jet1(at[0], at[1]);
        let feed = jet.su * request.feed[0] + jet.sv * request.feed[1];
        let look = StripQuery { feed, strip, contact: found.contact, uv: found.contact_uv };
        let again = strip_of_pose(&setting, &found.pose, &look).unwrap();
        if again.front_min < -1e-7
            || again.rear_min < -1e-7
            || again.width < 0.99 * found.strip_width
        {
            wrong.push(format!("{case}, {at:?}: {again:?} beside {found:?}"));
        }
    }
    (count, wrong)
}

/// Smooth sheets, sheets with a knot line of jumping curvature under the cutter, and biquadratic ones, whose
/// curvature jumps at every knot.
#[test]
fn bounds_hold_where_curvature_jumps() {
    let cases: u32 =
        std::env::var("POSITIONING_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(12);
    let passes: Vec<(u32, Vec<String>)> = (0..cases)
        .into_par_iter()
        .map(|case| {
            let mut random = Random(0x9E37_79B9 + 1_000_003 * u64::from(case));
            for _ in 0..8 {
                random.next();
            }
            let height = 3.0 * (1.0 + random.next());
            let (degree, inner): (usize, [&[f64]; 2]) = match case % 4 {
                0 => (3, [&[0.3, 0.52, 0.8], &[0.45]]),
                1 => (3, [&[0.5, 0.5], &[0.45]]),
                2 => (3, [&[0.3, 0.6], &[0.45, 0.45, 0.55]]),
                _ => (2, [&[0.3, 0.45, 0.52, 0.8], &[0.45, 0.55]]),
            };
            pass(case, &sheet(degree, inner, height, &mut random), 180)
        })
        .collect();
    let count: u32 = passes.iter().map(|(count, _)| count).sum();
    let wrong: Vec<&str> =
        passes.iter().flat_map(|(_, wrong)| wrong.iter().map(String::as_str)).collect();
    assert!(wrong.is_empty(), "{} of {count}\n{}", wrong.len(), wrong.join("\n"));
    assert!(count > 7 * cases, "{count} locations");
}
