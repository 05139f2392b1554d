//! Machine and tool over the time of a program, line by line.

use super::mover::Mover;
use super::segment::{Course, Segment};
use super::segments::Run;
use crate::math::angle::angle_between;
use crate::types::{AxisVector, ToolPose};
use crate::verify::error::VerifyError;
use crate::verify::input::CheckInput;

/// Machine and tool at one moment of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TimelinePoint {
    /// Time from the start of the program \[s\]; that of rapid moves is an estimate.
    pub time: f64,
    /// Line of the move that leads here.
    pub line: u32,
    /// Run at rapid speed.
    pub rapid: bool,
    /// First point of a move that does not begin where the last known one ended.
    pub apart: bool,
    /// Place of the tool in the table, 0 without one.
    pub tool: usize,
    /// Axes \[mm, rad\]; zeros for cutter locations, which have none.
    pub axes: AxisVector,
    /// Tool in the workpiece frame \[mm\].
    pub pose: ToolPose,
}

/// Distances between two points of a timeline at most, and the number of points that one move may exceed. Built by
/// struct update from [`TimelineOptions::for_pictures`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimelineOptions {
    /// Travel of the tip \[mm\].
    pub step: f64,
    /// Turn of the tool axis, and of a rotary axis \[rad\].
    pub turn: f64,
    /// Points in all. Beyond, moves have no points between their ends.
    pub most: usize,
}

impl TimelineOptions {
    /// Steps fine enough for a picture.
    pub fn for_pictures() -> Self {
        Self { step: 1.0, turn: 0.1, most: 400_000 }
    }
}

/// Points within one move at most.
const MOST: f64 = 1000.0;

/// Returns machine and tool over the time of a program, with the ends of every move that has a known path.
///
/// # Errors
///
/// [`VerifyError`].
pub fn timeline(
    input: &CheckInput<'_>,
    options: &TimelineOptions,
) -> Result<Vec<TimelinePoint>, VerifyError> {
    let controls = input.controls()?;
    let run = input.run(controls.as_ref(), options.step)?;
    let mut drawing = TimelineDrawing { options, points: Vec::new(), now: 0.0, apart: true };
    drawing.fill(&run)?;
    Ok(drawing.points)
}

/// Timeline that grows move by move.
struct TimelineDrawing<'a> {
    options: &'a TimelineOptions,
    points: Vec<TimelinePoint>,
    now: f64,
    apart: bool,
}

impl TimelineDrawing<'_> {
    fn fill(&mut self, run: &Run<'_>) -> Result<(), VerifyError> {
        for segment in run.segments() {
            let segment = &segment?;
            if segment.is_unknown() {
                self.apart = true;
            } else {
                self.add(&run.mover, segment)?;
            }
            self.now += segment.duration;
        }
        Ok(())
    }

    /// Adds the points of a move: both ends where nothing leads to its start, else those after it.
    fn add(&mut self, mover: &Mover<'_>, segment: &Segment) -> Result<(), VerifyError> {
        let rests = matches!(segment.course, Course::Rest);
        // A pause keeps the pose of the move before it.
        if rests && (segment.duration <= 0.0 || self.points.is_empty()) {
            return Ok(());
        }
        let [from, to] = [self.point(mover, segment, 0.0)?, self.point(mover, segment, 1.0)?];
        if std::mem::take(&mut self.apart) {
            self.points.push(TimelinePoint { apart: true, ..from });
        }
        let count =
            if self.points.len() < self.options.most { self.count(&from, &to) } else { 1.0 };
        let mut index = 1.0;
        while index < count {
            self.points.push(self.point(mover, segment, index / count)?);
            index += 1.0;
        }
        self.points.push(to);
        Ok(())
    }

    /// Returns the number of steps between two points.
    fn count(&self, from: &TimelinePoint, to: &TimelinePoint) -> f64 {
        let travel = (to.pose.tip - from.pose.tip).norm() / self.options.step;
        let rotaries = (to.axes - from.axes).fixed_rows::<2>(3).amax();
        let turn = angle_between(&from.pose.axis, &to.pose.axis).max(rotaries) / self.options.turn;
        travel.max(turn).ceil().clamp(1.0, MOST)
    }

    fn point(
        &self,
        mover: &Mover<'_>,
        segment: &Segment,
        t: f64,
    ) -> Result<TimelinePoint, VerifyError> {
        let Segment { line, rapid, tool, .. } = *segment;
        let axes = match mover {
            Mover::Machine(controls) => controls.of(tool).joints(segment, t)?,
            Mover::Locations => AxisVector::zeros(),
        };
        let pose = match (mover, &segment.course) {
            (Mover::Locations, Course::Rest) => {
                self.points.last().map(|point| point.pose).ok_or(VerifyError::NoMotion)?
            }
            _ => mover.pose(segment, t)?,
        };
        let time = self.now + t * segment.duration;
        Ok(TimelinePoint { time, line, rapid, apart: false, tool, axes, pose })
    }
}
