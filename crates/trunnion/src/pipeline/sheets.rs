//! Cutter locations, setup sheet, and the notes at the head of programs.

use super::error::PipelineError;
use super::job::Job;
use super::operations::OperationMotion;
use super::planned_motion::PlannedMotion;
use super::retracts;
use crate::nc::write::{
    self, AxisWords, Coolant, LegSection, Note, OutputFormat, Remark, SheetPrograms, SheetTool,
    ToolNote, WriteError,
};
use crate::types::{Block, Leg};

/// Decimals of cutter locations \[mm\].
const CL_DECIMALS: u8 = 6;

/// Texts that do not depend on the dialect.
pub(super) struct Sheets {
    /// Cutter locations as APT/CL text.
    pub(super) cl: String,
    /// Setup sheet.
    pub(super) setup: String,
}

/// Writes cutter locations, and a setup sheet for the programs of these formats.
pub(super) fn sheets(
    operations: &[OperationMotion<'_>],
    formats: &[OutputFormat],
) -> Result<Sheets, PipelineError> {
    let job = operations.first().ok_or(WriteError::Empty)?.job;
    let shares = shares(job);
    let remarks: Vec<Remark> =
        operations.iter().flat_map(|one| remarks(&one.motion(), &[])).collect();
    let duration = |one: &OperationMotion<'_>| one.motion().plan.schedule.duration();
    let total = operations.iter().map(duration).sum();
    let note = Note { remarks: &remarks, budget: &shares, ..note(job, total) };
    let legs: Vec<LegsOf<'_>> =
        operations.iter().map(|one| LegsOf { job: one.job, legs: &one.legs }).collect();
    let cl = cutter_locations(&legs)?;
    let mut setup = String::new();
    let axes = AxisWords::of(job.kinematics.machine())?;
    let tools = sheet_tools(operations);
    let tools = if tools.len() > 1 { tools.as_slice() } else { &[] };
    let programs = SheetPrograms { axes, dialects: formats, tools };
    write::setup_sheet(&mut setup, &job.kinematics, &note, programs)?;
    Ok(Sheets { cl, setup })
}

/// Returns the tools of the operations, each once.
fn sheet_tools(operations: &[OperationMotion<'_>]) -> Vec<SheetTool> {
    let tool = |one: &OperationMotion<'_>| SheetTool {
        tool: note(one.job, 0.0).tool,
        length: one.job.cutter.length(),
    };
    SheetTool::each_once(operations.iter().map(tool))
}

/// Legs of an operation.
#[derive(Clone, Copy)]
pub(super) struct LegsOf<'a> {
    pub(super) job: &'a Job,
    pub(super) legs: &'a [Leg],
}

/// Writes the cutter locations alone.
pub(super) fn cutter_locations(operations: &[LegsOf<'_>]) -> Result<String, PipelineError> {
    let mut cl = String::new();
    let notes: Vec<Note<'_>> = operations.iter().map(|one| note(one.job, 0.0)).collect();
    let sections: Vec<LegSection<'_>> = operations
        .iter()
        .zip(&notes)
        .map(|(of, note)| LegSection { note, legs: of.legs })
        .collect();
    write::apt(&mut cl, &sections, CL_DECIMALS)?;
    Ok(cl)
}

/// Returns a remark for each retract, before the first block of its first piece.
pub(super) fn remarks(moved: &PlannedMotion<'_>, pieces: &[Vec<Block>]) -> Vec<Remark> {
    let before = |piece: usize| pieces.iter().take(piece + 1).map(Vec::len).sum();
    let all = moved.followed.retracts.iter().zip(moved.retracts);
    all.map(|(retracted, summary)| Remark {
        block: before(retracted.pieces.start),
        text: retracts::line(summary),
    })
    .collect()
}

/// Returns the note at the head of a program of `duration` \[s\], without budget and remarks.
pub(super) fn note(job: &Job, duration: f64) -> Note<'_> {
    Note {
        name: &job.file.name,
        tool: ToolNote {
            number: job.file.tool.number,
            major: job.cutter.major(),
            minor: job.cutter.minor(),
        },
        spindle: job.file.cutting.spindle_rpm(),
        coolant: if job.file.cutting.coolant { Coolant::Flood } else { Coolant::Off },
        feed: job.file.cutting.feed,
        budget: &[],
        duration,
        remarks: &[],
    }
}

/// Returns the tolerance shares by name \[mm\].
pub(super) fn shares(job: &Job) -> Vec<(String, f64)> {
    job.budget.lines().map(|(name, value)| (name.to_owned(), value)).collect()
}
