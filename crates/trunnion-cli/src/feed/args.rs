//! Arguments of `trunnion feed`.

use crate::form::OutputForm;
use crate::motion::is_parquet;
use crate::outcome::Failure;
use crate::table::Ends;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct FeedArgs {
    #[command(flatten)]
    pub(super) ends: Ends,
    /// Limits of the axes: [axis.X] vel, acc, jerk; see `trunnion schema limits`.
    #[arg(long, value_name = "FILE")]
    pub(super) limits: PathBuf,
    /// Planning method. `jerk` is the fastest schedule within velocity, acceleration and jerk limits, `optimal`
    /// within velocity and acceleration limits alone; `blocks` and `given` may break limits, which is reported.
    #[arg(long, value_enum, default_value = "jerk")]
    pub(super) method: FeedMethod,
    /// optimal: keep the limits at rows only, not in between; for comparison with other planners.
    #[arg(long)]
    pub(super) no_guarantee: bool,
    /// Plan row by row with a look-ahead of this many rows, within which the axes can always stop, as a control does;
    /// with jerk limits up to eight times as many rows if stopping takes longer.
    #[arg(long, value_name = "ROWS", value_parser = clap::value_parser!(u32).range(4..))]
    pub(super) window: Option<u32>,
    /// With --window: read, plan and write row by row, for tables of any length; the table is read twice. Numbers that
    /// need the whole path are left out: the certified bound and the binding limits.
    #[arg(long, requires = "window", conflicts_with = "motion")]
    pub(super) stream: bool,
    /// Stop searching when less than this share of the time can still be gained [default: 1e-3 for jerk; 5e-3 for optimal, where a smaller share takes long].
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub(super) time_tolerance: Option<f64>,
    /// Largest difference of NAME3 from the quintic through NAME, NAME1, NAME2, as a share of the
    /// largest NAME3, or of the smallest value that matters for the limits.
    #[arg(long, value_name = "SHARE", default_value = "0.1", value_parser = share)]
    pub(super) third_tolerance: f64,
    /// Also write the axes at every servo period: position, velocity, acceleration, jerk. As CSV, or as Parquet
    /// if the name ends in .parquet and trunnion is built with that feature.
    #[arg(long, value_name = "FILE")]
    pub(super) motion: Option<PathBuf>,
    /// Servo period of --motion, of chord errors and of the junctions of --method blocks, in s.
    #[arg(long, value_name = "SECONDS", default_value = "0.001", value_parser = share)]
    pub(super) period: f64,
}

const EXAMPLES: &str = "\
Columns: s, and for each axis of the limits file NAME, NAME1, NAME2 (value and derivatives by s) and
optionally NAME3, which is checked. Between rows the path is the quintic through all three. Two rows
with the same s mark a jump of the derivatives: the axes rest there. A column `feed` limits ds/dt
row by row; with --method given, a column `speed` is ds/dt. Units are those of the columns, per
second.
Limits (TOML):  [axis.X]  vel = 500  acc = 5000  jerk = 1e5     one table per axis
                          vel_minus = 400  acc_minus = 4000     optional: in minus direction
                          chord = 0.001                         optional: largest distance from the
                                                                line between two setpoints, --period
                [path]    feed = 50  acc, jerk, start, end      optional, along s
Result: s,t,speed,acceleration,jerk. Between rows the acceleration is constant (optimal) or linear
in s (jerk).
Exit codes: 0 done; 1 done, but a limit is broken (--no-guarantee, blocks, given); 2 bad input,
nothing written.

  trunnion feed path.csv --limits machine.toml -o profile.csv
  trunnion feed path.csv --limits machine.toml --method optimal --json -o profile.csv
  trunnion feed path.csv --limits machine.toml --window 512 -o profile.csv
  trunnion feed long.csv --limits machine.toml --window 512 --stream -o profile.csv
  trunnion feed path.csv --limits machine.toml -o profile.csv --motion motion.csv --period 0.002";

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum FeedMethod {
    /// Velocity, acceleration and jerk limits.
    Jerk,
    /// Velocity and acceleration limits.
    Optimal,
    /// Classical look-ahead over straight blocks from row to row, for comparison.
    Blocks,
    /// Speeds of the column `speed`: reports the axis motion, and each broken limit with its position.
    Given,
}

impl FeedMethod {
    /// Returns the share of the time below which the search stops.
    pub(super) fn time_tolerance(self) -> f64 {
        match self {
            Self::Jerk => 1e-3,
            Self::Optimal | Self::Blocks | Self::Given => 5e-3,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Jerk => "jerk",
            Self::Optimal => "optimal",
            Self::Blocks => "blocks",
            Self::Given => "given",
        }
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a positive number is expected".into()),
    }
}

impl FeedArgs {
    /// Refuses options that do not go together.
    pub(super) fn check(&self, form: OutputForm) -> Result<(), Failure> {
        if form.is_json() && self.ends.to_stdout() {
            return Err(Failure::input(
                "--json prints a summary on stdout\n  help: give the schedule a file with -o",
            ));
        }
        if !cfg!(feature = "parquet") && self.motion.as_deref().is_some_and(is_parquet) {
            return Err(Failure::input(
                "this build of trunnion does not write Parquet\n  help: build it with --features parquet, or name a .csv file",
            ));
        }
        let optimal = self.method == FeedMethod::Optimal;
        if self.no_guarantee && !optimal {
            return Err(Failure::input(
                "--no-guarantee goes with --method optimal only\n  help: leave it out",
            ));
        }
        // Only these two planners work in a window.
        let streams = matches!(self.method, FeedMethod::Optimal | FeedMethod::Jerk);
        if self.window.is_some() && (!streams || self.no_guarantee) {
            return Err(Failure::input(
                "--window goes with --method optimal or jerk, and always keeps the limits\n  help: choose one of these methods, or leave --window out",
            ));
        }
        if self.stream && self.ends.is_stdin() {
            return Err(Failure::input(
                "--stream reads the table twice, and stdin can be read only once\n  help: name a file",
            ));
        }
        Ok(())
    }
}
