//! Program that is being written: its timer, its writer, and the blocks that are not audited yet.

use super::audit::{WrittenBatch, WrittenBlock, WrittenItem};
use crate::nc::write::{BlockPace, ProgramWriter, WrittenPosition};
use crate::post::axis_point::AxisPoint;
use crate::post::error::PostError;
use crate::post::rounded_words::RoundedWords;
use crate::post::timing::{PointTimer, TimedPoint};
use crate::types::AxisVector;

/// Program that is being written; it exists from the first move on.
#[derive(Debug)]
pub(super) struct ProgramOutput {
    timer: PointTimer,
    pub(super) writer: ProgramWriter,
    pub(super) words: RoundedWords,
    /// Points that the timer has not seen.
    pub(super) queue: Vec<AxisPoint>,
    timed: Vec<TimedPoint>,
    /// Time \[s\], travel of the tip \[mm\] and of the rotaries \[rad\] since the last block end, as written.
    waiting: [f64; 3],
    /// Last point, whether its time is known or not.
    pub(super) last: AxisVector,
    /// Blocks that are not audited yet.
    pub(super) written: WrittenBatch,
}

/// Reason for which blocks are written.
pub(super) enum WriteStep {
    /// Enough points wait.
    Batch,
    /// The axes come to rest; the next timer goes on from there.
    Rest(Box<PointTimer>),
}

impl ProgramOutput {
    /// Starts a program whose axes rest at `at`.
    pub(super) fn new(
        timer: PointTimer,
        writer: ProgramWriter,
        words: RoundedWords,
        at: AxisVector,
    ) -> Self {
        Self {
            timer,
            writer,
            words,
            queue: Vec::new(),
            timed: Vec::new(),
            waiting: [0.0; 3],
            last: at,
            written: WrittenBatch::default(),
        }
    }

    /// Goes on with another tool, whose axes rest at `at`.
    pub(super) fn start_tool(&mut self, timer: PointTimer, words: RoundedWords, at: AxisVector) {
        (self.timer, self.words, self.last) = (timer, words, at);
        self.waiting = [0.0; 3];
    }

    /// Times the queued points, and writes the blocks whose time is known; at rest all of them.
    pub(super) fn write(&mut self, out: &mut String, step: WriteStep) -> Result<(), PostError> {
        for point in self.queue.drain(..) {
            self.timer.push(&point, &mut self.timed)?;
        }
        match step {
            WriteStep::Batch => self.write_timed(out),
            WriteStep::Rest(next) => {
                std::mem::replace(&mut self.timer, *next).finish(&mut self.timed)?;
                self.write_timed(out)?;
                self.written.items.push(WrittenItem::Rest);
                Ok(())
            }
        }
    }

    /// Writes the blocks whose time is known.
    fn write_timed(&mut self, out: &mut String) -> Result<(), PostError> {
        for one in self.timed.drain(..) {
            let point = &one.point;
            let passed = [one.seconds, point.written[0], point.written[1]];
            self.waiting.iter_mut().zip(passed).for_each(|(sum, by)| *sum += by);
            if !point.block {
                self.written.items.push(WrittenItem::Inside(one));
                continue;
            }
            let [seconds, length, turn] = std::mem::take(&mut self.waiting);
            let pace = match point.least {
                None => BlockPace::Rapid,
                Some(_) => BlockPace::Timed { seconds, length, turn },
            };
            let begin = out.len();
            if point.goes_out {
                self.writer.comment(out, "out of the cut, rotaries go round, and back");
            }
            let end = point.end();
            self.writer.block(out, WrittenPosition { q: &end.q, pose: &end.pose }, pace)?;
            self.written.text.push_str(out.get(begin..).unwrap_or_default());
            let text_end = self.written.text.len();
            let block = WrittenBlock { end: one, pace, seconds, text_end };
            self.written.items.push(WrittenItem::Block(block));
        }
        Ok(())
    }
}
