//! Motion of the input and of the written text, counted apart and compared line by line.

use super::error::PostError;
use super::options::{PostMove, PostPace};
use crate::math::angle::angle_between;
use crate::types::ToolPose;
use std::collections::VecDeque;

/// Length that rounding may add to or take from a move that is not divided \[mm\].
const LEAST: f64 = 1e-5;

/// The same of the turn of the tool axis \[rad\].
const LEAST_TURN: f64 = 1e-5;

/// Motion that was counted in an input, or in the text of an output.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct MotionCount {
    /// Rapid moves.
    pub rapids: usize,
    /// Moves with feed.
    pub cuts: usize,
    /// Travel of the tip from end to end of the rapid moves \[mm\].
    pub rapid_length: f64,
    /// The same of the moves with feed \[mm\].
    pub cut_length: f64,
    /// Tools.
    pub tools: usize,
}

impl MotionCount {
    fn add(&mut self, one: &CountedMove) {
        let (moves, length) = if one.is_rapid {
            (&mut self.rapids, &mut self.rapid_length)
        } else {
            (&mut self.cuts, &mut self.cut_length)
        };
        *moves += 1;
        *length += one.length();
    }
}

/// Move as it was read, or as it was written and read back.
#[derive(Debug, Clone, Copy)]
pub(super) struct CountedMove {
    pub(super) line: u32,
    pub(super) is_rapid: bool,
    /// Tool at both ends.
    pub(super) ends: [ToolPose; 2],
    /// Length that rounding may add or take \[mm\].
    pub(super) rounding: f64,
}

impl CountedMove {
    fn length(&self) -> f64 {
        (self.ends[1].tip - self.ends[0].tip).norm()
    }

    fn turn(&self) -> f64 {
        angle_between(&self.ends[0].axis, &self.ends[1].axis)
    }
}

/// Motion of one line of the input that is not yet written in full.
#[derive(Debug, Clone, Copy)]
struct LineMotion {
    line: u32,
    is_rapid: bool,
    /// Travel of the tip and turn of the tool axis as read, and as written \[mm, rad\].
    read: [f64; 2],
    written: [f64; 2],
    /// Travel and turn that rounding may add or take \[mm, rad\].
    rounding: [f64; 2],
}

/// Account of all motion: what is read must be written, and nothing else.
#[derive(Debug, Default)]
pub(super) struct MotionAccount {
    pub(super) input: MotionCount,
    pub(super) output: MotionCount,
    open: VecDeque<LineMotion>,
    /// Place of the input.
    at: Option<ToolPose>,
}

impl MotionAccount {
    /// Starts with a tool; its first move only states a position.
    pub(super) fn start_tool(&mut self) {
        self.at = None;
    }

    /// Counts a move of the input whose line need not be found in the output, because a filter replaces it.
    pub(super) fn read_other(&mut self, one: &PostMove) -> Option<CountedMove> {
        let Some(from) = self.at.replace(one.pose) else {
            self.input.tools += 1;
            return None;
        };
        let (line, is_rapid) = (one.line, one.pace == PostPace::Rapid);
        let counted = CountedMove { line, is_rapid, ends: [from, one.pose], rounding: 0.0 };
        self.input.add(&counted);
        Some(counted)
    }

    /// Counts a move of the input whose line is to be found in the output.
    pub(super) fn read(&mut self, one: &PostMove) {
        if let Some(counted) = self.read_other(one) {
            self.expect(&counted);
        }
    }

    fn expect(&mut self, one: &CountedMove) {
        let by = [one.length(), one.turn()];
        let same = |last: &&mut LineMotion| last.line == one.line && last.is_rapid == one.is_rapid;
        if let Some(last) = self.open.back_mut().filter(same) {
            last.read = [0, 1].map(|k: usize| last.read[k] + by[k]);
            return;
        }
        self.open.push_back(LineMotion {
            line: one.line,
            is_rapid: one.is_rapid,
            read: by,
            written: [0.0; 2],
            rounding: [LEAST, LEAST_TURN],
        });
    }

    /// Counts the start of a tool in the output.
    pub(super) fn wrote_start(&mut self) {
        self.output.tools += 1;
    }

    /// Counts a move of the output that has no counterpart in the input, or stands for several.
    pub(super) fn wrote_other(&mut self, one: &CountedMove) {
        self.output.add(one);
    }

    /// Counts a move of the output, and settles the lines before its own.
    ///
    /// # Errors
    ///
    /// [`PostError::NotConserved`] for a line that is not written in full, and for motion without a line.
    pub(super) fn wrote(&mut self, one: &CountedMove) -> Result<(), PostError> {
        self.wrote_other(one);
        let is_own = |open: &LineMotion| open.line == one.line && open.is_rapid == one.is_rapid;
        while let Some(front) = self.open.front().filter(|front| !is_own(front)) {
            front.settle()?;
            self.open.pop_front();
        }
        let Some(own) = self.open.front_mut() else {
            let lengths = [0.0, one.length()];
            return Err(PostError::NotConserved { line: one.line, lengths });
        };
        own.written = [own.written[0] + one.length(), own.written[1] + one.turn()];
        own.rounding = [own.rounding[0] + one.rounding, own.rounding[1] + LEAST_TURN];
        Ok(())
    }

    /// Settles all lines.
    ///
    /// # Errors
    ///
    /// As [`MotionAccount::wrote`].
    pub(super) fn settle(&mut self) -> Result<(), PostError> {
        self.open.drain(..).try_for_each(|open| open.settle())
    }
}

impl LineMotion {
    /// Checks that the line was written in full: a way that bows is longer than its chord, but none is shorter.
    fn settle(&self) -> Result<(), PostError> {
        let lost = (0..2).any(|k| self.written[k] < self.read[k] - self.rounding[k]);
        if lost {
            let lengths = [self.read[0], self.written[0]];
            return Err(PostError::NotConserved { line: self.line, lengths });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::BlockInterpolation;

    fn at(x: f64) -> ToolPose {
        ToolPose::new([x, 0.0, 0.0], [0.0, 0.0, 1.0]).unwrap()
    }

    fn read(account: &mut MotionAccount, line: u32, x: f64) {
        let pace = if line < 3 { PostPace::Rapid } else { PostPace::Feed(10.0) };
        let way = BlockInterpolation::GreatCircle;
        account.read(&PostMove { line, pose: at(x), q: None, pace, way });
    }

    fn wrote(account: &mut MotionAccount, line: u32, ends: [f64; 2]) -> Result<(), PostError> {
        let ends = ends.map(at);
        account.wrote(&CountedMove { line, is_rapid: line < 3, ends, rounding: 1e-4 })
    }

    fn lost(result: Result<(), PostError>) -> u32 {
        match result {
            Err(PostError::NotConserved { line, .. }) => line,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_line_that_is_written_in_parts_is_conserved() {
        let mut account = MotionAccount::default();
        for (line, x) in [(1, 0.0), (2, 5.0), (3, 9.0), (4, 2.0)] {
            read(&mut account, line, x);
        }
        for (line, ends) in [(2, [0.0, 5.0]), (3, [5.0, 7.0]), (3, [7.0, 9.0]), (4, [9.0, 2.0])] {
            wrote(&mut account, line, ends).unwrap();
        }
        account.settle().unwrap();
        let [read, written] = [account.input, account.output];
        assert_eq!([read.rapids, read.cuts, written.rapids, written.cuts], [1, 2, 1, 3]);
        assert!((read.rapid_length - written.rapid_length).abs() < 1e-12);
        assert!((read.cut_length - written.cut_length).abs() < 1e-12);
    }

    #[test]
    fn a_line_that_is_lost_cut_short_or_invented_is_named() {
        let start = || {
            let mut account = MotionAccount::default();
            for (line, x) in [(1, 0.0), (2, 5.0), (3, 9.0), (4, 2.0)] {
                read(&mut account, line, x);
            }
            wrote(&mut account, 2, [0.0, 5.0]).unwrap();
            account
        };
        let mut account = start();
        assert_eq!(lost(wrote(&mut account, 4, [5.0, 2.0])), 3);
        let mut account = start();
        wrote(&mut account, 3, [5.0, 8.0]).unwrap();
        assert_eq!(lost(account.settle()), 3);
        let mut account = start();
        assert_eq!(lost(wrote(&mut account, 7, [5.0, 9.0])), 3);
        let mut account = start();
        wrote(&mut account, 3, [5.0, 9.0]).unwrap();
        wrote(&mut account, 4, [9.0, 2.0]).unwrap();
        account.settle().unwrap();
        assert_eq!(lost(wrote(&mut account, 5, [2.0, 3.0])), 5);
    }
}
