//! Arguments of the verb.

use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct LinuxcncArgs {
    /// Machine file, or name of a built-in machine.
    pub(super) machine: String,
    /// Folder for the configuration; a configuration that is there already is left as it is.
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: PathBuf,
    /// Planner of the motion.
    #[arg(long, value_enum, default_value_t = Planner::Stock)]
    pub(super) planner: Planner,
    /// Length of tool 1 in the tool table, in mm: gauge point to tip.
    #[arg(long, value_name = "MM", default_value_t = 100.0)]
    pub(super) tool_length: f64,
}

/// Planner module that the configuration names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Planner {
    /// The planner that comes with `LinuxCNC`.
    Stock,
    /// The planner of trunnion, which keeps velocity, acceleration and jerk of every joint.
    Trunnion,
}
