//! The verb: opens the outputs, posts and reports.

use super::args::PostArgs;
use super::plan::Plan;
use super::posting;
use super::setpoints::{self, SetpointSource};
use super::summary::{PostSummary, SetpointSummary};
use crate::form::OutputForm;
use crate::motion::is_parquet;
use crate::outcome::{Done, Failure};
use crate::output::{self, Outputs};
use crate::progress::Bars;
use crate::text;
use std::path::Path;
use trunnion::post::PostReport;
use trunnion::types::Progress;

/// Ratio of times from which a slowed move is reported by itself.
const FAR_BELOW: f64 = 10.0;

/// Largest number of slowed moves that are reported.
const MOST_WARNINGS: usize = 20;

pub(crate) fn run(args: &PostArgs, form: OutputForm) -> Result<Done, Failure> {
    if let Some(dialect) = args.print_template {
        return text::print(dialect.template());
    }
    let (Some(input), Some(machine), Some(output)) = (&args.input, &args.machine, &args.output)
    else {
        return Err(Failure::input("an input, a machine (-m) and an output (-o) are needed"));
    };
    let bars = Bars::new();
    let mut warnings = Vec::new();
    let written = written(args, &PostFiles { input, machine, output }, &bars, &mut warnings);
    bars.finish();
    // Before a failure as well, of which they may be the reason.
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
    let summary = written?;
    form.print(&summary, PostSummary::describe)?;
    Ok(if summary.kept() { Done::Kept } else { Done::Broken })
}

/// Files of a posting.
struct PostFiles<'a> {
    input: &'a Path,
    machine: &'a str,
    output: &'a Path,
}

/// Result of a posting for callers in other languages.
#[derive(Debug)]
#[non_exhaustive]
pub struct PostAnswer {
    /// Summary as `--json` prints it.
    pub summary: serde_json::Value,
    /// Summary as a table for people.
    pub table: String,
    /// True if every limit is kept.
    pub kept: bool,
    /// Warnings, as the command line prints them.
    pub warnings: Vec<String>,
}

/// Posts an input, and prints nothing.
pub(crate) fn answer(args: &PostArgs, progress: &dyn Progress) -> Result<PostAnswer, Failure> {
    let (Some(input), Some(machine), Some(output)) = (&args.input, &args.machine, &args.output)
    else {
        return Err(Failure::input("an input, a machine and an output are needed"));
    };
    let mut warnings = Vec::new();
    let written = written(args, &PostFiles { input, machine, output }, progress, &mut warnings);
    let summary = match written {
        Ok(summary) => summary,
        Err(Failure::Input(mut messages)) => {
            messages.append(&mut warnings);
            return Err(Failure::Input(messages));
        }
        Err(failure) => return Err(failure),
    };
    let json = serde_json::to_value(&summary).map_err(anyhow::Error::from)?;
    let (table, kept) = (summary.describe(), summary.kept());
    Ok(PostAnswer { summary: json, table, kept, warnings })
}

/// Posts the input; nothing is in place before everything is complete. Warnings stand also behind a failure.
fn written(
    args: &PostArgs,
    files: &PostFiles<'_>,
    progress: &dyn Progress,
    warnings: &mut Vec<String>,
) -> Result<PostSummary, Failure> {
    let PostFiles { input, machine, output } = *files;
    let calibrated = args.to_calibrated.as_deref().map_or(Path::new(machine), Path::new);
    output::protect(output, &[input, Path::new(machine), calibrated])?;
    let plan = Plan::new(args, machine)?;
    let motion = args.motion.as_deref();
    if let Some(table) = motion {
        check_motion(&plan, input, table)?;
        output::protect(table, &[input, Path::new(machine), output])?;
    }
    let (mut outputs, name) = Outputs::beside(output)?;
    let posted = outputs.add_checked(&name, |out| {
        posting::post(&plan, plan.open(input, progress)?, warnings, out)
    })?;
    warnings.extend(warnings_of(&posted.report, input, output));
    if args.to_calibrated.is_some() {
        warnings.push(format!(
            "{}: the origin of the calibrated machine is not that of the ideal one\n  help: enter G54 as the head of \
             this program states it",
            output.display()
        ));
    }
    // The setup sheet belongs to the program: both are committed together.
    if output::is_regular(output) {
        let sheet = plan.sheet(&name, &posted.head)?;
        outputs.text(&sheet_name(&name), &sheet)?;
    }
    let setpoints = motion.map(|table| sample(args, &plan, input, table, progress)).transpose()?;
    outputs.commit()?;
    let setpoints = setpoints.map(Sampled::commit).transpose()?;
    Ok(PostSummary::new(&plan, &posted, output).with_setpoints(setpoints))
}

/// Returns the warnings about a program that was posted.
fn warnings_of(report: &PostReport, input: &Path, output: &Path) -> Vec<String> {
    let mut warnings = Vec::new();
    // Text of a template that the reader does not know: the program may still be right.
    if let Some(unread) = &report.unread {
        let path = output.display();
        warnings.push(format!(
            "{path}:{unread}\nwarning: the program was not read back from this line on"
        ));
    }
    // A feed far below the programmed one is never written without a word.
    let far = report.slowed.iter().filter(|one| one.ratio() >= FAR_BELOW);
    for one in far.take(MOST_WARNINGS) {
        let (path, line, ratio) = (input.display(), one.line, one.ratio());
        warnings.push(format!(
            "{path}:{line}: this move takes {ratio:.0} times its programmed time, because an axis cannot follow it"
        ));
    }
    if let Some(fast) = &report.fastest_rapid {
        let (path, line, ratio) = (input.display(), fast.line, fast.ratio);
        warnings.push(format!(
            "{path}:{line}: LinuxCNC limits X, Y and Z of the tip in a rapid move, not the axes: one of them \
             would run at {ratio:.2} times its velocity\n  help: lower MAX_LINEAR_VELOCITY of the configuration to \
             {:.0} % of what it is, or write a feed for such moves",
            (100.0 / ratio).floor()
        ));
    }
    warnings
}

/// Refuses what setpoints cannot be made of.
fn check_motion(plan: &Plan, input: &Path, table: &Path) -> Result<(), Failure> {
    let refused = |message: &str| Err(Failure::input(message));
    if input == Path::new("-") {
        return refused("--motion reads the input twice\n  help: name a file in place of -");
    }
    if plan.tools.are_several() {
        return refused("--motion is for one tool\n  help: choose one with --tool");
    }
    if is_parquet(table) && !cfg!(feature = "parquet") {
        return refused(
            "this build of trunnion does not write Parquet\n  help: build it with --features parquet, or name a .csv file",
        );
    }
    Ok(())
}

/// Setpoints that wait to be put in place.
struct Sampled {
    outputs: Outputs,
    summary: SetpointSummary,
}

impl Sampled {
    fn commit(self) -> Result<SetpointSummary, Failure> {
        self.outputs.commit()?;
        Ok(self.summary)
    }
}

/// Writes the setpoints of the input.
fn sample(
    args: &PostArgs,
    plan: &Plan,
    input: &Path,
    table: &Path,
    bars: &dyn Progress,
) -> Result<Sampled, Failure> {
    let period = setpoints::period(args.period, plan.kinematics.machine());
    let (mut outputs, name) = Outputs::beside(table)?;
    let source = SetpointSource::open(plan, input, period, bars)?;
    let written = outputs.add_checked(&name, |out| {
        #[cfg(feature = "parquet")]
        if is_parquet(table) {
            return source.write_columns(out);
        }
        source.write(out)
    })?;
    let summary = SetpointSummary {
        file: table.display().to_string(),
        period,
        rows: written.rows,
        duration: written.duration,
    };
    Ok(Sampled { outputs, summary })
}

/// Returns the name of the setup sheet: `part.setup.txt` beside `part.nc`.
fn sheet_name(name: &str) -> String {
    let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    format!("{stem}.setup.txt")
}
