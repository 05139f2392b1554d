//! What a machine file says beside the chain: control, singular cone, unwinding, program format.

use std::collections::BTreeMap;

/// Sign of an axis that is preferred where two branches are equally good.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Prefer {
    /// Zero or above.
    Positive,
    /// Below zero.
    Negative,
}

/// How a program states the turn of a rotary axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Modulo {
    /// 370° stays 370°.
    Unwound,
    /// In `[0°, 360°)`.
    Positive,
    /// In `[-180°, 180°)`.
    Signed,
}

/// How a program writes an axis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// Address letter; the axis name if left out.
    pub letter: Option<String>,
    /// Digits behind the decimal point.
    pub decimals: u8,
    /// Turns of a rotary axis.
    pub modulo: Modulo,
}

impl Output {
    /// What holds where a machine file says nothing: the axis name, four decimals, unwound.
    pub const STANDARD: Self = Self { letter: None, decimals: 4, modulo: Modulo::Unwound };
}

/// What the control can do; `None` where the machine file does not say.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cycle {
    /// Time between two setpoints \[s\].
    pub servo_period: Option<f64>,
    /// Largest speed of the tip \[mm/s\].
    pub tip_speed_max: Option<f64>,
    /// Largest acceleration of the tip along its path \[mm/s²\].
    pub tip_acc_max: Option<f64>,
    /// Largest jerk of the tip along its path \[mm/s³\].
    pub tip_jerk_max: Option<f64>,
    /// How far the control's own smoothing may leave the programmed path \[mm\].
    pub contour_tolerance: Option<f64>,
    /// The same for the tool axis \[rad\].
    pub orientation_tolerance: Option<f64>,
}

/// Behaviour near a singular direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Singular {
    /// Half angle of the cone about the singular direction in which something is done \[rad\].
    pub cone: f64,
    /// Rotary move below which nothing is done \[rad\].
    pub min_rotary: f64,
    /// How far the tip may leave the path for it \[mm\].
    pub tolerance: f64,
}

impl Singular {
    /// What holds where a machine file says nothing: 3°, 10°, 0.02 mm.
    pub const STANDARD: Self = Self {
        cone: 3.0 * std::f64::consts::PI / 180.0,
        min_rotary: 10.0 * std::f64::consts::PI / 180.0,
        tolerance: 0.02,
    };
}

/// The frame in which a retraction is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RetractFrame {
    /// Move a machine axis.
    Machine,
    /// Move along the tool axis.
    Tool,
}

/// How the tool leaves the part to unwind a rotary axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Retract {
    /// Machine or tool frame.
    pub frame: RetractFrame,
    /// Axis that retracts (machine frame).
    pub axis: String,
    /// Where it goes \[mm\]: an axis position, or a distance along the tool axis.
    pub to: f64,
    /// Whether it retracts before the rotaries turn.
    pub first: bool,
}

impl Retract {
    /// What holds where a machine file says nothing: Z to machine 0, before the rotaries turn.
    pub fn standard() -> Self {
        Self { frame: RetractFrame::Machine, axis: "Z".to_owned(), to: 0.0, first: true }
    }
}

/// How the control moves the tool axis between two programmed positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// Tip straight, rotary axes in proportion (RTCP with angles).
    RotaryLinear,
    /// Tip straight, tool axis on the great circle (RTCP with vectors).
    GreatCircle,
    /// All five axes in proportion (no RTCP).
    Axes,
}

/// What a feed word means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FeedMode {
    /// Speed of the tip.
    Tip,
    /// One over the time of the block.
    InverseTime,
}

/// Program format of the control.
#[derive(Debug, Clone, PartialEq)]
pub struct Dialect {
    /// Name, such as `linuxcnc`.
    pub name: String,
    /// Interpolation under tool-centre-point control.
    pub interpolation: Interpolation,
    /// Meaning of the feed word.
    pub feed: FeedMode,
    /// Editable strings by key, such as `tcp_on`.
    pub strings: BTreeMap<String, String>,
}
