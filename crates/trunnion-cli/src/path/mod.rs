//! `trunnion path`: cutter locations of a job, or of a CL file, smoothed.

pub(crate) mod chart;
mod smoothed;

use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::{output, run as jobs, text};
use serde::Serialize;
use smoothed::Sheet;
use std::path::{Path, PathBuf};
use trunnion::nc::read;
use trunnion::pipeline;

/// Most faults of a CL file that are told.
const MOST_FAULTS: usize = 20;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Job file (TOML), or a CL file (APT/CL records).
    input: PathBuf,
    /// CL file to write [default: stdout].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Lay a C3 path within these of the cutter locations: mm at the tip, degrees of the tool axis.
    /// What is written stays within them everywhere.
    #[arg(long, value_name = "TIP,AXIS", value_parser = tolerances, allow_hyphen_values = true)]
    smooth: Option<[f64; 2]>,
    /// Draw tip and axis deviation along the path (SVG); with --smooth.
    #[arg(long, value_name = "FILE", requires = "smooth")]
    chart: Option<PathBuf>,
}

/// Two positive numbers; the angle as radians.
fn tolerances(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| *x > 0.0 && x.is_finite());
    match text.split_once(',').map(|(tip, axis)| (number(tip), number(axis))) {
        Some((Some(tip), Some(axis))) => Ok([tip, axis.to_radians()]),
        _ => Err("write two numbers above 0, mm and degrees, such as 0.005,0.02".to_owned()),
    }
}

/// What `--json` says.
#[derive(Debug, Default, Serialize)]
struct Answer {
    schema: &'static str,
    /// Cutter locations read, and written.
    locations: [usize; 2],
    smoothing: Option<Smoothing>,
}

/// What smoothing did; mm and degrees.
#[derive(Debug, Serialize)]
struct Smoothing {
    tip_tolerance: f64,
    axis_tolerance: f64,
    tip_deviation: f64,
    tip_bound: f64,
    axis_deviation: f64,
    axis_bound: f64,
    spans: usize,
    merged: usize,
    corners_blended: usize,
    corners_kept: usize,
}

pub(crate) fn run(args: &Args, json: bool) -> Result<Done, Failure> {
    if json && args.output.is_none() {
        let help = "help: name the CL file with -o";
        return Err(Failure::input(format!("--json and the CL file both go to stdout\n  {help}")));
    }
    let cl = locations(&args.input)?;
    let mut answer = Answer { schema: "trunnion-path/1", ..Answer::default() };
    let sheet = if let Some(tolerance) = args.smooth {
        let sheet = smoothed::smooth(&args.input, &cl, tolerance)?;
        answer.smoothing = Some(smoothing(&sheet, tolerance));
        answer.locations = sheet.locations;
        sheet
    } else {
        let count = cl.lines().filter(|line| line.trim_start().starts_with("GOTO")).count();
        answer.locations = [count; 2];
        Sheet { text: cl, ..Sheet::default() }
    };
    let write =
        |place: &Path, text: &str| output::file(place, |out| out.write_all(text.as_bytes()));
    if let (Some(place), Some(tolerance)) = (&args.chart, args.smooth) {
        write(place, &chart::draw(&sheet.deviations, tolerance))?;
    }
    match &args.output {
        None => text::print(&sheet.text)?,
        Some(place) => {
            write(place, &sheet.text)?;
            if json { text::print_json(&answer)? } else { text::print(&words(&answer, place))? }
        }
    };
    Ok(Done::Kept)
}

/// Cutter locations as text: those of a job, or the file itself.
fn locations(input: &Path) -> Result<String, Failure> {
    if input.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
        let bars = Bars::new();
        let (job, warnings) = jobs::load(input, &bars)?;
        for warning in warnings {
            eprintln!("warning: {warning}");
        }
        let cl = pipeline::locations(&job, &bars).map_err(jobs::failure)?;
        bars.finish();
        return Ok(cl);
    }
    let cl = text::read(input)?;
    read::cl(&cl, MOST_FAULTS).map_err(|faults| Failure::faults(input, &faults))?;
    Ok(cl)
}

fn smoothing(sheet: &Sheet, [tip, axis]: [f64; 2]) -> Smoothing {
    let report = &sheet.report;
    let most = &report.deviated;
    Smoothing {
        tip_tolerance: tip,
        axis_tolerance: axis.to_degrees(),
        tip_deviation: most.tip,
        tip_bound: most.tip_bound + smoothed::SHARE * tip,
        axis_deviation: most.axis.to_degrees(),
        axis_bound: (most.axis_bound + smoothed::SHARE * axis).to_degrees(),
        spans: report.spans,
        merged: report.merged,
        corners_blended: report.blended,
        corners_kept: report.stops,
    }
}

fn words(answer: &Answer, place: &Path) -> String {
    let [read, written] = answer.locations;
    let mut lines = vec![format!("{}: {written} cutter locations", place.display())];
    if let Some(of) = &answer.smoothing {
        let row = |name: &str, value: String| format!("  {name:<18}{value}");
        let Smoothing { tip_bound, axis_bound, corners_blended, corners_kept, .. } = of;
        lines.extend([
            row("read", format!("{read}, {} of them the same as the one before", of.merged)),
            row(
                "tip",
                format!("at most {tip_bound:.6} mm from the path read, of {} mm", of.tip_tolerance),
            ),
            row("axis", format!("at most {axis_bound:.6} deg, of {:.6} deg", of.axis_tolerance)),
            row("spans", of.spans.to_string()),
            row("corners", format!("{corners_blended} blended, {corners_kept} kept as stops")),
        ]);
    }
    lines.join("\n") + "\n"
}
