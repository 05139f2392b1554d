//! Programs: blocks, text, and the check of that very text.

use super::error::PipelineError;
use super::job::Job;
use super::material::Solids;
use super::measured::{self, CheckedAgainst, WrittenProgram};
use super::retracts;
use super::stages::QUINTIC_SHARE;
use crate::axes::FollowedPath;
use crate::blocks::{self, BlockInterpolation, BlockOptions};
use crate::cover;
use crate::feed::FeedPlan;
use crate::files::job as file;
use crate::files::summary::{RetractSummary, SingularSummary};
use crate::import::inspect;
use crate::inverse::Inverse;
use crate::machine::Kinematics;
use crate::nc::write::{
    self, AxisWords, Coordinates, Dialect, Note, Remark, Style, Template, ToolNote, WriteError,
};
use crate::post::{ReadBackError, WrittenText, control_of, read_back};
use crate::surface::FaceIndex;
use crate::types::{Block, Diagnostic, Leg, Motion, Progress, ToolPose, UncutRegion};
use crate::verify::{self, ClearanceReport, CutStock, OtherFaces};
use nalgebra::{Point3, Rotation3, Vector3};

/// Decimals of cutter locations \[mm\].
const CL_DECIMALS: u8 = 6;

/// Longest block \[s\]: a program runs at block-mean speed, and follows the schedule this closely.
const LONGEST_BLOCK: f64 = 0.05;

/// Shortest block \[s\]: controls read a thousand blocks a second.
const SHORTEST_BLOCK: f64 = 0.001;

/// Largest turn of a rotary axis in a block \[rad\].
const LARGEST_TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Deviation on links, far from the part \[mm\].
pub(super) const LINK_TOLERANCE: f64 = 1.0;

/// A program and what its check found.
#[derive(Debug)]
pub struct Program {
    /// Name of the dialect.
    pub dialect: &'static str,
    /// File name.
    pub file: &'static str,
    /// The program.
    pub text: String,
    /// What it says, block by block.
    pub blocks: Vec<Block>,
    /// Bound on what rounding its words does at the cutter \[mm\].
    pub rounding: f64,
    /// Every block was read back from the text and found to say what was meant, unless there is something here: the
    /// first words that the reader does not understand, such as strings of the machine file.
    pub unread: Option<Diagnostic>,
    /// What replaying the text found; `None` where another program has the same blocks.
    pub check: Option<verify::Report>,
    /// Dialect of the program with the same blocks, whose check holds for this one, too.
    pub same_as: Option<&'static str>,
    /// Result on the faces that are not cut. Its finding, if there is one, is among those of the check.
    pub others: OtherFaces,
    /// What it does to the stock of the job and what is left of it; `None` without stock, or where another program has
    /// the same blocks.
    pub carving: Option<CutStock>,
    /// How near it comes to the fixtures of the job; `None` without any, or where another program has the same blocks.
    pub clearance: Option<ClearanceReport>,
    /// Whether links, and whether cuts or their leads, come nearer to a fixture than asked for.
    pub too_near: [bool; 2],
}

/// What tells the dialects apart here.
pub(super) struct Form {
    pub(super) dialect: Dialect,
    pub(super) file: &'static str,
}

fn form(dialect: file::Dialect) -> Form {
    let (dialect, file) = match dialect {
        file::Dialect::LinuxCnc => (Dialect::LinuxCnc, "program.linuxcnc.ngc"),
        file::Dialect::G93 => (Dialect::G93, "program.g93.nc"),
        file::Dialect::Fanuc => (Dialect::Fanuc, "program.fanuc.nc"),
        file::Dialect::FanucVector => (Dialect::FanucVector, "program.fanuc-vector.nc"),
        file::Dialect::Haas => (Dialect::Haas, "program.haas.nc"),
        file::Dialect::Siemens => (Dialect::Siemens, "program.siemens.mpf"),
        file::Dialect::SiemensAxes => (Dialect::SiemensAxes, "program.siemens-axes.mpf"),
        file::Dialect::Heidenhain => (Dialect::Heidenhain, "program.heidenhain.h"),
        file::Dialect::HeidenhainAxes => (Dialect::HeidenhainAxes, "program.heidenhain-axes.h"),
    };
    Form { dialect, file }
}

/// The machine's motion, planned.
#[derive(Clone, Copy)]
pub(super) struct Moved<'a> {
    pub(super) followed: &'a FollowedPath,
    pub(super) plan: &'a FeedPlan,
    pub(super) retracts: &'a [RetractSummary],
    pub(super) singular: Option<SingularSummary>,
}

/// Writes every program of the job and checks what was written.
pub(super) fn write(
    job: &Job,
    (moved, rest, solids): (&Moved<'_>, &[UncutRegion], &Solids),
    progress: &dyn Progress,
) -> Result<Vec<Program>, PipelineError> {
    let words = AxisWords::of(job.kinematics.machine(), false)?;
    let mut programs: Vec<Program> = Vec::new();
    for &dialect in &job.file.dialects {
        let form = form(dialect);
        let (path, schedule) = (&moved.followed.path, &moved.plan.schedule);
        let options = options(job, control_of(&job.kinematics, form.dialect));
        let pieces = blocks::by_piece(&job.kinematics, path, schedule, &options, progress)?;
        let remarks = remarks(moved, &pieces);
        let blocks: Vec<Block> = pieces.into_iter().flatten().collect();
        let rounding = rounding(job, &blocks, &words, form.dialect.coordinates());
        let share = job.budget.shares.rounding;
        if rounding > share {
            return Err(PipelineError::Rounding { file: form.file, rounding, share });
        }
        let Written { text, ends, unread } = text(job, &form, &blocks, words, (moved, &remarks))?;
        let timed = measured::is_timed(form.dialect);
        let measured = |other: &&Program| {
            let holds = |check: &verify::Report| !timed || check.audit.is_some();
            other.check.as_ref().is_some_and(holds) && other.blocks == blocks
        };
        let same_as = programs.iter().find(measured).map(|other| other.dialect);
        let found = if same_as.is_none() {
            let written = WrittenProgram { form: &form, text: &text, axes: words };
            let against = CheckedAgainst { rest, solids };
            Some(measured::run(job, &written, &against, progress)?)
        } else {
            None
        };
        let (check, others, carving, clearance) = match found {
            Some(found) => (Some(found.report), found.others, found.stock, found.clearance),
            None => (None, OtherFaces::default(), None, None),
        };
        let too_near = too_near(clearance.as_ref(), &blocks, (&text, &ends));
        let Form { dialect, file } = form;
        let program = Program {
            dialect: dialect.name(),
            file,
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
        };
        programs.push(program);
    }
    Ok(programs)
}

fn options(job: &Job, control: BlockInterpolation) -> BlockOptions {
    BlockOptions {
        control,
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

/// Tilts of the tool about the mean normal at which the rounding is tried beforehand \[rad\].
const TILTS: [f64; 3] = [-0.35, 0.0, 0.35];

/// What rounding the words of the job's programs will do at the cutter, found before there is a path
/// \[mm\]: the worst of tilted tools at the corners of the part. 0 if no such pose is within reach.
pub(super) fn expected_rounding(
    kinematics: &Kinematics,
    faces: &[FaceIndex],
    dialects: &[file::Dialect],
    lever: f64,
) -> f64 {
    let (Ok(inverse), Ok(words)) =
        (Inverse::new(kinematics), AxisWords::of(kinematics.machine(), false))
    else {
        return 0.0;
    };
    let home = kinematics.machine().home();
    let of = |pose: ToolPose| {
        let q = inverse.near(&pose, &home).ok()?;
        let bound = |&dialect: &file::Dialect| {
            write::rounding(kinematics, &q, &words, form(dialect).dialect.coordinates(), lever)
        };
        dialects.iter().map(bound).reduce(f64::max)
    };
    faces.iter().flat_map(poses).filter_map(of).fold(0.0, f64::max)
}

/// Tools at the corners of a face's box, about its mean normal.
fn poses(face: &FaceIndex) -> Vec<ToolPose> {
    let summary = inspect::summary(face.face());
    let normal = summary.normal.unwrap_or_else(Vector3::z_axis);
    let [low, high] = summary.bounds;
    let mut poses = Vec::new();
    for corner in 0..8_u32 {
        let pick = |axis: u32| if corner >> axis & 1 == 0 { low } else { high };
        let tip = Point3::new(pick(0).x, pick(1).y, pick(2).z);
        for [x, y] in TILTS.iter().flat_map(|&x| TILTS.map(|y| [x, y])) {
            poses.push(ToolPose { tip, axis: Rotation3::from_euler_angles(x, y, 0.0) * normal });
        }
    }
    poses
}

/// Bound on what rounding does while the tool cuts; elsewhere it is clear of the part.
fn rounding(job: &Job, blocks: &[Block], words: &AxisWords, coordinates: Coordinates) -> f64 {
    let lever = cover::lever(&job.cutter);
    let of = |block: &Block| write::rounding(&job.kinematics, &block.q, words, coordinates, lever);
    blocks.iter().filter(|block| block.motion == Motion::Cut).map(of).fold(0.0, f64::max)
}

/// A program as it was written.
struct Written {
    text: String,
    /// Ends of the texts of its blocks.
    ends: Vec<usize>,
    /// What of it is not understood.
    unread: Option<Diagnostic>,
}

/// Whether links, and whether cuts or their leads, are among the lines that come too near a fixture.
fn too_near(
    clearance: Option<&ClearanceReport>,
    blocks: &[Block],
    (text, ends): (&str, &[usize]),
) -> [bool; 2] {
    let after = text.match_indices('\n').map(|(at, _)| at + 1);
    let starts: Vec<usize> = std::iter::once(0).chain(after).collect();
    let is_link = |line: u32| {
        let start = starts.get((line as usize).saturating_sub(1)).copied().unwrap_or(text.len());
        let block = blocks.get(ends.partition_point(|&end| end <= start));
        // Behind the last block the tool goes home.
        block.is_none_or(|block| matches!(block.motion, Motion::Link | Motion::Hop))
    };
    let near = || clearance.iter().flat_map(|clearance| &clearance.near);
    [near().any(|near| is_link(near.line)), near().any(|near| !is_link(near.line))]
}

fn text(
    job: &Job,
    form: &Form,
    blocks: &[Block],
    axes: AxisWords,
    (moved, remarks): (&Moved<'_>, &[Remark]),
) -> Result<Written, PipelineError> {
    let control = job.budget.shares.control;
    let blend = Some([control, control / cover::lever(&job.cutter)]);
    let style = Style { blend, ..Style::of(&job.kinematics, form.dialect, axes) };
    let template = Template::of(form.dialect).map_err(WriteError::from)?;
    let shares = shares(job);
    let note = Note { remarks, ..note(job, &shares, moved.plan.schedule.duration()) };
    let mut text = String::new();
    let ends = write::program(&mut text, &job.kinematics, blocks, (&note, &style, &template))?;
    match read_back(&job.kinematics, &style, blocks, WrittenText { text: &text, ends: &ends }) {
        Ok(()) => Ok(Written { text, ends, unread: None }),
        Err(ReadBackError::Unread(faults)) => {
            Ok(Written { text, ends, unread: faults.into_iter().next() })
        }
        Err(ReadBackError::Differs { line, what }) => {
            Err(PipelineError::Differs { file: form.file, line, what })
        }
    }
}

/// Cutter locations and setup sheet.
pub(super) fn sheets(
    job: &Job,
    legs: &[Leg],
    moved: &Moved<'_>,
) -> Result<(String, String), PipelineError> {
    let shares = shares(job);
    let remarks = remarks(moved, &[]);
    let note = Note { remarks: &remarks, ..note(job, &shares, moved.plan.schedule.duration()) };
    let (mut cl, mut setup) = (String::new(), String::new());
    write::apt(&mut cl, legs, &note, CL_DECIMALS)?;
    let words = AxisWords::of(job.kinematics.machine(), false)?;
    write::setup_sheet(&mut setup, &job.kinematics, &note, words)?;
    Ok((cl, setup))
}

/// Cutter locations alone.
pub(super) fn cutter_locations(job: &Job, legs: &[Leg]) -> Result<String, PipelineError> {
    let mut cl = String::new();
    write::apt(&mut cl, legs, &note(job, &[], 0.0), CL_DECIMALS)?;
    Ok(cl)
}

/// A line for each retract, before the first block of its first piece.
fn remarks(moved: &Moved<'_>, pieces: &[Vec<Block>]) -> Vec<Remark> {
    let before = |piece: usize| pieces.iter().take(piece + 1).map(Vec::len).sum();
    let all = moved.followed.retracts.iter().zip(moved.retracts);
    all.map(|(retracted, summary)| Remark {
        block: before(retracted.pieces.start),
        text: retracts::line(summary),
    })
    .collect()
}

fn note<'a>(job: &'a Job, budget: &'a [(String, f64)], duration: f64) -> Note<'a> {
    Note {
        name: &job.file.name,
        tool: ToolNote {
            number: job.file.tool.number,
            major: job.cutter.major(),
            minor: job.cutter.minor(),
        },
        spindle: job.file.cutting.spindle_rpm(),
        coolant: job.file.cutting.coolant,
        feed: job.file.cutting.feed,
        budget,
        duration,
        remarks: &[],
    }
}

fn shares(job: &Job) -> Vec<(String, f64)> {
    job.budget.lines().map(|(name, value)| (name.to_owned(), value)).collect()
}
