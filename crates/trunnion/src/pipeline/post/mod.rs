//! Cutter locations or a program to a program for a machine, move by move, with new feeds.
//!
//! ```text
//! replay  steps of a program to moves
//! filter  moves smoothed, or fewer of them
//! choice  where smoothing is quicker
//! ahead   which way round the rotaries go, so that cuts stay inside travel
//! course  moves to places on the machine, close enough for its control
//! written ways and times as far as words can say them
//! timer   times of places: pace along a smooth path, classic block after block, window by window
//! gauge   what it asks of the axes, what it takes on a control without look-ahead
//! running the program as it is written and read back
//! ```
//!
//! Memory is that of the window, however long the input is.

mod ahead;
mod choice;
mod classic;
mod corner;
mod course;
mod error;
mod filter;
mod gauge;
mod leg;
mod options;
mod pace;
mod replay;
mod running;
mod timer;
mod written;

pub use choice::PostChoice;
pub use error::PostError;
pub use filter::PostFilter;
pub use options::{
    POST_WINDOW, PostMethod, PostMove, PostOptions, PostPace, PostReport, PostSource,
};
pub use replay::{Left, ProgramMoves};

use crate::blocks::Control;
use crate::inverse::Inverse;
use crate::machine::{Interpolation, Kinematics};
use crate::nc::write::{Dialect, Note, Style, Template};
use crate::types::{AxisVector, ToolPose};
use ahead::{Ahead, Part, Planned};
use choice::{Choice, Unit};
use course::Course;
use filter::Filter;
use leg::Place;
use pace::Timed;
use running::{Running, Tally};
use std::collections::VecDeque;

/// Posts moves one by one.
#[derive(Debug)]
pub struct Poster {
    kinematics: Kinematics,
    options: PostOptions,
    style: Style,
    course: Course,
    source: PostSource,
    filter: Filter,
    filtered: Vec<PostMove>,
    /// Moves of which is not decided yet whether they are smoothed.
    unit: Unit,
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
        let kind = (options.filter, options.control);
        let share = options.filter.left(options.control);
        let rest = PostOptions { tolerance: options.tolerance.map(|of| share * of), ..*options };
        Ok(Self {
            kinematics: kinematics.clone(),
            options: *options,
            style: *style,
            filter: Filter::new(kind, source.clone(), options.tolerance),
            filtered: Vec::new(),
            unit: Unit::default(),
            ahead: Ahead::new(chooses(kinematics, &source, style)?, options.unwind),
            planned: Vec::new(),
            asked: VecDeque::new(),
            read: None,
            course: Course::new(kinematics, source.clone(), &rest)?,
            source,
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
        if self.options.filter == PostFilter::Smooth {
            if self.unit.ends_before(&one) {
                self.decide(out, head)?;
            }
            self.unit.push(one);
            return Ok(());
        }
        let mut filtered = std::mem::take(&mut self.filtered);
        self.filter.push(&one, &mut filtered)?;
        for one in filtered.drain(..) {
            self.look(out, &one, head)?;
        }
        self.filtered = filtered;
        Ok(())
    }

    /// Posts moves the way that is quickest.
    fn decide(&mut self, out: &mut String, head: (&Note<'_>, &Template)) -> Result<(), PostError> {
        if self.unit.is_empty() {
            return Ok(());
        }
        let choice = Choice {
            kinematics: &self.kinematics,
            source: &self.source,
            options: &self.options,
            style: &self.style,
            ahead: &self.ahead,
            course: &self.course,
        };
        let mut told = self.report.smoothing.unwrap_or_default();
        let best = choice.quickest(&self.unit, &mut told)?;
        self.report.smoothing = Some(told);
        self.unit.clear();
        (self.ahead, self.course) = (best.ahead, best.course);
        self.stray(best.strayed);
        if let Some(start) = best.start {
            self.begin(out, start, head)?;
        }
        self.run(out, &best.places)
    }

    fn stray(&mut self, by: [f64; 2]) {
        for (most, by) in self.report.strayed.iter_mut().zip(by) {
            *most = most.max(by);
        }
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
        let Some(from) = from else { return self.begin(out, to, head) };
        if let Some(asked) = asked {
            self.tell_before(&from, &to, asked);
        }
        if let (Some(Part::Out), Some(place)) = (planned.part, self.places.first_mut()) {
            place.goes_out = true;
        }
        let places = std::mem::take(&mut self.places);
        self.run(out, &places)?;
        self.places = places;
        Ok(())
    }

    /// Goes on with another tool: `kinematics` has its length, `source` that which the input assumes. The next move
    /// only says where it starts, and writes the change from note and template.
    ///
    /// # Errors
    ///
    /// [`PostError`].
    pub fn change_tool(
        &mut self,
        out: &mut String,
        (kinematics, source): (&Kinematics, PostSource),
        head: (&Note<'_>, &Template),
    ) -> Result<(), PostError> {
        self.settle(out, head)?;
        let fresh = Self::new(kinematics, source, &self.options, &self.style)?;
        self.report.unwound.append(&mut self.ahead.unwound);
        let Self { ahead, course, filter, source, kinematics, .. } = fresh;
        (self.ahead, self.course, self.filter) = (ahead, course, filter);
        (self.kinematics, self.source) = (kinematics, source);
        (self.unit, self.read) = (Unit::default(), None);
        Ok(())
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
        self.settle(out, head)?;
        let Some(running) = self.running.take() else { return Err(PostError::Empty) };
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
        self.report.unwound.append(&mut self.ahead.unwound);
        Ok(self.report)
    }

    /// Writes all that is held back; the machine rests.
    fn settle(&mut self, out: &mut String, head: (&Note<'_>, &Template)) -> Result<(), PostError> {
        self.decide(out, head)?;
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
        self.rest(out)?;
        if self.options.filter != PostFilter::Smooth {
            let [course, filter] = [self.course.strayed, self.filter.strayed()];
            self.stray([course[0] + filter[0], course[1] + filter[1]]);
        }
        Ok(())
    }

    /// Report so far.
    pub fn moves(&self) -> usize {
        self.report.blocks[0]
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
