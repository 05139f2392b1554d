//! The two-variable linear program of one cell.

mod constraints;
mod guess;
mod search;
mod solve;

pub(super) use constraints::{CellConstraints, least};
pub(super) use guess::WarmStart;
pub(super) use solve::{backward, forward};
