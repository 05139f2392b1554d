//! Errors of posting, with the line of the input and the remedy.

use crate::feed::FeedError;
use crate::inverse::InverseError;
use crate::nc::write::WriteError;
use crate::toolpath::SmoothError;
use crate::types::{Diagnostics, PoseDeviation, PoseTolerance};

/// Reason for refusing an input.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PostError {
    /// A pose is out of reach.
    #[error("{error}")]
    Reach {
        /// Line of the input.
        line: u32,
        /// Error of the inverse kinematics.
        error: Box<InverseError>,
    },
    /// The machine cannot follow a move.
    #[error(
        "the machine deviates from this move by {:.4} mm and {:.4} deg, more than {:.4} mm and {:.4} deg, however \
         finely it is divided: a rotary axis reaches the end of its travel and takes the long way round",
        strayed.tip, strayed.axis.to_degrees(), tolerance.tip, tolerance.axis.to_degrees()
    )]
    Strays {
        /// Line of the input.
        line: u32,
        /// Bounds on the deviation.
        strayed: PoseDeviation,
        /// Tolerance.
        tolerance: PoseTolerance,
    },
    /// A rotary axis reaches the end of its travel inside a cut that is written as tool vectors.
    #[error(
        "a rotary axis reaches the end of its travel in this move and would have to turn by {:.1} deg inside the cut; \
         tool vectors leave that to the control",
        turn.to_degrees()
    )]
    GoesRound {
        /// Line of the input.
        line: u32,
        /// Turn inside the cut \[rad\].
        turn: f64,
    },
    /// The input contains something that cannot be posted.
    #[error("{what} cannot be posted")]
    Refused {
        /// Line of the input.
        line: u32,
        /// The thing that cannot be posted.
        what: &'static str,
        /// Way out.
        remedy: PostRemedy,
    },
    /// Smoothing failed.
    #[error("{error}")]
    Smooth {
        /// Line of the input.
        line: u32,
        /// Error of the smoother.
        error: SmoothError,
    },
    /// The tool axis turns to its opposite in one move.
    #[error("the tool axis turns by half a turn in one move: its path is not defined")]
    Reversal {
        /// Line of the input.
        line: u32,
    },
    /// The input has no motion.
    #[error("there is no motion to write")]
    Empty,
    /// Planning failed.
    #[error(transparent)]
    Feed(#[from] FeedError),
    /// Writing failed.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Motion of the input is not in the output, or the other way round.
    #[error(
        "{:.4} mm of motion were read from this line, and {:.4} mm written: motion would be lost or invented",
        lengths[0], lengths[1]
    )]
    NotConserved {
        /// Line of the input.
        line: u32,
        /// Travel of the tip, as read and as written \[mm\].
        lengths: [f64; 2],
    },
    /// The written text means something else than was intended.
    #[error("the program was read back: {0}")]
    ReadBack(#[from] ReadBackError),
}

/// Way out of a [`PostError`]; a shell names its own options for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PostRemedy {
    /// No remedy is known.
    None,
    /// Move the workpiece origin, or rotate the workpiece.
    MoveOrRotatePart,
    /// Rotate the workpiece, or choose another machine.
    RotatePart,
    /// Allow retracts ([`PostOptions::unwind`](super::PostOptions::unwind)), divide the cut, or rotate the workpiece.
    UnwindOrRotatePart,
    /// Write rotary words, with retracts ([`PostOptions::unwind`](super::PostOptions::unwind)), or divide the cut.
    WriteRotaries,
    /// Give the length of every tool, or post one tool only.
    ToolLengths,
    /// Give the length of this tool.
    ToolLength,
    /// Enter the work offset at the control, and give the origin of the program.
    GiveOrigin,
    /// Inspect the input.
    InspectInput,
    /// Plain advice that names no option.
    Advice(&'static str),
}

impl From<&'static str> for PostRemedy {
    fn from(advice: &'static str) -> Self {
        Self::Advice(advice)
    }
}

impl PostError {
    pub(super) fn reach(line: u32, error: InverseError) -> Self {
        Self::Reach { line, error: Box::new(error) }
    }

    /// Returns the line of the input that caused the error; 0 for the input as a whole.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::post::PostError;
    ///
    /// assert_eq!(PostError::Reversal { line: 7 }.line(), 7);
    /// assert_eq!(PostError::Empty.line(), 0);
    /// ```
    pub fn line(&self) -> u32 {
        match self {
            Self::Reach { line, .. }
            | Self::Strays { line, .. }
            | Self::Refused { line, .. }
            | Self::GoesRound { line, .. }
            | Self::NotConserved { line, .. }
            | Self::Smooth { line, .. }
            | Self::Reversal { line } => *line,
            _ => 0,
        }
    }

    /// Returns the way out, for a shell to put into words.
    pub fn remedy(&self) -> PostRemedy {
        match self {
            Self::Reach { error, .. } if matches!(**error, InverseError::OutOfTravel(_)) => {
                PostRemedy::MoveOrRotatePart
            }
            Self::Reach { .. } => PostRemedy::RotatePart,
            Self::Strays { .. } => PostRemedy::UnwindOrRotatePart,
            Self::GoesRound { .. } => PostRemedy::WriteRotaries,
            Self::Refused { remedy, .. } => *remedy,
            Self::Reversal { .. } => PostRemedy::Advice("insert locations between"),
            Self::Feed(error) => error.remedy().map_or(PostRemedy::None, PostRemedy::Advice),
            Self::Empty => PostRemedy::InspectInput,
            Self::ReadBack(_) => PostRemedy::Advice(
                "check which modes the template and the strings of the machine file switch on before",
            ),
            _ => PostRemedy::None,
        }
    }
}

/// Result of reading a written program back, where it fails.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadBackError {
    /// The text means something else than was intended.
    #[error("line {line} of the program: {what}")]
    Differs {
        /// Line of the program.
        line: u32,
        /// Value read, and value intended.
        what: String,
    },
    /// The reader does not understand all of the text.
    #[error("not understood: {}", .0.first().map(ToString::to_string).unwrap_or_default())]
    Unread(Diagnostics),
}
