//! Feasible workpiece origins: the linear axes are affine in the origin.

use super::assemble::assemble;
use super::branch_plan;
use super::branch_run::PathSegment;
use super::error::AxesError;
use super::follower::PathFollower;
use super::result::FollowedPath;
use super::segments::LinkMove;
use crate::inverse::Inverse;
use crate::machine::{AxisKind, FIRST_ROTARY, Kinematics, Machine};
use crate::types::{AxisVector, Interval};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Room kept to the ends of travel \[mm\]: more than axes bow between two nodes, and than the digits
/// in which an origin is reported.
const ROOM: f64 = 1.0;

/// Constraints of the small programs that are solved on the way; each adds one that was broken by
/// most, and with exact arithmetic none comes twice.
const MOST_CONSTRAINTS: usize = 40;

/// Workpiece origins that keep the linear axes of a path inside travel, the rotation as it is.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct OriginRanges {
    /// Ranges of x, y and z of the origin \[mm\], the other two as they are; `None`: no value of this one
    /// alone helps.
    pub along: [Option<Interval>; 3],
    /// The origin that leaves most room on all sides \[mm\].
    pub best: Vector3<f64>,
    /// That room \[mm\]; negative: no origin fits, and by at least so much an axis is short.
    pub room: f64,
    /// Names of the axes whose ends limit the room.
    pub tight: Vec<String>,
}

/// `row · shift <= most`: an end of travel at one node, for a shift of the origin.
#[derive(Debug, Clone, Copy)]
struct TravelEnd {
    row: Vector3<f64>,
    most: f64,
    axis: usize,
}

/// `row · (shift, room) <= most`, and the axis whose end it is.
type OriginConstraint = (Vector4<f64>, f64, Option<usize>);

/// Ranges of origins for axes along a path that were found without regard to the ends of the linear axes.
///
/// With the rotaries as they are, a shift `d` of the origin moves the slides by `J⁻¹ R⁻¹ d`, `J` being
/// the derivative of the tip by the slides and `R` the rotation of the setup: each end of travel at
/// each node is a half-space of origins. Retracts are left out: the machine file fixes their target.
/// `None` if the path has no nodes, or the slides lie in one plane.
pub fn origins(kinematics: &Kinematics, followed: &FollowedPath) -> Option<OriginRanges> {
    let ends = ends(kinematics, followed)?;
    let origin = kinematics.setup().origin;
    let along = [0, 1, 2].map(|axis| {
        let Interval { low, high } = interval(&ends, axis);
        (low <= high).then(|| Interval::new(origin[axis] + low, origin[axis] + high))
    });
    let (shift, room, tight) = roomiest(&ends)?;
    let axes = &kinematics.machine().axes;
    let mut names: Vec<String> =
        tight.iter().filter_map(|&axis| axes.get(axis)).map(|axis| axis.name.clone()).collect();
    names.sort();
    names.dedup();
    Some(OriginRanges { along, best: origin + shift, room, tight: names })
}

/// Collects the ends of travel at all nodes as half-spaces of shifts of the origin.
fn ends(kinematics: &Kinematics, followed: &FollowedPath) -> Option<Vec<TravelEnd>> {
    let turn = kinematics.setup().rotation.inverse();
    let axes = &kinematics.machine().axes;
    let mut ends = Vec::new();
    for (index, piece) in followed.path.pieces.iter().enumerate() {
        if followed.retracts.iter().any(|retract| retract.pieces.contains(&index)) {
            continue;
        }
        for node in &piece.nodes {
            let q = &node.q[0];
            let moves = slides_by_tip(kinematics, q)? * turn.matrix();
            for axis in 0..FIRST_ROTARY {
                // Slide i at this node moves by row · d: low + room <= q + row · d <= high - room.
                let row: Vector3<f64> = moves.row(axis).transpose();
                let [low, high] = axes.get(axis)?.limits.ends();
                let both = [(row, high - ROOM - q[axis]), (-row, q[axis] - low - ROOM)];
                let real = both.into_iter().filter(|(_, most)| most.is_finite());
                ends.extend(real.map(|(row, most)| TravelEnd { row, most, axis }));
            }
        }
    }
    (!ends.is_empty()).then_some(ends)
}

/// Returns the derivative of the slides by the tip, rotaries as at `q`. The tip is affine in the slides.
fn slides_by_tip(kinematics: &Kinematics, q: &AxisVector) -> Option<Matrix3<f64>> {
    // The columns are exact as differences: the tip is affine in the slides.
    let at = |slide: Option<usize>| {
        let mut q = *q;
        q.fixed_rows_mut::<3>(0).fill(0.0);
        if let Some(slide) = slide {
            q[slide] = 1.0;
        }
        kinematics.forward(&q).tip
    };
    let zero = at(None);
    let column = |slide: usize| at(Some(slide)) - zero;
    Matrix3::from_columns(&[column(0), column(1), column(2)]).try_inverse()
}

/// Returns the shifts along one direction of the machine that keep all ends; empty if none does.
fn interval(ends: &[TravelEnd], axis: usize) -> Interval {
    let mut range = Interval::UNBOUNDED;
    for end in ends {
        // Only this coordinate moves: each half-space bounds it from one side.
        let slope = end.row[axis];
        if slope > 0.0 {
            range.high = range.high.min(end.most / slope);
        } else if slope < 0.0 {
            range.low = range.low.max(end.most / slope);
        } else if end.most < 0.0 {
            // Broken, and no shift in this direction changes it.
            return Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        }
    }
    range
}

/// Returns the shift with the most room, that room, and the axes that limit it: the largest `m` with
/// `row · d + m <= most` for all ends.
///
/// It is a linear program in four unknowns, solved on few of its constraints, to which the one broken by
/// most is added until none is broken.
fn roomiest(ends: &[TravelEnd]) -> Option<(Vector3<f64>, f64, Vec<usize>)> {
    // Far enough for any machine, so that the first small program has a corner.
    let far = ends.iter().fold(1.0_f64, |far, end| far.max(end.most.abs())) * 8.0;
    let mut some: Vec<OriginConstraint> = Vec::new();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut row = Vector4::zeros();
            row[axis] = sign;
            some.push((row, far, None));
        }
    }
    some.push((Vector4::w(), far, None));
    loop {
        let (best, corner) = corner(&some)?;
        let shift: Vector3<f64> = best.fixed_rows::<3>(0).into();
        let room = |end: &TravelEnd| end.most - end.row.dot(&shift);
        let worst = ends.iter().min_by(|a, b| room(a).total_cmp(&room(b)))?;
        // Sums of a dozen products of lengths up to `far`.
        if room(worst) >= best.w - 64.0 * f64::EPSILON * far || some.len() >= MOST_CONSTRAINTS {
            let tight = corner.iter().filter_map(|&at| some.get(at)?.2).collect();
            return Some((shift, room(worst), tight));
        }
        // Cutting plane: the constraint broken by most joins the program.
        let row = Vector4::new(worst.row.x, worst.row.y, worst.row.z, 1.0);
        some.push((row, worst.most, Some(worst.axis)));
    }
}

/// Returns the highest corner of a small program, by trying all, and the constraints that hold it down:
/// those with a price above zero. None of a highest corner's prices is negative.
fn corner(some: &[OriginConstraint]) -> Option<(Vector4<f64>, Vec<usize>)> {
    let count = some.len();
    let picks = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b])).flat_map(|[a, b]| {
        (b + 1..count).flat_map(move |c| (c + 1..count).map(move |d| [a, b, c, d]))
    });
    let mut best: Option<(Vector4<f64>, Vec<usize>)> = None;
    for pick in picks {
        // A vertex is optimal if the objective is a combination of its constraints with weights that are not
        // negative (linear programming duality).
        let Some((x, prices)) = crossing(some, pick) else { continue };
        // Prices add up to one: the rows' last entries are 1.
        let dear = |price: f64| price > 1e3 * f64::EPSILON;
        if prices.iter().all(|price| !dear(-price))
            && best.as_ref().is_none_or(|(least, _)| x.w > least.w)
            && keeps(some, &x)
        {
            let held = pick.into_iter().zip(prices.iter()).filter(|(_, price)| dear(**price));
            best = Some((x, held.map(|(at, _)| at).collect()));
        }
    }
    best
}

/// Returns the point where four constraints meet, and the gain in height from loosening each.
fn crossing(some: &[OriginConstraint], pick: [usize; 4]) -> Option<(Vector4<f64>, Vector4<f64>)> {
    let mut rows = Matrix4::zeros();
    let mut most = Vector4::zeros();
    for (place, at) in pick.into_iter().enumerate() {
        let (row, value, _) = some.get(at)?;
        rows.set_row(place, &row.transpose());
        most[place] = *value;
    }
    // The last row of the inverse has the derivative of the height by the right-hand sides.
    let inverse = rows.try_inverse()?;
    let x = inverse * most;
    x.iter().all(|x| x.is_finite()).then(|| (x, inverse.row(3).transpose()))
}

/// Returns `true` if a corner satisfies all constraints, to rounding.
fn keeps(some: &[OriginConstraint], x: &Vector4<f64>) -> bool {
    // A product of four terms, and the rounding of the corner itself.
    let size = 1.0 + x.amax();
    some.iter()
        .all(|(row, most, _)| row.dot(x) <= most + 1024.0 * f64::EPSILON * (size + most.abs()))
}

/// Origin for a path that was found without regard to the ends of the linear axes.
pub(super) enum OriginFit {
    /// With this origin: the one it has if that will do, else moved along one direction by as little
    /// as can be, else where there is most room.
    Fits(Vector3<f64>),
    /// Nowhere: these axes are short by so much \[mm\].
    Short { by: f64, axes: Vec<String> },
}

/// Returns the origin for a path; `None` as [`origins`].
pub(super) fn place(kinematics: &Kinematics, followed: &FollowedPath) -> Option<OriginFit> {
    let now = kinematics.setup().origin;
    if ends(kinematics, followed)?.iter().all(|end| end.most >= 0.0) {
        return Some(OriginFit::Fits(now));
    }
    let OriginRanges { along, best, room, tight } = origins(kinematics, followed)?;
    if room < 0.0 {
        return Some(OriginFit::Short { by: -room, axes: tight });
    }
    let moves = along.iter().enumerate().filter_map(|(axis, range)| {
        let Interval { low, high } = (*range)?;
        Some((axis, now[axis].clamp(low, high)))
    });
    let least = moves.min_by(|a, b| (a.1 - now[a.0]).abs().total_cmp(&(b.1 - now[b.0]).abs()));
    let moved = least.map(|(axis, value)| {
        let mut origin = now;
        origin[axis] = value;
        origin
    });
    Some(OriginFit::Fits(moved.unwrap_or(best)))
}

/// Puts into an error of travel which origin would fit.
pub(super) fn explain(
    error: AxesError,
    follower: &PathFollower<'_>,
    segments: &[PathSegment],
    links: &[LinkMove],
) -> AxesError {
    let AxesError::OutOfTravel { piece, node, u, axis, kind, value, limit, excess, remedy } = error
    else {
        return error;
    };
    let kinematics = follower.inverse.kinematics();
    // The rotaries do not depend on the origin: no shift of it helps them.
    let linear = kind == AxisKind::Linear;
    let found = linear.then(|| free(follower, segments, links)).flatten();
    let fitting = found.and_then(|followed| origins(kinematics, &followed));
    let remedy = fitting.map_or(remedy, |origins| advice(kinematics, &origins));
    AxesError::OutOfTravel { piece, node, u, axis, kind, value, limit, excess, remedy }
}

/// Plans the path on the same machine without ends of travel of the linear axes.
fn free(
    follower: &PathFollower<'_>,
    segments: &[PathSegment],
    links: &[LinkMove],
) -> Option<FollowedPath> {
    let kinematics = follower.inverse.kinematics();
    let machine = endless(kinematics.machine());
    let inverse = Inverse::new(&Kinematics::new(&machine, kinematics.setup())).ok()?;
    let follower = PathFollower { inverse: &inverse, options: follower.options };
    let chosen = branch_plan::plan_branches(&follower, segments, links).ok()?;
    Some(assemble(chosen, links, segments.to_vec()))
}

/// Returns a machine without ends of travel of its linear axes.
pub(super) fn endless(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    for axis in machine.axes.iter_mut().take(FIRST_ROTARY) {
        axis.limits = Interval::UNBOUNDED;
    }
    machine
}

/// Returns the advice for the job file.
fn advice(kinematics: &Kinematics, origins: &OriginRanges) -> String {
    let now = kinematics.setup().origin;
    let [x, y, z] = now.into();
    let is = format!("[setup] origin = [{x:.1}, {y:.1}, {z:.1}] does not fit");
    let ways: Vec<String> = ["x", "y", "z"]
        .iter()
        .zip(&origins.along)
        .filter_map(|(name, range)| {
            let [low, high] = (*range)?.ends().map(|end| (end * 10.0).round() / 10.0);
            Some(format!("{name} between {low:.1} and {high:.1}"))
        })
        .collect();
    let [x, y, z] = origins.best.into();
    let best = format!("origin = [{x:.1}, {y:.1}, {z:.1}]");
    if origins.room < 0.0 {
        return format!(
            "{is}, and with this rotation no other does: wherever it is, the path goes {:.1} mm or more beyond the ends of {}; \
             turn the setup, take a shorter tool or clearance, or split the job (least bad: {best})",
            -origins.room,
            origins.tight.join(" or ")
        );
    }
    let room = format!("{best} leaves most room, {:.1} mm to every end", origins.room + ROOM);
    if ways.is_empty() {
        format!("{is}; {room}")
    } else {
        format!(
            "{is}; the whole path would with {}, the rest unchanged; {room}",
            ways.join(", or ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(row: [f64; 3], most: f64) -> TravelEnd {
        TravelEnd { row: Vector3::from(row), most, axis: 0 }
    }

    #[test]
    fn the_middle_of_a_box_has_the_most_room() {
        let mut ends = Vec::new();
        for (axis, [low, high]) in [[-10.0, 30.0], [5.0, 9.0], [-100.0, -2.0]].iter().enumerate() {
            let mut row = [0.0; 3];
            row[axis] = 1.0;
            ends.push(end(row, *high));
            row[axis] = -1.0;
            ends.push(end(row, -low));
        }
        let (shift, room, _) = roomiest(&ends).unwrap();
        assert!((room - 2.0).abs() < 1e-9 && (shift.y - 7.0).abs() < 1e-9);
        let Interval { low, high } = interval(&ends, 0);
        assert!(low > high, "x alone does not help");
        // Too narrow for anything: short by one on both sides.
        ends.push(end([0.0, 1.0, 0.0], 3.0));
        let (shift, room, _) = roomiest(&ends).unwrap();
        assert!((room + 1.0).abs() < 1e-9 && (shift.y - 4.0).abs() < 1e-9);
    }

    #[test]
    fn a_slanted_corner_is_found() {
        // A tetrahedron with its corner at zero: the centre of the ball that touches all sides.
        let s = 1.0 / 3.0_f64.sqrt();
        let ends = [
            end([-1.0, 0.0, 0.0], 0.0),
            end([0.0, -1.0, 0.0], 0.0),
            end([0.0, 0.0, -1.0], 0.0),
            end([s, s, s], s),
        ];
        let (shift, room, _) = roomiest(&ends).unwrap();
        let radius = s / (1.0 + 3.0 * s);
        assert!((room - radius).abs() < 1e-12 && (shift - Vector3::repeat(radius)).norm() < 1e-12);
    }
}
