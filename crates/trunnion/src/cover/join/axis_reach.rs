//! Tool axes within the machine's reach, on the links between passes.

use crate::math;
use crate::math::angle::{angle_between, great_circle};
use crate::types::PoseCurve;
use nalgebra::{Unit, UnitVector3, Vector3};
use std::f64::consts::{PI, TAU};
use std::fmt;

/// Tool axes that the machine's rotary travel allows on a link.
#[derive(Clone, Copy)]
pub struct AxisReach<'a> {
    /// Tool axis with all axes at home, in the workpiece frame: in the middle of the reach.
    pub home: UnitVector3<f64>,
    /// Returns `true` if the machine reaches a tool axis.
    pub reaches: &'a (dyn Fn(&UnitVector3<f64>) -> bool + Sync),
}

impl fmt::Debug for AxisReach<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Turns").field("home", &self.home).finish_non_exhaustive()
    }
}

/// Angles from the home axis of the axes over which a link is tried \[rad\]. At home itself many
/// machines are singular.
const RINGS: [f64; 3] = [PI / 12.0, PI / 6.0, PI / 3.0];

/// Axes tried on each ring.
const SPOKES: u32 = 12;

/// Angle between the axes that are checked \[rad\]. It is less than the margin that the caller
/// keeps from the ends of travel.
const STEP: f64 = PI / 360.0;

impl AxisReach<'_> {
    /// Returns `true` if the machine reaches all axes on the great circles from one axis to the
    /// next.
    pub(crate) fn holds(&self, axes: &[UnitVector3<f64>]) -> bool {
        axes.windows(2).all(|pair| {
            let turn = angle_between(&pair[0], &pair[1]);
            let parts = (turn / STEP).ceil().max(1.0);
            let shares = (0_u32..).map(f64::from).take_while(|k| *k <= parts);
            shares.map(|k| k / parts).all(|share| {
                great_circle(&pair[0], &pair[1], share).is_none_or(|axis| (self.reaches)(&axis))
            })
        })
    }

    /// Returns `true` if the machine reaches all axes of a curve.
    pub(crate) fn holds_on(&self, curve: &PoseCurve) -> bool {
        (0..curve.spans.len()).all(|span| {
            let [start, end] = [curve.knots[span], curve.knots[span + 1]];
            let at = |share: f64| Some(curve.pose_in(span, start + (end - start) * share)?.axis);
            let Some((from, to)) = at(0.0).zip(at(1.0)) else { return false };
            // Between its ends the curve turns by a little more than they are apart.
            let parts = (2.0 * angle_between(&from, &to) / STEP).ceil().max(2.0);
            let shares = (0_u32..).map(f64::from).take_while(|k| *k <= parts);
            shares
                .map(|k| k / parts)
                .all(|share| at(share).is_some_and(|axis| (self.reaches)(&axis)))
        })
    }

    /// Returns axes about the home axis.
    pub(crate) fn around_home(&self) -> impl Iterator<Item = UnitVector3<f64>> {
        let home = self.home;
        let side = Unit::new_normalize(home.cross(&Vector3::ith(home.iamin(), 1.0)));
        let other = home.cross(&side);
        RINGS.into_iter().flat_map(move |angle| {
            (0..SPOKES).map(move |k| {
                let (sin, cos) = math::sin_cos(TAU * f64::from(k) / f64::from(SPOKES));
                let out = side.scale(cos) + other * sin;
                Unit::new_normalize(home.scale(math::cos(angle)) + out * math::sin(angle))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{Station, ToolPose};
    use nalgebra::Point3;

    /// With a table that tilts by 100 degrees, opposite sides are joined over the top, not from
    /// below.
    #[test]
    fn what_lies_below_is_gone_round() {
        let reaches = |axis: &UnitVector3<f64>| axis.z >= (100.0_f64.to_radians()).cos();
        let reach = AxisReach { home: Vector3::z_axis(), reaches: &reaches };
        let at = |x: f64, z: f64| Unit::new_normalize(Vector3::new(x, 0.0, z));
        let [left, right] = [at(-1.0, -0.15), at(1.0, -0.15)];
        assert!(!reach.holds(&[left, right]));
        let over = reach.around_home().find(|corner| reach.holds(&[left, *corner, right]));
        assert!(over.is_some_and(|axis| axis.z > 0.4));
    }

    /// A spline through axes at the end of travel leaves it between them.
    #[test]
    fn a_curve_is_asked_for_all_of_it() {
        const TILT: f64 = 2.0;
        let reaches = |axis: &UnitVector3<f64>| axis.z.acos() <= TILT + 1e-9;
        let reach = AxisReach { home: Vector3::z_axis(), reaches: &reaches };
        let curve = |tilts: [f64; 4]| {
            let stations: Vec<Station> = tilts
                .into_iter()
                .zip([0.0, 10.0, 20.0, 30.0])
                .map(|(tilt, x)| {
                    let axis = Unit::new_normalize(Vector3::new(tilt.sin(), 0.0, tilt.cos()));
                    let tip = Point3::new(x, 0.0, 0.0);
                    Station { pose: ToolPose { tip, axis }, contact: tip }
                })
                .collect();
            let axes: Vec<_> = stations.iter().map(|station| station.pose.axis).collect();
            assert!(reach.holds(&axes));
            PoseCurve::through(&stations, 10.0)
        };
        assert!(reach.holds_on(&curve([1.2, 1.4, 1.6, 1.8])));
        assert!(!reach.holds_on(&curve([TILT, TILT, 1.8, 1.4])));
    }
}
