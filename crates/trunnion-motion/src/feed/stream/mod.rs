//! A path that arrives bit by bit, planned through a window that can always stop at its end.

mod any_stream;
mod feed_stream;
mod jerk_stream;
mod nodes;
mod options;
mod step;
mod step_sampler;
mod whole_path;
mod window;

pub use any_stream::{AnyStream, StreamKind};
pub use feed_stream::FeedStream;
pub use jerk_stream::JerkStream;
pub use options::StreamOptions;
pub use step::StreamStep;
pub use step_sampler::StepSampler;
pub use whole_path::{RowCount, jerk_through_window};
