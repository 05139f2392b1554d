//! `trunnion run`: everything from one job file.

use crate::outcome::{Done, Failure};
use crate::output::Outputs;
use crate::progress::Bars;
use crate::{machine, material, motion, part, report, text};
use std::path::{Path, PathBuf};
use trunnion::files;
use trunnion::files::job::Stock;
use trunnion::files::summary::{
    CheckSummary, CoverSummary, SingularSummary, Summary, ToleranceSummary, TurnLimitSummary,
};
use trunnion::pipeline::{self, Job, Outcome, PipelineError};

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Job file (TOML); paths in it are relative to it.
    job: PathBuf,
    /// Folder for the outputs [default: out/ beside the job].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Check the job and its files, and stop before the work.
    #[arg(long)]
    dry_run: bool,
}

pub(crate) fn run(args: &Args, json: bool) -> Result<Done, Failure> {
    let bars = Bars::new();
    let (job, warnings) = load(&args.job, &bars)?;
    let folder = match &args.output {
        Some(folder) => folder.clone(),
        None => args.job.parent().unwrap_or(Path::new("")).join("out"),
    };
    Outputs::probe(&folder)?;
    if args.dry_run {
        pipeline::reach(&job).map_err(failure)?;
        pipeline::stock(&job).map_err(failure)?;
    }
    if args.dry_run && json {
        return text::print_json(&DryRun::of(&job, warnings));
    }
    if args.dry_run {
        return text::print(&dry(&job, &warnings));
    }
    let outcome = pipeline::run(&job, &bars).map_err(failure)?;
    bars.finish();
    let mut summary = outcome.summary.clone();
    summary.warnings.splice(0..0, warnings);
    let places = write(&job, &outcome, &mut summary, &folder)?;
    if json {
        text::print_json(&summary)?;
    } else {
        text::print(&table(&summary, &places))?;
    }
    Ok(if summary.passed { Done::Kept } else { Done::Broken })
}

/// Reads the job and the files it names. All faults of the files it names are told together.
pub(crate) fn load(path: &Path, bars: &Bars) -> Result<(Job, Vec<String>), Failure> {
    let file = files::job::parse(&text::read(path)?).map_err(|f| Failure::faults(path, &f))?;
    let beside = |name: &str| path.parent().unwrap_or(Path::new("")).join(name);
    let machine = machine::load_beside(path, &file.machine);
    let part = part::read(&beside(&file.part.file), bars);
    let (machine, part) = match (machine, part) {
        (Ok(machine), Ok(part)) => (machine, part),
        (Err(first), Err(second)) => return Err(first.and(second)),
        (Err(fault), _) | (_, Err(fault)) => return Err(fault),
    };
    let warnings = part.warnings.iter().map(|warning| format!("part: {warning}")).collect();
    let job = Job::new(file, &part.faces, &machine.machine)
        .map_err(|faults| Failure::faults(path, &faults))?;
    let job = match &job.file.stock {
        Some(Stock::Stl { file } | Stock::Step { file }) => {
            let mesh = material::mesh(&beside(file), material::CHORD)?;
            job.with_stock(mesh)
        }
        _ => job,
    };
    Ok((job, warnings))
}

/// What a stage could not do lies in the job, its part or its machine: nothing is written.
pub(crate) fn failure(error: PipelineError) -> Failure {
    match error {
        PipelineError::Cancelled(_) => Failure::Stopped,
        PipelineError::ReadBack { .. } => Failure::Internal(error.into()),
        error => Failure::input(error),
    }
}

/// What `--dry-run --json` says: the job as it would be worked, its budget shared out \[mm\].
#[derive(Debug, serde::Serialize)]
struct DryRun {
    schema: &'static str,
    job: String,
    faces: usize,
    tolerance: ToleranceSummary,
    warnings: Vec<String>,
}

impl DryRun {
    fn of(job: &Job, warnings: Vec<String>) -> Self {
        Self {
            schema: "trunnion-dry-run/1",
            job: job.file.name.clone(),
            faces: job.faces.len(),
            tolerance: job.budget.summary(),
            warnings,
        }
    }
}

fn dry(job: &Job, warnings: &[String]) -> String {
    let mut lines = vec![format!("{}: the job and its files are in order", job.file.name)];
    lines.extend(warnings.iter().map(|warning| format!("warning: {warning}")));
    lines.extend(job.budget.lines().map(|(name, value)| format!("  {name:<16}{value:>9.5} mm")));
    lines.join("\n") + "\n"
}

fn write(
    job: &Job,
    outcome: &Outcome,
    summary: &mut Summary,
    folder: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    summary.files =
        ["toolpath.cls", "setup.txt", "motion.csv", "report.html"].map(str::to_owned).into();
    let mut outputs = Outputs::open(folder)?;
    outputs.text("toolpath.cls", &outcome.cl)?;
    for program in &outcome.programs {
        outputs.text(program.file, &program.text)?;
        if let Some(unread) = &program.unread {
            let file = program.file;
            eprintln!("warning: {file}:{unread}\nwarning: from there on it was not read back");
        }
    }
    outputs.text("setup.txt", &outcome.setup)?;
    outputs.add("motion.csv", |out| motion::write(out, job, outcome))?;
    if let Some(left) = material::left(outcome) {
        summary.files.push("stock.stl".to_owned());
        outputs.add("stock.stl", |out| {
            material::write(out, &material::surface(left, job.budget.total))
        })?;
    }
    outputs.text("report.html", &report::page(job, outcome, summary)?)?;
    let json = serde_json::to_string_pretty(&summary).map_err(anyhow::Error::from)?;
    outputs.text("summary.json", &(json + "\n"))?;
    Ok(outputs.commit()?)
}

/// What moving the tool axis at singular directions did, on this path: what its share of the tolerance
/// costs elsewhere is not in it.
fn passages(singular: &SingularSummary) -> String {
    let SingularSummary { passages, through, tilt, turn_saved, seconds_saved } = *singular;
    let places = match (passages, through) {
        (1, 1) => "1 passage (straight through)".to_owned(),
        (1, _) => "1 passage (farther off)".to_owned(),
        _ => format!("{passages} passages ({through} straight through)"),
    };
    // To the hundredth that is shown.
    let time = match seconds_saved {
        seconds if seconds >= 0.005 => format!("{seconds:.2} s saved"),
        seconds if seconds <= -0.005 => format!("{:.2} s lost", -seconds),
        _ => "no time saved".to_owned(),
    };
    format!(
        "tool axis moved at {places} by up to {tilt:.4} deg: {turn_saved:.0} deg less turn, {time}"
    )
}

/// The short table for people.
fn table(summary: &Summary, places: &[PathBuf]) -> String {
    let mut lines = vec![format!(
        "{}: {}",
        summary.job,
        if summary.passed { "every tolerance and limit is kept" } else { "NOT KEPT" }
    )];
    let mut row = |name: &str, value: String| lines.push(format!("  {name:<22}{value}"));
    for (name, value) in covered(&summary.cover) {
        row(name, value);
    }
    let (motion, tolerance) = (&summary.motion, &summary.tolerance);
    row(
        "time",
        format!(
            "{:.1} s, of it cutting {:.1} s; lower bound {:.1} s",
            motion.duration, motion.cutting, motion.lower_bound
        ),
    );
    row(
        "tolerance",
        format!(
            "excess {} mm, gouge {} mm; strips work in [{:.4}, {:.4}]",
            tolerance.total, tolerance.gouge, tolerance.strip[0], tolerance.strip[1]
        ),
    );
    row(
        "its other shares",
        format!(
            "path {:.4}, linearisation {:.4}, rounding {:.4}, control {:.4}, singular {:.4}, \
             smoothing {:.4} mm",
            tolerance.path,
            tolerance.linearisation,
            tolerance.rounding,
            tolerance.control,
            tolerance.singular,
            tolerance.smoothing
        ),
    );
    if let Some(singular) = &motion.singular {
        row("singular directions", passages(singular));
    }
    for program in &summary.programs {
        if let Some(other) = &program.same_as {
            let told = format!(
                "{} blocks; the same as those of {other}, whose check holds",
                program.blocks
            );
            row(&program.dialect, told);
        }
        let Some(check) = &program.check else { continue };
        row(&program.dialect, checked(program.blocks, check));
        for words in program.stock.iter().flat_map(material::words) {
            row("", words);
        }
    }
    lines.extend(summary.warnings.iter().map(|warning| format!("warning: {warning}")));
    lines.extend(summary.failures.iter().map(|failure| format!("broken: {failure}")));
    lines.extend(places.iter().map(|place| format!("wrote {}", place.display())));
    lines.join("\n") + "\n"
}

/// What the passes cover, row by row.
fn covered(cover: &CoverSummary) -> Vec<(&'static str, String)> {
    let [least, mean, most] = cover.strip_width;
    let mut rows = vec![
        (
            "passes",
            format!(
                "{} with {} cutter locations, along {}",
                cover.passes,
                cover.stations,
                ways(&cover.along)
            ),
        ),
        ("cutting length", format!("{:.0} mm", cover.cutting_length)),
        ("strip width", format!("{least:.2} .. {most:.2} mm, mean {mean:.2}")),
    ];
    if let Some(TurnLimitSummary { free_passes, free_length, length, time }) = &cover.turn_limit {
        let [length, time] = [length, time].map(|share| 100.0 * share);
        let told = format!(
            "{length:+.1} % of length, {time:+.1} % of time (estimated) against {free_passes} passes of {free_length:.0} mm \
             with the axis free to turn"
        );
        rows.push(("turn limit costs", told));
    }
    if !cover.fixed.is_empty() {
        let share: f64 = cover.fixed.iter().map(|region| region.share).sum();
        let told = format!("{:.1} % of the faces, regions: {}", 100.0 * share, cover.fixed.len());
        rows.push(("at a fixed lean", told));
    }
    if !cover.rest.is_empty() {
        let area: f64 = cover.rest.iter().map(|rest| rest.area).sum();
        let told = format!("{area:.2} of {:.1} mm2, parts: {}", cover.area, cover.rest.len());
        rows.push(("not finished", told));
    }
    rows
}

/// Which ways passes run, each once.
fn ways(along: &[String]) -> String {
    let mut ways: Vec<&str> = along.iter().map(String::as_str).collect();
    ways.sort_unstable();
    ways.dedup();
    let bent = |way| if way == "bent" { "lines bent to the face" } else { way };
    ways.into_iter().map(bent).collect::<Vec<_>>().join(" and ")
}

/// What the check of a program found.
fn checked(blocks: usize, check: &CheckSummary) -> String {
    format!(
        "{blocks} blocks; checked at {} points, {} mm apart: excess {:.4}, gouge {:.4} mm, uncut {}{}{}{}",
        check.points,
        check.grid,
        check.excess,
        check.gouge,
        check.uncut,
        between(check),
        also(check.rest, "in the rest"),
        also(check.others, "on faces not cut, for gouges"),
    )
}

/// What holds between the points.
fn between(check: &CheckSummary) -> String {
    let (Some(gouge), Some(excess)) = (check.gouge_bound, check.excess_bound) else {
        return String::new();
    };
    let open = match check.unbounded_area {
        area if area > 0.0 => format!(" but for {area:.2} mm2"),
        _ => String::new(),
    };
    format!("; everywhere{open} excess <= {excess:.4}, gouge <= {gouge:.4} mm")
}

/// `; 3 points in the rest`, or nothing.
fn also(points: usize, what: &str) -> String {
    if points == 0 { String::new() } else { format!("; {points} points {what}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passages_are_counted_and_time_has_a_side() {
        let told = |passages, through, seconds_saved| {
            let (tilt, turn_saved) = (0.0125, 180.0);
            super::passages(&SingularSummary { passages, through, tilt, turn_saved, seconds_saved })
        };
        let start = "tool axis moved at 1 passage (straight through) by up to 0.0125 deg: 180 deg less turn,";
        assert_eq!(told(1, 1, -0.001), format!("{start} no time saved"));
        assert_eq!(told(1, 1, -0.25), format!("{start} 0.25 s lost"));
        assert!(told(1, 0, 0.0).contains("1 passage (farther off)"));
        assert!(told(3, 2, 1.5).contains("3 passages (2 straight through)"));
        assert!(told(3, 2, 1.5).ends_with("1.50 s saved"));
    }
}
