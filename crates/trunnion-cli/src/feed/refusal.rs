//! Errors of planning, with their remedy.

use crate::outcome::Failure;
use std::path::Path;
use trunnion::feed::FeedError;

/// Refuses a file, with the remedy on a line of its own.
pub(super) fn refusal(file: &Path, error: FeedError) -> Failure {
    let help = error.remedy().map_or_else(String::new, |remedy| format!("\n  help: {remedy}"));
    Failure::input(format!("{}: {error}{help}", file.display()))
}
