//! Moves of a CL file or a program, one by one.

mod cl;
mod moves;
mod program;
mod refusal;
mod source;

pub(super) use moves::Input;
pub(super) use source::InputOptions;
