//! Run-outs where the continued surface gives no cutter location.

use crate::cover::place::candidate::{CandidatePass, PlacedStation};
use crate::cover::prove::span_strip::{SpanCheck, SpanStrip};
use crate::math;
use crate::types::{Station, ToolPose, Uv};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};

/// Direction along a track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Heading {
    /// Towards growing parameters.
    Forward,
    Backward,
}

impl Heading {
    fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }
}

/// Rigid motion of the cutter along the circle of curvature of a track, from one of its points.
struct ArcMotion {
    from: Point3<f64>,
    feed: UnitVector3<f64>,
    normal: UnitVector3<f64>,
    /// Curvature of the surface along the track, positive towards `normal` \[1/mm\].
    curvature: f64,
}

impl ArcMotion {
    /// Prepares the motion along the track from a station.
    fn new(candidate: &CandidatePass<'_>, place: &PlacedStation, heading: Heading) -> Option<Self> {
        let chart = candidate.chart;
        let face = candidate.face.face();
        let [u, v] = chart.uv([place.across, place.along]);
        let jet = face.surface.jet2(u, v);
        let [_, step] = chart.steps([place.across, place.along]);
        let [du, dv] = step.map(|s| heading.sign() * s);
        let feed = Unit::try_new(jet.su * du + jet.sv * dv, f64::MIN_POSITIVE)?;
        let (normal, curvature) = (jet.normal()?, jet.normal_curvature([du, dv])?);
        let (normal, curvature) =
            if face.flip { (-normal, -curvature) } else { (normal, curvature) };
        Some(Self { from: jet.s, feed, normal, curvature })
    }

    /// Moves a station by `length` \[mm\]: turned by the angle of the arc, and along its chord.
    fn carry(&self, station: &Station, length: f64) -> Station {
        // An arc of this length turns by curvature * length; its chord leaves at half that angle.
        let half = 0.5 * self.curvature * length;
        let axis = Unit::new_normalize(self.feed.cross(&self.normal));
        let turn = math::rotation_about(&axis, 2.0 * half);
        // Chord 2 sin(half) / curvature; the quotient loses no digits above the smallest numbers.
        let chord =
            if half.abs() > f64::MIN_POSITIVE { length * math::sin(half) / half } else { length };
        let direction: Vector3<f64> =
            self.feed.scale(math::cos(half)) + self.normal.scale(math::sin(half));
        let moved = |p: &Point3<f64>| self.from + turn * (p - self.from) + direction * chord;
        let axis = Unit::new_normalize(turn * station.pose.axis.into_inner());
        Station {
            pose: ToolPose { tip: moved(&station.pose.tip), axis },
            contact: moved(&station.contact),
        }
    }
}

/// Carries the pass on from its end `last` to arc length `target`, in steps of half the largest
/// spacing, as long as it does not gouge.
///
/// The cutter keeps its attitude to the circle of curvature at the end, so it neither sinks nor
/// lifts as long as the face bends evenly.
pub(crate) fn run_out(
    candidate: &CandidatePass<'_>,
    between: &SpanCheck<'_>,
    last: &PlacedStation,
    target: f64,
) -> Vec<PlacedStation> {
    let mut added = Vec::new();
    let heading = if target > last.arc { Heading::Forward } else { Heading::Backward };
    let Some(roll) = ArcMotion::new(candidate, last, heading) else { return added };
    let distance = (target - last.arc).abs();
    let steps = (2.0 * distance / candidate.options.spacing.high).ceil();
    let mut guess: [f64; 2] = last.contact_uv.into();
    for step in std::iter::successors(Some(1.0), |i| Some(i + 1.0)).take_while(|i| *i <= steps) {
        let length = distance * step / steps;
        let station = roll.carry(&last.station, length);
        let Ok(foot) = candidate.face.closest_near(&station.contact, guess.into()) else {
            return added;
        };
        let strip = if candidate.cutter.is_barrel() {
            barrel_strip(candidate, &station.pose, foot.uv)
        } else {
            let Ok(strip) = between.strip(&station.pose, &station.contact, foot.uv.into()) else {
                return added;
            };
            strip
        };
        let arc = last.arc + heading.sign() * length;
        // Over the face the pass has to leave a strip; beside it only not to gouge.
        let useless =
            candidate.track.over_face(arc) && strip.far.is_none_or(|f| f[0] <= candidate.across);
        let barred = candidate.keep_off.check(&station.pose, foot.uv).is_err();
        if strip.least < between.band.lower || useless || barred {
            return added;
        }
        guess = foot.uv.into();
        let along = candidate.track.at(arc);
        let mut location = last.location.clone();
        location.pose = station.pose;
        let chart = candidate.chart;
        location.far = chart.uv(strip.far.unwrap_or([candidate.across, along])).into();
        let contact_uv = foot.uv;
        added.push(PlacedStation { arc, along, location, station, contact_uv, ..*last });
    }
    added
}

/// Returns the strip of a barrel that is carried on: none, as it serves beside the face only, and whether it gouges.
fn barrel_strip(candidate: &CandidatePass<'_>, pose: &ToolPose, uv: Uv) -> SpanStrip {
    let is_clear = candidate.keep_off.check_own(pose, uv).is_ok();
    SpanStrip { far: None, least: if is_clear { f64::INFINITY } else { f64::NEG_INFINITY } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_a_circle_by_pencil() {
        let roll = ArcMotion {
            from: Point3::origin(),
            feed: Vector3::x_axis(),
            normal: Vector3::z_axis(),
            curvature: 0.1,
        };
        let pose = ToolPose { tip: Point3::origin(), axis: Vector3::z_axis() };
        let station = Station { pose, contact: Point3::new(0.0, 2.0, 0.0) };
        let moved = roll.carry(&station, 10.0 * std::f64::consts::FRAC_PI_2);
        assert!((moved.pose.tip - Point3::new(10.0, 0.0, 10.0)).norm() < 1e-12);
        assert!((moved.pose.axis.into_inner() + Vector3::x()).norm() < 1e-12);
        assert!((moved.contact - Point3::new(10.0, 2.0, 10.0)).norm() < 1e-12);
        let straight = ArcMotion { curvature: 0.0, ..roll }.carry(&station, 3.0);
        assert!((straight.pose.tip - Point3::new(3.0, 0.0, 0.0)).norm() < 1e-15);
    }
}
