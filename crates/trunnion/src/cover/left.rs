//! What passes leave: points of the face against the poses of the cutter, in closed form.
//!
//! Nothing here knows of strips or closest points, so that a slip there cannot hide.

use super::lane::Lane;
use super::region::{Local, Region};
use super::stretch::Stretch;
use crate::cutter::Cutter;
use crate::types::{PoseCurve, ToolPose};
use nalgebra::Point3;
use rayon::prelude::*;

/// Distance of the poses along a pass that points are compared with \[mm\].
const POSE_STEP: f64 = 0.2;

/// Distance of the lines across the passes on which points are taken \[mm\].
const COLUMN_STEP: f64 = 1.0;

/// Points of a line from one pass to the next.
const ROWS: u32 = 24;

/// Where a pass leaves something unfinished.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Left {
    /// The first place from which on something is left; `None` where all is finished.
    pub(super) next: Option<Local>,
    /// Lines on which the pass finishes nothing although the region begins at its track: no later pass
    /// will.
    pub(super) missed: usize,
}

/// Poses of a stretch, [`POSE_STEP`] apart.
pub(super) fn poses(stretch: &Stretch, cutter: &Cutter) -> Vec<ToolPose> {
    let stations: Vec<_> = stretch.placed.iter().map(|p| p.station).collect();
    let curve = PoseCurve::through(&stations, super::lever(cutter));
    let [start, end] = curve.range();
    let steps = ((end - start) / POSE_STEP).ceil().max(1.0);
    std::iter::successors(Some(0.0), |i| Some(i + 1.0))
        .take_while(|i| *i <= steps)
        .filter_map(|i| curve.pose(start + (end - start) * i / steps))
        .collect()
}

/// Takes `next`, where the strips say that a pass ends, back to where points show it.
pub(super) fn left<Inside: Fn(Local) -> bool + Sync>(
    lane: &Lane<'_>,
    region: &Region<Inside>,
    swept: &[ToolPose],
    next: Option<Local>,
) -> Left {
    let [[_, last], _] = region.bounds;
    let end = next.map_or(last, |next| next[0]);
    let [start, finish] = lane.track.face();
    let columns = ((finish - start) / COLUMN_STEP).ceil().max(1.0);
    let alongs: Vec<f64> = std::iter::successors(Some(0.0), |i| Some(i + 1.0))
        .take_while(|i| *i <= columns)
        .map(|i| lane.track.at(start + (finish - start) * i / columns))
        .collect();
    let column = |along: f64| column(lane, region, swept, [along, end]);
    let ends: Vec<Option<Local>> = alongs.into_par_iter().map(column).collect();
    let stuck = |place: &&Local| place[0] <= lane.across;
    let missed = ends.iter().flatten().filter(stuck).count();
    let found = ends.iter().flatten().filter(|place| !stuck(place)).copied();
    let next = found.chain(next).min_by(|a, b| a[0].total_cmp(&b[0]));
    Left { next, missed }
}

/// The last place of the line at `along`, up to `end` across, before one that is not finished; `None` if
/// all are.
fn column<Inside: Fn(Local) -> bool + Sync>(
    lane: &Lane<'_>,
    region: &Region<Inside>,
    swept: &[ToolPose],
    [along, end]: [f64; 2],
) -> Option<Local> {
    let chart = lane.options.along;
    let (face, cutter) = (lane.face.face(), lane.cutter);
    // Between poses the distance has a minimum whose second derivative is at most 1 / r.
    let between = 0.125 * POSE_STEP * POSE_STEP / cutter.minor().max(POSE_STEP);
    let limit = lane.options.band.upper + lane.options.path_share + between;
    let at = |row: u32| lane.across + (end - lane.across) * f64::from(row) / f64::from(ROWS);
    let open = |row: &u32| {
        let [u, v] = chart.uv([at(*row), along]);
        region.holds([at(*row), along]) && !finished(&face.point(u, v), swept, cutter, limit)
    };
    // The end itself is where the next pass begins.
    (1..ROWS).find(open).map(|row| [at(row - 1), along])
}

fn finished(point: &Point3<f64>, swept: &[ToolPose], cutter: &Cutter, limit: f64) -> bool {
    let reach = cutter.radius() + cutter.minor() + limit;
    swept.iter().any(|pose| {
        (point - pose.tip).norm_squared() <= reach * reach && distance(point, pose, cutter) <= limit
    })
}

/// Signed distance of a point from the cutting end: what is higher than `r` above the tip and not
/// farther than `R` from the axis, grown by `r`.
pub(super) fn distance(point: &Point3<f64>, pose: &ToolPose, cutter: &Cutter) -> f64 {
    let from_tip = point - pose.tip;
    let height = from_tip.dot(&pose.axis);
    let below = cutter.minor() - height;
    let out = (from_tip - pose.axis.scale(height)).norm() - cutter.major();
    let outside = out.max(0.0).hypot(below.max(0.0));
    outside + out.max(below).min(0.0) - cutter.minor()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::{Construction, CutterSpec, Kind};
    use nalgebra::Vector3;

    #[test]
    fn distances_from_a_standing_cutter_by_pencil() {
        let (kind, construction) = (Kind::Bull, Construction::Solid);
        let spec =
            CutterSpec { kind, major: 4.0, minor: 3.0, length: 60.0, construction, shank: vec![] };
        let cutter = Cutter::new(spec).unwrap();
        let pose = ToolPose { tip: Point3::origin(), axis: Vector3::z_axis() };
        let at = |x: f64, z: f64| distance(&Point3::new(x, 0.0, z), &pose, &cutter);
        for (x, z, expected) in
            [(0.0, -1.0, 1.0), (9.0, 8.0, 2.0), (8.0, 0.0, 2.0), (7.0, 3.0, 0.0), (0.0, 1.0, -1.0)]
        {
            assert!((at(x, z) - expected).abs() < 1e-12, "{x} {z}: {}", at(x, z));
        }
    }
}
