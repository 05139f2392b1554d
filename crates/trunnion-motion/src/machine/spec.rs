//! A machine as plain data, before it is checked.

use super::body::MachineBody;
use super::settings::{
    AxisFormat, ControlLimits, PreferredSign, ProgramFormat, RetractPolicy, SingularPolicy,
};
use crate::types::Interval;
use std::f64::consts::{PI, TAU};

/// Kind of motion of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AxisKind {
    /// Along a direction \[mm\].
    Linear,
    /// About a line \[rad\].
    Rotary,
}

impl AxisKind {
    /// Formats a position or distance \[mm or rad\] in mm or degrees.
    pub fn format_value(self, value: f64) -> String {
        match self {
            Self::Linear => format!("{} mm", decimals(value)),
            Self::Rotary => format!("{} deg", decimals(value.to_degrees())),
        }
    }
}

/// One axis as written in a machine file, in mm, rad, s.
///
/// Begin with [`AxisSpec::linear`] or [`AxisSpec::rotary`] and change the rest by struct update.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisSpec {
    /// Name, as in the chain.
    pub name: String,
    /// Linear or rotary.
    pub kind: AxisKind,
    /// Direction at q = 0, machine frame; any length but zero.
    pub dir: [f64; 3],
    /// Any point of the axis line at q = 0 \[mm\]; needed on a rotary axis.
    pub point: Option<[f64; 3]>,
    /// Travel \[mm or rad\]; may be left out on a cyclic axis only.
    pub limits: Option<Interval>,
    /// Period of an axis that turns without end \[rad\]: one whole turn.
    pub cyclic: Option<f64>,
    /// Largest velocity while cutting \[mm/s or rad/s\].
    pub vel: f64,
    /// Largest velocity of a rapid; `vel` if left out.
    pub rapid: Option<f64>,
    /// Largest acceleration \[mm/s² or rad/s²\].
    pub acc: f64,
    /// Largest jerk \[mm/s³ or rad/s³\].
    pub jerk: f64,
    /// +1 for ISO 841, -1 for the reverse.
    pub sense: f64,
    /// Start value, and value of a free axis \[mm or rad\]. If left out: 0, or the nearest end of
    /// travel where 0 is outside.
    pub home: Option<f64>,
    /// Sign to prefer where two branches are equally good.
    pub prefer: Option<PreferredSign>,
    /// Format of its words in programs.
    pub output: AxisFormat,
}

impl AxisSpec {
    /// Creates a linear axis along `dir`.
    ///
    /// The preset limits are generous: 10 m of travel either way, 500 mm/s, 5 m/s² and 50 m/s³. Replace
    /// them by struct update.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_motion::{machine::AxisSpec, types::Interval};
    ///
    /// let x = AxisSpec::linear("X", [1.0, 0.0, 0.0]);
    /// let short = AxisSpec { limits: Some(Interval::new(-250.0, 250.0)), vel: 300.0, ..x };
    /// assert_eq!((short.vel, short.acc), (300.0, 5_000.0));
    /// ```
    pub fn linear(name: &str, dir: [f64; 3]) -> Self {
        Self {
            name: name.to_owned(),
            kind: AxisKind::Linear,
            dir,
            point: None,
            limits: Some(Interval::new(-10_000.0, 10_000.0)),
            cyclic: None,
            vel: 500.0,
            rapid: None,
            acc: 5_000.0,
            jerk: 50_000.0,
            sense: 1.0,
            home: None,
            prefer: None,
            output: AxisFormat::STANDARD,
        }
    }

    /// Creates a rotary axis about the line through `point` \[mm\] along `dir`.
    ///
    /// It turns without end. The other preset limits are 30 rpm, 20 rad/s² and 200 rad/s³. Replace them by
    /// struct update; a limited axis also needs `cyclic: None`.
    pub fn rotary(name: &str, dir: [f64; 3], point: [f64; 3]) -> Self {
        Self {
            kind: AxisKind::Rotary,
            point: Some(point),
            limits: None,
            cyclic: Some(TAU),
            // 30 rpm.
            vel: PI,
            acc: 20.0,
            jerk: 200.0,
            ..Self::linear(name, dir)
        }
    }
}

/// A machine as written in a machine file, in mm, rad, s.
///
/// Begin with [`MachineSpec::new`] and change the rest by struct update.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineSpec {
    /// Name of the machine.
    pub name: String,
    /// From the workpiece `w` over the bed `b` to the tool `t`, with five axis names in between.
    pub chain: Vec<String>,
    /// Tip to spindle at q = 0, machine frame; any length but zero.
    pub tool_axis: [f64; 3],
    /// Gauge point (spindle nose) at q = 0 \[mm\], machine frame.
    pub gauge: [f64; 3],
    /// All axes, in any order.
    pub axes: Vec<AxisSpec>,
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
}

impl MachineSpec {
    /// Creates a machine from its chain, from `w` over `b` to `t`, and its axes.
    ///
    /// Presets: the tool points along Z with its gauge point at the machine origin, the control states no limits,
    /// singular directions and retracts are those of machine files, programs are for `LinuxCNC`, and there are no bodies.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_motion::machine::{AxisSpec, Machine, MachineSpec};
    ///
    /// let linear = |name, dir| AxisSpec::linear(name, dir);
    /// let [a, c] = [("A", [1.0, 0.0, 0.0]), ("C", [0.0, 0.0, 1.0])]
    ///     .map(|(name, dir)| AxisSpec::rotary(name, dir, [0.0; 3]));
    /// let [x, y, z] = [("X", [1.0, 0.0, 0.0]), ("Y", [0.0, 1.0, 0.0]), ("Z", [0.0, 0.0, 1.0])]
    ///     .map(|(name, dir)| linear(name, dir));
    /// let chain = ["w", "C", "A", "b", "X", "Y", "Z", "t"];
    /// let spec = MachineSpec::new("trunnion table", &chain, vec![x, y, z, a, c]);
    /// // The spindle nose is 80 mm above the origin of the machine at home.
    /// let machine = Machine::new(MachineSpec { gauge: [0.0, 0.0, 80.0], ..spec })?;
    /// assert_eq!(machine.axes.len(), 5);
    /// # Ok::<(), trunnion_motion::machine::MachineErrors>(())
    /// ```
    pub fn new(name: &str, chain: &[&str], axes: Vec<AxisSpec>) -> Self {
        Self {
            name: name.to_owned(),
            chain: chain.iter().map(|&word| word.to_owned()).collect(),
            tool_axis: [0.0, 0.0, 1.0],
            gauge: [0.0; 3],
            axes,
            cycle: ControlLimits::default(),
            singular: SingularPolicy::STANDARD,
            retract: RetractPolicy::standard(),
            dialect: ProgramFormat::linuxcnc(),
            bodies: Vec::new(),
        }
    }
}

/// Formats with four decimals, or as a power of ten if the number is below 1e-3 or above 1e9.
pub(super) fn decimals(value: f64) -> String {
    const READABLE: std::ops::Range<f64> = 1e-3..1e9;
    // Zero is written as such.
    if value.abs() > 0.0 && !READABLE.contains(&value.abs()) {
        format!("{value:.1e}")
    } else {
        format!("{value:.4}")
    }
}
