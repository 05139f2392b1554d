//! A machine that passed every check, and its travel.

use super::body::MachineBody;
use super::settings::{
    AxisFormat, ControlLimits, PreferredSign, ProgramFormat, RetractPolicy, SingularPolicy,
};
use super::spec::AxisKind;
use crate::types::{AXES, AxisVector, Interval};
use nalgebra::{Point3, UnitVector3};

/// Index of the workpiece-side rotary axis in an [`AxisVector`].
pub const FIRST_ROTARY: usize = 3;
/// Index of the tool-side rotary axis in an [`AxisVector`].
pub const SECOND_ROTARY: usize = 4;

/// One axis of a checked machine; see `AxisSpec` for the meaning of each entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name in the chain, such as `B`.
    pub name: String,
    /// Linear or rotary.
    pub kind: AxisKind,
    /// Direction of positive motion at q = 0 by ISO 841, before `sense`, machine frame.
    pub dir: UnitVector3<f64>,
    /// A point of a rotary axis line at q = 0 \[mm\], machine frame; the origin for a linear axis.
    pub point: Point3<f64>,
    /// Travel \[mm or rad\]; unbounded on a cyclic axis without stated travel.
    pub limits: Interval,
    /// `true` for a rotary axis that turns without end.
    pub cyclic: bool,
    /// Largest velocity while cutting \[mm/s or rad/s\].
    pub vel: f64,
    /// Largest velocity of a rapid \[mm/s or rad/s\].
    pub rapid: f64,
    /// Largest acceleration \[mm/s² or rad/s²\].
    pub acc: f64,
    /// Largest jerk \[mm/s³ or rad/s³\].
    pub jerk: f64,
    /// +1: ISO 841; -1: reversed.
    pub sense: f64,
    /// Value at the start, and of a free axis \[mm or rad\].
    pub home: f64,
    /// Sign to prefer where two branches are equally good.
    pub prefer: Option<PreferredSign>,
    /// Format of its words in programs.
    pub output: AxisFormat,
}

/// A checked machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name of the machine.
    pub name: String,
    /// X, Y, Z, then the rotaries in chain order (workpiece side first).
    pub axes: [Axis; AXES],
    /// The chain as written: `w`, axis names and `b` in between, `t`.
    pub chain: Vec<String>,
    /// Tip to spindle at q = 0, machine frame.
    pub tool_axis: UnitVector3<f64>,
    /// Gauge point (spindle nose) at q = 0 \[mm\], machine frame.
    pub gauge: Point3<f64>,
    /// Limits of the control, as far as known.
    pub cycle: ControlLimits,
    /// Behaviour near a singular direction.
    pub singular: SingularPolicy,
    /// Retract move for unwinding.
    pub retract: RetractPolicy,
    /// Program format of the control.
    pub dialect: ProgramFormat,
    /// Bodies that must not collide.
    pub bodies: Vec<MachineBody>,
    /// Number of rotaries between the workpiece and each of X, Y, Z.
    pub(super) stage: [usize; 3],
}

/// An axis outside its travel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[error("{}", self.message())]
pub struct OutOfTravel {
    /// Name of the axis.
    pub axis: String,
    /// Its index in an [`AxisVector`].
    pub index: usize,
    /// Position it would need \[mm or rad\].
    pub value: f64,
    /// Lower end of travel.
    pub low: f64,
    /// Upper end of travel.
    pub high: f64,
    /// Distance outside; positive.
    pub excess: f64,
}

/// Distance of one axis outside its travel: an [`OutOfTravel`] without the name, which allocates nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TravelExcess {
    /// Index of the axis in an [`AxisVector`].
    pub index: usize,
    /// Position it would need \[mm or rad\].
    pub value: f64,
    /// Lower end of travel.
    pub low: f64,
    /// Upper end of travel.
    pub high: f64,
    /// Distance outside; positive.
    pub excess: f64,
}

impl Machine {
    /// Returns the index of the axis called `name`.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.axes.iter().position(|axis| axis.name == name)
    }

    /// Returns the start values of all axes \[mm, rad\].
    pub fn home(&self) -> AxisVector {
        self.vector(|axis| axis.home)
    }

    /// Collects one figure of every axis into a vector, for example `machine.vector(|axis| axis.vel)`.
    pub fn vector(&self, figure: impl Fn(&Axis) -> f64) -> AxisVector {
        // One row an axis, in the order of `axes`.
        AxisVector::from_fn(|row, _| self.axes.get(row).map_or(0.0, &figure))
    }

    /// Returns the axis farthest outside its travel at `q`; `None` if all are inside.
    ///
    /// The excess is compared as a share of the travel, so that mm and rad compare. NaN counts as outside.
    pub fn out_of_travel(&self, q: &AxisVector) -> Option<OutOfTravel> {
        self.travel_excess(q).map(|excess| excess.named(self))
    }

    /// Returns the axis of [`Machine::out_of_travel`] without its name. Allocates nothing.
    pub fn travel_excess(&self, q: &AxisVector) -> Option<TravelExcess> {
        let faults =
            self.axes.iter().zip(q.iter()).enumerate().filter_map(|(index, (axis, &value))| {
                // Written so that a NaN is not inside.
                let [low, high] = axis.limits.ends();
                let inside = low <= value && value <= high;
                let excess = if value < low { low - value } else { value - high };
                (!inside).then_some(TravelExcess { index, value, low, high, excess })
            });
        faults.max_by(|a, b| a.relative_excess().total_cmp(&b.relative_excess()))
    }
}

impl TravelExcess {
    /// Returns the excess as a share of the travel, so that mm and rad compare.
    pub(crate) fn relative_excess(&self) -> f64 {
        self.excess / (self.high - self.low)
    }

    /// Returns the excess with the name that the axis has in `machine`.
    pub fn named(self, machine: &Machine) -> OutOfTravel {
        let Self { index, value, low, high, excess } = self;
        let axis = machine.axes.get(index).map_or_else(String::new, |axis| axis.name.clone());
        OutOfTravel { axis, index, value, low, high, excess }
    }
}

impl OutOfTravel {
    /// Returns the message, in mm or deg.
    fn message(&self) -> String {
        let kind = if self.index < FIRST_ROTARY { AxisKind::Linear } else { AxisKind::Rotary };
        let [value, excess] = [self.value, self.excess].map(|number| kind.format_value(number));
        let factor = if kind == AxisKind::Linear { 1.0 } else { 1.0_f64.to_degrees() };
        let [low, high] = [self.low, self.high].map(|end| end * factor);
        format!("{} = {value} is outside its travel [{low:.4}, {high:.4}] by {excess}", self.axis)
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::ac_trunnion;
    use super::*;

    #[test]
    fn travel_names_the_worst_axis() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        assert_eq!(machine.out_of_travel(&machine.home()), None);
        let fault =
            machine.out_of_travel(&AxisVector::from([501.0, 0.0, 700.0, 99.0, 0.0])).unwrap();
        assert_eq!((fault.axis.as_str(), fault.excess.to_bits()), ("Z", 200.0_f64.to_bits()));
        assert!(machine.out_of_travel(&AxisVector::repeat(f64::NAN)).is_some());
    }
}
