//! Audit of the output: every block read back, the motion that the text has, and the load on axes and control.
//!
//! It follows the writer batch by batch and needs nothing of what is planned next, so that it runs beside the timing of
//! the next batch. Blocks are audited in their order: the result does not depend on the number of threads.

use super::read_moves::ReadItem;
use super::tally::FeedTally;
use crate::machine::Kinematics;
use crate::nc::write::{BlockPace, Coolant, OutputFormat, Style, rounding};
use crate::post::axis_point::{AxesPose, AxisPoint};
use crate::post::conservation::{CountedMove, MotionAccount};
use crate::post::error::{PostError, ReadBackError};
use crate::post::options::{PostFilter, PostOptions};
use crate::post::read_back::ReadBack;
use crate::post::report::{FastRapid, InputOutput, PostReport, SlowedMove};
use crate::post::subdivision::Subdivider;
use crate::post::timing::{TimedPoint, position_error, word_travel};
use crate::types::{AxisVector, ToolPose};

/// Ratio of the times from which a move counts as slowed: rounding is less.
const SLOWER: f64 = 1.001;

/// Most slowed moves that are listed.
const MOST_SLOWED: usize = 1000;

/// Text of some blocks, with the points that they pass.
#[derive(Debug, Default)]
pub(super) struct WrittenBatch {
    pub(super) text: String,
    pub(super) items: Vec<WrittenItem>,
    /// Moves of the input that were read meanwhile.
    pub(super) read: Vec<ReadItem>,
}

/// Point of a batch, or a standstill behind its points.
#[derive(Debug, Clone, Copy)]
pub(super) enum WrittenItem {
    /// Point inside a block.
    Inside(TimedPoint),
    /// Point at which a block ends.
    Block(WrittenBlock),
    /// The axes come to rest.
    Rest,
}

/// Block, and the end of its text in the batch.
#[derive(Debug, Clone, Copy)]
pub(super) struct WrittenBlock {
    pub(super) end: TimedPoint,
    pub(super) pace: BlockPace,
    /// Its time, also where it is a rapid move \[s\].
    pub(super) seconds: f64,
    /// End of its text \[bytes\]; it begins where that of the block before ends.
    pub(super) text_end: usize,
}

impl WrittenBatch {
    /// Forgets the blocks, and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.text.clear();
        self.items.clear();
        self.read.clear();
    }
}

/// Machine and options that the program is written for.
#[derive(Debug, Clone, Copy)]
pub(super) struct AuditContext<'a> {
    pub(super) kinematics: &'a Kinematics,
    pub(super) style: &'a Style,
    pub(super) options: &'a PostOptions,
    pub(super) subdivider: &'a Subdivider,
}

/// Point inside a block.
#[derive(Debug, Clone, Copy)]
struct InsidePoint {
    /// Largest travel of the axes from the point before ([`Subdivider::fastest`]).
    fastest: AxisVector,
    /// Size of its share of the block.
    size: f64,
}

/// Audit of a program, up to the blocks that were handed to it.
#[derive(Debug)]
pub(super) struct OutputAudit {
    /// Reads what the writer writes; `None` before the program begins, and once the text is not understood.
    read_back: Option<Box<ReadBack>>,
    /// Last point; `None` before the program begins.
    at: Option<AxesPose>,
    /// End of the last block.
    block: Option<AxesPose>,
    /// Points since the last block end.
    inside: Vec<InsidePoint>,
    /// Account of the motion that is read and written.
    pub(super) account: MotionAccount,
    /// Times and axis load of the input.
    pub(super) before: FeedTally,
    /// Times and axis load of the output.
    pub(super) after: FeedTally,
    /// Move of the input whose times are being added up.
    comparing: Option<SlowedMove>,
}

impl OutputAudit {
    pub(super) fn new(kinematics: &Kinematics, style: &Style) -> Self {
        Self {
            read_back: None,
            at: None,
            block: None,
            inside: Vec::new(),
            account: MotionAccount::default(),
            before: FeedTally::new(kinematics, style),
            after: FeedTally::new(kinematics, style),
            comparing: None,
        }
    }

    /// Starts with the text up to the starting position of the program.
    pub(super) fn begin(
        &mut self,
        context: &AuditContext<'_>,
        to: AxesPose,
        text: &str,
        report: &mut PostReport,
    ) -> Result<(), PostError> {
        self.account.wrote_start();
        self.start_at(to);
        let read = ReadBack::new(context.kinematics, context.style, text, &to.pose);
        self.read_back = understood(read, report)?.map(Box::new);
        Ok(())
    }

    /// Continues with the text of a tool change, up to the starting position of the next tool.
    pub(super) fn change(
        &mut self,
        context: &AuditContext<'_>,
        to: AxesPose,
        text: &str,
        report: &mut PostReport,
    ) -> Result<(), PostError> {
        self.account.wrote_start();
        self.start_at(to);
        self.after.stop_clock();
        self.read(report, |read| read.change_tool(context.kinematics, text, &to.pose))?;
        Ok(())
    }

    fn start_at(&mut self, to: AxesPose) {
        (self.at, self.block) = (Some(to), Some(to));
        self.inside.clear();
    }

    /// Takes in the text that switches the coolant.
    pub(super) fn coolant(
        &mut self,
        text: &str,
        coolant: Coolant,
        report: &mut PostReport,
    ) -> Result<(), PostError> {
        self.after.stop();
        self.read(report, |read| read.coolant(text, coolant))?;
        Ok(())
    }

    /// Takes in the text behind the last block.
    pub(super) fn end(&mut self, text: &str, report: &mut PostReport) -> Result<(), PostError> {
        if let Some(read) = self.read_back.take() {
            understood(read.end(text), report)?;
        }
        self.note_slowed(report);
        Ok(())
    }

    /// Counts moves of the input, and forgets them.
    pub(super) fn count_read(
        &mut self,
        read: &mut Vec<ReadItem>,
        kinematics: &Kinematics,
        style: &Style,
    ) {
        for item in read.drain(..) {
            item.count(&mut self.before, kinematics, style);
        }
    }

    /// Takes in the blocks of a batch, and the moves that were read meanwhile.
    pub(super) fn take(
        &mut self,
        batch: &mut WrittenBatch,
        context: &AuditContext<'_>,
        report: &mut PostReport,
    ) -> Result<(), PostError> {
        self.count_read(&mut batch.read, context.kinematics, context.style);
        let mut begin = 0;
        for item in &batch.items {
            match item {
                WrittenItem::Rest => self.after.rest(),
                WrittenItem::Inside(timed) => self.pass(timed, context, report),
                WrittenItem::Block(block) => {
                    self.pass(&block.end, context, report);
                    self.count(block, context, report);
                    let text = batch.text.get(begin..block.text_end).unwrap_or_default();
                    begin = block.text_end;
                    self.read_block(block, text, context, report)?;
                    self.block = self.at;
                }
            }
        }
        Ok(())
    }

    /// Moves on to a timed point.
    fn pass(&mut self, one: &TimedPoint, context: &AuditContext<'_>, report: &mut PostReport) {
        let end = one.point.end();
        let from = self.at.replace(end).unwrap_or(end);
        let between = || context.subdivider.fastest([from.block_end(), end.block_end()]);
        let fastest = one.point.fastest.unwrap_or_else(between);
        self.inside.push(InsidePoint { fastest, size: one.point.size() });
        self.compare_time(one, report);
    }

    /// Reads a block back, and enters it in the account.
    fn read_block(
        &mut self,
        block: &WrittenBlock,
        text: &str,
        context: &AuditContext<'_>,
        report: &mut PostReport,
    ) -> Result<(), PostError> {
        let point = &block.end.point;
        let end = point.end();
        // What was written must read back as the same block.
        match self.read(report, |read| read.block(text, &end, block.pace))? {
            Some(ends) => self.account_for(point, ends, context),
            None => Ok(()),
        }
    }

    /// Reads a text back; text that the reader does not understand is noted in the report, and ends the reading.
    fn read<T>(
        &mut self,
        report: &mut PostReport,
        take: impl FnOnce(&mut ReadBack) -> Result<T, ReadBackError>,
    ) -> Result<Option<T>, PostError> {
        let Some(read) = &mut self.read_back else { return Ok(None) };
        let done = understood(take(read), report)?;
        if done.is_none() {
            self.read_back = None;
        }
        Ok(done)
    }

    /// Enters a block, as it was read back, in the account of all motion.
    fn account_for(
        &mut self,
        point: &AxisPoint,
        ends: [ToolPose; 2],
        context: &AuditContext<'_>,
    ) -> Result<(), PostError> {
        let AuditContext { kinematics, style, options, .. } = context;
        let is_rapid = point.least.is_none();
        let filters = options.filter != PostFilter::None;
        // Both ends are rounded; a filter may move them within the tolerance.
        let coordinates = style.dialect.coordinates();
        let off = rounding(kinematics, &point.q, &style.axes, coordinates, 0.0);
        let moved = if filters { options.tolerance.tip } else { 0.0 };
        let rounding = 2.0 * (off + moved);
        let one = CountedMove { line: point.line, is_rapid, ends, rounding };
        if point.is_added || (filters && !is_rapid) {
            self.account.wrote_other(&one);
            return Ok(());
        }
        self.account.wrote(&one)
    }

    /// Adds a block to the times and axis loads of the report.
    fn count(&mut self, block: &WrittenBlock, context: &AuditContext<'_>, report: &mut PostReport) {
        let AuditContext { kinematics, style, .. } = context;
        let TimedPoint { point, .. } = &block.end;
        let (Some(from), Some(to)) = (self.block, self.at) else { return };
        let words = word_travel(kinematics, style.dialect, &from, &to);
        let BlockPace::Timed { seconds, .. } = block.pace else {
            self.count_rapid(point.line, &words, context, report);
            self.inside.clear();
            report.rapid_seconds += block.seconds;
            return self.after.rapid(&words);
        };
        let error = position_error(&style.axes, point.source, point.linear_error);
        self.after.block(&(point.q - from.q), &error, seconds);
        // Points inside a block share its time by their size.
        let whole: f64 = self.inside.iter().map(|point| point.size).sum();
        for InsidePoint { fastest, size } in self.inside.drain(..) {
            self.after.load.inside(&fastest, seconds * size / whole);
        }
        self.after.feed(&words, seconds);
        // Words are rounded in the axes; the report states what that does to the tip.
        let coordinates = style.dialect.coordinates();
        let off = rounding(kinematics, &point.q, &style.axes, coordinates, 0.0);
        report.rounding = report.rounding.max(off);
    }

    /// Compares the axes in a rapid move with their velocities, on a control that limits X, Y and Z of the tip alone.
    ///
    /// `LinuxCNC` plans rapid moves under tool-centre-point control in the words: each at most at its own velocity. The
    /// axes behind X, Y and Z may have to be quicker.
    fn count_rapid(
        &self,
        line: u32,
        words: &AxisVector,
        context: &AuditContext<'_>,
        report: &mut PostReport,
    ) {
        if context.style.dialect != OutputFormat::LinuxCnc {
            return;
        }
        let limits = context.kinematics.machine().vector(|axis| axis.rapid);
        let seconds = words.abs().component_div(&limits).amax();
        let whole: f64 = self.inside.iter().map(|point| point.size).sum();
        let over = |point: &InsidePoint| {
            point.fastest.component_div(&limits).amax() * whole / (point.size * seconds)
        };
        let ratios = self.inside.iter().map(over);
        let ratio = ratios.filter(|ratio| ratio.is_finite()).fold(0.0, f64::max);
        if ratio > 1.0 && report.fastest_rapid.is_none_or(|worst| worst.ratio < ratio) {
            report.fastest_rapid = Some(FastRapid { line, ratio });
        }
    }

    /// Compares the time of a point with the programmed one, move by move.
    fn compare_time(&mut self, one: &TimedPoint, report: &mut PostReport) {
        let TimedPoint { point, seconds } = *one;
        let Some(programmed) = point.programmed else { return };
        match &mut self.comparing {
            Some(sum) if sum.line == point.line => {
                sum.seconds.input += programmed;
                sum.seconds.output += seconds;
            }
            _ => {
                self.note_slowed(report);
                let seconds = InputOutput { input: programmed, output: seconds };
                self.comparing = Some(SlowedMove { line: point.line, seconds });
            }
        }
    }

    /// Notes the move that was compared last, if it is slower than programmed.
    fn note_slowed(&mut self, report: &mut PostReport) {
        let slowed = self.comparing.take().filter(|sum| sum.ratio() > SLOWER);
        let Some(slowed) = slowed else { return };
        report.slowed_moves += 1;
        if report.slowed.len() < MOST_SLOWED {
            report.slowed.push(slowed);
        }
        if report.slowest.is_none_or(|worst| worst.ratio() < slowed.ratio()) {
            report.slowest = Some(slowed);
        }
    }
}

/// Returns the result of reading back; a text that the reader does not understand is noted in the report.
fn understood<T>(
    read: Result<T, ReadBackError>,
    report: &mut PostReport,
) -> Result<Option<T>, PostError> {
    match read {
        Ok(read) => Ok(Some(read)),
        Err(ReadBackError::Unread(faults)) => {
            report.unread = faults.into_iter().next();
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}
