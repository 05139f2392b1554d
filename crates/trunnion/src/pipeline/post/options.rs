//! What is posted and how, and what that did.

use super::{PostChoice, PostFilter};
use crate::blocks::Control;
use crate::machine::Kinematics;
use crate::types::{AxisVector, Diagnostic, ToolPose};

/// Where moves come from, and with that what the tool does between them.
#[derive(Debug, Clone)]
pub enum PostSource {
    /// Cutter locations: the tip straight, the tool axis on a great circle.
    Locations,
    /// A program for this machine, set up as it assumes: [`PostMove::way`] says what its control does.
    Program(Box<Kinematics>),
}

/// How fast a move is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PostPace {
    /// Rapid.
    Rapid,
    /// No faster than this tip speed \[mm/s\]; where the tip stands, as fast as the axes can.
    Feed(f64),
    /// No quicker than in this time \[s\].
    Seconds(f64),
}

/// One move of the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostMove {
    /// Line of the input, counted from 1.
    pub line: u32,
    /// Where it ends, workpiece frame.
    pub pose: ToolPose,
    /// Axes there, where the input is a program.
    pub q: Option<AxisVector>,
    /// How fast.
    pub pace: PostPace,
    /// What the tool does on the way; cutter locations: [`Control::GreatCircle`].
    pub way: Control,
}

/// How times are found, and which limits of the axes they keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PostMethod {
    /// Velocities and accelerations, along a smooth path that passes the ends of all blocks.
    Optimal,
    /// Jerks as well.
    Jerk,
    /// Velocities and accelerations of straight blocks, speed changing at a constant rate; where two meet the axes
    /// step by what they change in a servo period, which is not kept to the letter of the limit. What a control
    /// without smoothing does: [`look_ahead`](crate::feed::look_ahead).
    Blocks,
    /// None: times are those of the input, and what they ask of the axes is only told.
    Programmed,
}

/// How to post. No `Default`: the caller knows part and machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostOptions {
    /// How the control moves between blocks.
    pub control: Control,
    /// Largest deviation of tip \[mm\] and tool axis \[rad\] from the input, everywhere; rounding the words comes on
    /// top. Also how far the path that is timed rounds corners.
    pub tolerance: [f64; 2],
    /// Tip speed to which feeds may be raised \[mm/s\]; `None`: those of the input stay the most.
    pub max_feed: Option<f64>,
    /// Limits that are kept.
    pub method: PostMethod,
    /// Rows that the planner looks ahead.
    pub window: usize,
    /// What is done to the moves first; it takes part of the tolerance.
    pub filter: PostFilter,
    /// Where a rotary axis comes to the end of its travel inside a cut, and no other way from the start of the cut leads
    /// farther: the tool goes so far out along its axis \[mm\], the rotaries go round, and it comes back. `None`: such
    /// a cut is refused. Controls that choose the rotaries themselves are left to do so.
    pub unwind: Option<f64>,
}

/// Rows that let a machine stop from full speed in fine programs.
pub const POST_WINDOW: usize = 4096;

/// What posting did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PostReport {
    /// Moves read, blocks written.
    pub blocks: [usize; 2],
    /// Way of the tip with feed \[mm\].
    pub length: f64,
    /// Time with feed as programmed; and with the limits of the axes kept \[s\].
    pub seconds: [f64; 2],
    /// Time of rapid moves with the limits of the axes kept \[s\].
    pub rapid_seconds: f64,
    /// Time with feed on the control model, of input and output \[s\].
    pub model_seconds: [f64; 2],
    /// Largest axis velocity and acceleration over their limits, as programmed.
    pub ratios_before: [f64; 2],
    /// The same of the output.
    pub ratios_after: [f64; 2],
    /// Bound on how far tip \[mm\] and tool axis \[rad\] stray from the input, before rounding.
    pub strayed: [f64; 2],
    /// Bound on what rounding the words moves the tip by \[mm\].
    pub rounding: f64,
    /// Where smoothing was chosen, if it was asked for.
    pub smoothing: Option<PostChoice>,
    /// Lines of the input before which the tool went out and back, so that rotaries could go round.
    pub unwound: Vec<u32>,
    /// Every block was read back from the text and found to say what was meant, unless there is something here: the
    /// first words of the program that its reader does not understand, such as those of a shop's own template.
    pub unread: Option<Diagnostic>,
}
