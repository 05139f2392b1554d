//! Faces that a proposed job does not cut, with their reasons.

use crate::cutter::CutterErrors;
use crate::types::{Cancelled, UncutReason};

/// Face that a proposed job does not cut.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LeftOutFace {
    /// Number of the face.
    pub number: usize,
    /// Reason.
    pub reason: FaceReason,
}

/// Reason why a proposed job does not cut a face.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaceReason {
    /// The face cannot be worked with.
    #[error("{0}")]
    Surface(String),
    /// The face looks down, to the table.
    #[error("looks down to the table; turn the part over in a second setup")]
    Down,
    /// The face is an outer wall that goes down to the bottom of the part.
    #[error(
        "is a wall down to the bottom, where the part is held; a job that names it cuts it, with the tool from the side"
    )]
    Wall,
    /// The tool reaches less than half of it; the reason at most of the points.
    #[error("the tool reaches {:.0} % of it: {reason}", 100.0 * share)]
    NotReached {
        /// Share of the face that is reached.
        share: f64,
        /// Reason at most of the other points.
        reason: UncutReason,
    },
}

/// Reason why no job can be proposed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProposalError {
    /// No face can be cut.
    #[error(
        "no face of the part can be cut from above: {}; turn the part, or take another machine", reasons(.left_out)
    )]
    NothingReached {
        /// All faces, each with the reason.
        left_out: Vec<LeftOutFace>,
    },
    /// No cutter can be chosen.
    #[error(
        "the library has no flat, bull-nose or ball end mill; add one, as `[[cutter]]` with `kind = \"ball\"`"
    )]
    NoCutter,
    /// A cutter of the library cannot exist.
    #[error("cutter \"{name}\" of the library: {errors}")]
    BadCutter {
        /// Name of the cutter.
        name: String,
        /// Everything that is wrong with it.
        errors: CutterErrors,
    },
    /// The part does not fit into the travel of the machine.
    #[error(
        "the part does not fit into the travel of {axis}: {short:.1} mm are missing wherever the origin is; take a larger machine"
    )]
    Travel {
        /// Name of the axis.
        axis: String,
        /// Travel that is missing \[mm\].
        short: f64,
    },
    /// The operation was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Lists faces with their reasons; of many, the first few.
fn reasons(left_out: &[LeftOutFace]) -> String {
    const MOST: usize = 6;
    let one = |face: &LeftOutFace| format!("face {} {}", face.number, face.reason);
    let mut all: Vec<String> = left_out.iter().take(MOST).map(one).collect();
    if left_out.len() > MOST {
        all.push(format!("and {} more", left_out.len() - MOST));
    }
    all.join("; ")
}
