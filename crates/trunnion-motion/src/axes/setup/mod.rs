//! The setup search: a rotation of the workpiece that keeps a path far from the singular directions
//! and inside travel.
//!
//! `angle_check` judges a rotation by angles alone and `rotary_triangle` by the ends of travel of the
//! rotaries; `evaluation` plans the axes. `local_search` finds good rotations fast; `optimality_proof`
//! halves boxes of rotations (`rotation_cell`) until none is left that could hold a better one.

mod angle_check;
mod evaluation;
mod local_search;
mod optimality_proof;
mod options;
mod progress;
mod result;
mod rotary_triangle;
mod rotation_cell;
mod search;
mod workpiece_tilt;

pub use options::SetupOptions;
pub use result::{EvaluatedSetup, PathTravel, SearchAssurance, SetupSearch, SetupVerdict};
pub use search::setup;
pub use workpiece_tilt::{TiltBounds, WorkpieceTilt};
