//! The fewest program blocks for a given kind of control within tolerance.

mod bend;
mod deviation;
mod error;
mod options;
mod reduce;
mod search;
mod smooth_piece;
mod validate;
mod whole_path;

pub(crate) use bend::arms;
pub use deviation::{BlockEnd, bend, moved};
pub use error::BlocksError;
pub use options::{BlockInterpolation, BlockOptions};
pub use reduce::{ReduceOptions, reduce};
pub use whole_path::{blocks, by_piece};
