//! Out of the part, rotaries round, and back to the same place.

use super::march::{Bounds, Marched, Marcher};
use super::travel::Travel;
use super::{AxesError, RetractOptions};
use crate::machine::{FIRST_ROTARY, RetractFrame};
use crate::math::jet::{Jet, Real};
use crate::types::{AxisVector, Motion, ToolPose};
use nalgebra::{Point3, Vector3};

/// A retract as a sequence of motions.
pub(super) type Legs = Vec<(Motion, Marched)>;

/// A way along the tool axis climbs at least this much per mm of its length, as leads do: a flatter
/// one would run over the part for more than ten times the height it has to gain.
const LEAST_CLIMB: f64 = 0.1;

/// Retracts at a place of a path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Retractor<'a> {
    pub(super) marcher: &'a Marcher<'a>,
    pub(super) travel: Travel<'a>,
    pub(super) options: &'a RetractOptions,
}

impl Retractor<'_> {
    /// From the rotaries `from` at `pose` to the rotaries `to` at the same pose: up along the tool
    /// axis, away as the machine file says, rotaries round, and all the way back.
    pub(super) fn legs(
        &self,
        piece: usize,
        pose: &ToolPose,
        rotaries: [[f64; 2]; 2],
    ) -> Result<Legs, AxesError> {
        let refused = |why: &'static str| AxesError::NoRetract { piece, tip: pose.tip, why };
        let climb = pose.axis.dot(&self.options.up);
        if climb < LEAST_CLIMB {
            return Err(refused("the tool axis leads to the side, not up from the part"));
        }
        let height = self.options.plane - pose.tip.coords.dot(&self.options.up);
        let retract = &self.marcher.inverse.kinematics().machine().retract;
        let own = if retract.frame == RetractFrame::Tool { retract.to } else { 0.0 };
        let length = (height / climb).max(self.options.least).max(own);
        let near = self.options.approach.min(length);
        let tips = [0.0, near, length].map(|way| pose.tip + pose.axis.scale(way));
        let [out, back] = rotaries;
        let straight = |from: Point3<f64>, to: Point3<f64>, turns: [f64; 2]| {
            let marched = self.marcher.link([from, to], [turns, turns]);
            marched.map_err(|trouble| trouble.of(piece))
        };
        let mut legs = vec![
            (Motion::LeadOut, straight(tips[0], tips[1], out)?),
            (Motion::Link, straight(tips[1], tips[2], out)?),
        ];
        let above = ToolPose { tip: tips[2], axis: pose.axis };
        let [from, to] = [self.at(piece, &above, out)?, self.at(piece, &above, back)?];
        let over = if let Some(over) = self.over(from, to) {
            over
        } else {
            // Nothing leads farther away: the tip stays above the part while the tool turns.
            let turned = self.marcher.link([above.tip; 2], [out, back]);
            vec![turned.map_err(|trouble| trouble.of(piece))?]
        };
        legs.extend(over.into_iter().map(|leg| (Motion::Link, leg)));
        legs.push((Motion::Link, straight(tips[2], tips[1], back)?));
        legs.push((Motion::LeadIn, straight(tips[1], tips[0], back)?));
        legs.retain(|(_, marched)| !marched.nodes.is_empty());
        let mut bounds = Bounds::NONE;
        legs.iter().flat_map(|(_, leg)| leg.bounds()).for_each(|part| bounds.merge(&part));
        if self.travel.slides_inside(&bounds) {
            Ok(legs)
        } else {
            Err(refused("the way out or back leaves the travel of a linear axis"))
        }
    }

    /// Axes at a pose with given rotaries.
    fn at(
        &self,
        piece: usize,
        pose: &ToolPose,
        rotaries: [f64; 2],
    ) -> Result<AxisVector, AxesError> {
        let still = Vector3::zeros();
        let tip = [pose.tip.coords, still, still, still];
        match self.marcher.inverse.with_rotaries(&tip, rotaries.map(Jet::constant)) {
            Ok([q, ..]) => Ok(q),
            Err(source) => Err(AxesError::Inverse { piece, u: 0.0, source }),
        }
    }

    /// From one position above the part to another, the retracting axis away in between; `None` if
    /// there is no such axis, or it would come nearer to the part.
    fn over(&self, from: AxisVector, to: AxisVector) -> Option<Vec<Marched>> {
        let machine = self.marcher.inverse.kinematics().machine();
        let retract = &machine.retract;
        let axis = machine.index_of(&retract.axis).filter(|axis| *axis < FIRST_ROTARY)?;
        if retract.frame == RetractFrame::Tool {
            return None;
        }
        let [up, down] = [self.away(from, axis)?, self.away(to, axis)?];
        let mut middle = (from + to) * 0.5;
        middle[axis] = up[axis];
        let stops = if retract.first { vec![from, up, down, to] } else { vec![from, middle, to] };
        Some(stops.windows(2).map(|pair| Marched::proportional(&pair[0], &pair[1])).collect())
    }

    /// A linear axis at its retracted position; `None` if that is nearer to the part.
    fn away(&self, q: AxisVector, axis: usize) -> Option<AxisVector> {
        let kinematics = self.marcher.inverse.kinematics();
        let machine = kinematics.machine();
        let [low, high] = machine.axes.get(axis)?.limits;
        let margin = self.options.margin.min(0.5 * (high - low));
        let mut moved = q;
        moved[axis] = machine.retract.to.clamp(low + margin, high - margin);
        let [before, after] = [kinematics.forward(&q), kinematics.forward(&moved)];
        ((after.tip - before.tip).dot(&before.axis) > 0.0).then_some(moved)
    }
}
