//! When a place is deepest in a moving cutter.

use super::sweep::{Instant, Sweep};
use crate::cutter::solid::Solid;
use nalgebra::Point3;

/// Steps to the time at which a place is deepest in the cutter: each squares the relative error of
/// a start that is already in the right stretch.
const STEPS: u32 = 3;

/// The same where a sharp edge passes: tangents meet in its kink after a few.
const EDGE_STEPS: u32 = 6;

/// A time, the distance of a place from the cutter, its rate, and where the cutter is.
type Look = (f64, f64, f64, Instant);

/// The time, near `start`, at which a place is deepest in the cutter: secant steps on the change of
/// its distance, and the best of what was tried.
pub(super) fn settle(
    sweep: &Sweep,
    end: &Solid,
    place: &Point3<f64>,
    start: f64,
) -> Option<(f64, Instant)> {
    let [low, high] = sweep.curve.range();
    let look = |u: f64| -> Option<Look> {
        let u = u.clamp(low, high);
        let here = sweep.instant(sweep.curve.span_at(u), u)?;
        let gap = end.gap(place, &here.pose);
        let from_tip = place - here.pose.tip;
        let rate = -gap.gradient.dot(&(here.velocity + here.turn.cross(&from_tip)));
        Some((u, gap.distance, rate, here))
    };
    let mut last = look(start)?;
    let mut best = last;
    // For a torus of radius r the distance bends like v^2 / r.
    let bend = last.3.velocity.norm_squared() / end.bending_radius();
    let reach = end.bending_radius();
    let mut step = (-last.2 / bend.max(f64::MIN_POSITIVE)).clamp(-reach, reach);
    for _ in 0..STEPS {
        let now = look(last.0 + step)?;
        if now.1 < best.1 {
            best = now;
        }
        let bend = (now.2 - last.2) / (now.0 - last.0);
        // No more bend found (or no step taken): there is nothing to gain.
        if bend <= 0.0 || bend.is_nan() {
            break;
        }
        step = (-now.2 / bend).clamp(-reach, reach);
        last = now;
    }
    if end.is_sharp() {
        best = settle_at_edge(end, best, last, look)?;
    }
    Some((best.0, best.3))
}

/// As [`settle`] where an edge passes: the distance is least in a kink, which lies where the tangents
/// on either side of it meet.
fn settle_at_edge(
    end: &Solid,
    best: Look,
    last: Look,
    look: impl Fn(f64) -> Option<Look>,
) -> Option<Look> {
    let mut best = best;
    let (mut a, mut b) = (best, last);
    let mut stride = end.bending_radius();
    for _ in 0..EDGE_STEPS {
        let crossing = a.2 * b.2 < 0.0;
        let u = if crossing {
            (b.1 - a.1 + a.2 * a.0 - b.2 * b.0) / (a.2 - b.2)
        } else {
            stride *= 2.0;
            best.0 - stride.copysign(best.2)
        };
        let now = look(u)?;
        if now.1 < best.1 {
            best = now;
        }
        // Keeps one place on either side, the nearer ones.
        if crossing && now.2 * a.2 > 0.0 {
            a = now;
        } else if crossing {
            b = now;
        } else {
            (a, b) = (best, now);
        }
    }
    Some(best)
}
