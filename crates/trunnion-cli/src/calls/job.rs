//! Jobs: read, run, written.

use crate::outcome::Failure;
use crate::output::Outputs;
use crate::run;
use std::path::{Path, PathBuf};
use trunnion::pipeline::{self, Job, Outcome, PipelineError};
use trunnion::types::Progress;

/// Job with the files that it names.
#[derive(Debug)]
#[non_exhaustive]
pub struct LoadedJob {
    /// Checked job.
    pub job: Job,
    /// Warnings about its part.
    pub warnings: Vec<String>,
}

/// Result of a run for callers in other languages.
#[derive(Debug)]
#[non_exhaustive]
pub struct JobAnswer {
    /// Everything that the run made; its summary has the warnings of the job.
    pub outcome: Outcome,
    /// Summary as a table for people.
    pub table: String,
    /// Files that were written.
    pub places: Vec<PathBuf>,
    /// Warnings, as the command line prints them.
    pub warnings: Vec<String>,
}

/// Reads a job file and the files that it names.
///
/// # Errors
///
/// All faults of all files.
pub fn load_job(path: &Path, progress: &dyn Progress) -> Result<LoadedJob, Failure> {
    let (job, warnings) = run::load(path, None, progress)?;
    Ok(LoadedJob { job, warnings })
}

/// Reads the text of a job that would stand at `path`, and the files that it names.
///
/// # Errors
///
/// All faults of all files.
pub fn load_job_text(
    path: &Path,
    text: &str,
    progress: &dyn Progress,
) -> Result<LoadedJob, Failure> {
    let (job, warnings) = run::load_text(path, text, None, progress)?;
    Ok(LoadedJob { job, warnings })
}

/// Runs a job that stands at `path`, and writes its files where a folder is given.
///
/// # Errors
///
/// The error of the stage that could not go on. Passes that could not become a program are kept in the folder.
pub fn run_job(
    path: &Path,
    loaded: &LoadedJob,
    folder: Option<&Path>,
    progress: &dyn Progress,
) -> Result<JobAnswer, Failure> {
    let LoadedJob { job, warnings } = loaded;
    folder.map_or(Ok(()), Outputs::probe)?;
    let outcome = match (pipeline::run(job, progress), folder) {
        (Err(PipelineError::AfterPasses { why, cl }), Some(folder)) => {
            return Err(run::kept_passes(folder, &cl, &why));
        }
        (found, _) => found.map_err(|error| run::refused(path, error))?,
    };
    let mut answer = JobAnswer {
        warnings: run::unread(&outcome),
        outcome,
        table: String::new(),
        places: Vec::new(),
    };
    let mut summary = answer.outcome.summary.clone();
    // Warnings about the part come first: they explain later ones.
    summary.warnings.splice(0..0, warnings.iter().cloned());
    if let Some(folder) = folder {
        answer.places = run::write(job, &answer.outcome, &mut summary, folder)?;
    }
    answer.table = run::table(&summary, &answer.places);
    answer.outcome.summary = summary;
    Ok(answer)
}
