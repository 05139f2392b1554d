//! Values with the words that named them.

/// A value of the command line or of a job, and the words that stand before its errors.
#[derive(Debug, Clone)]
pub(super) struct Named<T> {
    /// Option as typed, or position in the job file.
    pub(super) name: String,
    pub(super) value: T,
}

impl<T> Named<T> {
    pub(super) fn new(name: impl Into<String>, value: T) -> Self {
        Self { name: name.into(), value }
    }
}
