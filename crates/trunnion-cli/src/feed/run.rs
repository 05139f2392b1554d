//! The verb: reads limits and table, plans, writes and reports.

use super::args::{FeedArgs, FeedMethod};
use super::path::Table;
use super::plan::{PlanInput, Planned, plan};
use super::{schedule, streamed, summary};
use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::{output, text};
use std::sync::OnceLock;
use std::time::Instant;
use trunnion::feed::{FeedError, FeedOptions, Limits, PathEnds, optimal_schedule};
use trunnion::files::limits::{LimitsFile, parse};
use trunnion::setpoint;
use trunnion::types::{AxisPath, Progress, Schedule, Setpoint, Silent};

/// Axis counts that plans are compiled for; other counts get additional axes that stand still.
const SIZES: [usize; 4] = [3, 5, 6, 10];

pub(crate) fn run(args: &FeedArgs, form: OutputForm) -> Result<Done, Failure> {
    args.check(form)?;
    let inputs = [args.ends.input(), &args.limits];
    for written in args.motion.as_deref().into_iter().chain([args.ends.output()]) {
        output::protect(written, &inputs)?;
    }
    let limits = parse(&text::read(&args.limits)?)
        .map_err(|faults| Failure::faults(&args.limits, &faults))?;
    jerks(args, &limits)?;
    rests(args, &limits)?;
    if args.stream {
        let axes = streamed::axes(args, &limits)?;
        return match axes {
            0..=3 => streamed::run::<3>(args, form, &limits),
            4..=5 => streamed::run::<5>(args, form, &limits),
            6 => streamed::run::<6>(args, form, &limits),
            7..=10 => streamed::run::<10>(args, form, &limits),
            many => Err(too_many(args, many)),
        };
    }
    let table = Table::read(&args.ends, &limits, args.method)?;
    match table.layout.axes() {
        // Rounded up to the next compiled count: additional axes stand still and never bind.
        0..=3 => sized::<3>(args, form, &limits, &table),
        4..=5 => sized::<5>(args, form, &limits, &table),
        6 => sized::<6>(args, form, &limits, &table),
        7..=10 => sized::<10>(args, form, &limits, &table),
        many => Err(too_many(args, many)),
    }
}

fn too_many(args: &FeedArgs, axes: usize) -> Failure {
    Failure::input(format!(
        "{}: {axes} axes, with the path's own limits; at most {} can be planned together",
        args.limits.display(),
        SIZES[3]
    ))
}

/// Refuses axes without a jerk limit if the method keeps jerk limits.
fn jerks(args: &FeedArgs, limits: &LimitsFile) -> Result<(), Failure> {
    if args.method != FeedMethod::Jerk {
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

/// Refuses speeds at the ends of a path that is planned through a window, which starts and ends at rest.
fn rests(args: &FeedArgs, limits: &LimitsFile) -> Result<(), Failure> {
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

fn sized<const N: usize>(
    args: &FeedArgs,
    form: OutputForm,
    file: &LimitsFile,
    table: &Table,
) -> Result<Done, Failure> {
    let planned = planned::<N>(args, file, table, &Bars::new())?;
    schedule::write(args, &planned, table)?;
    summary::report(args, form, &planned, table)
}

/// Path, limits and options of a plan.
struct PreparedPlan<const N: usize> {
    path: AxisPath<N>,
    limits: Limits<N>,
    options: FeedOptions,
    /// Axes whose limits the chord error lowers.
    chords: [bool; N],
}

impl<const N: usize> PreparedPlan<N> {
    fn new(args: &FeedArgs, file: &LimitsFile, table: &Table) -> Result<Self, Failure> {
        let (limits, chords) = table
            .layout
            .limits(file, args.period)
            .map_err(|error| Failure::input(format!("{}: {error}", args.limits.display())))?;
        let path = table.path(&limits, args)?;
        let mut options = FeedOptions::fastest();
        options.speeds.feed = table.layout.feed();
        options.time_tolerance = args.time_tolerance.unwrap_or(args.method.time_tolerance());
        options.end_speeds = PathEnds { start: file.path.start, end: file.path.end };
        options.guarantee = !args.no_guarantee;
        Ok(Self { path, limits, options, chords })
    }
}

fn refused(args: &FeedArgs, error: FeedError) -> Failure {
    match error {
        FeedError::Cancelled(_) => Failure::Stopped,
        error => Failure::input(format!("{}: {error}", args.ends.name().display())),
    }
}

/// Plans the speed along a table.
fn planned<const N: usize>(
    args: &FeedArgs,
    file: &LimitsFile,
    table: &Table,
    progress: &dyn Progress,
) -> Result<Planned<N>, Failure> {
    let PreparedPlan { path, limits, options, chords } = PreparedPlan::new(args, file, table)?;
    let start = Instant::now();
    let input = PlanInput { path: &path, table, limits: &limits, options: &options };
    let plan = plan(args, &input, progress);
    let seconds = start.elapsed().as_secs_f64();
    let (mut plan, breaches) = plan.map_err(|error| refused(args, error))?;
    // Limits that the chord error lowered are named after it.
    plan.name_chords(chords);
    Ok(Planned { path, plan, breaches, seconds })
}

/// Table of axis positions in memory.
#[derive(Debug, Clone, Copy)]
pub struct AxisTable<'a> {
    /// Names of the columns.
    pub names: &'a [String],
    /// Values, row by row.
    pub values: &'a [f64],
}

/// Plan of a table for callers in other languages.
pub struct PlanAnswer {
    /// Names of the axes, in the order of [`PlannedMotion::sample`].
    pub axes: Vec<String>,
    /// Path and schedule.
    pub motion: Box<dyn PlannedMotion>,
}

impl std::fmt::Debug for PlanAnswer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PlanAnswer").field("axes", &self.axes).finish_non_exhaustive()
    }
}

/// Figures that are measured on a plan.
#[derive(Debug, Clone)]
pub struct PlanFigures {
    /// Summary as `--json` prints it.
    pub summary: serde_json::Value,
    /// True if every limit is kept.
    pub within_limits: bool,
    /// No schedule within the velocity and acceleration limits is faster \[s\].
    pub lower_bound: f64,
}

/// Path of any number of axes with its schedule.
pub trait PlannedMotion: Send + Sync {
    /// Returns the schedule.
    fn schedule(&self) -> &Schedule;

    /// Returns what is measured of the plan. A plan that keeps the limits at its rows alone is measured when it is first
    /// asked, which takes longer than planning it.
    ///
    /// # Errors
    ///
    /// Failures of the measurement.
    fn figures(&self) -> Result<&PlanFigures, Failure>;

    /// Returns the motion of the first `axes` axes at every `period` \[s\].
    ///
    /// Each row has the time, then positions, velocities, accelerations and jerks.
    ///
    /// # Errors
    ///
    /// A period that is not above 0, or so short that the rows would not fit in memory.
    fn sample(&self, axes: usize, period: f64) -> Result<Vec<f64>, Failure>;
}

/// Plan that keeps all it needs to be measured later.
struct KeptPlan<const N: usize> {
    args: FeedArgs,
    limits: LimitsFile,
    table: Table,
    path: AxisPath<N>,
    schedule: Schedule,
    figures: OnceLock<PlanFigures>,
}

impl<const N: usize> PlannedMotion for KeptPlan<N> {
    fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    fn figures(&self) -> Result<&PlanFigures, Failure> {
        if let Some(found) = self.figures.get() {
            return Ok(found);
        }
        let planned = planned::<N>(&self.args, &self.limits, &self.table, &Silent)?;
        let measured = figures(&self.args, &planned, &self.table)?;
        Ok(self.figures.get_or_init(|| measured))
    }

    fn sample(&self, axes: usize, period: f64) -> Result<Vec<f64>, Failure> {
        let points =
            setpoint::sample(&self.path, &self.schedule, period).map_err(Failure::input)?;
        let mut rows = Vec::new();
        for Setpoint { t, position, velocity, acceleration, jerk } in points {
            rows.push(t);
            for vector in [position, velocity, acceleration, jerk] {
                rows.extend(vector.iter().take(axes));
            }
        }
        Ok(rows)
    }
}

/// Plans the speed along a table in memory, and writes nothing.
pub(crate) fn answer(
    args: FeedArgs,
    table: AxisTable<'_>,
    limits: &LimitsFile,
    progress: &dyn Progress,
) -> Result<PlanAnswer, Failure> {
    args.check(OutputForm::Text)?;
    jerks(&args, limits)?;
    rests(&args, limits)?;
    let table = Table::of_values(table, limits, args.method)?;
    match table.layout.axes() {
        0..=3 => answered::<3>(args, limits, table, progress),
        4..=5 => answered::<5>(args, limits, table, progress),
        6 => answered::<6>(args, limits, table, progress),
        7..=10 => answered::<10>(args, limits, table, progress),
        many => Err(too_many(&args, many)),
    }
}

fn answered<const N: usize>(
    args: FeedArgs,
    limits: &LimitsFile,
    table: Table,
    progress: &dyn Progress,
) -> Result<PlanAnswer, Failure> {
    let axes = table.layout.names().to_vec();
    let measured = OnceLock::new();
    let (path, schedule) = if args.no_guarantee {
        let prepared = PreparedPlan::<N>::new(&args, limits, &table)?;
        let PreparedPlan { path, limits, options, .. } = &prepared;
        let schedule = optimal_schedule(path, limits, options, progress);
        let schedule = schedule.map_err(|error| refused(&args, error))?;
        (prepared.path, schedule)
    } else {
        let planned = planned::<N>(&args, limits, &table, progress)?;
        let _ = measured.set(figures(&args, &planned, &table)?);
        (planned.path, planned.plan.schedule)
    };
    let (limits, figures) = (limits.clone(), measured);
    let motion = Box::new(KeptPlan { args, limits, table, path, schedule, figures });
    Ok(PlanAnswer { axes, motion })
}

fn figures<const N: usize>(
    args: &FeedArgs,
    planned: &Planned<N>,
    table: &Table,
) -> Result<PlanFigures, Failure> {
    let summary = summary::of(args, planned, table);
    let within_limits = summary.within_limits;
    let summary = serde_json::to_value(&summary).map_err(anyhow::Error::from)?;
    Ok(PlanFigures { summary, within_limits, lower_bound: planned.plan.lower_bound })
}
