//! Cuts that pass close to a singular direction: through it, or farther away from it.

use super::options::{AxesOptions, SingularOptions};
use super::result::SingularPassage;
use crate::inverse::Inverse;
use crate::math::angle::wrap;
use crate::types::{Motion, PieceGeometry, PoseCurve, PoseSpan, ToolPath};
use nalgebra::{UnitVector3, Vector3};

/// Points a span at which the distance from the singular direction is taken.
const SAMPLES: u32 = 8;

/// Halvings in the search for the closest approach: to a millionth of a sample's distance.
const HALVINGS: u32 = 40;

/// The axis vector of a spline may be a little shorter between samples than at them, where it is
/// (nearly) a unit vector.
const LENGTH_SHARE: f64 = 0.99;

/// One route through the cone.
#[derive(Debug, Clone, Copy)]
struct ConeVisit {
    /// Parameters of entry, closest approach and exit.
    at: [f64; 3],
    /// Shortest axis vector seen.
    length: f64,
}

/// A tool path whose cuts pass the singular directions better, and what was changed.
///
/// Inside the cone the axis vector gets a smooth addition that is largest at the closest approach and
/// fades to the border of the cone with two derivatives: so much that the singular direction is passed
/// through exactly, if that is within `tilt`; else `tilt` away from it. Visits that begin or end inside
/// the cone are left alone.
pub(super) fn smooth(
    inverse: &Inverse,
    path: &ToolPath,
    options: &AxesOptions,
) -> Option<(ToolPath, Vec<SingularPassage>)> {
    let singular = options.singular.as_ref()?;
    let mut path = path.clone();
    let mut passages = Vec::new();
    for (source, piece) in path.pieces.iter_mut().enumerate() {
        let PieceGeometry::Curve(curve) = &mut piece.geometry else { continue };
        if piece.motion != Motion::Cut {
            continue;
        }
        for pole in inverse.singular_directions() {
            for visit in visits(curve, &pole, singular.cone) {
                if let Some(passage) = pass(curve, &pole, (source, visit), options, singular) {
                    passages.push(passage);
                }
            }
        }
    }
    (!passages.is_empty()).then_some((path, passages))
}

/// Axis vector at `u`.
fn axis(curve: &PoseCurve, u: f64) -> Vector3<f64> {
    curve.rates(u).axis[0]
}

/// Part of a vector square to the pole.
fn across(axis: &Vector3<f64>, pole: &UnitVector3<f64>) -> Vector3<f64> {
    axis - pole.scale(axis.dot(pole))
}

/// Angle to the pole \[rad\].
fn distance(curve: &PoseCurve, pole: &UnitVector3<f64>, u: f64) -> f64 {
    let axis = axis(curve, u);
    across(&axis, pole).norm().atan2(axis.dot(pole))
}

/// Ways from outside the cone through it and out again.
fn visits(curve: &PoseCurve, pole: &UnitVector3<f64>, cone: f64) -> Vec<ConeVisit> {
    let mut places: Vec<f64> = Vec::new();
    for pair in curve.knots.windows(2) {
        let part = |i: u32| pair[0] + (pair[1] - pair[0]) * f64::from(i) / f64::from(SAMPLES);
        places.extend((0..SAMPLES).map(part));
    }
    places.extend(curve.knots.last());
    let mut visits = Vec::new();
    let mut outside: Option<f64> = None;
    let mut inside: Vec<f64> = Vec::new();
    for &u in &places {
        if distance(curve, pole, u) < cone {
            inside.push(u);
            continue;
        }
        if let (Some(before), false) = (outside, inside.is_empty()) {
            visits.push(visit(curve, pole, (before, &inside, u)));
        }
        inside.clear();
        outside = Some(u);
    }
    visits
}

/// The closest approach: the best sample, then halving between its neighbours.
fn visit(
    curve: &PoseCurve,
    pole: &UnitVector3<f64>,
    (before, inside, after): (f64, &[f64], f64),
) -> ConeVisit {
    let from = |u: f64| distance(curve, pole, u);
    let nearest = inside
        .iter()
        .enumerate()
        .min_by(|a, b| from(*a.1).total_cmp(&from(*b.1)))
        .map_or(0, |(index, _)| index);
    let neighbour = |index: Option<usize>| index.and_then(|index| inside.get(index)).copied();
    let mut low = neighbour(nearest.checked_sub(1)).unwrap_or(before);
    let mut high = neighbour(Some(nearest + 1)).unwrap_or(after);
    for _ in 0..HALVINGS {
        let third = (high - low) / 3.0;
        if from(low + third) < from(high - third) { high -= third } else { low += third }
    }
    let all = inside.iter().chain([&before, &after]);
    let length = all.map(|&u| axis(curve, u).norm()).fold(f64::INFINITY, f64::min);
    ConeVisit { at: [before, 0.5 * (low + high), after], length }
}

/// Changes one passage, if it turns the rotary by enough.
fn pass(
    curve: &mut PoseCurve,
    pole: &UnitVector3<f64>,
    (source, visit): (usize, ConeVisit),
    options: &AxesOptions,
    singular: &SingularOptions,
) -> Option<SingularPassage> {
    let [before, u, after] = visit.at;
    let [entry, exit] = [before, after].map(|u| across(&axis(curve, u), pole));
    let turn = entry.cross(&exit).dot(pole).atan2(entry.dot(&exit));
    let closest = distance(curve, pole, u);
    // So close that the axes go straight through anyway.
    let through_already = closest <= 0.1 * options.axis_tolerance;
    if turn.abs() < singular.min_rotary || through_already {
        return None;
    }
    let here = axis(curve, u);
    let off = across(&here, pole);
    let reach = LENGTH_SHARE * visit.length * singular.tilt.sin();
    let through = off.norm() <= reach;
    let shift = if through { -off } else { off * (reach / off.norm()) };
    add(curve, &visit, &shift);
    let left = distance(curve, pole, u);
    let turned = if through { wrap(turn - std::f64::consts::PI) } else { turn };
    Some(SingularPassage {
        source,
        u,
        distance: [closest, left],
        turn: [turn.abs(), turned.abs()],
        tilt: (closest - left).abs(),
    })
}

/// Adds `shift` times a hat that rises from the entry to the closest approach and falls to the exit.
fn add(curve: &mut PoseCurve, visit: &ConeVisit, shift: &Vector3<f64>) {
    let [before, top, after] = visit.at;
    for u in visit.at {
        split(curve, u);
    }
    let starts = curve.knots.clone();
    for (span, start) in curve.spans.iter_mut().zip(starts) {
        let hat = if before <= start && start < top {
            step((start - before) / (top - before), 1.0 / (top - before))
        } else if top <= start && start < after {
            step((after - start) / (after - top), -1.0 / (after - top))
        } else {
            continue;
        };
        for (coefficients, factor) in span.coefficients.iter_mut().zip(hat) {
            for row in 0..3 {
                coefficients[3 + row] += shift[row] * factor;
            }
        }
    }
}

/// Coefficients in `x` of the smooth step `10 t³ - 15 t⁴ + 6 t⁵` at `t + rate x`: from 0 to 1 with two
/// derivatives zero at both ends.
fn step(t: f64, rate: f64) -> [f64; 6] {
    let shifted = shift([0.0, 0.0, 0.0, 10.0, -15.0, 6.0], t);
    let mut power = 1.0;
    shifted.map(|coefficient| {
        let scaled = coefficient * power;
        power *= rate;
        scaled
    })
}

/// Coefficients of `p(x + by)` from those of `p(x)` (Horner's scheme, repeated).
fn shift<T>(mut c: [T; 6], by: f64) -> [T; 6]
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    for start in 0..5 {
        for k in (start..5).rev() {
            c[k] = c[k] + c[k + 1] * by;
        }
    }
    c
}

/// A knot at `u`, the curve as it is.
fn split(curve: &mut PoseCurve, u: f64) {
    let at = curve.span_at(u);
    let (Some(&start), Some(span)) = (curve.knots.get(at), curve.spans.get(at)) else { return };
    if u > start && curve.knots.get(at + 1).is_some_and(|&end| u < end) {
        let rest = PoseSpan { coefficients: shift(span.coefficients, u - start) };
        curve.knots.insert(at + 1, u);
        curve.spans.insert(at + 1, rest);
    }
}
