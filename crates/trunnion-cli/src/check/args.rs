//! Arguments of `trunnion check`.

use super::offset::{self, WorkOffsetArgument};
use super::tool;
use crate::inspect;
use crate::option_values::{not_negative, positive, three};
use crate::post::tools::{self, ToolLength};
use std::path::PathBuf;
use trunnion::nc::read::Dialect;

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Program (G-code), a CL file, or axis setpoints as a run writes them: motion.csv.
    pub(super) program: PathBuf,
    /// Take machine, part, setup, tool, tolerance, grid, stock and fixtures from a job file.
    #[arg(long, value_name = "JOB.toml", conflicts_with_all = ["machine", "part", "faces", "flip",
        "origin", "rotation"])]
    pub(super) job: Option<PathBuf>,
    /// Machine file, or name of a built-in machine; a CL file needs none.
    #[arg(long, value_name = "M")]
    pub(super) machine: Option<String>,
    /// Surface JSON or STEP file.
    #[arg(long, value_name = "FILE")]
    pub(super) part: Option<PathBuf>,
    /// Numbers of the faces that are cut, see `trunnion inspect`; all if left out. On all others the
    /// tool must not gouge.
    #[arg(long, value_name = "N,N..", value_delimiter = ',')]
    pub(super) faces: Vec<usize>,
    /// The cutter is on the other side of the faces.
    #[arg(long)]
    pub(super) flip: bool,
    /// Radii in mm: R of the centre circle, r of the corner; L, gauge point to tip, if it is not
    /// --tool-length. With a number in front, 2=R=5,r=1, of the tool that the program calls so; may be
    /// given several times, and once without number for all the others.
    #[arg(long, value_name = "[N=]R=10,r=6")]
    pub(super) cutter: Vec<String>,
    /// Profile above the cutting part: height above the tip and radius in mm, from below up. Numbered as
    /// --cutter.
    #[arg(long, value_name = "[N=]H:R,H:R..")]
    pub(super) shank: Vec<String>,
    /// Holder, likewise.
    #[arg(long, value_name = "[N=]H:R,H:R..")]
    pub(super) holder: Vec<String>,
    /// What the program is written in: linuxcnc, fanuc, haas, siemens, heidenhain, apt; told by the
    /// file's name and first lines if left out.
    #[arg(long, value_parser = dialect)]
    pub(super) dialect: Option<Dialect>,
    /// A parameter that the program does not set itself, such as `500=0`, `_hal[x]=3`, `R1=5`. May be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = inspect::parameter)]
    pub(super) parameters: Vec<(String, f64)>,
    /// Whether lines that begin with / are run.
    #[arg(long, value_name = "RUN")]
    pub(super) block_delete: Option<bool>,
    /// Length of the tool, gauge point to tip, in mm. Numbered as --cutter.
    #[arg(long, value_name = "[N=]L", value_parser = tools::length)]
    pub(super) tool_length: Vec<ToolLength>,
    /// Where a work offset is that the program uses beside G54: X, Y and Z of its table in mm, as the
    /// setup sheet has them for G54; or =G54 for the same place. G55 to G59, G59.1 to G59.3, G54.1P1 and
    /// on, Siemens G505 and on, or the number of a Heidenhain preset. May be given several times.
    #[arg(long, value_name = "G55=X,Y,Z", value_parser = offset::read, allow_hyphen_values = true)]
    pub(super) offset: Vec<WorkOffsetArgument>,
    /// Workpiece origin in machine coordinates with all axes at zero, in mm.
    #[arg(long, value_name = "X,Y,Z", value_parser = three, default_value = "0,0,0", allow_hyphen_values = true)]
    pub(super) origin: [f64; 3],
    /// Rotation of the workpiece about the fixed x, then y, then z, in degrees.
    #[arg(long, value_name = "A,B,C", value_parser = three, default_value = "0,0,0", allow_hyphen_values = true)]
    pub(super) rotation: [f64; 3],
    /// Most material left and deepest gouge in mm; with a gouge of 0, what rounding makes, 0.0001 mm, is allowed.
    #[arg(long, value_name = "TOTAL,GOUGE", value_parser = tool::tolerance, allow_hyphen_values = true)]
    pub(super) tolerance: Option<[f64; 2]>,
    /// Largest distance between measured points in mm [default: 0.2, or the job's].
    #[arg(long, value_name = "MM", value_parser = positive, allow_negative_numbers = true)]
    pub(super) grid: Option<f64>,
    /// Material it is cut from, in the part's coordinates in mm: box:x,y,z,X,Y,Z (two corners),
    /// cyl:x,y,z,radius,height (centre of the lower end), a closed STL file or a STEP file, which may have a
    /// place behind it: vise.step@x,y,z where its origin lies, vise.step@x,y,z,a,b,c turned about the fixed x,
    /// then y, then z by so many degrees, too [default: the job's].
    #[arg(long, value_name = "STOCK", allow_hyphen_values = true)]
    pub(super) stock: Option<String>,
    /// What the tool must not touch, said as --stock; may be given several times, and is looked at beside the
    /// job's.
    #[arg(long, value_name = "FIXTURE", allow_hyphen_values = true)]
    pub(super) fixture: Vec<String>,
    /// How far any part of the tool must keep off fixtures in mm; what comes nearer is told [default: the
    /// job's, or 0: what runs into one].
    #[arg(long, value_name = "MM", value_parser = not_negative, allow_negative_numbers = true)]
    pub(super) clearance: Option<f64>,
    /// How far the triangles that stand for STEP solids may be off their faces in mm; fixtures are taken to
    /// be larger by that [default: the job's, or 0.01].
    #[arg(long, value_name = "MM", value_parser = positive, allow_negative_numbers = true)]
    pub(super) chord: Option<f64>,
    /// Largest distance of the rays that stand for stock in mm [default: 400 on the longest side].
    #[arg(long, value_name = "MM", value_parser = positive, allow_negative_numbers = true)]
    pub(super) stock_cell: Option<f64>,
    /// Servo period of a table of setpoints in s [default: the job's, the machine's or that of its rows].
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(super) period: Option<f64>,
    /// Tell the jerk of a table of setpoints, but do not judge it: for motion that was planned without.
    #[arg(long)]
    pub(super) no_jerk: bool,
    /// Folder for summary.json, report.html, deviation.vtp and stock.stl; none are written if left out.
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
}

fn dialect(text: &str) -> Result<Dialect, String> {
    Dialect::from_name(text).ok_or_else(|| {
        let names: Vec<&str> = Dialect::ALL.iter().map(|dialect| dialect.name()).collect();
        format!("one of {} is wanted", names.join(", "))
    })
}

const EXAMPLES: &str = "\
The program is run as the control would run it, from the machine's home position, and what it leaves is
measured along the normals of the faces: below 0 a gouge, above 0 excess. Axes are held against travel,
velocity and acceleration. The workpiece is taken to stand where --origin and --rotation say, and the work
offset and tool length at the control to be right; see the setup sheet of a run.
Where a program tells a direction and not the rotaries (vectors: Siemens A3= B3= C3=, Heidenhain LN, Fanuc G43.5; tilted
planes: G68.2 and G53.1, PLANE, CYCLE800), they turn to the solution with the least travel from where they stood, inside
travel; it is told which. Between vectors the tool turns as the program says (ORIVECT, ORIAXES, PATHCTRL), on the great
circle if it does not. Velocities there are told, not judged: the control plans its own.
A program with several tools needs each: --cutter 1=R=10,r=6 --cutter 2=R=5,r=1 --tool-length 1=120 --tool-length 2=95;
a job says others than its own as [[verify.tool]], with the keys of [tool].
Where a change leaves X, Y and Z is the machine's own: rapid moves behind it are not measured until the program has told
all three, a cut before that is refused; the rotaries are taken to stand as before.
Rapid moves are run twice: all axes together, and each at its own speed. The worse gouge is told. Excess is what feed moves
leave; where a rapid alone finishes a face, it is told.
With --stock the material is cut away move by move. Rapid moves through it, either way, and shank or holder in it
are told with line, depth and place; what is left is written as stock.stl.
How near any part of the tool comes to a --fixture is found for every move, between times and places, too: the
least distance is told, and every line that runs into one, or comes nearer than --clearance. A job has both as
[stock], [[fixture]] and verify.fixture_clearance.
Setpoints (a .csv file) are held against the machine alone. Columns: t in s, then X,Y,.. in mm and degrees, and
X_vel,..; X_acc,..; X_jerk,.. as far as there are any. Every row must keep the period and every limit; between
two rows, the least acceleration and jerk of any motion through both must. The decimals' own rounding is taken
off, so that what is told as broken is broken.
Exit codes: 0 everything is kept; 1 something is broken, and where; 2 malformed input, nothing written.

  trunnion check out/program.linuxcnc.ngc --job job.toml -o checked
  trunnion check part.ngc --machine bc-trunnion --part part.step --faces 2,3 --cutter R=10,r=6 \\
      --tool-length 120 --origin -381,-254,-505 --rotation 0,20,0 --tolerance 0.02,0.002 -o checked
  trunnion check part.ngc --job job.toml --stock box:-60,-75,-30,60,75,5 --fixture clamp.stl -o checked
  trunnion check two-tools.ngc --job job.toml --cutter 2=R=5,r=1 --tool-length 2=95 --offset G55=-381,-204,-505
  trunnion check out/motion.csv --machine bc-trunnion
  trunnion check out/toolpath.cls --part patch.json --cutter R=10,r=6 --tolerance 0.02,0.002";
