//! `trunnion post`: writes a program for a machine from cutter locations or another program, with new feeds.

mod args;
mod head;
mod input;
mod moves;
mod plan;
mod posting;
mod run;
mod setpoints;
mod summary;
pub(crate) mod tools;

pub(crate) use args::PostArgs;
pub use moves::MovesAnswer;
pub(crate) use moves::moves;
pub use run::PostAnswer;
pub(crate) use run::{answer, run};
