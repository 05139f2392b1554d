//! A schedule sampled at the servo period.

mod error;
mod sample;

pub use error::SetpointError;
pub use sample::{SetpointIter, sample};
