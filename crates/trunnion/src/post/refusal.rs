//! Refusals of a step of a program.

use super::error::{PostError, PostRemedy};

/// Refuses what stands in a line of the input.
pub(super) fn refused(line: u32, what: &'static str, remedy: impl Into<PostRemedy>) -> PostError {
    PostError::Refused { line, what, remedy: remedy.into() }
}
