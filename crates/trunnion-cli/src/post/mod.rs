//! `trunnion post`: writes a program for a machine from cutter locations or another program, with new feeds.

mod args;
mod head;
mod input;
mod plan;
mod posting;
mod run;
mod setpoints;
mod summary;
pub(crate) mod tools;

pub(crate) use args::PostArgs;
pub(crate) use run::run;
