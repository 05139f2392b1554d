//! Motions that the axes follow: a curve, or a link between two segments.

use super::options::FeedPoint;
use crate::inverse::{AxisJets, Branch, Inverse, InverseError};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math::angle::unwrap_near;
use crate::math::jet::{Jet, Real};
use crate::types::Interval;
use crate::types::{AxisNode, AxisVector, PoseCurve, PoseRates, ToolPose};
use nalgebra::{Point3, Vector3};

/// Exact axes at a parameter, whole turns left open: shared by all branches along a motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Evaluation {
    pub(super) u: f64,
    /// Speed of the tip and of the feed point, per unit of the parameter.
    speeds: [f64; 2],
    /// Each branch.
    pub(super) both: Option<[AxisJets; 2]>,
    /// Further solutions from which the motion may go on.
    pub(super) more: Vec<AxisJets>,
    /// Part of the tool axis square to the singular direction.
    pub(super) across: [f64; 2],
    /// `true` if the first rotary is free and keeps its position: the tool stays in the
    /// singular direction.
    pub(super) held: bool,
    /// `true` if the rotaries are prescribed, whole turns included.
    prescribed: bool,
}

/// Motion with exact axes at every parameter.
pub(super) trait PathMotion {
    /// Returns the parameters at which derivatives may jump; each gets a node.
    fn knots(&self) -> &[f64];
    /// Computes the exact axes at `u` seen from span `span`; a free rotary is held where `near` has it.
    fn evaluate(
        &self,
        u: f64,
        span: usize,
        near: &AxisVector,
        evaluation: &mut Evaluation,
    ) -> Result<(), InverseError>;
    /// Returns the pose at `u` in span `span`.
    fn pose(&self, u: f64, span: usize) -> Option<ToolPose>;
}

impl Evaluation {
    /// Creates an evaluation at no parameter.
    pub(super) fn unset() -> Self {
        let [u, speeds, across] = [f64::NAN, 0.0, 0.0];
        let (both, more) = (None, Vec::new());
        Self {
            u,
            speeds: [speeds; 2],
            both,
            more,
            across: [across; 2],
            held: false,
            prescribed: false,
        }
    }

    /// Clears the evaluation for another parameter.
    fn begin(&mut self, u: f64, speeds: [f64; 2]) {
        (self.u, self.speeds, self.both) = (u, speeds, None);
        self.more.clear();
        (self.held, self.prescribed) = (false, false);
    }

    /// Returns all solutions.
    pub(super) fn solutions(&self) -> impl Iterator<Item = &AxisJets> {
        self.both.iter().flatten().chain(&self.more)
    }

    /// Returns the axes of a solution, rotaries unwound to `near`.
    pub(super) fn unwound(&self, solution: &AxisJets, near: &AxisVector) -> AxisVector {
        let mut q = solution.q[0];
        if self.prescribed {
            return q;
        }
        for axis in [FIRST_ROTARY, SECOND_ROTARY] {
            q[axis] = unwrap_near(q[axis], near[axis]);
        }
        q
    }

    /// Returns the node of a solution, rotaries unwound to `near`.
    pub(super) fn node(&self, solution: &AxisJets, near: &AxisVector) -> AxisNode {
        let [_, q1, q2, q3] = solution.q;
        let [tip_rate, feed_rate] = self.speeds;
        let q = [self.unwound(solution, near), q1, q2, q3];
        AxisNode { s: self.u, q, tip_rate, feed_rate }
    }
}

/// A curve of tip and tool axis.
#[derive(Debug)]
pub(super) struct CurveMotion<'a> {
    pub(super) inverse: &'a Inverse,
    pub(super) curve: &'a PoseCurve,
    pub(super) feed_at: FeedPoint,
    /// A direction this close to the singular one is taken to be on it \[rad\].
    pub(super) pole: f64,
}

/// Link: the tip moves straight, the rotaries in proportion.
#[derive(Debug)]
pub(super) struct LinkMotion<'a> {
    pub(super) inverse: &'a Inverse,
    pub(super) tips: [Point3<f64>; 2],
    pub(super) rotaries: [[f64; 2]; 2],
    /// 0 and the length.
    pub(super) knots: [f64; 2],
}

impl CurveMotion<'_> {
    /// Returns the exact axes of both branches at a point where the first rotary is not free.
    pub(super) fn both(&self, rates: &PoseRates) -> Result<[AxisJets; 2], InverseError> {
        // Derivatives by the parameter are compared with rounding over the length of the curve.
        let Interval { low: start, high: end } = self.curve.range();
        self.inverse.both_jets_through(rates, self.pole, end - start)
    }

    /// Returns the axes while the tool stays in the singular direction: only the linear axes move.
    fn held(&self, rates: &PoseRates, near: &AxisVector) -> Result<AxisJets, InverseError> {
        let second =
            rates.pose().and_then(|pose| self.inverse.second_at_pole(&pose.axis, self.pole));
        let second = second.ok_or(InverseError::NotFinite { what: "the tool axis" })?;
        let rotaries = [near[FIRST_ROTARY], unwrap_near(second, near[SECOND_ROTARY])];
        let q = self.inverse.with_rotaries(&rates.tip, rotaries.map(Jet::constant))?;
        Ok(AxisJets { q, lost: 0 })
    }
}

impl PathMotion for CurveMotion<'_> {
    fn knots(&self) -> &[f64] {
        &self.curve.knots
    }

    fn evaluate(
        &self,
        u: f64,
        span: usize,
        near: &AxisVector,
        evaluation: &mut Evaluation,
    ) -> Result<(), InverseError> {
        let rates = self.curve.rates_in(span, u);
        // Speed of the tip and of the feed point per unit of the parameter.
        let tip = rates.tip[1].norm();
        let feed = match self.feed_at {
            FeedPoint::Tip => tip,
            FeedPoint::Contact => rates.contact[1].norm(),
        };
        evaluation.begin(u, [tip, feed]);
        evaluation.across = self.inverse.across(&rates.axis[0]);
        match self.both(&rates) {
            Ok(both) => {
                // Passing straight through is a choice; where it leaves the tolerance, the solutions of
                // the pose itself count. (On the pole the pose has none.)
                if both.iter().any(|jets| jets.lost > 0) {
                    let beside = Branch::BOTH.map(|branch| self.inverse.jets(&rates, branch));
                    evaluation
                        .more
                        .extend(beside.into_iter().flatten().map(|q| AxisJets { q, lost: 0 }));
                }
                evaluation.both = Some(both);
            }
            Err(InverseError::Singular { .. }) => {
                evaluation.more.push(self.held(&rates, near)?);
                evaluation.held = true;
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }

    fn pose(&self, u: f64, span: usize) -> Option<ToolPose> {
        self.curve.pose_in(span, u)
    }
}

impl LinkMotion<'_> {
    fn length(&self) -> f64 {
        self.knots[1]
    }

    fn rotaries(&self, u: f64) -> [Jet; 2] {
        // Linear in u: the jets have no second and third derivative.
        let [from, to] = self.rotaries;
        [0, 1].map(|axis| {
            let slope = (to[axis] - from[axis]) / self.length();
            Jet { c: [from[axis] + slope * u, slope, 0.0, 0.0] }
        })
    }
}

impl PathMotion for LinkMotion<'_> {
    fn knots(&self) -> &[f64] {
        &self.knots
    }

    fn evaluate(
        &self,
        u: f64,
        _: usize,
        _: &AxisVector,
        evaluation: &mut Evaluation,
    ) -> Result<(), InverseError> {
        let [from, to] = self.tips;
        // Over the length of the link the tip moves at 1 mm per mm, or rests while the rotaries turn.
        let slope = (to - from) / self.length();
        let tip = [from.coords + slope * u, slope, Vector3::zeros(), Vector3::zeros()];
        let q = self.inverse.with_rotaries(&tip, self.rotaries(u))?;
        let rate = slope.norm();
        evaluation.begin(u, [rate, rate]);
        evaluation.more.push(AxisJets { q, lost: 0 });
        evaluation.prescribed = true;
        Ok(())
    }

    fn pose(&self, u: f64, _: usize) -> Option<ToolPose> {
        // The tool axis depends on the rotaries alone, so that the slides may stay at zero.
        let [from, to] = self.tips;
        let mut q = AxisVector::zeros();
        for (axis, jet) in [FIRST_ROTARY, SECOND_ROTARY].into_iter().zip(self.rotaries(u)) {
            q[axis] = jet.value();
        }
        let axis = self.inverse.kinematics().forward(&q).axis;
        Some(ToolPose { tip: from + (to - from) * (u / self.length()), axis })
    }
}
