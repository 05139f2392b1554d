//! The kinematic chain: forward map, travel, singular directions.
//!
//! A machine is data: three linear and two rotary axes in any order between workpiece and tool,
//! with any directions and offsets. Signs are ISO 841: every axis, table or head, is the motion of
//! the tool relative to the workpiece, so that for the chain in order workpiece -> tool
//!
//! ```text
//! tip_w = M1(q1) M2(q2) ... M5(q5) tip,   axis_w likewise
//! ```
//!
//! wherever the bed sits. Frames and signs are drawn in `docs/frames.md`.

mod check;
mod describe;
mod forward;
mod picture;
mod settings;
mod spec;

pub use check::{MachineError, MachineErrors};
pub use describe::{Body, Kind, SignCheck};
pub use forward::{ChainGeometry, Kinematics, RotaryJoint, Setup};
pub use picture::picture;
pub use settings::{
    Cycle, Dialect, FeedMode, Interpolation, Modulo, Output, Prefer, Retract, RetractFrame,
    Singular,
};
pub use spec::{AxisKind, AxisSpec, MachineSpec};

use crate::types::AXES;
use crate::types::AxisVector;
use nalgebra::{Point3, UnitVector3};

/// Index of the workpiece-side rotary axis in an [`AxisVector`].
pub const FIRST_ROTARY: usize = 3;
/// Index of the tool-side rotary axis in an [`AxisVector`].
pub const SECOND_ROTARY: usize = 4;

/// One axis of a checked machine; see [`AxisSpec`] for the meaning of each entry.
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
    /// Travel `[low, high]` \[mm or rad\]; infinite on a cyclic axis without stated travel.
    pub limits: [f64; 2],
    /// Whether it turns without end.
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
    /// Which branch to take where two are equally good.
    pub prefer: Option<Prefer>,
    /// How a program writes it.
    pub output: Output,
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
    /// What the control can do, as far as known.
    pub cycle: Cycle,
    /// Behaviour near a singular direction.
    pub singular: Singular,
    /// How to unwind.
    pub retract: Retract,
    /// How programs are written.
    pub dialect: Dialect,
    /// How many of X, Y, Z stand before, between and after the two rotaries.
    stage: [usize; 3],
}

/// An axis outside its travel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", self.words())]
pub struct OutOfTravel {
    /// Name of the axis.
    pub axis: String,
    /// Its index in an [`AxisVector`].
    pub index: usize,
    /// Where it would have to be \[mm or rad\].
    pub value: f64,
    /// Lower end of travel.
    pub low: f64,
    /// Upper end of travel.
    pub high: f64,
    /// How far outside; positive.
    pub excess: f64,
}

impl Machine {
    /// Checks a machine.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with it, in the order of the specification.
    pub fn new(spec: MachineSpec) -> Result<Self, MachineErrors> {
        check::machine(spec)
    }

    /// Index of the axis called `name`.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.axes.iter().position(|axis| axis.name == name)
    }

    /// Start values of all axes \[mm, rad\].
    pub fn home(&self) -> AxisVector {
        self.vector(|axis| axis.home)
    }

    /// One figure of every axis as a vector, for example `machine.vector(|axis| axis.vel)`.
    pub fn vector(&self, figure: impl Fn(&Axis) -> f64) -> AxisVector {
        AxisVector::from_fn(|row, _| self.axes.get(row).map_or(0.0, &figure))
    }

    /// The axis farthest outside its travel at `q`, measured as a share of its travel so that mm
    /// and rad compare; `None` if all are inside. NaN counts as outside.
    pub fn out_of_travel(&self, q: &AxisVector) -> Option<OutOfTravel> {
        let faults =
            self.axes.iter().zip(q.iter()).enumerate().filter_map(|(index, (axis, &value))| {
                let [low, high] = axis.limits;
                let inside = low <= value && value <= high;
                let excess = if value < low { low - value } else { value - high };
                (!inside).then(|| OutOfTravel {
                    axis: axis.name.clone(),
                    index,
                    value,
                    low,
                    high,
                    excess,
                })
            });
        faults.max_by(|a, b| a.relative_excess().total_cmp(&b.relative_excess()))
    }
}

impl OutOfTravel {
    /// Excess as a share of the travel, so that mm and rad compare.
    pub(crate) fn relative_excess(&self) -> f64 {
        self.excess / (self.high - self.low)
    }

    /// For people: in mm or deg.
    fn words(&self) -> String {
        let kind = if self.index < FIRST_ROTARY { AxisKind::Linear } else { AxisKind::Rotary };
        let [value, excess] = [self.value, self.excess].map(|number| kind.told(number));
        let factor = if kind == AxisKind::Linear { 1.0 } else { 1.0_f64.to_degrees() };
        let [low, high] = [self.low, self.high].map(|end| end * factor);
        format!("{} = {value} is outside its travel [{low:.4}, {high:.4}] by {excess}", self.axis)
    }
}

#[cfg(test)]
pub(crate) mod samples;

#[cfg(test)]
mod tests {
    use super::samples::{ac_trunnion, axis};
    use super::*;

    #[test]
    fn all_faults_are_reported_at_once() {
        let mut spec = ac_trunnion();
        spec.axes[0].dir = [0.0; 3];
        spec.axes[1].limits = Some([1.0, -1.0]);
        spec.axes[2].vel = f64::NAN;
        spec.axes[3].point = None;
        spec.axes[4].sense = 0.5;
        spec.axes[4].limits = None;
        spec.chain = ["C", "A", "X", "X", "Y", "Q"].map(str::to_owned).to_vec();
        let keys: Vec<String> =
            Machine::new(spec).unwrap_err().iter().map(MachineError::key).collect();
        assert_eq!(
            keys,
            [
                "chain",
                "chain",
                "chain",
                "chain",
                "chain",
                "axis.Z",
                "axis.X.dir",
                "axis.Y.limits",
                "axis.Z.vel",
                "axis.C.point",
                "axis.A.sense",
                "axis.A.limits"
            ]
        );
    }

    #[test]
    fn degenerate_directions_are_named() {
        let mut spec = ac_trunnion();
        spec.axes[2].dir = [1.0, 1.0, 0.0];
        spec.axes[4].dir = [0.0, 1e-6, -1.0];
        let faults = Machine::new(spec).unwrap_err();
        assert!(matches!(faults[0], MachineError::CoplanarLinear { .. }));
        assert!(matches!(faults[1], MachineError::ParallelRotaries { .. }));
        assert!(matches!(faults[2], MachineError::SpindleParallel { .. }));
        assert_eq!(faults.len(), 3);
    }

    #[test]
    fn an_axis_needs_a_direction() {
        for axis in [1, 3, 4] {
            let mut spec = ac_trunnion();
            spec.axes[axis].dir = [0.0; 3];
            let key = format!("axis.{}.dir", spec.axes[axis].name);
            assert_eq!(Machine::new(spec).unwrap_err(), [MachineError::ZeroDirection { key }]);
        }
    }

    #[test]
    fn a_chain_needs_workpiece_and_tool() {
        let told = |drop: &str| {
            let mut spec = ac_trunnion();
            spec.chain.retain(|word| word != drop);
            let faults = Machine::new(spec).unwrap_err();
            assert_eq!(faults.len(), 1, "{faults:?}");
            faults[0].to_string()
        };
        assert!(told("w").ends_with("it must start with \"w\", the workpiece"));
        assert!(told("t").ends_with("it must end with \"t\", the tool"));
        assert!(told("b").contains("it needs \"b\", the bed"));
    }

    #[test]
    fn empty_travel_is_told_in_its_unit() {
        let mut spec = ac_trunnion();
        spec.axes[0].limits = Some([1.0, -1.0]);
        spec.axes[4].limits = Some([std::f64::consts::PI, 0.0]);
        let faults = Machine::new(spec).unwrap_err();
        let told: Vec<String> = faults.iter().map(ToString::to_string).collect();
        assert!(told[0].contains("axis X is empty: from 1.0000 mm to -1.0000 mm"), "{told:?}");
        assert!(told[1].contains("axis A is empty: from 180.0000 deg to 0.0000 deg"), "{told:?}");
    }

    #[test]
    fn two_axes_with_one_letter_are_refused() {
        let mut spec = ac_trunnion();
        spec.axes[4].output.letter = Some("C".to_owned());
        let faults = Machine::new(spec).unwrap_err();
        assert!(
            matches!(&faults[..], [MachineError::DoubleLetter { letter, .. }] if letter == "C")
        );
        let mut spec = ac_trunnion();
        spec.axes.push(axis("X", AxisKind::Linear, [1.0, 0.0, 0.0]));
        assert!(Machine::new(spec).is_err());
    }

    #[test]
    fn axes_stand_in_order_whatever_the_file_says() {
        let mut spec = ac_trunnion();
        spec.axes.reverse();
        let machine = Machine::new(spec).unwrap();
        assert_eq!(
            machine.axes.each_ref().map(|axis| axis.name.as_str()),
            ["X", "Y", "Z", "C", "A"]
        );
    }

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
