//! Arcs of every dialect: centre and sweep from what is written.

use super::control::{ControlState, MoveTarget};
use super::log::ReadRemark;
use super::step::{Arc, Way};
use crate::math;
use std::f64::consts::TAU;

/// Ends closer to the start than this are the start \[mm\]: below the digits of any program.
const SAME_PLACE: f64 = 1e-6;

/// Largest difference of the radii at both ends \[mm\], or as a share of the radius: CAM rounds ends and
/// centres to the digits of the program.
pub(super) const ROUNDED: f64 = 0.0127;
const ROUNDED_SHARE: f64 = 1e-3;

/// Form in which the centre is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ArcForm {
    /// From the start \[mm\].
    Center([f64; 2]),
    /// Positive for less than half a turn, negative for more \[mm\].
    Radius(f64),
}

/// Sense in which an arc runs, seen against the third axis of its plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ArcSense {
    /// `G2`, `DR-`.
    Clockwise,
    /// `G3`, `DR+`.
    Counterclockwise,
}

/// An arc as written.
#[derive(Debug, Clone, Copy)]
pub(super) struct GivenArc {
    /// Slots of the plane.
    pub(super) plane: [usize; 2],
    pub(super) form: ArcForm,
    pub(super) sense: ArcSense,
    /// 1: less than a full turn, or one; each more adds one.
    pub(super) turns: u32,
    /// Largest difference of the radii at both ends that the control takes \[mm\].
    pub(super) rounded: f64,
}

pub(super) fn unknown_start(at: usize) -> ReadRemark {
    let message = "an arc from a position that the program does not state";
    ReadRemark::new(at, message, "program both axes of its plane absolutely before it")
}

/// Returns the arc from the current position to a target.
pub(super) fn way(
    control: &ControlState,
    target: &MoveTarget,
    given: &GivenArc,
) -> Result<Way, ReadRemark> {
    // Component of the chord: a coordinate less the current position, or a distance as it is.
    // Without a word the axis stays.
    let chord = |slot: usize| match target.get(slot) {
        None => Ok(0.0),
        Some(word) if target.is_incremental(slot) => Ok(word),
        Some(word) => {
            let place = control.reading(slot).ok_or_else(|| unknown_start(target.at))?;
            Ok(word - place)
        }
    };
    // From here on all points are relative to the start of the arc, so that offsets and shifts
    // cancel.
    let [u, v] = given.plane;
    let end = [chord(u)?, chord(v)?];
    let center = match given.form {
        ArcForm::Center(center) => centered(end, center, given.rounded, target.at)?,
        ArcForm::Radius(radius) => by_radius(end, radius, given.sense, target.at)?,
    };
    if given.turns == 0 {
        return Err(ReadRemark::new(target.at, "an arc of no turns", "P counts from 1"));
    }
    let sweep = sweep(end, center, given.sense);
    // Further turns extend the sweep in its own sense: |sweep| + 2π (turns - 1).
    let sweep = sweep + sweep.signum() * TAU * (f64::from(given.turns) - 1.0);
    // The order of the plane's axes defines the positive sense, whatever their slots.
    Ok(Way::Arc(Arc { plane: given.plane, center, sweep }))
}

fn norm([u, v]: [f64; 2]) -> f64 {
    math::hypot(u, v)
}

fn is_full(end: [f64; 2]) -> bool {
    norm(end) < SAME_PLACE
}

/// Moves the centre to the nearest point that is equally far from both ends.
fn centered(
    end: [f64; 2],
    center: [f64; 2],
    rounded: f64,
    at: usize,
) -> Result<[f64; 2], ReadRemark> {
    // With the start as origin the radii are |c| at the start and |e - c| at the end.
    let radius = norm(center);
    let other = norm([end[0] - center[0], end[1] - center[1]]);
    if radius < SAME_PLACE {
        return Err(ReadRemark::new(at, "an arc of radius zero", "look at its centre"));
    }
    // The fixed limit covers the digits of small arcs, the relative one those of large arcs.
    let off = (radius - other).abs();
    if off > rounded && off > ROUNDED_SHARE * radius.max(other) {
        let message =
            format!("the arc begins {radius:.4} mm from its centre and ends at {other:.4} mm");
        let help =
            "look at centre and end: G91.1 counts I J K from the start, G90.1 from the origin";
        return Err(ReadRemark::new(at, message, help));
    }
    if is_full(end) {
        return Ok(center);
    }
    // Foot of the centre on the perpendicular bisector of the chord.
    let length2 = end[0] * end[0] + end[1] * end[1];
    let along = (center[0] * end[0] + center[1] * end[1]) / length2 - 0.5;
    Ok([center[0] - along * end[0], center[1] - along * end[1]])
}

/// Returns the centre of an arc given by its radius: left or right of the chord.
fn by_radius(
    end: [f64; 2],
    radius: f64,
    sense: ArcSense,
    at: usize,
) -> Result<[f64; 2], ReadRemark> {
    // Every point at the distance |R| from the start would be the centre of a full circle.
    let half = 0.5 * norm(end);
    if is_full(end) {
        let help = "write the centre of a full circle";
        return Err(ReadRemark::new(at, "an arc with R that ends where it begins", help));
    }
    // The chord must fit into the circle, |e| / 2 <= |R|, up to the rounding of the words.
    let off = half - radius.abs();
    if off > ROUNDED && off > ROUNDED_SHARE * half {
        let message = format!("the ends are {:.4} mm apart, more than twice R{radius}", 2.0 * half);
        return Err(ReadRemark::new(at, message, "look at the end and the radius"));
    }
    // The radius may round to slightly less than half the chord; the centre is then its midpoint.
    // Pythagoras: the centre is sqrt(R^2 - (|e| / 2)^2) away from the chord.
    let height = (radius * radius - half * half).max(0.0).sqrt();
    // Counterclockwise and less than half a turn: the centre is left of the chord.
    let left = if (sense == ArcSense::Clockwise) == (radius < 0.0) { height } else { -height };
    // From the midpoint of the chord along its left normal (-v, u).
    let (u, v) = (end[0] / (2.0 * half), end[1] / (2.0 * half));
    Ok([0.5 * end[0] - left * v, 0.5 * end[1] + left * u])
}

/// Returns the signed angle from start to end, up to a full turn; end and centre are relative to the start.
fn sweep(end: [f64; 2], center: [f64; 2], sense: ArcSense) -> f64 {
    // Radii to both ends; cross = r^2 sin, dot = r^2 cos of the angle from the first to the second.
    let from = [-center[0], -center[1]];
    let to = [end[0] - center[0], end[1] - center[1]];
    let cross = from[0] * to[1] - from[1] * to[0];
    let dot = from[0] * to[0] + from[1] * to[1];
    // Coinciding ends are a full circle: a zero angle falls through to a full turn in either sense.
    let turn = if is_full(end) { 0.0 } else { math::atan2(cross, dot) };
    // The angle of atan2 lies in (-π, π]; a turn is added where it runs against the sense.
    match sense {
        ArcSense::Counterclockwise if turn > 0.0 => turn,
        ArcSense::Counterclockwise => turn + TAU,
        ArcSense::Clockwise if turn < 0.0 => turn,
        ArcSense::Clockwise => turn - TAU,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn radii_lead_to_centres() {
        // From (1, 0) about the origin to (0, 1): the end is (-1, 1) from the start.
        let end = [-1.0, 1.0];
        let near = |found: [f64; 2], expected: [f64; 2]| {
            assert!(norm([found[0] - expected[0], found[1] - expected[1]]) < 1e-12, "{found:?}");
        };
        near(by_radius(end, 1.0, ArcSense::Counterclockwise, 0).unwrap(), [-1.0, 0.0]);
        near(by_radius(end, -1.0, ArcSense::Clockwise, 0).unwrap(), [-1.0, 0.0]);
        near(by_radius(end, 1.0, ArcSense::Clockwise, 0).unwrap(), [0.0, 1.0]);
        near(by_radius(end, -1.0, ArcSense::Counterclockwise, 0).unwrap(), [0.0, 1.0]);
        assert!((sweep(end, [-1.0, 0.0], ArcSense::Counterclockwise) - FRAC_PI_2).abs() < 1e-15);
        assert!((sweep(end, [-1.0, 0.0], ArcSense::Clockwise) + 1.5 * PI).abs() < 1e-15);
        assert!((sweep([0.0, 0.0], [3.0, 0.0], ArcSense::Clockwise) + TAU).abs() < 1e-15);
        assert!(by_radius(end, 0.6, ArcSense::Counterclockwise, 0).is_err());
    }

    #[test]
    fn a_rounded_centre_is_put_between_the_ends() {
        let center = centered([-1.0, 1.001], [-1.0, 0.0], ROUNDED, 0).unwrap();
        let other = norm([-1.0 - center[0], 1.001 - center[1]]);
        assert!((norm(center) - other).abs() < 1e-12);
        assert!(centered([-1.0, 1.1], [-1.0, 0.0], ROUNDED, 0).is_err());
    }
}
