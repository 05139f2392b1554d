//! One move of the machine, as the control runs it.

use crate::math::angle::great_circle;
use crate::nc::control::ToolLength;
use crate::types::{AxisVector, ToolPose};
use crate::verify::error::VerifyError;
use nalgebra::Point3;

/// One move of the machine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Segment {
    /// Line of the program.
    pub(crate) line: u32,
    /// Place of the tool in the table.
    pub(crate) tool: usize,
    /// Axes at both ends.
    pub(crate) joints: [AxisVector; 2],
    /// Interpolation between both ends.
    pub(crate) course: Course,
    /// Time \[s\].
    pub(crate) duration: f64,
    /// Of which block it is.
    pub(crate) block: Block,
    /// Run at rapid speed: its time is an estimate.
    pub(crate) rapid: bool,
}

/// The block that a move is a part of, as the chords of an arc are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    /// Time of all of it \[s\].
    pub(crate) duration: f64,
    /// Angle of an arc \[rad\].
    pub(crate) sweep: f64,
    /// It begins with this move.
    pub(crate) begins: bool,
    /// It ends with this move.
    pub(crate) ends: bool,
    /// Origin of its time.
    pub(crate) time: BlockTime,
}

/// Origin of the time of a block.
#[derive(Debug, Clone, Copy)]
pub(crate) enum BlockTime {
    /// Nothing is rounded: the move is rapid, or stands still.
    Exact,
    /// The program states it as inverse time.
    Stated,
    /// The length of the path over the programmed speed.
    OverLength(FeedLength),
}

/// Length along which a feed counts.
#[derive(Debug, Clone, Copy)]
pub(crate) enum FeedLength {
    /// Of the tip, or of X, Y and Z \[mm\].
    Linear(f64),
    /// Of the rotaries, where X, Y and Z stand \[degrees\].
    Degrees(f64),
}

impl FeedLength {
    /// Returns the number without its unit.
    pub(crate) fn value(self) -> f64 {
        match self {
            Self::Linear(length) | Self::Degrees(length) => length,
        }
    }
}

impl Block {
    /// A block of one move.
    pub(crate) fn of_one(duration: f64) -> Self {
        Self { duration, sweep: 0.0, begins: true, ends: true, time: BlockTime::Exact }
    }
}

/// Coordinates that are linear in a move.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Course {
    /// All axes.
    Joints,
    /// The rotaries, and the tip in the table frame as the control knows it.
    Tip {
        /// Tip at both ends \[mm\].
        ends: [Point3<f64>; 2],
        /// Tool or gauge point.
        length: ToolLength,
    },
    /// The tip, and the tool axis on the great circle, in the workpiece frame.
    Circle {
        /// The tool at both ends.
        ends: [ToolPose; 2],
    },
    /// Nothing moves.
    Rest,
    /// A rapid move of axes whose positions a tool change left unknown, or before the first tool.
    Unknown,
}

impl Segment {
    /// Returns true if its path is not known.
    pub(crate) fn is_unknown(&self) -> bool {
        matches!(self.course, Course::Unknown)
    }

    /// Returns its beginning, up to a `share` of its time within 0..=1, with all axes together even if it is rapid.
    ///
    /// Between tips the linear axes at the end are not those of the control: nothing that moves the tool reads them.
    pub(crate) fn until(&self, share: f64) -> Result<Self, VerifyError> {
        let [from, to] = self.joints;
        let course = match self.course {
            Course::Tip { ends: [start, end], length } => {
                Course::Tip { ends: [start, start + (end - start) * share], length }
            }
            Course::Circle { ends } => {
                Course::Circle { ends: [ends[0], on_circle(&ends, share, self.line)?] }
            }
            other => other,
        };
        let (joints, duration) = ([from, from + (to - from) * share], self.duration * share);
        Ok(Self { joints, course, duration, rapid: false, ..*self })
    }
}

/// Between two poses.
pub(crate) fn on_circle(
    [from, to]: &[ToolPose; 2],
    t: f64,
    line: u32,
) -> Result<ToolPose, VerifyError> {
    let axis = great_circle(&from.axis, &to.axis, t).ok_or(VerifyError::TurnsTooFar { line })?;
    Ok(ToolPose { tip: from.tip + (to.tip - from.tip) * t, axis })
}
