//! `trunnion check motion.csv`: a table of axis setpoints against the machine.

use super::args::CheckArgs;
use crate::form::OutputForm;
use crate::motion::SUFFIXES;
use crate::outcome::{Done, Failure};
use crate::output::Outputs;
use crate::progress::Bars;
use crate::report::AxisLimits;
use crate::{machine, report, run, table};
use std::path::{Path, PathBuf};
use trunnion::files::job::MotionMethod;
use trunnion::files::table::TableHeader;
use trunnion::machine::{AxisKind, Machine};
use trunnion::types::{AXES, AxisVector, Diagnostic, Diagnostics, Progress};
use trunnion::verify::{
    AxisMotion, MotionAudit, MotionError, MotionOptions, MotionReport, MotionRow, RowRatio,
};
use trunnion_report::{Motion, Number, Recorder, ReportData, Sample, State};

/// Returns true if the file name is that of a table of setpoints.
pub(super) fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
}

/// Summary of a table of setpoints: `summary.json` and `--json`; mm, degrees, s.
#[derive(Debug, serde::Serialize)]
pub(super) struct SetpointCheckSummary {
    schema: &'static str,
    generator: String,
    table: String,
    machine: String,
    pub(super) passed: bool,
    rows: usize,
    duration: f64,
    period: f64,
    /// Number of time derivatives in the rows.
    derivatives: usize,
    /// True if the jerk is judged.
    jerk_judged: bool,
    axes: Vec<AxisRates>,
    failures: Vec<String>,
    /// Files beside this one.
    files: Vec<String>,
}

#[derive(Debug, serde::Serialize)]
struct AxisRates {
    name: String,
    unit: &'static str,
    range: [f64; 2],
    velocity: RateRatio,
    acceleration: RateRatio,
    jerk: RateRatio,
}

#[derive(Debug, Clone, Copy, serde::Serialize)]
struct RateRatio {
    ratio: f64,
    line: u32,
    /// True if the rows around the line imply the rate; false if the line states it.
    between: bool,
    broken: usize,
}

/// Table, machine and options, before the rows are judged.
struct Table {
    machine: Machine,
    options: MotionOptions,
    /// Time of the last row \[s\].
    end: f64,
}

pub(super) fn check(args: &CheckArgs, form: OutputForm) -> Result<Done, Failure> {
    let bars = Bars::new();
    let (summary, places) = judged(args, &bars)?;
    bars.finish();
    form.print(&summary, |summary| summary.table(&places))?;
    Ok(if summary.passed { Done::Kept } else { Done::Broken })
}

/// Judges the rows, and writes the report files where the arguments name a folder.
pub(super) fn judged(
    args: &CheckArgs,
    progress: &dyn Progress,
) -> Result<(SetpointCheckSummary, Vec<PathBuf>), Failure> {
    // Before anything is read: these options would be ignored silently.
    only_axes(args)?;
    let table = Table::open(args, progress)?;
    if let Some(folder) = &args.output {
        Outputs::probe(folder)?;
    }
    let (found, charts) = table.audit(&args.program)?;
    let mut summary = SetpointCheckSummary::new(args, &table, &found);
    let places = match &args.output {
        Some(folder) => summary.write(charts, folder)?,
        None => Vec::new(),
    };
    Ok((summary, places))
}

/// Refuses options about the part, which a table of setpoints does not know.
fn only_axes(args: &CheckArgs) -> Result<(), Failure> {
    let given = [
        ("--part", args.part.is_some()),
        ("--cutter", !args.cutter.is_empty()),
        ("--tolerance", args.tolerance.is_some()),
        ("--stock", args.stock.is_some()),
        ("--fixture", !args.fixture.is_empty()),
        ("--clearance", args.clearance.is_some()),
        ("--what-if", !args.what_if.is_empty()),
        ("--accept", !args.accept.is_empty()),
        ("--control", args.control.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((name, _)) => Err(Failure::input(format!(
            "{}: setpoints are checked against the machine alone: {name} does not apply\n  help: leave it \
             out, or check the program",
            args.program.display()
        ))),
        None => Ok(()),
    }
}

impl Table {
    /// Reads the machine, and the table once for its decimals and its period.
    fn open(args: &CheckArgs, bars: &dyn Progress) -> Result<Self, Failure> {
        let (machine, period, jerk) = match (&args.job, &args.machine) {
            (Some(path), _) => {
                let (job, _) = run::load(path, None, bars)?;
                let motion = &job.file.motion;
                // `optimal` plans without jerk limits: its jerk is reported only.
                let jerk = motion.method != MotionMethod::Optimal;
                (job.kinematics.machine().clone(), Some(motion.servo_period), jerk)
            }
            (None, Some(name)) => {
                let machine = machine::load(name)?.machine;
                let period = machine.cycle.servo_period;
                (machine, period, true)
            }
            (None, None) => {
                let help = "add --machine M, or --job JOB.toml";
                let place = args.program.display();
                return Err(Failure::input(format!(
                    "{place}: setpoints need a machine\n  help: {help}"
                )));
            }
        };
        let looks = TableSurvey::of(&args.program, &machine)?;
        // The option beats the job, the job the machine; the rows decide if none states a period.
        let period = args.period.or(period).unwrap_or_else(|| looks.period());
        let options = MotionOptions {
            // The first of the names is the time, which the division drops.
            derivatives: looks.names.len() / AXES - 1,
            time_rounding: looks.rounding(0),
            rounding: looks.roundings(&machine),
            jerk: jerk && !args.no_jerk,
            ..MotionOptions::positions(period)
        };
        Ok(Self { machine, options, end: looks.last })
    }

    /// Reads and judges the rows, and records them for the charts.
    fn audit(&self, path: &Path) -> Result<(MotionReport, Motion), Failure> {
        let fault = |error: MotionError| match error {
            MotionError::Time { line, .. } => {
                let message = error.to_string();
                // The position is added in the form of all diagnostics.
                let message = message.split_once(": ").map_or(message.as_str(), |(_, rest)| rest);
                let fault =
                    Diagnostic { line, column: 1, message: message.into(), help: String::new() };
                Failure::faults(path, &[fault])
            }
            error => Failure::input(format!("{}: {error}", path.display())),
        };
        let names = columns(&self.machine, self.options.derivatives);
        let mut audit = MotionAudit::new(&self.machine, self.options.clone()).map_err(fault)?;
        let limits = self.machine.vector(|axis| axis.acc);
        let axes = self.machine.axes.iter().zip(limits.iter());
        let axes = axes.map(|(axis, acc)| {
            let limits = AxisLimits { acceleration: *acc, chord: false, jerk: self.options.jerk };
            report::axis(axis, &limits)
        });
        // One pass feeds the charts and the audit: tables may be too long for memory.
        let mut recorder = Recorder::new(axes.collect(), self.end, report::SLOTS, 0.0);
        table::each_of(
            path,
            |_| Ok(names.clone()),
            |line, _, _, values| {
                let (t, values) = values.split_first().unwrap_or((&0.0, &[]));
                let row = |order: usize| values.get(order * AXES..(order + 1) * AXES);
                let at = |order| row(order).unwrap_or(&[0.0; AXES]);
                recorder.add(&Sample {
                    t: *t,
                    position: at(0),
                    velocity: at(1),
                    acceleration: at(2),
                    jerk: at(3),
                    speed: 0.0,
                    tip: 0.0,
                    cutting: false,
                });
                let values = [0, 1, 2, 3].map(|order| self.inside(at(order)));
                audit.push(&MotionRow { line, t: *t, values }).map_err(fault)
            },
        )?;
        Ok((audit.finish().map_err(fault)?, recorder.finish()))
    }

    /// Converts the numbers of a row to mm and rad.
    fn inside(&self, values: &[f64]) -> AxisVector {
        let mut inside = AxisVector::from_iterator(values.iter().copied());
        for (value, axis) in inside.iter_mut().zip(&self.machine.axes) {
            if axis.kind == AxisKind::Rotary {
                // Tables are in degrees, the audit in radians.
                *value = value.to_radians();
            }
        }
        inside
    }
}

/// Returns the columns of a table with so many derivatives.
fn columns(machine: &Machine, derivatives: usize) -> Vec<String> {
    let of = |suffix: &'static str| {
        machine.axes.iter().map(move |axis| format!("{}{suffix}", axis.name))
    };
    let all = SUFFIXES.into_iter().take(derivatives + 1).flat_map(of);
    std::iter::once("t".to_owned()).chain(all).collect()
}

/// Properties of all rows, found before they are judged.
struct TableSurvey {
    names: Vec<String>,
    /// Largest number of decimals in each column.
    decimals: Vec<usize>,
    rows: usize,
    /// Times of the first two rows and the last two.
    first: [f64; 2],
    before: f64,
    last: f64,
}

impl TableSurvey {
    fn of(path: &Path, machine: &Machine) -> Result<Self, Failure> {
        let mut looks = Self {
            names: Vec::new(),
            decimals: vec![0; SUFFIXES.len() * AXES + 1],
            rows: 0,
            first: [0.0; 2],
            before: 0.0,
            last: 0.0,
        };
        // As many derivatives as have a column; a missing axis among them is reported as a fault.
        let choose = |header: &TableHeader| -> Result<Vec<String>, Diagnostics> {
            let has = |order: &usize| {
                let wanted = columns(machine, *order);
                let wanted = &wanted[wanted.len() - AXES..];
                header.names().iter().any(|name| wanted.contains(name))
            };
            Ok(columns(machine, (1..SUFFIXES.len()).take_while(has).count()))
        };
        looks.names = table::each_of(path, choose, |_, text, columns, values| {
            columns.decimals(text, &mut looks.decimals);
            let t = values.first().copied().unwrap_or_default();
            if let Some(first) = looks.first.get_mut(looks.rows) {
                *first = t;
            }
            (looks.before, looks.last) = (looks.last, t);
            looks.rows += 1;
            Ok(())
        })?;
        Ok(looks)
    }

    /// Returns half a unit of the last decimal of a column.
    fn rounding(&self, column: usize) -> f64 {
        let decimals = self.decimals.get(column).copied().unwrap_or(0);
        0.5 * 10.0_f64.powi(-i32::try_from(decimals).unwrap_or(i32::MAX))
    }

    /// Returns the rounding of positions and derivatives. Every column takes that of the finest one of its order,
    /// because numbers may be written without trailing zeros.
    fn roundings(&self, machine: &Machine) -> [AxisVector; 4] {
        [0, 1, 2, 3].map(|order| {
            let columns = order * AXES + 1..(order + 1) * AXES + 1;
            let finest = columns.map(|column| self.rounding(column)).fold(0.5, f64::min);
            machine.vector(|axis| match axis.kind {
                AxisKind::Rotary => finest.to_radians(),
                AxisKind::Linear => finest,
            })
        })
    }

    /// Returns the period of the rows: the shortest decimal number that agrees with the times of the first row and
    /// the last but one.
    fn period(&self) -> f64 {
        let [start, second] = self.first;
        let step = second - start;
        let whole = self.before - start;
        // The last row may end early, so the whole number of steps is counted up to the one before.
        let steps = (whole / step).round().max(1.0);
        // Both times are rounded: the mean is off by at most two roundings over all steps.
        let (mean, error) = (whole.max(step) / steps, 2.0 * self.rounding(0) / steps);
        let shortest = (0..17).map(|digits| format!("{mean:.digits$e}").parse().unwrap_or(mean));
        shortest.into_iter().find(|short| (short - mean).abs() <= error).unwrap_or(mean)
    }
}

impl SetpointCheckSummary {
    fn new(args: &CheckArgs, table: &Table, found: &MotionReport) -> Self {
        Self {
            schema: "trunnion-motion-check/1",
            generator: format!("trunnion {}", env!("CARGO_PKG_VERSION")),
            table: args.program.display().to_string(),
            machine: table.machine.name.clone(),
            passed: found.findings.is_empty(),
            rows: found.rows,
            duration: found.duration,
            period: found.period,
            derivatives: table.options.derivatives,
            jerk_judged: table.options.jerk,
            axes: found.axes.iter().map(AxisRates::of).collect(),
            failures: found.findings.iter().map(ToString::to_string).collect(),
            files: Vec::new(),
        }
    }

    fn write(&mut self, charts: Motion, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
        self.files = vec!["report.html".to_owned()];
        let mut outputs = Outputs::open(folder)?;
        outputs.text("report.html", &self.page(charts)?)?;
        let summary = serde_json::to_string_pretty(&self).map_err(anyhow::Error::from)?;
        outputs.text("summary.json", &(summary + "\n"))?;
        Ok(outputs.commit()?)
    }

    fn page(&self, charts: Motion) -> Result<String, Failure> {
        let verdict = match &self.failures[..] {
            [] => vec!["the setpoints keep every limit, at the rows and between them".to_owned()],
            failures => failures.to_vec(),
        };
        let data = ReportData {
            job: self.table.clone(),
            machine: self.machine.clone(),
            generator: self.generator.clone(),
            passed: self.passed,
            verdict,
            numbers: self.numbers(),
            // Without derivatives there is nothing to draw against limits.
            motion: if self.derivatives == 3 { charts } else { Motion::default() },
            ..ReportData::default()
        };
        Ok(trunnion_report::render(&data).map_err(anyhow::Error::from)?)
    }

    /// Rates of an axis by name; true for those that are judged.
    fn rates(&self, axis: &AxisRates) -> [(&'static str, RateRatio, bool); 3] {
        [
            ("velocity", axis.velocity, true),
            ("acceleration", axis.acceleration, true),
            ("jerk", axis.jerk, self.jerk_judged),
        ]
    }

    fn numbers(&self) -> Vec<Number> {
        let mut numbers = vec![
            plain("time", format!("{:.3}", self.duration), "s"),
            plain("rows", self.rows.to_string(), ""),
        ];
        for axis in &self.axes {
            for (name, rate, judged) in self.rates(axis) {
                let good = rate.ratio <= 1.0;
                numbers.push(Number {
                    label: format!("{} {name}", axis.name),
                    value: format!("{:.2}", 100.0 * rate.ratio),
                    unit: "%".to_owned(),
                    note: format!("of its limit, at line {}", rate.line),
                    // A rate that is not judged has no colour, whatever its ratio.
                    state: match (judged, good) {
                        (false, _) => State::Plain,
                        (true, true) => State::Good,
                        (true, false) => State::Bad,
                    },
                    headline: false,
                });
            }
        }
        numbers
    }

    /// Returns the table for people.
    pub(super) fn table(&self, places: &[PathBuf]) -> String {
        let kept = if self.passed { "every limit is kept" } else { "NOT KEPT" };
        let mut lines = vec![format!("{}: {kept}", self.table)];
        let mut row = |name: &str, value: String| lines.push(format!("  {name:<14}{value}"));
        let Self { rows, duration, period, .. } = self;
        row("rows", format!("{rows} over {duration:.3} s, expected every {:.6} ms", 1e3 * period));
        for axis in &self.axes {
            let [low, high] = axis.range;
            let rates = self.rates(axis).map(|(name, rate, judged)| {
                let judged = if judged { "" } else { ", not judged" };
                format!("{name} {:.2} % (line {}{judged})", 100.0 * rate.ratio, rate.line)
            });
            let value = format!("{low:.3} .. {high:.3} {}, {}", axis.unit, rates.join(", "));
            row(&format!("axis {}", axis.name), value);
        }
        lines.extend(self.failures.iter().map(|failure| format!("broken: {failure}")));
        lines.extend(places.iter().map(|place| format!("wrote {}", place.display())));
        lines.join("\n") + "\n"
    }
}

fn plain(label: &str, value: String, unit: &str) -> Number {
    let (label, unit) = (label.to_owned(), unit.to_owned());
    Number { label, value, unit, headline: true, ..Number::default() }
}

impl AxisRates {
    fn of(axis: &AxisMotion) -> Self {
        let rotary = axis.kind == AxisKind::Rotary;
        let rate = |RowRatio { worst, line, between, broken, .. }: RowRatio| RateRatio {
            ratio: worst,
            line,
            between,
            broken,
        };
        let [velocity, acceleration, jerk] = axis.rates.map(rate);
        Self {
            name: axis.name.clone(),
            unit: if rotary { "deg" } else { "mm" },
            range: if rotary { axis.range.ends().map(f64::to_degrees) } else { axis.range.ends() },
            velocity,
            acceleration,
            jerk,
        }
    }
}
