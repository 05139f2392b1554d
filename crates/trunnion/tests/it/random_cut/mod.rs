//! What random motion is measured with: a cutter, a face below it, and how far a check is from many poses.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![allow(dead_code, reason = "every test binary uses its own part of this module")]

use super::dice::Random;
use super::many_poses::{self, Course};
use nalgebra::{Rotation3, Vector3};
use trunnion::cutter::{Cutter, CutterKind, CutterSpec};
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::verify::{CheckOptions, DeviationTolerance, Report};

pub(crate) const RAY_TOLERANCE: f64 = 1e-5;
pub(crate) const REACH: f64 = 2.0;
/// What words of nine decimals are off, at levers of a metre, and rounding of the measure itself \[mm\].
pub(crate) const ROUNDING: f64 = 1e-7;
/// Length of all tools \[mm\].
pub(crate) const LENGTH: f64 = 60.0;

pub(crate) fn any_cutter(random: &mut Random) -> Cutter {
    let [major, minor] = [random.within(0.5, 6.0), random.within(0.3, 4.0)];
    let (kind, major, minor) = match random.below(3) {
        0 => (CutterKind::Flat, major, 0.0),
        1 => (CutterKind::Ball, 0.0, minor + 1.0),
        _ => (CutterKind::Bull, major, minor),
    };
    let spec = CutterSpec { kind, length: LENGTH, ..CutterSpec::of_radii(major, minor) };
    Cutter::new(spec).unwrap()
}

/// The same with a shank, steep or stepped, and a holder.
pub(crate) fn with_holder(cutter: &Cutter, random: &mut Random) -> Cutter {
    let radius = cutter.radius();
    let neck = cutter.minor() + random.within(1.0, 8.0);
    let [low, high] = [neck + random.within(0.0, 4.0), neck + random.within(5.0, 12.0)];
    let [slim, wide] = [radius * random.within(0.6, 1.5), radius + random.within(1.0, 8.0)];
    let shank = vec![[neck, slim], [low, slim], [high, wide], [high, wide + 2.0]];
    Cutter::new(CutterSpec { shank, ..cutter.spec().clone() }).unwrap()
}

/// A bicubic patch below the tool where it starts, leaning and waved.
pub(crate) fn any_face(random: &mut Random, way: &dyn Course, cutter: &Cutter) -> Face {
    let start = way.pose(0, 0.0);
    let up = Rotation3::rotation_between(&Vector3::z(), &start.axis).unwrap();
    let [a, b] = [random.within(-0.5, 0.5), random.within(-0.5, 0.5)];
    let turn = up * Rotation3::from_euler_angles(a, b, 0.0);
    // About as far below the tip as the lean lifts its edge.
    let gap = random.within(-0.4, 0.4) + 0.3 * a.hypot(b) * cutter.radius();
    let place = start.tip - start.axis.into_inner() * gap;
    let size = random.within(2.0, 6.0);
    let mut point = |i: usize, j: usize| {
        let along = |k: usize| size * (k as f64 / 3.0 - 0.5);
        let waved = random.point(0.07 * size);
        place + turn * (Vector3::new(along(i), along(j), 0.0) + waved)
    };
    let net = (0..4).map(|i| (0..4).map(|j| point(i, j)).collect()).collect();
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([3, 3], [knots(), knots()], net, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

/// How heights are looked for.
pub(crate) fn options(grid: f64) -> CheckOptions {
    // Heights along the normal alone: no point counts as cut by what is beside it.
    let tolerance = DeviationTolerance { excess: 1e-9, gouge: 0.002 };
    CheckOptions {
        reach: REACH,
        ray_tolerance: RAY_TOLERANCE,
        most_points: 10_000,
        bounds: None,
        ..CheckOptions::of_tolerance(tolerance, grid)
    }
}

/// How far the check is above what poses show at most, and how far from the tool the place is that it names \[mm\].
/// What is cut `also` counts where it gouges.
pub(crate) fn off(
    [way, also]: [&dyn Course; 2],
    cutter: &Cutter,
    face: &Face,
    report: &Report,
) -> [f64; 2] {
    let mut worst = [f64::NEG_INFINITY; 2];
    let [poses, others] = [way, also].map(|way| way.poses(many_poses::SPACING));
    let deepest = report.deviation.lowest.map_or(0.0, |extreme| extreme.height.min(0.0));
    for sample in report.maps[0].samples.iter().flatten() {
        let normal = face.normal(sample.uv.u, sample.uv.v).unwrap().into_inner();
        let ray = (sample.point, normal);
        let [seen, other] = [&poses, &others]
            .map(|poses| many_poses::lowest(poses, cutter, ray, REACH, 0.2 * RAY_TOLERANCE));
        // A gouge within the tolerance may be reported or not.
        let gouge = other.filter(|s| *s < -RAY_TOLERANCE);
        let found = sample.height;
        worst[0] = worst[0].max(match (seen, found) {
            (Some(seen), Some(found)) => found - gouge.map_or(seen, |gouge| seen.min(gouge)),
            (Some(seen), None) => REACH - seen,
            (None, _) => f64::NEG_INFINITY,
        });
        if let Some(gouge) = gouge {
            worst[0] = worst[0].max(deepest - gouge);
        }
        if let Some(found) = found {
            let place = (found, RAY_TOLERANCE);
            let mut near = many_poses::nearest((way, &poses), cutter, ray, place);
            if found < 0.0 && other.is_some() {
                near = near.min(many_poses::nearest((also, &others), cutter, ray, place));
            }
            worst[1] = worst[1].max(near);
        }
    }
    worst
}

/// Nothing moves.
pub(crate) struct Still;

impl Course for Still {
    fn moves(&self) -> usize {
        0
    }

    fn pose(&self, _: usize, _: f64) -> trunnion::types::ToolPose {
        unreachable!("no move has a pose")
    }
}
