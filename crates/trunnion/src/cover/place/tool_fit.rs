//! Largest ball that fits at a point of a face, and the reason why the cutter does not fit.

use crate::cover::prove::part_faces::{KeepOff, NearestQuery, PartFaces};
use crate::cutter::{ConvexSolid, Cutter, CutterKind};
use crate::math;
use crate::surface::FaceIndex;
use crate::types::{Interval, ToolPose, UncutReason};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Radius above which balls are not distinguished, in radii of the cutter.
const LARGEST: f64 = 20.0;

/// Steps of the shrinking ball. Each at least halves the depth of the ball where it touches a flat
/// face, and squares it where it touches at an angle.
const STEPS: u32 = 60;

/// Directions and angles of inclination at which the tool is tried at a point.
const DIRECTIONS: u32 = 12;
const ANGLES: [f64; 7] = [0.01, 0.09, 0.25, 0.5, 0.8, 1.1, 1.35];

/// Distances from the middle of its underside at which a standing tool is tried, as shares of the underside's radius: farther
/// out it gets to the foot of a wall.
const STANDING: [f64; 2] = [0.5, 0.95];

/// Points of the arc of a barrel with which it is tried, as shares of the arc.
const ARC_SHARES: [f64; 3] = [0.1, 0.5, 0.9];

/// Further angles at which a tool with a flank leans away from another face.
const STEEP: [f64; 4] = [0.8, 1.1, 1.35, FRAC_PI_2];

/// Largest inclination of cutters that are not balls \[rad\].
const MOST: f64 = 0.6;

/// Point of a face with its normal on the cutter's side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPoint {
    pub(crate) point: Point3<f64>,
    pub(crate) normal: UnitVector3<f64>,
}

impl ContactPoint {
    pub(crate) fn new(face: &FaceIndex, [u, v]: [f64; 2]) -> Option<Self> {
        let (point, normal) = (face.face().point(u, v), face.face().normal(u, v)?);
        Some(Self { point, normal })
    }

    /// Returns the centre of an arc of a radius \[mm\] that touches with a gap.
    fn above(&self, radius: f64, gap: ContactGap) -> Point3<f64> {
        self.point + self.normal.scale(radius + gap.least + gap.raised)
    }
}

/// Distance between a cutter and the point that it touches \[mm\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactGap {
    /// Distance that the tool keeps from every face.
    pub(crate) least: f64,
    /// Height by which it is raised over that.
    pub(crate) raised: f64,
}

/// Depth to which the largest ball may go into a face, as a share of its radius.
const SHALLOW: f64 = 1e-3;

/// Returns the radius of the largest ball that touches a face at a point and goes into no face by
/// more than `precision` \[mm\] or [`SHALLOW`]; infinite where a ball of [`LARGEST`] cutter radii fits.
///
/// A ball that holds another point `q` of a face shrinks to the one through both, `|q - p|² / (2
/// n.(q - p))`: no larger one that touches at `p` is free of `q`. So the radius is never too small,
/// and too large by no more than lets the ball go in by the precision.
pub(crate) fn largest_ball(
    part_faces: &PartFaces<'_>,
    contact: &ContactPoint,
    cutter: &Cutter,
    precision: f64,
) -> f64 {
    let mut radius = LARGEST * cutter.radius();
    let mut free = true;
    for _ in 0..STEPS {
        let pose =
            ToolPose { tip: contact.point + contact.normal.scale(radius), axis: contact.normal };
        let query = NearestQuery {
            // In a bowl of the ball's own radius all points are about as near: finer, all of them are compared.
            within: -precision.max(SHALLOW * radius),
            slack: 0.0,
            precision: precision.max(0.01 * radius),
            enough: f64::NEG_INFINITY,
        };
        let Some(near) = part_faces.nearest(&ConvexSolid::ball(radius), &pose, None, query) else {
            break;
        };
        let apart = near.point - contact.point;
        let rise = contact.normal.dot(&apart);
        // Ball through p with normal n that passes q: |q - (p + R n)| = R gives R = |q - p|^2 / (2
        // n . (q - p)).
        let smaller = apart.norm_squared() / (2.0 * rise);
        // Rounding at the point itself.
        if !(rise > 0.0 && smaller < radius) {
            break;
        }
        (radius, free) = (smaller, false);
    }
    if free { f64::INFINITY } else { radius }
}

/// Returns the reason why the tool does not finish a point.
pub(crate) fn reason(
    keep_off: &KeepOff<'_>,
    contact: &ContactPoint,
    cutter: &Cutter,
) -> UncutReason {
    let gap = ContactGap { least: keep_off.least, raised: 0.0 };
    corner_fits(keep_off, contact, cutter.minor())
        .and_then(|()| first_fitting(keep_off, poses(contact, gap, cutter)))
        .err()
        .unwrap_or(UncutReason::Passes)
}

/// Returns the pose nearest to an axis in which the cutter touches a point and the whole tool keeps off all faces,
/// within reach of the machine.
///
/// # Errors
///
/// The reason why there is none.
pub(crate) fn fitting_pose_along(
    keep_off: &KeepOff<'_>,
    contact: &ContactPoint,
    cutter: &Cutter,
    axis: &UnitVector3<f64>,
) -> Result<ToolPose, UncutReason> {
    corner_fits(keep_off, contact, cutter.minor())?;
    let gap = ContactGap { least: keep_off.least, raised: 0.0 };
    let along = [flank_pose(axis, contact, gap, cutter), pose_along(axis, contact, gap, cutter)];
    let others = standing_poses(contact, gap, cutter).chain(poses(contact, gap, cutter));
    first_fitting(keep_off, along.into_iter().flatten().chain(by_turn(axis, others)))
}

/// Returns the pose nearest to an axis in which the flank or the flat underside lies along a plane at a point and the whole tool
/// keeps off all faces, within reach of the machine.
///
/// # Errors
///
/// The reason why there is none.
pub(crate) fn fitting_pose_flush(
    keep_off: &KeepOff<'_>,
    contact: &ContactPoint,
    cutter: &Cutter,
    axis: &UnitVector3<f64>,
) -> Result<ToolPose, UncutReason> {
    let gap = ContactGap { least: keep_off.least, raised: 0.0 };
    let flank = flank_pose(axis, contact, gap, cutter);
    let poses = flank.into_iter().chain(standing_poses(contact, gap, cutter));
    first_fitting(keep_off, by_turn(axis, poses).into_iter())
}

/// Returns poses of a tool that stands with its flat underside on a point: with the middle of it, and with points around
/// that.
fn standing_poses(
    contact: &ContactPoint,
    gap: ContactGap,
    cutter: &Cutter,
) -> impl Iterator<Item = ToolPose> {
    let (tip, axis) = (contact.above(0.0, gap), contact.normal);
    let [across, beside] = tangents(&axis);
    let major = cutter.major();
    let ring = move |share: f64| {
        (0..DIRECTIONS).map(move |i| {
            let (sin, cos) = math::sin_cos(TAU * f64::from(i) / f64::from(DIRECTIONS));
            tip + (across.scale(cos) + beside.scale(sin)) * (share * major)
        })
    };
    let rings = STANDING.into_iter().flat_map(ring);
    let tips = std::iter::once(tip).chain(rings).filter(move |_| has_flank(cutter));
    tips.map(move |tip| ToolPose { tip, axis })
}

/// Returns `true` for a cutter with a cylindrical flank down to a flat underside.
pub(crate) fn has_flank(cutter: &Cutter) -> bool {
    matches!(cutter.kind(), CutterKind::Flat | CutterKind::Bull)
}

/// Returns the pose in which the lower end of a cylindrical flank touches a point, its axis as near to another as the
/// tangent plane allows; `None` for a cutter without such a flank, or an axis along the normal.
fn flank_pose(
    axis: &UnitVector3<f64>,
    contact: &ContactPoint,
    gap: ContactGap,
    cutter: &Cutter,
) -> Option<ToolPose> {
    let ahead = direction_ahead(axis, &contact.normal).filter(|_| has_flank(cutter))?;
    let arc = cutter.contact_arc();
    Some(arc.pose(contact.above(arc.radius, gap), &contact.normal, &ahead, FRAC_PI_2))
}

/// Sorts poses by their turn from an axis.
fn by_turn(axis: &UnitVector3<f64>, poses: impl Iterator<Item = ToolPose>) -> Vec<ToolPose> {
    let mut poses: Vec<ToolPose> = poses.collect();
    poses.sort_by(|a, b| b.axis.dot(axis).total_cmp(&a.axis.dot(axis)));
    poses
}

/// Returns the part of an axis square to a normal, of unit length; `None` along the normal.
fn direction_ahead(axis: &UnitVector3<f64>, normal: &UnitVector3<f64>) -> Option<UnitVector3<f64>> {
    let ahead = axis.into_inner() - normal.scale(normal.dot(axis));
    Unit::try_new(ahead, f64::MIN_POSITIVE)
}

/// Checks that a ball which touches a point keeps off all faces. Where the corner of a cutter does not, no inclination
/// helps; of a barrel it is the tip, which bends as much as its arc at most.
///
/// # Errors
///
/// The reason why it does not.
fn corner_fits(
    keep_off: &KeepOff<'_>,
    contact: &ContactPoint,
    radius: f64,
) -> Result<(), UncutReason> {
    let part_faces = keep_off.part_faces;
    let corner = contact.point + contact.normal.scale(radius + keep_off.least);
    let pose = ToolPose { tip: corner, axis: contact.normal };
    match part_faces.nearest(&ConvexSolid::ball(radius), &pose, None, nearest_of_all(keep_off)) {
        None => Ok(()),
        Some(near) if near.face == keep_off.own => Err(UncutReason::Hollow),
        Some(near) => Err(UncutReason::Neighbour(part_faces.number(near.face))),
    }
}

/// Returns `true` if a ball of a radius \[mm\] that touches a point with a gap keeps off all other faces.
pub(crate) fn keeps_off_others(
    keep_off: &KeepOff<'_>,
    contact: &ContactPoint,
    gap: ContactGap,
    radius: f64,
) -> bool {
    let pose = ToolPose { tip: contact.above(radius, gap), axis: contact.normal };
    let query = NearestQuery::any(keep_off.least - keep_off.precision, keep_off.precision);
    let ball = ConvexSolid::ball(radius);
    keep_off.part_faces.nearest(&ball, &pose, Some(keep_off.own), query).is_none()
}

/// Returns `true` if a ball of a radius \[mm\] that touches a point of a face goes into that face elsewhere.
pub(crate) fn is_hollow(keep_off: &KeepOff<'_>, contact: &ContactPoint, radius: f64) -> bool {
    let corner = contact.point + contact.normal.scale(radius + keep_off.least);
    let pose = ToolPose { tip: corner, axis: contact.normal };
    let within = keep_off.least - keep_off.precision;
    let query = NearestQuery::any(within, keep_off.precision);
    let ball = ConvexSolid::ball(radius);
    keep_off.part_faces.nearest_of(keep_off.own, &ball, &pose, query).is_some()
}

/// Returns the query in which all faces count, the nearest one most.
fn nearest_of_all(keep_off: &KeepOff<'_>) -> NearestQuery {
    let within = keep_off.least - keep_off.precision;
    NearestQuery { enough: f64::NEG_INFINITY, ..NearestQuery::any(within, keep_off.precision) }
}

/// Returns the first of some poses in which the whole tool keeps off all faces, within reach of the machine.
///
/// # Errors
///
/// The reason why there is none.
fn first_fitting(
    keep_off: &KeepOff<'_>,
    poses: impl Iterator<Item = ToolPose>,
) -> Result<ToolPose, UncutReason> {
    let part_faces = keep_off.part_faces;
    let within = keep_off.least - keep_off.precision;
    let query = NearestQuery::any(within, keep_off.precision);
    let (mut barred, mut far) = (None, false);
    // The face that bars one pose most often bars the next.
    let mut last = None;
    for pose in poses {
        let bars = |face: usize| {
            let hit = |solid| part_faces.nearest_of(face, solid, &pose, query).is_some();
            keep_off.tool.solids().any(hit)
        };
        if last.is_some_and(bars) {
            continue;
        }
        let hit =
            keep_off.tool.solids().find_map(|solid| part_faces.nearest(solid, &pose, None, query));
        match hit {
            Some(near) => {
                last = Some(near.face);
                barred = barred.or(last);
            }
            None if keep_off.cost.reaches(&pose) => return Ok(pose),
            None => far = true,
        }
    }
    if far {
        return Err(UncutReason::Machine);
    }
    Err(barred.map_or(UncutReason::Passes, |face| UncutReason::Tool(part_faces.number(face))))
}

/// Heights above the lower end of the band at which a tool is tried that goes into a neighbouring face, as shares of
/// the room above it.
const LIFTS: [f64; 3] = [0.0, 0.5, 1.0];

/// Poses that are tried first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PoseOrder {
    /// Those that lean square to the nearest other face: along a corner the inclination stays the same to the corner.
    Square,
    /// Those that lean as the pose before or straight away from that, first those whose strips are wide: along the flank, and
    /// on the underside.
    Widest,
    /// Those nearest to the pose before.
    AsBefore,
}

/// Search of a pose that fits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PoseSearch {
    /// Height by which the tool may be raised where its corner would go into a face \[mm\].
    pub(crate) room: f64,
    /// Pose before, to whose inclination the nearest is searched; without it the first from upright to inclined.
    pub(crate) before: Option<ToolPose>,
    pub(crate) order: PoseOrder,
}

/// Returns a pose in which the cutter touches a point and the whole tool keeps off all faces, within reach of the machine:
/// the first in the order of the search.
pub(crate) fn fitting_pose_near(
    keep_off: &KeepOff<'_>,
    contact: &ContactPoint,
    cutter: &Cutter,
    search: PoseSearch,
) -> Option<ToolPose> {
    let PoseSearch { room, before, order } = search;
    let query = NearestQuery::any(keep_off.least - keep_off.precision, keep_off.precision);
    let ball_fits = |corner: &Point3<f64>| {
        let ball = ToolPose { tip: *corner, axis: contact.normal };
        let solid = ConvexSolid::ball(cutter.minor());
        keep_off.part_faces.nearest(&solid, &ball, None, query).is_none()
    };
    // Step 1: the corner alone. Where it does not fit, no inclination helps.
    let gap = |share: f64| ContactGap { least: keep_off.least, raised: share * room };
    let fits_raised = |gap: &ContactGap| ball_fits(&contact.above(cutter.minor(), *gap));
    let gap = LIFTS.into_iter().map(gap).find(fits_raised)?;
    // Step 2: the whole tool, at inclinations more and more different.
    let fits = |pose: &ToolPose| keep_off.cost.reaches(pose) && !keep_off.hits_any(pose);
    let sorted = |poses: Vec<ToolPose>| match before {
        None => poses,
        Some(before) => by_turn(&before.axis, poses.into_iter()),
    };
    let square = || sorted(square_poses(keep_off, contact, gap, cutter)).into_iter().find(fits);
    let as_before = || {
        let same = before.and_then(|before| pose_along(&before.axis, contact, gap, cutter));
        let others = || sorted(poses(contact, gap, cutter).collect());
        same.filter(fits).or_else(|| others().into_iter().find(fits))
    };
    match order {
        PoseOrder::Square => square().or_else(as_before),
        PoseOrder::Widest => {
            let ahead = before.and_then(|before| direction_ahead(&before.axis, &contact.normal));
            let poses = ahead.map(|ahead| poses_towards(ahead, contact, gap, cutter));
            wide_first(poses.unwrap_or_default(), &contact.normal).into_iter().find(fits)
        }
        PoseOrder::AsBefore => as_before().or_else(square),
    }
}

/// Sorts poses by the lesser of the angles of flank and underside to a face: between the two, the tool leaves a groove.
fn wide_first(mut poses: Vec<ToolPose>, normal: &UnitVector3<f64>) -> Vec<ToolPose> {
    let groove = |pose: &ToolPose| {
        let cos = pose.axis.dot(normal).abs();
        cos.min((1.0 - cos * cos).max(0.0).sqrt())
    };
    poses.sort_by(|a, b| groove(a).total_cmp(&groove(b)));
    poses
}

/// Returns poses that lean straight towards the nearest other face, and straight away from it.
///
/// In the corner of a slope and a floor a flat end lies up the slope, and the tool leans down it: a little to either side its
/// edge would dip into the floor.
fn square_poses(
    keep_off: &KeepOff<'_>,
    contact: &ContactPoint,
    gap: ContactGap,
    cutter: &Cutter,
) -> Vec<ToolPose> {
    let ahead = keep_off.neighbour_normal(&contact.point, cutter.radius());
    let ahead = ahead.and_then(|other| direction_ahead(&other, &contact.normal));
    ahead.map_or_else(Vec::new, |ahead| poses_towards(ahead, contact, gap, cutter))
}

/// Returns poses that lean straight in a direction along a face, and straight away from it.
fn poses_towards(
    ahead: UnitVector3<f64>,
    contact: &ContactPoint,
    gap: ContactGap,
    cutter: &Cutter,
) -> Vec<ToolPose> {
    let arc = cutter.contact_arc();
    // Away from another face farther than elsewhere, up to the flank: at the foot of a wall the tool stands.
    let steep = STEEP.into_iter().filter(move |_| has_flank(cutter));
    let pose = |ahead: UnitVector3<f64>, angle: f64| {
        arc.pose(contact.above(arc.radius, gap), &contact.normal, &ahead, angle)
    };
    let both = [-ahead, ahead].into_iter();
    let both = both.flat_map(|ahead| angles(cutter).map(move |angle| pose(ahead, angle)));
    both.chain(steep.map(|angle| pose(ahead, angle))).collect()
}

/// Returns the pose along an axis that touches at a point; `None` where such an axis leaves the face's side, or inclines
/// a cutter that is no ball too far.
fn pose_along(
    axis: &UnitVector3<f64>,
    contact: &ContactPoint,
    gap: ContactGap,
    cutter: &Cutter,
) -> Option<ToolPose> {
    let normal = contact.normal;
    let arc = cutter.contact_arc();
    let angle = math::acos(normal.dot(axis).clamp(-1.0, 1.0));
    let range = if cutter.is_barrel() {
        arc.inclinations
    } else if cutter.major() > 0.0 {
        Interval::new(0.0, MOST)
    } else {
        Interval::new(0.0, ANGLES[ANGLES.len() - 1])
    };
    let ahead = direction_ahead(axis, &normal)?;
    let center = contact.above(arc.radius, gap);
    range.contains(angle).then(|| arc.pose(center, &normal, &ahead, angle))
}

/// Returns `true` if the tool touches a point in some pose within reach of the machine, and keeps off all faces there.
pub(crate) fn is_accessible(
    keep_off: &KeepOff<'_>,
    contact: &ContactPoint,
    cutter: &Cutter,
) -> bool {
    let gap = ContactGap { least: 0.0, raised: 0.0 };
    first_fitting(keep_off, poses(contact, gap, cutter)).is_ok()
}

/// Returns poses that touch at a point with a gap, inclined more and more, all round.
fn poses(
    contact: &ContactPoint,
    gap: ContactGap,
    cutter: &Cutter,
) -> impl Iterator<Item = ToolPose> {
    let arc = cutter.contact_arc();
    let center = contact.above(arc.radius, gap);
    let normal = contact.normal;
    let [across, beside] = tangents(&normal);
    angles(cutter).flat_map(move |angle| {
        (0..DIRECTIONS).map(move |i| {
            let (sin, cos) = math::sin_cos(TAU * f64::from(i) / f64::from(DIRECTIONS));
            let ahead = across.scale(cos) + beside.scale(sin);
            arc.pose(center, &normal, &ahead, angle)
        })
    })
}

/// Returns two directions square to a normal and to each other, of unit length.
fn tangents(normal: &UnitVector3<f64>) -> [Vector3<f64>; 2] {
    // The component of least size keeps the cross product away from zero.
    let across = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    [across, normal.cross(&across)]
}

/// Returns the inclinations at which a cutter is tried at a point \[rad\].
fn angles(cutter: &Cutter) -> impl Iterator<Item = f64> + use<> {
    let (inclinations, is_barrel) = (cutter.contact_arc().inclinations, cutter.is_barrel());
    let on_circle = cutter.major() > 0.0;
    let tip = ANGLES.into_iter().filter(move |angle| !on_circle || *angle <= MOST);
    let arc = ARC_SHARES.into_iter().map(move |share| inclinations.at(share));
    tip.filter(move |_| !is_barrel).chain(arc.filter(move |_| is_barrel))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::cost::LengthCost;
    use crate::cutter::{CutterSpec, ToolBody};
    use crate::surface::{Face, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop};

    /// Returns the plane through the origin with a normal, as far as 60 mm from the line where y = 0 on one side.
    fn plane(number: usize, z: Vector3<f64>, x: Vector3<f64>) -> FaceIndex {
        let frame = SurfaceFrame::new(Point3::origin(), z, x).unwrap();
        let corners = [[-60.0, 0.0], [60.0, 0.0], [60.0, 60.0], [-60.0, 60.0], [-60.0, 0.0]];
        let border = TrimCurve::polyline(&corners).unwrap();
        let trims = vec![TrimLoop::new(vec![border], [None, None], 1e-9).unwrap()];
        let face = Face::new(number, Surface::Plane(PlaneSurface { frame }), trims).unwrap();
        FaceIndex::new(face).unwrap()
    }

    /// A slope meets a floor in a line at an odd angle to the directions that are tried: a wide flat end gets to its foot
    /// only straight up the slope.
    #[test]
    fn a_flat_end_gets_to_the_foot_of_a_slope() {
        let foot = Vector3::new(0.4_f64.cos(), 0.4_f64.sin(), 0.0);
        let out = Vector3::new(foot.y, -foot.x, 0.0);
        // y of the floor is out of the slope, that of the slope goes up it.
        let floor = plane(1, Vector3::z(), -foot);
        let normal = (out + Vector3::z()).normalize();
        let slope = plane(2, normal, foot);
        assert!(
            slope.face().point(0.0, 10.0).z > 7.0
                && floor.face().point(0.0, 10.0).coords.dot(&out) > 9.0
        );
        let cutter = Cutter::new(CutterSpec::flat(20.0)).unwrap();
        let part_faces = PartFaces::new([&slope, &floor].into_iter(), &cutter);
        let (tool, cost) = (ToolBody::new(&cutter), LengthCost { link: 1.0 });
        let (part_faces, tool, cost) = (&part_faces, &tool, &cost);
        let keep_off = KeepOff { cost, part_faces, own: 0, tool, least: -1e-3, precision: 1e-4 };
        let search = PoseSearch { room: 0.0, before: None, order: PoseOrder::AsBefore };
        for up in [0.002, 0.05, 1.0] {
            let contact = ContactPoint::new(&slope, [3.0, up]).unwrap();
            let pose = fitting_pose_near(&keep_off, &contact, &cutter, search).unwrap();
            // Nothing of the edge is below the floor, and it touches the slope where it should.
            let [a, b] = tangents(&pose.axis);
            let edge = (0..3600).map(|i| {
                let (sin, cos) = math::sin_cos(TAU * f64::from(i) / 3600.0);
                pose.tip + (a.scale(cos) + b.scale(sin)) * cutter.radius()
            });
            let heights = edge.map(|p| (p.z, (p - contact.point).norm()));
            let [lowest, nearest] =
                heights.fold([f64::INFINITY; 2], |[z, d], p| [z.min(p.0), d.min(p.1)]);
            assert!(lowest >= -1.2e-3 && nearest < 0.01, "{up}: {lowest} {nearest}");
        }
    }
}
