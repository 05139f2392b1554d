//! Cutter locations or a program to a program for a machine, move by move, with new feeds.
//!
//! ```text
//! replay  steps of a program to moves
//! filter  moves smoothed, or fewer of them
//! ahead   which way round the rotaries go, so that cuts stay inside travel
//! course  moves to places on the machine, close enough for its control
//! pace    times of places, window by window
//! gauge   what it asks of the axes, what it takes on a control without look-ahead
//! ```
//!
//! Memory is that of the window, however long the input is.

mod ahead;
mod corner;
mod course;
mod error;
mod filter;
mod gauge;
mod leg;
mod options;
mod pace;
mod replay;

pub use error::PostError;
pub use filter::PostFilter;
pub use options::{
    POST_WINDOW, PostMethod, PostMove, PostOptions, PostPace, PostReport, PostSource,
};
pub use replay::{Left, ProgramMoves};

use crate::blocks::Control;
use crate::inverse::Inverse;
use crate::machine::{Interpolation, Kinematics};
use crate::nc::write::{
    BlockPace, Coordinates, Dialect, Note, ProgramWriter, Style, Template, rounding,
};
use crate::pipeline::read_back::{ReadBack, ReadBackError};
use crate::types::{AxisVector, ToolPose};
use ahead::{Ahead, Part, Planned};
use course::Course;
use filter::Filter;
use gauge::{ControlModel, Gauge};
use leg::Place;
use pace::{Pace, Timed};
use std::collections::VecDeque;

/// Times and counts of blocks, input or output.
#[derive(Debug)]
struct Tally {
    gauge: Gauge,
    seconds: f64,
    model: f64,
    cutting: bool,
}

impl Tally {
    fn new(kinematics: &Kinematics) -> Self {
        let gauge = Gauge::new(kinematics.machine());
        Self { gauge, seconds: 0.0, model: 0.0, cutting: false }
    }

    fn rapid(&mut self) {
        if self.cutting {
            self.gauge.rest();
        }
        self.cutting = false;
    }
}

/// Posts moves one by one.
#[derive(Debug)]
pub struct Poster {
    kinematics: Kinematics,
    options: PostOptions,
    style: Style,
    course: Course,
    filter: Filter,
    filtered: Vec<PostMove>,
    ahead: Ahead,
    planned: Vec<Planned>,
    /// How fast the input asks for the moves that are looked at ahead.
    asked: VecDeque<PostPace>,
    /// Where the input is, on the machine; moves that are not filtered are their own measure.
    read: Option<(AxisVector, ToolPose)>,
    running: Option<Running>,
    places: Vec<Place>,
    timed: Vec<Timed>,
    before: Tally,
    after: Tally,
    report: PostReport,
}

/// What exists from the first move on.
#[derive(Debug)]
struct Running {
    pace: Pace,
    writer: ProgramWriter,
    /// Reads what the writer writes; `None` once it does not understand it.
    read_back: Option<ReadBack>,
    /// The last place whose time is known, and the last block end.
    at: (AxisVector, ToolPose),
    block: (AxisVector, ToolPose),
    /// Time, way and turn since the last block end.
    waiting: [f64; 3],
}

impl Poster {
    /// Starts.
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
        let share = options.filter.left(options.control);
        let rest = PostOptions { tolerance: options.tolerance.map(|of| share * of), ..*options };
        Ok(Self {
            kinematics: kinematics.clone(),
            options: *options,
            style: *style,
            filter: Filter::new(
                (options.filter, options.control),
                source.clone(),
                options.tolerance,
            ),
            filtered: Vec::new(),
            ahead: Ahead::new(chooses(kinematics, &source, style)?, options.unwind),
            planned: Vec::new(),
            asked: VecDeque::new(),
            read: None,
            course: Course::new(kinematics, source, &rest)?,
            running: None,
            places: Vec::new(),
            timed: Vec::new(),
            before: Tally::new(kinematics),
            after: Tally::new(kinematics),
            report: PostReport::default(),
        })
    }

    /// Takes in a move; what can be written is appended. The first only says where the program starts, and writes
    /// its head from note and template.
    ///
    /// # Errors
    ///
    /// [`PostError`].
    pub fn push(
        &mut self,
        out: &mut String,
        one: &PostMove,
        head: (&Note<'_>, &Template),
    ) -> Result<(), PostError> {
        let asked = one.pace;
        let one = PostMove { pace: self.capped(one.pace), ..*one };
        if self.options.filter == PostFilter::None {
            self.asked.push_back(asked);
            return self.look(out, &one, head);
        }
        let to = (self.course.near(&one, self.read.as_ref())?, one.pose);
        if let Some(from) = self.read.replace(to) {
            self.tell_before(&from, &to, asked);
        }
        let mut filtered = std::mem::take(&mut self.filtered);
        self.filter.push(&one, &mut filtered)?;
        for one in filtered.drain(..) {
            self.look(out, &one, head)?;
        }
        self.filtered = filtered;
        Ok(())
    }

    /// Takes in a move that is to be posted as it is, once its rotaries are chosen.
    fn look(
        &mut self,
        out: &mut String,
        one: &PostMove,
        head: (&Note<'_>, &Template),
    ) -> Result<(), PostError> {
        let mut planned = std::mem::take(&mut self.planned);
        self.ahead.push(one, &mut planned);
        for one in planned.drain(..) {
            self.take(out, &one, head)?;
        }
        self.planned = planned;
        Ok(())
    }

    /// Runs a move.
    fn take(
        &mut self,
        out: &mut String,
        planned: &Planned,
        head: (&Note<'_>, &Template),
    ) -> Result<(), PostError> {
        let from = self.course.place();
        self.places.clear();
        self.course.go(planned, &mut self.places)?;
        let Some(to) = self.course.place() else { return Ok(()) };
        let asked = if planned.part.is_none() { self.asked.pop_front() } else { None };
        let Some(from) = from else {
            let begin = out.len();
            let writer = ProgramWriter::new(
                out,
                &self.kinematics,
                (head.0, &self.style, head.1),
                (&to.0, &to.1),
            )?;
            let pace = Pace::new(&self.kinematics, &self.options, to.0)?;
            let text = out.get(begin..).unwrap_or_default();
            let read = ReadBack::new(&self.kinematics, &self.style, (text, &to.1));
            let read_back = self.understood(read)?;
            let waiting = [0.0; 3];
            self.running = Some(Running { pace, writer, read_back, at: to, block: to, waiting });
            return Ok(());
        };
        if let Some(asked) = asked {
            self.tell_before(&from, &to, asked);
        }
        if let (Some(Part::Out), Some(place)) = (planned.part, self.places.first_mut()) {
            place.goes_out = true;
        }
        let Some(running) = &mut self.running else { return Ok(()) };
        for place in &self.places {
            running.pace.push(place, &mut self.timed)?;
        }
        self.write(out)
    }

    /// Ends the program.
    ///
    /// # Errors
    ///
    /// [`PostError`]; [`PostError::Empty`] where there was no move.
    pub fn finish(
        mut self,
        out: &mut String,
        head: (&Note<'_>, &Template),
    ) -> Result<PostReport, PostError> {
        let mut filtered = std::mem::take(&mut self.filtered);
        self.filter.finish(&mut filtered)?;
        for one in &filtered {
            self.look(out, one, head)?;
        }
        let mut planned = Vec::new();
        self.ahead.finish(&mut planned);
        for one in &planned {
            self.take(out, one, head)?;
        }
        let Some(running) = self.running.take() else { return Err(PostError::Empty) };
        let Running { pace, writer, read_back, at, block, waiting } = running;
        pace.finish(&mut self.timed)?;
        // The rest is written by the same code, with a planner that has nothing left.
        let rest = Pace::new(&self.kinematics, &self.options, at.0)?;
        self.running = Some(Running { pace: rest, writer, read_back, at, block, waiting });
        self.write(out)?;
        let Some(running) = self.running.take() else { return Err(PostError::Empty) };
        self.before.rapid();
        self.after.rapid();
        let begin = out.len();
        self.report.blocks[1] = running.writer.finish(out);
        if let Some(read) = running.read_back {
            let ended = read.end(out.get(begin..).unwrap_or_default());
            self.understood(ended)?;
        }
        self.report.seconds = [self.before.seconds, self.after.seconds];
        self.report.model_seconds = [self.before.model, self.after.model];
        self.report.ratios_before = self.before.gauge.worst;
        self.report.ratios_after = self.after.gauge.worst;
        let [course, filter] = [self.course.strayed, self.filter.strayed()];
        self.report.unwound = std::mem::take(&mut self.ahead.unwound);
        self.report.strayed = [course[0] + filter[0], course[1] + filter[1]];
        Ok(self.report)
    }

    /// Report so far.
    pub fn moves(&self) -> usize {
        self.report.blocks[0]
    }

    /// What reading back gives, if the reader understands the text; if not, that is noted.
    fn understood<T>(&mut self, read: Result<T, ReadBackError>) -> Result<Option<T>, PostError> {
        match read {
            Ok(read) => Ok(Some(read)),
            Err(ReadBackError::Unread(faults)) => {
                self.report.unread = faults.into_iter().next();
                Ok(None)
            }
            Err(error) => Err(error.into()),
        }
    }

    fn capped(&self, pace: PostPace) -> PostPace {
        match (pace, self.options.max_feed) {
            (PostPace::Rapid, _) | (_, None) => pace,
            (_, Some(most)) => PostPace::Feed(most),
        }
    }

    /// Takes down what the input asks for.
    fn tell_before(
        &mut self,
        from: &(AxisVector, ToolPose),
        to: &(AxisVector, ToolPose),
        asked: PostPace,
    ) {
        self.report.blocks[0] += 1;
        if asked == PostPace::Rapid {
            return self.before.rapid();
        }
        let travel = to.0 - from.0;
        let length = (to.1.tip - from.1.tip).norm();
        let told = match asked {
            PostPace::Feed(feed) => length / feed,
            PostPace::Seconds(seconds) => seconds,
            PostPace::Rapid => 0.0,
        };
        let seconds = if told > 0.0 { told } else { self.before.gauge.least(&travel) };
        self.report.length += length;
        self.before.cutting = true;
        self.before.gauge.push(&travel, seconds);
        self.before.seconds += seconds;
        self.before.model += self.model(from, to, seconds);
    }

    fn model(
        &self,
        from: &(AxisVector, ToolPose),
        to: &(AxisVector, ToolPose),
        seconds: f64,
    ) -> f64 {
        let mut words = to.0 - from.0;
        if self.style.dialect.coordinates() == Coordinates::Tip {
            let tip = self.kinematics.setup().rotation * (to.1.tip - from.1.tip);
            words.fixed_rows_mut::<3>(0).copy_from(&tip);
        }
        ControlModel::new(self.kinematics.machine()).seconds(&words, seconds)
    }

    /// Writes the blocks whose time is known.
    fn write(&mut self, out: &mut String) -> Result<(), PostError> {
        let Some(mut running) = self.running.take() else { return Ok(()) };
        let timed = std::mem::take(&mut self.timed);
        for one in &timed {
            self.tell_after(&running, one);
            let place = &one.place;
            running.at = (place.q, place.pose);
            let [seconds, length, turn] = &mut running.waiting;
            *seconds += one.seconds;
            *length += place.tip;
            *turn += place.turn;
            if !place.block {
                continue;
            }
            let pace = match place.least {
                None => BlockPace::Rapid,
                Some(_) => BlockPace::Timed { seconds: *seconds, length: *length, turn: *turn },
            };
            if place.least.is_some() {
                let time = *seconds;
                self.after.model += self.model(&running.block, &running.at, time);
                let words = &self.style.axes;
                let coordinates = self.style.dialect.coordinates();
                let off = rounding(&self.kinematics, &place.q, words, coordinates, 0.0);
                self.report.rounding = self.report.rounding.max(off);
            }
            let begin = out.len();
            if place.goes_out {
                running.writer.comment(out, "out of the cut, rotaries go round, and back");
            }
            running.writer.block(out, (&place.q, &place.pose), pace)?;
            if let Some(mut read) = running.read_back.take() {
                let text = out.get(begin..).unwrap_or_default();
                let done = read.block(text, (&place.q, &place.pose), pace);
                running.read_back = self.understood(done)?.map(|()| read);
            }
            running.waiting = [0.0; 3];
            running.block = running.at;
        }
        self.timed = timed;
        self.timed.clear();
        self.running = Some(running);
        Ok(())
    }

    /// Takes down what the output does.
    fn tell_after(&mut self, running: &Running, one: &Timed) {
        if one.place.least.is_none() {
            self.report.rapid_seconds += one.seconds;
            return self.after.rapid();
        }
        self.after.cutting = true;
        self.after.gauge.push(&(one.place.q - running.at.0), one.seconds);
        self.after.seconds += one.seconds;
    }
}

/// The inverse, where rotaries are chosen here: not for a program that is for the machine already, nor for a control that
/// is told vectors.
fn chooses(
    kinematics: &Kinematics,
    source: &PostSource,
    style: &Style,
) -> Result<Option<Inverse>, PostError> {
    let own = matches!(source, PostSource::Program(of) if **of == *kinematics);
    let vectors = style.dialect.is_vector() || style.dialect == Dialect::Apt;
    if own || vectors {
        return Ok(None);
    }
    Inverse::new(kinematics).map(Some).map_err(|error| PostError::reach(0, error))
}

/// How a dialect's control moves between blocks, as the machine file says where it speaks of that dialect.
pub fn control_of(kinematics: &Kinematics, dialect: Dialect) -> Control {
    let told = &kinematics.machine().dialect;
    let own = Dialect::from_name(&told.name) == Some(dialect);
    match dialect {
        Dialect::G93 => Control::Axes,
        Dialect::Apt => Control::GreatCircle,
        of if of.is_vector() => Control::GreatCircle,
        _ if own && told.interpolation == Interpolation::GreatCircle => Control::GreatCircle,
        _ => Control::RotaryLinear,
    }
}
