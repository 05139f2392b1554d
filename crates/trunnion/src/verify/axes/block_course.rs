//! Course of the blocks: how the last cut is left, and blocks that are far slower or faster than their neighbours.

use crate::types::ToolPose;
use crate::verify::fast_block::FastBlock;
use crate::verify::line_stats::LineStatistics;
use crate::verify::replay::segment::Segment;
use crate::verify::report::{SlowBlocks, UnendedCut};

/// Block that ran last.
#[derive(Debug, Clone, Copy)]
struct LastBlock {
    line: u32,
    tool: usize,
    /// It cut: a move with feed that does not lead the tool off along its axis.
    cuts: bool,
}

/// Feed block whose speed is compared with those of its neighbours.
#[derive(Debug, Clone, Copy)]
struct PacedBlock {
    line: u32,
    /// Travel of the tip \[mm\].
    length: f64,
    /// Part of it square to the tool axis \[mm\].
    aside: f64,
    /// Time \[s\].
    duration: f64,
}

impl PacedBlock {
    /// Returns the mean speed of the tip \[mm/s\].
    fn speed(&self) -> f64 {
        self.length / self.duration
    }
}

/// Follows the moves of a program, block by block.
#[derive(Debug)]
pub(crate) struct BlockCourse {
    last: Option<LastBlock>,
    current: Option<PacedBlock>,
    /// The last two feed blocks of an unbroken sequence.
    before: [Option<PacedBlock>; 2],
    pub(crate) unended: Option<UnendedCut>,
    pub(crate) slow: Option<SlowBlocks>,
    fast: LineStatistics<FastBlock>,
}

impl Default for BlockCourse {
    fn default() -> Self {
        Self {
            last: None,
            current: None,
            before: [None; 2],
            unended: None,
            slow: None,
            fast: LineStatistics::new(MOST_FAST),
        }
    }
}

impl BlockCourse {
    /// Takes in a move and the tool at both ends of it, where they are known.
    pub(crate) fn take(&mut self, segment: &Segment, ends: Option<[ToolPose; 2]>) {
        if self.last.is_some_and(|last| last.tool != segment.tool) {
            self.end_tool();
        }
        let leads_off = ends.is_none_or(|[from, to]| (to.tip - from.tip).dot(&from.axis) > LEAD);
        let cuts = !segment.rapid && !leads_off;
        self.last = Some(LastBlock { line: segment.line, tool: segment.tool, cuts });
        match ends.filter(|_| !segment.rapid) {
            Some(ends) => self.pace(segment, &ends),
            None => self.before = [None; 2],
        }
    }

    /// Notes a cut that nothing leads off from, where the program ends or another tool follows.
    pub(crate) fn end_tool(&mut self) {
        self.before = [None; 2];
        let Some(last) = self.last.take().filter(|last| last.cuts) else { return };
        self.unended.get_or_insert(UnendedCut { count: 0, line: last.line }).count += 1;
    }

    /// Adds a move to its block, and compares the blocks where one is complete.
    fn pace(&mut self, segment: &Segment, [from, to]: &[ToolPose; 2]) {
        let (line, duration) = (segment.line, segment.block.duration);
        if segment.block.begins {
            self.current = Some(PacedBlock { line, length: 0.0, aside: 0.0, duration });
        }
        let Some(block) = &mut self.current else { return };
        let way = to.tip - from.tip;
        block.length += way.norm();
        block.aside += (way - from.axis.scale(way.dot(&from.axis))).norm();
        if !segment.block.ends {
            return;
        }
        let next = self.current.take().filter(|block| block.duration > 0.0);
        if let ([Some(one), Some(middle)], Some(next)) = (self.before, next) {
            self.note_slow(&middle, one.speed().min(next.speed()));
            self.note_fast(&middle, one.speed().max(next.speed()));
        }
        self.before = [self.before[1], next];
    }

    /// Notes a block that is slower than the slower one of its neighbours by far, and costs time.
    fn note_slow(&mut self, block: &PacedBlock, beside: f64) {
        let ratio = beside / block.speed();
        let lost = block.duration - block.length / beside;
        // A turn in place has no speed of the tip.
        if block.length < SHORT || ratio < SLOWER || lost < LOST {
            return;
        }
        let slow =
            self.slow.get_or_insert(SlowBlocks { count: 0, line: block.line, ratio, lost: 0.0 });
        slow.count += 1;
        slow.lost += lost;
        if slow.ratio < ratio {
            (slow.line, slow.ratio) = (block.line, ratio);
        }
    }

    /// Notes a block that is faster than the faster one of its neighbours by far. Along its axis a tool plunges or leads off:
    /// that may be fast, also where its side slides along a wall that is finished.
    fn note_fast(&mut self, block: &PacedBlock, beside: f64) {
        let speed = block.aside / block.duration;
        if block.aside >= SHORT && speed >= FASTER * beside {
            self.fast.note(block.line, speed, FastBlock { line: block.line, speed, beside });
        }
    }

    /// Returns the fastest blocks between far slower ones, in the order of lines.
    pub(crate) fn finish_fast(&mut self) -> Vec<FastBlock> {
        std::mem::replace(&mut self.fast, LineStatistics::new(MOST_FAST)).finish().0
    }
}

/// Travel along the tool axis that leads a tool off the part \[mm\].
const LEAD: f64 = 0.1;

/// Blocks shorter than this are not compared \[mm\].
const SHORT: f64 = 0.02;

/// Ratio of speeds from which a block is called slow. Planned feeds change by less than 10 from block to block, also
/// next to a stop.
const SLOWER: f64 = 25.0;

/// Ratio of speeds from which a block is faster than both of its neighbours by far: a tool that speeds up and slows down
/// within its limits takes several blocks for it.
const FASTER: f64 = 3.0;

/// Most fast blocks that are kept.
const MOST_FAST: usize = 200;

/// Time that a block has to cost to be called slow \[s\].
const LOST: f64 = 0.1;
