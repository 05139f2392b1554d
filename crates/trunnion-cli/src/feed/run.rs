//! The verb: reads limits and table, plans, writes and reports.

use super::args::{FeedArgs, FeedMethod};
use super::path::{Table, TableNumbers};
use super::plan::{PlanInput, Planned, plan};
use super::refusal::refusal;
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
use trunnion::types::{AxisPath, Progress, Schedule, Setpoint, Silent, Stage};

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
    Table::read(&args.ends, &limits, args.method, |table, numbers| {
        let input = PathInput { args, limits: &limits, table, numbers };
        match table.layout.axes() {
            // Rounded up to the next compiled count: additional axes stand still and never bind.
            0..=3 => sized::<3>(&input, form),
            4..=5 => sized::<5>(&input, form),
            6 => sized::<6>(&input, form),
            7..=10 => sized::<10>(&input, form),
            many => Err(too_many(args, many)),
        }
    })
}

fn too_many(args: &FeedArgs, axes: usize) -> Failure {
    Failure::input(format!(
        "{}: {axes} axes, with the path's own limits; at most {} can be planned together\n  help: leave out axes that \
         stand still",
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

/// Table and limits that a path is made of.
struct PathInput<'a> {
    args: &'a FeedArgs,
    limits: &'a LimitsFile,
    table: &'a Table,
    numbers: &'a TableNumbers<'a>,
}

fn sized<const N: usize>(input: &PathInput<'_>, form: OutputForm) -> Result<Done, Failure> {
    let PathInput { args, table, .. } = *input;
    let prepared = PreparedPlan::<N>::new(input)?;
    let planned = prepared.planned(args, table, &Bars::new())?;
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
    fn new(input: &PathInput<'_>) -> Result<Self, Failure> {
        let PathInput { args, limits: file, table, numbers } = *input;
        let (limits, chords) =
            table.layout.limits(file, args.period).map_err(|error| refusal(&args.limits, error))?;
        let path = table.path(numbers, &limits, args)?;
        let mut options = FeedOptions::fastest();
        options.speeds.feed = table.layout.feed();
        options.time_tolerance = args.time_tolerance.unwrap_or(args.method.time_tolerance());
        options.end_speeds = PathEnds { start: file.path.start, end: file.path.end };
        options.guarantee = !args.no_guarantee;
        Ok(Self { path, limits, options, chords })
    }

    /// Plans the speed along the path.
    fn planned(
        &self,
        args: &FeedArgs,
        table: &Table,
        progress: &dyn Progress,
    ) -> Result<Planned<'_, N>, Failure> {
        let Self { path, limits, options, chords } = self;
        let start = Instant::now();
        let plan = plan(args, &PlanInput { path, table, limits, options }, progress);
        let seconds = start.elapsed().as_secs_f64();
        let (mut plan, breaches) = plan.map_err(|error| refused(args, error))?;
        // Limits that the chord error lowered are named after it.
        plan.name_chords(*chords);
        Ok(Planned { path, plan, breaches, seconds })
    }
}

fn refused(args: &FeedArgs, error: FeedError) -> Failure {
    match error {
        FeedError::Cancelled(_) => Failure::Stopped,
        error => refusal(args.ends.name(), error),
    }
}

/// Table of axis positions in memory.
#[derive(Debug, Clone, Copy)]
pub struct AxisTable<'a> {
    /// Names of the columns.
    pub names: &'a [String],
    /// Columns, as many as names.
    pub columns: &'a [AxisColumn<'a>],
}

/// Column of a table, where the caller has it in memory.
#[derive(Debug, Clone, Copy)]
pub struct AxisColumn<'a> {
    /// Numbers from the first of the column on.
    pub values: &'a [f64],
    /// Distance of neighbouring rows in `values`: 1 for a column of its own, the width of a table that is stored row by
    /// row.
    pub step: usize,
}

impl AxisColumn<'_> {
    /// Returns the number of rows.
    pub(super) fn len(&self) -> usize {
        self.values.len().div_ceil(self.step.max(1))
    }

    /// Returns the number of a row; 0 beyond the last.
    #[inline]
    pub(super) fn at(&self, row: usize) -> f64 {
        self.values.get(row * self.step).copied().unwrap_or(0.0)
    }
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
    fn sample(
        &self,
        axes: usize,
        period: f64,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Failure>;
}

/// Rows between two checks for cancellation.
const ROWS_A_STEP: u64 = 4096;

/// Plan that keeps all it needs to be measured later.
struct KeptPlan<const N: usize> {
    args: FeedArgs,
    table: Table,
    prepared: PreparedPlan<N>,
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
        let planned = self.prepared.planned(&self.args, &self.table, &Silent)?;
        let measured = figures(&self.args, &planned, &self.table)?;
        Ok(self.figures.get_or_init(|| measured))
    }

    fn sample(
        &self,
        axes: usize,
        period: f64,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Failure> {
        let points = setpoint::sample(&self.prepared.path, &self.schedule, period)
            .map_err(Failure::input)?;
        let mut rows = Vec::new();
        for (count, point) in (0_u64..).zip(points) {
            let Setpoint { t, position, velocity, acceleration, jerk } = point;
            // Reporting every row would cost more than computing it. How many there are the iterator does not know.
            if count.is_multiple_of(ROWS_A_STEP)
                && progress.report(Stage::Setpoints, count, 0).is_break()
            {
                return Err(Failure::Stopped);
            }
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
    let (table, numbers) = Table::of_columns(table, limits, args.method)?;
    let input = PathInput { args: &args, limits, table: &table, numbers: &numbers };
    let axes = table.layout.names().to_vec();
    let motion = match table.layout.axes() {
        0..=3 => PreparedPlan::<3>::new(&input)?.kept(args, table, progress),
        4..=5 => PreparedPlan::<5>::new(&input)?.kept(args, table, progress),
        6 => PreparedPlan::<6>::new(&input)?.kept(args, table, progress),
        7..=10 => PreparedPlan::<10>::new(&input)?.kept(args, table, progress),
        many => Err(too_many(&args, many)),
    };
    Ok(PlanAnswer { axes, motion: motion? })
}

impl<const N: usize> PreparedPlan<N> {
    /// Plans the speed along the path, and keeps all that can be asked for later.
    fn kept(
        self,
        args: FeedArgs,
        table: Table,
        progress: &dyn Progress,
    ) -> Result<Box<dyn PlannedMotion>, Failure> {
        let measured = OnceLock::new();
        let schedule = if args.no_guarantee {
            let Self { path, limits, options, .. } = &self;
            let schedule = optimal_schedule(path, limits, options, progress);
            schedule.map_err(|error| refused(&args, error))?
        } else {
            let planned = self.planned(&args, &table, progress)?;
            let _ = measured.set(figures(&args, &planned, &table)?);
            planned.plan.schedule
        };
        Ok(Box::new(KeptPlan { args, table, prepared: self, schedule, figures: measured }))
    }
}

fn figures<const N: usize>(
    args: &FeedArgs,
    planned: &Planned<'_, N>,
    table: &Table,
) -> Result<PlanFigures, Failure> {
    let summary = summary::of(args, planned, table);
    let within_limits = summary.within_limits;
    let summary = serde_json::to_value(&summary).map_err(anyhow::Error::from)?;
    Ok(PlanFigures { summary, within_limits, lower_bound: planned.plan.lower_bound })
}
