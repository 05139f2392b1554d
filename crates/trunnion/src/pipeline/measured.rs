//! Check of a written program: its text is read, and run as its control would run it.

use super::error::PipelineError;
use super::fixtures::MOST_COLLISIONS;
use super::job::Job;
use super::program_format::ProgramFormat;
use super::solids::Solids;
use crate::blocks::BlockInterpolation;
use crate::nc::read::{self, AxisWords, Step, Turning};
use crate::nc::write::OutputFormat;
use crate::post::{MOST_FAULTS, control_of};
use crate::surface::{Face, FaceIndex};
use crate::types::{Progress, UncutRegion};
use crate::verify::{
    CheckInput, CheckOptions, DeviationTolerance, FeedMeaning, Inspection, InspectionReport,
};

/// Returns true if every block has its time. Where F is a tip feed the control plans its own speeds, and only the
/// geometry is checked.
pub(super) fn is_timed(dialect: OutputFormat) -> bool {
    matches!(dialect, OutputFormat::LinuxCnc | OutputFormat::G93)
}

/// Checks a program of a job as `trunnion check` does: faces that are cut and those that are not, stock and fixtures.
pub(super) fn run(
    job: &Job,
    program: &WrittenProgram<'_>,
    against: &CheckedAgainst<'_>,
    progress: &dyn Progress,
) -> Result<InspectionReport, PipelineError> {
    let &WrittenProgram { form, text, axes } = program;
    let options = read::ReadOptions::new(form.dialect.dialect(), axes, MOST_FAULTS);
    let failed = |faults| PipelineError::ReadBack { file: form.file, faults };
    let mut program = read::read(text, &options).map_err(failed)?;
    if control_of(&job.kinematics, form.dialect) == BlockInterpolation::GreatCircle {
        on_circles(&mut program);
    }
    let plain = |faces: &[FaceIndex]| -> Vec<Face> {
        faces.iter().map(|face| face.face().clone()).collect()
    };
    let (faces, others) = (plain(&job.faces), plain(&job.others));
    let input = CheckInput::program(&program, &job.kinematics, &job.cutter);
    let input = input.faces(&faces).rest(against.rest);
    let tolerance = DeviationTolerance { excess: job.budget.total, gouge: job.budget.gouge };
    let options = CheckOptions::of_tolerance(tolerance, job.file.verify_grid);
    let feeds = if is_timed(form.dialect) { FeedMeaning::Timed } else { FeedMeaning::Cap };
    let mut inspection = Inspection::new(input, options).others(&others).feeds(feeds);
    if let Some(stock) = &against.solids.stock {
        inspection = inspection.stock(stock, MOST_COLLISIONS);
    }
    if let Some(fixtures) = &against.solids.fixtures {
        inspection = inspection.fixtures(fixtures.all(), fixtures.watch());
    }
    Ok(inspection.run(progress)?)
}

/// Text of a program, as it was written.
pub(super) struct WrittenProgram<'a> {
    pub(super) form: &'a ProgramFormat,
    pub(super) text: &'a str,
    pub(super) axes: AxisWords,
}

/// References of the check besides the faces of the job.
pub(super) struct CheckedAgainst<'a> {
    /// Regions that are known to be unfinished.
    pub(super) rest: &'a [UncutRegion],
    pub(super) solids: &'a Solids,
}

/// Makes the tool turn on great circles between rotary words, as the control of the job does.
fn on_circles(program: &mut read::Program) {
    for step in &mut program.steps {
        if let Step::Move(one) = step {
            one.turning = Turning::GreatCircle;
        }
    }
}
