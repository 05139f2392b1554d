//! Origin that keeps poses inside the travel of the linear axes.

use super::pass_cost::{LinearTravel, inset};
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Kinematics, Setup};
use crate::types::{Interval, ToolPose};
use nalgebra::Vector3;

/// Distance of the poses from the ends of travel, as a share of it.
const MARGIN: f64 = 0.02;

/// Steps of the search for the origin: the first and the last \[mm\].
const ORIGIN_STEPS: Interval = Interval { low: 0.5, high: 256.0 };

/// Digits of the origin \[mm\].
const ORIGIN_DIGIT: f64 = 0.1;

/// Search for the origin that keeps poses inside the travel of the linear axes.
pub(super) struct OriginSearch<'a> {
    /// The machine; its setup has the origin from which the search starts.
    pub(super) kinematics: &'a Kinematics,
    /// Poses in workpiece coordinates; those that the rotary axes do not reach are left aside.
    pub(super) poses: &'a [ToolPose],
}

/// Travel that poses need beyond the margins from its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TravelNeed {
    /// Over all linear axes \[mm\].
    sum: f64,
    /// Index of the axis that needs most, and how much \[mm\].
    pub(super) axis: usize,
    pub(super) short: f64,
}

impl OriginSearch<'_> {
    /// Finds the origin nearest to the first one, by steps along the machine's axes that are halved.
    ///
    /// # Errors
    ///
    /// The travel that is missing at the best origin, if none keeps all poses inside.
    pub(super) fn best(&self) -> Result<Vector3<f64>, TravelNeed> {
        let mut start = self.kinematics.setup().origin;
        let (mut origin, mut need) = (start, self.need(&start));
        let mut step = ORIGIN_STEPS.high;
        while need.sum > 0.0 && step >= ORIGIN_STEPS.low {
            let moves = (0..3).flat_map(|axis| [step, -step].map(|by| Vector3::ith(axis, by)));
            let tried = moves.map(|by| (origin + by, self.need(&(origin + by))));
            let least = tried.min_by(|a, b| a.1.sum.total_cmp(&b.1.sum));
            match least {
                Some((moved, less)) if less.sum < need.sum => (origin, need) = (moved, less),
                _ => step *= 0.5,
            }
        }
        if need.sum > 0.0 {
            return Err(need);
        }
        // The first steps were long: back towards the start, as far as travel allows.
        while (origin - start).norm() > ORIGIN_STEPS.low {
            let middle = 0.5 * (origin + start);
            if self.need(&middle).sum > 0.0 {
                start = middle;
            } else {
                origin = middle;
            }
        }
        Ok(origin.map(|x| (x / ORIGIN_DIGIT).round() * ORIGIN_DIGIT))
    }

    fn need(&self, origin: &Vector3<f64>) -> TravelNeed {
        let none = TravelNeed { sum: f64::INFINITY, axis: 0, short: f64::INFINITY };
        let machine = self.kinematics.machine();
        let setup = Setup { origin: *origin, ..*self.kinematics.setup() };
        let kinematics = Kinematics::new(machine, &setup);
        let Ok(inverse) = Inverse::new(&inset(&kinematics, LinearTravel::Unbounded)) else {
            return none;
        };
        let home = machine.home();
        let mut ranges = [Interval::new(f64::INFINITY, f64::NEG_INFINITY); FIRST_ROTARY];
        for pose in self.poses {
            let Ok(position) = inverse.continued(pose, &home) else { continue };
            for (axis, range) in ranges.iter_mut().enumerate() {
                *range = range.hull(Interval::point(position.q[axis]));
            }
        }
        let mut need = TravelNeed { sum: 0.0, ..none };
        for (index, (axis, range)) in machine.axes.iter().zip(ranges).enumerate() {
            let margin = MARGIN * axis.limits.width();
            let short = (axis.limits.low + margin - range.low).max(0.0)
                + (range.high - axis.limits.high + margin).max(0.0);
            if need.sum <= 0.0 || short > need.short {
                need = TravelNeed { axis: index, short, ..need };
            }
            need.sum += short;
        }
        need
    }
}
