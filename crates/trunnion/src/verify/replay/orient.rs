//! Rotary axes for a tool direction: the program states the direction, and the control chooses the axes.
//!
//! Written for the check alone: the makers' inverse is not asked.

use crate::machine::{Axis, FIRST_ROTARY, Kinematics, PreferredSign, RotaryPair, SECOND_ROTARY};
use crate::math;
use crate::math::angle::angle_between;
use crate::types::AxisVector;
use crate::verify::error::VerifyError;
use nalgebra::{UnitVector3, Vector3};
use std::f64::consts::TAU;

/// Choices of rotary axes that the program leaves to the control.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Choices {
    /// Blocks that give the tool as a vector.
    pub vectors: usize,
    /// Turns into tilted planes.
    pub planes: usize,
    /// The first vector, every later change to the other solution, and every turn into a plane; only the first of them all.
    pub places: Vec<Choice>,
    /// Number of further ones.
    pub more: usize,
}

/// A choice between two solutions inside travel: along a great circle the one in which the rotaries stand, otherwise
/// that with the least travel from there; of equals the one an axis prefers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Choice {
    /// Line of the program.
    pub line: u32,
    /// A turn into a tilted plane; otherwise a vector.
    pub plane: bool,
    /// Rotary axes \[rad\].
    pub taken: RotaryPair,
    /// The other solution, on the nearest turn \[rad\]; `None` where the tool stands along the first rotary's axis, which is
    /// left where it stood.
    pub other: Option<RotaryPair>,
}

/// Most choices that are listed.
const MOST_LISTED: usize = 50;

impl Choices {
    /// Notes a solution.
    pub(crate) fn note(
        &mut self,
        line: u32,
        by: DirectionSource,
        turned: &Turned,
        before: Option<RotaryBranch>,
    ) {
        let changed = before.zip(turned.branch).is_some_and(|(before, now)| before != now);
        let plane = by == DirectionSource::Plane;
        let count = if plane { &mut self.planes } else { &mut self.vectors };
        *count += 1;
        if !plane && *count > 1 && !changed {
            return;
        }
        if self.places.len() < MOST_LISTED {
            let Turned { rotaries: taken, other, .. } = *turned;
            self.places.push(Choice {
                line,
                plane,
                taken: taken.into(),
                other: other.map(Into::into),
            });
        } else {
            self.more += 1;
        }
    }
}

/// Word of the program that gives a tool direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DirectionSource {
    /// A vector of a block.
    Vector,
    /// The normal of a tilted plane.
    Plane,
}

/// Solution of the rotaries: the side of the plane of both rotary axes on which the tool axis passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RotaryBranch {
    /// Along the cross product of both axes.
    Positive,
    /// Against it.
    Negative,
}

/// Rotary axes for a direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turned {
    pub(crate) rotaries: [f64; 2],
    pub(crate) other: Option<[f64; 2]>,
    /// Solution that was taken; `None` where both are the same.
    pub(crate) branch: Option<RotaryBranch>,
}

/// Below this sine the tool stands along the first rotary's axis \[rad\]: directions are known to some 1e-15.
const ALONG: f64 = 1e-9;
/// Excess of a direction over the reach that counts as rounding \[1\]: half of the last of six decimals in each component.
const REACH_ROUNDING: f64 = 1e-6;
/// Travels of rotaries closer than this are equal \[rad\].
const TIE: f64 = 1e-9;

/// Direction of the workpiece frame along which the tool is turned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TurnRequest<'a> {
    /// The direction.
    pub(crate) direction: UnitVector3<f64>,
    /// Axes from which the tool is turned.
    pub(crate) near: &'a AxisVector,
    /// Solution that the rotaries keep, if it is inside travel; otherwise the nearest counts.
    pub(crate) keeps: Option<RotaryBranch>,
    /// Line of the program.
    pub(crate) line: u32,
}

/// Returns the solution in which the rotaries stand; `None` where both are the same.
pub(crate) fn branch_at(kinematics: &Kinematics, axes: &AxisVector) -> Option<RotaryBranch> {
    let chain = kinematics.chain();
    let [first, second] = chain.rotary.map(|joint| joint.dir);
    let turn = math::rotation_about(&second, axes[SECOND_ROTARY]);
    let side = (turn * chain.axis.into_inner()).dot(&first.cross(&second));
    match side {
        _ if side.abs() < ALONG => None,
        _ if side > 0.0 => Some(RotaryBranch::Positive),
        _ => Some(RotaryBranch::Negative),
    }
}

/// Rotaries that turn the tool as requested: with the solution that they keep, or else nearest to where they stand; of
/// those in travel for which X, Y and Z are in travel too (`slides`), if there are any.
///
/// With `z = R2 a = R1' w`, both `z d1 = w d1` and `z d2 = a d2` hold; so that `z` lies on the line where two planes
/// meet, and is where that leaves the unit sphere (subproblem 2 of Paden and Kahan).
pub(crate) fn turned(
    kinematics: &Kinematics,
    request: &TurnRequest<'_>,
    slides: &dyn Fn([f64; 2]) -> bool,
) -> Result<Turned, VerifyError> {
    let TurnRequest { direction, near, keeps, line } = *request;
    let chain = kinematics.chain();
    let [d1, d2] = chain.rotary.map(|joint| joint.dir.into_inner());
    let (a, w) = (chain.axis.into_inner(), direction.into_inner());
    let (c, across) = (d1.dot(&d2), d1.cross(&d2));
    let square = across.norm_squared();
    // z = first d1 + second d2 + out: its projections on both axes are those of w and a.
    let [along1, along2] = [w.dot(&d1), a.dot(&d2)];
    let [first, second] = [along1 - c * along2, along2 - c * along1].map(|share| share / square);
    // What the unit length leaves for the part across both axes; below zero the direction is out of reach.
    let rest = 1.0 - (first * first + second * second + 2.0 * first * second * c);
    if rest < -REACH_ROUNDING || square <= 0.0 {
        return Err(VerifyError::OutOfReach { line, axis: w.into() });
    }
    let out = across * (rest.max(0.0) / square).sqrt();
    // Along the first axis every turn of it gives the same direction.
    let free = math::sin(angle_between(&direction, &chain.rotary[0].dir)).abs() < ALONG;
    let solution = |sign: f64| {
        let z = d1 * first + d2 * second + out * sign;
        let turn = if free { near[FIRST_ROTARY] } else { angle(&d1, &z, &w) };
        [turn, angle(&d2, &a, &z)]
    };
    // Each solution on its best turn; the better of both is taken.
    let near = [near[FIRST_ROTARY], near[SECOND_ROTARY]];
    let best = |turns| {
        let linear = if slides(turns) { LinearTravel::Inside } else { LinearTravel::Outside };
        nearest(kinematics, turns, near, linear)
    };
    let [plus, minus] = [solution(1.0), solution(-1.0)].map(best);
    let is_plus = match keeps {
        Some(RotaryBranch::Positive) if !plus.outside => true,
        Some(RotaryBranch::Negative) if !minus.outside => false,
        _ => !minus.is_before(&plus),
    };
    let (taken, other) = if is_plus { (plus, minus) } else { (minus, plus) };
    let other = (!free).then_some(other.rotaries);
    let branch = if is_plus { RotaryBranch::Positive } else { RotaryBranch::Negative };
    Ok(Turned { rotaries: taken.rotaries, other, branch: (!free).then_some(branch) })
}

/// Turn about `axis` from the half-plane of one vector to that of another \[rad\].
fn angle(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    math::atan2(axis.dot(&from.cross(to)), from.dot(to) - axis.dot(from) * axis.dot(to))
}

/// A position of the rotaries, and how good it is.
#[derive(Debug, Clone, Copy)]
struct RotaryCandidate {
    rotaries: [f64; 2],
    /// Some axis is outside its travel.
    outside: bool,
    /// From where they stood \[rad\].
    travel: f64,
    /// Axes on the side they do not prefer.
    disliked: usize,
}

impl RotaryCandidate {
    fn is_before(&self, other: &Self) -> bool {
        // Inside travel first, then the least travel, then the preferred side.
        if self.outside != other.outside {
            return other.outside;
        }
        let less = other.travel - self.travel;
        less > TIE || (less > -TIE && self.disliked < other.disliked)
    }
}

/// X, Y and Z against their travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LinearTravel {
    Inside,
    Outside,
}

/// Returns the best of the turns about the nearest.
fn nearest(
    kinematics: &Kinematics,
    turns: [f64; 2],
    near: [f64; 2],
    linear: LinearTravel,
) -> RotaryCandidate {
    let [_, _, _, first, second] = &kinematics.machine().axes;
    let axes = [first, second];
    let place = |rotaries: [f64; 2]| {
        let each = || axes.into_iter().zip(rotaries);
        let inside = |(axis, value): (&Axis, f64)| axis.limits.widened(TIE).contains(value);
        RotaryCandidate {
            rotaries,
            outside: linear == LinearTravel::Outside || !each().all(inside),
            travel: (rotaries[0] - near[0]).abs() + (rotaries[1] - near[1]).abs(),
            disliked: each().filter(|(axis, value)| dislikes(axis, *value)).count(),
        }
    };
    let turned = |slot: usize, by: f64| {
        // The turn next to where the axis stands, and others about it.
        let on_nearest = turns[slot] + TAU * ((near[slot] - turns[slot]) / TAU).round();
        on_nearest + TAU * by
    };
    let mut best = place([turned(0, 0.0), turned(1, 0.0)]);
    for first in AROUND {
        for second in AROUND {
            let other = place([turned(0, first), turned(1, second)]);
            if other.is_before(&best) {
                best = other;
            }
        }
    }
    best
}

/// Turns that are tried about the nearest: enough for any travel that has room for the angle.
const AROUND: [f64; 7] = [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0];

fn dislikes(axis: &Axis, value: f64) -> bool {
    match axis.prefer {
        Some(PreferredSign::Positive) => value < 0.0,
        Some(PreferredSign::Negative) => value >= 0.0,
        None => false,
    }
}
