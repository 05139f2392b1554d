//! `trunnion position`: one cutter location, explained.

mod answer;
mod args;
mod compare;
mod drawing;
mod inputs;
mod refusal;
mod run;

pub(crate) use args::PositionArgs;
pub(crate) use run::run;
