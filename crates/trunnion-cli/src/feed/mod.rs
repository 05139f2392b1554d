//! `trunnion feed`: a speed schedule for a table of axis positions.

mod layout;
mod out;
mod path;
mod plan;
mod streamed;

use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::table::Ends;
use crate::text;
use path::Table;
use std::path::PathBuf;
use std::time::Instant;
use trunnion::feed::{FeedError, FeedOptions, FeedPlan, LimitBreach, Limits, ProgrammedSpeeds};
use trunnion::files::limits::{LimitsFile, parse};
use trunnion::types::AxisPath;

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    ends: Ends,
    /// Limits of the axes: [axis.X] vel, acc, jerk; see `trunnion schema limits`.
    #[arg(long, value_name = "FILE")]
    limits: PathBuf,
    /// Planning method. `jerk` is the fastest schedule within velocity, acceleration and jerk limits, `optimal`
    /// within velocity and acceleration limits alone; `blocks` and `given` may break limits, which is reported.
    #[arg(long, value_enum, default_value = "jerk")]
    method: Method,
    /// optimal: keep the limits at rows only, not in between; for comparison with other planners.
    #[arg(long)]
    no_guarantee: bool,
    /// Plan row by row with a look-ahead of so many rows, inside which the axes can always stop, as a control does;
    /// with jerk limits up to eight times as many rows if stopping takes longer.
    #[arg(long, value_name = "ROWS", value_parser = clap::value_parser!(u32).range(4..))]
    window: Option<u32>,
    /// With --window: read, plan and write row by row, for tables of any length; the table is read twice. Numbers that
    /// need the whole path are left out: the certified bound and the binding limits.
    #[arg(long, requires = "window", conflicts_with = "motion")]
    stream: bool,
    /// Stop searching when less than this share of the time can still be gained [default: 1e-3 for jerk; 5e-3 for
    /// optimal, which takes long to get below].
    #[arg(long, value_name = "SHARE", value_parser = share)]
    time_tolerance: Option<f64>,
    /// Largest difference of NAME3 from the quintic through NAME, NAME1, NAME2, as a share of the
    /// largest NAME3, or of the smallest value that matters for the limits.
    #[arg(long, value_name = "SHARE", default_value = "0.1", value_parser = share)]
    third_tolerance: f64,
    /// Also write the axes at every servo period: position, velocity, acceleration, jerk. As CSV, or as Parquet
    /// if the name ends in .parquet and trunnion is built with that feature.
    #[arg(long, value_name = "FILE")]
    motion: Option<PathBuf>,
    /// Servo period of --motion, of chord errors and of the junctions of --method blocks, in s.
    #[arg(long, value_name = "SECONDS", default_value = "0.001", value_parser = share)]
    period: f64,
}

const EXAMPLES: &str = "\
Columns: s, and for each axis of the limits file NAME, NAME1, NAME2 (value and derivatives by s) and
optionally NAME3, which is checked. Between rows the path is the quintic through all three. Two rows
with the same s mark a jump of the derivatives: the axes rest there. A column `feed` limits ds/dt row
by row; with --method given a column `speed` is ds/dt. Units are those of the columns, per second.
Limits (TOML):  [axis.X]  vel = 500  acc = 5000  jerk = 1e5     one table per axis
                          vel_minus = 400  acc_minus = 4000     optional: in minus direction
                          chord = 0.001                         optional: largest distance from the
                                                                line between two setpoints, --period
                [path]    feed = 50  acc, jerk, start, end      optional, along s
Result: s,t,speed,acceleration,jerk. Between rows the acceleration is constant (optimal) or linear in
s (jerk).
Exit codes: 0 done; 1 done, but a limit is broken (--no-guarantee, blocks, given); 2 bad input, nothing
written.

  trunnion feed path.csv --limits machine.toml -o profile.csv
  trunnion feed path.csv --limits machine.toml --method optimal --json -o profile.csv
  trunnion feed path.csv --limits machine.toml --window 512 -o profile.csv
  trunnion feed long.csv --limits machine.toml --window 512 --stream -o profile.csv
  trunnion feed path.csv --limits machine.toml -o profile.csv --motion motion.csv --period 0.002";

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Method {
    /// Velocity, acceleration and jerk limits.
    Jerk,
    /// Velocity and acceleration limits.
    Optimal,
    /// Classical look-ahead over straight blocks from row to row, for comparison.
    Blocks,
    /// Speeds of the column `speed`: reports the axis motion, and each broken limit with its place.
    Given,
}

impl Method {
    /// Returns the share of the time below which the search stops.
    fn time_tolerance(self) -> f64 {
        match self {
            Self::Jerk => 1e-3,
            Self::Optimal | Self::Blocks | Self::Given => 5e-3,
        }
    }

    fn name(self) -> &'static str {
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

/// Axis counts that plans are compiled for; others get axes that stand still.
const SIZES: [usize; 4] = [3, 5, 6, 10];

pub(crate) fn run(args: &Args, json: bool) -> Result<Done, Failure> {
    usage(args, json)?;
    let limits = parse(&text::read(&args.limits)?)
        .map_err(|faults| Failure::faults(&args.limits, &faults))?;
    jerks(args, &limits)?;
    rests(args, &limits)?;
    if args.stream {
        let axes = streamed::axes(args, &limits)?;
        return match axes {
            0..=3 => streamed::run::<3>(args, json, &limits),
            4..=5 => streamed::run::<5>(args, json, &limits),
            6 => streamed::run::<6>(args, json, &limits),
            7..=10 => streamed::run::<10>(args, json, &limits),
            many => Err(too_many(args, many)),
        };
    }
    let table = Table::read(&args.ends, &limits, args.method)?;
    match table.layout.axes() {
        0..=3 => sized::<3>(args, json, &limits, &table),
        4..=5 => sized::<5>(args, json, &limits, &table),
        6 => sized::<6>(args, json, &limits, &table),
        7..=10 => sized::<10>(args, json, &limits, &table),
        many => Err(too_many(args, many)),
    }
}

fn too_many(args: &Args, axes: usize) -> Failure {
    Failure::input(format!(
        "{}: {axes} axes, with the path's own limits; at most {} can be planned together",
        args.limits.display(),
        SIZES[3]
    ))
}

fn usage(args: &Args, json: bool) -> Result<(), Failure> {
    if json && args.ends.to_stdout() {
        return Err(Failure::input(
            "--json prints a summary on stdout\n  help: give the schedule a file with -o",
        ));
    }
    if !cfg!(feature = "parquet") && args.motion.as_deref().is_some_and(out::is_parquet) {
        return Err(Failure::input(
            "this trunnion writes no Parquet\n  help: build it with --features parquet, or name a .csv file",
        ));
    }
    let optimal = args.method == Method::Optimal;
    if args.no_guarantee && !optimal {
        return Err(Failure::input("--no-guarantee goes with --method optimal only"));
    }
    let streams = matches!(args.method, Method::Optimal | Method::Jerk);
    if args.window.is_some() && (!streams || args.no_guarantee) {
        return Err(Failure::input(
            "--window goes with --method optimal or jerk, and always keeps the limits",
        ));
    }
    if args.stream && args.ends.is_stdin() {
        return Err(Failure::input(
            "--stream reads the table twice, which stdin cannot be\n  help: name a file",
        ));
    }
    Ok(())
}

/// Every axis needs a jerk limit where jerk is to be limited.
fn jerks(args: &Args, limits: &LimitsFile) -> Result<(), Failure> {
    if args.method != Method::Jerk {
        return Ok(());
    }
    let missing = limits.axes.iter().filter(|(_, axis)| axis.jerk.is_none());
    let missing: Vec<String> = missing
        .map(|(name, _)| {
            let file = args.limits.display();
            format!(
                "{file}: axis {name} has no jerk limit\n  help: add `jerk = ...` to [axis.{name}], \
                 or plan without jerk limits: --method optimal"
            )
        })
        .collect();
    if missing.is_empty() { Ok(()) } else { Err(Failure::Input(missing)) }
}

/// A window starts at rest and always ends there.
fn rests(args: &Args, limits: &LimitsFile) -> Result<(), Failure> {
    let ends = [limits.path.start, limits.path.end];
    if args.window.is_none() || ends.iter().all(|speed| *speed <= 0.0) {
        return Ok(());
    }
    Err(Failure::input(format!(
        "{}: [path] start = {}, end = {}, but a path through a window starts and ends at rest\n  \
         help: leave them out, or leave --window out",
        args.limits.display(),
        ends[0],
        ends[1]
    )))
}

/// What was planned, and for which path.
struct Planned<const N: usize> {
    path: AxisPath<N>,
    plan: FeedPlan,
    /// Where a given speed breaks which limit.
    breaches: Vec<LimitBreach>,
    /// Wall-clock time of planning \[s\].
    seconds: f64,
}

fn sized<const N: usize>(
    args: &Args,
    json: bool,
    file: &LimitsFile,
    table: &Table,
) -> Result<Done, Failure> {
    let (limits, chords): (Limits<N>, _) = table
        .layout
        .limits(file, args.period)
        .map_err(|error| Failure::input(format!("{}: {error}", args.limits.display())))?;
    let path = table.path(&limits, args)?;
    let options = FeedOptions {
        speeds: ProgrammedSpeeds { feed: table.layout.feed(), ..ProgrammedSpeeds::FASTEST },
        time_tolerance: args.time_tolerance.unwrap_or(args.method.time_tolerance()),
        ends: [file.path.start, file.path.end],
        guarantee: !args.no_guarantee,
    };
    let progress = Bars::new();
    let start = Instant::now();
    let plan = plan::plan(args, (&path, table), (&limits, &options), &progress);
    let seconds = start.elapsed().as_secs_f64();
    let (mut plan, breaches) = plan.map_err(|error| match error {
        FeedError::Cancelled(_) => Failure::Stopped,
        error => Failure::input(format!("{}: {error}", args.ends.name().display())),
    })?;
    plan.name_chords(chords);
    let planned = Planned { path, plan, breaches, seconds };
    out::write(args, &planned, table)?;
    out::tell(args, json, &planned, table)
}
