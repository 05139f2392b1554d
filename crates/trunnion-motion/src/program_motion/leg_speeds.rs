//! Speeds of legs beside each other.

use super::block::BlockKind;
use super::leg::Leg;

/// Share by which a speed may change from leg to leg without a node: the lower speed of both holds there.
const SAME_SPEED: f64 = 0.01;

/// True if a leg has the speed of another, or nearly.
pub(super) fn is_same(one: &Leg, other: &Leg) -> bool {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_SPEED * a.min(*b);
    one.rates.iter().zip(&other.rates).all(near)
}

/// Returns the speed where two legs meet, as their times have it: with the same acceleration on either side of the corner,
/// which the corner may not allow.
pub(super) fn border_speed(before: &Leg, behind: &Leg) -> f64 {
    let [long, short] = [before, behind].map(|leg| leg.length * leg.rate());
    let speeds = [before, behind].map(|leg| 1.0 / leg.rate());
    let even = (speeds[0] * short + speeds[1] * long) / (long + short);
    even.min(behind.pace.enters)
}

/// The leg, if it is a timed one.
pub(super) fn timed(leg: Option<&Leg>) -> Option<&Leg> {
    leg.filter(|leg| leg.kind == BlockKind::Timed)
}

/// Seconds per length at a place of a timed leg: linear from its middle to an end beside a faster leg.
pub(super) fn timed_rate(leg: &Leg, beside: [Option<&Leg>; 2], share: f64) -> f64 {
    let own = leg.rates[0];
    let border = |other: &Leg| {
        (own * other.length + other.rates[0] * leg.length) / (leg.length + other.length)
    };
    let [start, end] = beside.map(|other| other.map_or(own, border).min(own));
    if share < 0.5 {
        start + (own - start) * 2.0 * share
    } else {
        own + (end - own) * (2.0 * share - 1.0)
    }
}
