//! Programs and cutter locations as moves, from the start as often as it takes.

use super::VerifyError;
use super::replay::{Block, Control, Course, Mover, Segment, apply};
use super::vectors::{self, Known};
use crate::nc::read::{Arc, ClFile, ClMotion, Move, Pace, ProgramSource, Step, Turning, Way};
use crate::types::{AxisVector, ToolPose};

/// All that moves the tool, from the start as often as it is asked for.
pub(super) struct Run<'a> {
    pub(super) mover: Mover<'a>,
    source: Source<'a>,
    /// How far chords of arcs may be off \[mm\].
    tolerance: f64,
}

/// Where moves come from.
enum Source<'a> {
    Program(&'a dyn ProgramSource),
    Locations(&'a ClFile),
}

/// Moves one by one.
pub(super) type Segments<'a> = Box<dyn Iterator<Item = Result<Segment, VerifyError>> + 'a>;

impl<'a> Run<'a> {
    /// A program from the machine's home position; arcs in chords within `tolerance` \[mm\].
    pub(super) fn program(
        control: &'a Control<'a>,
        program: &'a dyn ProgramSource,
        tolerance: f64,
    ) -> Self {
        let (mover, source) = (Mover::Machine(control), Source::Program(program));
        Self { mover, source, tolerance }
    }

    /// Cutter locations: straight, arcs and holes in chords within `tolerance` \[mm\]. Rapid moves take no
    /// time: nothing is known of a machine.
    pub(super) fn locations(file: &'a ClFile, tolerance: f64) -> Self {
        Self { mover: Mover::Locations, source: Source::Locations(file), tolerance }
    }

    /// The moves, from the start.
    pub(super) fn segments(&self) -> Segments<'_> {
        let tolerance = self.tolerance;
        match (&self.mover, &self.source) {
            (Mover::Machine(control), Source::Program(program)) => {
                let at = Known::Axes(control.real().machine().home());
                Box::new(Replay { control, steps: program.steps(), at, arc: None, tolerance })
            }
            (_, Source::Locations(file)) => Box::new(locations(file, tolerance)),
            (Mover::Locations, Source::Program(_)) => Box::new(std::iter::empty()),
        }
    }

    /// About how many moves there are.
    pub(super) fn steps(&self) -> usize {
        match &self.source {
            Source::Program(program) => program.count(),
            Source::Locations(file) => file.records.len(),
        }
    }
}

/// A program being run, move by move.
struct Replay<'a> {
    control: &'a Control<'a>,
    steps: Box<dyn Iterator<Item = Step> + 'a>,
    at: Known,
    /// An arc on the way.
    arc: Option<OnArc>,
    /// How far chords may be off \[mm\].
    tolerance: f64,
}

/// An arc of which some chords were run.
struct OnArc {
    step: Move,
    arc: Arc,
    /// Axes so far.
    q: AxisVector,
    /// Words where it begins and ends.
    ends: [AxisVector; 2],
    /// Chords run, and in all.
    done: u32,
    parts: u32,
    /// Time of all of it \[s\].
    duration: f64,
}

/// Chords of one arc; more only at a radius of kilometres.
const MOST_PARTS: u32 = 1_000_000;

impl Replay<'_> {
    /// What a step does; `None` if it moves nothing and takes no time, or is an arc to be run.
    fn segment(&mut self, step: &Step) -> Result<Option<Segment>, VerifyError> {
        match step {
            Step::Dwell { line, seconds } => Ok(Some(self.rest(*line, *seconds))),
            // The plane is refused where a move names it.
            Step::Tool { .. } | Step::Spindle { .. } | Step::Plane(_) | Step::Words { .. } => {
                Ok(None)
            }
            Step::Offset(offset) => {
                let (line, what) = (offset.line, "a work offset written by the program");
                Err(VerifyError::Special { line, what })
            }
            Step::Move(step) => {
                let plain = Move { way: Way::Line, turning: Turning::Rotary, axis: None, ..*step };
                if let Some(what) = plain.special() {
                    return Err(VerifyError::Special { line: step.line, what });
                }
                match (step.way, self.at, step.axis) {
                    (Way::Line, Known::Axes(q), None) => self.straight(&q, step, None).map(Some),
                    (Way::Arc(arc), Known::Axes(q), None) => {
                        self.arc = Some(self.enter(&q, step, arc)?);
                        Ok(None)
                    }
                    (Way::Line, ..) => self.by_vectors(step).map(Some),
                    (Way::Arc(_), ..) => {
                        let what = "an arc between tool vectors";
                        Err(VerifyError::Special { line: step.line, what })
                    }
                }
            }
        }
    }

    /// A stretch of time in which nothing moves.
    fn rest(&self, line: u32, duration: f64) -> Segment {
        let joints = match self.at {
            Known::Axes(q) => [q; 2],
            _ => [AxisVector::zeros(); 2],
        };
        let block = Block::of_one(duration);
        Segment { line, joints, course: Course::Rest, duration, block, rapid: false }
    }

    /// A straight move with a tool vector, or after one.
    fn by_vectors(&mut self, step: &Move) -> Result<Segment, VerifyError> {
        let (to, ends) = self.at.after(self.control, step)?;
        self.at = to;
        let rapid = step.pace == Pace::Rapid;
        let (course, duration) = match ends {
            Some(ends) => (Course::Circle { ends }, vectors::duration(&ends, step.pace)),
            None if rapid => (Course::Unknown, 0.0),
            None => return Err(VerifyError::Unfollowed { line: step.line }),
        };
        let joints = [AxisVector::zeros(); 2];
        let block = Block::of_one(duration);
        Ok(Segment { line: step.line, joints, course, duration, block, rapid })
    }

    /// A straight move, or a chord of a block.
    fn straight(
        &mut self,
        q: &AxisVector,
        step: &Move,
        block: Option<Block>,
    ) -> Result<Segment, VerifyError> {
        let (to, course) = self.control.target(q, step)?;
        if !to.iter().all(|value| value.is_finite()) {
            return Err(VerifyError::LinearAxes);
        }
        self.at = Known::Axes(to);
        let joints = [*q, to];
        let duration = duration(&joints, &course, step.pace, &self.control.rapid());
        let block = block.unwrap_or(Block::of_one(duration));
        let rapid = step.pace == Pace::Rapid;
        Ok(Segment { line: step.line, joints, course, duration, block, rapid })
    }

    /// An arc before its first chord.
    fn enter(&self, q: &AxisVector, step: &Move, arc: Arc) -> Result<OnArc, VerifyError> {
        let from = self.control.words(q, (step.frame, step.line))?;
        let to = apply(from, step, &AxisVector::zeros());
        let parts = arc.parts(self.tolerance);
        if parts > MOST_PARTS {
            return Err(VerifyError::TurnsTooFar { line: step.line });
        }
        let across: f64 =
            (0..3).filter(|axis| !arc.plane.contains(axis)).map(|axis| to[axis] - from[axis]).sum();
        let duration = match step.pace {
            Pace::Inverse { seconds } => seconds,
            Pace::PerMinute { speed } => (arc.radius() * arc.sweep).hypot(across) / speed,
            Pace::Rapid => {
                let what = "an arc at rapid speed";
                return Err(VerifyError::Special { line: step.line, what });
            }
        };
        Ok(OnArc { step: *step, arc, q: *q, ends: [from, to], done: 0, parts, duration })
    }

    /// The next chord of an arc.
    fn chord(&mut self, on: &mut OnArc) -> Result<Segment, VerifyError> {
        let OnArc { step, arc, q, ends: [from, to], parts, duration, .. } = *on;
        on.done += 1;
        let share = f64::from(on.done) / f64::from(parts);
        let mut words = to;
        if on.done < parts {
            words = from + (to - from) * share;
            for (axis, by) in arc.plane.into_iter().zip(arc.at(share)) {
                words[axis] = from[axis] + by;
            }
        }
        let step = Move {
            words: [0, 1, 2, 3, 4].map(|axis| Some(words[axis])),
            incremental: false,
            way: Way::Line,
            pace: Pace::Inverse { seconds: duration / f64::from(parts) },
            ..step
        };
        let (begins, ends) = (on.done == 1, on.done == parts);
        let sweep = arc.sweep.abs();
        let segment = self.straight(&q, &step, Some(Block { duration, sweep, begins, ends }))?;
        [_, on.q] = segment.joints;
        Ok(segment)
    }
}

impl Iterator for Replay<'_> {
    type Item = Result<Segment, VerifyError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let segment = if let Some(mut arc) = self.arc.take() {
                let chord = self.chord(&mut arc);
                self.arc = Some(arc).filter(|arc| arc.done < arc.parts);
                chord.map(Some)
            } else {
                let step = self.steps.next()?;
                self.segment(&step)
            };
            match segment {
                Ok(None) => {}
                Ok(Some(segment)) => return Some(Ok(segment)),
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

/// Time of a move \[s\].
fn duration(joints: &[AxisVector; 2], course: &Course, pace: Pace, rapid: &AxisVector) -> f64 {
    let change = joints[1] - joints[0];
    match pace {
        Pace::Inverse { seconds } => seconds,
        Pace::Rapid => change.component_div(rapid).amax(),
        Pace::PerMinute { speed } => {
            let length = match course {
                Course::Tip { ends: [from, to], .. } => (to - from).norm(),
                Course::Circle { ends: [from, to] } => (to.tip - from.tip).norm(),
                _ => change.fixed_rows::<3>(0).norm(),
            };
            let degrees = change.fixed_rows::<2>(3).norm().to_degrees();
            if length > 0.0 { length / speed } else { degrees / speed }
        }
    }
}

/// Runs through cutter locations.
fn locations(
    file: &ClFile,
    tolerance: f64,
) -> impl Iterator<Item = Result<Segment, VerifyError>> + '_ {
    let mut before: Option<ToolPose> = None;
    file.records.iter().flat_map(move |record| {
        let parts = record.straight(before.as_ref(), tolerance).into_iter();
        let segments = parts.filter_map(|part| {
            let ends = [before.replace(part.pose)?, part.pose];
            let (duration, rapid) = match part.motion {
                ClMotion::Rapid => (0.0, true),
                ClMotion::Feed(speed) => ((ends[1].tip - ends[0].tip).norm() / speed, false),
            };
            let joints = [AxisVector::zeros(); 2];
            let course = Course::Circle { ends };
            let block = Block::of_one(duration);
            Some(Ok(Segment { line: part.line, joints, course, duration, block, rapid }))
        });
        segments.collect::<Vec<_>>()
    })
}
