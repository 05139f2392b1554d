//! Servo setpoints of an input: `--motion`.

use super::head::Head;
use super::input::Input;
use super::plan::Plan;
use crate::motion;
use crate::outcome::Failure;
#[cfg(feature = "parquet")]
use std::collections::VecDeque;
use std::io::Write;
use std::path::Path;
use trunnion::machine::Machine;
use trunnion::nc::write::{OutputFormat, Style, Template};
use trunnion::post::{PostError, PostMethod, PostOptions, Poster, ProgramHead, control_of};
use trunnion::types::{Progress, Setpoint};

/// Servo period of a machine that states none \[s\].
const SERVO_PERIOD: f64 = 0.001;

/// Setpoints of an input, move by move.
pub(super) struct SetpointSource<'a> {
    plan: &'a Plan,
    input: Input<'a>,
    poster: Option<Poster>,
    period: f64,
    options: PostOptions,
    style: Style,
    template: Template,
    head: Head,
    /// Program text, which nobody asks for.
    text: String,
}

/// Setpoints that were written.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WrittenSetpoints {
    pub(super) rows: usize,
    /// Time of the last \[s\].
    pub(super) duration: f64,
}

impl WrittenSetpoints {
    fn count(&mut self, setpoints: &[Setpoint]) {
        self.rows += setpoints.len();
        self.duration = setpoints.last().map_or(self.duration, |last| last.t);
    }
}

/// Returns the servo period: that of the arguments, of the machine, or a millisecond.
pub(super) fn period(given: Option<f64>, machine: &Machine) -> f64 {
    given.or(machine.cycle.servo_period).unwrap_or(SERVO_PERIOD)
}

impl<'a> SetpointSource<'a> {
    /// Opens the input again, for motion at a servo period \[s\].
    pub(super) fn open(
        plan: &'a Plan,
        path: &'a Path,
        period: f64,
        bars: &'a dyn Progress,
    ) -> Result<Self, Failure> {
        let input = plan.open(path, bars)?;
        // The axes run straight from point to point. Points and rounded corners each have half of the tolerance.
        let dialect = OutputFormat::G93;
        let options = PostOptions {
            control: control_of(&plan.kinematics, dialect),
            tolerance: plan.options.tolerance.scaled(0.5),
            method: PostMethod::Programmed,
            ..plan.options
        };
        let style = Style { dialect, blend: None, ..plan.style };
        let template = Template::of(dialect).map_err(|error| Failure::input(error.to_string()))?;
        let (head, text) = (Head::default(), String::new());
        Ok(Self { plan, input, poster: None, period, options, style, template, head, text })
    }

    /// Writes all setpoints as a CSV table.
    pub(super) fn write(mut self, out: &mut dyn Write) -> Result<WrittenSetpoints, Failure> {
        let unwritten = |error| anyhow::Error::new(error).context("writing the setpoints");
        let axes = &self.plan.kinematics.machine().axes;
        motion::header(out, axes, motion::JERK_LIMITED).map_err(unwritten)?;
        let mut written = WrittenSetpoints::default();
        let mut rows = |setpoints: &[Setpoint]| -> Result<(), Failure> {
            written.count(setpoints);
            let mut each = setpoints.iter();
            Ok(each.try_for_each(|one| motion::row(out, axes, one)).map_err(unwritten)?)
        };
        // Setpoints are known only behind the look-ahead, so most calls return a batch and some return none.
        while let Some(setpoints) = self.next()? {
            rows(&setpoints)?;
        }
        rows(&self.finish()?)?;
        Ok(written)
    }

    /// Writes all setpoints as a Parquet table.
    #[cfg(feature = "parquet")]
    pub(super) fn write_columns(
        mut self,
        out: impl Write + Send,
    ) -> Result<WrittenSetpoints, Failure> {
        let axes = &self.plan.kinematics.machine().axes;
        let mut written = WrittenSetpoints::default();
        let mut failed = None;
        let mut waiting: VecDeque<Setpoint> = VecDeque::new();
        let mut more = true;
        // The writer of columns pulls rows; an error ends them, and is returned after the file is closed.
        let rows = std::iter::from_fn(|| {
            while waiting.is_empty() && more {
                let next = self.next().and_then(|moved| match moved {
                    Some(setpoints) => Ok(setpoints),
                    None => {
                        more = false;
                        self.finish()
                    }
                });
                match next {
                    Ok(setpoints) => {
                        written.count(&setpoints);
                        waiting.extend(setpoints);
                    }
                    Err(error) => {
                        (failed, more) = (Some(error), false);
                    }
                }
            }
            waiting.pop_front().map(|setpoint| motion::values(axes, &setpoint))
        });
        crate::parquet::write(out, &motion::columns(axes), rows)
            .map_err(|error| anyhow::Error::new(error).context("writing the setpoints"))?;
        failed.map_or(Ok(written), Err)
    }

    /// Takes the next move in, and returns the setpoints that are known then; `None` behind the last move.
    fn next(&mut self) -> Result<Option<Vec<Setpoint>>, Failure> {
        let Some(one) = self.input.next()? else { return Ok(None) };
        if self.poster.is_none() {
            self.head.name = self.input.name();
        }
        self.head.take(&self.input.state());
        let note = self.head.note();
        let texts = ProgramHead { note: &note, template: &self.template };
        let poster = match &mut self.poster {
            Some(poster) => poster,
            none => {
                let machine = self.plan.with_tool(self.head.tool);
                let source = self.input.source();
                let new = Poster::new(&machine, source, &self.options, &self.style);
                let new = new.map_err(|error| self.input.failure(&error))?;
                none.insert(new.with_setpoints(self.period))
            }
        };
        let pushed = poster.push(&mut self.text, &one, texts);
        pushed.map_err(|error| self.input.failure(&error))?;
        self.text.clear();
        Ok(Some(poster.take_setpoints()))
    }

    /// Returns the last setpoints.
    fn finish(&mut self) -> Result<Vec<Setpoint>, Failure> {
        let note = self.head.note();
        let texts = ProgramHead { note: &note, template: &self.template };
        let poster = self.poster.take().ok_or_else(|| self.input.failure(&PostError::Empty))?;
        let done = poster.finish_motion(&mut self.text, texts);
        done.map_err(|error| self.input.failure(&error))
    }
}
