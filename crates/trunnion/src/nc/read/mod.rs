//! Programs and CL files from text: every word with its place, all faults at once.
//!
//! [`gcode`] reads five-axis G-code, [`cl`] APT/CL files. What is not understood is a [`Fault`],
//! never skipped motion. Kinematics is not applied here, only units, signs and modal state.
//!
//! [`Fault`]: crate::types::Fault

mod cl;
mod gcode;
mod lexer;
mod modal;

pub use super::words::{AxisWord, AxisWords};
pub use cl::{
    ClArc, ClFile, ClHole, ClItem, ClMotion, ClReader, ClRecord, ClRecords, ClTally, ClWay, cl,
    cl_records,
};
pub use gcode::gcode;

use crate::types::AXES;
use crate::types::AxisVector;

/// How a G-code program is to be understood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadOptions {
    /// Letters, units and signs of the axes. The decimals are not used: the text shows them.
    pub axes: AxisWords,
    /// Faults after which reading stops.
    pub most_faults: usize,
}

/// What the control is told to do, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// Moves and dwells in order.
    pub steps: Vec<Step>,
    /// Largest rounding error of each axis word \[mm, rad\]: half of the last digit that the text
    /// uses anywhere on that axis.
    pub rounding: AxisVector,
    /// Half of the last digit of the feed words, in their own unit (mm/min or 1/min).
    pub feed_rounding: f64,
    /// Numbers of the tools called, in order.
    pub tools: Vec<u32>,
}

/// One thing a program does that takes time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// A block with axis words.
    Move(Move),
    /// `G4`.
    Dwell {
        /// Line, counted from 1.
        line: u32,
        /// How long \[s\].
        seconds: f64,
    },
}

/// One block with axis words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Line, counted from 1.
    pub line: u32,
    /// What the block says about each axis \[mm, rad\]; `None`: nothing.
    pub words: [Option<f64>; AXES],
    /// The words are distances from where the axes stand (`G91`).
    pub incremental: bool,
    /// What the words refer to.
    pub frame: Frame,
    /// How fast.
    pub pace: Pace,
}

/// What axis words refer to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// `G53`: axis positions.
    Machine,
    /// A work offset.
    Work {
        /// 0 for `G54`, 1 for `G55` and so on.
        offset: u8,
        /// `G43`: the tool length counts.
        length: bool,
        /// Tool-centre-point control: X Y Z are the tip.
        tcp: bool,
    },
}

/// How fast a block is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// `G0`.
    Rapid,
    /// `G93 G1 F`: the block takes this long \[s\].
    Inverse {
        /// Time of the block \[s\].
        seconds: f64,
    },
    /// `G94 G1 F`: speed \[mm/s\] of X Y Z; of the rotaries \[deg/s\] if X Y Z stand still.
    PerMinute {
        /// mm/s, or deg/s.
        speed: f64,
    },
}
