//! Blocks of a program between positions, as a control takes them.

use super::control::Control;
use super::segment::{BlockTime, Course, Segment};
use crate::nc::control::ToolLength;
use crate::nc::read::Smoothing;
use crate::types::AxisVector;
use crate::verify::error::VerifyError;
use crate::verify::input::CheckInput;
use nalgebra::Point3;

/// Coordinates that a block moves in proportion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReplayedCourse {
    /// All axes.
    Axes,
    /// The tip in the table frame, and the rotaries.
    Tip {
        /// Length of the tool \[mm\].
        tool_length: f64,
    },
    /// Nothing moves, or nobody knows from where: the machine rests.
    Rest,
}

/// Speed that a block states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReplayedSpeed {
    /// Rapid speed.
    Rapid,
    /// A time of its own (`G93`).
    Time,
    /// A speed along its path (`G94`).
    Feed,
}

/// A straight block of a program, or a chord of an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ReplayedBlock {
    /// Line of the program.
    pub line: u32,
    /// Coordinates that it moves in proportion.
    pub course: ReplayedCourse,
    /// Those coordinates at both ends: of the axes, or X Y Z of the tip in place of the linear axes \[mm, rad\].
    pub ends: [AxisVector; 2],
    /// Speed that it states.
    pub speed: ReplayedSpeed,
    /// Time that this makes \[s\]; that of rapid moves is an estimate.
    pub seconds: f64,
    /// Distance from the path that the control may keep; `None`: no word was about it.
    pub smoothing: Option<Smoothing>,
}

/// Replays the blocks of a program, in order; arcs in chords within `chord` \[mm\]. `visit` may end the replay by an error.
/// Cutter locations have no blocks.
///
/// # Errors
///
/// [`VerifyError`], and those of `visit`.
pub fn replay_blocks<E: From<VerifyError>>(
    input: &CheckInput<'_>,
    chord: f64,
    mut visit: impl FnMut(&ReplayedBlock) -> Result<(), E>,
) -> Result<(), E> {
    let controls = input.controls()?;
    let run = input.run(controls.as_ref(), chord)?;
    let (Some(mut replay), Some(controls)) = (run.replay(), &controls) else { return Ok(()) };
    while let Some(segment) = replay.next() {
        let segment = segment?;
        visit(&block(controls.of(segment.tool), &segment, replay.smoothing))?;
    }
    Ok(())
}

fn block(control: &Control, segment: &Segment, smoothing: Option<Smoothing>) -> ReplayedBlock {
    let (course, ends) = course(control, segment);
    let speed = match (segment.rapid, segment.block.time) {
        (true, _) => ReplayedSpeed::Rapid,
        (false, BlockTime::Stated) => ReplayedSpeed::Time,
        (false, BlockTime::Exact | BlockTime::OverLength(_)) => ReplayedSpeed::Feed,
    };
    let Segment { line, duration: seconds, .. } = *segment;
    ReplayedBlock { line, course, ends, speed, seconds, smoothing }
}

/// Returns the coordinates that a segment moves in proportion, at both ends.
fn course(control: &Control, segment: &Segment) -> (ReplayedCourse, [AxisVector; 2]) {
    // Tips of a segment count from the workpiece origin, along the axes of the table.
    let origin = control.model(ToolLength::Active).setup().origin;
    let with_tips = |tips: [Point3<f64>; 2]| {
        let mut ends = segment.joints;
        for (end, tip) in ends.iter_mut().zip(tips) {
            end.fixed_rows_mut::<3>(0).copy_from(&(tip.coords + origin));
        }
        ends
    };
    match segment.course {
        Course::Joints => (ReplayedCourse::Axes, segment.joints),
        Course::Tip { ends, length } => {
            let tool_length = match length {
                ToolLength::Active => control.tool_length(),
                ToolLength::Cancelled => 0.0,
            };
            (ReplayedCourse::Tip { tool_length }, with_tips(ends))
        }
        Course::Circle { ends } => {
            let rotation = control.real().setup().rotation;
            let tips = ends.map(|end| rotation * end.tip);
            (ReplayedCourse::Tip { tool_length: control.tool_length() }, with_tips(tips))
        }
        Course::Rest | Course::Unknown => (ReplayedCourse::Rest, segment.joints),
    }
}
