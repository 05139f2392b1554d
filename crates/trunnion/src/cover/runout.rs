//! Run-outs where the continued surface gives no cutter location.

use super::between::Between;
use super::lane::{Lane, Placed};
use crate::types::{Station, ToolPose};
use nalgebra::{Point3, Rotation3, Unit, UnitVector3, Vector3};

/// A rigid motion of the cutter along the circle of curvature of a track, from one of its places.
struct Roll {
    from: Point3<f64>,
    feed: UnitVector3<f64>,
    normal: UnitVector3<f64>,
    /// Curvature of the surface along the track, positive towards `normal` \[1/mm\].
    curvature: f64,
}

impl Roll {
    /// Along the track at `place`, towards growing parameters or back.
    fn new(lane: &Lane<'_>, place: &Placed, forward: bool) -> Option<Self> {
        let chart = lane.chart;
        let face = lane.face.face();
        let [u, v] = chart.uv([place.across, place.along]);
        let jet = face.surface.jet2(u, v);
        let [_, step] = chart.steps([place.across, place.along]);
        let [du, dv] = step.map(|s| if forward { s } else { -s });
        let feed = Unit::try_new(jet.su * du + jet.sv * dv, f64::MIN_POSITIVE)?;
        let (normal, curvature) = (jet.normal()?, jet.normal_curvature([du, dv])?);
        let (normal, curvature) =
            if face.flip { (-normal, -curvature) } else { (normal, curvature) };
        Some(Self { from: jet.s, feed, normal, curvature })
    }

    /// A station moved by `way` \[mm\]: turned by the angle of the arc, and along its chord.
    fn carry(&self, station: &Station, way: f64) -> Station {
        let half = 0.5 * self.curvature * way;
        let axis = Unit::new_normalize(self.feed.cross(&self.normal));
        let turn = Rotation3::from_axis_angle(&axis, 2.0 * half);
        // Chord 2 sin(half) / curvature; the quotient loses nothing above the smallest numbers.
        let length = if half.abs() > f64::MIN_POSITIVE { way * half.sin() / half } else { way };
        let chord: Vector3<f64> = self.feed.scale(half.cos()) + self.normal.scale(half.sin());
        let moved = |p: &Point3<f64>| self.from + turn * (p - self.from) + chord * length;
        let axis = Unit::new_normalize(turn * station.pose.axis.into_inner());
        Station {
            pose: ToolPose { tip: moved(&station.pose.tip), axis },
            contact: moved(&station.contact),
        }
    }
}

/// Carries the pass on from its end `last` to arc length `target`, in steps of half the largest
/// spacing, as long as it does not gouge: the cutter keeps its attitude to the circle of curvature at the
/// end, so that it neither sinks nor lifts as long as the face bends evenly.
pub(super) fn run_out(
    lane: &Lane<'_>,
    between: &Between<'_>,
    last: &Placed,
    target: f64,
) -> Vec<Placed> {
    let mut added = Vec::new();
    let forward = target > last.way;
    let Some(roll) = Roll::new(lane, last, forward) else { return added };
    let distance = (target - last.way).abs();
    let steps = (2.0 * distance / lane.options.spacing[1]).ceil();
    let mut guess = last.contact_uv;
    for step in std::iter::successors(Some(1.0), |i| Some(i + 1.0)).take_while(|i| *i <= steps) {
        let way = distance * step / steps;
        let station = roll.carry(&last.station, way);
        let Ok(foot) = lane.face.closest_near(&station.contact, guess) else { return added };
        let Ok(strip) = between.strip(&station.pose, &station.contact, foot.uv) else {
            return added;
        };
        let way = last.way + if forward { way } else { -way };
        // Over the face the pass has to leave a strip, beside it only not to gouge.
        let useless = lane.track.over_face(way) && strip.far.is_none_or(|f| f[0] <= lane.across);
        let barred = lane.around.clear(&station.pose, foot.uv).is_err();
        if strip.least < between.band.lower || useless || barred {
            return added;
        }
        guess = foot.uv;
        let along = lane.track.at(way);
        let mut location = last.location.clone();
        location.pose = station.pose;
        let chart = lane.chart;
        location.far = chart.uv(strip.far.unwrap_or([lane.across, along]));
        let contact_uv = foot.uv;
        added.push(Placed { way, along, location, station, contact_uv, ..*last });
    }
    added
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_a_circle_by_pencil() {
        let roll = Roll {
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
        let straight = Roll { curvature: 0.0, ..roll }.carry(&station, 3.0);
        assert!((straight.pose.tip - Point3::new(3.0, 0.0, 0.0)).norm() < 1e-15);
    }
}
