//! The end of a straight block.

use super::kinematics::{ControlKinematics, RotaryRequest, TipTarget};
use super::word_frame::{TipFrame, WordFrame};
use super::words::end_words;
use crate::read::{Move, Pace, Turning};
use crate::types::{AXES, AxisVector};
use nalgebra::Point3;

/// Slot of the first rotary axis.
const FIRST_ROTARY: usize = AXES - 2;

/// End of a straight block.
#[derive(Debug, Clone, Copy)]
pub struct BlockEnd<R> {
    /// Axis positions \[mm, rad\].
    pub axes: AxisVector,
    /// Goal of the tip under tool-centre-point control.
    pub tip: Option<TipTarget>,
    /// Rotaries chosen for a tool direction.
    pub rotaries: Option<R>,
}

/// Returns what the words of a frame read at axis positions: positions, or the tip and the rotaries \[mm, rad\].
pub fn read_words<C: ControlKinematics>(
    control: &C,
    axes: &AxisVector,
    frame: &WordFrame,
) -> AxisVector {
    match frame {
        WordFrame::Axes(shift) => axes - shift,
        WordFrame::Tip(frame) => {
            let tip = frame.to_words(&control.tip(axes, frame.length));
            AxisVector::new(tip.x, tip.y, tip.z, axes[3], axes[4])
        }
    }
}

/// Returns the point that the X, Y, Z words of a frame name.
pub fn tip_target(frame: &TipFrame, words: &AxisVector) -> TipTarget {
    let point = frame.to_table(&Point3::new(words[0], words[1], words[2]));
    TipTarget { point, length: frame.length }
}

/// Returns where a straight block ends that begins at `from`.
///
/// # Errors
///
/// Those of the control's [`ControlKinematics`].
pub fn block_end<C: ControlKinematics>(
    control: &C,
    from: &AxisVector,
    block: &Move,
    frame: &WordFrame,
) -> Result<BlockEnd<C::Rotaries>, C::Error> {
    // Words left out stay as the tip reads now, even if the frame changed since the last block.
    let start = BlockStart { axes: *from, words: read_words(control, from, frame) };
    block_end_from(control, &start, block, frame)
}

/// Start of a block: axis positions, and what the words of its frame read there \[mm, rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockStart {
    /// Axis positions.
    pub axes: AxisVector,
    /// Words there ([`read_words`]).
    pub words: AxisVector,
}

/// Returns where a straight block ends, for a caller that has read the words of its start.
///
/// # Errors
///
/// Those of the control's [`ControlKinematics`].
pub fn block_end_from<C: ControlKinematics>(
    control: &C,
    start: &BlockStart,
    block: &Move,
    frame: &WordFrame,
) -> Result<BlockEnd<C::Rotaries>, C::Error> {
    let from = &start.axes;
    match frame {
        WordFrame::Axes(shift) => {
            let mut axes = end_words(*from, block, shift);
            // A turn of the rotaries alone: X, Y, Z stay unless words state them.
            let rotaries = choose(control, from, block, None)?;
            turn(control, &mut axes, rotaries.as_ref());
            Ok(BlockEnd { axes, tip: None, rotaries })
        }
        WordFrame::Tip(tip) => {
            let mut axes = end_words(start.words, block, &AxisVector::zeros());
            let target = tip_target(tip, &axes);
            let rotaries = choose(control, from, block, Some(target))?;
            turn(control, &mut axes, rotaries.as_ref());
            // The linear axes follow from the tip once the rotaries are known.
            let linear = control.linear_axes(&target, &axes, block.line)?;
            axes.fixed_rows_mut::<3>(0).copy_from(&linear);
            Ok(BlockEnd { axes, tip: Some(target), rotaries })
        }
    }
}

fn choose<C: ControlKinematics>(
    control: &C,
    near: &AxisVector,
    block: &Move,
    tip: Option<TipTarget>,
) -> Result<Option<C::Rotaries>, C::Error> {
    // A rapid move positions the rotaries by the shortest way.
    let turning = if block.pace == Pace::Rapid { Turning::Rotary } else { block.turning };
    let request = |direction| RotaryRequest {
        tip,
        turning,
        ..RotaryRequest::new(block.line, direction, near)
    };
    block.axis.map(|direction| control.rotaries(&request(direction))).transpose()
}

fn turn<C: ControlKinematics>(control: &C, axes: &mut AxisVector, rotaries: Option<&C::Rotaries>) {
    if let Some(rotaries) = rotaries {
        let positions = <[f64; 2]>::from(control.positions(rotaries));
        axes.fixed_rows_mut::<2>(FIRST_ROTARY).copy_from_slice(&positions);
    }
}
