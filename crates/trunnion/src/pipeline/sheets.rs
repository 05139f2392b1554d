//! Cutter locations, setup sheet, and the notes at the head of programs.

use super::error::PipelineError;
use super::job::Job;
use super::planned_motion::PlannedMotion;
use super::retracts;
use crate::nc::write::{
    self, AxisWords, Coolant, Note, OutputFormat, Remark, SheetPrograms, ToolNote,
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
    job: &Job,
    legs: &[Leg],
    moved: &PlannedMotion<'_>,
    formats: &[OutputFormat],
) -> Result<Sheets, PipelineError> {
    let shares = shares(job);
    let remarks = remarks(moved, &[]);
    let note =
        Note { remarks: &remarks, budget: &shares, ..note(job, moved.plan.schedule.duration()) };
    let (mut cl, mut setup) = (String::new(), String::new());
    write::apt(&mut cl, legs, &note, CL_DECIMALS)?;
    let axes = AxisWords::of(job.kinematics.machine())?;
    let programs = SheetPrograms { axes, dialects: formats };
    write::setup_sheet(&mut setup, &job.kinematics, &note, programs)?;
    Ok(Sheets { cl, setup })
}

/// Writes the cutter locations alone.
pub(super) fn cutter_locations(job: &Job, legs: &[Leg]) -> Result<String, PipelineError> {
    let mut cl = String::new();
    write::apt(&mut cl, legs, &note(job, 0.0), CL_DECIMALS)?;
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
