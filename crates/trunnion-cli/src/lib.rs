//! Command line: reads input, calls the library, writes output.
//!
//! Exit codes: 0 done; 1 done, but a tolerance or limit is broken; 2 bad input or usage, nothing
//! written; 3 internal.
//!
//! The binary calls [`main`]. Shells for other languages call the verbs as functions, in [`calls`].

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod batch;
pub mod calls;
mod check;
mod decimals;
mod desktop;
mod disk;
mod feed;
mod figure;
mod form;
mod init;
mod inspect;
mod library;
mod linuxcnc;
mod machine;
mod material;
mod motion;
mod option_values;
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
mod program_files;
mod progress;
mod report;
mod run;
mod setup;
mod studio;
mod table;
mod table_tool;
mod text;

use clap::{CommandFactory, Parser, Subcommand};
use form::OutputForm;
use outcome::Done;
pub use outcome::Failure;
use std::path::PathBuf;
use std::process::ExitCode;

/// Five-axis machining, from surface to servo, with proof.
#[derive(Debug, Parser)]
#[command(name = "trunnion", version, arg_required_else_help = true, max_term_width = 100)]
struct Arguments {
    /// Print one machine-readable summary on stdout, and nothing else there.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Write a job for a part: faces, cutter, origin and feeds that run as they are, with comments.
    ///
    /// The job cuts the faces that the machine reaches from above. The cutter is the largest of a library
    /// that reaches nearly all that smaller ones reach. Planes beside concave faces get a flat end mill of their own, and
    /// hollows a ball behind a larger one: a job of several operations. The origin keeps the axes inside travel.
    Init(init::InitArgs),
    /// Run the whole chain: surface to passes, axis motion, programs, check and report.
    Run(run::RunArgs),
    /// Check an NC program or CL file: simulate it and measure it against the part and the machine.
    Check(Box<check::CheckArgs>),
    /// Run many jobs, and check many programs, on this machine; what is finished is not run again.
    Batch(batch::BatchArgs),
    /// Search the rotation of the workpiece that keeps a job's path off the singular directions.
    ///
    /// Near a singular direction (the tool parallel to the workpiece-side rotary axis) that axis must turn fast, which
    /// limits the feed. Turning the workpiece moves the path away from there. The command prints the [setup] lines to
    /// paste into the job file. It considers the part alone: check that the turned part clears table and fixture.
    Setup(setup::SetupArgs),
    /// Write the cutter locations of a job or of a CL file as a CL file; smoothed with --smooth.
    ///
    /// Smoothing fits a C3 path through the locations between rapid moves. Corners are found first, and rounded within
    /// the tolerance or kept. Lines without motion stay unchanged.
    Path(path::PathArgs),
    /// List the faces of a part with number, kind, size and smallest concave radius; draw them with -o.
    Inspect(inspect::InspectArgs),
    /// List, show, check, make, import and calibrate machine files.
    Machine {
        #[command(subcommand)]
        action: machine::Action,
    },
    /// Write a configuration of `LinuxCNC` for a machine, which runs as a simulator.
    ///
    /// It has the limits of the machine file, HAL, a tool table and the codes M428 and M429 that switch tool-centre-point
    /// control. The kinematics are those of the machine file, by the module trunnionkins of the folder `linuxcnc`.
    /// A text beside it says what to change for real drives.
    Linuxcnc(linuxcnc::LinuxcncArgs),
    /// Convert tables of tool poses to tables of machine axes, and back.
    Pose(pose::PoseArgs),
    /// Compute one cutter location: the widest strip from a point of a face, explained.
    Position(position::PositionArgs),
    /// Post a CL file or program for a machine, with feeds that its axes can follow.
    ///
    /// Poses become axis positions. Moves are divided as finely as the control needs to stay within tolerance. Every
    /// block gets a feed at which no axis exceeds its velocity or acceleration. Memory does not grow with the length of
    /// the file.
    Post(Box<post::PostArgs>),
    /// Plan the speed along a table of axis positions: as fast as the axes allow, with or without jerk limits.
    Feed(feed::FeedArgs),
    /// Print the JSON schema of a file format, for editors and scripts.
    Schema {
        /// File format.
        format: Format,
    },
    /// Open the report of a run in the browser.
    View {
        /// Output folder of a run, or the report itself.
        folder: PathBuf,
    },
    /// Plan and check in a page of the browser, with everything computed there; see the book.
    Studio(studio::StudioArgs),
    /// Print completions for a shell: `trunnion completions bash > ...`.
    Completions {
        /// Shell.
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
    Library,
}

/// Runs the verb that the arguments of the process name, and returns its exit code.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    outcome::exit(dispatch(&arguments))
}

fn dispatch(arguments: &Arguments) -> Result<Done, Failure> {
    let form = if arguments.json { OutputForm::Json } else { OutputForm::Text };
    match &arguments.verb {
        Verb::Init(args) => init::run(args, form),
        Verb::Run(args) => run::run(args, form),
        Verb::Check(args) => check::run(args, form),
        Verb::Batch(args) => batch::run(args, form),
        Verb::Setup(args) => setup::run(args, form),
        Verb::Path(args) => path::run(args, form),
        Verb::Inspect(args) => inspect::run(args, form),
        Verb::Linuxcnc(args) => linuxcnc::run(args, form),
        Verb::Machine { action } => machine::run(action, form),
        Verb::Pose(args) => pose::run(args, form),
        Verb::Position(args) => position::run(args, form),
        Verb::Post(args) => post::run(args, form),
        Verb::Feed(args) => feed::run(args, form),
        Verb::Schema { format } => schema(*format),
        Verb::View { folder } => view(folder),
        Verb::Studio(args) => studio::run(args, form),
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
        Format::Library => schema::library(),
    })
}

/// Opens the report with the program of the desktop for HTML files.
fn view(folder: &std::path::Path) -> Result<Done, Failure> {
    let page = if folder.is_dir() { folder.join("report.html") } else { folder.to_owned() };
    if !page.is_file() {
        let help = "run a job first: trunnion run JOB.toml";
        return Err(Failure::input(format!(
            "{}: there is no report\n  help: {help}",
            page.display()
        )));
    }
    desktop::open(&page.display().to_string())?;
    Ok(Done::Kept)
}
