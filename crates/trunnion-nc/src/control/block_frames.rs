//! The frame of a block: work offset, tilted plane, tool length.

use super::word_frame::{TipFrame, ToolLength, WordFrame};
use super::work_offsets::WorkOffsets;
use crate::read::{Frame, Move, Plane};
use crate::types::AxisVector;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use thiserror::Error;

/// A work offset that the table does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("work offset {number} (0 is G54) is not in the table; put its values in")]
pub struct UnknownOffset {
    /// 0 for `G54`, 1 for `G55` and so on.
    pub number: u8,
}

/// Work offsets and the tilted plane that the words of a block count from.
#[derive(Debug, Clone, Default)]
pub struct BlockFrames {
    /// Table of work offsets.
    pub offsets: WorkOffsets,
    /// The last tilted plane.
    pub plane: Option<Plane>,
}

impl BlockFrames {
    /// Returns the coordinates that the words of a block are; `tool_length` is that of the tool in the spindle \[mm\].
    ///
    /// # Errors
    ///
    /// [`UnknownOffset`].
    pub fn frame_of(&self, block: &Move, tool_length: f64) -> Result<WordFrame, UnknownOffset> {
        let (Frame::Work { offset, tcp, .. }, Some(length)) =
            (block.frame, ToolLength::in_frame(&block.frame))
        else {
            return Ok(WordFrame::Axes(AxisVector::zeros()));
        };
        let entry = self.offsets.entry(offset).ok_or(UnknownOffset { number: offset })?;
        if !tcp {
            // axis = word + offset + length along Z
            let shift = entry.offset.origin + Vector3::z() * length.of(tool_length);
            return Ok(WordFrame::Axes(AxisVector::new(shift.x, shift.y, shift.z, 0.0, 0.0)));
        }
        let table_from_words = self.table_from_words(block, entry.in_table);
        Ok(WordFrame::Tip(TipFrame { length, table_from_words }))
    }

    /// First the tilted plane, then the shift to the offset's origin; `None` where there is neither.
    fn table_from_words(&self, block: &Move, origin: Vector3<f64>) -> Option<Isometry3<f64>> {
        let shift = (origin != Vector3::zeros())
            .then(|| Isometry3::from_parts(Translation3::from(origin), UnitQuaternion::identity()));
        let plane = self
            .plane
            .filter(|plane| plane.number == block.plane)
            .map(|plane| plane.work_from_plane);
        match (shift, plane) {
            (Some(shift), Some(plane)) => Some(shift * plane),
            (shift, plane) => shift.or(plane),
        }
    }
}
