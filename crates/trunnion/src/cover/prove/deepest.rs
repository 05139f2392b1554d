//! Time at which a point is deepest in a moving cutter.

use crate::cover::prove::sweep::{PassSweep, SweepInstant};
use crate::cutter::ConvexSolid;
use crate::types::Interval;
use nalgebra::Point3;

/// Largest number of evaluations after the first two; mostly three suffice.
const LOOKS: u32 = 8;

/// Share to which a rate falls on one side if the distance has a bow there.
const BOWED: f64 = 0.75;

/// Depth that may be missed at another time, as a share of the cutter's width, if the distance
/// falls and rises convexly. A cutter that swings to and fro bends it the other way by a little.
const PRECISION: f64 = 1e-8;

/// Distance of the point from the cutter at one time, its rate, and the pose of the cutter.
#[derive(Clone, Copy)]
struct TimeSample {
    u: f64,
    distance: f64,
    rate: f64,
    here: SweepInstant,
}

impl TimeSample {
    /// Returns the time and height at which the tangents of two samples meet.
    fn meet(&self, other: &Self) -> (f64, f64) {
        let lines = [self, other].map(|look| look.distance - look.rate * look.u);
        // Intersection of the tangents d + r (u - u0).
        let u = (lines[1] - lines[0]) / (self.rate - other.rate);
        (u, lines[0] + self.rate * u)
    }

    /// Returns the time at which a rate that changes evenly is zero.
    fn level(&self, other: &Self) -> f64 {
        // Secant method for the root of the rate.
        (self.u * other.rate - other.u * self.rate) / (other.rate - self.rate)
    }
}

/// Finds the time, near `start`, at which a point is deepest in the cutter.
///
/// As the cutter passes, the distance falls and rises again, with a bow where its rounding passes
/// and with a kink where a sharp edge does. A small rounding is both: a kink from afar, and a bow
/// nearby.
pub(crate) fn deepest(
    sweep: &PassSweep,
    end: &ConvexSolid,
    place: &Point3<f64>,
    start: f64,
) -> Option<(f64, SweepInstant)> {
    let Interval { low, high } = sweep.curve.range();
    let mut span = sweep.curve.span_at(start.clamp(low, high));
    let mut look = |u: f64| -> Option<TimeSample> {
        let u = u.clamp(low, high);
        // Looks are near to each other.
        span = sweep.curve.span_near(u, span);
        let here = sweep.instant(span, u)?;
        let gap = end.gap(place, &here.pose);
        let from_tip = place - here.pose.tip;
        // The point stands still, and the cutter moves by v + w x q: seen from it the point moves
        // the other way.
        let rate = -gap.gradient.dot(&(here.velocity + here.turn.cross(&from_tip)));
        Some(TimeSample { u, distance: gap.distance, rate, here })
    };
    let enough = PRECISION * end.width();
    let mut a = look(start)?;
    // Guess: for a torus of radius r the distance bends like v^2 / r.
    let bend = a.here.velocity.norm_squared() / end.bending_radius();
    let mut stride = end.bending_radius();
    let step = (-a.rate / bend.max(f64::MIN_POSITIVE)).clamp(-stride, stride);
    let mut b = look(a.u + step)?;
    let mut best = if b.distance < a.distance { b } else { a };
    let mut bowed = true;
    for _ in 0..LOOKS {
        let between = a.rate * b.rate < 0.0;
        // Between the samples: the root of the rate for a bow, the meeting of the tangents for a
        // kink. Outside: on downhill, with a growing stride.
        let u = if between {
            let (meet, floor) = a.meet(&b);
            if best.distance - floor <= enough {
                break;
            }
            if bowed { a.level(&b) } else { meet }
        } else {
            stride *= 2.0;
            let level = a.level(&b) - b.u;
            let down = stride.copysign(-b.rate);
            b.u + if level * down > 0.0 { level.clamp(-stride, stride) } else { down }
        };
        let now = look(u)?;
        if now.distance < best.distance {
            best = now;
        }
        // An end of the curve or the bottom is reached.
        if [a.u, b.u].contains(&now.u) {
            break;
        }
        // Keep one sample on either side of the minimum.
        if between {
            let side = if now.rate * a.rate > 0.0 { &mut a } else { &mut b };
            bowed = now.rate.abs() < BOWED * side.rate.abs();
            *side = now;
        } else {
            (a, b) = (b, now);
        }
    }
    Some((best.u, best.here))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::ToolBody;
    use crate::cutter::{Cutter, CutterKind, CutterSpec};
    use crate::types::{PoseCurve, Station, ToolPose};
    use nalgebra::{UnitVector3, Vector3};

    /// Returns a pass along x that leans into the feed, waves and turns.
    fn sweep(lever: f64, lead: f64) -> PassSweep {
        let station = |i: u32| {
            let x = f64::from(i);
            let lean =
                Vector3::new(-(lead + 0.01 * (0.1 * x).sin()).sin(), 0.02 * (0.1 * x).cos(), 1.0);
            let tip = Point3::new(x, 0.2 * (0.1 * x).sin(), 0.1 * (0.1 * x).cos());
            Station { pose: ToolPose { tip, axis: UnitVector3::new_normalize(lean) }, contact: tip }
        };
        let stations: Vec<Station> = (0..30).map(station).collect();
        PassSweep::of(PoseCurve::through(&stations, lever), lever)
    }

    /// All roundings, from none through a hundredth of a millimetre to a ball. The cutter turns on
    /// its way, so a downward bow in time is not followed to the last.
    #[test]
    fn no_other_time_nearby_is_deeper() {
        let sizes =
            [[8.0, 0.0], [8.0, 0.001], [8.0, 0.03], [8.0, 0.5], [6.0, 2.0], [4.0, 3.0], [0.0, 6.0]];
        for ([major, minor], lead) in sizes.into_iter().zip([0.1, 0.05, 0.2]).cycle().take(21) {
            let kind = match (major, minor) {
                (0.0, _) => CutterKind::Ball,
                (_, 0.0) => CutterKind::Flat,
                _ => CutterKind::Bull,
            };
            let spec = CutterSpec { kind, length: 60.0, ..CutterSpec::of_radii(major, minor) };
            let cutter = Cutter::new(spec).unwrap();
            let end = ToolBody::new(&cutter).end;
            let sweep = sweep(cutter.radius(), lead);
            for i in 0..24 {
                let place = Point3::new(
                    8.0 + 0.21 * f64::from(i),
                    f64::from(i % 7) - 3.0,
                    0.15 + 0.04 * f64::from(i % 5),
                );
                let depth = |u: f64| {
                    end.distance(&place, &sweep.instant(sweep.curve.span_at(u), u).unwrap().pose)
                };
                let starts = || sweep.poses.iter().map(|(u, _)| *u);
                let start = starts().min_by(|a, b| depth(*a).total_cmp(&depth(*b))).unwrap();
                let (u, _) = deepest(&sweep, &end, &place, start).unwrap();
                let near = (-4000..=4000).map(|k| start + 2.5e-4 * f64::from(k));
                let least = near.map(depth).fold(f64::INFINITY, f64::min);
                let found = depth(u);
                assert!(found <= least + 2e-5, "{major} {minor}, {place}: {found} over {least}");
            }
        }
    }
}
