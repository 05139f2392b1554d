//! `trunnion run`: everything from one job file.

use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::output::Outputs;
use crate::progress::Bars;
use crate::{disk, machine, material, motion, part, report, text};
use std::path::{Path, PathBuf};
use trunnion::files;
use trunnion::files::job::{JobFile, JobFixture, JobSolid, JobStock};
use trunnion::files::summary::{
    CheckSummary, CoverSummary, LayoutSummary, LayoutTime, OperationSummary, ProgramSummary,
    SingularSummary, Summary, ToleranceSummary, TurnLimitSummary,
};
use trunnion::pipeline::{self, CheckedProgram, Job, Outcome, PipelineError};
use trunnion::types::{Mesh, Progress};

#[derive(Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// Job file (TOML); paths in it are relative to it.
    job: PathBuf,
    /// Folder for the outputs [default: out/ beside the job].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Check the job and its files, and stop before the passes are placed.
    #[arg(long)]
    dry_run: bool,
}

pub(crate) fn run(args: &RunArgs, form: OutputForm) -> Result<Done, Failure> {
    let bars = Bars::new();
    let (job, warnings) = load(&args.job, None, &bars)?;
    let folder = match &args.output {
        Some(folder) => folder.clone(),
        None => args.job.parent().unwrap_or(Path::new("")).join("out"),
    };
    // Minutes of planning must not end at a folder without write permission.
    Outputs::probe(&folder)?;
    // The dry run makes every check that takes little time.
    if args.dry_run {
        job.operations().try_for_each(pipeline::reach).map_err(failure)?;
        let too_concave = pipeline::fit(&job).map_err(failure)?;
        pipeline::solids(&job).map_err(|error| refused(&args.job, error))?;
        let warnings = [warnings, too_concave].concat();
        let dry_run = DryRun::of(&job, warnings);
        return form.print(&dry_run, |dry_run| describe_dry_run(&job, &dry_run.warnings));
    }
    let outcome = match pipeline::run(&job, &bars) {
        Err(PipelineError::AfterPasses { why, cl }) => return Err(kept_passes(&folder, &cl, &why)),
        other => other.map_err(|error| refused(&args.job, error))?,
    };
    bars.finish();
    let mut summary = outcome.summary.clone();
    // Warnings about the part come first: they explain later ones.
    summary.warnings.splice(0..0, warnings);
    let places = write(&job, &outcome, &mut summary, &folder)?;
    for warning in unread(&outcome) {
        eprintln!("warning: {warning}");
    }
    form.print(&summary, |summary| table(summary, &places))?;
    Ok(if summary.passed { Done::Kept } else { Done::Broken })
}

/// Reads the job and the files it names, STEP solids within `chord` \[mm\] of their faces if it is given. All
/// faults of the files it names are reported together.
pub(crate) fn load(
    path: &Path,
    chord: Option<f64>,
    bars: &dyn Progress,
) -> Result<(Job, Vec<String>), Failure> {
    load_text(path, &text::read(path)?, chord, bars)
}

/// Reads the text of a job; `path` is where it stands or would stand.
pub(crate) fn load_text(
    path: &Path,
    text: &str,
    chord: Option<f64>,
    bars: &dyn Progress,
) -> Result<(Job, Vec<String>), Failure> {
    let file = files::job::parse(text).map_err(|f| Failure::faults(path, &f))?;
    // The chord must be known before the STEP files are divided into triangles.
    let file = match chord {
        Some(chord) => file.with_chord(chord),
        None => file,
    };
    let machine = machine::load_beside(path, &file.machine);
    let machine = machine.map_err(|what| at_key(path, &file, "machine.file", &file.machine, what));
    let part = part::read(&beside(path, &file.part.file), bars);
    let part = part.map_err(|what| at_key(path, &file, "part.file", &file.part.file, what));
    let solids = solids(path, &file);
    let file = with_holders(path, file);
    // One run shows the faults of all files.
    let (machine, (part, (solids, file))) = both(machine, both(part, both(solids, file)))?;
    let warnings = part.warnings.iter().map(|warning| format!("part: {warning}")).collect();
    let mut job = Job::new(file, &part.faces, &machine.machine)
        .map_err(|faults| Failure::faults(path, &faults))?;
    if let Some(mesh) = solids.stock {
        job = job.with_stock(mesh);
    }
    for (number, mesh) in solids.fixtures {
        job = job.with_fixture(number, mesh);
    }
    Ok((job, warnings))
}

/// Returns both values, or the failures of both.
pub(crate) fn both<A, B>(a: Result<A, Failure>, b: Result<B, Failure>) -> Result<(A, B), Failure> {
    match (a, b) {
        (Ok(a), Ok(b)) => Ok((a, b)),
        (Err(a), Err(b)) => Err(a.and(b)),
        (Err(fault), _) | (_, Err(fault)) => Err(fault),
    }
}

/// Returns the path of a file that a job names.
fn beside(job: &Path, name: &str) -> PathBuf {
    job.parent().unwrap_or(Path::new("")).join(name)
}

/// Returns the error of a file that a job names, at its line of the job if the file does not exist.
fn at_key(path: &Path, file: &JobFile, key: &str, name: &str, what: Failure) -> Failure {
    match what {
        // A file that exists has its own positions; one that does not is a mistake in the job.
        Failure::Input(messages) if !disk::is_file(&beside(path, name)) => {
            let at = file.places.get(key);
            let detail =
                |message| format!("{}:{}:{}: {message}", path.display(), at.line, at.column);
            Failure::Input(messages.into_iter().map(detail).collect())
        }
        other => other,
    }
}

/// Triangles of the solids that are in files.
struct Solids {
    stock: Option<Mesh>,
    /// By their numbers in the job, from 0.
    fixtures: Vec<(usize, Mesh)>,
}

/// Reads the files of stock and fixtures; errors are reported at their lines of the job.
fn solids(path: &Path, file: &JobFile) -> Result<Solids, Failure> {
    let mut faults = Vec::new();
    let mut read = |key: &str, solid: &JobSolid| {
        let name = solid.file()?;
        let found = material::mesh_of(&beside(path, name), solid.chord());
        let refused = |what: String| {
            // Only STEP solids have a chord, so it shows the kind.
            let help = match (Path::new(name), solid.chord()) {
                (file, None) if material::is_step(file) => "write kind = \"step\" for a STEP file",
                (file, Some(_)) if material::is_stl(file) => "write kind = \"stl\" for an STL file",
                _ => "",
            };
            faults.push(file.places.fault(key, format!("{name}: {what}")).with_help(help));
        };
        found.map_err(refused).ok()
    };
    let stock = file.stock.as_ref().and_then(JobStock::solid);
    let stock = stock.and_then(|solid| read("stock.file", solid));
    let of = |(number, fixture): (usize, &JobFixture)| {
        Some((number, read(&format!("fixture.{number}.file"), &fixture.solid)?))
    };
    let fixtures = file.fixtures.iter().enumerate().filter_map(of).collect();
    if faults.is_empty() {
        Ok(Solids { stock, fixtures })
    } else {
        Err(Failure::faults(path, &faults))
    }
}

/// Reads the files of the holders.
fn with_holders(path: &Path, file: JobFile) -> Result<JobFile, Failure> {
    let read = |name: &str| material::holder_mesh(&beside(path, name));
    file.with_holders(read).map_err(|faults| Failure::faults(path, &faults))
}

/// Returns the failure of a stage; defects of stock and fixtures are reported at their lines of the job.
pub(crate) fn refused(path: &Path, error: PipelineError) -> Failure {
    match error {
        PipelineError::Solids(faults) => Failure::faults(path, &faults),
        error => failure(error),
    }
}

/// Returns the failure of a stage: the job, its part or its machine is the cause, and nothing is written.
pub(crate) fn failure(error: PipelineError) -> Failure {
    match error {
        PipelineError::Cancelled(_) => Failure::Stopped,
        // A program that the own reader refuses is a defect of trunnion, not of the job.
        PipelineError::ReadBack { .. } => Failure::Internal(error.into()),
        error => Failure::input(error),
    }
}

/// Answer of `--dry-run --json`: the job as it would run, with its budget \[mm\].
#[derive(Debug, serde::Serialize)]
struct DryRun {
    schema: &'static str,
    job: String,
    faces: usize,
    /// Names of the fixtures that programs are checked against.
    fixtures: Vec<String>,
    tolerance: ToleranceSummary,
    warnings: Vec<String>,
}

impl DryRun {
    fn of(job: &Job, warnings: Vec<String>) -> Self {
        Self {
            schema: "trunnion-dry-run/1",
            job: job.file.name.clone(),
            faces: job.cut_faces().len(),
            fixtures: job.fixtures.iter().map(|held| held.name.clone()).collect(),
            tolerance: job.budget.summary(),
            warnings,
        }
    }
}

fn describe_dry_run(job: &Job, warnings: &[String]) -> String {
    let mut lines = vec![format!("{}: the job and its files are in order", job.file.name)];
    lines.extend(warnings.iter().map(|warning| format!("warning: {warning}")));
    lines.extend(job.budget.lines().map(|(name, value)| format!("  {name:<16}{value:>9.5} mm")));
    let fixtures: Vec<&str> = job.fixtures.iter().map(|held| held.name.as_str()).collect();
    if !fixtures.is_empty() {
        lines.push(format!("  {:<16}{}", "fixtures", fixtures.join(", ")));
    }
    lines.join("\n") + "\n"
}

/// Writes the cutter locations of passes that could not become a program, and returns the reason.
pub(crate) fn kept_passes(folder: &Path, cl: &str, why: &PipelineError) -> Failure {
    let keep = || {
        let mut outputs = Outputs::open(folder)?;
        outputs.text("toolpath.cls", cl)?;
        Ok(outputs.commit()?)
    };
    let kept = match keep() {
        Ok(kept) => kept,
        Err(failure) => return failure,
    };
    let help = "the passes are planned and kept as cutter locations, for another setup or machine: trunnion post";
    Failure::Unfinished { messages: vec![format!("{why}\n  help: {help}")], kept }
}

/// Returns warnings about programs that could not be read back to their end.
pub(crate) fn unread(outcome: &Outcome) -> Vec<String> {
    let of = |program: &CheckedProgram| {
        let (file, unread) = (program.file, program.unread.as_ref()?);
        Some(format!("{file}:{unread}\nwarning: it was not read back from this line on"))
    };
    outcome.programs.iter().filter_map(of).collect()
}

/// Writes the files of a run; nothing is visible before all of them are complete.
pub(crate) fn write(
    job: &Job,
    outcome: &Outcome,
    summary: &mut Summary,
    folder: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let motions: Vec<String> =
        outcome.operations.iter().map(|one| motion::file_name(job, one)).collect();
    let first = ["toolpath.cls", "setup.txt"].map(str::to_owned).into_iter();
    summary.files =
        first.chain(motions.iter().cloned()).chain(["report.html".to_owned()]).collect();
    let mut outputs = Outputs::open(folder)?;
    outputs.text("toolpath.cls", &outcome.cl)?;
    for program in &outcome.programs {
        outputs.text(program.file, &program.text)?;
        for part in &program.parts {
            outputs.text(&part.file, &part.text)?;
        }
    }
    outputs.text("setup.txt", &outcome.setup)?;
    for (file, operation) in motions.iter().zip(&outcome.operations) {
        outputs.add(file, |out| motion::write(out, job, operation))?;
    }
    if let Some(left) = material::left(outcome) {
        summary.files.push("stock.stl".to_owned());
        outputs.add("stock.stl", |out| {
            material::write(out, &material::surface(left, job.budget.total))
        })?;
    }
    // The page and summary.json come last, when everything else has succeeded.
    outputs.text("report.html", &report::page(job, outcome, summary)?)?;
    let json = serde_json::to_string_pretty(&summary).map_err(anyhow::Error::from)?;
    outputs.text("summary.json", &(json + "\n"))?;
    Ok(outputs.commit()?)
}

/// Describes the effect of moving the tool axis at singular directions on this path. The cost of its
/// share of the tolerance elsewhere is not included.
fn passages(singular: &SingularSummary) -> String {
    let SingularSummary { passages, through, tilt, turn_saved, seconds_saved, .. } = *singular;
    let places = match (passages, through) {
        (1, 1) => "1 passage (straight through)".to_owned(),
        (1, _) => "1 passage (farther off)".to_owned(),
        _ => format!("{passages} passages ({through} straight through)"),
    };
    // Rounded to the hundredth that is shown: below it, neither saved nor lost.
    let time = match seconds_saved {
        seconds if seconds >= 0.005 => format!("{seconds:.2} s saved"),
        seconds if seconds <= -0.005 => format!("{:.2} s lost", -seconds),
        _ => "no time saved".to_owned(),
    };
    format!(
        "tool axis moved at {places} by up to {tilt:.4} deg: {turn_saved:.0} deg less turn, {time}"
    )
}

/// Returns the table for people.
pub(crate) fn table(summary: &Summary, places: &[PathBuf]) -> String {
    let mut lines = vec![format!(
        "{}: {}",
        summary.job,
        if summary.passed { "every tolerance and limit is kept" } else { "NOT KEPT" }
    )];
    let mut row = |name: &str, value: String| lines.push(format!("  {name:<22}{value}"));
    for (name, value) in covered(&summary.cover) {
        row(name, value);
    }
    for operation in &summary.operations {
        row("operation", operation_words(operation));
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
    for (name, value) in summary.programs.iter().flat_map(program) {
        row(name, value);
    }
    if !summary.chords.is_empty() {
        row("STEP solids", material::chord_words(&summary.chords));
    }
    lines.extend(summary.warnings.iter().map(|warning| format!("warning: {warning}")));
    lines.extend(summary.failures.iter().map(|failure| format!("broken: {failure}")));
    lines.extend(places.iter().map(|place| format!("wrote {}", place.display())));
    lines.join("\n") + "\n"
}

/// Describes an operation.
fn operation_words(operation: &OperationSummary) -> String {
    let OperationSummary { name, cover, motion, .. } = operation;
    let faces: Vec<String> = cover.faces.iter().map(usize::to_string).collect();
    format!(
        "{name}: passes {}, {:.0} mm on faces {}, {:.1} s, of it cutting {:.1} s",
        cover.passes,
        cover.cutting_length,
        faces.join(", "),
        motion.duration,
        motion.cutting
    )
}

/// Describes a program, row by row.
fn program(program: &ProgramSummary) -> Vec<(&str, String)> {
    let mut rows = Vec::new();
    if let Some(other) = &program.same_as {
        let detail =
            format!("{} blocks; the same as those of {other}, whose check applies", program.blocks);
        rows.push((program.dialect.as_str(), detail));
    }
    let parts = program.parts.iter();
    let parts: Vec<String> = parts
        .map(|part| format!("{} ({}, {} blocks)", part.file, part.operation, part.blocks))
        .collect();
    let by_operation = (!parts.is_empty()).then(|| format!("by operation: {}", parts.join(", ")));
    let Some(check) = &program.check else {
        rows.extend(by_operation.map(|words| ("", words)));
        return rows;
    };
    rows.push((&program.dialect, checked(program, check)));
    rows.extend(by_operation.map(|words| ("", words)));
    rows.extend(program.stock.iter().flat_map(material::words).map(|words| ("", words)));
    let fixtures = program.fixtures.iter().map(pipeline::nearest_fixture);
    rows.extend(fixtures.map(|words| ("", format!("fixtures: {words}"))));
    let bodies = program.bodies.iter().map(pipeline::nearest_bodies);
    rows.extend(bodies.map(|words| ("", format!("machine bodies: {words}"))));
    rows
}

/// Describes the passes, row by row.
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
    rows.extend(cover.layouts.iter().take(LAYOUTS).map(|face| ("layout", compared(face))));
    if let Some(TurnLimitSummary { free_passes, free_length, length, time, .. }) = &cover.turn_limit
    {
        let [length, time] = [length, time].map(|share| 100.0 * share);
        let detail = format!(
            "{length:+.1} % of length, {time:+.1} % of time (estimated) against {free_passes} passes of {free_length:.0} mm \
             with the axis free to turn"
        );
        rows.push(("turn limit costs", detail));
    }
    if !cover.fixed.is_empty() {
        let share: f64 = cover.fixed.iter().map(|region| region.share).sum();
        let detail = format!("{:.1} % of the faces, regions: {}", 100.0 * share, cover.fixed.len());
        rows.push(("fixed inclination", detail));
    }
    if !cover.rest.is_empty() {
        let area: f64 = cover.rest.iter().map(|rest| rest.area).sum();
        let detail = format!("{area:.2} of {:.1} mm2, parts: {}", cover.area, cover.rest.len());
        rows.push(("not finished", detail));
    }
    rows
}

/// Faces whose layouts are listed at most; `summary.json` has all.
const LAYOUTS: usize = 6;

/// Describes the layout of a face beside those that it was compared with.
fn compared(face: &LayoutSummary) -> String {
    let left = |one: &LayoutTime| match one.rest {
        rest if rest > 0.0 => format!(" and {rest:.1} mm2 not finished"),
        _ => String::new(),
    };
    let named = |one: &LayoutTime| match one.along.as_str() {
        "bent" => "along curves fitted to the face".to_owned(),
        parameter => format!("along {parameter}"),
    };
    let chosen = &face.chosen;
    let others: Vec<String> = face
        .others
        .iter()
        .map(|one| format!("{} {:.1} s{}", named(one), one.seconds, left(one)))
        .collect();
    format!(
        "face {} {}, {:.1} s by the speeds of the axes{}; planned as well: {}",
        face.face,
        named(chosen),
        chosen.seconds,
        left(chosen),
        others.join(", ")
    )
}

/// Lists the feed directions of the passes, each once.
fn ways(along: &[String]) -> String {
    let mut ways: Vec<&str> = along.iter().map(String::as_str).collect();
    ways.sort_unstable();
    ways.dedup();
    let bent = |way| match way {
        "bent" => "curves fitted to the face",
        "flank" => "the flank of the tool",
        "floor" => "floors",
        "fixed-axis" => "lines at a fixed axis",
        parameter => parameter,
    };
    ways.into_iter().map(bent).collect::<Vec<_>>().join(" and ")
}

/// Describes the check of a program.
fn checked(program: &ProgramSummary, check: &CheckSummary) -> String {
    // The planned time holds for the machine; the planner of a control may need longer.
    let own = program.linuxcnc_duration;
    let own = own.map_or_else(String::new, |seconds| format!(", {seconds:.1} s on LinuxCNC"));
    format!(
        "{} blocks{own}; checked at {} points, {} mm apart: excess {:.4}, gouge {:.4} mm, uncut {}{}{}{}",
        program.blocks,
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

/// Describes the bounds between the points.
fn between(check: &CheckSummary) -> String {
    let (Some(gouge), Some(excess)) = (check.gouge_bound, check.excess_bound) else {
        return String::new();
    };
    let open = match check.unbounded_area {
        area if area > 0.0 => format!(" except on {area:.2} mm2"),
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
        let detail = |passages, through, seconds_saved| {
            let mut summary = SingularSummary::default();
            (summary.passages, summary.through, summary.seconds_saved) =
                (passages, through, seconds_saved);
            (summary.tilt, summary.turn_saved) = (0.0125, 180.0);
            super::passages(&summary)
        };
        let start = "tool axis moved at 1 passage (straight through) by up to 0.0125 deg: 180 deg less turn,";
        assert_eq!(detail(1, 1, -0.001), format!("{start} no time saved"));
        assert_eq!(detail(1, 1, -0.25), format!("{start} 0.25 s lost"));
        assert!(detail(1, 0, 0.0).contains("1 passage (farther off)"));
        assert!(detail(3, 2, 1.5).contains("3 passages (2 straight through)"));
        assert!(detail(3, 2, 1.5).ends_with("1.50 s saved"));
    }
}
