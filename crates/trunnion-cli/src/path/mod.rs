//! `trunnion path`: cutter locations of a job, or of a CL file, smoothed.

mod answer;
mod args;
pub(crate) mod chart;
mod conserved;
pub(crate) mod lines;
pub(crate) mod profile;
mod run;
mod smoothed;

pub(crate) use args::PathArgs;
pub(crate) use run::run;
