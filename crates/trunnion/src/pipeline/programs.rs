//! Programs: blocks, text, and the check of that text.

use super::error::PipelineError;
use super::job::Job;
use super::measured::{self, CheckedAgainst, WrittenProgram};
use super::planned_motion::PlannedMotion;
use super::program::{CheckedProgram, LeftOutProgram};
use super::program_format::{ProgramFormat, format_of};
use super::sheets::{note, remarks, shares};
use super::solids::Solids;
use super::tolerances::{LINK_TOLERANCE, QUINTIC_SHARE};
use crate::blocks::{self, BlockInterpolation, BlockOptions};
use crate::cover;
use crate::nc::write::{
    self, AxisWords, Coordinates, Note, OutputFormat, Remark, Style, Template, WriteError,
};
use crate::post::{ReadBackError, WrittenText, control_of, read_back};
use crate::types::{Block, Diagnostic, Motion, PoseTolerance, Progress, UncutRegion};
use crate::verify::{self, ClearanceReport, OtherFaces};

/// Longest block \[s\]: a program runs each block at its mean speed, so this bounds its difference from the schedule.
const LONGEST_BLOCK: f64 = 0.05;

/// Shortest block \[s\]: controls read a thousand blocks a second.
const SHORTEST_BLOCK: f64 = 0.001;

/// Largest turn of a rotary axis in a block \[rad\].
const LARGEST_TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Inputs of the programs beside the job.
#[derive(Clone, Copy)]
pub(super) struct ProgramInputs<'a> {
    pub(super) motion: &'a PlannedMotion<'a>,
    /// Regions that stay uncut, which the check does not report again.
    pub(super) uncut: &'a [UncutRegion],
    pub(super) solids: &'a Solids,
}

/// Programs of a job.
#[derive(Default)]
pub(super) struct Programs {
    pub(super) checked: Vec<CheckedProgram>,
    pub(super) left_out: Vec<LeftOutProgram>,
}

/// Writes every program of the job and checks the written text. One that fails is left out; the others go on.
///
/// # Errors
///
/// [`PipelineError::Words`] for a machine without words, [`PipelineError::Cancelled`].
pub(super) fn write(
    job: &Job,
    inputs: ProgramInputs<'_>,
    progress: &dyn Progress,
) -> Result<Programs, PipelineError> {
    let words = AxisWords::of(job.kinematics.machine())?;
    let mut programs = Programs::default();
    for &format in &job.file.dialects {
        match one(job, inputs, ProgramTask { format, words, programs: &programs.checked }, progress)
        {
            Ok(program) => programs.checked.push(program),
            Err(stop @ PipelineError::Cancelled(_)) => return Err(stop),
            Err(why) => {
                let (file, why) = (format.program_file(), Box::new(why));
                programs.left_out.push(LeftOutProgram { format, file, why });
            }
        }
    }
    Ok(programs)
}

/// Program to write.
#[derive(Clone, Copy)]
struct ProgramTask<'a> {
    format: OutputFormat,
    words: AxisWords,
    /// Programs that were checked before.
    programs: &'a [CheckedProgram],
}

/// Writes a program and checks the written text.
fn one(
    job: &Job,
    inputs: ProgramInputs<'_>,
    task: ProgramTask<'_>,
    progress: &dyn Progress,
) -> Result<CheckedProgram, PipelineError> {
    let ProgramInputs { motion, uncut, solids } = inputs;
    let ProgramTask { format, words, programs } = task;
    let form = format_of(format);
    // Step 1: blocks within tolerance.
    let path = &motion.followed.path;
    let schedule = &motion.plan.schedule;
    let options = options(job, control_of(&job.kinematics, form.dialect));
    let pieces = blocks::by_piece(&job.kinematics, path, schedule, &options, progress)?;
    let remarks = remarks(motion, &pieces);
    let blocks: Vec<Block> = pieces.into_iter().flatten().collect();
    let rounding = rounding(job, &blocks, &words, form.dialect.coordinates());
    let share = job.budget.shares.rounding;
    if rounding > share {
        return Err(PipelineError::Rounding { file: form.file, rounding, share });
    }
    // Step 2: their text, read back.
    let head = ProgramRemarks { duration: schedule.duration(), remarks: &remarks };
    let ProgramText { text, ends, unread } = text(job, &form, &blocks, words, head)?;
    // Step 3: its check, unless a program with the same blocks was checked.
    let timed = measured::is_timed(form.dialect);
    let measured = |other: &&CheckedProgram| {
        // A check without times has not judged the axes: it cannot stand for a timed program.
        let holds = |check: &verify::Report| !timed || check.audit.is_some();
        other.check.as_ref().is_some_and(holds) && other.blocks == blocks
    };
    let same_as = programs.iter().find(measured).map(|other| other.dialect);
    let found = if same_as.is_none() {
        let written = WrittenProgram { form: &form, text: &text, axes: words };
        let against = CheckedAgainst { rest: uncut, solids };
        Some(measured::run(job, &written, &against, progress)?)
    } else {
        None
    };
    let (check, others, carving, clearance) = match found {
        Some(found) => (Some(found.report), found.others, found.stock, found.clearance),
        None => (None, OtherFaces::default(), None, None),
    };
    let written = WrittenText { text: &text, ends: &ends };
    let too_near = too_near(clearance.as_ref(), &blocks, written);
    Ok(CheckedProgram {
        dialect: form.dialect.name(),
        file: form.file,
        text,
        blocks,
        rounding,
        unread,
        check,
        same_as,
        others,
        carving,
        clearance,
        too_near,
    })
}

fn options(job: &Job, control: BlockInterpolation) -> BlockOptions {
    BlockOptions {
        control,
        // The quintic axis path has taken its share twice: for the tip and for the tool axis.
        tolerance: (1.0 - 2.0 * QUINTIC_SHARE) * job.budget.shares.linearisation,
        link_tolerance: LINK_TOLERANCE,
        lever: cover::lever(&job.cutter),
        max_step: f64::INFINITY,
        max_turn: LARGEST_TURN,
        max_axis_turn: f64::INFINITY,
        max_duration: LONGEST_BLOCK,
        min_duration: SHORTEST_BLOCK,
    }
}

/// Bounds the cutter movement caused by rounding while the tool cuts; elsewhere it is clear of the part.
fn rounding(job: &Job, blocks: &[Block], words: &AxisWords, coordinates: Coordinates) -> f64 {
    let lever = cover::lever(&job.cutter);
    let of = |block: &Block| write::rounding(&job.kinematics, &block.q, words, coordinates, lever);
    blocks.iter().filter(|block| block.motion == Motion::Cut).map(of).fold(0.0, f64::max)
}

/// Text of a program.
struct ProgramText {
    text: String,
    /// Ends of the texts of its blocks.
    ends: Vec<usize>,
    /// First text that the reader does not understand.
    unread: Option<Diagnostic>,
}

/// Returns true for links, and for cuts or their leads, among the lines that come too near a fixture.
fn too_near(
    clearance: Option<&ClearanceReport>,
    blocks: &[Block],
    written: WrittenText<'_>,
) -> [bool; 2] {
    let WrittenText { text, ends } = written;
    let after = text.match_indices('\n').map(|(at, _)| at + 1);
    let starts: Vec<usize> = std::iter::once(0).chain(after).collect();
    let is_link = |line: u32| {
        let start = starts.get((line as usize).saturating_sub(1)).copied().unwrap_or(text.len());
        // The first block whose text ends behind the start of the line.
        let block = blocks.get(ends.partition_point(|&end| end <= start));
        // After the last block the tool goes home.
        block.is_none_or(|block| matches!(block.motion, Motion::Link | Motion::Hop))
    };
    let near = || clearance.iter().flat_map(|clearance| &clearance.near);
    [near().any(|near| is_link(near.line)), near().any(|near| !is_link(near.line))]
}

/// Duration and remarks at the head of a program.
#[derive(Clone, Copy)]
struct ProgramRemarks<'a> {
    duration: f64,
    remarks: &'a [Remark],
}

/// Writes the text of a program and reads it back.
fn text(
    job: &Job,
    form: &ProgramFormat,
    blocks: &[Block],
    axes: AxisWords,
    head: ProgramRemarks<'_>,
) -> Result<ProgramText, PipelineError> {
    let control = job.budget.shares.control;
    // The control may smooth by its share at the tip, and by the angle that moves the contact as far.
    let blend = Some(PoseTolerance::new(control, control / cover::lever(&job.cutter)));
    let style = Style { blend, ..Style::of(&job.kinematics, form.dialect, axes) };
    let template = Template::of(form.dialect).map_err(WriteError::from)?;
    let shares = shares(job);
    let note = Note { remarks: head.remarks, budget: &shares, ..note(job, head.duration) };
    let mut text = String::new();
    let written = write::ProgramForm { note: &note, style: &style, template: &template };
    let ends = write::program(&mut text, &job.kinematics, blocks, written)?;
    match read_back(&job.kinematics, &style, blocks, WrittenText { text: &text, ends: &ends }) {
        Ok(()) => Ok(ProgramText { text, ends, unread: None }),
        // Strings of the machine file may be unknown to the reader: a warning, not an error.
        Err(ReadBackError::Unread(faults)) => {
            Ok(ProgramText { text, ends, unread: faults.into_iter().next() })
        }
        Err(ReadBackError::Differs { line, what }) => {
            Err(PipelineError::Differs { file: form.file, line, what })
        }
    }
}
