//! Branch and turn inside travel: a position that continues the one before.

use super::refusal::PoseRefusal;
use super::solve::{Branch, Inverse, InverseError, InverseSolutions, unwound};
use crate::machine::{Axis, FIRST_ROTARY, Machine, PreferredSign, SECOND_ROTARY, TravelExcess};
use crate::math::angle::unwrap_near;
use crate::types::{AxisVector, PoseRates, ToolPose};
use std::f64::consts::{PI, TAU};

/// Rotary travels closer than this \[rad\] are equal: a sum of 10^6 moves of up to a turn, each
/// rounded to half an ulp of 2π.
pub(crate) const TRAVEL_TIE: f64 = 1e-9;

/// Error of forward after inverse \[mm, rad\] (`tests/kinematics.rs`): a linear or rotary axis outside
/// its travel by no more than this counts as at its end.
const ACCURACY: [f64; 2] = [1e-9, 1e-12];

/// An axis position inside travel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ContinuedPosition {
    /// Axis position, rotaries unwound.
    pub q: AxisVector,
    /// Its branch; `None` at a singular pose, where both branches are one.
    pub branch: Option<Branch>,
}

impl Inverse {
    /// Returns a position like [`Inverse::near`], but inside travel: the branch and whole turns with the least rotary
    /// travel from `near`; where two are equal, the one an axis prefers.
    ///
    /// # Errors
    ///
    /// As [`Inverse::solutions`], and [`InverseError::OutOfTravel`] with the axis that is outside
    /// by least, as a share of its travel, if no branch is inside.
    pub fn continued(
        &self,
        pose: &ToolPose,
        near: &AxisVector,
    ) -> Result<ContinuedPosition, InverseError> {
        self.continued_or_refused(pose, near).map_err(|refusal| self.named(refusal))
    }

    /// Returns the position of [`Inverse::continued`]. Allocates nothing, also where it refuses the pose.
    ///
    /// # Errors
    ///
    /// As [`Inverse::continued`], without the names of the axes.
    pub fn continued_or_refused(
        &self,
        pose: &ToolPose,
        near: &AxisVector,
    ) -> Result<ContinuedPosition, PoseRefusal> {
        if let Some(found) = self.plainly(pose, near)? {
            return Ok(found);
        }
        let mut choice = NearestChoice::new(self.kinematics().machine(), near);
        match self.every(pose)? {
            InverseSolutions::Regular([plus, minus]) => {
                choice.offer(plus, Some(Branch::Plus));
                choice.offer(minus, Some(Branch::Minus));
            }
            InverseSolutions::Singular(_) => choice.offer(self.nearest(pose, near)?, None),
        }
        choice.made()
    }

    /// Returns the position if it needs no choice: the nearest branch on the nearest turn is inside travel,
    /// and nothing else is as near.
    #[inline]
    fn plainly(
        &self,
        pose: &ToolPose,
        near: &AxisVector,
    ) -> Result<Option<ContinuedPosition>, PoseRefusal> {
        let Some([plus, minus]) = self.regular(pose, near)? else { return Ok(None) };
        let (way, other, branch) = if plus.travel <= minus.travel {
            (plus, minus, Branch::Plus)
        } else {
            (minus, plus, Branch::Minus)
        };
        // Neither another branch nor another turn is as near: half a turn in either direction would be.
        let unique = other.travel - way.travel > TRAVEL_TIE && PI - way.longest > TRAVEL_TIE;
        let q = unwound(self.slide(pose, &way.turns)?, near);
        let inside = q.iter().zip(&self.kinematics().machine().axes).all(|(&value, axis)| {
            let [low, high] = axis.limits.ends();
            low <= value && value <= high
        });
        Ok((unique && inside).then_some(ContinuedPosition { q, branch: Some(branch) }))
    }

    /// Returns the position of [`Inverse::continued`] alone.
    ///
    /// # Errors
    ///
    /// As [`Inverse::continued`].
    pub fn near_inside(
        &self,
        pose: &ToolPose,
        near: &AxisVector,
    ) -> Result<AxisVector, InverseError> {
        self.continued(pose, near).map(|found| found.q)
    }

    /// Returns the position of [`Inverse::continued`] and its first three derivatives along a path.
    ///
    /// # Errors
    ///
    /// As [`Inverse::continued`] and [`Inverse::jets`].
    pub fn jets_continued(
        &self,
        rates: &PoseRates,
        near: &AxisVector,
    ) -> Result<[AxisVector; 4], InverseError> {
        let pose = rates.pose().ok_or(InverseError::NotFinite { what: "the tool axis" })?;
        let ContinuedPosition { q, branch } = self.continued(&pose, near)?;
        // At a singular pose both branches report that there are no derivatives.
        let [_, first, second, third] = self.jets(rates, branch.unwrap_or(Branch::Plus))?;
        Ok([q, first, second, third])
    }
}

/// Best of the solutions offered so far.
struct NearestChoice<'m> {
    machine: &'m Machine,
    near: &'m AxisVector,
    best: Option<(f64, ContinuedPosition)>,
    fault: Option<TravelExcess>,
}

impl<'m> NearestChoice<'m> {
    fn new(machine: &'m Machine, near: &'m AxisVector) -> Self {
        Self { machine, near, best: None, fault: None }
    }

    /// Offers a solution on all turns that can be nearest.
    fn offer(&mut self, q: AxisVector, branch: Option<Branch>) {
        for first in self.turns(&q, FIRST_ROTARY) {
            for second in self.turns(&q, SECOND_ROTARY) {
                let mut q = q;
                [q[FIRST_ROTARY], q[SECOND_ROTARY]] = [first, second];
                self.weigh(q, branch);
            }
        }
    }

    /// Returns the nearest turn inside travel and its neighbours, which can be as near; where no turn is
    /// inside, the one outside by least.
    fn turns(&self, q: &AxisVector, axis: usize) -> impl Iterator<Item = f64> + use<> {
        // The nearest turn has a neighbour that is as near if it is half a turn away.
        let [value, near] = [q[axis], self.near[axis]];
        let [low, high] = self.machine.axes.get(axis).map_or([0.0; 2], |axis| axis.limits.ends());
        let [_, slack] = ACCURACY;
        // Whole turns that keep the axis inside its travel.
        let [first, last] =
            [((low - slack - value) / TAU).ceil(), ((high + slack - value) / TAU).floor()];
        let inside = first <= last;
        let nearest = if inside {
            ((near - value) / TAU).round().clamp(first, last)
        } else {
            (unwrap_near(value, 0.5 * (low + high)) - value) / TAU
        };
        let others = [nearest - 1.0, nearest + 1.0]
            .into_iter()
            .filter(move |turn| inside && (first..=last).contains(turn));
        std::iter::once(nearest).chain(others).map(move |turn| value + TAU * turn)
    }

    fn weigh(&mut self, mut q: AxisVector, branch: Option<Branch>) {
        at_ends(&mut q, self.machine);
        // Positions outside are kept for the error: the one outside by least, as a share of its travel.
        if let Some(outside) = self.machine.travel_excess(&q) {
            let nearer = |worst: &TravelExcess| outside.relative_excess() < worst.relative_excess();
            if self.fault.as_ref().is_none_or(nearer) {
                self.fault = Some(outside);
            }
            return;
        }
        // Least travel; of equal ones the fewest axes on the side that they do not prefer.
        let travel = (q - self.near).fixed_rows::<2>(FIRST_ROTARY).abs().sum();
        let better = self.best.as_ref().is_none_or(|(least, chosen)| {
            travel < least - TRAVEL_TIE
                || (travel <= least + TRAVEL_TIE
                    && disliked(&q, self.machine) < disliked(&chosen.q, self.machine))
        });
        if better {
            self.best = Some((travel, ContinuedPosition { q, branch }));
        }
    }

    /// Returns the best position, or the error of the one outside by least.
    fn made(self) -> Result<ContinuedPosition, PoseRefusal> {
        match (self.best, self.fault) {
            (Some((_, found)), _) => Ok(found),
            (None, Some(fault)) => Err(PoseRefusal::OutOfTravel(fault)),
            (None, None) => Err(PoseRefusal::NotFinite { what: "the pose" }),
        }
    }
}

/// Clamps axes that are outside their travel by rounding to its end.
fn at_ends(q: &mut AxisVector, machine: &Machine) {
    for (index, (value, axis)) in q.iter_mut().zip(&machine.axes).enumerate() {
        let slack = if index < FIRST_ROTARY { ACCURACY[0] } else { ACCURACY[1] };
        let [low, high] = axis.limits.ends();
        let end = value.clamp(low, high);
        if (*value - end).abs() <= slack {
            *value = end;
        }
    }
}

/// Counts the axes on the side that they do not prefer.
fn disliked(q: &AxisVector, machine: &Machine) -> usize {
    let wrong = |(axis, &value): (&Axis, &f64)| match axis.prefer {
        Some(PreferredSign::Positive) => value < 0.0,
        Some(PreferredSign::Negative) => value >= 0.0,
        None => false,
    };
    machine.axes.iter().zip(q.iter()).filter(|pair| wrong(*pair)).count()
}
