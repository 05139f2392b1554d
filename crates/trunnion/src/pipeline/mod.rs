//! The whole chain from one job.
