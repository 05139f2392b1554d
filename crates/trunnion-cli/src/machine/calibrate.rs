//! `trunnion machine calibrate`: a machine file from measured spheres.

use crate::form::OutputForm;
use crate::option_values::{finite, positive};
use crate::outcome::{Done, Failure};
use crate::{machine, output, text};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trunnion::calibrate::{
    CalibrationOptions, CalibrationReport, DeviationCombination, DeviationEstimate, DeviationKind,
    FurtherReading, calibrate, further_readings,
};
use trunnion::files::machine::{MachineFile, write};
use trunnion::files::measurements::MeasurementTable;
use trunnion::machine::{AxisKind, Machine, MachineSpec};

/// Factor from the standard uncertainty to the one that is printed: 95 %.
const COVERAGE: f64 = 2.0;

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct CalibrateArgs {
    /// Tables of readings (CSV).
    #[arg(required = true)]
    measurements: Vec<PathBuf>,
    /// Machine file to calibrate, or name of a built-in machine.
    #[arg(short, long)]
    machine: String,
    /// Calibrated machine file to write; without it, the result is only printed.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Gauge point to the centre of the probe ball or sphere in the spindle, in mm, for tables without `length_mm`.
    #[arg(long, value_name = "L", default_value = "0", value_parser = finite, allow_hyphen_values = true)]
    tool_length: f64,
    /// Standard deviation of a reading, in mm [default: from the residuals].
    #[arg(long, value_name = "MM", value_parser = positive, allow_hyphen_values = true)]
    noise: Option<f64>,
}

const EXAMPLES: &str = "\
Columns are matched by name, others ignored; the unit is part of the name. Lines starting with # are comments.
  X_mm,Y_mm,Z_mm,C_deg,B_deg   position of the axes (also _inch, _rad), one column for each axis
  length_mm                    gauge point to the centre of the ball in the spindle [default: --tool-length]
  sphere                       number of the sphere on the table, 1 if there is no such column; its place is not needed
  dx_mm,dy_mm,dz_mm            ball in the spindle less sphere, in the directions of the workpiece (R-test); without
                               them the ball was at the centre of the sphere (spindle probe)
  radius_mm                    distance of both centres instead (ball bar)
The fit has thirteen deviations: place and tilt of both rotary axes, squareness of X, Y and Z, tilt of the tool axis.
The tilt of the tool shows only with two lengths. Uncertainties are for 95 %. X and the gauge point define the frame.
Exit codes: 0 the readings determine every deviation; 1 they leave some open, or contradict each other; 2 the input is
malformed, or the readings are of another machine; nothing is written.

  trunnion machine calibrate probe.csv -m bc-trunnion --tool-length 150 -o calibrated.toml
  trunnion machine calibrate short.csv long.csv ballbar.csv -m my.toml -o calibrated.toml";

pub(crate) fn run(args: &CalibrateArgs, form: OutputForm) -> Result<Done, Failure> {
    if let Some(path) = &args.output {
        output::refuse_existing(path)?;
    }
    let found = answer(args)?;
    if let Some(path) = &args.output {
        output::file(path, |out| out.write_all(found.text.as_bytes()))?;
    }
    form.print(&found.summary, CalibrationSummary::describe)?;
    Ok(if found.complete { Done::Kept } else { Done::Broken })
}

/// Errors of a machine that were found, for callers in other languages.
#[derive(Debug)]
#[non_exhaustive]
pub struct CalibrationAnswer {
    /// Summary as `--json` prints it.
    pub summary: CalibrationSummary,
    /// The same for people.
    pub table: String,
    /// The calibrated machine file.
    pub text: String,
    /// True if the readings determine every deviation, and none contradicts the others.
    pub complete: bool,
}

/// Fits the deviations, and writes nothing.
pub(crate) fn answer(args: &CalibrateArgs) -> Result<CalibrationAnswer, Failure> {
    let MachineFile { machine, spec, .. } = machine::load(&args.machine)?;
    let mut table = MeasurementTable::default();
    let mut rows = Vec::new();
    for file in &args.measurements {
        let content = text::read(file)?;
        let added = table.add(&content, &machine, args.tool_length);
        added.map_err(|faults| Failure::faults(file, &faults))?;
        rows.resize(table.readings.len(), file.as_path());
    }
    let options = CalibrationOptions { noise: args.noise, ..CalibrationOptions::standard() };
    let report = calibrate(&machine, &table.readings, options).map_err(|error| {
        let names: Vec<String> =
            args.measurements.iter().map(|file| file.display().to_string()).collect();
        Failure::input(format!("{}: {error}\n  help: {}", names.join(", "), error.remedy()))
    })?;
    let further = further_readings(&table.readings, &report, options.weak);
    let rows = Rows { table: &table, files: &rows };
    let summary = CalibrationSummary::new(args, &machine, &report, &further, &rows);
    let text = write(&calibrated(&spec, &report.machine), &summary.notes());
    let complete = report.confounded.is_empty() && report.contradicting.is_empty();
    Ok(CalibrationAnswer { table: summary.describe(), summary, text, complete })
}

/// Puts directions and points of the calibrated machine into the content of the file.
fn calibrated(spec: &MachineSpec, machine: &Machine) -> MachineSpec {
    let mut spec = spec.clone();
    for axis in &mut spec.axes {
        let Some(found) = machine.axes.iter().find(|found| found.name == axis.name) else {
            continue;
        };
        axis.dir = found.dir.into_inner().into();
        if axis.kind == AxisKind::Rotary {
            axis.point = Some(found.point.into());
        }
    }
    spec.tool_axis = machine.tool_axis.into_inner().into();
    spec
}

/// Rows behind the readings.
struct Rows<'a> {
    table: &'a MeasurementTable,
    files: &'a [&'a Path],
}

/// Result for scripts; mm and degrees.
#[derive(Debug, serde::Serialize)]
pub struct CalibrationSummary {
    machine: String,
    measurements: Vec<String>,
    readings: usize,
    /// Root mean square of the residuals of a number, mm, with the file and with the result.
    rms_before: f64,
    rms: f64,
    /// Noise of a number, mm, and numbers read less numbers found.
    noise: f64,
    freedom: usize,
    errors: Vec<DeviationJson>,
    /// Changes that no reading notices: name and amount of each part.
    confounded: Vec<Vec<PartJson>>,
    further: Vec<FurtherJson>,
    contradicting: Vec<ContradictionJson>,
    /// Centres of the spheres, machine coordinates with all axes at zero.
    spheres: Vec<[f64; 3]>,
    output: Option<String>,
}

#[derive(Debug, serde::Serialize)]
struct DeviationJson {
    name: String,
    meaning: String,
    unit: &'static str,
    value: f64,
    /// Expanded uncertainty (95 %); `null`: not found by itself.
    uncertainty: Option<f64>,
}

#[derive(Debug, serde::Serialize)]
struct PartJson {
    name: String,
    unit: &'static str,
    change: f64,
}

#[derive(Debug, serde::Serialize)]
struct FurtherJson {
    words: String,
    fixes: usize,
    /// Axis positions, mm and degrees.
    positions: Vec<Vec<f64>>,
}

#[derive(Debug, serde::Serialize)]
struct ContradictionJson {
    file: String,
    line: u64,
    residual: f64,
}

impl CalibrationSummary {
    fn new(
        args: &CalibrateArgs,
        machine: &Machine,
        report: &CalibrationReport,
        further: &[FurtherReading],
        rows: &Rows<'_>,
    ) -> Self {
        let contradiction = |&index: &usize| ContradictionJson {
            file: rows.files.get(index).map(|file| file.display().to_string()).unwrap_or_default(),
            line: rows.table.lines.get(index).copied().unwrap_or_default(),
            residual: report.residuals.get(index).copied().unwrap_or_default(),
        };
        Self {
            machine: args.machine.clone(),
            measurements: args.measurements.iter().map(|file| file.display().to_string()).collect(),
            readings: rows.table.readings.len(),
            rms_before: report.rms_before,
            rms: report.rms,
            noise: report.noise,
            freedom: report.freedom,
            errors: report.estimates.iter().map(|one| DeviationJson::of(one, machine)).collect(),
            confounded: report.confounded.iter().map(|one| parts(one, machine)).collect(),
            further: further.iter().map(|one| FurtherJson::of(one, machine)).collect(),
            contradicting: report.contradicting.iter().map(contradiction).collect(),
            spheres: report.spheres.iter().map(|center| center.coords.into()).collect(),
            output: args.output.as_ref().map(|path| path.display().to_string()),
        }
    }

    fn describe(&self) -> String {
        let mut text = format!(
            "{} readings; off the file by {:.4} mm (rms), off the result by {:.4} mm; noise of a number {:.4} mm\n\n",
            self.readings, self.rms_before, self.rms, self.noise
        );
        for line in self.table() {
            text.push_str(&line);
            text.push('\n');
        }
        self.describe_open(&mut text);
        for one in &self.contradicting {
            let ContradictionJson { file, line, residual } = one;
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "\n{file}:{line}: this reading is {residual:.4} mm off what the others say\n  help: measure it again, or leave the row out"
            );
        }
        if let Some(output) = &self.output {
            let _ = writeln!(text, "\nwrote {output}");
        }
        text
    }

    /// Returns the deviations as a table.
    fn table(&self) -> Vec<String> {
        let head = format!("{:<12} {:>10} {:>10}  {:<5} {}", "error", "value", "+-", "", "meaning");
        let row = |one: &DeviationJson| {
            let scale = if one.unit == "deg" { 1e6_f64.to_radians() } else { 1e3 };
            let unit = if one.unit == "deg" { "urad" } else { "um" };
            let uncertainty =
                one.uncertainty.map_or("open".to_owned(), |by| format!("{:.2}", by * scale));
            format!(
                "{:<12} {:>10.2} {uncertainty:>10}  {unit:<5} {}",
                one.name,
                one.value * scale,
                one.meaning
            )
        };
        std::iter::once(head).chain(self.errors.iter().map(row)).collect()
    }

    /// Appends the combinations that stay open, and the readings that would fix them.
    fn describe_open(&self, text: &mut String) {
        for parts in &self.confounded {
            let _ = writeln!(text, "\n{}", open_words(parts));
        }
        if !self.further.is_empty() {
            text.push_str("\nfurther readings that would separate them:\n");
        }
        for one in &self.further {
            let _ = writeln!(text, "  {}", one.words);
        }
        if !self.confounded.is_empty() && self.further.is_empty() {
            text.push_str(
                "no further sphere within the travel separates them: they stay as in the machine file\n",
            );
        }
    }

    /// Returns the comments of the calibrated file.
    fn notes(&self) -> Vec<String> {
        let mut notes = vec![format!(
            "Calibrated by trunnion from {} and {} readings: {}.",
            self.machine,
            self.readings,
            self.measurements.join(", ")
        )];
        notes.push("Deviations from that machine file, uncertainties for 95 %:".to_owned());
        notes.extend(self.table());
        notes.extend(self.confounded.iter().map(|parts| open_words(parts)));
        notes
    }
}

/// Says which deviations only show together.
fn open_words(parts: &[PartJson]) -> String {
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    if let [one] = names.as_slice() {
        return format!("no reading depends on {one}: it stays as in the machine file");
    }
    let amount = |part: &PartJson| format!("{:+.4} {} of {}", part.change, part.unit, part.name);
    let amounts: Vec<String> = parts.iter().map(amount).collect();
    format!(
        "the readings do not separate {}: together, {} change none of them",
        names.join(", "),
        amounts.join(", ")
    )
}

/// Returns the factor to the unit of the summary, and its name.
fn unit(kind: DeviationKind) -> (f64, &'static str) {
    match kind {
        DeviationKind::Offset => (1.0, "mm"),
        DeviationKind::Tilt => (1.0_f64.to_degrees(), "deg"),
    }
}

impl DeviationJson {
    fn of(one: &DeviationEstimate, machine: &Machine) -> Self {
        let (factor, unit) = unit(one.deviation.kind);
        Self {
            name: one.deviation.name(machine),
            meaning: one.deviation.words(machine),
            unit,
            value: one.value * factor,
            uncertainty: one.uncertainty.map(|by| COVERAGE * by * factor),
        }
    }
}

fn parts(one: &DeviationCombination, machine: &Machine) -> Vec<PartJson> {
    let part = |part: &trunnion::calibrate::CombinationPart| {
        let (factor, unit) = unit(part.deviation.kind);
        PartJson { name: part.deviation.name(machine), unit, change: part.change * factor }
    };
    one.parts.iter().map(part).collect()
}

impl FurtherJson {
    fn of(one: &FurtherReading, machine: &Machine) -> Self {
        let degrees = |value: f64| (value.to_degrees() * 1e3).round() / 1e3 + 0.0;
        let [.., first, second] = &machine.axes;
        let position = |reading: &trunnion::calibrate::SphereReading| {
            let [x, y, z, a, b] = reading.q.into();
            vec![x, y, z, degrees(a), degrees(b)]
        };
        let positions: Vec<Vec<f64>> = one.readings.iter().map(position).collect();
        let rotary = positions.iter().map(|q| match q.as_slice() {
            [.., a, b] => format!("{} {a} {} {b}", first.name, second.name),
            _ => String::new(),
        });
        let rotary: Vec<String> = rotary.collect();
        let mut words = format!("at {}", rotary.join("; "));
        if let Some(beside) = one.second_sphere {
            let [x, y, z]: [f64; 3] = beside.into();
            words = format!("a second sphere, ({x}, {y}, {z}) mm from the first, {words}");
        }
        if one.longer > 0.0 {
            let _ = write!(words, " with a ball {} mm farther from the spindle", one.longer);
        } else if one.longer < 0.0 {
            let _ = write!(words, " with a ball {} mm nearer to the spindle", -one.longer);
        }
        Self { words, fixes: one.fixes, positions }
    }
}
