//! Replay a program as the control would, measure it against the surface, audit the axes.
//!
//! Shares only surface, cutter, machine and `nc::read` with the makers and never calls their inverse (where a program tells
//! a direction, `turns` has its own), so that a maker's mistake cannot hide in the checker.
//!
//! [`check`] runs a [program](ProgramSource) from the machine's home position: without TCP all axes are linear in
//! a block, with it the tip (table frame, see [`nc`](crate::nc)) and the rotaries. For every point
//! `p` of a grid over the faces it finds the lowest `s` at which the normal `p + s n` meets the tool
//! in any pose of any cut: below 0 a gouge, above 0 excess. Rapids gouge likewise, with all axes together and with each at
//! its own speed; what they cut is not counted on. A tool that is on the
//! normal only below `p` is behind a wall thinner than the check looks, and gouges, if anything, the face
//! on its other side. That is a minimum over continuous time to a stated tolerance, not over sampled poses
//! (`docs/sources.md`, verification). Moves are taken so many at a time: memory is that of the measured points and
//! of the program's source, [`ProgramText`](crate::nc::read::ProgramText) for a long one.

mod audit;
mod blocks;
mod control_model;
mod deviation;
mod fixture;
mod inner;
mod known;
mod ledger;
mod motion;
mod place;
mod replay;
mod report;
mod run;
mod stock;
mod swept;
mod tools;
mod track;
mod turns;

pub use control_model::{AxisRatio, ModelAudit};
pub use deviation::side::{behind, behind_cl};
pub use fixture::{
    ClearanceOptions, ClearanceReport, DEPTH_SHARE, Fixture, FixtureApproach, clearance,
    clearance_cl,
};
pub use ledger::Lines;
pub use motion::{
    AxisMotion, MotionAudit, MotionError, MotionFinding, MotionOptions, MotionReport, MotionRow,
    RowRatio, Unevenness,
};
pub use report::{
    Audit, AxisAudit, Bin, Bounds, Brief, Deviation, Extreme, FaceMap, Finding, Overrun, Ratio,
    Report, Sample, Sensitivity, Singular,
};
pub use stock::{
    Collision, CollisionKind, Solid, Stock, StockOptions, StockReport, UndecidedCollision,
    simulate, simulate_cl,
};
pub use tools::{Changes, Tables, Tool, WorkOffset};
pub use track::{Track, track, track_cl};
pub use turns::{Choice, Choices};

use crate::cutter::Cutter;
use crate::machine::Kinematics;
use crate::nc::read::{ClSource, ProgramSource};
use crate::surface::Face;
use crate::types::{Cancelled, Progress, UncutRegion};
use audit::Audited;
use deviation::measure::{self, MeasureSubject};
use run::Run;
use tools::Controls;

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
    pub rest: &'a [UncutRegion],
    /// More tools and work offsets than those of the setup.
    pub tables: Tables<'a>,
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

/// Material higher than this counts as uncut, unless a tolerance is not far below it \[mm\].
const REACH: f64 = 1.0;
/// Shares of the tolerances of excess and of gouges by which a ray may miss the swept cutter: a gouge is judged with
/// it against it.
const RAY_SHARES: [f64; 2] = [0.005, 0.05];
/// Gouges up to this are nobody's \[mm\]: the words of a program that touches a face round its tool into it. Words of
/// X Y Z with four decimals, the most that controls take in mm, are off by `sqrt(3) * 0.00005` together.
pub const LEAST_GOUGE: f64 = 1e-4;
/// Shares of the same by which what is certain between the measured points may lie beyond the worst of them.
const MARGIN_SHARES: [f64; 2] = [0.05, 0.5];
/// Most grid points on one face.
const MOST_POINTS: usize = 20_000_000;

impl Options {
    /// How finely to look where excess and gouges have these tolerances, points being `grid` apart \[mm\]. A gouge
    /// is allowed to be [`LEAST_GOUGE`] deep in any case.
    pub fn of_tolerance([total, gouge]: [f64; 2], grid: f64) -> Self {
        let gouge = gouge.max(LEAST_GOUGE);
        let finer = |[share, of_gouge]: [f64; 2]| (of_gouge * gouge).min(share * total);
        let margin = [finer(MARGIN_SHARES), MARGIN_SHARES[0] * total];
        Self {
            grid,
            reach: REACH.max(2.0 * total).max(2.0 * gouge),
            ray_tolerance: finer(RAY_SHARES),
            total,
            gouge,
            most_points: MOST_POINTS,
            promise: Some(Promise { margin, excess: true }),
        }
    }
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
    /// More than one tool, and no table of them.
    #[error(
        "line {line}: tool {} after tool {}: say what each is, --cutter {}=R=..,r=.. and --tool-length {}=L, and so on", numbers[1], numbers[0], numbers[0], numbers[0]
    )]
    Tools {
        /// Line of the program.
        line: u32,
        /// The first, and that of the line.
        numbers: [u32; 2],
    },
    /// A tool that the table does not have.
    #[error(
        "line {line}: tool {number} is not known; say what it is: --cutter {number}=R=..,r=.. --tool-length {number}=L"
    )]
    UnknownTool {
        /// Line of the program.
        line: u32,
        /// What the program calls it.
        number: u32,
    },
    /// A cut before the first of several tools.
    #[error(
        "line {line}: a move before the program calls a tool; call it before (T.. M6, TOOL CALL, LOADTL)"
    )]
    NoTool {
        /// Line of the program.
        line: u32,
    },
    /// A work offset that the table does not have.
    #[error("line {line}: work offset {} is not known; say where it is, --offset {}=X,Y,Z, or that it is where G54 is, --offset {}=G54", tools::name(*number), tools::plain_name(*number), tools::plain_name(*number))]
    WorkOffset {
        /// Line of the program.
        line: u32,
        /// 0 for `G54`, 1 for `G55` and so on.
        number: u8,
    },
    /// A work offset that the program writes in a way that is not followed.
    #[error(
        "line {line}: {what} is not followed; write X, Y and Z of the offset as axis positions (G10 L2), and rotaries as 0"
    )]
    Offset {
        /// Line of the program.
        line: u32,
        /// What it is.
        what: &'static str,
    },
    /// A direction that no position of the rotaries gives the tool.
    #[error("line {line}: no position of the rotary axes turns the tool along {:.6}, {:.6}, {:.6} (workpiece); check the vector or plane, and machine and rotation of the setup", axis[0], axis[1], axis[2])]
    OutOfReach {
        /// Line of the program.
        line: u32,
        /// Tool axis, workpiece frame.
        axis: [f64; 3],
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
    /// A cut from a place that is not known.
    #[error(
        "line {line}: where X, Y and Z stand after the tool change is the machine's own, and this cut cannot be followed; \
         put rapid moves before it that name X, Y and Z"
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
/// their limit are not modelled. Rapids are looked at for gouges, with all axes together and with each at its own speed:
/// a control does the one or the other; a place that only they finish is [`Finding::Rapid`]. Where the program tells a direction of the tool and not the rotaries, they turn the way
/// [`Choice`] says. Behind a tool change nothing is measured until X, Y and Z are told, see [`Changes`]. A limit broken
/// shows in [`Report::findings`], not as an error.
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
    let controls = controls(input)?;
    let run = Run::program(
        &controls,
        (input.program, &input.tables),
        CHORD_SHARE * options.ray_tolerance,
    );
    let Audited { audit, choices, changes } = audit::audit(&controls, &run, input)?;
    let cutters = tools::cutters(input.cutter, input.tables.tools);
    let subject = MeasureSubject { faces: input.faces, cutters: &cutters, rest: input.rest };
    let (maps, mut deviation) = measure::measure(&run, &subject, options, progress)?;
    deviation.sensitivity.pivot = Some(measure::pivot(&audit));
    let mut findings = left(&maps, &deviation, options);
    findings.extend(broken(&audit).into_iter().filter(|finding| {
        // Between vectors the control plans its own speeds, on the axes it chose.
        choices.vectors == 0 || matches!(finding, Finding::Travel { .. })
    }));
    let changes = Some(changes).filter(|changes| changes.count > 0 || changes.unmeasured > 0);
    Ok(Report { maps, deviation, audit: Some(audit), choices, changes, findings })
}

/// The control with each tool.
fn controls(input: &Input<'_>) -> Result<Controls, VerifyError> {
    tools::known(input.program, &input.tables)?;
    Controls::new([input.believed, input.real], &input.tables)
}

/// Cutter locations, and against what they are checked.
#[derive(Debug, Clone, Copy)]
pub struct ClInput<'a> {
    /// The locations: a file as read, or its text where it is long.
    pub file: &'a dyn ClSource,
    /// Tools of a file that loads several; empty: it has one, whatever its number. From the last location of one to the
    /// first of the next nothing is measured.
    pub tools: &'a [Tool<'a>],
    /// Faces to be cut, in the frame of the locations.
    pub faces: &'a [Face],
    /// The tool, from tip to gauge point.
    pub cutter: &'a Cutter,
    /// What is known not to be finished: it may be uncut, or more than the tolerance may stand there.
    pub rest: &'a [UncutRegion],
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
    let run = Run::locations(input, CHORD_SHARE * options.ray_tolerance)?;
    let cutters = tools::cutters(input.cutter, input.tools);
    let subject = MeasureSubject { faces: input.faces, cutters: &cutters, rest: input.rest };
    let (maps, deviation) = measure::measure(&run, &subject, options, progress)?;
    let findings = left(&maps, &deviation, options);
    let choices = Choices::default();
    Ok(Report { maps, deviation, audit: None, choices, changes: None, findings })
}

/// Share of the ray tolerance by which the chords of an arc may be off.
const CHORD_SHARE: f64 = 0.1;

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
    if let Some(higher) = deviation.higher {
        findings.push(Finding::Length { higher });
    }
    let mut uncut = maps.iter().flat_map(|map| &map.samples).flatten();
    if let Some(sample) = uncut.find(|sample| sample.height.is_none() && !sample.rest) {
        let (points, area) = (deviation.uncut, deviation.uncut_area);
        findings.push(Finding::Uncut { points, area, place: sample.point });
    }
    findings.extend(deviation.rapid.map(|line| Finding::Rapid { line }));
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
