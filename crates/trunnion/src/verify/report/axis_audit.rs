//! Axes against their limits.

use crate::machine::AxisKind;
use crate::types::{AXES, Interval};
use crate::verify::fast_block::FastBlock;
use std::fmt;

/// Motion of a program. Travel is of the tool tip from end to end of the moves, of arcs by their chords; moves from a
/// place that the program does not state have none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct AuditedMotion {
    /// Rapid moves.
    pub rapids: usize,
    /// Moves with feed, and dwells.
    pub cuts: usize,
    /// Travel of the rapid moves \[mm\].
    pub rapid_length: f64,
    /// Travel of the moves with feed \[mm\].
    pub cut_length: f64,
}

/// Axes against their limits.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Audit {
    /// In the order of the machine's axes.
    pub axes: [AxisAudit; AXES],
    /// Time of all blocks \[s\]; rapids at rapid speed, without acceleration.
    pub duration: f64,
    /// Part of it that is rapid.
    pub rapid: f64,
    /// Number of moves.
    pub moves: usize,
    /// Rapid moves and moves with feed among them.
    pub motion: AuditedMotion,
    /// Time of all blocks when each lasts as long as the fastest of its axes needs \[s\]: a control cannot be
    /// faster.
    pub held: f64,
    /// The same on a control that does not look ahead where rotaries move.
    pub linuxcnc: ModelAudit,
    /// Feed moves shorter than the servo period; `None` if there are none, or the machine does not name it.
    pub brief: Option<ShortBlocks>,
    /// Feed moves that come within the machine's singular cone; `None` if there are none.
    pub singular: Option<SingularPassages>,
    /// Cuts after which the tool stays where it is; `None` if there are none.
    pub unended: Option<UnendedCut>,
    /// Feed blocks that are far slower than both of their neighbours; `None` if there are none.
    pub slow: Option<SlowBlocks>,
    /// Feed blocks that are far faster than both of their neighbours: the fastest, in the order of lines.
    pub fast: Vec<FastBlock>,
}

/// Cuts after which the program ends, or changes the tool, without leading the tool off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct UnendedCut {
    /// Number of them: one for each tool at most.
    pub count: usize,
    /// Line of the first.
    pub line: u32,
}

impl fmt::Display for UnendedCut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, line } = self;
        let help = "write a rapid move or a retract along the tool axis after it";
        match count {
            1 => {
                write!(f, "line {line}: nothing leads the tool off the part after this cut; {help}")
            }
            _ => write!(
                f,
                "line {line}: nothing leads the tool off the part after this cut, and after {} more; {help}",
                count - 1
            ),
        }
    }
}

/// Feed blocks that are slower by far than the blocks beside them, such as one with a wrong F word.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SlowBlocks {
    /// Number of them.
    pub count: usize,
    /// Line of the slowest.
    pub line: u32,
    /// Speed beside it over its own.
    pub ratio: f64,
    /// Time that all of them cost \[s\].
    pub lost: f64,
}

/// Blocks shorter than the servo period: a control joins them, slows down or skips some.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ShortBlocks {
    /// Number of blocks.
    pub count: usize,
    /// Line of the shortest.
    pub line: u32,
    /// Its time \[s\].
    pub shortest: f64,
    /// The servo period \[s\].
    pub period: f64,
}

/// Passages of the singular cone: the tool axis is nearly along the rotary axis next to the workpiece, and small changes
/// of direction need large turns.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SingularPassages {
    /// Number of times that the program enters the cone.
    pub passages: usize,
    /// Line that comes nearest to the singular direction.
    pub line: u32,
    /// Least angle from the singular direction \[rad\].
    pub angle: f64,
    /// Largest turn of a rotary axis in one of these blocks \[rad\].
    pub turn: f64,
}

impl fmt::Display for SlowBlocks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, line, ratio, lost } = self;
        let (blocks, cost) =
            if *count == 1 { ("block is", "costs") } else { ("blocks are", "cost") };
        write!(
            f,
            "line {line}: {count} {blocks} slower by far than those beside, this one {ratio:.0} times, and {cost} \
             {lost:.2} s; is F as intended?"
        )
    }
}

/// Range and rates of one axis, against its limits.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct AxisAudit {
    /// Name of the axis.
    pub name: String,
    /// Smallest and largest position \[mm or rad\].
    pub range: Interval,
    /// Position farthest outside the travel, if any is.
    pub travel: Option<TravelOverrun>,
    /// Largest velocity in a feed move, against the limit.
    pub velocity: LimitRatio,
    /// Largest acceleration between feed moves, against the limit.
    pub acceleration: LimitRatio,
    /// Largest jerk over three feed moves, against the limit, if the control keeps the times of the blocks and
    /// stands still without acceleration. It is reported, not judged: not every control limits it.
    pub jerk: LimitRatio,
}

/// A position outside the travel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TravelOverrun {
    /// Line of the program.
    pub line: u32,
    /// Of a linear or a rotary axis.
    pub kind: AxisKind,
    /// Position \[mm or rad\].
    pub value: f64,
    /// Distance beyond the end of travel \[mm or rad\].
    pub excess: f64,
}

/// A rate against its limit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LimitRatio {
    /// Largest rate over limit, by the words as written.
    pub raw: f64,
    /// Largest rate over limit less the part that the rounding of the words can have added: this one is judged.
    pub worst: f64,
    /// Line where `worst` was found; 0 if nothing moves.
    pub line: u32,
    /// Count of blocks above the limit.
    pub broken: usize,
}

impl fmt::Display for LimitRatio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "is {:.4} times its limit at line {}, above it in {} blocks",
            self.worst, self.line, self.broken
        )
    }
}

/// Audit of a program on a model of `LinuxCNC` 2.9.
///
/// The time is that of [`BlendClock`](crate::nc::control::BlendClock), rapids included. For the loads a block of length L in
/// which a rotary moves counts as passed at `sqrt(a L / 2)` at most, whatever comes next, `a` being the acceleration that
/// the axes named in the block allow along it. The control limits the words. With tool-centre-point control those are the
/// tip's, so linear axes may be driven beyond their limits.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ModelAudit {
    /// Time of all blocks \[s\].
    pub seconds: f64,
    /// Largest velocity in a feed move.
    pub velocity: AxisRatio,
    /// Largest acceleration between feed moves in which rotaries move, or from and to rest, as the divided difference of
    /// mean velocities.
    pub acceleration: AxisRatio,
    /// Largest jerk, as the divided difference of three mean velocities of such moves, from and to rest without
    /// acceleration. `LinuxCNC` 2.9 does not limit jerk: the machine has to bear it.
    pub jerk: AxisRatio,
}

/// Rate of the axis that is nearest to its limit, or farthest beyond.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct AxisRatio {
    /// Name of the axis.
    pub axis: String,
    /// Its rate against the limit.
    pub ratio: LimitRatio,
}
