//! The table of work offsets.

use nalgebra::Vector3;

/// Number of Siemens `G500`: words count from machine zero.
pub const NO_OFFSET: u8 = u8::MAX;

/// A work offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkOffset {
    /// 0 for `G54`, 1 for `G55` and so on, see [`Frame::Work`](crate::read::Frame::Work).
    pub number: u8,
    /// Positions of X, Y, Z as they stand in the table: with the gauge point on the origin and the rotaries at
    /// zero \[mm\].
    pub origin: Vector3<f64>,
}

/// Work offsets as a program finds and leaves them, each with its origin in the table frame.
#[derive(Debug, Clone, Default)]
pub struct WorkOffsets(Vec<OffsetEntry>);

#[derive(Debug, Clone, Copy)]
pub(super) struct OffsetEntry {
    pub(super) offset: WorkOffset,
    /// Its origin in the table frame \[mm\].
    pub(super) in_table: Vector3<f64>,
}

impl WorkOffsets {
    /// Puts an offset in, in place of one of the same number; `in_table` is its origin in the table frame \[mm\].
    pub fn set(&mut self, offset: WorkOffset, in_table: Vector3<f64>) {
        // The table is short, and its order has no meaning.
        self.0.retain(|entry| entry.offset.number != offset.number);
        self.0.push(OffsetEntry { offset, in_table });
    }

    /// Returns the offset of a number.
    pub fn get(&self, number: u8) -> Option<WorkOffset> {
        self.entry(number).map(|entry| entry.offset)
    }

    pub(super) fn entry(&self, number: u8) -> Option<OffsetEntry> {
        self.0.iter().copied().find(|entry| entry.offset.number == number)
    }
}
