//! Output of the poster: hands the axis points to the program, and what is written to its audit.

use super::Poster;
use super::audit::AuditContext;
use super::program_output::{ProgramOutput, WriteStep};
use super::read_moves::ReadItem;
use crate::nc::write::{Coolant, ProgramForm, ProgramWriter, WrittenPosition};
use crate::post::axis_point::{AxesPose, AxisPoint};
use crate::post::error::PostError;
use crate::post::options::{PostMethod, ProgramHead};
use crate::post::rounded_words::RoundedWords;
use crate::post::timing::PointTimer;
use crate::types::AxisVector;

/// Number of points that are timed before the finished blocks are written.
const BATCH: usize = 1024;

/// Number of points from which a second thread is worth its start.
const WORTH_A_THREAD: usize = 128;

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
        let begin = out.len();
        let style = &self.style;
        let form = ProgramForm { note: head.note, style, template: head.template, changes: &[] };
        let start = WrittenPosition { q: &to.q, pose: &to.pose };
        // The head depends on where the program starts, so it is written with the first position.
        let writer = ProgramWriter::new(out, &self.kinematics, form, start)?;
        let timer = self.timer(to.q)?;
        let text = out.get(begin..).unwrap_or_default();
        let Self { audit, kinematics, style, options, subdivider, report, .. } = self;
        let context = AuditContext { kinematics, style, options, subdivider };
        audit.begin(&context, to, text, report)?;
        let words = RoundedWords::new(&self.kinematics, &self.style, &to);
        self.output = Some(ProgramOutput::new(timer, writer, words, to.q));
        Ok(())
    }

    /// Creates a timer for axes that rest at `at`.
    fn timer(&self, at: AxisVector) -> Result<PointTimer, PostError> {
        PointTimer::new(&self.kinematics, &self.style.axes, &self.options, at)
    }

    /// Writes the change to another tool, up to its starting position.
    fn change(
        &mut self,
        out: &mut String,
        to: AxesPose,
        head: ProgramHead<'_>,
    ) -> Result<(), PostError> {
        let timer = self.timer(to.q)?;
        let Self { audit, kinematics, style, options, subdivider, report, output, .. } = self;
        let Some(output) = output else { return Ok(()) };
        self.counted.push(ReadItem::StopClock);
        let begin = out.len();
        let start = WrittenPosition { q: &to.q, pose: &to.pose };
        output.writer.change_tool(out, kinematics, head.note, head.template, start)?;
        let text = out.get(begin..).unwrap_or_default();
        let context = AuditContext { kinematics, style, options, subdivider };
        audit.change(&context, to, text, report)?;
        output.start_tool(timer, RoundedWords::new(kinematics, style, &to), to.q);
        Ok(())
    }

    /// Times points, and writes the blocks whose time is known.
    pub(super) fn run(&mut self, out: &mut String, points: &[AxisPoint]) -> Result<(), PostError> {
        self.sample(points)?;
        let Some(output) = &mut self.output else { return Ok(()) };
        let from = output.queue.len();
        output.queue.extend_from_slice(points);
        output.last = points.last().map_or(output.last, |point| point.q);
        // Programmed times are kept even where an axis is too fast for them: the report shows it.
        let limited = self.options.method != PostMethod::Programmed;
        let subdivider = limited.then_some(&self.subdivider);
        let queued = output.queue.get_mut(from..).unwrap_or_default();
        output.words.take(&self.kinematics, &self.style, subdivider, queued);
        if output.queue.len() >= BATCH { self.advance(out, WriteStep::Batch) } else { Ok(()) }
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
        self.counted.push(ReadItem::Rest);
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
        let begin = out.len();
        if let Some(output) = &mut self.output {
            output.writer.switch_coolant(out, coolant);
        }
        let text = out.get(begin..).unwrap_or_default();
        self.audit.coolant(text, coolant, &mut self.report)?;
        Ok(true)
    }

    /// Brings the machine of the program to rest, and writes and audits everything up to there.
    fn rest_output(&mut self, out: &mut String) -> Result<(), PostError> {
        if let Some(motion) = &mut self.motion {
            motion.rest()?;
        }
        let Some(output) = &self.output else { return Ok(()) };
        // A fresh timer starts from rest at the same place.
        let next = self.timer(output.last)?;
        self.advance(out, WriteStep::Rest(Box::new(next)))?;
        self.audit_written()
    }

    /// Times the queued points and writes their blocks, while those that were written before are audited.
    ///
    /// Audit and timing share nothing, and the audit goes block by block: the result does not depend on the number of
    /// threads.
    fn advance(&mut self, out: &mut String, step: WriteStep) -> Result<(), PostError> {
        let Self { audit, kinematics, style, options, subdivider, report, output, .. } = self;
        let (Some(output), batch) = (output, &mut self.audited) else { return Ok(()) };
        std::mem::swap(&mut output.written, batch);
        std::mem::swap(&mut self.counted, &mut batch.read);
        let context = AuditContext { kinematics, style, options, subdivider };
        let is_worth = batch.items.len() >= WORTH_A_THREAD;
        let mut take = || audit.take(batch, &context, report);
        let write = || output.write(out, step);
        let (taken, written) = if is_worth { rayon::join(take, write) } else { (take(), write()) };
        batch.clear();
        // The audited blocks come before those that are written now.
        taken?;
        written
    }

    /// Audits the blocks that were written last.
    fn audit_written(&mut self) -> Result<(), PostError> {
        let Self { audit, kinematics, style, options, subdivider, report, output, .. } = self;
        let Some(output) = output else { return Ok(()) };
        let context = AuditContext { kinematics, style, options, subdivider };
        std::mem::swap(&mut self.counted, &mut output.written.read);
        let taken = audit.take(&mut output.written, &context, report);
        output.written.clear();
        taken
    }
}
