//! One value of a foreign file.

/// One value as written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SourceValue {
    pub(super) key: String,
    pub(super) value: String,
    pub(super) line: u64,
}
