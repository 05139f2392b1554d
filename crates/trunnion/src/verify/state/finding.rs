//! Findings about the state of the control.

use crate::nc::read::{LengthEntry, Smoothing};
use crate::verify::fast_block::FastBlock;
use std::fmt;

/// State of the control over a whole program.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct StateReport {
    /// Loosest smoothing during a cut, with the line that asks for it; `None`: no word of the program is about it.
    pub smoothing: Option<ActiveSmoothing>,
    /// All feed moves.
    pub cuts: Option<AffectedCuts>,
    /// States in which no cut is right; the first cut of each kind.
    pub findings: Vec<StateFinding>,
}

/// Smoothing, and the line that asks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ActiveSmoothing {
    /// Line of the program.
    pub line: u32,
    /// Distance from the path that the control may keep.
    pub smoothing: Smoothing,
}

/// Need of coolant during cuts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CoolantDemand {
    /// Nothing is known: any program is right.
    #[default]
    Unknown,
    /// The job asks for it.
    Needed,
}

/// Tools and feed that a job plans its cuts with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedCuts<'a> {
    /// Numbers of the tools.
    pub tools: &'a [u32],
    /// Feed \[mm/s\].
    pub feed: f64,
}

/// A state of the control in which no cut is right.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum StateFinding {
    /// Cuts with a spindle that stands still.
    SpindleStopped(AffectedCuts),
    /// Cuts with a spindle that turns counterclockwise.
    SpindleReversed(AffectedCuts),
    /// Cuts without tool length compensation.
    NoLength(AffectedCuts),
    /// Cuts with the length of another tool, or of another edge.
    WrongLength {
        /// The cuts.
        cuts: AffectedCuts,
        /// Number of the tool in the spindle.
        tool: u32,
        /// Entry of the table that counts.
        entry: LengthEntry,
    },
    /// Cuts, of which none runs with a tool that the job plans.
    NoTool {
        /// All cuts.
        cuts: AffectedCuts,
        /// Number of the tool that is never called.
        tool: u32,
    },
    /// Cuts that take far longer than at the feed of the job, although the axes could follow.
    SlowCuts {
        /// The cuts.
        cuts: AffectedCuts,
        /// Time by the program over the time at the planned feed.
        ratio: f64,
    },
    /// Cuts far faster than the feed of the job, each between far slower ones.
    FastCuts {
        /// The fastest of them.
        fastest: FastBlock,
        /// Number of them.
        count: usize,
        /// Feed of the job \[mm/s\].
        feed: f64,
    },
    /// Cuts without coolant, where the job asks for it.
    NoCoolant(AffectedCuts),
    /// Smoothing without a bound.
    UnboundedSmoothing {
        /// Line that asks for it.
        line: u32,
        /// Tolerance of the part \[mm\].
        tolerance: f64,
    },
    /// Smoothing that is looser than the tolerance of the part.
    Smoothing {
        /// Line that asks for it.
        line: u32,
        /// Distance from the path that the control may keep \[mm\].
        smoothing: f64,
        /// Tolerance of the part \[mm\].
        tolerance: f64,
    },
}

/// Feed moves in a wrong state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct AffectedCuts {
    /// Line of the first.
    pub line: u32,
    /// Number of them.
    pub count: usize,
}

impl fmt::Display for AffectedCuts {
    /// Writes the number of moves with a verb, so that a sentence can go on: "3 feed moves run".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count {
            1 => f.write_str("a feed move runs"),
            count => write!(f, "{count} feed moves run"),
        }
    }
}

impl fmt::Display for StateFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SpindleStopped(cuts) => write!(
                f,
                "line {}: {cuts} while the spindle stands still; start it with S and M3 after the tool change",
                cuts.line
            ),
            Self::SpindleReversed(cuts) => write!(
                f,
                "line {}: {cuts} while the spindle turns counterclockwise (M4); a right-hand tool needs M3",
                cuts.line
            ),
            Self::NoLength(cuts) => write!(
                f,
                "line {}: {cuts} without tool length compensation, so that X Y Z are those of the gauge point; switch it \
                 on, or give the tool the length 0 if the work offset contains it",
                cuts.line
            ),
            Self::WrongLength { cuts, tool, entry: LengthEntry::Row(row) } => write!(
                f,
                "line {}: {cuts} with tool {tool} and the length of H{row}; choose the row of the tool in the spindle",
                cuts.line
            ),
            Self::WrongLength { cuts, tool, entry: LengthEntry::Edge(edge) } => write!(
                f,
                "line {}: {cuts} with tool {tool} and the length of its edge D{edge}; only that of D1 is known here",
                cuts.line
            ),
            Self::NoTool { cuts, tool } => write!(
                f,
                "line {}: {cuts}, none with tool {tool}, which the job cuts with; its call is missing",
                cuts.line
            ),
            Self::SlowCuts { cuts, ratio } => write!(
                f,
                "line {}: {cuts} {ratio:.0} times as long as at the feed of the job; look at the unit and the mode of F",
                cuts.line
            ),
            Self::FastCuts { fastest: FastBlock { line, speed, beside }, count, feed } => {
                let [speed, beside, feed] = [speed, beside, feed].map(|speed| speed * 60.0);
                let more = match count {
                    1 => String::new(),
                    _ => format!("; {} more are like it", count - 1),
                };
                write!(
                    f,
                    "line {line}: this cut runs at {speed:.0} mm/min between cuts at {beside:.0} mm/min or less, and the feed of the \
                     job is {feed:.0} mm/min; look at F{more}"
                )
            }
            Self::NoCoolant(cuts) => write!(
                f,
                "line {}: {cuts} without the coolant that the job asks for; write M8 after the tool change",
                cuts.line
            ),
            Self::UnboundedSmoothing { line, tolerance } => write!(
                f,
                "line {line}: the control may smooth the path by any distance, with a tolerance of {tolerance} mm; write \
                 the distance (G64 P)"
            ),
            Self::Smoothing { line, smoothing, tolerance } => write!(
                f,
                "line {line}: the control may smooth the path by {smoothing} mm, more than the tolerance of {tolerance} mm"
            ),
        }
    }
}
