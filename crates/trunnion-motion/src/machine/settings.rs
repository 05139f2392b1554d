//! Settings of a machine beside its chain: control, singular cone, unwinding, program format.

use std::collections::BTreeMap;

/// Sign of an axis that is preferred where two branches are equally good.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PreferredSign {
    /// Zero or above.
    Positive,
    /// Below zero.
    Negative,
}

/// Representation of the turns of a rotary axis in a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TurnFormat {
    /// 370° stays 370°.
    Unwound,
    /// In `[0°, 360°)`.
    Positive,
    /// In `[-180°, 180°)`.
    Signed,
}

/// Format of the words of an axis in programs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AxisFormat {
    /// Address letter; the axis name if left out.
    pub letter: Option<String>,
    /// Digits behind the decimal point.
    pub decimals: u8,
    /// Turns of a rotary axis.
    pub modulo: TurnFormat,
}

impl AxisFormat {
    /// Default of machine files: the axis name, four decimals, unwound.
    pub const STANDARD: Self = Self { letter: None, decimals: 4, modulo: TurnFormat::Unwound };
}

/// Limits of the control; `None` if the machine file does not state one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ControlLimits {
    /// Time between two setpoints \[s\].
    pub servo_period: Option<f64>,
    /// Largest speed of the tip \[mm/s\].
    pub tip_speed_max: Option<f64>,
    /// Largest acceleration of the tip along its path \[mm/s²\].
    pub tip_acc_max: Option<f64>,
    /// Largest jerk of the tip along its path \[mm/s³\].
    pub tip_jerk_max: Option<f64>,
    /// Largest deviation of the control's own smoothing from the programmed path \[mm\].
    pub contour_tolerance: Option<f64>,
    /// The same for the tool axis \[rad\].
    pub orientation_tolerance: Option<f64>,
}

/// Behaviour near a singular direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularPolicy {
    /// Half angle of the singular cone, in which the path may be changed \[rad\].
    pub cone: f64,
    /// Rotary move up to which the path stays as it is \[rad\].
    pub min_rotary: f64,
    /// Largest deviation of the tip from the path to avoid that move \[mm\].
    pub tolerance: f64,
}

impl SingularPolicy {
    /// Default of machine files: 3°, 10°, 0.02 mm.
    pub const STANDARD: Self = Self {
        // 3 and 10 degrees.
        cone: 3.0 * std::f64::consts::PI / 180.0,
        min_rotary: 10.0 * std::f64::consts::PI / 180.0,
        tolerance: 0.02,
    };
}

/// Frame of a retract move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RetractFrame {
    /// Move a machine axis.
    Machine,
    /// Move along the tool axis.
    Tool,
}

/// Retract move with which the tool leaves the part to unwind a rotary axis.
#[derive(Debug, Clone, PartialEq)]
pub struct RetractPolicy {
    /// Machine or tool frame.
    pub frame: RetractFrame,
    /// Axis that retracts (machine frame).
    pub axis: String,
    /// Target \[mm\]: an axis position, or a distance along the tool axis.
    pub to: f64,
    /// `true` to retract before the rotaries turn.
    pub first: bool,
}

impl RetractPolicy {
    /// Returns the default of machine files: Z to machine 0, before the rotaries turn.
    pub fn standard() -> Self {
        Self { frame: RetractFrame::Machine, axis: "Z".to_owned(), to: 0.0, first: true }
    }
}

/// Motion of the tool axis between two programmed positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AxisInterpolation {
    /// Tip straight, rotary axes in proportion (RTCP with angles).
    RotaryLinear,
    /// Tip straight, tool axis on the great circle (RTCP with vectors).
    GreatCircle,
    /// All five axes in proportion (no RTCP).
    Axes,
}

/// Meaning of a feed word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FeedMode {
    /// Speed of the tip.
    Tip,
    /// One over the time of the block.
    InverseTime,
}

/// Program format of the control.
#[derive(Debug, Clone, PartialEq)]
pub struct ProgramFormat {
    /// Name, such as `linuxcnc`.
    pub name: String,
    /// Interpolation under tool-centre-point control.
    pub interpolation: AxisInterpolation,
    /// Meaning of the feed word.
    pub feed: FeedMode,
    /// Editable strings by key, such as `tcp_on`.
    pub strings: BTreeMap<String, String>,
}

impl ProgramFormat {
    /// Returns the format of `LinuxCNC`: rotary axes in proportion, inverse-time feed, standard strings.
    pub fn linuxcnc() -> Self {
        Self {
            name: "linuxcnc".to_owned(),
            interpolation: AxisInterpolation::RotaryLinear,
            feed: FeedMode::InverseTime,
            strings: BTreeMap::new(),
        }
    }
}
