//! Entry point: takes the moves of an input one by one and writes the program.

mod audit;
mod output;
mod program_output;
mod read_moves;
mod tally;

use super::axis_point::{AxesPose, AxisPoint};
use super::control::smoothing_bound;
use super::error::PostError;
use super::filter::MoveFilter;
use super::motion_stream::MotionStream;
use super::options::{PostFilter, PostMove, PostOptions, PostPace, PostSource, ProgramHead};
use super::report::{InputOutput, PostReport};
use super::rotaries::{PlannedMove, RetractPhase, RotaryPlanner};
use super::smoothing_choice::{MoveGroup, SmoothingChoice};
use super::subdivision::Subdivider;
use crate::inverse::Inverse;
use crate::machine::Kinematics;
use crate::nc::write::{Coolant, OutputFormat, Style};
use crate::types::{AxisVector, Setpoint};
use audit::{OutputAudit, WrittenBatch};
use program_output::ProgramOutput;
use read_moves::{ReadItem, ReadMove};
use std::collections::VecDeque;

/// Moves of the input that wait to be counted, at most.
const MOST_COUNTED: usize = 1 << 13;

/// Posts the moves of an input one by one.
///
/// The moves pass the stages of the module in order; each holds back as many as it must look ahead.
#[derive(Debug)]
pub struct Poster {
    kinematics: Kinematics,
    options: PostOptions,
    style: Style,
    subdivider: Subdivider,
    source: PostSource,
    filter: MoveFilter,
    filtered: Vec<PostMove>,
    /// Moves for which smoothing is not yet decided.
    group: MoveGroup,
    rotaries: RotaryPlanner,
    planned: Vec<PlannedMove>,
    /// Programmed speeds of the moves that the rotary planner holds back.
    asked: VecDeque<PostPace>,
    /// Coolant of the moves that are pushed; `None`: that of the note.
    coolant: Option<Coolant>,
    /// Coolant of the moves that the rotary planner holds back.
    cooled: VecDeque<Option<Coolant>>,
    /// End of the last move of the input, on the machine, if the moves are filtered.
    read: Option<AxesPose>,
    output: Option<ProgramOutput>,
    points: Vec<AxisPoint>,
    /// Moves of the input whose times are not counted yet.
    counted: Vec<ReadItem>,
    /// Audit of the output.
    audit: OutputAudit,
    /// Blocks that are being audited; kept for its memory.
    audited: WrittenBatch,
    /// Samples the motion of the axes, where it is asked for.
    motion: Option<MotionStream>,
    /// Axes up to which it is sampled.
    sampled: Option<AxisVector>,
    report: PostReport,
}

impl Poster {
    /// Creates a poster for `kinematics`, whose program has this style.
    ///
    /// # Errors
    ///
    /// [`PostError`].
    pub fn new(
        kinematics: &Kinematics,
        source: PostSource,
        options: &PostOptions,
        style: &Style,
    ) -> Result<Self, PostError> {
        // Filter and machine conversion divide the tolerance between them.
        let share = options.filter.left(options.control);
        let rest = PostOptions { tolerance: options.tolerance.scaled(share), ..*options };
        Ok(Self {
            kinematics: kinematics.clone(),
            options: *options,
            style: *style,
            filter: MoveFilter::new(
                options.filter,
                options.control,
                source.clone(),
                options.tolerance.into(),
            ),
            filtered: Vec::new(),
            group: MoveGroup::default(),
            rotaries: RotaryPlanner::new(chooses(kinematics, &source, style)?, options.unwind),
            planned: Vec::new(),
            asked: VecDeque::new(),
            coolant: None,
            cooled: VecDeque::new(),
            read: None,
            subdivider: Subdivider::new(kinematics, source.clone(), &rest)?.for_style(style),
            source,
            output: None,
            points: Vec::new(),
            counted: Vec::new(),
            audit: OutputAudit::new(kinematics, style),
            audited: WrittenBatch::default(),
            motion: None,
            sampled: None,
            report: PostReport::default(),
        })
    }

    /// Samples the motion of the axes as well, at the servo period \[s\].
    ///
    /// The axes run within their jerk limits through the points of the program, and round its corners within the tolerance
    /// of the options, which adds to that of the points. Dwells are left out. Take the setpoints with
    /// [`Self::take_setpoints`] after each move, and end with [`Self::finish_motion`].
    #[must_use]
    pub fn with_setpoints(self, period: f64) -> Self {
        let motion = Some(MotionStream::new(&self.kinematics, &self.options, period));
        Self { motion, ..self }
    }

    /// Returns the setpoints since the last call.
    pub fn take_setpoints(&mut self) -> Vec<Setpoint> {
        self.motion.as_mut().map(MotionStream::take).unwrap_or_default()
    }

    /// Ends the motion, and returns its last setpoints.
    ///
    /// # Errors
    ///
    /// As [`Self::finish`].
    pub fn finish_motion(
        mut self,
        out: &mut String,
        head: ProgramHead<'_>,
    ) -> Result<Vec<Setpoint>, PostError> {
        self.settle(out, head)?;
        if self.output.is_none() {
            return Err(PostError::Empty);
        }
        Ok(self.motion.map(MotionStream::finish).unwrap_or_default())
    }

    /// Switches the coolant for the moves that are pushed from here on, until the next change of tool.
    ///
    /// The program has it on a line of its own, where the machine rests: a control waits for its motion before it switches.
    ///
    /// # Errors
    ///
    /// [`PostError`].
    pub fn switch_coolant(
        &mut self,
        out: &mut String,
        coolant: Coolant,
        head: ProgramHead<'_>,
    ) -> Result<(), PostError> {
        if self.options.filter != PostFilter::None {
            // A filter must not join moves over the change.
            self.decide(out, head)?;
            self.hand_on_filtered(out, head)?;
            self.counted.push(ReadItem::Stop);
        }
        self.coolant = Some(coolant);
        Ok(())
    }

    /// Takes in a move and appends the blocks that are final to `out`.
    ///
    /// The first move only sets the starting position, and writes the head of the program.
    ///
    /// # Errors
    ///
    /// [`PostError`].
    pub fn push(
        &mut self,
        out: &mut String,
        one: &PostMove,
        head: ProgramHead<'_>,
    ) -> Result<(), PostError> {
        let asked = one.pace;
        // A filter replaces moves with feed by others.
        if self.options.filter == PostFilter::None || asked == PostPace::Rapid {
            self.audit.account.read(one);
        } else {
            self.audit.account.read_other(one);
        }
        // The report compares with the feed as asked; the output is capped.
        let one = PostMove { pace: self.capped(one.pace), ..*one };
        if self.options.filter == PostFilter::None {
            self.asked.push_back(asked);
            return self.choose_rotaries(out, &one, head);
        }
        // Filtered moves no longer match those of the input one to one, so the input is counted here, on its
        // own way over the machine.
        let q = self.subdivider.near(&one, self.read.as_ref())?;
        let to = AxesPose { q, pose: one.pose };
        if let Some(from) = self.read.replace(to) {
            let source = self.subdivider.position_source(&one);
            let linear_error = self.subdivider.linear_error(source, &to.q);
            self.count_input(ReadMove { from, to, asked, source, linear_error });
        }
        if self.options.filter == PostFilter::Smooth {
            // Whether smoothing pays is decided for a whole cut, at its end.
            if self.group.ends_before(&one) {
                self.decide(out, head)?;
            }
            self.group.push(one);
            return Ok(());
        }
        let mut filtered = std::mem::take(&mut self.filtered);
        self.filter.push(&one, &mut filtered)?;
        for one in filtered.drain(..) {
            self.choose_rotaries(out, &one, head)?;
        }
        self.filtered = filtered;
        Ok(())
    }

    /// Posts the group of moves with the filter that makes it quickest.
    fn decide(&mut self, out: &mut String, head: ProgramHead<'_>) -> Result<(), PostError> {
        if self.group.is_empty() {
            return Ok(());
        }
        let choice = SmoothingChoice {
            kinematics: &self.kinematics,
            source: &self.source,
            options: &self.options,
            style: &self.style,
            rotaries: &self.rotaries,
            subdivider: &self.subdivider,
        };
        // The trial starts from copies of the state; the quickest one becomes the state.
        let mut decisions = self.report.smoothing.unwrap_or_default();
        let best = choice.quickest(&self.group, &mut decisions)?;
        self.report.smoothing = Some(decisions);
        self.group.clear();
        self.rotaries = best.rotaries;
        self.subdivider = best.subdivider;
        self.add_deviation(best.strayed);
        if let Some(start) = best.start {
            self.begin(out, start, head)?;
        }
        self.switch_to(out, self.coolant)?;
        self.run(out, &best.points)
    }

    /// Keeps the largest deviation of rapid moves.
    fn add_rapid(&mut self) {
        let rapid = self.subdivider.strayed_rapid.into();
        self.report.rapid_deviation = self.report.rapid_deviation.max(rapid);
    }

    /// Keeps the largest deviation from the input \[mm, rad\].
    fn add_deviation(&mut self, by: [f64; 2]) {
        self.report.deviation = self.report.deviation.max(by.into());
    }

    /// Passes a filtered move to the rotary planner, and runs the moves that it releases.
    fn choose_rotaries(
        &mut self,
        out: &mut String,
        one: &PostMove,
        head: ProgramHead<'_>,
    ) -> Result<(), PostError> {
        let mut planned = std::mem::take(&mut self.planned);
        self.cooled.push_back(self.coolant);
        self.rotaries.push(one, &mut planned);
        for one in planned.drain(..) {
            self.take(out, &one, head)?;
        }
        self.planned = planned;
        Ok(())
    }

    /// Runs a move whose rotaries are chosen.
    fn take(
        &mut self,
        out: &mut String,
        planned: &PlannedMove,
        head: ProgramHead<'_>,
    ) -> Result<(), PostError> {
        // Moves that are added belong to the move behind them, and run with the coolant before it.
        let coolant =
            if planned.phase.is_none() { self.cooled.pop_front().flatten() } else { None };
        if self.switch_to(out, coolant)? && self.options.filter == PostFilter::None {
            self.counted.push(ReadItem::Stop);
        }
        let from = self.subdivider.position();
        self.points.clear();
        self.subdivider.divide(planned, &mut self.points)?;
        let Some(to) = self.subdivider.position() else { return Ok(()) };
        let asked = if planned.phase.is_none() { self.asked.pop_front() } else { None };
        let Some(from) = from else { return self.begin(out, to, head) };
        if let Some(asked) = asked {
            let source = self.subdivider.position_source(&planned.one);
            // The last point ends where the move does.
            let linear_error = self.points.last().map_or(0.0, |last| last.linear_error);
            self.count_input(ReadMove { from, to, asked, source, linear_error });
        }
        // The first point of a retract carries the comment that explains it in the program.
        if let (Some(RetractPhase::Out), Some(first)) = (planned.phase, self.points.first_mut()) {
            first.goes_out = true;
        }
        let points = std::mem::take(&mut self.points);
        self.run(out, &points)?;
        self.points = points;
        Ok(())
    }

    /// Continues with another tool: `kinematics` has its length, `source` the length that the input assumes.
    ///
    /// The next move only sets the starting position, and writes the tool change.
    ///
    /// # Errors
    ///
    /// [`PostError`].
    pub fn change_tool(
        &mut self,
        out: &mut String,
        kinematics: &Kinematics,
        source: PostSource,
        head: ProgramHead<'_>,
    ) -> Result<(), PostError> {
        // Everything of the tool before is written before its kinematics are replaced.
        self.settle(out, head)?;
        if self.report.unread.is_none() {
            self.audit.account.settle()?;
        }
        self.audit.account.start_tool();
        let fresh = Self::new(kinematics, source, &self.options, &self.style)?;
        self.add_rapid();
        self.report.unwound.append(&mut self.rotaries.unwound);
        self.rotaries = fresh.rotaries;
        self.subdivider = fresh.subdivider;
        self.filter = fresh.filter;
        self.kinematics = fresh.kinematics;
        self.source = fresh.source;
        self.group = MoveGroup::default();
        self.read = None;
        self.coolant = None;
        Ok(())
    }

    /// Ends the program: writes what is held back, and the end of the template.
    ///
    /// # Errors
    ///
    /// [`PostError`]; [`PostError::Empty`] if there was no move.
    pub fn finish(
        mut self,
        out: &mut String,
        head: ProgramHead<'_>,
    ) -> Result<PostReport, PostError> {
        self.settle(out, head)?;
        let Some(output) = self.output.take() else { return Err(PostError::Empty) };
        let begin = out.len();
        let unwritten = output.writer.unwritten();
        self.report.blocks.output = output.writer.finish(out);
        self.audit.end(out.get(begin..).unwrap_or_default(), &mut self.report)?;
        if self.report.unread.is_none() {
            self.audit.account.settle()?;
        }
        self.report.motion =
            InputOutput { input: self.audit.account.input, output: self.audit.account.output };
        self.report.smoothing_bound = smoothing_bound(&self.style);
        self.add_rapid();
        let [before, after] = [&mut self.audit.before, &mut self.audit.after];
        self.report.unwritten_seconds = unwritten;
        // What no block of the text has is no time of the program.
        let written = (after.seconds - unwritten).max(0.0);
        self.report.seconds = InputOutput { input: before.seconds, output: written };
        self.report.model_seconds =
            InputOutput { input: before.cuts.stop(), output: after.cuts.stop() };
        self.report.linuxcnc_duration =
            InputOutput { input: before.clock.stop(), output: after.clock.stop() };
        self.report.loads = InputOutput { input: before.load.worst, output: after.load.worst };
        self.report.unwound.append(&mut self.rotaries.unwound);
        Ok(self.report)
    }

    /// Writes everything that is held back, and brings the machine to rest.
    fn settle(&mut self, out: &mut String, head: ProgramHead<'_>) -> Result<(), PostError> {
        self.decide(out, head)?;
        self.hand_on_filtered(out, head)?;
        let mut planned = Vec::new();
        self.rotaries.finish(&mut planned);
        for one in &planned {
            self.take(out, one, head)?;
        }
        self.rest(out)?;
        let Self { audit, counted, kinematics, style, .. } = self;
        audit.count_read(counted, kinematics, style);
        if self.options.filter != PostFilter::Smooth {
            let divided = self.subdivider.strayed;
            let filtered = self.filter.strayed();
            self.add_deviation([divided[0] + filtered[0], divided[1] + filtered[1]]);
        }
        Ok(())
    }

    /// Passes on the moves that the filter holds back.
    fn hand_on_filtered(
        &mut self,
        out: &mut String,
        head: ProgramHead<'_>,
    ) -> Result<(), PostError> {
        let mut filtered = std::mem::take(&mut self.filtered);
        self.filter.finish(&mut filtered)?;
        for one in filtered.drain(..) {
            self.choose_rotaries(out, &one, head)?;
        }
        self.filtered = filtered;
        Ok(())
    }

    /// Returns the number of moves read so far.
    pub fn moves(&self) -> usize {
        self.report.blocks.input
    }

    /// Raises or lowers a feed to the largest one of the options.
    fn capped(&self, pace: PostPace) -> PostPace {
        match (pace, self.options.max_feed) {
            (PostPace::Rapid, _) | (_, None) => pace,
            (_, Some(most)) => PostPace::Feed(most),
        }
    }

    /// Takes a move of the input for the times and axis loads of the report.
    fn count_input(&mut self, read: ReadMove) {
        let ReadMove { from, to, asked, .. } = &read;
        self.report.blocks.input += 1;
        if *asked != PostPace::Rapid {
            self.report.length += (to.pose.tip - from.pose.tip).norm();
        }
        self.counted.push(ReadItem::Move(read));
        if self.counted.len() >= MOST_COUNTED {
            // A filter may leave so much out that no batch is written for long.
            let Self { audit, counted, kinematics, style, .. } = self;
            audit.count_read(counted, kinematics, style);
        }
    }
}

/// Returns the inverse kinematics if the rotaries are chosen here.
///
/// They are not for a program that is for this machine already, nor for a control that receives tool vectors.
fn chooses(
    kinematics: &Kinematics,
    source: &PostSource,
    style: &Style,
) -> Result<Option<Inverse>, PostError> {
    let own = matches!(source, PostSource::Program(of) if **of == *kinematics);
    let vectors = style.dialect.is_vector() || style.dialect == OutputFormat::Apt;
    if own || vectors {
        return Ok(None);
    }
    Inverse::new(kinematics).map(Some).map_err(|error| PostError::reach(0, error))
}
