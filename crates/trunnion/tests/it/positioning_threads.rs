//! Cutter locations by the thousand: the same on any number of threads; and strips that reach
//! both of their end points.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
use crate::brute_force;

use brute_force::{Shape, bezier};
use nalgebra::Point3;
use rayon::prelude::*;
use trunnion::cutter::{Cutter, CutterConstruction, CutterKind, CutterSpec};
use trunnion::positioning::{
    AxisCone, CutterLocation, LocationRequest, StripSide, ToleranceBand, widest_strip,
};
use trunnion::surface::FaceIndex;
use trunnion::types::Interval;

/// The patch of paper 004: heights by rows of y.
fn patch() -> FaceIndex {
    let places = [-60.0, -30.0, 30.0, 60.0];
    let heights = [
        [0.0, -20.0, -20.0, 5.0],
        [-5.0, -15.0, -25.0, -5.0],
        [-5.0, -25.0, -20.0, -5.0],
        [5.0, -15.0, -15.0, 0.0],
    ];
    let point = |i: usize, j: usize| Point3::new(places[i], places[j], heights[j][i]);
    bezier((0..4).map(|i| (0..4).map(|j| point(i, j)).collect()).collect())
}

fn cutter(major: f64, minor: f64) -> Cutter {
    let (kind, construction) = (CutterKind::Bull, CutterConstruction::Solid);
    let shank = Vec::new();
    Cutter::new(CutterSpec {
        kind,
        length: 120.0,
        construction,
        shank,
        ..CutterSpec::of_radii(major, minor)
    })
    .unwrap()
}

fn request<'a>(face: &'a FaceIndex, cutter: &'a Cutter, at: [f64; 2]) -> LocationRequest<'a> {
    LocationRequest {
        offset_range: Interval::new(-0.26, 0.26),
        ..LocationRequest::new(
            face,
            cutter,
            ToleranceBand { lower: 0.0, upper: 0.01 },
            at.into(),
            [0.0, 1.0],
        )
    }
}

/// Rows of locations, each from the one before; rows run in parallel.
fn rows(face: &FaceIndex, cutter: &Cutter, [rows, stations]: [u32; 2]) -> Vec<Vec<CutterLocation>> {
    let row = |row: u32| {
        let u = 0.1 + 0.8 * f64::from(row) / f64::from(rows);
        let mut found: Vec<CutterLocation> = Vec::new();
        for station in 0..stations {
            let v = 0.2 + 0.6 * f64::from(station) / f64::from(stations);
            let request = request(face, cutter, [u, v]);
            found.push(widest_strip(&request, found.last()).unwrap());
        }
        found
    };
    (0..rows).into_par_iter().map(row).collect()
}

#[test]
fn threads_change_no_bit() {
    let (face, bull) = (patch(), cutter(10.0, 6.0));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        // Every bit of every number: the shortest text that reads back as the same number.
        pool.install(|| format!("{:?}", rows(&face, &bull, [8, 40])))
    };
    let one = on(1);
    assert!(one.len() > 100_000, "{one}");
    for threads in [2, 3] {
        assert!(on(threads) == one, "{threads} threads give another result");
    }
}

/// Strips that once ended at a maximum next to an end point: curvatures, radii of the cutter, upper
/// end of the band, heading in degrees, and whether the strip lies on the left.
type Short = ([f64; 2], [f64; 2], f64, f64, bool);
const SHORT: [Short; 4] = [
    (
        [0.016_603_857_870_505_487, -0.001_539_636_414_629_359_8],
        [6.164_185_019_125_972, 5.553_909_905_403_037],
        0.015_764_910_224_156_575,
        232.713_762_463_834_7,
        false,
    ),
    (
        [0.018_163_040_521_248_897, 0.030_190_468_770_855_888],
        [8.224_224_342_925_927, 2.036_770_677_767_889_6],
        0.011_980_405_916_144_082,
        326.450_909_421_402_97,
        false,
    ),
    (
        [-0.000_981_693_703_661_367_5, 0.0],
        [11.264_837_389_231_191, 7.214_028_143_812_605],
        0.011_734_815_444_684_753,
        226.576_542_477_012_25,
        true,
    ),
    (
        [-0.000_367_173_417_847_497_7, 0.014_130_322_339_313_455],
        [6.987_056_253_035_671_5, 7.997_174_877_935_307],
        0.024_017_769_099_869_586,
        218.581_581_373_688_46,
        true,
    ),
];

#[test]
fn strips_reach_both_end_points() {
    for (k, [major, minor], upper, degrees, left) in SHORT {
        let (face, at, feed) = Shape::Quadric(k).face(degrees);
        let strip = if left { StripSide::Left } else { StripSide::Right };
        let (bull, band) = (cutter(major, minor), ToleranceBand { lower: 0.0, upper });
        let offset_range = [-0.4, 0.4];
        let plain = request(&face, &bull, at);
        let found = widest_strip(
            &LocationRequest { band, feed, strip, offset_range: offset_range.into(), ..plain },
            None,
        )
        .unwrap();
        let share = found.strip_width / found.chord_width;
        assert!(share > 0.999, "{k:?}: {share}");
    }
}

/// Held to a neighbour there is a location wherever a search from everywhere finds one, as wide.
#[test]
fn what_is_held_near_a_neighbour_is_as_wide_as_from_scratch() {
    let (face, bull) = (patch(), cutter(10.0, 6.0));
    let mut compared = 0;
    for u in [0.2, 0.4, 0.6, 0.8] {
        let mut before = widest_strip(&request(&face, &bull, [u, 0.2]), None).unwrap();
        for station in 1..12 {
            let v = 0.2 + 0.05 * f64::from(station);
            let free = request(&face, &bull, [u, v]);
            let around = |turn: f64| {
                let alpha = before.offset_direction;
                let [low, high] = free.offset_range.ends();
                let offset_range = [(alpha - turn).max(low), (alpha + turn).min(high)];
                let axis_cone = Some(AxisCone { axis: before.pose.axis, max_turn: turn });
                LocationRequest { offset_range: offset_range.into(), axis_cone, ..free }
            };
            let mut next = None;
            for turn in [0.01, 0.04, 0.16] {
                let request = around(turn);
                let (held, cold) =
                    (widest_strip(&request, Some(&before)), widest_strip(&request, None));
                match (&held, &cold) {
                    (Ok(held), Ok(cold)) => {
                        let share = held.chord_width / cold.chord_width;
                        assert!(share > 0.995, "{u} {v} {turn}: {share}");
                        compared += 1;
                    }
                    (Err(error), Ok(_)) => panic!("{u} {v} {turn}: {error}"),
                    _ => {}
                }
                next = next.or(held.ok());
            }
            before = next.unwrap_or(before);
        }
    }
    assert!(compared > 60, "{compared}");
}
