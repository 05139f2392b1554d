//! A machine under its controls, or cutter locations themselves: the pose of the tool along a segment.

use super::controls::Controls;
use super::segment::{Block, Course, Segment, on_circle};
use crate::math::angle::angle_between;
use crate::types::ToolPose;
use crate::verify::error::VerifyError;

/// Carrier of the tool: a machine under its control, or the cutter locations themselves.
pub(crate) enum Mover<'a> {
    /// A machine.
    Machine(&'a Controls),
    /// Tip straight, tool axis on the great circle from location to location.
    Locations,
}

/// Quantities that bound how far a move is from a quadratic.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Swing {
    /// Sum of all turns \[rad\].
    pub(crate) turn: f64,
    /// Largest distance of the tip from what turns it \[mm\].
    pub(crate) lever: f64,
    /// Travel of the linear axes while it is turned \[mm\].
    pub(crate) travel: f64,
}

impl Mover<'_> {
    /// Returns the pose of the real tool at `t` in 0..=1.
    pub(crate) fn pose(&self, segment: &Segment, t: f64) -> Result<ToolPose, VerifyError> {
        match (self, &segment.course) {
            (_, Course::Circle { ends }) => on_circle(ends, t, segment.line),
            (Self::Machine(controls), _) => controls.of(segment.tool).pose(segment, t),
            (Self::Locations, _) => Err(VerifyError::NoMotion),
        }
    }

    /// Divides a rapid move whose axes each run at their own speed, straight from the arrival of one axis to that
    /// of the next. Returns nothing for other moves, and for cutter locations.
    pub(crate) fn dog_leg(&self, segment: &Segment) -> Vec<Segment> {
        let (Self::Machine(controls), true, false) = (self, segment.rapid, segment.is_unknown())
        else {
            return Vec::new();
        };
        let control = controls.of(segment.tool);
        let [from, to] = segment.joints;
        let change = to - from;
        // Each axis arrives after its own travel over its own speed.
        let times = change.abs().component_div(&control.rapid());
        let mut stops: Vec<f64> = times.iter().copied().filter(|time| *time > 0.0).collect();
        stops.sort_by(f64::total_cmp);
        // The path bends only where an axis arrives.
        stops.dedup();
        let at = |time: f64| {
            let share = times.map(|whole| if whole > time { time / whole } else { 1.0 });
            from + change.component_mul(&share)
        };
        let mut before = (0.0, from);
        let legs = stops.into_iter().map(|time| {
            let (start, joints) = std::mem::replace(&mut before, (time, at(time)));
            let (joints, duration) = ([joints, before.1], time - start);
            let block = Block::of_one(duration);
            Segment { joints, duration, block, course: Course::Joints, ..*segment }
        });
        let legs: Vec<Segment> = legs.collect();
        // One leg of all axes is the move itself, unless the tip was to run straight.
        if legs.len() == 1 && matches!(segment.course, Course::Joints) { Vec::new() } else { legs }
    }

    /// Returns the quantities that bound a segment's third derivatives; `None` if nothing moves.
    pub(crate) fn swing(&self, segment: &Segment) -> Option<Swing> {
        let change = segment.joints[1] - segment.joints[0];
        // Rotations through both angles turn the tool by no more than their sum.
        let turn = change[3].abs() + change[4].abs();
        match (self, &segment.course) {
            (_, Course::Circle { ends: [from, to] }) => {
                let turn = angle_between(&from.axis, &to.axis);
                Some(Swing { turn, lever: 0.0, travel: 0.0 })
            }
            (Self::Machine(controls), Course::Tip { length, .. }) => {
                let control = controls.of(segment.tool);
                Some(Swing { turn, lever: control.error_lever(*length), travel: 0.0 })
            }
            (Self::Machine(controls), Course::Joints) => {
                let control = controls.of(segment.tool);
                let travel = change.fixed_rows::<3>(0).lp_norm(1);
                Some(Swing { turn, lever: control.lever(segment) + travel, travel })
            }
            (_, Course::Rest | Course::Unknown) | (Self::Locations, _) => None,
        }
    }
}
