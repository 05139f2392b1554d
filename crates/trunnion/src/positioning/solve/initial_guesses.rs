//! Initial guesses of the search for the widest strip.

use crate::math;
use crate::positioning::location::CutterLocation;
use crate::positioning::solve::conditions::{StripProblem, offset_curvature};
use crate::positioning::solve::optimum::LocalOptimum;
use crate::types::Interval;
use std::f64::consts::FRAC_PI_2;

/// Ranges of the unknowns of a search \[rad\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct SearchRanges {
    /// Range of the offset direction.
    pub(crate) offset: Interval,
    /// Range of the rotation about the chord.
    pub(crate) rotation: Interval,
}

/// Initial guess of a climb, and the box it stays in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InitialGuess {
    /// `(w, alpha, theta)`.
    pub(crate) x: [f64; 3],
    /// Trust region at first, in units of `scale`.
    pub(crate) trust: f64,
    /// Size of a bold step of each unknown.
    pub(crate) scale: [f64; 3],
    /// Range of the offset direction \[rad\].
    pub(crate) offset_range: Interval,
    /// Range of the rotation \[rad\].
    pub(crate) rotation_range: Interval,
}

/// Largest distance between two starts of the offset direction \[rad\].
pub(crate) const START_SPACING: f64 = 0.27;

/// Returns a neighbour's location, clamped to the ranges, with small steps.
pub(crate) fn warm_start(
    warm: &CutterLocation,
    SearchRanges { offset: offset_range, rotation: rotation_range }: SearchRanges,
) -> InitialGuess {
    let alpha = warm.offset_direction.clamp(offset_range.low, offset_range.high);
    let theta = warm.rotation.clamp(rotation_range.low, rotation_range.high);
    InitialGuess {
        x: [warm.offset, alpha, theta],
        trust: 0.3,
        scale: scales(warm.offset, theta),
        offset_range,
        rotation_range,
    }
}

/// Returns a guess inclined as far as the axis cone around a neighbour allows, over a short chord:
/// where the rear or the disc would touch, that is the remedy.
pub(crate) fn inclined_start(
    problem: &StripProblem,
    warm: &CutterLocation,
    SearchRanges { offset: offset_range, rotation: rotation_range }: SearchRanges,
) -> InitialGuess {
    let frame = &problem.frame;
    let alpha = warm.offset_direction.clamp(offset_range.low, offset_range.high);
    let turn = problem.axis_cone.map_or(0.0, |near| near.max_turn);
    let theta = (warm.rotation + turn).clamp(rotation_range.low, rotation_range.high);
    let across = offset_curvature(&frame.first, &frame.direction(alpha), frame.lift);
    // A circle that bends by `bend` more than the surface leaves a strip of sqrt(8 e / bend).
    let bend = math::sin(theta) / frame.major - across.unwrap_or(0.0);
    let band = problem.band.upper - problem.band.lower;
    let w = (8.0 * band / bend.max(f64::MIN_POSITIVE)).sqrt().min(frame.major);
    let scale = scales(w, theta);
    InitialGuess { x: [w, alpha, theta], trust: 1.0, scale, offset_range, rotation_range }
}

/// Returns the end of a rough climb as the guess of a fine one.
pub(crate) fn restart_from(
    rough: &LocalOptimum,
    SearchRanges { offset: offset_range, rotation: rotation_range }: SearchRanges,
) -> InitialGuess {
    let x = rough.state.placement.x;
    InitialGuess { x, trust: 0.3, scale: scales(x[0], x[2]), offset_range, rotation_range }
}

/// Returns a bold step of `(w, alpha, theta)`: a third of what there is, but not less than a degree.
fn scales(w: f64, theta: f64) -> [f64; 3] {
    [0.3 * w, 0.2, (0.3 * theta.abs()).max(0.017)]
}

/// Excess bend of an initial guess over the surface along the chord, and its rise along the feed, as
/// sines of the rotation. The next one is tried where none of the guesses found a strip.
pub(crate) const TILTS: [f64; 3] = [0.05, 0.2, 0.5];

/// Returns guesses spread over the offset range. Along the chord the circle, turned by theta, bends like
/// `sin(theta) / R`, and so does the line from its front to its rear against the surface along
/// the feed; a start bends clearly more than the surface does both ways, so that it fits at once.
pub(crate) fn cold_starts(
    problem: &StripProblem,
    tilt: f64,
    SearchRanges { offset: offset_range, rotation: rotation_range }: SearchRanges,
) -> Vec<InitialGuess> {
    let frame = &problem.frame;
    let [low, high] = offset_range.ends();
    let band = problem.band.upper - problem.band.lower;
    let mut starts = Vec::new();
    for alpha in spread(low, high) {
        let curvature =
            |turn: f64| offset_curvature(&frame.first, &frame.direction(alpha + turn), frame.lift);
        let (Some(across), Some(along)) = (curvature(0.0), curvature(FRAC_PI_2)) else { continue };
        // sin(theta) = R k, and a margin: bends more than the surface across and along.
        let sine = (frame.major * across.max(along).max(0.0) + tilt).min(0.97);
        let theta = math::asin(sine).clamp(rotation_range.low, rotation_range.high);
        let bend = (math::sin(theta) / frame.major - across).max(tilt / frame.major);
        let w = (8.0 * band / bend).sqrt().min(frame.major);
        starts.push(InitialGuess {
            x: [w, alpha, theta],
            trust: 1.0,
            scale: scales(w, theta),
            offset_range,
            rotation_range,
        });
    }
    starts
}

/// Returns evenly spaced values over `[low, high]`, at most `START_SPACING` apart, ends left out.
fn spread(low: f64, high: f64) -> impl Iterator<Item = f64> {
    let count = ((high - low) / START_SPACING).ceil().clamp(1.0, 100.0);
    (0..100)
        .map(f64::from)
        .take_while(move |k| *k < count)
        .map(move |k| low + (high - low) * (k + 0.5) / count)
}
