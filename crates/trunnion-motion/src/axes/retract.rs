//! Retracts: out of the part, unwind the rotaries, and back to the same pose.

use super::axis_bounds::AxisBounds;
use super::error::AxesError;
use super::follower::{AxisTrack, PathFollower};
use super::options::RetractOptions;
use super::travel::TravelLimits;
use crate::machine::{FIRST_ROTARY, RetractFrame};
use crate::math::jet::{Jet, Real};
use crate::types::{AxisVector, Motion, ToolPose};
use nalgebra::{Point3, Vector3};

/// A retract as a sequence of motions.
pub(super) type RetractLegs = Vec<(Motion, AxisTrack)>;

/// One motion of a retract.
#[derive(Debug, Clone, Copy)]
enum RetractStep {
    /// The tip straight, the rotaries at rest.
    Straight([Point3<f64>; 2], [f64; 2]),
    /// The tip at rest, the rotaries from one position to another.
    Turn(Point3<f64>, [[f64; 2]; 2]),
    /// All axes in proportion.
    Proportional([AxisVector; 2]),
}

/// Least height gained per mm of a retract along the tool axis, as for leads: a flatter one would run over
/// the part for more than ten times the height it has to gain.
const LEAST_CLIMB: f64 = 0.1;

/// Retracts at a point of a path.
#[derive(Debug, Clone, Copy)]
pub(super) struct RetractPlanner<'a> {
    pub(super) follower: &'a PathFollower<'a>,
    pub(super) travel: TravelLimits<'a>,
    pub(super) options: &'a RetractOptions,
}

impl RetractPlanner<'_> {
    /// Plans a retract between two positions of the rotaries at one pose: up along the tool axis, away as in
    /// the machine file, rotaries turned, and back the same way.
    pub(super) fn legs(
        &self,
        piece: usize,
        pose: &ToolPose,
        rotaries: [[f64; 2]; 2],
    ) -> Result<RetractLegs, AxesError> {
        let steps = self.steps(piece, pose, rotaries)?;
        let legs = steps.into_iter().map(|(motion, step)| Ok((motion, self.track(piece, step)?)));
        let mut legs = legs.collect::<Result<RetractLegs, AxesError>>()?;
        legs.retain(|(_, track)| !track.nodes.is_empty());
        Ok(legs)
    }

    /// Plans the motions of a retract; an error if they leave travel.
    fn steps(
        &self,
        piece: usize,
        pose: &ToolPose,
        rotaries: [[f64; 2]; 2],
    ) -> Result<Vec<(Motion, RetractStep)>, AxesError> {
        let refused = |why: &'static str| AxesError::NoRetract { piece, tip: pose.tip, why };
        // Height gained per mm along the tool axis.
        let climb = pose.axis.dot(&self.options.up);
        if climb < LEAST_CLIMB {
            return Err(refused("the tool axis leads to the side, not up from the part"));
        }
        let height = self.options.plane - pose.tip.coords.dot(&self.options.up);
        let retract = &self.follower.inverse.kinematics().machine().retract;
        let own = if retract.frame == RetractFrame::Tool { retract.to } else { 0.0 };
        // Far enough for the retract plane, the least distance, and the machine's own policy.
        let length = (height / climb).max(self.options.least).max(own);
        let near = self.options.approach.min(length);
        let tips = [0.0, near, length].map(|way| pose.tip + pose.axis.scale(way));
        // Out and back with the rotaries at rest, so that the tool leaves along its own axis both times.
        let [out, back] = rotaries;
        let [from, to] = [self.at(piece, tips[2], out)?, self.at(piece, tips[2], back)?];
        // If no axis leads farther away, the tip stays above the part while the tool turns.
        let turned = || vec![RetractStep::Turn(tips[2], [out, back])];
        let over = self.over(from, to).unwrap_or_else(turned);
        let mut steps = vec![
            (Motion::LeadOut, RetractStep::Straight([tips[0], tips[1]], out)),
            (Motion::Link, RetractStep::Straight([tips[1], tips[2]], out)),
        ];
        steps.extend(over.into_iter().map(|step| (Motion::Link, step)));
        steps.push((Motion::Link, RetractStep::Straight([tips[2], tips[1]], back)));
        steps.push((Motion::LeadIn, RetractStep::Straight([tips[1], tips[0]], back)));
        // The rotaries go between two positions inside travel: only the linear axes can leave it.
        let mut bounds = AxisBounds::NONE;
        for (_, step) in &steps {
            self.include(piece, *step, &mut bounds)?;
        }
        if self.travel.slides_inside(&bounds) {
            Ok(steps)
        } else {
            Err(refused("the retract or the return leaves the travel of a linear axis"))
        }
    }

    /// Checks that a retract is possible: like [`RetractPlanner::legs`] without the nodes.
    pub(super) fn check(
        &self,
        piece: usize,
        pose: &ToolPose,
        rotaries: [[f64; 2]; 2],
    ) -> Result<(), AxesError> {
        self.steps(piece, pose, rotaries).map(|_| ())
    }

    /// Follows one motion with the axes.
    fn track(&self, piece: usize, step: RetractStep) -> Result<AxisTrack, AxesError> {
        let link = match step {
            RetractStep::Straight(tips, turns) => self.follower.link(tips, [turns, turns]),
            RetractStep::Turn(tip, turns) => self.follower.link([tip; 2], turns),
            RetractStep::Proportional([from, to]) => Ok(AxisTrack::proportional(&from, &to)),
        };
        link.map_err(|trouble| trouble.of(piece))
    }

    /// Includes the extent of the axes over a motion.
    fn include(
        &self,
        piece: usize,
        step: RetractStep,
        bounds: &mut AxisBounds,
    ) -> Result<(), AxesError> {
        match step {
            // With rotaries at rest the slides are affine in the tip: the ends are the extremes.
            RetractStep::Straight(tips, turns) => {
                for tip in tips {
                    bounds.include(&self.at(piece, tip, turns)?);
                }
            }
            RetractStep::Turn(..) => {
                self.track(piece, step)?.bounds().for_each(|part| bounds.merge(&part));
            }
            RetractStep::Proportional(ends) => ends.iter().for_each(|q| bounds.include(q)),
        }
        Ok(())
    }

    /// Returns the axes at a tip with given rotaries.
    fn at(
        &self,
        piece: usize,
        tip: Point3<f64>,
        rotaries: [f64; 2],
    ) -> Result<AxisVector, AxesError> {
        let still = Vector3::zeros();
        let tip = [tip.coords, still, still, still];
        match self.follower.inverse.with_rotaries(&tip, rotaries.map(Jet::constant)) {
            Ok([q, ..]) => Ok(q),
            Err(source) => Err(AxesError::Inverse { piece, u: 0.0, source }),
        }
    }

    /// Plans the motions between two positions above the part, the retracting axis away in between; `None` if
    /// there is no such axis, or it would come nearer to the part.
    fn over(&self, from: AxisVector, to: AxisVector) -> Option<Vec<RetractStep>> {
        let machine = self.follower.inverse.kinematics().machine();
        let retract = &machine.retract;
        let axis = machine.index_of(&retract.axis).filter(|axis| *axis < FIRST_ROTARY)?;
        if retract.frame == RetractFrame::Tool {
            return None;
        }
        let [up, down] = [self.away(from, axis)?, self.away(to, axis)?];
        // Retract first and then turn, or both at once with the axis away in the middle.
        let mut middle = (from + to) * 0.5;
        middle[axis] = up[axis];
        let stops = if retract.first { vec![from, up, down, to] } else { vec![from, middle, to] };
        Some(stops.windows(2).map(|pair| RetractStep::Proportional([pair[0], pair[1]])).collect())
    }

    /// Moves a linear axis to its retracted position; `None` if that is nearer to the part.
    fn away(&self, q: AxisVector, axis: usize) -> Option<AxisVector> {
        let kinematics = self.follower.inverse.kinematics();
        let machine = kinematics.machine();
        let [low, high] = machine.axes.get(axis)?.limits.ends();
        let margin = self.options.margin.min(0.5 * (high - low));
        let mut moved = q;
        moved[axis] = machine.retract.to.clamp(low + margin, high - margin);
        // Away from the part is along the tool axis, from the tip to the spindle.
        let [before, after] = [kinematics.forward(&q), kinematics.forward(&moved)];
        ((after.tip - before.tip).dot(&before.axis) > 0.0).then_some(moved)
    }
}
