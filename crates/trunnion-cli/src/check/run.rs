//! The verb: reads, checks, writes and prints.

use super::args::CheckArgs;
use super::subject::Subject;
use super::summary::PartCheckSummary;
use super::{export, page, setpoints};
use crate::form::OutputForm;
use crate::material;
use crate::outcome::{Done, Failure};
use crate::output::Outputs;
use crate::progress::Bars;
use std::path::PathBuf;
use trunnion::verify::InspectionReport;

pub(crate) fn run(args: &CheckArgs, form: OutputForm) -> Result<Done, Failure> {
    if setpoints::is_table(&args.program) {
        return setpoints::check(args, form);
    }
    // Options of setpoints would be ignored silently here.
    if args.period.is_some() || args.no_jerk {
        let message = "--period and --no-jerk go with a table of setpoints (.csv)";
        return Err(Failure::input(message));
    }
    let bars = Bars::new();
    // Everything is read and the folder probed before the long work: a typing error costs seconds.
    let subject = Subject::load(args, &bars)?;
    if let Some(folder) = &args.output {
        Outputs::probe(folder)?;
    }
    subject.errors()?;
    let found = subject.check(&bars)?;
    let assumed = subject.assumed(&bars)?;
    bars.finish();
    let mut summary = PartCheckSummary::new(&subject, &found, assumed);
    let places = match &args.output {
        Some(folder) => write(&subject, &found, &mut summary, folder)?,
        None => Vec::new(),
    };
    form.print(&summary, |summary| summary.table(&places))?;
    Ok(if summary.passed { Done::Kept } else { Done::Broken })
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
