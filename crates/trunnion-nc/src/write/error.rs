//! Errors of the writers.

use super::template::TemplateError;
use std::fmt;

/// Reason why a text cannot be written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The receiver of the text failed.
    #[error("the text cannot be stored")]
    Store(#[from] fmt::Error),
    /// Nothing to write.
    #[error("there is no motion to write")]
    Empty,
    /// A number that no program can hold.
    #[error("block {block}: {value} cannot be written with {decimals} decimals")]
    Number {
        /// Index of the block.
        block: usize,
        /// The number, in mm, degrees or 1/min.
        value: f64,
        /// Decimals asked for.
        decimals: u8,
    },
    /// A block that moves in no time, or in so much that its feed word would be 0.
    #[error("block {block} takes {duration} s, which no inverse-time feed word can express")]
    Duration {
        /// Index of the block.
        block: usize,
        /// Its time \[s\].
        duration: f64,
    },
    /// A template that cannot be filled.
    #[error(transparent)]
    Template(#[from] TemplateError),
    /// A second tool, and a template without a tool change.
    #[error("the template has no block `toolchange`, which a program with several tools needs")]
    NoToolChange,
    /// X, Y and Z do not span space.
    #[error("the linear axes do not reach every position, so there is no work offset")]
    WorkOffset,
}
