//! Origin that keeps the poses of a job inside travel.

use super::cutters::CutterTrial;
use super::left_out::ProposalError;
use super::part_measure::PartMeasure;
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Kinematics, Machine, MovedBody, Setup};
use crate::pipeline::pass_cost::{LinearTravel, inset};
use crate::types::{Interval, ToolPose};
use nalgebra::Vector3;

/// Height of the part's bottom above the table, for a vice or a riser \[mm\].
const STANDOFF: f64 = 50.0;

/// Distance of the poses from the ends of travel, as a share of it.
const MARGIN: f64 = 0.02;

/// Poses by which the origin is found, at most.
const POSES: usize = 240;

/// Steps of the search for the origin: the first and the last \[mm\].
const ORIGIN_STEPS: Interval = Interval { low: 0.5, high: 256.0 };

/// Digits of the origin \[mm\].
const ORIGIN_DIGIT: f64 = 0.1;

/// Search for the origin that keeps poses inside the travel of the linear axes.
pub(super) struct OriginSearch<'a> {
    machine: &'a Machine,
    length: f64,
    poses: Vec<ToolPose>,
    start: Vector3<f64>,
}

/// Travel that the poses need beyond the margins, over all linear axes \[mm\], and the axis that needs most.
#[derive(Debug, Clone, Copy)]
struct TravelNeed {
    sum: f64,
    axis: usize,
    short: f64,
}

impl<'a> OriginSearch<'a> {
    pub(super) fn new(machine: &'a Machine, chosen: &[CutterTrial], part: &PartMeasure) -> Self {
        // The cutters of a proposal are equally long.
        let length = chosen.first().map_or(0.0, |trial| trial.cutter.length());
        let all: Vec<&ToolPose> = chosen.iter().flat_map(|trial| &trial.poses).collect();
        let stride = all.len().div_ceil(POSES).max(1);
        let clearance = part.clearance();
        // Where the tool cuts, and above, where it comes from.
        let poses = all.into_iter().step_by(stride).flat_map(|pose| {
            let up = pose.tip + Vector3::z() * clearance + pose.axis.scale(clearance);
            [*pose, ToolPose { tip: up, ..*pose }]
        });
        let start = first_origin(machine, length) - part.foot().coords;
        Self { machine, length, poses: poses.collect(), start }
    }

    /// Finds the origin nearest to the first one, by steps along the machine's axes that are halved.
    pub(super) fn best(&self) -> Result<Vector3<f64>, ProposalError> {
        let (mut origin, mut need) = (self.start, self.need(&self.start));
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
            let axis = self.machine.axes[need.axis].name.clone();
            return Err(ProposalError::Travel { axis, short: need.short });
        }
        // The first steps were long: back towards the start, as far as travel allows.
        let mut start = self.start;
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
        let setup = Setup::new(*origin, [0.0; 3], self.length);
        let kinematics = Kinematics::new(self.machine, &setup);
        let Ok(inverse) = Inverse::new(&inset(&kinematics, LinearTravel::Unbounded)) else {
            return none;
        };
        let home = self.machine.home();
        let mut ranges = [Interval::new(f64::INFINITY, f64::NEG_INFINITY); FIRST_ROTARY];
        for pose in &self.poses {
            let Ok(position) = inverse.continued(pose, &home) else { continue };
            for (axis, range) in ranges.iter_mut().enumerate() {
                *range = range.hull(Interval::point(position.q[axis]));
            }
        }
        let mut need = TravelNeed { sum: 0.0, ..none };
        for (index, (axis, range)) in self.machine.axes.iter().zip(ranges).enumerate() {
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

/// Returns the place of the middle of the part's bottom: above the middle of the table where it turns, else in the
/// middle of the travel \[mm\], machine coordinates with all axes at zero.
fn first_origin(machine: &Machine, length: f64) -> Vector3<f64> {
    if machine.body(FIRST_ROTARY) == MovedBody::Part {
        return machine.axes[FIRST_ROTARY].point.coords + Vector3::z() * STANDOFF;
    }
    let mut middle = machine.home();
    for (index, axis) in machine.axes.iter().take(FIRST_ROTARY).enumerate() {
        if axis.limits.is_bounded() {
            middle[index] = axis.limits.middle();
        }
    }
    let setup = Setup::new(Vector3::zeros(), [0.0; 3], length);
    Kinematics::new(machine, &setup).forward(&middle).tip.coords
}
