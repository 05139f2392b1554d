//! The program as it is written: places are timed, and every block is read back.

use super::course::Course;
use super::gauge::{ControlModel, Gauge, words};
use super::leg::Place;
use super::pace::Timed;
use super::timer::Timer;
use super::written::Written;
use super::{PostError, PostMethod, Poster};
use crate::machine::Kinematics;
use crate::nc::write::{BlockPace, Note, ProgramWriter, Template, rounding};
use crate::pipeline::read_back::{ReadBack, ReadBackError};
use crate::types::{AxisVector, ToolPose};

/// Times and counts of blocks, input or output.
#[derive(Debug)]
pub(super) struct Tally {
    pub(super) gauge: Gauge,
    pub(super) seconds: f64,
    pub(super) model: f64,
    pub(super) cutting: bool,
}

impl Tally {
    pub(super) fn new(kinematics: &Kinematics) -> Self {
        let gauge = Gauge::new(kinematics.machine());
        Self { gauge, seconds: 0.0, model: 0.0, cutting: false }
    }

    pub(super) fn rapid(&mut self) {
        if self.cutting {
            self.gauge.rest();
        }
        self.cutting = false;
    }
}

/// What exists from the first move on.
#[derive(Debug)]
pub(super) struct Running {
    pace: Timer,
    pub(super) writer: ProgramWriter,
    /// Reads what the writer writes; `None` once it does not understand it.
    pub(super) read_back: Option<ReadBack>,
    /// The last place whose time is known, and the last block end.
    at: (AxisVector, ToolPose),
    block: (AxisVector, ToolPose),
    /// Time, way and turn since the last block end, as they are written.
    waiting: [f64; 3],
    /// Largest travel of the axes from place to place since then ([`Course::fastest`]), and the share of the block.
    inside: Vec<(AxisVector, f64)>,
    words: Written,
}

/// Places that are timed before what is known is written.
const BATCH: usize = 1024;

impl Poster {
    /// Writes the head of the program, up to where it starts.
    pub(super) fn begin(
        &mut self,
        out: &mut String,
        to: (AxisVector, ToolPose),
        head: (&Note<'_>, &Template),
    ) -> Result<(), PostError> {
        if self.running.is_some() {
            return self.change(out, to, head);
        }
        let begin = out.len();
        let style = &self.style;
        let writer =
            ProgramWriter::new(out, &self.kinematics, (head.0, style, head.1), (&to.0, &to.1))?;
        let pace = Timer::new(&self.kinematics, &self.options, to.0)?;
        let text = out.get(begin..).unwrap_or_default();
        let read = ReadBack::new(&self.kinematics, style, (text, &to.1));
        let read_back = self.understood(read)?;
        let (waiting, inside) = ([0.0; 3], Vec::new());
        let words = Written::new(&self.kinematics, &self.style, &to);
        let (at, block) = (to, to);
        self.running = Some(Running { pace, writer, read_back, at, block, waiting, inside, words });
        Ok(())
    }

    /// Writes the change to another tool, up to where it starts.
    fn change(
        &mut self,
        out: &mut String,
        to: (AxisVector, ToolPose),
        head: (&Note<'_>, &Template),
    ) -> Result<(), PostError> {
        let Some(mut running) = self.running.take() else { return Ok(()) };
        let begin = out.len();
        running.writer.change_tool(out, &self.kinematics, head, (&to.0, &to.1))?;
        if let Some(mut read) = running.read_back.take() {
            let text = out.get(begin..).unwrap_or_default();
            let done = read.change_tool(&self.kinematics, (text, &to.1));
            running.read_back = self.understood(done)?.map(|()| read);
        }
        let pace = Timer::new(&self.kinematics, &self.options, to.0)?;
        let (waiting, inside) = ([0.0; 3], Vec::new());
        let words = Written::new(&self.kinematics, &self.style, &to);
        let (at, block) = (to, to);
        self.running = Some(Running { pace, at, block, waiting, inside, words, ..running });
        Ok(())
    }

    /// Times places, and writes the blocks whose time is known.
    pub(super) fn run(&mut self, out: &mut String, places: &[Place]) -> Result<(), PostError> {
        let mut places = places.to_vec();
        if let Some(running) = &mut self.running {
            let course = (self.options.method != PostMethod::Programmed).then_some(&self.course);
            running.words.take((&self.kinematics, &self.style), course, &mut places);
        }
        for batch in places.chunks(BATCH) {
            let Some(running) = &mut self.running else { return Ok(()) };
            for place in batch {
                running.pace.push(place, &mut self.timed)?;
            }
            self.write(out)?;
        }
        Ok(())
    }

    /// Ends the motion: all that is left is written.
    pub(super) fn rest(&mut self, out: &mut String) -> Result<(), PostError> {
        let Some(running) = self.running.take() else { return Ok(()) };
        let next = Timer::new(&self.kinematics, &self.options, running.at.0)?;
        running.pace.finish(&mut self.timed)?;
        self.running = Some(Running { pace: next, ..running });
        self.write(out)?;
        self.before.rapid();
        self.after.rapid();
        Ok(())
    }

    /// Time of a block on the control model \[s\].
    pub(super) fn model(
        &self,
        from: &(AxisVector, ToolPose),
        to: &(AxisVector, ToolPose),
        seconds: f64,
    ) -> f64 {
        let words = words(&self.kinematics, self.style.dialect, [from, to]);
        ControlModel::new(self.kinematics.machine()).seconds(&words, seconds)
    }

    /// What reading back gives, if the reader understands the text; if not, that is noted.
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
        let Some(mut running) = self.running.take() else { return Ok(()) };
        let timed = std::mem::take(&mut self.timed);
        for one in &timed {
            let place = &one.place;
            running.pass(one, &self.course);
            if !place.block {
                continue;
            }
            self.tell_after(&mut running, one);
            let [seconds, length, turn] = running.waiting;
            let pace = match place.least {
                None => BlockPace::Rapid,
                Some(_) => BlockPace::Timed { seconds, length, turn },
            };
            if place.least.is_some() {
                self.after.model += self.model(&running.block, &running.at, seconds);
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

    /// Takes down what a block of the output does.
    fn tell_after(&mut self, running: &mut Running, end: &Timed) {
        let inside = std::mem::take(&mut running.inside);
        let [seconds, ..] = running.waiting;
        if end.place.least.is_none() {
            self.report.rapid_seconds += seconds;
            return self.after.rapid();
        }
        self.after.cutting = true;
        self.after.seconds += seconds;
        self.after.gauge.push(&(end.place.q - running.block.0), seconds);
        let whole: f64 = inside.iter().map(|(_, size)| size).sum();
        for (travel, size) in &inside {
            self.after.gauge.inside(travel, seconds * size / whole);
        }
    }
}

impl Running {
    /// Passes a place.
    fn pass(&mut self, one: &Timed, course: &Course) {
        let place = &one.place;
        if place.least.is_some() {
            let fastest = course.fastest([(&self.at.0, &self.at.1), (&place.q, &place.pose)]);
            self.inside.push((fastest, place.size()));
        }
        self.at = (place.q, place.pose);
        let passed = [one.seconds, place.written[0], place.written[1]];
        self.waiting.iter_mut().zip(passed).for_each(|(sum, by)| *sum += by);
    }
}
