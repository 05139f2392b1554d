//! Distances between the bodies of a machine, the tool, fixtures and stock, over the whole motion, proven.
//!
//! A body is a closed mesh on a link of the chain (see `bodies`). Moves are boxes of axis positions in a tree over the program
//! (see `spans`). Where the axes are anywhere in a box, no point of one body is farther from where it is in the middle of
//! the box than a bound by the travels and their levers (see `pair`): the distance there less the bound holds for all moves of
//! the box. A best-first search divides boxes until the bound is within the tolerance (see `search`).

pub(crate) mod bodies;
mod linked;
mod pair;
mod search;
mod spans;
mod stock_watch;
pub(crate) mod watch;

pub use bodies::{BodyMeeting, MachineBodies};
pub use watch::{BodyApproach, BodyReport};
