//! Work offsets that a program writes: `G10 L2`, `G10 L20`.

use super::word_frame::ToolLength;
use super::work_offsets::{WorkOffset, WorkOffsets};
use crate::read::{Offset, OffsetKind};
use crate::types::AxisVector;
use nalgebra::Vector3;
use thiserror::Error;

/// Reason why a written work offset cannot be followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum OffsetFault {
    /// A rotary axis is shifted.
    #[error("a work offset of a rotary axis")]
    Rotary,
    /// Some values are written, and the others are not known.
    #[error("a part of a work offset whose other values are not known")]
    Partial,
    /// The position is that of the tip.
    #[error("a work offset by the position (G10 L20) under tool-centre-point control")]
    UnderTcp,
    /// The position is not known.
    #[error("a work offset by a position (G10 L20) that a tool change left unknown")]
    UnknownPosition,
}

/// Position that `G10 L20` reads.
#[derive(Debug, Clone, Copy)]
pub enum OffsetReading {
    /// Axes, and the compensation of the last block; `None` where that ran under tool-centre-point control.
    Axes {
        /// Axis positions \[mm, rad\].
        axes: AxisVector,
        /// Compensation in force.
        length: Option<ToolLength>,
        /// Length of the tool in the spindle \[mm\].
        tool_length: f64,
    },
    /// A tool change left the position unknown.
    Unknown,
}

impl WorkOffsets {
    /// Returns the offset that a block writes; the caller puts it into the table.
    ///
    /// # Errors
    ///
    /// [`OffsetFault`].
    pub fn written(
        &self,
        block: &Offset,
        reading: &OffsetReading,
    ) -> Result<WorkOffset, OffsetFault> {
        let Offset { offset: number, words: [x, y, z, turns @ ..], kind, .. } = *block;
        if turns.iter().flatten().any(|turn| turn.abs() > 0.0) {
            return Err(OffsetFault::Rotary);
        }
        let words = [x, y, z];
        let mut origin = match self.get(number) {
            Some(known) => known.origin,
            None if words.iter().all(Option::is_some) => Vector3::zeros(),
            None => return Err(OffsetFault::Partial),
        };
        for (slot, word) in words.into_iter().enumerate() {
            let Some(word) = word else { continue };
            origin[slot] = match kind {
                OffsetKind::Origin => word,
                OffsetKind::Reading => read_origin(reading, slot)? - word,
                OffsetKind::Standing => origin[slot],
            };
        }
        Ok(WorkOffset { number, origin })
    }
}

/// Position of an axis less what the tool adds to it \[mm\]: where the origin is if the axis reads zero.
fn read_origin(reading: &OffsetReading, slot: usize) -> Result<f64, OffsetFault> {
    match *reading {
        OffsetReading::Axes { length: None, .. } => Err(OffsetFault::UnderTcp),
        OffsetReading::Axes { axes, length: Some(length), tool_length } => {
            let along_z = if slot == 2 { length.of(tool_length) } else { 0.0 };
            Ok(axes[slot] - along_z)
        }
        OffsetReading::Unknown => Err(OffsetFault::UnknownPosition),
    }
}
