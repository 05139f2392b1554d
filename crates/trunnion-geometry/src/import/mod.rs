//! Readers of part files: STEP (feature `step`) and surface JSON give faces, STL gives a mesh.
//!
//! A format enters through the narrow trait [`Reader`] and leaves as the project's own
//! [`Face`](crate::surface::Face)s at once: nothing of a file's structure reaches another module.

mod error;
mod format;
pub mod inspect;
mod part;
#[cfg(feature = "step")]
pub mod step;
pub mod stl;
pub mod surface_json;

pub use error::ImportError;
pub use format::{looks_like, without_mark};
pub use part::{Part, Reader, Warning};
