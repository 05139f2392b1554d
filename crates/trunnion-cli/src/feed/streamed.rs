//! `trunnion feed --stream`: a table of any length, planned row by row through a window.

use super::args::{FeedArgs, FeedMethod};
use super::layout::{JumpPosition, Layout, Next, PieceInterval, ThirdTolerance, columns};
use super::path::Rest;
use super::plan::LEAST_ROWS;
use super::refusal::refusal;
use super::schedule::{HEADER, write_row};
use super::summary::{MOST_LISTED, ROUNDING, Share, print, report_rests};
use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::table::{Faults, each_of};
use anyhow::Context;
use std::io::Write;
use std::path::Path;
use std::time::Instant;
use trunnion::feed::{
    AnyStream, FeedError, LimitRatios, Limits, ProgrammedSpeeds, StreamKind, StreamOptions,
    StreamStep,
};
use trunnion::files::limits::LimitsFile;
use trunnion::types::{AxisNode, AxisPiece, Diagnostic, Motion};

/// Results of the first reading; the second plans.
struct Survey {
    layout: Layout,
    rows: u64,
    /// Length of all pieces.
    length: f64,
    /// Largest third derivative of each axis of the table.
    largest: Vec<f64>,
    /// Lines of the rows that begin a piece.
    rests: Vec<Rest>,
    more_rests: usize,
}

/// Last row read.
#[derive(Clone, Copy)]
struct Last<const N: usize> {
    line: u32,
    node: AxisNode<N>,
    /// Number of rows of its piece up to it.
    of_piece: usize,
}

/// Writer of the schedule: the last row of a piece waits for the row after it.
struct Writer<'a> {
    /// Table, for messages.
    name: &'a Path,
    out: &'a mut dyn Write,
    line: String,
    last: Option<StreamStep>,
    rows: u64,
}

/// Result of planning.
struct Outcome {
    duration: f64,
    points: u64,
    /// Guaranteed bounds, where the planner keeps them.
    bounds: Option<LimitRatios>,
}

/// Summary for scripts.
#[derive(Debug, serde::Serialize)]
struct StreamSummary {
    method: &'static str,
    window: Option<u32>,
    stream: bool,
    guarantee: bool,
    /// Time the schedule takes \[s\].
    duration: f64,
    /// Time reading, planning and writing took \[s\], wall clock; not part of what is the same from run to run.
    seconds: f64,
    /// Rows read.
    read: u64,
    /// Rows of the schedule.
    points: u64,
    /// Largest values over their limits, guaranteed everywhere; without jerk limits they are kept by how it is planned.
    #[serde(skip_serializing_if = "Option::is_none")]
    bounds: Option<Share>,
    /// Places inside the path at which the axes rest.
    rests: usize,
    within_limits: bool,
    output: String,
}

/// Returns the number of axes to plan for.
pub(super) fn axes(args: &FeedArgs, limits: &LimitsFile) -> Result<usize, Failure> {
    let names = args.ends.columns(|header| columns(header, limits, args.method))?;
    Ok(Layout::new(&names, limits).axes())
}

pub(super) fn run<const N: usize>(
    args: &FeedArgs,
    form: OutputForm,
    file: &LimitsFile,
) -> Result<Done, Failure> {
    let start = Instant::now();
    let survey = survey::<N>(args, file)?;
    let limits: Result<(Limits<N>, _), _> = survey.layout.limits(file, args.period);
    let (limits, _) = limits.map_err(|error| refusal(&args.limits, error))?;
    report_rests(&survey.rests, survey.more_rests);
    let Outcome { duration, points, bounds } =
        args.ends.write_checked(|out| planned(args, file, &survey, &limits, out))?;
    let kept = |ratio: f64| ratio <= 1.0 + ROUNDING;
    // Without jerk limits the planner keeps the others by construction, and states no bounds.
    let within = bounds.is_none_or(|bounds| {
        let LimitRatios { velocity, acceleration, jerk, .. } = bounds;
        kept(velocity) && kept(acceleration) && jerk.is_none_or(kept)
    });
    let summary = StreamSummary {
        method: args.method.name(),
        window: args.window,
        stream: true,
        guarantee: true,
        duration,
        seconds: start.elapsed().as_secs_f64(),
        read: survey.rows,
        points,
        bounds: bounds.map(Share::from),
        rests: survey.rests.len() + survey.more_rests,
        within_limits: within,
        output: args.ends.output().display().to_string(),
    };
    print(args, form, &summary, describe)?;
    Ok(if within { Done::Kept } else { Done::Broken })
}

fn describe(summary: &StreamSummary) -> String {
    let StreamSummary { duration, seconds, read, points, within_limits, .. } = summary;
    let kept = if *within_limits { "every limit is kept" } else { "a limit is broken" };
    let wrote = &summary.output;
    let wrote = if wrote == "-" { String::new() } else { format!("wrote {wrote}\n") };
    format!("{duration:.6} s; {kept}\n{points} rows of {read} read, in {seconds:.4} s\n{wrote}")
}

/// Reads the table once, for the faults of its rows and for the data that planning needs beforehand.
fn survey<const N: usize>(args: &FeedArgs, file: &LimitsFile) -> Result<Survey, Failure> {
    let name = args.ends.name();
    let names = args.ends.columns(|header| columns(header, file, args.method))?;
    let layout = Layout::new(&names, file);
    let mut faults = Faults::default();
    let (mut rows, mut length) = (0, 0.0);
    let mut largest = vec![0.0_f64; layout.names().len()];
    let (mut rests, mut more_rests) = (Vec::new(), 0);
    let mut last: Option<Last<N>> = None;
    let choose = |header: &_| columns(header, file, args.method);
    each_of(name, choose, |line, _, _, values| {
        let node: AxisNode<N> = layout.node(line, values.iter().copied(), &mut faults);
        // The comparison of NAME3 is relative to the largest of the whole table, known after one reading.
        for (most, third) in largest.iter_mut().zip(node.q[3].iter()) {
            *most = most.max(third.abs());
        }
        let mut of_piece = 1;
        if let Some(Last { node: before, of_piece: up_to, .. }) = &last {
            let pair = [before, &node];
            let position = if *up_to >= 2 { JumpPosition::Inside } else { JumpPosition::AtEnd };
            if layout.next(line, pair, position, &mut faults) == Next::On {
                of_piece = up_to + 1;
                length += node.s - before.s;
            } else if rests.len() < MOST_LISTED {
                rests.push(Rest { s: node.s, line, jump: layout.jump(pair) });
            } else {
                more_rests += 1;
            }
        }
        rows += 1;
        last = Some(Last { line, node, of_piece });
        Ok(())
    })?;
    if rows < 2 {
        faults.add(
            Diagnostic::whole("a path needs at least two rows").with_help("add its other rows"),
        );
    }
    // A repeated row at the end of the path has no piece after it.
    if let Some(Last { line, node, .. }) = last.filter(|last| rows > 1 && last.of_piece < 2) {
        layout.next(line, [&node, &node], JumpPosition::AtEnd, &mut faults);
    }
    if !faults.is_empty() {
        return Err(Failure::faults(name, &faults.listed()));
    }
    Ok(Survey { layout, rows, length, largest, rests, more_rests })
}

/// Reads the table again, plans and writes.
fn planned<const N: usize>(
    args: &FeedArgs,
    file: &LimitsFile,
    survey: &Survey,
    limits: &Limits<N>,
    out: &mut dyn Write,
) -> Result<Outcome, Failure> {
    let (name, layout) = (args.ends.name(), &survey.layout);
    let refused = |error: FeedError| refusal(name, error);
    let window = args.window.unwrap_or(0) as usize;
    let (feed, step) = (layout.feed(), survey.length / LEAST_ROWS);
    // Rows farther apart than the step are divided, as in planning the whole table.
    let options = StreamOptions {
        speeds: ProgrammedSpeeds { feed, ..ProgrammedSpeeds::FASTEST },
        ..StreamOptions::fastest(window, step)
    };
    let kind = match args.method {
        FeedMethod::Jerk => StreamKind::Jerk,
        _ => StreamKind::Optimal,
    };
    let mut planner = AnyStream::new(kind, *limits, options).map_err(refused)?;
    let mut writer = Writer { name, out, line: String::new(), last: None, rows: 0 };
    writeln!(writer.out, "{HEADER}").context(WRITING)?;
    let tolerance = ThirdTolerance { limits, method: args.method, share: args.third_tolerance };
    let mut faults = Faults::default();
    let mut last: Option<Last<N>> = None;
    let mut pair = AxisPiece { motion: Motion::Cut, source: 0, nodes: Vec::with_capacity(2) };
    let choose = |header: &_| columns(header, file, args.method);
    each_of(name, choose, |line, _, _, values| {
        let node = layout.node(line, values.iter().copied(), &mut faults);
        let before = last.replace(Last { line, node, of_piece: 0 });
        match before.filter(|before| node.s > before.node.s) {
            Some(before) => {
                pair.nodes.clear();
                pair.nodes.extend([before.node, node]);
                let interval = PieceInterval { lines: [before.line, line], piece: &pair, index: 0 };
                for axis in layout.thirds() {
                    let largest = survey.largest.get(axis).copied().unwrap_or(0.0);
                    layout.third(&interval, axis, largest, &tolerance, &mut faults);
                }
            }
            None => planner.begin(Motion::Cut),
        }
        // After a fault nothing will be written; the rest is read for its faults only.
        if !faults.is_empty() {
            return Ok(());
        }
        planner.push(node).map_err(refused)?;
        // A full window yields steps until it wants another row.
        while !planner.wants() {
            let Some(step) = planner.next() else { break };
            writer.step(step)?;
        }
        Ok(())
    })?;
    if !faults.is_empty() {
        return Err(Failure::faults(name, &faults.listed()));
    }
    // At the end of the table the window empties.
    for step in planner.by_ref() {
        writer.step(step)?;
    }
    // A stream that stops short has no error of its own.
    let (reached, end) = (writer.last.map(|step| step.s.high), last.map(|last| last.node.s));
    if reached.is_none_or(|reached| end.is_some_and(|end| reached < end)) {
        return Err(refused(FeedError::Unresolved { piece: 0 }));
    }
    writer.end_piece()?;
    Ok(Outcome { duration: planner.time(), points: writer.rows, bounds: planner.bounds() })
}

const WRITING: &str = "writing the result";

impl Writer<'_> {
    /// Writes the start of a step; its end becomes a row only at the end of a piece.
    fn step(&mut self, step: StreamStep) -> Result<(), Failure> {
        if self.last.is_some_and(|last| last.piece != step.piece) {
            self.end_piece()?;
        }
        if !step.is_resolved() {
            return Err(refusal(self.name, FeedError::Unresolved { piece: step.piece }));
        }
        let StreamStep { s, t, speed, acceleration, .. } = step;
        self.row([s.low, t, speed.start, acceleration, step.at(0.0).jerk])?;
        self.last = Some(step);
        Ok(())
    }

    fn end_piece(&mut self) -> Result<(), Failure> {
        let Some(step) = self.last.take() else { return Ok(()) };
        let StreamStep { s, t, duration, speed, end_acceleration, .. } = step;
        self.row([s.high, t + duration, speed.end, end_acceleration, step.at(duration).jerk])
    }

    fn row(&mut self, numbers: [f64; 5]) -> Result<(), Failure> {
        self.rows += 1;
        write_row(&mut self.line, numbers);
        Ok(self.out.write_all(self.line.as_bytes()).context(WRITING)?)
    }
}
