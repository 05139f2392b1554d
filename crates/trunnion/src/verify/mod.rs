//! Replay a program as the control would, measure it against the surface, audit the axes.
//!
//! Shares only surface, cutter, machine and `nc::read` with the makers and never calls an inverse,
//! so that a maker's mistake cannot hide in the checker.
//!
//! [`check`] runs a [program](ProgramSource) from the machine's home position: without TCP all axes are linear in
//! a block, with it the tip (table frame, see [`nc`](crate::nc)) and the rotaries. For every point
//! `p` of a grid over the faces it finds the lowest `s` at which the normal `p + s n` meets the tool
//! in any pose of any move, links and rapids included: below 0 a gouge, above 0 excess. A tool that is on the
//! normal only below `p` is behind a wall thinner than the check looks, and gouges, if anything, the face
//! on its other side. That is a minimum over continuous time to a stated tolerance, not over sampled poses
//! (`docs/sources.md`, verification). Moves are taken so many at a time: memory is that of the measured points and
//! of the program's source, [`ProgramText`](crate::nc::read::ProgramText) for a long one.

mod audit;
mod blocks;
mod body;
mod bounds;
mod chunks;
mod control_model;
mod deviation;
mod fixture;
mod grid;
mod index;
mod measure;
mod motion;
mod ray;
mod replay;
mod report;
mod run;
mod stock;
mod sweep;
mod track;
mod vectors;

pub use control_model::{AxisRatio, ModelAudit};
pub use fixture::{Approach, Clearance, Fixture, Watch, clearance, clearance_cl};
pub use motion::{
    AxisMotion, MotionAudit, MotionError, MotionFinding, MotionOptions, MotionReport, MotionRow,
    RowRatio, Unevenness,
};
pub use report::{
    Audit, AxisAudit, Bin, Bounds, Brief, Deviation, Extreme, FaceMap, Finding, Overrun, Ratio,
    Report, Sample, Sensitivity, Singular, Vectors,
};
pub use stock::{Carving, Collision, CollisionKind, Solid, Stock, simulate, simulate_cl};
pub use track::{Track, track, track_cl};

use crate::cutter::Cutter;
use crate::machine::Kinematics;
use crate::nc::read::{ClFile, ProgramSource};
use crate::surface::Face;
use crate::types::{Cancelled, Progress, Rest};
use measure::Subject;
use replay::Control;
use run::Run;

/// What is checked, and against what.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// The program: its steps, or its text where it is long.
    pub program: &'a dyn ProgramSource,
    /// Machine and setup as the control has them: work offset, tool length, pivots.
    pub believed: &'a Kinematics,
    /// Machine and setup as they are; the same, unless an error of either is to be studied.
    pub real: &'a Kinematics,
    /// Faces to be cut, in the workpiece frame.
    pub faces: &'a [Face],
    /// The tool, from tip to gauge point.
    pub cutter: &'a Cutter,
    /// What is known not to be finished: it may be uncut, or more than the tolerance may stand there.
    pub rest: &'a [Rest],
}

/// How finely to look, and what to allow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Largest distance of grid points \[mm\].
    pub grid: f64,
    /// How far to look for the tool along the normal, both ways \[mm\]: what is higher is uncut.
    pub reach: f64,
    /// How exactly heights are found \[mm\]: no tool smaller by a fifth of this gets lower by more
    /// than this. (A tenth each is for motion inside a block and for touches that only graze.)
    pub ray_tolerance: f64,
    /// Largest excess \[mm\].
    pub total: f64,
    /// Deepest gouge \[mm\].
    pub gouge: f64,
    /// Grid points on one face at most.
    pub most_points: usize,
    /// What is to be certain between the grid points, if anything.
    pub promise: Option<Promise>,
}

/// What is to be certain all over the faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Promise {
    /// How far the bounds may be from the worst gouge and the worst excess \[mm\]; less where the
    /// tolerance is kept by less.
    pub margin: [f64; 2],
    /// Whether excess is bounded, too: not on faces that are to be left alone.
    pub excess: bool,
}

/// Why a program cannot be checked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// An option that is not a usable number.
    #[error("option {name} is {value}; it must be {must}")]
    Option {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// The program moves nothing.
    #[error("the program has no moves")]
    NoMotion,
    /// More than one tool.
    #[error(
        "the program calls {count} tools; check the program of each tool alone, which trunnion post --tool writes"
    )]
    Tools {
        /// How many.
        count: usize,
    },
    /// A work offset other than the one the setup defines.
    #[error("line {line}: the setup defines G54 only, not G{number}")]
    WorkOffset {
        /// Line of the program.
        line: u32,
        /// G code without its decimals.
        number: u8,
    },
    /// A step that is read, but not replayed.
    #[error(
        "line {line}: {what} is not replayed; post the program with straight moves of five axes"
    )]
    Special {
        /// Line of the program.
        line: u32,
        /// What it is.
        what: &'static str,
    },
    /// A cut of axes whose places are not known.
    #[error(
        "line {line}: after tool vectors the places of the axes are the control's own choice, and this cut cannot be followed; \
         put a rapid move before it that names X, Y, Z and the tool vector, or all axes"
    )]
    Unfollowed {
        /// Line of the program.
        line: u32,
    },
    /// X, Y and Z do not span space.
    #[error("the linear axes do not reach every position")]
    LinearAxes,
    /// A block that turns so far that its motion cannot be followed.
    #[error("line {line}: the block turns too far to be followed; break it up")]
    TurnsTooFar {
        /// Line of the program.
        line: u32,
    },
    /// Stock or a fixture that cannot be worked with.
    #[error("the solid {what}")]
    Stock {
        /// What is wrong with it.
        what: String,
    },
    /// The grid is too fine.
    #[error("face {face} would have {points:.0} grid points, more than {most}; use a coarser grid")]
    TooManyPoints {
        /// Number of the face.
        face: usize,
        /// Points asked for.
        points: f64,
        /// Points allowed.
        most: usize,
    },
}

/// Checks a program against surface and machine.
///
/// Heights are relative to the faces as given; control smoothing and the speed of rapids beyond
/// their limit are not modelled. From vector to vector ([`Move::axis`](crate::nc::read::Move::axis)) the tip runs
/// straight and the tool axis on the great circle, the machine being as believed; axes are not audited then, see
/// [`Report::vectors`]. A limit broken shows in [`Report::findings`], not as an error.
///
/// # Errors
///
/// [`VerifyError`].
///
/// # Source
///
/// `docs/sources.md`, verification.
pub fn check(
    input: &Input<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Report, VerifyError> {
    check_options(options)?;
    one_tool(input.program.tools())?;
    let control = Control::new(input)?;
    let run = Run::program(&control, input.program, CHORD_SHARE * options.ray_tolerance);
    let vectors = vectors::of(&run, input.program)?;
    let audit = match vectors {
        Some(_) => None,
        None => Some(audit::audit(&control, &run, input)?),
    };
    let subject = Subject { faces: input.faces, cutter: input.cutter, rest: input.rest };
    let (maps, mut deviation) = measure::measure(&run, &subject, options, progress)?;
    deviation.sensitivity.pivot = audit.as_ref().map(measure::pivot);
    let mut findings = left(&maps, &deviation, options);
    findings.extend(audit.iter().flat_map(broken));
    Ok(Report { maps, deviation, audit, vectors, findings })
}

/// Cutter locations, and against what they are checked.
#[derive(Debug, Clone, Copy)]
pub struct ClInput<'a> {
    /// The file, as read from its text.
    pub file: &'a ClFile,
    /// Faces to be cut, in the frame of the locations.
    pub faces: &'a [Face],
    /// The tool, from tip to gauge point.
    pub cutter: &'a Cutter,
    /// What is known not to be finished: it may be uncut, or more than the tolerance may stand there.
    pub rest: &'a [Rest],
}

/// Checks cutter locations against a surface: the tip runs straight, the tool axis on a great circle
/// from one to the next. Axes are not audited: a CL file has none.
///
/// # Errors
///
/// [`VerifyError`].
pub fn check_cl(
    input: &ClInput<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Report, VerifyError> {
    check_options(options)?;
    let run = Run::locations(input.file, CHORD_SHARE * options.ray_tolerance);
    let subject = Subject { faces: input.faces, cutter: input.cutter, rest: input.rest };
    let (maps, deviation) = measure::measure(&run, &subject, options, progress)?;
    let findings = left(&maps, &deviation, options);
    Ok(Report { maps, deviation, audit: None, vectors: None, findings })
}

/// Share of the ray tolerance by which the chords of an arc may be off.
const CHORD_SHARE: f64 = 0.1;

fn one_tool(tools: &[u32]) -> Result<(), VerifyError> {
    let mut tools = tools.to_vec();
    tools.dedup();
    if tools.len() > 1 { Err(VerifyError::Tools { count: tools.len() }) } else { Ok(()) }
}

fn check_options(options: &Options) -> Result<(), VerifyError> {
    let positive = [
        ("grid", options.grid),
        ("reach", options.reach),
        ("ray_tolerance", options.ray_tolerance),
    ];
    for (name, value) in positive {
        if !(value > 0.0 && value.is_finite()) {
            return Err(VerifyError::Option { name, value, must: "a length above 0" });
        }
    }
    for (name, value) in [("total", options.total), ("gouge", options.gouge)] {
        if !(value >= 0.0 && value < options.reach) {
            return Err(VerifyError::Option { name, value, must: "from 0 to below the reach" });
        }
    }
    Ok(())
}

/// What breaks a tolerance. A gouge is judged with the ray tolerance against it.
fn left(maps: &[FaceMap], deviation: &Deviation, options: &Options) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some(low) = deviation.lowest
        && low.height - options.ray_tolerance < -options.gouge
    {
        findings.push(Finding::Gouge(low));
    }
    if let Some(high) = deviation.highest
        && high.height > options.total
    {
        findings.push(Finding::Excess(high));
    }
    let mut uncut = maps.iter().flat_map(|map| &map.samples).flatten();
    if let Some(sample) = uncut.find(|sample| sample.height.is_none() && !sample.rest) {
        let (points, area) = (deviation.uncut, deviation.uncut_area);
        findings.push(Finding::Uncut { points, area, place: sample.point });
    }
    if deviation.unmeasured > 0 {
        findings.push(Finding::Unmeasured { points: deviation.unmeasured });
    }
    findings
}

/// What breaks a limit of an axis.
fn broken(audit: &Audit) -> Vec<Finding> {
    let mut findings = Vec::new();
    for axis in &audit.axes {
        let name = || axis.name.clone();
        if let Some(worst) = axis.travel {
            findings.push(Finding::Travel { axis: name(), worst });
        }
        if axis.velocity.broken > 0 {
            findings.push(Finding::Velocity { axis: name(), worst: axis.velocity });
        }
        if axis.acceleration.broken > 0 {
            findings.push(Finding::Acceleration { axis: name(), worst: axis.acceleration });
        }
    }
    findings
}
