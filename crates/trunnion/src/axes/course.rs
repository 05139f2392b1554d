//! What the axes have to follow: a curve, or a link between two stretches.

use super::FeedPoint;
use crate::inverse::{Branch, Inverse, InverseError};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math::angle::unwrap_near;
use crate::math::jet::{Jet, Real};
use crate::types::{AxisNode, AxisVector, PoseCurve, PoseRates, ToolPose};
use nalgebra::{Point3, Vector3};

/// A node, and how many of its highest derivatives are unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trial {
    pub(super) node: AxisNode,
    pub(super) lost: usize,
}

/// Something with exact axes at every parameter.
pub(super) trait Course {
    /// Where derivatives may jump; nodes stand there.
    fn knots(&self) -> &[f64];
    /// Exact axes at `u` seen from span `span`, rotaries unwound to `near`: one for each branch.
    fn trials(&self, u: f64, span: usize, near: &AxisVector) -> Result<Vec<Trial>, InverseError>;
    /// The pose at `u`.
    fn pose(&self, u: f64) -> Option<ToolPose>;
}

/// A curve of tip and tool axis.
#[derive(Debug)]
pub(super) struct Along<'a> {
    pub(super) inverse: &'a Inverse,
    pub(super) curve: &'a PoseCurve,
    pub(super) feed_at: FeedPoint,
    /// A direction this close to the singular one is taken to be on it \[rad\].
    pub(super) pole: f64,
}

/// Tip straight, rotaries in proportion.
#[derive(Debug)]
pub(super) struct Across<'a> {
    pub(super) inverse: &'a Inverse,
    pub(super) tips: [Point3<f64>; 2],
    pub(super) rotaries: [[f64; 2]; 2],
    /// 0 and the length.
    pub(super) knots: [f64; 2],
}

impl Along<'_> {
    /// Exact axes of one branch at a point that is not held.
    pub(super) fn on(
        &self,
        rates: &PoseRates,
        branch: Branch,
    ) -> Result<([AxisVector; 4], usize), InverseError> {
        let [start, end] = self.curve.range();
        let found = self.inverse.jets_through(rates, branch, self.pole, end - start)?;
        Ok((found.q, found.lost))
    }

    /// Axes that stand still but for the slides: the tool stays in the singular direction.
    fn held(&self, rates: &PoseRates, near: &AxisVector) -> Result<[AxisVector; 4], InverseError> {
        let second =
            rates.pose().and_then(|pose| self.inverse.second_at_pole(&pose.axis, self.pole));
        let second = second.ok_or(InverseError::NotFinite { what: "the tool axis" })?;
        let rotaries = [near[FIRST_ROTARY], unwrap_near(second, near[SECOND_ROTARY])];
        self.inverse.with_rotaries(&rates.tip, rotaries.map(Jet::constant))
    }

    fn trial(
        &self,
        u: f64,
        rates: &PoseRates,
        (mut q, lost): ([AxisVector; 4], usize),
        near: &AxisVector,
    ) -> Trial {
        for axis in [FIRST_ROTARY, SECOND_ROTARY] {
            q[0][axis] = unwrap_near(q[0][axis], near[axis]);
        }
        let tip_rate = rates.tip[1].norm();
        let feed_rate = match self.feed_at {
            FeedPoint::Tip => tip_rate,
            FeedPoint::Contact => rates.contact[1].norm(),
        };
        Trial { node: AxisNode { s: u, q, tip_rate, feed_rate }, lost }
    }
}

impl Course for Along<'_> {
    fn knots(&self) -> &[f64] {
        &self.curve.knots
    }

    fn trials(&self, u: f64, span: usize, near: &AxisVector) -> Result<Vec<Trial>, InverseError> {
        let rates = self.curve.rates_in(span, u);
        let mut found = Vec::with_capacity(Branch::BOTH.len());
        for branch in Branch::BOTH {
            match self.on(&rates, branch) {
                Ok(axes) => found.push(self.trial(u, &rates, axes, near)),
                Err(InverseError::Singular { .. }) => {
                    found.push(self.trial(u, &rates, (self.held(&rates, near)?, 0), near));
                    return Ok(found);
                }
                Err(error) => return Err(error),
            }
        }
        // Passing straight through is a choice; where it leaves the tolerance, what the pose says
        // counts. (On the pole itself it says nothing.)
        if found.iter().any(|trial| trial.lost > 0) {
            for branch in Branch::BOTH {
                if let Ok(q) = self.inverse.jets(&rates, branch) {
                    found.push(self.trial(u, &rates, (q, 0), near));
                }
            }
        }
        Ok(found)
    }

    fn pose(&self, u: f64) -> Option<ToolPose> {
        self.curve.pose(u)
    }
}

impl Across<'_> {
    fn length(&self) -> f64 {
        self.knots[1]
    }

    fn rotaries(&self, u: f64) -> [Jet; 2] {
        let [from, to] = self.rotaries;
        [0, 1].map(|axis| {
            let slope = (to[axis] - from[axis]) / self.length();
            Jet { c: [from[axis] + slope * u, slope, 0.0, 0.0] }
        })
    }
}

impl Course for Across<'_> {
    fn knots(&self) -> &[f64] {
        &self.knots
    }

    fn trials(&self, u: f64, _: usize, _: &AxisVector) -> Result<Vec<Trial>, InverseError> {
        let [from, to] = self.tips;
        let slope = (to - from) / self.length();
        let tip = [from.coords + slope * u, slope, Vector3::zeros(), Vector3::zeros()];
        let q = self.inverse.with_rotaries(&tip, self.rotaries(u))?;
        let rate = slope.norm();
        let node = AxisNode { s: u, q, tip_rate: rate, feed_rate: rate };
        Ok(vec![Trial { node, lost: 0 }])
    }

    fn pose(&self, u: f64) -> Option<ToolPose> {
        let [from, to] = self.tips;
        let mut q = AxisVector::zeros();
        for (axis, jet) in [FIRST_ROTARY, SECOND_ROTARY].into_iter().zip(self.rotaries(u)) {
            q[axis] = jet.value();
        }
        let axis = self.inverse.kinematics().forward(&q).axis;
        Some(ToolPose { tip: from + (to - from) * (u / self.length()), axis })
    }
}
