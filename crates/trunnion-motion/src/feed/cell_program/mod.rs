//! The two-variable linear program of one cell.

mod constraints;
mod guess;
mod search;
mod solve;

pub(super) use constraints::{Strips, least};
pub(super) use guess::Guess;
pub(super) use solve::{backward, forward};
