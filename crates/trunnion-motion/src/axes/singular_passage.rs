//! Cuts that pass close to a singular direction: moved onto it, or farther away from it.

use super::options::{AxesOptions, SingularOptions};
use super::result::SingularPassage;
use crate::inverse::Inverse;
use crate::math;
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

/// One stretch of a curve inside the cone.
#[derive(Debug, Clone, Copy)]
struct ConeVisit {
    /// Parameters of entry, closest approach and exit.
    at: [f64; 3],
    /// Shortest axis vector among the samples.
    length: f64,
}

/// Rule by which passages are changed.
#[derive(Debug, Clone, Copy)]
struct PassageRule<'a> {
    /// Permitted changes.
    allowed: &'a SingularOptions,
    /// Angle to the singular direction up to which the axes go straight through anyway \[rad\].
    straight: f64,
}

/// Returns a tool path whose cuts pass the singular directions better, and the passages that differ.
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
    let allowed = options.singular.as_ref()?;
    let rule = PassageRule { allowed, straight: 0.1 * options.tolerance.axis };
    let mut path = path.clone();
    let mut passages = Vec::new();
    for (source, piece) in path.pieces.iter_mut().enumerate() {
        let PieceGeometry::Curve(curve) = &mut piece.geometry else { continue };
        if piece.motion != Motion::Cut {
            continue;
        }
        for pole in inverse.singular_directions() {
            for visit in visits(curve, &pole, allowed.cone) {
                if let Some(passage) = pass(source, curve, &pole, &visit, rule) {
                    passages.push(passage);
                }
            }
        }
    }
    (!passages.is_empty()).then_some((path, passages))
}

/// Returns the axis vector at `u`.
fn axis(curve: &PoseCurve, u: f64) -> Vector3<f64> {
    curve.rates(u).axis[0]
}

/// Returns the part of a vector perpendicular to the pole.
fn across(axis: &Vector3<f64>, pole: &UnitVector3<f64>) -> Vector3<f64> {
    axis - pole.scale(axis.dot(pole))
}

/// Returns the angle to the pole \[rad\].
fn distance(curve: &PoseCurve, pole: &UnitVector3<f64>, u: f64) -> f64 {
    // atan2 keeps its digits next to the pole, where the arc cosine loses half of them.
    let axis = axis(curve, u);
    math::atan2(across(&axis, pole).norm(), axis.dot(pole))
}

/// Finds the stretches of a curve that enter the cone and leave it again.
fn visits(curve: &PoseCurve, pole: &UnitVector3<f64>, cone: f64) -> Vec<ConeVisit> {
    let mut parameters: Vec<f64> = Vec::new();
    for pair in curve.knots.windows(2) {
        let part = |i: u32| pair[0] + (pair[1] - pair[0]) * f64::from(i) / f64::from(SAMPLES);
        parameters.extend((0..SAMPLES).map(part));
    }
    parameters.extend(curve.knots.last());
    let mut visits = Vec::new();
    let mut outside: Option<f64> = None;
    let mut inside: Vec<f64> = Vec::new();
    for &u in &parameters {
        if distance(curve, pole, u) < cone {
            inside.push(u);
            continue;
        }
        // A stretch without a sample outside on both sides begins or ends in the cone: left alone.
        if let (Some(before), false) = (outside, inside.is_empty()) {
            visits.push(visit(curve, pole, before, &inside, u));
        }
        inside.clear();
        outside = Some(u);
    }
    visits
}

/// Finds the closest approach between the samples `before` and `after`, which are outside the cone: the
/// best sample, then thirds of the interval between its neighbours.
fn visit(
    curve: &PoseCurve,
    pole: &UnitVector3<f64>,
    before: f64,
    inside: &[f64],
    after: f64,
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
    // Ternary search: of a function with one minimum the third beyond the worse point can be dropped.
    for _ in 0..HALVINGS {
        let third = (high - low) / 3.0;
        if from(low + third) < from(high - third) { high -= third } else { low += third }
    }
    let all = inside.iter().chain([&before, &after]);
    let length = all.map(|&u| axis(curve, u).norm()).fold(f64::INFINITY, f64::min);
    ConeVisit { at: [before, 0.5 * (low + high), after], length }
}

/// Changes one passage, if it turns the rotary by enough; `source` is the index of the piece.
fn pass(
    source: usize,
    curve: &mut PoseCurve,
    pole: &UnitVector3<f64>,
    visit: &ConeVisit,
    rule: PassageRule<'_>,
) -> Option<SingularPassage> {
    let PassageRule { allowed, straight } = rule;
    let [before, u, after] = visit.at;
    // The workpiece-side rotary follows the azimuth of the tool axis about the pole.
    let [entry, exit] = [before, after].map(|u| across(&axis(curve, u), pole));
    let turn = math::atan2(entry.cross(&exit).dot(pole), entry.dot(&exit));
    let closest = distance(curve, pole, u);
    if turn.abs() < allowed.min_rotary || closest <= straight {
        return None;
    }
    let here = axis(curve, u);
    let off = across(&here, pole);
    // An addition of length a across an axis vector of length l or more tilts it by asin(a / l) at most.
    let reach = LENGTH_SHARE * visit.length * math::sin(allowed.tilt);
    let through = off.norm() <= reach;
    // Onto the pole if that is near enough: then the other branch continues, and the turn is short by half
    // a turn. Otherwise away from it, since the peak rate of the rotary goes with 1 / sin(distance).
    let shift = if through { -off } else { off * (reach / off.norm()) };
    add(curve, visit, &shift);
    let left = distance(curve, pole, u);
    let turned = if through { wrap(turn - std::f64::consts::PI) } else { turn };
    Some(SingularPassage {
        source,
        u,
        distance_before: closest,
        distance_after: left,
        turn_before: turn.abs(),
        turn_after: turned.abs(),
        tilt: (closest - left).abs(),
    })
}

/// Adds `shift` times a hat that rises from the entry to the closest approach and falls to the exit.
fn add(curve: &mut PoseCurve, visit: &ConeVisit, shift: &Vector3<f64>) {
    let [before, top, after] = visit.at;
    // The hat is a polynomial on either side of its top: with knots at its ends and top it can be added to
    // the coefficients of each span.
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
                // Rows 3 to 5 are the axis vector; tip and contact stay as they are.
                coefficients[3 + row] += shift[row] * factor;
            }
        }
    }
}

/// Returns the coefficients in `x` of the smooth step `10 t³ - 15 t⁴ + 6 t⁵` at `t + rate x`: it rises from
/// 0 to 1 and has two derivatives zero at both ends.
fn step(t: f64, rate: f64) -> [f64; 6] {
    let shifted = shift([0.0, 0.0, 0.0, 10.0, -15.0, 6.0], t);
    let mut power = 1.0;
    shifted.map(|coefficient| {
        let scaled = coefficient * power;
        power *= rate;
        scaled
    })
}

/// Returns the coefficients of `p(x + by)` from those of `p(x)` (Horner's scheme, repeated).
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

/// Inserts a knot at `u`; the curve stays as it is.
fn split(curve: &mut PoseCurve, u: f64) {
    let at = curve.span_at(u);
    let (Some(&start), Some(span)) = (curve.knots.get(at), curve.spans.get(at)) else { return };
    if u > start && curve.knots.get(at + 1).is_some_and(|&end| u < end) {
        let rest = PoseSpan { coefficients: shift(span.coefficients, u - start) };
        curve.knots.insert(at + 1, u);
        curve.spans.insert(at + 1, rest);
    }
}
