//! Moves of a CL file or a program, one by one.

mod batch;
mod cl;
mod moves;
mod program;
mod refusal;
mod source;

pub(super) use batch::{BatchReader, InputBatch, InputMove};
pub(super) use moves::Input;
pub(super) use source::InputOptions;
