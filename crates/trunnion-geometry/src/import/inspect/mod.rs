//! Facts about the faces of a part by which a user names them in a job.

mod face_summary;
mod picture;
mod quadrature;

pub use face_summary::{AreaElement, FaceSummary, elements, summary};
pub use picture::picture;
