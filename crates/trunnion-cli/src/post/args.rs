//! Arguments of `trunnion post`.

use super::tools::{self, ToolLength};
use crate::inspect;
use crate::option_values::{pose_tolerance, positive, three};
use crate::program_files::ProgramFileArgs;
use std::path::PathBuf;
use trunnion::nc::read;
use trunnion::nc::write::{OUTPUT_FORMATS, OutputFormat};
use trunnion::types::PoseTolerance;

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
#[expect(clippy::struct_excessive_bools, reason = "switches of a command line")]
pub(crate) struct PostArgs {
    /// CL file (APT/CL as written by NX, CATIA, Creo, SOLIDWORKS and Autodesk) or NC program; - is stdin.
    #[arg(required_unless_present = "print_template")]
    pub(super) input: Option<PathBuf>,
    /// Machine file, or name of a built-in machine (see `trunnion machine list`).
    #[arg(short, long, required_unless_present = "print_template")]
    pub(super) machine: Option<String>,
    /// Program to write; its setup sheet is written beside it, OUT.setup.txt.
    #[arg(short, long, value_name = "OUT", required_unless_present = "print_template")]
    pub(super) output: Option<PathBuf>,
    /// Dialect of the program [default: that of the machine file].
    #[arg(short, long, value_parser = dialect)]
    pub(super) dialect: Option<OutputFormat>,
    /// Largest deviation of the program from the input: mm at the tip, degrees of the tool axis.
    #[arg(long, value_name = "TIP,AXIS", value_parser = pose_tolerance, default_value = "0.01,0.05", allow_hyphen_values = true)]
    pub(super) tolerance: PoseTolerance,
    /// Dialect of the input [default: detected from its text]: apt linuxcnc fanuc haas siemens heidenhain.
    #[arg(long, value_name = "DIALECT", value_parser = read_dialect)]
    pub(super) from: Option<read::Dialect>,
    /// Machine of the input program [default: that of --machine].
    #[arg(long, value_name = "MACHINE")]
    pub(super) from_machine: Option<String>,
    /// Calibrated file of the machine, by `trunnion machine calibrate`: the input is for --machine, and the axis positions
    /// that are written bring the tool to the same places on the real machine. For programs in axis positions (-d g93).
    #[arg(long, value_name = "FILE", conflicts_with = "from_machine")]
    pub(super) to_calibrated: Option<String>,
    /// Workpiece origin assumed by the input program [default: --origin].
    #[arg(long, value_name = "X,Y,Z", value_parser = three, allow_hyphen_values = true)]
    pub(super) from_origin: Option<[f64; 3]>,
    /// Workpiece rotation assumed by the input program [default: --rotation].
    #[arg(long, value_name = "RX,RY,RZ", value_parser = three, allow_hyphen_values = true)]
    pub(super) from_rotation: Option<[f64; 3]>,
    /// Tool length assumed by the input program [default: --tool-length]; NUMBER=L for each of several tools.
    #[arg(long, value_name = "L|NUMBER=L", value_parser = tools::length, allow_hyphen_values = true)]
    pub(super) from_tool_length: Vec<ToolLength>,
    /// Rotaries of the input program count against ISO 841.
    #[arg(long)]
    pub(super) from_reversed_rotaries: bool,
    /// Post the moves of this tool only; --tool-length and --from-tool-length are those of this tool.
    #[arg(long, value_name = "NUMBER")]
    pub(super) tool: Option<u32>,
    /// Value of a parameter that the input program does not set, such as `500=0`, `_hal[x]=3`, `R1=5`. May be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = inspect::parameter)]
    pub(super) parameters: Vec<(String, f64)>,
    /// Run the lines that begin with / (true), or skip them (false).
    #[arg(long, value_name = "RUN")]
    pub(super) block_delete: Option<bool>,
    #[command(flatten)]
    pub(super) files: ProgramFileArgs,
    /// Fit a C3 path through the moves between rapid moves: fewer and longer blocks, and no corners that slow the
    /// axes down.
    #[arg(long, conflicts_with = "reduce")]
    pub(super) smooth: bool,
    /// Leave out moves that a longer one replaces within tolerance.
    #[arg(long)]
    pub(super) reduce: bool,
    /// Retract by this distance along the tool, in mm, if a rotary axis reaches the end of its travel inside a cut; the rotaries
    /// unwind and the tool returns. Without this option such a cut is refused.
    #[arg(long, value_name = "MM", value_parser = positive, allow_hyphen_values = true)]
    pub(super) unwind: Option<f64>,
    /// Feed in mm/min to which feeds may be raised if the axes allow it [default: feeds of the input are the upper
    /// limit].
    #[arg(long, value_name = "F", value_parser = positive, allow_hyphen_values = true)]
    pub(super) max_feed: Option<f64>,
    /// Method for the times of blocks, and with them F.
    #[arg(long, value_enum, default_value_t = PostTiming::Optimal)]
    pub(super) feed: PostTiming,
    /// Table of servo setpoints to write as well (.csv, or .parquet if trunnion is built with that feature): the axes within
    /// their jerk limits, corners rounded within the tolerance. For one tool; dwells are left out.
    #[arg(long, value_name = "TABLE")]
    pub(super) motion: Option<PathBuf>,
    /// Servo period of the setpoints in s [default: that of the machine, or 0.001].
    #[arg(long, value_name = "S", value_parser = positive, requires = "motion")]
    pub(super) period: Option<f64>,
    /// Workpiece origin in machine coordinates with all axes at zero, in mm.
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", value_parser = three, allow_hyphen_values = true)]
    pub(super) origin: [f64; 3],
    /// Rotation of the workpiece about the fixed x, then y, then z, in degrees.
    #[arg(long, value_name = "RX,RY,RZ", default_value = "0,0,0", value_parser = three, allow_hyphen_values = true)]
    pub(super) rotation: [f64; 3],
    /// Length of the tool, gauge point to tip, in mm [default: 0]. With NUMBER=L, once for each tool, an input with
    /// several tools becomes one program.
    #[arg(long, value_name = "L|NUMBER=L", value_parser = tools::length, allow_hyphen_values = true)]
    pub(super) tool_length: Vec<ToolLength>,
    /// Write rotaries against ISO 841, as the trunnion kinematics of `LinuxCNC` count them by default.
    #[arg(long)]
    pub(super) reversed_rotaries: bool,
    /// Spindle speed in 1/min [default: that of the input].
    #[arg(long, value_name = "S", value_parser = positive, allow_hyphen_values = true)]
    pub(super) spindle: Option<f64>,
    /// Switch the coolant on at the start and off at the end [default: as in the input].
    #[arg(long)]
    pub(super) coolant: bool,
    /// Template of the text around the blocks; --print-template prints one to start from.
    #[arg(long, value_name = "FILE")]
    pub(super) template: Option<PathBuf>,
    /// Print the template of a dialect, and do nothing else.
    #[arg(long, value_name = "DIALECT", value_parser = dialect, exclusive = true)]
    pub(super) print_template: Option<OutputFormat>,
}

const EXAMPLES: &str = "\
Feeds never exceed those of the input unless --max-feed allows it; rapid moves stay rapid. With
tool-centre-point control, F is an upper limit: the control plans its own speed below it. Without it
(g93), each block has its time.
Dialects: linuxcnc g93 fanuc fanuc-vector haas siemens siemens-axes heidenhain heidenhain-axes apt.
Exit codes: 0 done; 1 written, but a limit is broken; 2 bad input or poses out of reach, nothing
written.

  trunnion post out/toolpath.cls -m bc-trunnion --origin -381,-254,-505 --tool-length 120 \\
      -d fanuc -o part.nc
  trunnion post old.ngc -m new.toml --from-machine old.toml --from-tool-length 150 \\
      --tool-length 120 -d g93 -o new.nc
  trunnion post part.nc -m my.toml --to-calibrated calibrated.toml --tool-length 120 -d g93 -o real.nc
  trunnion post two-tools.ngc -m new.toml --tool 2 --tool-length 95 -d g93 -o second.nc
  trunnion post two-tools.ngc -m new.toml --tool-length 1=120 --tool-length 2=95 -d fanuc -o both.nc
  trunnion post part.cls -m my-machine.toml --tool-length 120 -o part.nc --motion motion.csv
  trunnion post --print-template fanuc > shop.j2
  trunnion post part.cls -m my-machine.toml --template shop.j2 -o part.nc";

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum PostTiming {
    /// Shortest time within velocity and acceleration limits.
    Optimal,
    /// Jerk limits as well: gentler, and a little slower.
    Jerk,
    /// Block after block with look-ahead, as a classical control without smoothing runs them.
    Blocks,
    /// Times of the input; the load on the axes is reported. For controls with a tip feed that plan by themselves.
    Programmed,
}

fn dialect(name: &str) -> Result<OutputFormat, String> {
    OutputFormat::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = OUTPUT_FORMATS.iter().map(|(name, _)| *name).collect();
        format!("write one of {}", names.join(", "))
    })
}

fn read_dialect(name: &str) -> Result<read::Dialect, String> {
    let names = read::Dialect::ALL.map(read::Dialect::name);
    read::Dialect::from_name(name).ok_or_else(|| format!("write one of {}", names.join(", ")))
}
