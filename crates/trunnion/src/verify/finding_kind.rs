//! Kinds of findings, by the names that reports and reference pages use.

use super::report::Finding;
use super::state::StateFinding;

/// Kind of a [`Finding`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FindingKind {
    /// [`Finding::Gouge`]
    Gouge,
    /// [`Finding::Excess`]
    Excess,
    /// [`Finding::Length`]
    ToolLength,
    /// [`Finding::Uncut`]
    Uncut,
    /// [`Finding::Rapid`]
    RapidFinish,
    /// [`Finding::Unmeasured`]
    Unmeasured,
    /// [`Finding::Travel`]
    Travel,
    /// [`Finding::Velocity`]
    Velocity,
    /// [`Finding::Acceleration`]
    Acceleration,
    /// [`StateFinding::SpindleStopped`]
    SpindleStopped,
    /// [`StateFinding::SpindleReversed`]
    SpindleReversed,
    /// [`StateFinding::NoLength`]
    NoLength,
    /// [`StateFinding::WrongLength`]
    WrongLength,
    /// [`StateFinding::NoTool`]
    NoTool,
    /// [`StateFinding::SlowCuts`]
    SlowCuts,
    /// [`StateFinding::FastCuts`]
    FastCuts,
    /// [`StateFinding::NoCoolant`]
    NoCoolant,
    /// [`StateFinding::Smoothing`] and [`StateFinding::UnboundedSmoothing`]
    Smoothing,
}

impl FindingKind {
    /// All kinds.
    pub const ALL: [Self; 18] = [
        Self::Gouge,
        Self::Excess,
        Self::ToolLength,
        Self::Uncut,
        Self::RapidFinish,
        Self::Unmeasured,
        Self::Travel,
        Self::Velocity,
        Self::Acceleration,
        Self::SpindleStopped,
        Self::SpindleReversed,
        Self::NoLength,
        Self::WrongLength,
        Self::NoTool,
        Self::SlowCuts,
        Self::FastCuts,
        Self::NoCoolant,
        Self::Smoothing,
    ];

    /// Returns the name: lower case, words joined by hyphens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gouge => "gouge",
            Self::Excess => "excess",
            Self::ToolLength => "tool-length",
            Self::Uncut => "uncut",
            Self::RapidFinish => "rapid-finish",
            Self::Unmeasured => "unmeasured",
            Self::Travel => "travel",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::SpindleStopped => "spindle-stopped",
            Self::SpindleReversed => "spindle-reversed",
            Self::NoLength => "no-length",
            Self::WrongLength => "wrong-length",
            Self::NoTool => "no-tool",
            Self::SlowCuts => "slow-cuts",
            Self::FastCuts => "fast-cuts",
            Self::NoCoolant => "no-coolant",
            Self::Smoothing => "smoothing",
        }
    }

    /// Returns the kind of a name.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::verify::FindingKind;
    ///
    /// assert_eq!(FindingKind::from_name("spindle-stopped"), Some(FindingKind::SpindleStopped));
    /// assert!(FindingKind::ALL.iter().all(|kind| FindingKind::from_name(kind.name()) == Some(*kind)));
    /// ```
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl Finding {
    /// Returns the kind.
    pub fn kind(&self) -> FindingKind {
        match self {
            Self::Gouge(_) | Self::FurtherGouges { .. } => FindingKind::Gouge,
            Self::Excess(_) | Self::FurtherExcess { .. } => FindingKind::Excess,
            Self::Length { .. } => FindingKind::ToolLength,
            Self::Uncut { .. } => FindingKind::Uncut,
            Self::Rapid { .. } => FindingKind::RapidFinish,
            Self::Unmeasured { .. } => FindingKind::Unmeasured,
            Self::Travel { .. } => FindingKind::Travel,
            Self::Velocity { .. } => FindingKind::Velocity,
            Self::Acceleration { .. } => FindingKind::Acceleration,
            Self::State(StateFinding::SpindleStopped(_)) => FindingKind::SpindleStopped,
            Self::State(StateFinding::SpindleReversed(_)) => FindingKind::SpindleReversed,
            Self::State(StateFinding::NoLength(_)) => FindingKind::NoLength,
            Self::State(StateFinding::WrongLength { .. }) => FindingKind::WrongLength,
            Self::State(StateFinding::NoTool { .. }) => FindingKind::NoTool,
            Self::State(StateFinding::SlowCuts { .. }) => FindingKind::SlowCuts,
            Self::State(StateFinding::FastCuts { .. }) => FindingKind::FastCuts,
            Self::State(StateFinding::NoCoolant(_)) => FindingKind::NoCoolant,
            Self::State(
                StateFinding::Smoothing { .. } | StateFinding::UnboundedSmoothing { .. },
            ) => FindingKind::Smoothing,
        }
    }
}
