//! Arguments of `trunnion check`.

use super::offset::{self, WorkOffsetArgument};
use super::tool;
use super::what_if::{self, Assumption};
use crate::inspect;
use crate::option_values::{not_negative, part_angles, positive, three};
use crate::post::tools::{self, ToolLength};
use crate::program_files::ProgramFileArgs;
use std::path::PathBuf;
use trunnion::nc::read::Dialect;
use trunnion::verify::FindingKind;

/// Control whose time is predicted: `LinuxCNC` 2.9 with its own planner, or with that of trunnion.
// Variants with documentation would give the whole help another layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum PredictedControl {
    Linuxcnc,
    LinuxcncTrunnion,
}

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct CheckArgs {
    /// Program (G-code), CL file, or axis setpoints as a run writes them (motion.csv).
    pub(super) program: PathBuf,
    /// Take machine, part, setup, tool, tolerance, grid, stock and fixtures from a job file.
    #[arg(long, value_name = "JOB.toml", conflicts_with_all = ["machine", "part", "faces", "flip",
        "part_rotation", "origin", "rotation"])]
    pub(super) job: Option<PathBuf>,
    /// Number of an operation of the job: checks its own program (`output.programs = "each"`), with its faces, tool and
    /// feed. What it leaves uncut is listed and does not fail the check.
    #[arg(long, value_name = "N", requires = "job")]
    pub(super) operation: Option<u32>,
    /// Machine file, or name of a built-in machine. A CL file needs none.
    #[arg(short, long, value_name = "M")]
    pub(super) machine: Option<String>,
    /// Surface JSON or STEP file. Without one, only axes, stock and fixtures are checked.
    #[arg(long, value_name = "FILE")]
    pub(super) part: Option<PathBuf>,
    /// Numbers of the faces that are cut, from `trunnion inspect` [default: all]. The tool must not gouge the others.
    #[arg(long, value_name = "N,N..", value_delimiter = ',')]
    pub(super) faces: Vec<usize>,
    /// Flip the faces: the cutter is on their other side.
    #[arg(long)]
    pub(super) flip: bool,
    /// Rotation of the part about its x, then y, then z, in degrees, before it is the workpiece of the program.
    #[arg(long, value_name = "A,B,C", value_parser = part_angles, allow_hyphen_values = true)]
    pub(super) part_rotation: Option<[f64; 3]>,
    /// Cutter in mm: R, radius of the centre circle; r, radius of the corner; optionally L, length from gauge point to
    /// tip, instead of --tool-length. Cutters with a side beside the tip arc have r, the radius of that arc, and D, the
    /// diameter where the side ends: taper=5 is a cone with that half angle in degrees, barrel=85 a barrel of that radius,
    /// both a conical barrel, corner=1 a lens with that corner. A number in front, 2=R=5,r=1, describes tool 2. May be repeated, once without a
    /// number for all other tools.
    #[arg(long, value_name = "[N=]R=10,r=6")]
    pub(super) cutter: Vec<String>,
    /// Profile above the cutting part: height above the tip and radius in mm, from the lowest point up. Tool numbers as for
    /// --cutter.
    #[arg(long, value_name = "[N=]H:R,H:R..")]
    pub(super) shank: Vec<String>,
    /// Profile of the holder, likewise; or an STL file of it in mm, whose z is the tool axis, 0 at the gauge point, and rises to
    /// the spindle.
    #[arg(long, value_name = "[N=]H:R,H:R..")]
    pub(super) holder: Vec<String>,
    /// Dialect of the program: linuxcnc, fanuc, haas, siemens, heidenhain, apt [default: detected from file name and
    /// first lines].
    #[arg(long, value_parser = dialect)]
    pub(super) dialect: Option<Dialect>,
    /// Value of a parameter that the program does not set, such as `500=0`, `_hal[x]=3`, `R1=5`. May be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = inspect::parameter)]
    pub(super) parameters: Vec<(String, f64)>,
    /// Run the lines that begin with / (true), or skip them (false).
    #[arg(long, value_name = "RUN")]
    pub(super) block_delete: Option<bool>,
    #[command(flatten)]
    pub(super) files: ProgramFileArgs,
    /// Length of the tool, gauge point to tip, in mm. Tool numbers as for --cutter.
    #[arg(long, value_name = "[N=]L", value_parser = tools::length)]
    pub(super) tool_length: Vec<ToolLength>,
    /// Work offset that the program uses beside G54: X, Y and Z of its table in mm, as the setup sheet gives them for
    /// G54, or =G54 for the same origin. G55 to G59, G59.1 to G59.3, G54.1P1 and on, Siemens G505 and on, or the number
    /// of a Heidenhain preset. May be repeated.
    #[arg(long, value_name = "G55=X,Y,Z", value_parser = offset::read, allow_hyphen_values = true)]
    pub(super) offset: Vec<WorkOffsetArgument>,
    /// Rotaries of the program count against ISO 841, as the trunnion kinematics of `LinuxCNC` count them by default.
    #[arg(long)]
    pub(super) reversed_rotaries: bool,
    /// Workpiece origin in machine coordinates with all axes at zero, in mm.
    #[arg(long, value_name = "X,Y,Z", value_parser = three, default_value = "0,0,0", allow_hyphen_values = true)]
    pub(super) origin: [f64; 3],
    /// Rotation of the workpiece about the fixed x, then y, then z, in degrees.
    #[arg(long, value_name = "A,B,C", value_parser = three, default_value = "0,0,0", allow_hyphen_values = true)]
    pub(super) rotation: [f64; 3],
    /// Largest excess and deepest gouge in mm. Gouges up to 0.0001 mm are always allowed, because rounded words cause
    /// them.
    #[arg(long, value_name = "TOTAL,GOUGE", value_parser = tool::tolerance, allow_hyphen_values = true)]
    pub(super) tolerance: Option<[f64; 2]>,
    /// Largest distance between measured points in mm [default: that of the job, or 0.2].
    #[arg(long, value_name = "MM", value_parser = positive, allow_negative_numbers = true)]
    pub(super) grid: Option<f64>,
    /// Stock in the part's coordinates, in mm: box:x,y,z,X,Y,Z (two corners), cyl:x,y,z,radius,height (centre of the
    /// lower end), a closed STL file, or a STEP file. A file may have a placement: vise.step@x,y,z moves its origin,
    /// vise.step@x,y,z,a,b,c first rotates it about the fixed x, then y, then z, in degrees [default: that of the job].
    #[arg(long, value_name = "STOCK", allow_hyphen_values = true)]
    pub(super) stock: Option<String>,
    /// Fixture that the tool must not touch, written as for --stock. May be repeated, and adds to those of the job.
    #[arg(long, value_name = "FIXTURE", allow_hyphen_values = true)]
    pub(super) fixture: Vec<String>,
    /// Keep-off distance of every part of the tool from fixtures in mm; closer approaches are reported [default: that of
    /// the job, or 0, which reports contact].
    #[arg(long, value_name = "MM", value_parser = not_negative, allow_negative_numbers = true)]
    pub(super) clearance: Option<f64>,
    /// Largest distance of the triangles that represent STEP solids from their faces in mm; fixtures are enlarged by it
    /// [default: that of the job, or 0.01].
    #[arg(long, value_name = "MM", value_parser = positive, allow_negative_numbers = true)]
    pub(super) chord: Option<f64>,
    /// Largest distance between the rays that represent the stock in mm [default: that of the job, or 1/400 of the longest
    /// side].
    #[arg(long, value_name = "MM", value_parser = positive, allow_negative_numbers = true)]
    pub(super) stock_cell: Option<f64>,
    /// Errors in mm that the control does not know of: length and radius of the tools, origin.x of the workpiece, pivot.B.z
    /// of a rotary axis. The part is measured under each and under all together; the verdict is that without them.
    #[arg(long, value_name = "NAME=MM,..", value_delimiter = ',', value_parser = what_if::read)]
    pub(super) what_if: Vec<Assumption>,
    /// Control whose time is predicted: linuxcnc is version 2.9 as it comes, linuxcnc-trunnion has the planner of trunnion,
    /// which plans the program for it. Both are printed then; neither is judged [default: linuxcnc].
    #[arg(long, value_name = "NAME")]
    pub(super) control: Option<PredictedControl>,
    /// Kind of finding that does not fail the check, such as spindle-stopped for a plotter; see below. May be repeated.
    #[arg(long, value_name = "KIND", value_parser = finding_kind)]
    pub(super) accept: Vec<FindingKind>,
    /// Servo period of a table of setpoints in s [default: that of the job, of the machine, or of the rows].
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(super) period: Option<f64>,
    /// Report the jerk of a table of setpoints, but do not judge it: for motion planned without jerk limits.
    #[arg(long)]
    pub(super) no_jerk: bool,
    /// Folder for summary.json, report.html, deviation.vtp and stock.stl [default: no files].
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
}

fn dialect(text: &str) -> Result<Dialect, String> {
    Dialect::from_name(text).ok_or_else(|| {
        let names: Vec<&str> = Dialect::ALL.iter().map(|dialect| dialect.name()).collect();
        format!("one of {} is expected", names.join(", "))
    })
}

fn finding_kind(text: &str) -> Result<FindingKind, String> {
    FindingKind::from_name(text).ok_or_else(|| {
        let names: Vec<&str> = FindingKind::ALL.iter().map(|kind| kind.name()).collect();
        format!("one of {} is expected", names.join(", "))
    })
}

const EXAMPLES: &str = "\
The check runs the program as the control would, from the machine's home position, and measures
the result along the normals of the faces: negative is a gouge, positive is excess. It also
compares the axes with their limits of travel, velocity and acceleration. It assumes that the
workpiece is where --origin and --rotation put it, and that work offset and tool length at the
control are correct; see the setup sheet of a run.

Tool directions: a program may give vectors (Siemens A3= B3= C3=, Heidenhain LN, Fanuc G43.5) or
tilted planes (G68.2 with G53.1, PLANE, CYCLE800) instead of rotary positions. The rotaries then
take the solution inside travel that is nearest to their last position, and the check reports it.
Between vectors the tool turns as programmed (ORIVECT, ORIAXES, PATHCTRL), else on the great
circle. Velocities there are reported but not judged, because the control plans its own.

Several tools: describe each, as in --cutter 1=R=10,r=6 --cutter 2=R=5,r=1 --tool-length 1=120
--tool-length 2=95. A job describes further tools as [[verify.tool]], with the keys of [tool].

Tool changes: the machine decides where X, Y and Z are after a change. Rapid moves are not
measured until the program has given all three, and a cut before that is refused. Rotaries keep
their position.

Rapid moves run twice: all axes together, and each axis at its own speed. The deeper gouge counts.
Excess is what feed moves leave; a face that only a rapid move finishes is reported.

Stock: with --stock, material is removed move by move. Rapid moves through it, and shank or holder
in it, are reported with line, depth and position. The remaining stock is written as stock.stl.

Fixtures: the smallest distance between the tool and each --fixture is found for every move,
including the motion between its ends. The check reports the smallest distance of the program, and
every line with contact or below --clearance. A job has stock and fixtures as [stock], [[fixture]]
and verify.fixture_clearance.

Without --part, nothing is measured: the check audits the axes, and cuts --stock and keeps clear of
--fixture where they are given. The axes alone need only the length of each tool.

State of the control: every feed move needs a spindle that turns clockwise, tool length compensation
if a tool has a length, and the length of the tool in the spindle. A tool change stops the spindle.
Smoothing that the program allows (G64 P, CYCLE832, CYCL DEF 32, G187 E) must not exceed the
tolerance of the part. A job with cutting.coolant needs M7 or M8 in front of every cut; the
program has to call the tools of a job, and must not be far slower than its feed.

Findings have kinds, each with a page in the book: gouge, excess, tool-length, uncut, rapid-finish,
unmeasured, travel, velocity, acceleration, spindle-stopped, spindle-reversed, no-length,
wrong-length, no-tool, slow-cuts, no-coolant, smoothing. Those named with --accept are reported, but do not fail the check.

Time: a control takes longer than the program states where its planner has to be slower. The table
has the time on LinuxCNC 2.9, by a model of its planner; --control linuxcnc-trunnion adds that with
the planner of trunnion (TPMOD = trunniontp), which rounds corners within P of G64 and keeps the
jerk limits of the machine file. Tool changes and the spindle take no time there, and motion in step
with it is timed as if it were not. Arcs count as chords, so under G61 they begin with a stop. A
block that this planner refuses is a warning with its line: then there is no such time, and the rest
of the check goes on.

Setpoints (a .csv file) are checked against the machine alone. Columns: t in s, then X,Y,.. in mm
and degrees, and optionally X_vel,.., X_acc,.., X_jerk,... Every row must keep the period and all
limits. Between two rows, the smallest acceleration and jerk that any motion through both needs
must keep them. Rounding of the decimals is allowed for, so that every reported violation is real.

Exit codes: 0 every tolerance and limit is kept; 1 one is broken, and reported; 2 bad input, nothing
written.

  trunnion check out/program.linuxcnc.ngc --job job.toml -o checked
  trunnion check part.ngc --machine bc-trunnion --tool-length 120 --control linuxcnc-trunnion
  trunnion check part.ngc --machine bc-trunnion --part part.step --faces 2,3 --cutter R=10,r=6 \\
      --tool-length 120 --origin -381,-254,-505 --rotation 0,20,0 --tolerance 0.02,0.002 -o checked
  trunnion check part.ngc --job job.toml --stock box:-60,-75,-30,60,75,5 --fixture clamp.stl
  trunnion check two-tools.ngc --job job.toml --cutter 2=R=5,r=1 --tool-length 2=95 \\
      --offset G55=-381,-204,-505
  trunnion check part.ngc --job job.toml --what-if length=+0.01,radius=-0.01,pivot.B.z=0.02
  trunnion check part.ngc --machine bc-trunnion --tool-length 120 --origin -381,-254,-505
  trunnion check out/motion.csv --machine bc-trunnion
  trunnion check out/toolpath.cls --part patch.json --cutter R=10,r=6 --tolerance 0.02,0.002";
