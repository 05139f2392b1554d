//! Errors of the chain, by stage.

use super::out_of_reach::OutOfReach;
use super::too_concave::TooConcave;
use crate::axes::AxesError;
use crate::blocks::BlocksError;
use crate::cover::CoverError;
use crate::feed::FeedError;
use crate::nc::write::{WordsError, WriteError};
use crate::setpoint::SetpointError;
use crate::toolpath::ToolPathError;
use crate::types::{Cancelled, Diagnostic, Diagnostics};
use crate::verify::VerifyError;

/// Failure of a stage, with its cause.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Part of a face that the machine cannot reach, found before anything was placed.
    #[error(transparent)]
    OutOfReach(Box<OutOfReach>),
    /// Face that no cutter fits, found before anything was placed.
    #[error(
        "{0}; take a ball or a corner of at most {radius:.3} mm, in a further [[operation]] with method = \"rest\" or in its place, \
         or leave the face out",
        radius = .0.radius
    )]
    TooConcave(Box<TooConcave>),
    /// Faces that the flank is asked to cut and cannot, found before anything was placed.
    #[error("method = \"flank\" does not fit:\n{}", why.join("\n"))]
    NoFlank {
        /// Faces with their reasons.
        why: Vec<String>,
    },
    /// Stock or fixtures that cannot be worked with, each at its line of the job.
    #[error("{}", first(.0))]
    Solids(Diagnostics),
    /// No pass cuts anything.
    #[error("no pass with this tool in this setup finishes anything of the faces:\n{}", why.join("\n"))]
    NothingCut {
        /// Uncut regions with their reasons.
        why: Vec<String>,
    },
    /// Passes over the faces.
    #[error("placing strips: {0}")]
    Cover(CoverError),
    /// Curves through the cutter locations.
    #[error("fitting curves: {0}")]
    ToolPath(ToolPathError),
    /// The machine's axes.
    #[error("solving the axes: {0}")]
    Axes(AxesError),
    /// Speeds.
    #[error("planning speeds: {}", .0.in_one_line())]
    Feed(FeedError),
    /// A schedule so long that its setpoints would fill the disk.
    #[error(
        "the program takes {duration:.0} s: motion.csv would have {rows:.0} rows, more than {most:.0}; \
         raise motion.servo_period to {period:.4} s or more, or the feed"
    )]
    Rows {
        /// Planned time \[s\].
        duration: f64,
        /// Rows at the period asked for.
        rows: f64,
        /// Rows that are written at most.
        most: f64,
        /// Period that would do \[s\].
        period: f64,
    },
    /// Setpoints.
    #[error("sampling setpoints: {0}")]
    Setpoint(#[from] SetpointError),
    /// Program blocks.
    #[error("breaking the path into blocks: {0}")]
    Blocks(BlocksError),
    /// Axis words of the machine.
    #[error("machine file: {0}")]
    Words(#[from] WordsError),
    /// Program text.
    #[error("writing the program: {0}")]
    Write(#[from] WriteError),
    /// Decimals of the program are too few for the tolerance.
    #[error(
        "rounding the words of {file} moves the cutter by up to {rounding:.6} mm, more than the \
         {share:.6} mm the budget gives it; ask for more decimals in the machine's output or set \
         tolerance.split.rounding"
    )]
    Rounding {
        /// Program file.
        file: &'static str,
        /// Effect of rounding \[mm\].
        rounding: f64,
        /// Share of the budget \[mm\].
        share: f64,
    },
    /// The reader does not understand a program: a defect of the writer.
    #[error("{file} cannot be read back: {}", first(faults))]
    ReadBack {
        /// Program file.
        file: &'static str,
        /// Diagnostics of the reader.
        faults: Diagnostics,
    },
    /// A program means something else than was intended, because of strings in the machine file or a defect of the
    /// writer.
    #[error("{file}, line {line}: {what}")]
    Differs {
        /// Program file.
        file: &'static str,
        /// Line of the program.
        line: u32,
        /// Value read, and value intended.
        what: String,
    },
    /// A stage could not go on after the passes were planned: their cutter locations are all that remains.
    #[error("{why}")]
    AfterPasses {
        /// Error of the stage.
        why: Box<PipelineError>,
        /// Cutter locations as APT/CL text.
        cl: String,
    },
    /// The check of a program.
    #[error("checking the program: {0}")]
    Verify(VerifyError),
}

fn first(faults: &[Diagnostic]) -> String {
    faults.first().map(ToString::to_string).unwrap_or_default()
}

/// Makes cancellation one error, whichever stage noticed it.
macro_rules! stage_error {
    ($($error:ident => $variant:ident),*) => {$(
        impl From<$error> for PipelineError {
            fn from(error: $error) -> Self {
                match error {
                    $error::Cancelled(stop) => Self::Cancelled(stop),
                    error => Self::$variant(error),
                }
            }
        }
    )*};
}

/// Returns the result; `None` in place of an error other than cancellation: what was tried is not to be had so.
///
/// # Errors
///
/// [`PipelineError::Cancelled`].
pub(super) fn unless_stopped<T>(
    result: Result<T, PipelineError>,
) -> Result<Option<T>, PipelineError> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(stop @ PipelineError::Cancelled(_)) => Err(stop),
        Err(_) => Ok(None),
    }
}

stage_error!(
    CoverError => Cover,
    ToolPathError => ToolPath,
    AxesError => Axes,
    FeedError => Feed,
    BlocksError => Blocks,
    VerifyError => Verify
);
