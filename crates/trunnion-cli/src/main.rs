//! The command line: read, call the library, write.
//!
//! Exit codes: 0 done; 1 done, but a tolerance or limit is broken; 2 bad input or usage, nothing
//! written; 3 internal.

mod check;
mod feed;
mod figure;
mod inspect;
mod machine;
mod material;
mod motion;
mod outcome;
mod output;
#[cfg(feature = "parquet")]
mod parquet;
mod part;
mod path;
mod places;
mod pose;
mod position;
mod post;
mod progress;
mod report;
mod run;
mod setup;
mod table;
mod text;

use clap::{CommandFactory, Parser, Subcommand};
use outcome::{Done, Failure};
use std::path::PathBuf;
use std::process::ExitCode;

/// Five-axis machining, from surface to servo, with proof.
#[derive(Debug, Parser)]
#[command(name = "trunnion", version, arg_required_else_help = true)]
struct Arguments {
    /// One machine-readable summary on stdout, and nothing else there.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// The whole chain: surface to passes, axis motion, programs, check and report.
    Run(run::Args),
    /// An NC program or CL file, simulated and measured against the part and the machine.
    Check(Box<check::Args>),
    /// The rotation of the workpiece that keeps a job's path off the singular directions.
    ///
    /// Next to a singular direction (the tool parallel to the workpiece-side rotary axis) that axis must
    /// turn fast, and holds the feed back. Turning the workpiece moves the path away from there.
    /// Prints the [setup] lines to paste into the job file. The part alone is looked at: see that it
    /// clears table and fixture.
    Setup(setup::Args),
    /// Cutter locations of a job, or of a CL file, as a CL file; smoothed with --smooth.
    ///
    /// Smoothing lays a C3 path through the locations between rapid moves: corners are found first, and rounded
    /// within the tolerance or kept. Lines that move nothing stay as they stand.
    Path(path::Args),
    /// Faces of a part with number, kind, size and smallest concave radius; a picture with -o.
    Inspect(inspect::Args),
    /// Machine files: those built in, what is in one, what is wrong with one.
    Machine {
        #[command(subcommand)]
        action: machine::Action,
    },
    /// Tables of tool poses to tables of machine axes, and back.
    Pose(pose::Args),
    /// One cutter location: the widest strip from a point of a face, explained.
    Position(position::Args),
    /// A CL file or program to a program for a machine, with feeds that its axes can follow.
    ///
    /// Poses become axis positions, moves are cut as finely as the control needs to stay within tolerance, and every
    /// block gets a feed at which no axis exceeds its velocity or acceleration. Memory stays the same however long
    /// the file is.
    Post(Box<post::Args>),
    /// Speed along a table of axis positions: as fast as the axes allow, with or without jerk limits.
    Feed(feed::Args),
    /// JSON schema of a file format, for editors and scripts.
    Schema {
        /// Which format.
        format: Format,
    },
    /// Open the report of a run in the browser.
    View {
        /// Output folder of a run, or the report itself.
        folder: PathBuf,
    },
    /// Completions for a shell: `trunnion completions bash > ...`.
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Format {
    Job,
    Machine,
    Surface,
    Summary,
    Setup,
    Limits,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    outcome::exit(dispatch(&arguments))
}

fn dispatch(arguments: &Arguments) -> Result<Done, Failure> {
    match &arguments.verb {
        Verb::Run(args) => run::run(args, arguments.json),
        Verb::Check(args) => check::run(args, arguments.json),
        Verb::Setup(args) => setup::run(args, arguments.json),
        Verb::Path(args) => path::run(args, arguments.json),
        Verb::Inspect(args) => inspect::run(args, arguments.json),
        Verb::Machine { action } => machine::run(action, arguments.json),
        Verb::Pose(args) => pose::run(args, arguments.json),
        Verb::Position(args) => position::run(args, arguments.json),
        Verb::Post(args) => post::run(args, arguments.json),
        Verb::Feed(args) => feed::run(args, arguments.json),
        Verb::Schema { format } => schema(*format),
        Verb::View { folder } => view(folder),
        Verb::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(*shell, &mut Arguments::command(), "trunnion", &mut text);
            text::print(&String::from_utf8_lossy(&text))
        }
    }
}

fn schema(format: Format) -> Result<Done, Failure> {
    use trunnion::files::schema;
    text::print(&match format {
        Format::Job => schema::job(),
        Format::Machine => schema::machine(),
        Format::Surface => schema::surface(),
        Format::Summary => schema::summary(),
        Format::Setup => schema::setup(),
        Format::Limits => schema::limits(),
    })
}

/// Hands the report to whatever the desktop opens HTML files with.
fn view(folder: &std::path::Path) -> Result<Done, Failure> {
    let page = if folder.is_dir() { folder.join("report.html") } else { folder.to_owned() };
    if !page.is_file() {
        let help = "run a job first: trunnion run JOB.toml";
        return Err(Failure::input(format!("{}: no report here\n  help: {help}", page.display())));
    }
    let opener = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    match std::process::Command::new(opener).arg(&page).status() {
        Ok(_) => Ok(Done::Kept),
        Err(error) => Err(Failure::input(format!(
            "cannot start {opener} ({error})\n  help: open {} in a browser",
            page.display()
        ))),
    }
}
