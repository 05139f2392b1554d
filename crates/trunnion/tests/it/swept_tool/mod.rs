//! What a cutter leaves on its way, in closed form: shared by the tests of passes.

#![allow(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::Point3;
use trunnion::cover::lever;
use trunnion::cutter::Cutter;
use trunnion::toolpath::{ToolPathOptions, through};
use trunnion::types::Interval;
use trunnion::types::{Leg, Motion, Pass, PieceGeometry, Silent, ToolPose};

/// Distance between the poses that are tried \[mm\].
pub(crate) const SPACING: f64 = 0.1;

/// Signed distance of `p` from the cutter, the solid of height above `r` within `R`, grown by `r`.
pub(crate) fn distance(p: &Point3<f64>, pose: &ToolPose, cutter: &Cutter) -> f64 {
    let from_tip = p - pose.tip;
    let up = from_tip.dot(&pose.axis) - cutter.minor();
    let out = (from_tip.norm_squared() - from_tip.dot(&pose.axis).powi(2)).max(0.0).sqrt()
        - cutter.major();
    let outside = out.max(0.0).hypot((-up).max(0.0));
    let inside = out.max(-up).min(0.0);
    outside + inside - cutter.minor()
}

/// Poses of the cutting curves, [`SPACING`] of contact track apart.
pub(crate) fn poses(passes: &[Pass], cutter: &Cutter) -> Vec<ToolPose> {
    let mut poses = Vec::new();
    assert!(!passes.is_empty());
    for pass in passes {
        let legs = [Leg { motion: Motion::Cut, stations: pass.stations.clone() }];
        let path = through(&legs, &ToolPathOptions::with_lever(lever(cutter)), &Silent).unwrap();
        let PieceGeometry::Curve(curve) = &path.pieces[0].geometry else { continue };
        let Interval { low: start, high: end } = curve.range();
        let steps = ((end - start) / SPACING).ceil();
        let ways = std::iter::successors(Some(0.0), |i| Some(i + 1.0)).take_while(|i| *i <= steps);
        poses.extend(ways.map(|i| curve.pose(start + (end - start) * i / steps).unwrap()));
    }
    poses
}
