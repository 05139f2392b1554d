//! Programs: blocks, text, and the check of that text.

use super::error::PipelineError;
use super::inner_velocity::InnerVelocity;
use super::job::Job;
use super::measured::{self, CheckedAgainst, WrittenProgram};
use super::operations::OperationMotion;
use super::program::{CheckedProgram, LeftOutProgram, NearMoves, OperationProgram};
use super::program_format::{ProgramFormat, format_of};
use super::sheets::{note, remarks, shares};
use super::solids::Solids;
use super::tolerances::{LINK_TOLERANCE, QUINTIC_SHARE};
use crate::blocks::{self, BlockInterpolation, BlockOptions};
use crate::cover;
use crate::files::job::{JobLinkBlocks, JobPrograms};
use crate::inverse::Inverse;
use crate::nc::write::{
    self, AxisWords, Coordinates, Note, OutputFormat, Remark, Style, Template, ToolSection,
    WriteError,
};
use crate::post::{ReadBackError, WrittenSection, WrittenText, control_of, read_back_sections};
use crate::types::{Block, Diagnostic, Motion, PoseTolerance, Progress, UncutRegion};
use crate::verify::{self, OtherFaces};

/// Longest block \[s\]: a program runs each block at its mean speed, so this bounds its difference from the schedule.
const LONGEST_BLOCK: f64 = 0.05;

/// Shortest block \[s\]: controls read a thousand blocks a second.
const SHORTEST_BLOCK: f64 = 0.001;

/// Largest turn of a rotary axis in a block \[rad\].
const LARGEST_TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Inputs of the programs beside the job.
#[derive(Clone, Copy)]
pub(super) struct ProgramInputs<'a> {
    pub(super) operations: &'a [OperationMotion<'a>],
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
    let ProgramInputs { operations, uncut, solids } = inputs;
    let ProgramTask { format, words, programs } = task;
    let form = format_of(format);
    // Step 1: blocks within tolerance.
    let sections = sections(operations, &form, words, progress)?;
    let rounding = sections.iter().map(|section| section.rounding).fold(0.0, f64::max);
    // Step 2: their text, read back.
    let ProgramText { text, ends, unread } = text(&sections, &form, words)?;
    let parts = parts(job, &sections, &form, words)?;
    let blocks: Vec<Block> = sections.into_iter().flat_map(|section| section.blocks).collect();
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
    let (check, others, carving, clearance, bodies) = match found {
        Some(found) => {
            (Some(found.report), found.others, found.stock, found.clearance, found.bodies)
        }
        None => (None, OtherFaces::default(), None, None, None),
    };
    let written = WrittenText { text: &text, ends: &ends };
    let near = clearance.iter().flat_map(|clearance| &clearance.near).map(|near| near.line);
    let too_near = near_moves(near, &blocks, written);
    let near = bodies.iter().flat_map(|bodies| &bodies.near).map(|near| near.line);
    let bodies_near = near_moves(near, &blocks, written);
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
        bodies,
        parts,
        too_near,
        bodies_near,
    })
}

/// Things that come too near in the programs of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TooNear {
    Nothing,
    /// Bodies of the machine alone.
    Bodies,
    /// The tool and fixtures, whatever the bodies do.
    Fixtures,
}

/// Returns what comes too near in the first program of the job in which something does. The programs are written for that,
/// and not checked against the part.
pub(super) fn too_near(
    job: &Job,
    inputs: ProgramInputs<'_>,
    progress: &dyn Progress,
) -> Result<TooNear, PipelineError> {
    let words = AxisWords::of(job.kinematics.machine())?;
    let ProgramInputs { operations, uncut, solids } = inputs;
    for &format in &job.file.dialects {
        let form = format_of(format);
        let sections = sections(operations, &form, words, progress)?;
        let ProgramText { text, .. } = text(&sections, &form, words)?;
        let written = WrittenProgram { form: &form, text: &text, axes: words };
        let against = CheckedAgainst { rest: uncut, solids };
        let found = measured::motion(job, &written, &against, progress)?;
        if found.clearance.iter().any(|fixtures| !fixtures.near.is_empty()) {
            return Ok(TooNear::Fixtures);
        }
        if found.bodies.iter().any(|bodies| !bodies.near.is_empty()) {
            return Ok(TooNear::Bodies);
        }
    }
    Ok(TooNear::Nothing)
}

/// Writes a program for each of several operations if the job asks for it, and reads each back.
fn parts(
    job: &Job,
    sections: &[OperationBlocks<'_>],
    form: &ProgramFormat,
    words: AxisWords,
) -> Result<Vec<OperationProgram>, PipelineError> {
    if job.file.programs == JobPrograms::One || sections.len() < 2 {
        return Ok(Vec::new());
    }
    let part = |section: &OperationBlocks<'_>| {
        let ProgramText { text, .. } = text(std::slice::from_ref(section), form, words)?;
        let number = section.job.index + 1;
        Ok(OperationProgram {
            operation: section.job.name.clone(),
            file: form.file.replacen("program", &format!("program-{number}"), 1),
            text,
            blocks: section.blocks.len(),
        })
    };
    sections.iter().map(part).collect()
}

fn options(job: &Job, control: BlockInterpolation) -> BlockOptions {
    BlockOptions {
        control,
        // The quintic axis path has taken its share twice: for the tip and for the tool axis.
        tolerance: (1.0 - 2.0 * QUINTIC_SHARE) * job.budget.shares.linearisation,
        link_tolerance: link_tolerance(job),
        lever: cover::lever(&job.cutter),
        max_step: f64::INFINITY,
        max_turn: LARGEST_TURN,
        max_axis_turn: f64::INFINITY,
        max_duration: LONGEST_BLOCK,
        min_duration: SHORTEST_BLOCK,
    }
}

/// Tolerance of the blocks of links \[mm\].
fn link_tolerance(job: &Job) -> f64 {
    match job.file.link_blocks {
        JobLinkBlocks::Long => LINK_TOLERANCE,
        // Corners of chords are rounded to the curve again where what rounds them reaches three of them: its deviation is
        // five thirds of the chords' then.
        JobLinkBlocks::Short => (0.5 * job.budget.shares.control).min(LINK_TOLERANCE),
    }
}

/// Blocks of one operation, with the remarks among them.
struct OperationBlocks<'a> {
    job: &'a Job,
    blocks: Vec<Block>,
    remarks: Vec<Remark>,
    /// Planned time, with what blocks are slowed by \[s\].
    duration: f64,
    /// Bound on the effect of rounding \[mm\].
    rounding: f64,
}

/// Breaks the motion of each operation into blocks.
fn sections<'a>(
    operations: &[OperationMotion<'a>],
    form: &ProgramFormat,
    words: AxisWords,
    progress: &dyn Progress,
) -> Result<Vec<OperationBlocks<'a>>, PipelineError> {
    operations.iter().map(|of| section(of, form, words, progress)).collect()
}

/// Breaks the motion of an operation into blocks.
fn section<'a>(
    operation: &OperationMotion<'a>,
    form: &ProgramFormat,
    words: AxisWords,
    progress: &dyn Progress,
) -> Result<OperationBlocks<'a>, PipelineError> {
    let (job, motion) = (operation.job, operation.motion());
    let path = &motion.followed.path;
    let schedule = &motion.plan.schedule;
    let control = control_of(&job.kinematics, form.dialect);
    let options = options(job, control);
    let pieces = blocks::by_piece(&job.kinematics, path, schedule, &options, progress)?;
    let remarks = remarks(&motion, &pieces);
    let mut blocks: Vec<Block> = pieces.into_iter().flatten().collect();
    // A path that was followed has an inverse.
    let slowed = Inverse::new(&job.kinematics)
        .map_or(0.0, |inverse| InnerVelocity { inverse: &inverse, control }.slow(&mut blocks));
    let rounding = rounding(job, &blocks, &words, form.dialect.coordinates());
    let share = job.budget.shares.rounding;
    if rounding > share {
        return Err(PipelineError::Rounding { file: form.file, rounding, share });
    }
    let duration = schedule.duration() + slowed;
    Ok(OperationBlocks { job, blocks, remarks, duration, rounding })
}

/// Bounds the cutter movement caused by rounding while the tool cuts; elsewhere it is clear of the part.
fn rounding(job: &Job, blocks: &[Block], words: &AxisWords, coordinates: Coordinates) -> f64 {
    let lever = cover::lever(&job.cutter);
    let of = |block: &Block| write::rounding(&job.kinematics, &block.q, words, coordinates, lever);
    blocks.iter().filter(|block| block.motion.is_cut()).map(of).fold(0.0, f64::max)
}

/// Text of a program.
struct ProgramText {
    text: String,
    /// Ends of the texts of its blocks.
    ends: Vec<usize>,
    /// First text that the reader does not understand.
    unread: Option<Diagnostic>,
}

/// Returns the kinds of moves on some lines.
fn near_moves(
    lines: impl Iterator<Item = u32>,
    blocks: &[Block],
    written: WrittenText<'_>,
) -> NearMoves {
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
    lines.fold(NearMoves::default(), |near, line| {
        let links = is_link(line);
        near.or(NearMoves { links, cuts: !links })
    })
}

/// Writes the text of a program and reads it back.
fn text(
    operations: &[OperationBlocks<'_>],
    form: &ProgramFormat,
    axes: AxisWords,
) -> Result<ProgramText, PipelineError> {
    let job = operations.first().ok_or(WriteError::Empty)?.job;
    // The control may smooth by its share at the tip, and by the angle that moves the contact as far.
    let smoothing = |of: &OperationBlocks<'_>| {
        let control = of.job.budget.shares.control;
        PoseTolerance::new(control, control / cover::lever(&of.job.cutter))
    };
    // One word allows it for all operations.
    let blend = operations
        .iter()
        .map(smoothing)
        .reduce(|a, b| PoseTolerance::new(a.tip.min(b.tip), a.axis.min(b.axis)));
    let style = Style { blend, ..Style::of(&job.kinematics, form.dialect, axes) };
    let template = Template::of(form.dialect).map_err(WriteError::from)?;
    let shares = shares(job);
    // The head of the program is about all operations; the changes of tool about their own.
    let total = operations.iter().map(|of| of.duration).sum();
    let duration_of =
        |of: &OperationBlocks<'_>| if of.job.index == job.index { total } else { of.duration };
    let notes: Vec<Note<'_>> = operations
        .iter()
        .map(|of| Note { remarks: &of.remarks, budget: &shares, ..note(of.job, duration_of(of)) })
        .collect();
    let sections: Vec<ToolSection<'_>> = operations
        .iter()
        .zip(&notes)
        .map(|(of, note)| ToolSection { kinematics: &of.job.kinematics, note, blocks: &of.blocks })
        .collect();
    let mut text = String::new();
    let ends = write::sections(&mut text, &sections, &style, &template)?;
    let written: Vec<WrittenSection<'_>> = sections
        .iter()
        .zip(&ends)
        .map(|(of, ends)| WrittenSection { kinematics: of.kinematics, blocks: of.blocks, ends })
        .collect();
    let read = read_back_sections(&style, &written, &text);
    let ends = ends.into_iter().flatten().collect();
    match read {
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
