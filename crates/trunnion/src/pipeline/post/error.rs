//! Why an input was not posted: with its line, and what to do.

use crate::feed::FeedError;
use crate::inverse::InverseError;
use crate::nc::write::WriteError;
use crate::pipeline::ReadBackError;
use crate::toolpath::SmoothError;

/// Why an input was not posted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PostError {
    /// A pose is out of reach.
    #[error("{error}")]
    Reach {
        /// Line of the input.
        line: u32,
        /// Why.
        error: Box<InverseError>,
    },
    /// The machine cannot follow a move.
    #[error(
        "the machine strays from this move by {:.4} mm and {:.4} deg, more than {:.4} mm and {:.4} deg, however \
         finely it is cut: a rotary axis comes to the end of its travel and goes round",
        strayed[0], strayed[1].to_degrees(), tolerance[0], tolerance[1].to_degrees()
    )]
    Strays {
        /// Line of the input.
        line: u32,
        /// Bounds found: mm, rad.
        strayed: [f64; 2],
        /// Bounds allowed: mm, rad.
        tolerance: [f64; 2],
    },
    /// What cannot be posted.
    #[error("{what} cannot be posted")]
    Refused {
        /// Line of the input.
        line: u32,
        /// What it is.
        what: &'static str,
        /// What to do.
        help: &'static str,
    },
    /// Smoothing failed.
    #[error("{error}")]
    Smooth {
        /// Line of the input.
        line: u32,
        /// Why.
        error: SmoothError,
    },
    /// The tool axis turns to its opposite in one move.
    #[error("the tool axis turns by half a turn in one move: the way is not defined")]
    Reversal {
        /// Line of the input.
        line: u32,
    },
    /// No motion.
    #[error("there is no motion to write")]
    Empty,
    /// Planning failed.
    #[error(transparent)]
    Feed(#[from] FeedError),
    /// Writing failed.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The text says something else than was meant.
    #[error("the program was read back: {0}")]
    ReadBack(#[from] ReadBackError),
}

impl PostError {
    pub(super) fn reach(line: u32, error: InverseError) -> Self {
        Self::Reach { line, error: Box::new(error) }
    }

    /// Line of the input it belongs to; 0 for the input as a whole.
    pub fn line(&self) -> u32 {
        match self {
            Self::Reach { line, .. }
            | Self::Strays { line, .. }
            | Self::Refused { line, .. }
            | Self::Smooth { line, .. }
            | Self::Reversal { line } => *line,
            _ => 0,
        }
    }

    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Reach { error, .. } if matches!(**error, InverseError::OutOfTravel(_)) => {
                "clamp the part elsewhere (--origin), or turn it (--rotation)"
            }
            Self::Reach { .. } => "turn the part (--rotation), or post it for another machine",
            Self::Strays { .. } => {
                "let the rotaries go round off the part (--unwind), part the cut by a rapid move before this line, or turn \
                 the part (--rotation)"
            }
            Self::Refused { help, .. } => help,
            Self::Reversal { .. } => "insert locations between",
            Self::Empty => "inspect tells what the file holds; with --tool, which tools it calls",
            Self::ReadBack(_) => {
                "look at what the template and the strings of the machine file switch on before"
            }
            _ => "",
        }
    }
}
