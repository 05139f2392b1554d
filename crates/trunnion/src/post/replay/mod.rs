//! Replays a program as moves of the tool: the rules of [`nc::control`](crate::nc::control) with the
//! makers' inverse kinematics.

mod bare_moves;
mod control;
mod left_out;
mod only_tool;
mod program_moves;

pub use left_out::LeftOut;
pub use program_moves::ProgramMoves;
