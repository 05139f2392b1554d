//! Nodes along a course, so close that quintics between them follow it.

use super::course::{Across, Along, Course, Trial};
use super::{AxesError, AxesOptions, Deviation};
use crate::inverse::{Inverse, InverseError};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math::angle::angle_between;
use crate::math::quintic::Quintic;
use crate::types::{AXES, AxisNode, AxisVector, PoseCurve, ToolPose};
use nalgebra::Point3;

/// Share of the tolerance that deviations at checked points may use. The error of a quintic
/// between exact nodes is (t(1-t))³ to leading order; the checked points miss its top by less
/// than a tenth, and the rest is for what is not leading order.
const SHARE: f64 = 0.5;

/// Where an interval is checked, as shares of it.
const CHECKED: [f64; 5] = [0.15, 0.325, 0.5, 0.675, 0.85];

/// Intervals shorter than this share of the piece give up.
const SHORTEST: f64 = 1e-10;

/// Intervals shorter than this share of the piece may turn a rotary by any amount: on them only
/// the deviation counts. So a free axis can settle while the tool leaves the singular direction.
const SETTLING: f64 = 1e-4;

/// Parts an interval is cut into to bound its extent.
const PARTS: u32 = 8;

/// Follows courses with an inverse and tolerances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Marcher<'a> {
    pub(super) inverse: &'a Inverse,
    pub(super) options: &'a AxesOptions,
}

/// Nodes along a course.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Marched {
    pub(super) nodes: Vec<AxisNode>,
    /// How far the axes go from each node to the next.
    pub(super) bounds: Vec<Bounds>,
    pub(super) deviation: Deviation,
}

/// Lowest and highest value of every axis on some part of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds(pub(super) [[f64; 2]; AXES]);

impl Bounds {
    pub(super) const NONE: Self = Self([[f64::INFINITY, f64::NEG_INFINITY]; AXES]);

    pub(super) fn include(&mut self, q: &AxisVector) {
        for ([low, high], &value) in self.0.iter_mut().zip(q.iter()) {
            *low = low.min(value);
            *high = high.max(value);
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for ([low, high], [l, h]) in self.0.iter_mut().zip(other.0) {
            *low = low.min(l);
            *high = high.max(h);
        }
    }

    /// Control points of the quintic's parts between two nodes: it stays between the lowest and the
    /// highest.
    fn between(from: &AxisNode, to: &AxisNode) -> Self {
        let mut bounds = Self::NONE;
        let quintic = between(from, to);
        let part = (to.s - from.s) / f64::from(PARTS);
        for index in 0..PARTS {
            let x = part * f64::from(index);
            for (x, side) in [(x, part), (x + part, -part)] {
                let [q, q1, q2, _] = quintic.at(x);
                bounds.include(&q);
                bounds.include(&(q + q1 * (side / 5.0)));
                bounds.include(&(q + q1 * (side * 0.4) + q2 * (side * side / 20.0)));
            }
        }
        bounds
    }
}

/// Why a course cannot be followed, with the parameter.
pub(super) enum Trouble {
    Inverse(f64, InverseError),
    NotFollowed(f64, Deviation),
}

impl Trouble {
    /// As the error of a piece.
    pub(super) fn of(self, piece: usize) -> AxesError {
        match self {
            Self::Inverse(u, source) => AxesError::Inverse { piece, u, source },
            Self::NotFollowed(u, Deviation { tip, axis }) => {
                AxesError::NotFollowed { piece, u, tip, axis }
            }
        }
    }
}

impl<'a> Marcher<'a> {
    /// Directions this close to the singular one may be taken to be on it \[rad\]: a share of the
    /// tolerance that leaves the rest to the quintics beside it.
    pub(super) fn pole(&self) -> f64 {
        0.1 * self.options.axis_tolerance
    }

    /// A curve as a course.
    pub(super) fn along(&self, curve: &'a PoseCurve) -> Along<'a> {
        let feed_at = self.options.feed_at;
        Along { inverse: self.inverse, curve, feed_at, pole: self.pole() }
    }

    /// Nodes along a curve, starting where the rotaries of `start` are nearest.
    pub(super) fn curve(
        &self,
        curve: &'a PoseCurve,
        start: &AxisVector,
    ) -> Result<Marched, Trouble> {
        self.march(&self.along(curve), start)
    }

    /// Nodes along a link; no node if nothing moves.
    pub(super) fn link(
        &self,
        tips: [Point3<f64>; 2],
        rotaries: [[f64; 2]; 2],
    ) -> Result<Marched, Trouble> {
        let [from, to] = rotaries;
        let distance = (tips[1] - tips[0]).norm();
        let turn = (to[0] - from[0]).hypot(to[1] - from[1]);
        let length = if distance > 0.0 { distance } else { turn };
        if length <= 0.0 {
            return Ok(Marched::nothing());
        }
        let knots = [0.0, length];
        self.march(&Across { inverse: self.inverse, tips, rotaries, knots }, &AxisVector::zeros())
    }

    fn march(&self, course: &dyn Course, start: &AxisVector) -> Result<Marched, Trouble> {
        let knots = course.knots();
        let spans = knots.len().saturating_sub(1);
        let mut marched = Marched::nothing();
        let (Some(&first), Some(&last)) = (knots.first(), knots.last()) else { return Ok(marched) };
        let mut from = self.nearest(course, first, 0, start)?;
        let mut lost = vec![from.lost];
        marched.push(from.node);
        for span in 0..spans {
            let mut targets = vec![knots.get(span + 1).copied().unwrap_or(last)];
            while let Some(&to) = targets.last() {
                let next = if targets.len() == 1 { (span + 1).min(spans - 1) } else { span };
                match self.step(course, &from, (to, next), last - first)? {
                    Ok((trial, deviation)) => {
                        marched.deviation = marched.deviation.max(deviation);
                        marched.push(trial.node);
                        lost.push(trial.lost);
                        from = trial;
                        targets.pop();
                    }
                    Err(worst) if to - from.node.s <= SHORTEST * (last - first) => {
                        return Err(Trouble::NotFollowed(from.node.s, worst));
                    }
                    Err(_) => targets.push(from.node.s + 0.5 * (to - from.node.s)),
                }
            }
        }
        marched.complete(&lost);
        Ok(marched)
    }

    /// The trial nearest to `start`.
    fn nearest(
        &self,
        course: &dyn Course,
        u: f64,
        span: usize,
        start: &AxisVector,
    ) -> Result<Trial, Trouble> {
        let trials = course.trials(u, span, start).map_err(|error| Trouble::Inverse(u, error))?;
        let nearest = trials
            .into_iter()
            .min_by(|a, b| self.turn(&a.node, start).total_cmp(&self.turn(&b.node, start)));
        let nothing = InverseError::NotFinite { what: "the tool axis" };
        nearest.ok_or(Trouble::Inverse(u, nothing))
    }

    /// One step: the node at `to` on the branch that turns least and stays within tolerance, or
    /// how far the best is off.
    fn step(
        &self,
        course: &dyn Course,
        from: &Trial,
        (to, span): (f64, usize),
        whole: f64,
    ) -> Result<Result<(Trial, Deviation), Deviation>, Trouble> {
        let near = from.node.q[0];
        let mut trials =
            course.trials(to, span, &near).map_err(|error| Trouble::Inverse(to, error))?;
        trials.sort_by(|a, b| self.turn(&a.node, &near).total_cmp(&self.turn(&b.node, &near)));
        let mut least = Deviation { tip: f64::INFINITY, axis: f64::INFINITY };
        let settling = to - from.node.s <= SETTLING * whole;
        for trial in trials {
            let rotaries = (trial.node.q[0] - near).fixed_rows::<2>(FIRST_ROTARY).amax();
            if rotaries > self.options.max_rotary_step && !settling {
                continue;
            }
            let deviation = self.deviation(course, &from.node, &trial.node);
            let within = deviation.tip <= SHARE * self.options.tip_tolerance
                && deviation.axis <= SHARE * self.options.axis_tolerance;
            if within {
                return Ok(Ok((trial, deviation)));
            }
            if deviation.tip < least.tip {
                least = deviation;
            }
        }
        Ok(Err(least))
    }

    /// Weighted rotary travel between two positions \[rad\].
    fn turn(&self, node: &AxisNode, from: &AxisVector) -> f64 {
        turn(&node.q[0], from, self.options)
    }

    /// How far the quintic between two nodes is from the course, at the checked points. Infinite
    /// where there is no pose.
    fn deviation(&self, course: &dyn Course, from: &AxisNode, to: &AxisNode) -> Deviation {
        let quintic = between(from, to);
        let length = to.s - from.s;
        CHECKED.iter().fold(Deviation::default(), |worst, share| {
            let q = quintic.value(share * length);
            let ToolPose { tip, axis } = self.inverse.kinematics().forward(&q);
            let Some(wanted) = course.pose(from.s + share * length) else {
                return Deviation { tip: f64::INFINITY, axis: f64::INFINITY };
            };
            let distance = (tip - wanted.tip).norm();
            // `max` ignores NaN; a position that is not a number is not within any tolerance.
            let distance = if distance.is_nan() { f64::INFINITY } else { distance };
            worst.max(Deviation { tip: distance, axis: angle_between(&axis, &wanted.axis) })
        })
    }
}

/// Weighted rotary travel between two positions \[rad\].
pub(super) fn turn(to: &AxisVector, from: &AxisVector, options: &AxesOptions) -> f64 {
    let [first, second] = options.rotary_weights;
    first * (to[FIRST_ROTARY] - from[FIRST_ROTARY]).abs()
        + second * (to[SECOND_ROTARY] - from[SECOND_ROTARY]).abs()
}

/// The axis path between two nodes.
fn between(from: &AxisNode, to: &AxisNode) -> Quintic<AXES> {
    let jet = |q: &[AxisVector; 4]| [q[0], q[1], q[2]];
    Quintic::new(to.s - from.s, jet(&from.q), jet(&to.q))
}

impl Marched {
    pub(super) fn nothing() -> Self {
        Self { nodes: Vec::new(), bounds: Vec::new(), deviation: Deviation::default() }
    }

    /// Two nodes between which every axis moves in proportion, over the way of the slides \[mm\] or
    /// the turn of the rotaries \[rad\]; no node if nothing moves.
    ///
    /// The speed of the tip counts as that of the slides: while rotaries swing a tool that is far
    /// from the part, their own limits hold.
    pub(super) fn proportional(from: &AxisVector, to: &AxisVector) -> Self {
        let way = to - from;
        let [slides, turn] =
            [way.fixed_rows::<3>(0).norm(), way.fixed_rows::<2>(FIRST_ROTARY).norm()];
        let length = if slides > 0.0 { slides } else { turn };
        if length <= 0.0 {
            return Self::nothing();
        }
        let rate = slides / length;
        let zero = AxisVector::zeros();
        let node = |s: f64, q: &AxisVector| AxisNode {
            s,
            q: [*q, way / length, zero, zero],
            tip_rate: rate,
            feed_rate: rate,
        };
        let mut bounds = Bounds::NONE;
        bounds.include(from);
        bounds.include(to);
        let nodes = vec![node(0.0, from), node(length, to)];
        Self { nodes, bounds: vec![bounds], deviation: Deviation::default() }
    }

    /// The nodes of a piece, if it moves at all.
    pub(super) fn nodes(&self) -> Option<Vec<AxisNode>> {
        (self.nodes.len() > 1).then(|| self.nodes.clone())
    }

    fn push(&mut self, node: AxisNode) {
        if let Some(last) = self.nodes.last() {
            self.bounds.push(Bounds::between(last, &node));
        }
        self.nodes.push(node);
    }

    /// Third derivatives that are not known exactly are those of the quintic beside the node.
    fn complete(&mut self, lost: &[usize]) {
        let count = self.nodes.len();
        for (index, _) in lost.iter().enumerate().filter(|(_, lost)| **lost > 0) {
            let from = index.min(count.saturating_sub(2));
            if let (Some(&a), Some(&b)) = (self.nodes.get(from), self.nodes.get(from + 1)) {
                let [_, _, _, third] =
                    between(&a, &b).at(if index == from { 0.0 } else { b.s - a.s });
                if let Some(node) = self.nodes.get_mut(index) {
                    node.q[3] = third;
                }
            }
        }
    }
}
