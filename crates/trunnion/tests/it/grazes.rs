//! Shank, holder and rapid moves that graze stock between its rays: where the place and its depth are known, and on
//! random paths against many places at many times.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;

use nalgebra::{Point3, Rotation3, Unit, Vector3};
use property::cases;
use proptest::prelude::*;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::nc::read::{ClFile, ClMotion, ClPath, ClRecord};
use trunnion::types::{Silent, ToolPose};
use trunnion::verify::{self, CheckInput, CollisionKind, Solid, Stock, StockOptions, StockReport};

const TOLERANCE: f64 = 5e-4;
/// Depths are reported to a twentieth, and to half a micrometre.
const SHARE: f64 = 0.06;

fn cutter(shank: Vec<[f64; 2]>) -> Cutter {
    let spec = CutterSpec { length: 60.0, shank, ..CutterSpec::of_radii(4.0, 1.0) };
    Cutter::new(spec).unwrap()
}

/// A step of a path: where to, and whether at rapid speed.
type Step = (ToolPose, bool);

fn carve(path: &[Step], cutter: &Cutter, solid: &Solid, cell: f64) -> StockReport {
    let record = |(line, &(pose, rapid)): (u32, &Step)| {
        let motion = if rapid { ClMotion::Rapid } else { ClMotion::Feed(10.0) };
        ClRecord { line, pose, motion, way: ClPath::Straight }
    };
    let file = ClFile { records: (1..).zip(path).map(record).collect(), ..ClFile::default() };
    let input = CheckInput::locations(&file, cutter);
    let mut stock = Stock::new(solid, cell, 10_000_000).unwrap();
    let cutting = StockOptions::within(TOLERANCE);
    verify::simulate(&input, &mut stock, &cutting, &Silent).unwrap()
}

fn block() -> Solid {
    Solid::Box { low: Point3::new(-8.0, -8.0, -10.0), high: Point3::new(8.0, 8.0, 0.0) }
}

fn leaning(by: f64, about: f64) -> Unit<Vector3<f64>> {
    let axis = Rotation3::from_axis_angle(&Vector3::z_axis(), about)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), by)
        * Vector3::z();
    Unit::new_normalize(axis)
}

/// How deep a place is in a rim that leans by an angle and dips in by `dip`: as far below one side as below the other.
fn wedge(dip: f64, lean: f64) -> f64 {
    dip / (lean.sin() + lean.cos())
}

/// What is reported of shank and holder: lines and depths.
fn holders(carving: &StockReport) -> Vec<(u32, f64)> {
    assert_eq!(carving.undecided, None);
    let all = carving.collisions.iter().filter(|hit| hit.kind == CollisionKind::Holder);
    all.map(|hit| (hit.line, hit.depth)).collect()
}

proptest! {
    #![proptest_config(cases(24))]

    /// The rim of a leaning holder comes down to the top of a block, anywhere, and goes up again.
    #[test]
    fn the_rim_of_a_holder_on_the_top(
        at in [-7.0..7.0, -7.0..7.0],
        lean in 0.01..0.5f64,
        about in -3.0..3.0f64,
        depth in 0.003..0.012f64,
        cell in 0.05..0.4f64,
        round in any::<bool>(),
    ) {
        let cutter = cutter(vec![[40.0, 20.0]]);
        let base = Point3::new(0.5, 0.0, -10.0);
        let solid = if round { Solid::Cylinder { base, radius: 12.0, height: 10.0 } } else { block() };
        let axis = leaning(lean, about);
        let down = -Vector3::z();
        let aside = (down - *axis * axis.dot(&down)).normalize();
        let pose = |height: f64| {
            let rim = Point3::new(at[0], at[1], height);
            (ToolPose { tip: rim - aside * 20.0 - *axis * 40.0, axis }, false)
        };
        for (dip, lines) in [(-0.0005, vec![]), (depth, vec![3])] {
            let (path, deep) = ([20.0, 5.0, -dip, 5.0].map(pose), wedge(dip, lean));
            // The cutter's end is far beside the block, or below it.
            let carving = carve(&path, &cutter, &solid, cell);
            let reported = holders(&carving);
            if lines.is_empty() {
                prop_assert!(reported.is_empty(), "{reported:?}");
                continue;
            }
            prop_assert!(!reported.is_empty() && reported.iter().all(|(line, _)| lines.contains(line)), "{reported:?}");
            for (_, found) in reported {
                prop_assert!((found - deep).abs() < SHARE * deep + TOLERANCE, "{found} {deep}");
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(12))]

    /// A stepped pocket; beside the wall that the cutter left above, the rim of a holder leaning away from it.
    #[test]
    fn the_rim_of_a_holder_on_a_wall_that_was_cut(
        lean in 0.01..0.2f64,
        from in -10.0..5.0f64,
        depth in 0.003..0.012f64,
        cell in 0.2..0.6f64,
    ) {
        let cutter = cutter(vec![[20.0, 7.0]]);
        let solid = Solid::Box { low: Point3::new(-20.0, -20.0, -40.0), high: Point3::new(20.0, 20.0, 0.0) };
        let upright = leaning(0.0, 0.0);
        let mut path = Vec::new();
        for (z, wide) in [(-15.0, 10.0), (-30.0, 6.0)] {
            for k in 0..6 {
                let x = wide * (f64::from(k) / 2.5 - 1.0);
                let ends = if k % 2 == 0 { [-30.0, 30.0] } else { [30.0, -30.0] };
                for y in ends {
                    path.push((ToolPose { tip: Point3::new(x, y, z), axis: upright }, false));
                }
            }
            let tip = Point3::new(0.0, -30.0, 30.0);
            path.push((ToolPose { tip, axis: upright }, true));
        }
        let axis = leaning(-lean, 0.0);
        // The wall is at x = 15; the holder's lower rim is farthest that way.
        let reach = axis.x * 20.0 + 7.0 * axis.z;
        let pose = |x: f64, y: f64, z: f64| {
            (ToolPose { tip: Point3::new(x - reach, y, z), axis }, false)
        };
        for dip in [-0.0005, depth] {
            let (x, deep) = (15.0 + dip, wedge(dip, lean));
            let mut path = path.clone();
            path.extend([pose(x - 3.0, from, 30.0), pose(x - 3.0, from, -30.0)]);
            let first = u32::try_from(path.len()).unwrap() + 1;
            path.extend([pose(x, from, -30.0), pose(x, from + 3.0, -30.0), pose(x - 3.0, from, -30.0)]);
            let reported = holders(&carve(&path, &cutter, &solid, cell));
            if dip < 0.0 {
                prop_assert!(reported.is_empty(), "{reported:?}");
                continue;
            }
            prop_assert!(reported.iter().all(|(line, _)| *line >= first), "{reported:?} {first}");
            let lines: Vec<u32> = reported.iter().map(|(line, _)| *line).collect();
            prop_assert!(lines.contains(&first), "{reported:?} {first}");
            for (_, found) in reported {
                prop_assert!((found - deep).abs() < SHARE * deep + TOLERANCE, "{found} {deep}");
            }
        }
    }
}

fn between([from, to]: [&ToolPose; 2], t: f64) -> ToolPose {
    ToolPose { tip: from.tip + (to.tip - from.tip) * t, axis: from.axis.slerp(&to.axis, t) }
}

/// Distances of a point, below 0 inside, from the cutting end of the tool and from its shank.
fn distances(cutter: &Cutter, pose: &ToolPose, p: &Point3<f64>) -> [f64; 2] {
    let y = p - pose.tip;
    let [rho, z] = [pose.axis.cross(&y).norm(), pose.axis.dot(&y)];
    let [height, radius] = cutter.spec().shank[0];
    let [out, down] = [rho - cutter.major(), cutter.minor() - z];
    let round = out.max(0.0).hypot(down.max(0.0)) + out.max(down).min(0.0);
    let end = (round - cutter.minor()).max(z - height);
    [end, (rho - radius).max(height - z).max(z - cutter.length())]
}

/// Times of a move that are looked at.
const TIMES: u32 = 60;

/// How near anything came to a point on a path.
fn nearest(cutter: &Cutter, path: &[Step], p: &Point3<f64>) -> f64 {
    let times = || (0..=TIMES).map(|i| f64::from(i) / f64::from(TIMES));
    let of = |pair: &[Step]| {
        let at = |t| distances(cutter, &between([&pair[0].0, &pair[1].0], t), p);
        times()
            .map(|t| at(t).into_iter().fold(f64::INFINITY, f64::min))
            .fold(f64::INFINITY, f64::min)
    };
    path.windows(2).map(of).fold(f64::INFINITY, f64::min)
}

/// The same before the move `k`, and on it by what may cut.
fn nearest_to_cut(cutter: &Cutter, path: &[Step], k: usize, p: &Point3<f64>) -> f64 {
    let own = [path[k - 1].0, path[k].0];
    let end = |i: u32| {
        distances(cutter, &between([&own[0], &own[1]], f64::from(i) / f64::from(TIMES)), p)[0]
    };
    let cuts = (0..=TIMES).filter(|_| !path[k].1).map(end).fold(f64::INFINITY, f64::min);
    cuts.min(nearest(cutter, &path[..k], p))
}

/// Close by one another in the block and above, some of them at rapid speed.
fn path() -> impl Strategy<Value = Vec<Step>> {
    let step = (-7.0..7.0, -7.0..7.0, -6.0..2.0, -0.3..0.3, -3.0..3.0, 0..4u8);
    prop::collection::vec(step, 3..9).prop_map(|steps| {
        let pose = |(x, y, z, lean, about, rapid): (f64, f64, f64, f64, f64, u8)| {
            let pose = ToolPose { tip: Point3::new(x, y, z), axis: leaning(lean, about) };
            (pose, rapid == 0)
        };
        steps.into_iter().map(pose).collect()
    })
}

proptest! {
    #![proptest_config(cases(24))]

    /// Nowhere is a shank or a rapid move deeper in what is left than reported: many random places, and no place reported that
    /// something was before.
    #[test]
    fn random_paths_with_a_short_cutter(path in path(), places in prop::collection::vec([-1.0..1.0, -1.0..1.0, -1.0..1.0, 0.0..1.0], 4000)) {
        let cutter = cutter(vec![[7.0, 6.0]]);
        let carving = carve(&path, &cutter, &block(), 0.5);
        let reported = |line: u32, kind: CollisionKind| {
            carving.collisions.iter().find(|hit| (hit.line, hit.kind) == (line, kind))
        };
        let kinds = [CollisionKind::Rapid, CollisionKind::Holder];
        for hit in &carving.collisions {
            let k = hit.line as usize - 1;
            let before = nearest(&cutter, &path[..k], &hit.point);
            // Times are sampled: a place that was held is so within what the tool moves from one to the next.
            prop_assert!(before > -1e-3, "{hit} {before}");
        }
        for [x, y, z, t] in places {
            let p = Point3::new(8.0 * x, 8.0 * y, 5.0 * z - 5.0);
            for k in 1..path.len() {
                let deep = distances(&cutter, &between([&path[k - 1].0, &path[k].0], t), &p);
                for (kind, distance) in kinds.into_iter().zip(deep) {
                    if kind == CollisionKind::Rapid && !path[k].1 {
                        continue;
                    }
                    let known = reported(u32::try_from(k).unwrap() + 1, kind).map_or(0.002, |hit| hit.depth);
                    if -distance > known + SHARE * known + TOLERANCE && nearest_to_cut(&cutter, &path, k, &p) > 0.3 {
                        // What is deeper than rays are apart is reported as deep as rays show it.
                        prop_assert!(known > 0.25, "line {}, {kind:?}: {} deep at {p}, reported {known}", k + 1, -distance);
                    }
                }
            }
        }
    }
}
