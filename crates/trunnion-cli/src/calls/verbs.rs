//! Verbs that take options.

use crate::check::{CheckAnswer, ReplayAnswer, TimedStockAnswer};
use crate::feed::{AxisTable, PlanAnswer};
use crate::init::ProposalAnswer;
use crate::machine::{self as machines, CalibrationAnswer, ImportAnswer};
use crate::outcome::Failure;
use crate::post::{MovesAnswer, PostAnswer};
use crate::setup::SetupAnswer;
use crate::{check as checks, feed, init, post as posts, setup as setups};
use clap::{Args, Command};
use trunnion::files::limits::LimitsFile;
use trunnion::nc::read::SubprogramFile;
use trunnion::types::Progress;

/// Checks a program, CL file or table of setpoints, as `trunnion check` does.
///
/// # Errors
///
/// Wrong options or input.
pub fn check(options: &[String], progress: &dyn Progress) -> Result<CheckAnswer, Failure> {
    checks::answer(&parsed("check", options)?, progress)
}

/// Runs a program or CL file as `trunnion check` does, and returns the moves in place of a verdict.
///
/// # Errors
///
/// Wrong options or input.
pub fn replay(options: &[String], progress: &dyn Progress) -> Result<ReplayAnswer, Failure> {
    checks::replay(&parsed("check", options)?, progress)
}

/// Prepares the stock of a program or CL file to be cut in a picture, with rays about `cell` \[mm\] apart; the box of the part
/// where no stock is named, and nothing without a part. The options are those of `trunnion check`.
///
/// # Errors
///
/// Wrong options or input.
pub fn timed_stock(
    options: &[String],
    cell: f64,
    progress: &dyn Progress,
) -> Result<Option<TimedStockAnswer>, Failure> {
    checks::timed_stock(&parsed("check", options)?, cell, progress)
}

/// Returns the files of the subprograms that a program runs as `trunnion check` finds them; what it depends on beside the
/// files that the options name.
///
/// # Errors
///
/// Wrong options, or a file that cannot be read.
pub fn subprograms(options: &[String]) -> Result<Vec<SubprogramFile>, Failure> {
    checks::subprograms(&parsed("check", options)?)
}

/// Posts a CL file or program, as `trunnion post` does.
///
/// # Errors
///
/// Wrong options or input, or poses out of reach.
pub fn post(options: &[String], progress: &dyn Progress) -> Result<PostAnswer, Failure> {
    posts::answer(&parsed("post", options)?, progress)
}

/// Reads the moves of a CL file or program; the options are those of `trunnion post`.
///
/// # Errors
///
/// Wrong options or input.
pub fn moves(options: &[String], progress: &dyn Progress) -> Result<MovesAnswer, Failure> {
    posts::moves(&parsed("post", options)?, progress)
}

/// Plans the speed along a table in memory; the options are those of `trunnion feed`.
///
/// # Errors
///
/// Wrong options, limits or rows.
pub fn plan(
    options: &[String],
    table: AxisTable<'_>,
    limits: &LimitsFile,
    progress: &dyn Progress,
) -> Result<PlanAnswer, Failure> {
    feed::answer(parsed("feed", options)?, table, limits, progress)
}

/// Proposes a job for a part; the options are those of `trunnion init`, and nothing is written.
///
/// # Errors
///
/// Wrong options or input, or a part that no cutter of the library finishes.
pub fn propose(options: &[String], progress: &dyn Progress) -> Result<ProposalAnswer, Failure> {
    init::answer(&parsed("init", options)?, progress)
}

/// Searches setups of a job; the options are those of `trunnion setup`.
///
/// # Errors
///
/// Wrong options, or a job that cannot be planned.
pub fn setup(options: &[String], progress: &dyn Progress) -> Result<SetupAnswer, Failure> {
    setups::answer(&parsed("setup", options)?, progress)
}

/// Turns the description of a machine by a control or another program into a machine file; the options are those of
/// `trunnion machine import`, and nothing is written.
///
/// # Errors
///
/// Wrong options or input, or values that the description does not state.
pub fn import(options: &[String]) -> Result<ImportAnswer, Failure> {
    machines::imported(&parsed("import", options)?)
}

/// Finds the errors of a machine from measured spheres; the options are those of `trunnion machine calibrate`, and
/// nothing is written.
///
/// # Errors
///
/// Wrong options or input, or readings of another machine.
pub fn calibrate(options: &[String]) -> Result<CalibrationAnswer, Failure> {
    machines::calibration(&parsed("calibrate", options)?)
}

/// Reads the options of a verb.
fn parsed<A: Args>(verb: &'static str, options: &[String]) -> Result<A, Failure> {
    let command = A::augment_args(Command::new(verb).no_binary_name(true));
    let matches = command.try_get_matches_from(options);
    matches.and_then(|matches| A::from_arg_matches(&matches)).map_err(|error| {
        let text = error.to_string();
        // Below the first paragraph clap explains how to ask for help on a command line.
        let first = text.split("\n\n").next().unwrap_or_default();
        Failure::input(first.trim_start_matches("error: "))
    })
}
