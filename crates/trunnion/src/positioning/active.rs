//! The constraints that limit a strip.

use std::fmt;

/// Constraint that limits the width of a strip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ActiveConstraint {
    /// The cutter touches the lower end of the band inside the strip.
    Touch,
    /// The error reaches the upper end of the band inside the strip.
    Middle,
    /// The error curve is level at the first end point: it would leave the band inside the strip.
    FirstSlope,
    /// The same at the second end point.
    SecondSlope,
    /// The rear of the centre circle.
    Rear,
    /// The flat disc inside the cutting circle.
    Disc,
    /// The chord is as long as the cutter is wide.
    Chord,
    /// An end of the range of the offset direction.
    OffsetRange,
    /// The bound on the turn of the tool axis.
    AxisTurn,
    /// The angle between tool axis and normal was given, not found.
    GivenLead,
}

impl fmt::Display for ActiveConstraint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Touch => "a contact inside the strip",
            Self::Middle => "the largest error inside the strip",
            Self::FirstSlope => "the first end of the strip, where the error rises",
            Self::SecondSlope => "the far end of the strip, where the error rises",
            Self::Rear => "the rear of the cutting circle",
            Self::Disc => "the flat underside",
            Self::Chord => "a chord as long as the cutter is wide",
            Self::OffsetRange => "an end of the offset range",
            Self::AxisTurn => "the bound on the axis turn",
            Self::GivenLead => "the given lead",
        })
    }
}
