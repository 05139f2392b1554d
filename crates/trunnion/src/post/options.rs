//! Inputs and options of posting.

use crate::blocks::BlockInterpolation;
use crate::machine::Kinematics;
use crate::nc::write::{Note, Template};
use crate::types::{AxisVector, PoseTolerance, ToolPose};

/// Source of the moves, which decides the motion of the tool between them.
#[derive(Debug, Clone)]
pub enum PostSource {
    /// Cutter locations: the tip moves straight, the tool axis on a great circle.
    Locations,
    /// A program for this machine, set up as the program assumes; [`PostMove::way`] is its control's motion.
    Program(Box<Kinematics>),
}

/// Programmed speed of a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PostPace {
    /// Rapid.
    Rapid,
    /// Largest tip speed \[mm/s\]; where the tip stands still, the axes run as fast as they can.
    Feed(f64),
    /// Shortest time of the move \[s\].
    Seconds(f64),
}

/// One move of the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostMove {
    /// Line of the input, counted from 1.
    pub line: u32,
    /// Tool pose at the end of the move, workpiece frame.
    pub pose: ToolPose,
    /// Axes at the end of the move, if the input is a program.
    pub q: Option<AxisVector>,
    /// Programmed speed.
    pub pace: PostPace,
    /// Motion of the tool during the move; for cutter locations [`BlockInterpolation::GreatCircle`].
    pub way: BlockInterpolation,
}

/// Treatment of the moves before they are posted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PostFilter {
    /// Posts the moves as they are.
    None,
    /// Fits a C3 path through the moves between rapid moves and divides it into chords.
    Smooth,
    /// Leaves out moves that a longer one replaces within tolerance.
    Reduce,
}

/// Timing method, with the axis limits it keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PostMethod {
    /// Keeps velocities and accelerations along a smooth path through the ends of all blocks.
    Optimal,
    /// Keeps jerks as well.
    Jerk,
    /// Keeps velocities and accelerations of straight blocks, with the speed changing at a constant rate.
    ///
    /// Where two blocks meet, the axes may step by the change of one servo period, so the acceleration limit does
    /// not hold exactly. A control without smoothing runs this way: [`look_ahead`](crate::feed::look_ahead).
    Blocks,
    /// Keeps no limits: times are those of the input, and the load on the axes is only reported.
    Programmed,
}

/// Options of posting. Begin with [`PostOptions::within`] and change the rest by struct update. There is no
/// `Default`: tolerances depend on part and machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostOptions {
    /// Motion of the target control between blocks.
    pub control: BlockInterpolation,
    /// Largest deviation from the input, everywhere; the rounding of words is extra.
    ///
    /// The path that is timed rounds corners within the same tolerance.
    pub tolerance: PoseTolerance,
    /// Tip speed to which feeds may be raised \[mm/s\]; `None` keeps the feeds of the input as upper limits.
    pub max_feed: Option<f64>,
    /// Timing method, and with it the limits that are kept.
    pub method: PostMethod,
    /// Look-ahead of the planner \[rows\].
    pub window: usize,
    /// Treatment of the moves before posting; it takes part of the tolerance.
    pub filter: PostFilter,
    /// Retract along the tool axis for unwinding inside a cut \[mm\].
    ///
    /// It is used where a rotary axis reaches the end of its travel and no other solution from the start of the cut
    /// leads farther: the tool retracts, the rotaries unwind, and the tool returns. `None` refuses such a cut.
    /// Controls that choose the rotaries themselves are not affected.
    pub unwind: Option<f64>,
}

/// Look-ahead window that lets a machine stop from full speed in fine programs \[rows\].
pub const POST_WINDOW: usize = 4096;

impl PostOptions {
    /// Posts within a tolerance for a control with that motion between blocks.
    ///
    /// Presets: the moves as they are, at no more than their own feeds, with velocities and accelerations kept along a
    /// smooth path; no retract inside a cut.
    #[must_use]
    pub const fn within(control: BlockInterpolation, tolerance: PoseTolerance) -> Self {
        Self {
            control,
            tolerance,
            max_feed: None,
            method: PostMethod::Optimal,
            window: POST_WINDOW,
            filter: PostFilter::None,
            unwind: None,
        }
    }
}

/// Texts at the head of a program.
#[derive(Debug, Clone, Copy)]
pub struct ProgramHead<'a> {
    /// Name, tool, spindle and feed of the program.
    pub note: &'a Note<'a>,
    /// Template of the dialect.
    pub template: &'a Template,
}
