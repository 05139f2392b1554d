//! A machine as plain data, before it is checked.

use super::settings::{Cycle, Dialect, Output, Prefer, Retract, Singular};

/// How an axis moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AxisKind {
    /// Along a direction \[mm\].
    Linear,
    /// About a line \[rad\].
    Rotary,
}

impl AxisKind {
    /// A position or distance \[mm or rad\] for people: in mm or degrees.
    pub fn told(self, value: f64) -> String {
        match self {
            Self::Linear => format!("{} mm", decimals(value)),
            Self::Rotary => format!("{} deg", decimals(value.to_degrees())),
        }
    }
}

/// One axis as written in a machine file, in mm, rad, s.
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
    pub limits: Option<[f64; 2]>,
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
    /// Breaks ties between branches.
    pub prefer: Option<Prefer>,
    /// How a program writes it.
    pub output: Output,
}

/// A machine as written in a machine file, in mm, rad, s.
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
    /// What the control can do, as far as known.
    pub cycle: Cycle,
    /// Behaviour near a singular direction.
    pub singular: Singular,
    /// How to unwind.
    pub retract: Retract,
    /// How programs are written.
    pub dialect: Dialect,
}

/// Four decimals, or a power of ten where these show nothing, or nothing else.
pub(super) fn decimals(value: f64) -> String {
    const READABLE: std::ops::Range<f64> = 1e-3..1e9;
    if value.abs() > 0.0 && !READABLE.contains(&value.abs()) {
        format!("{value:.1e}")
    } else {
        format!("{value:.4}")
    }
}
