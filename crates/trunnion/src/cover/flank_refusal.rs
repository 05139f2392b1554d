//! Reasons why the flank of a tool cannot cut a face.

use std::fmt;

/// Reason why the flank of a tool cannot cut a face in one pass.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum FlankRefusal {
    /// The face has no straight lines that rise from below.
    NoRulings,
    /// The straight side of the tool is too short.
    Short {
        /// Length of the longest straight line of the face \[mm\].
        ruling: f64,
        /// Length of the straight side \[mm\].
        side: f64,
    },
    /// The face is hollow, and narrower than the tool.
    Concave {
        /// Least concave radius of the face \[mm\].
        concave: f64,
        /// Radius of the tool \[mm\].
        radius: f64,
    },
    /// The face twists so much that the side of the tool leaves the tolerance.
    Twisted {
        /// Radius of the tool \[mm\].
        radius: f64,
    },
    /// The tool would gouge this face or another one.
    Gouges,
}

impl std::error::Error for FlankRefusal {}

impl fmt::Display for FlankRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRulings => write!(
                f,
                "the face has no straight lines that rise from below; take method = \"auto\" for it"
            ),
            Self::Short { ruling, side } => write!(
                f,
                "its straight lines are up to {ruling:.1} mm long, the straight side of the tool is {side:.1} mm; take a tool \
                 with a longer side"
            ),
            Self::Concave { concave, radius } => write!(
                f,
                "the face is hollow with a radius of {concave:.3} mm, the tool has {radius} mm; take a thinner tool"
            ),
            Self::Twisted { radius } => write!(
                f,
                "the face twists so much that the side of a tool of {radius} mm radius leaves the tolerance; take a thinner \
                 tool, a larger tolerance, or method = \"auto\""
            ),
            Self::Gouges => write!(
                f,
                "the tool would gouge this face or one beside it; take a thinner tool, or method = \"auto\""
            ),
        }
    }
}
