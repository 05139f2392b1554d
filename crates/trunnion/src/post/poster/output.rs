//! Output of the poster: times the axis points, writes blocks, and reads every block back.

use super::{InsidePoint, Poster, ProgramOutput};
use crate::nc::write::{
    BlockPace, Coolant, OutputFormat, ProgramForm, ProgramWriter, WrittenPosition, rounding,
};
use crate::post::axis_point::{AxesPose, AxisPoint};
use crate::post::conservation::CountedMove;
use crate::post::error::{PostError, ReadBackError};
use crate::post::options::{PostFilter, PostMethod, ProgramHead};
use crate::post::read_back::ReadBack;
use crate::post::report::{FastRapid, InputOutput, SlowedMove};
use crate::post::rounded_words::RoundedWords;
use crate::post::subdivision::Subdivider;
use crate::post::timing::{PointTimer, TimedPoint, position_error, word_travel};
use crate::types::ToolPose;

/// Number of points that are timed before the finished blocks are written.
const BATCH: usize = 1024;

/// Ratio of the times from which a move counts as slowed: rounding is less.
const SLOWER: f64 = 1.001;

/// Most slowed moves that are listed.
const MOST_SLOWED: usize = 1000;

impl Poster {
    /// Writes the head of the program, up to its starting position.
    pub(super) fn begin(
        &mut self,
        out: &mut String,
        to: AxesPose,
        head: ProgramHead<'_>,
    ) -> Result<(), PostError> {
        self.sampled = Some(to.q);
        if self.output.is_some() {
            return self.change(out, to, head);
        }
        self.account.wrote_start();
        let begin = out.len();
        let style = &self.style;
        let form = ProgramForm { note: head.note, style, template: head.template };
        let start = WrittenPosition { q: &to.q, pose: &to.pose };
        // The head depends on where the program starts, so it is written with the first position.
        let writer = ProgramWriter::new(out, &self.kinematics, form, start)?;
        let timer = PointTimer::new(&self.kinematics, &self.style.axes, &self.options, to.q)?;
        let text = out.get(begin..).unwrap_or_default();
        let read = ReadBack::new(&self.kinematics, style, text, &to.pose);
        let read_back = self.understood(read)?.map(Box::new);
        self.output = Some(Box::new(ProgramOutput {
            timer,
            writer,
            read_back,
            at: to,
            block: to,
            waiting: [0.0; 3],
            inside: Vec::new(),
            words: RoundedWords::new(&self.kinematics, &self.style, &to),
        }));
        Ok(())
    }

    /// Writes the change to another tool, up to its starting position.
    fn change(
        &mut self,
        out: &mut String,
        to: AxesPose,
        head: ProgramHead<'_>,
    ) -> Result<(), PostError> {
        let Some(mut output) = self.output.take() else { return Ok(()) };
        self.account.wrote_start();
        self.before.clock.stop();
        self.after.clock.stop();
        let begin = out.len();
        let start = WrittenPosition { q: &to.q, pose: &to.pose };
        output.writer.change_tool(out, &self.kinematics, head.note, head.template, start)?;
        if let Some(mut read) = output.read_back.take() {
            let text = out.get(begin..).unwrap_or_default();
            let done = read.change_tool(&self.kinematics, text, &to.pose);
            output.read_back = self.understood(done)?.map(|()| read);
        }
        output.timer = PointTimer::new(&self.kinematics, &self.style.axes, &self.options, to.q)?;
        (output.at, output.block, output.waiting) = (to, to, [0.0; 3]);
        output.inside.clear();
        output.words = RoundedWords::new(&self.kinematics, &self.style, &to);
        self.output = Some(output);
        Ok(())
    }

    /// Times points, and writes the blocks whose time is known.
    pub(super) fn run(&mut self, out: &mut String, points: &[AxisPoint]) -> Result<(), PostError> {
        self.sample(points)?;
        let mut rounded = std::mem::take(&mut self.rounded);
        rounded.clear();
        rounded.extend_from_slice(points);
        if let Some(output) = &mut self.output {
            // Programmed times are kept even where an axis is too fast for them: the report shows it.
            let limited = self.options.method != PostMethod::Programmed;
            let subdivider = limited.then_some(&self.subdivider);
            output.words.take(&self.kinematics, &self.style, subdivider, &mut rounded);
        }
        for batch in rounded.chunks(BATCH) {
            let Some(output) = &mut self.output else { return Ok(()) };
            for point in batch {
                output.timer.push(point, &mut self.timed)?;
            }
            self.write(out)?;
        }
        self.rounded = rounded;
        Ok(())
    }

    /// Samples the motion along points that are not rounded to words.
    fn sample(&mut self, points: &[AxisPoint]) -> Result<(), PostError> {
        let (Some(motion), Some(start)) = (&mut self.motion, self.sampled) else { return Ok(()) };
        let mut at = start;
        for point in points {
            motion.push(at, point)?;
            at = point.q;
        }
        self.sampled = Some(at);
        Ok(())
    }

    /// Brings the machine to rest, and writes everything up to there.
    pub(super) fn rest(&mut self, out: &mut String) -> Result<(), PostError> {
        self.rest_output(out)?;
        self.before.rest();
        Ok(())
    }

    /// Switches the coolant of the program, if another one is wanted; returns true if it was switched.
    pub(super) fn switch_to(
        &mut self,
        out: &mut String,
        wanted: Option<Coolant>,
    ) -> Result<bool, PostError> {
        let Some(output) = &self.output else { return Ok(false) };
        let Some(coolant) = wanted.filter(|wanted| *wanted != output.writer.coolant()) else {
            return Ok(false);
        };
        self.rest_output(out)?;
        self.after.stop();
        let Some(mut output) = self.output.take() else { return Ok(false) };
        let begin = out.len();
        output.writer.switch_coolant(out, coolant);
        if let Some(mut read) = output.read_back.take() {
            let done = read.coolant(out.get(begin..).unwrap_or_default(), coolant);
            output.read_back = self.understood(done)?.map(|()| read);
        }
        self.output = Some(output);
        Ok(true)
    }

    /// Brings the machine of the program to rest, and writes everything up to there.
    fn rest_output(&mut self, out: &mut String) -> Result<(), PostError> {
        if let Some(motion) = &mut self.motion {
            motion.rest()?;
        }
        let Some(output) = &mut self.output else { return Ok(()) };
        // A fresh timer starts from rest at the same place.
        let next = PointTimer::new(&self.kinematics, &self.style.axes, &self.options, output.at.q)?;
        std::mem::replace(&mut output.timer, next).finish(&mut self.timed)?;
        self.write(out)?;
        self.after.rest();
        Ok(())
    }

    /// Returns the result of reading back; a text that the reader does not understand is noted in the report.
    pub(super) fn understood<T>(
        &mut self,
        read: Result<T, ReadBackError>,
    ) -> Result<Option<T>, PostError> {
        match read {
            Ok(read) => Ok(Some(read)),
            Err(ReadBackError::Unread(faults)) => {
                self.report.unread = faults.into_iter().next();
                Ok(None)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Writes the blocks whose time is known.
    fn write(&mut self, out: &mut String) -> Result<(), PostError> {
        let Some(mut output) = self.output.take() else { return Ok(()) };
        let timed = std::mem::take(&mut self.timed);
        for one in &timed {
            let point = &one.point;
            output.pass(one, &self.subdivider);
            self.compare_time(one);
            if !point.block {
                continue;
            }
            self.count_output(&mut output, one);
            let [seconds, length, turn] = output.waiting;
            let pace = match point.least {
                None => BlockPace::Rapid,
                Some(_) => BlockPace::Timed { seconds, length, turn },
            };
            if point.least.is_some() {
                let travel =
                    word_travel(&self.kinematics, self.style.dialect, &output.block, &output.at);
                self.after.feed(&travel, seconds);
                let words = &self.style.axes;
                let coordinates = self.style.dialect.coordinates();
                // Words are rounded in the axes; the report states what that does to the tip.
                let off = rounding(&self.kinematics, &point.q, words, coordinates, 0.0);
                self.report.rounding = self.report.rounding.max(off);
            }
            let begin = out.len();
            if point.goes_out {
                output.writer.comment(out, "out of the cut, rotaries go round, and back");
            }
            let end = point.end();
            output.writer.block(out, WrittenPosition { q: &end.q, pose: &end.pose }, pace)?;
            // What was just written must read back as the same block.
            if let Some(mut read) = output.read_back.take() {
                let text = out.get(begin..).unwrap_or_default();
                let done = read.block(text, &end, pace);
                let ends = self.understood(done)?;
                output.read_back = ends.map(|_| read);
                if let Some(ends) = ends {
                    self.account_for(point, ends)?;
                }
            }
            output.waiting = [0.0; 3];
            output.block = output.at;
        }
        self.timed = timed;
        self.timed.clear();
        self.output = Some(output);
        Ok(())
    }

    /// Enters a block, as it was read back, in the account of all motion.
    fn account_for(&mut self, point: &AxisPoint, ends: [ToolPose; 2]) -> Result<(), PostError> {
        let is_rapid = point.least.is_none();
        let filters = self.options.filter != PostFilter::None;
        // Both ends are rounded; a filter may move them within the tolerance.
        let coordinates = self.style.dialect.coordinates();
        let off = rounding(&self.kinematics, &point.q, &self.style.axes, coordinates, 0.0);
        let moved = if filters { self.options.tolerance.tip } else { 0.0 };
        let rounding = 2.0 * (off + moved);
        let one = CountedMove { line: point.line, is_rapid, ends, rounding };
        if point.is_added || (filters && !is_rapid) {
            self.account.wrote_other(&one);
            return Ok(());
        }
        self.account.wrote(&one)
    }

    /// Compares the time of a point with the programmed one, move by move.
    fn compare_time(&mut self, one: &TimedPoint) {
        let TimedPoint { point, seconds } = *one;
        let Some(programmed) = point.programmed else { return };
        match &mut self.comparing {
            Some(sum) if sum.line == point.line => {
                sum.seconds.input += programmed;
                sum.seconds.output += seconds;
            }
            _ => {
                self.note_slowed();
                let seconds = InputOutput { input: programmed, output: seconds };
                self.comparing = Some(SlowedMove { line: point.line, seconds });
            }
        }
    }

    /// Notes the move that was compared last, if it is slower than programmed.
    pub(super) fn note_slowed(&mut self) {
        let slowed = self.comparing.take().filter(|sum| sum.ratio() > SLOWER);
        let Some(slowed) = slowed else { return };
        self.report.slowed_moves += 1;
        if self.report.slowed.len() < MOST_SLOWED {
            self.report.slowed.push(slowed);
        }
        if self.report.slowest.is_none_or(|worst| worst.ratio() < slowed.ratio()) {
            self.report.slowest = Some(slowed);
        }
    }

    /// Compares the axes in a rapid move with their velocities, on a control that limits X, Y and Z of the tip alone.
    ///
    /// `LinuxCNC` plans rapid moves under tool-centre-point control in the words: each at most at its own velocity. The
    /// axes behind X, Y and Z may have to be quicker.
    fn count_rapid(&mut self, output: &ProgramOutput, line: u32, inside: &[InsidePoint]) {
        if self.style.dialect != OutputFormat::LinuxCnc {
            return;
        }
        let limits = self.kinematics.machine().vector(|axis| axis.rapid);
        let words = word_travel(&self.kinematics, self.style.dialect, &output.block, &output.at);
        let seconds = words.abs().component_div(&limits).amax();
        let whole: f64 = inside.iter().map(|point| point.size).sum();
        let over = |point: &InsidePoint| {
            point.fastest.component_div(&limits).amax() * whole / (point.size * seconds)
        };
        let ratio = inside.iter().map(over).filter(|ratio| ratio.is_finite()).fold(0.0, f64::max);
        if ratio > 1.0 && self.report.fastest_rapid.is_none_or(|worst| worst.ratio < ratio) {
            self.report.fastest_rapid = Some(FastRapid { line, ratio });
        }
    }

    /// Adds a block of the output to the times and axis loads of the report.
    fn count_output(&mut self, output: &mut ProgramOutput, end: &TimedPoint) {
        let inside = std::mem::take(&mut output.inside);
        let [seconds, ..] = output.waiting;
        if end.point.least.is_none() {
            self.count_rapid(output, end.point.line, &inside);
            self.report.rapid_seconds += seconds;
            let words =
                word_travel(&self.kinematics, self.style.dialect, &output.block, &output.at);
            return self.after.rapid(&words);
        }
        self.after.cutting = true;
        self.after.seconds += seconds;
        let q = &end.point.q;
        let error = position_error(&self.kinematics, &self.style.axes, end.point.source, q);
        self.after.load.push(&(q - output.block.q), &error, seconds);
        // Points inside a block share its time by their size.
        let whole: f64 = inside.iter().map(|point| point.size).sum();
        for InsidePoint { fastest, size } in &inside {
            self.after.load.inside(fastest, seconds * size / whole);
        }
    }
}

impl ProgramOutput {
    /// Moves on to a timed point, and adds its time and travel to those of the block.
    fn pass(&mut self, one: &TimedPoint, subdivider: &Subdivider) {
        let point = &one.point;
        let end = point.end();
        let fastest = subdivider.fastest([self.at.block_end(), end.block_end()]);
        self.inside.push(InsidePoint { fastest, size: point.size() });
        self.at = end;
        let passed = [one.seconds, point.written[0], point.written[1]];
        self.waiting.iter_mut().zip(passed).for_each(|(sum, by)| *sum += by);
    }
}
