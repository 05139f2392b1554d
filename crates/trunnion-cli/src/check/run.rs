//! The verb: reads, checks, writes and prints.

use super::args::{CheckArgs, PredictedControl};
use super::planner_time::planner_time;
use super::subject::Subject;
use super::summary::PartCheckSummary;
use super::{export, page, setpoints};
use crate::form::OutputForm;
use crate::material;
use crate::outcome::{Done, Failure};
use crate::output::Outputs;
use crate::progress::Bars;
use std::path::PathBuf;
use trunnion::nc::read::SubprogramFile;
use trunnion::types::Progress;
use trunnion::verify::InspectionReport;

pub(crate) fn run(args: &CheckArgs, form: OutputForm) -> Result<Done, Failure> {
    if setpoints::is_table(&args.program) {
        return setpoints::check(args, form);
    }
    let bars = Bars::new();
    let PartCheck { summary, places, .. } = checked(args, &bars)?;
    bars.finish();
    form.print(&summary, |summary| summary.table(&places))?;
    Ok(if summary.passed { Done::Kept } else { Done::Broken })
}

/// Result of a check of a program or CL file.
pub(super) struct PartCheck {
    pub(super) summary: PartCheckSummary,
    pub(super) found: InspectionReport,
    /// Files that were written.
    pub(super) places: Vec<PathBuf>,
}

/// Checks a program or CL file, and writes the report files where the arguments name a folder.
pub(super) fn checked(args: &CheckArgs, progress: &dyn Progress) -> Result<PartCheck, Failure> {
    // Options of setpoints would be ignored silently here.
    if args.period.is_some() || args.no_jerk {
        let message = "--period and --no-jerk go with a table of setpoints (.csv)";
        return Err(Failure::input(message));
    }
    // Everything is read and the folder probed before the long work: a typing error costs seconds.
    let subject = Subject::load(args, progress)?;
    if let Some(folder) = &args.output {
        Outputs::probe(folder)?;
    }
    subject.errors()?;
    let found = subject.check(progress)?;
    let assumed = subject.assumed(progress)?;
    let mut summary = PartCheckSummary::new(&subject, &found, assumed);
    if args.control == Some(PredictedControl::LinuxcncTrunnion) {
        summary.set_planner_time(planner_time(&subject));
    }
    let places = match &args.output {
        Some(folder) => write(&subject, &found, &mut summary, folder)?,
        None => Vec::new(),
    };
    Ok(PartCheck { summary, found, places })
}

/// Returns the files of the subprograms that a program runs.
pub(crate) fn subprograms(args: &CheckArgs) -> Result<Vec<SubprogramFile>, Failure> {
    args.files.called(&args.program)
}

/// Verdict of a check for callers in other languages.
#[derive(Debug)]
#[non_exhaustive]
pub struct CheckAnswer {
    /// Summary as `--json` prints it.
    pub summary: serde_json::Value,
    /// Summary as a table for people.
    pub table: String,
    /// True if every tolerance and limit is kept.
    pub passed: bool,
    /// Measured points; `None` for a table of setpoints.
    pub found: Option<InspectionReport>,
}

/// Checks a program, CL file or table of setpoints, and prints nothing.
pub(crate) fn answer(args: &CheckArgs, progress: &dyn Progress) -> Result<CheckAnswer, Failure> {
    if setpoints::is_table(&args.program) {
        let (summary, places) = setpoints::judged(args, progress)?;
        let json = serde_json::to_value(&summary).map_err(anyhow::Error::from)?;
        let (table, passed) = (summary.table(&places), summary.passed);
        return Ok(CheckAnswer { summary: json, table, passed, found: None });
    }
    let PartCheck { summary, found, places } = checked(args, progress)?;
    let json = serde_json::to_value(&summary).map_err(anyhow::Error::from)?;
    let (table, passed) = (summary.table(&places), summary.passed);
    Ok(CheckAnswer { summary: json, table, passed, found: Some(found) })
}

/// Writes the report files; nothing is visible before all of them are complete.
fn write(
    subject: &Subject,
    found: &InspectionReport,
    summary: &mut PartCheckSummary,
    folder: &std::path::Path,
) -> Result<Vec<PathBuf>, Failure> {
    let mut outputs = Outputs::open(folder)?;
    // summary.json lists the other files.
    summary.files = vec!["report.html".to_owned(), "deviation.vtp".to_owned()];
    if found.stock.is_some() {
        summary.files.push("stock.stl".to_owned());
    }
    outputs.text("report.html", &page::page(subject, found, summary)?)?;
    outputs.add("deviation.vtp", |out| export::vtp(out, &found.report.maps))?;
    if let Some(stock) = &found.stock {
        let surface = material::surface(&stock.remaining, subject.options.total);
        outputs.add("stock.stl", |out| material::write(out, &surface))?;
    }
    let json = serde_json::to_string_pretty(summary).map_err(anyhow::Error::from)?;
    outputs.text("summary.json", &(json + "\n"))?;
    Ok(outputs.commit()?)
}
