//! The verb: reads limits and table, plans, writes and reports.

use super::args::{FeedArgs, FeedMethod};
use super::path::Table;
use super::plan::{PlanInput, Planned, plan};
use super::{schedule, streamed, summary};
use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::{output, text};
use std::time::Instant;
use trunnion::feed::{FeedError, FeedOptions, Limits, PathEnds};
use trunnion::files::limits::{LimitsFile, parse};

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
    let (limits, chords): (Limits<N>, _) = table
        .layout
        .limits(file, args.period)
        .map_err(|error| Failure::input(format!("{}: {error}", args.limits.display())))?;
    let path = table.path(&limits, args)?;
    let mut options = FeedOptions::fastest();
    options.speeds.feed = table.layout.feed();
    options.time_tolerance = args.time_tolerance.unwrap_or(args.method.time_tolerance());
    options.end_speeds = PathEnds { start: file.path.start, end: file.path.end };
    options.guarantee = !args.no_guarantee;
    let progress = Bars::new();
    let start = Instant::now();
    let input = PlanInput { path: &path, table, limits: &limits, options: &options };
    let plan = plan(args, &input, &progress);
    let seconds = start.elapsed().as_secs_f64();
    let (mut plan, breaches) = plan.map_err(|error| match error {
        FeedError::Cancelled(_) => Failure::Stopped,
        error => Failure::input(format!("{}: {error}", args.ends.name().display())),
    })?;
    // Limits that the chord error lowered are named after it.
    plan.name_chords(chords);
    let planned = Planned { path, plan, breaches, seconds };
    schedule::write(args, &planned, table)?;
    summary::report(args, form, &planned, table)
}
