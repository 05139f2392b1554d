//! Estimated time of the machine through a few poses, before anything is planned.

use crate::inverse::{Inverse, InverseSolutions};
use crate::machine::{Axis, Kinematics};
use crate::math;
use crate::types::{AXES, AxisVector, ToolPose};

/// Estimator of motions that are not planned yet.
pub(super) struct TravelEstimate {
    inverse: Inverse,
}

impl TravelEstimate {
    /// Creates an estimator; `None` if the setup is not a number.
    pub(super) fn new(kinematics: &Kinematics) -> Option<Self> {
        Some(Self { inverse: Inverse::new(kinematics).ok()? })
    }

    /// Returns the least time through poses from rest to rest \[s\]; infinite if a pose is out of reach.
    ///
    /// It is the time of the slowest axis, each moving by itself, on the better branch.
    pub(super) fn seconds(&self, poses: &[ToolPose]) -> f64 {
        let Some((first, rest)) = poses.split_first() else { return 0.0 };
        // Both branches are followed: the better start may lead to the worse end.
        let starts = match self.inverse.solutions(first) {
            Ok(InverseSolutions::Regular(both)) => both.to_vec(),
            Ok(InverseSolutions::Singular(one)) => vec![one],
            Err(_) => Vec::new(),
        };
        starts.iter().map(|start| self.through(start, rest)).fold(f64::INFINITY, f64::min)
    }

    fn through(&self, start: &AxisVector, poses: &[ToolPose]) -> f64 {
        let (mut here, mut travels) = (*start, [0.0; AXES]);
        for pose in poses {
            let Ok(next) = self.inverse.near(pose, &here) else { return f64::INFINITY };
            for (travel, (to, from)) in travels.iter_mut().zip(next.iter().zip(&here)) {
                *travel += (to - from).abs();
            }
            here = next;
        }
        // The poses are passed without a stop: each axis has one ramp up and one ramp down.
        let axes = &self.inverse.kinematics().machine().axes;
        axes.iter()
            .zip(travels)
            .map(|(axis, travel)| rest_to_rest(axis, travel))
            .fold(0.0, f64::max)
    }
}

/// Returns the least time of one axis for a travel from rest to rest \[s\].
///
/// Jerk, acceleration and speed are constant in turn, as far as the axis reaches their limits.
pub(super) fn rest_to_rest(axis: &Axis, travel: f64) -> f64 {
    let (v, a, j) = (axis.rapid, axis.acc, axis.jerk);
    // Highest acceleration within the travel. Four jerk phases of a/j each travel 2 a³/j², so that
    // a = (travel j² / 2)^(1/3); the first two reach the speed a²/j, which must stay below v.
    let a = a.min(math::cbrt(0.5 * travel * j * j)).min((v * j).sqrt());
    // Highest speed: travel = v (v/a + a/j) solved for v.
    let v = v.min(0.5 * ((a * a / j).powi(2) + 4.0 * a * travel).sqrt() - 0.5 * a * a / j);
    // A symmetric profile lasts travel/v plus the time to reach v, v/a + a/j.
    if travel > 0.0 { travel / v + v / a + a / j } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::machine::{built_in, parse};

    #[test]
    fn an_axis_goes_by_what_binds_it() {
        let machine = parse(built_in("bc-trunnion").unwrap()).unwrap().machine;
        let axis =
            |rapid: f64, acc: f64, jerk: f64| Axis { rapid, acc, jerk, ..machine.axes[0].clone() };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b, "{a} {b}");
        // Jerk alone: four equal phases, each of (travel / 2 j)^(1/3).
        near(rest_to_rest(&axis(1e9, 1e9, 2000.0), 4.0), 4.0 * (4.0_f64 / 4000.0).cbrt());
        // Acceleration (all but) alone.
        near(rest_to_rest(&axis(1e9, 100.0, 1e20), 25.0), 1.0);
        // Speed binds: travel / v + v / a + a / j.
        near(rest_to_rest(&axis(10.0, 100.0, 1000.0), 50.0), 5.0 + 0.1 + 0.1);
        // Speed binds before acceleration is reached: travel / v + 2 sqrt(v / j).
        near(rest_to_rest(&axis(10.0, 1e6, 1000.0), 50.0), 5.0 + 2.0 * 0.1);
        near(1.0 + rest_to_rest(&axis(10.0, 100.0, 1000.0), 0.0), 1.0);
    }
}
