//! Segments of a program or CL file, from its start as often as needed.

use crate::nc::control::{
    ArcChords, BlockFrames, OffsetReading, STANDING, ToolLength, UnknownOffset, WordFrame,
    WorkOffsets, end_words, path_length, read_words,
};
use crate::nc::read::{
    Arc, ClMotion, ClSource, Frame, Move, Offset, OffsetKind, Pace, ProgramSource, Smoothing, Step,
    Way,
};
use crate::types::{AXES, AxisVector, ToolPose};
use crate::verify::error::VerifyError;
use crate::verify::replay::control::Control;
use crate::verify::replay::controls::{self, Controls, ToolStart};
use crate::verify::replay::mover::Mover;
use crate::verify::replay::orient::{Choices, DirectionSource, RotaryBranch, Turned};
use crate::verify::replay::position::Known;
use crate::verify::replay::segment::{Block, BlockTime, Course, FeedLength, Segment};
use crate::verify::replay::tables::{Changes, Tables, Tool};

/// All that moves the tool, from the start as often as it is asked for.
pub(crate) struct Run<'a> {
    pub(crate) mover: Mover<'a>,
    source: Source<'a>,
    /// Largest distance of chords from arcs \[mm\].
    tolerance: f64,
}

/// Origin of the moves.
enum Source<'a> {
    Program(&'a dyn ProgramSource, WorkOffsets),
    /// Cutter locations, and the first one of each tool.
    Locations(&'a dyn ClSource, Vec<ToolStart>),
}

/// Moves one by one.
pub(crate) type Segments<'a> = Box<dyn Iterator<Item = Result<Segment, VerifyError>> + 'a>;

impl<'a> Run<'a> {
    /// A program from the machine's home position; arcs in chords within `tolerance` \[mm\].
    pub(crate) fn program(
        controls: &'a Controls,
        program: &'a dyn ProgramSource,
        tables: &Tables<'_>,
        tolerance: f64,
    ) -> Self {
        let offsets = controls::work_offsets(controls.first(), tables);
        let (mover, source) = (Mover::Machine(controls), Source::Program(program, offsets));
        Self { mover, source, tolerance }
    }

    /// Cutter locations: straight, arcs and holes in chords within `tolerance` \[mm\]. Rapid moves take no
    /// time: nothing is known of a machine.
    pub(crate) fn locations(
        file: &'a dyn ClSource,
        table: &[Tool<'_>],
        tolerance: f64,
    ) -> Result<Self, VerifyError> {
        let places = controls::tool_starts(file, table)?;
        let source = Source::Locations(file, places);
        Ok(Self { mover: Mover::Locations, source, tolerance })
    }

    /// The moves, from the start.
    pub(crate) fn segments(&self) -> Segments<'_> {
        match &self.source {
            Source::Locations(file, places) => Box::new(locations(*file, places, self.tolerance)),
            Source::Program(..) => Box::new(self.replay().into_iter().flatten()),
        }
    }

    /// A program from its start; `None` for cutter locations.
    pub(crate) fn replay(&self) -> Option<Replay<'_>> {
        let (Mover::Machine(controls), Source::Program(program, offsets)) =
            (&self.mover, &self.source)
        else {
            return None;
        };
        Some(Replay {
            controls,
            steps: program.steps(),
            at: Known::Axes(controls.first().real().machine().home()),
            moved: false,
            tool: if controls.are_several() { None } else { Some(0) },
            frames: BlockFrames { offsets: offsets.clone(), plane: None },
            length: Some(ToolLength::Cancelled),
            arc: None,
            tolerance: self.tolerance,
            branch: None,
            choices: Choices::default(),
            changes: Changes { count: 0, line: 0, unmeasured: 0, first: None },
            smoothing: None,
        })
    }

    /// About how many moves there are.
    pub(crate) fn steps(&self) -> usize {
        match &self.source {
            Source::Program(program, _) => program.count(),
            Source::Locations(file, _) => file.count(),
        }
    }
}

/// A program being run, move by move.
pub(crate) struct Replay<'a> {
    controls: &'a Controls,
    steps: Box<dyn Iterator<Item = Step> + 'a>,
    at: Known,
    /// True once anything moved.
    moved: bool,
    /// Place of the tool in the table; `None` before the first of several.
    tool: Option<usize>,
    /// Work offsets, and the last tilted plane.
    frames: BlockFrames,
    /// Compensation of the last block; `None` under tool-centre-point control.
    length: Option<ToolLength>,
    /// An arc on the way.
    arc: Option<OnArc>,
    /// Largest distance of chords from arcs \[mm\].
    tolerance: f64,
    /// Solution of the last vector.
    branch: Option<RotaryBranch>,
    /// Choices left to the control so far.
    pub(crate) choices: Choices,
    /// Tool changes so far, with what they left unknown.
    pub(crate) changes: Changes,
    /// Distance from the path that the control may keep now; `None`: no word was about it.
    pub(crate) smoothing: Option<Smoothing>,
}

/// An arc of which some chords were run.
struct OnArc {
    chords: ArcChords,
    frame: WordFrame,
    /// Axes so far.
    q: AxisVector,
    /// Angle run through \[rad\].
    sweep: f64,
    /// Time of all of it \[s\].
    duration: f64,
    /// Origin of that time.
    time: BlockTime,
}

/// Chords of one arc; more only at a radius of kilometres.
const MOST_PARTS: u32 = 1_000_000;

impl<'a> Replay<'a> {
    fn control(&self) -> &'a Control {
        self.controls.of(self.tool.unwrap_or(0))
    }

    /// Runs a step; `None` if it moves nothing and takes no time, or is an arc to be run.
    fn segment(&mut self, step: &Step) -> Result<Option<Segment>, VerifyError> {
        match step {
            Step::Dwell { line, seconds } => return Ok(Some(self.rest(*line, *seconds))),
            Step::Tool { line, number } => self.change(*line, *number)?,
            Step::Plane(plane) => self.frames.plane = Some(*plane),
            Step::Smoothing { smoothing, .. } => self.smoothing = Some(*smoothing),
            // State beside the motion; `verify::state` follows it.
            Step::Spindle { .. }
            | Step::LengthEntry { .. }
            | Step::Probe { .. }
            | Step::Words { .. }
            | Step::Offset(Offset { kind: OffsetKind::Standing, .. }) => {}
            Step::Offset(offset) => self.write(offset)?,
            Step::Move(step) => return self.go(step),
        }
        Ok(None)
    }

    fn go(&mut self, step: &Move) -> Result<Option<Segment>, VerifyError> {
        let refused = |what| Err(VerifyError::Special { line: step.line, what });
        if step.sixth.is_some() {
            return refused("a sixth axis");
        }
        let frame = self.frame_of(step)?;
        // `G10 L20` reads the position with the compensation of the last block in a work offset.
        self.length = match step.frame {
            Frame::Machine => self.length,
            Frame::Work { tcp: true, .. } => None,
            Frame::Work { tcp: false, .. } => ToolLength::in_frame(&step.frame),
        };
        if step.axis.is_some() && matches!(frame, WordFrame::Axes(_)) && step.words != [None; AXES]
        {
            return refused("a tool vector without tool-centre-point control");
        }
        self.moved = true;
        match (step.way, self.at) {
            (Way::Arc(_), _) if step.axis.is_some() => refused("an arc between tool vectors"),
            (Way::Arc(arc), Known::Axes(q)) => {
                self.arc = Some(self.enter(&q, step, frame, arc)?);
                Ok(None)
            }
            (Way::Line, Known::Axes(q)) => self.straight(&q, step, &frame, None).map(Some),
            (Way::Line, Known::Part(part)) if step.pace == Pace::Rapid => {
                let (at, turned) = part.after(self.control(), step, &frame)?;
                self.at = at;
                self.note(step, &frame, turned.as_ref());
                Ok(Some(self.unknown(step.line)))
            }
            (_, Known::Part(_)) => Err(VerifyError::Unfollowed { line: step.line }),
        }
    }

    /// A tool goes into the spindle. What the change does to X, Y and Z is not known, unless nothing moved yet.
    fn change(&mut self, line: u32, number: u32) -> Result<(), VerifyError> {
        let place = self.controls.position(line, number)?;
        // The same tool again, or a tool before the first move, changes no position.
        if self.tool.replace(place) == Some(place) || !self.moved {
            return Ok(());
        }
        self.changes.count += 1;
        if self.changes.count == 1 {
            self.changes.line = line;
        }
        self.at = self.at.changed(self.control());
        Ok(())
    }

    /// The program writes a work offset.
    fn write(&mut self, written: &Offset) -> Result<(), VerifyError> {
        let reading = match self.at {
            Known::Axes(axes) => {
                let tool_length = self.control().tool_length();
                OffsetReading::Axes { axes, length: self.length, tool_length }
            }
            Known::Part(_) => OffsetReading::Unknown,
        };
        let refused = |fault| VerifyError::Offset { line: written.line, fault };
        let offset = self.frames.offsets.written(written, &reading).map_err(refused)?;
        let in_table = self.controls.first().in_table(&offset.origin);
        self.frames.offsets.set(offset, in_table);
        Ok(())
    }

    /// Returns the coordinates that the words of a block are.
    fn frame_of(&self, step: &Move) -> Result<WordFrame, VerifyError> {
        let unknown =
            |of: UnknownOffset| VerifyError::WorkOffset { line: step.line, number: of.number };
        self.frames.frame_of(step, self.control().tool_length()).map_err(unknown)
    }

    /// A stretch of time in which nothing moves.
    fn rest(&self, line: u32, duration: f64) -> Segment {
        let joints = match self.at {
            Known::Axes(q) => [q; 2],
            Known::Part(_) => [AxisVector::zeros(); 2],
        };
        let block = Block::of_one(duration);
        let tool = self.tool.unwrap_or(0);
        Segment { line, tool, joints, course: Course::Rest, duration, block, rapid: false }
    }

    /// A rapid move from where nobody knows, or of an unknown tool.
    fn unknown(&mut self, line: u32) -> Segment {
        self.changes.unmeasured += 1;
        self.changes.first.get_or_insert(line);
        let joints = [AxisVector::zeros(); 2];
        let (tool, block) = (self.tool.unwrap_or(0), Block::of_one(0.0));
        Segment { line, tool, joints, course: Course::Unknown, duration: 0.0, block, rapid: true }
    }

    /// Notes which rotaries were taken for a direction.
    fn note(&mut self, step: &Move, frame: &WordFrame, turned: Option<&Turned>) {
        let Some(turned) = turned else { return };
        // A turn to a plane has no words.
        let plane = matches!(frame, WordFrame::Axes(_)) || step.words == [None; AXES];
        let by = if plane { DirectionSource::Plane } else { DirectionSource::Vector };
        self.choices.note(step.line, by, turned, self.branch);
        self.branch = turned.branch.or(self.branch);
    }

    /// A straight move, or a chord of a block.
    fn straight(
        &mut self,
        q: &AxisVector,
        step: &Move,
        frame: &WordFrame,
        block: Option<Block>,
    ) -> Result<Segment, VerifyError> {
        let control = self.control();
        let (end, course) = control.target(q, step, frame)?;
        let to = end.axes;
        if !to.iter().all(|value| value.is_finite()) {
            return Err(VerifyError::LinearAxes);
        }
        self.note(step, frame, end.rotaries.as_ref());
        self.at = Known::Axes(to);
        let rapid = step.pace == Pace::Rapid;
        let Some(tool) = self.tool else {
            return if rapid {
                Ok(self.unknown(step.line))
            } else {
                Err(VerifyError::NoTool { line: step.line })
            };
        };
        let joints = [*q, to];
        // Chords of an arc share the time of their block.
        let length = feed_length(&joints, &course);
        let duration = match step.pace {
            Pace::Inverse { seconds } => seconds,
            Pace::Rapid => (joints[1] - joints[0]).component_div(&control.rapid()).amax(),
            Pace::PerMinute { speed } => length.value() / speed,
        };
        let time = block_time(step.pace, length);
        let block = block.unwrap_or(Block { time, ..Block::of_one(duration) });
        Ok(Segment { line: step.line, tool, joints, course, duration, block, rapid })
    }

    /// An arc before its first chord.
    fn enter(
        &self,
        q: &AxisVector,
        step: &Move,
        frame: WordFrame,
        arc: Arc,
    ) -> Result<OnArc, VerifyError> {
        let from = read_words(self.control(), q, &frame);
        let to = end_words(from, step, &AxisVector::zeros());
        let count = arc.parts(self.tolerance);
        if count > MOST_PARTS {
            return Err(VerifyError::TurnsTooFar { line: step.line });
        }
        let length = path_length(step, &from, &to);
        let duration = match step.pace {
            Pace::Inverse { seconds } => seconds,
            Pace::PerMinute { speed } => length / speed,
            Pace::Rapid => {
                let what = "an arc at rapid speed";
                return Err(VerifyError::Special { line: step.line, what });
            }
        };
        let time = block_time(step.pace, FeedLength::Linear(length));
        let chords = ArcChords::new(step, arc, [from, to], count);
        Ok(OnArc { chords, frame, q: *q, sweep: arc.sweep.abs(), duration, time })
    }

    /// The next chord of an arc; `None` behind the last.
    fn chord(&mut self, on: &mut OnArc) -> Result<Option<Segment>, VerifyError> {
        let begins = on.chords.is_at_start();
        let Some(chord) = on.chords.next() else { return Ok(None) };
        let seconds = on.duration / f64::from(on.chords.total());
        let step = Move { pace: Pace::Inverse { seconds }, ..chord };
        let OnArc { duration, sweep, time, .. } = *on;
        let block = Block { duration, sweep, begins, ends: on.chords.is_over(), time };
        let segment = self.straight(&on.q, &step, &on.frame, Some(block))?;
        [_, on.q] = segment.joints;
        Ok(Some(segment))
    }
}

impl Iterator for Replay<'_> {
    type Item = Result<Segment, VerifyError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let segment = if let Some(mut arc) = self.arc.take() {
                let chord = self.chord(&mut arc);
                self.arc = Some(arc).filter(|arc| !arc.chords.is_over());
                chord
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

/// Returns the length along which the feed of a move counts.
fn feed_length(joints: &[AxisVector; 2], course: &Course) -> FeedLength {
    let change = joints[1] - joints[0];
    // F counts along the tip or X, Y, Z, and in degrees along the rotaries where these stand.
    let length = match course {
        Course::Tip { ends: [from, to], .. } => (to - from).norm(),
        Course::Circle { ends: [from, to] } => (to.tip - from.tip).norm(),
        _ => change.fixed_rows::<3>(0).norm(),
    };
    if length > STANDING {
        return FeedLength::Linear(length);
    }
    FeedLength::Degrees(change.fixed_rows::<2>(3).norm().to_degrees())
}

fn block_time(pace: Pace, length: FeedLength) -> BlockTime {
    match pace {
        Pace::Rapid => BlockTime::Exact,
        Pace::Inverse { .. } => BlockTime::Stated,
        Pace::PerMinute { .. } => BlockTime::OverLength(length),
    }
}

/// Runs through cutter locations; those of each tool begin with its first location.
fn locations<'a>(
    file: &'a dyn ClSource,
    starts: &'a [ToolStart],
    tolerance: f64,
) -> impl Iterator<Item = Result<Segment, VerifyError>> + 'a {
    let mut before: Option<ToolPose> = None;
    let (mut next, mut tool) = (starts.iter().peekable(), 0);
    file.records().enumerate().flat_map(move |(index, record)| {
        if let Some(start) = next.next_if(|start| start.record <= index) {
            // The way from one tool to the next is the machine's own.
            (before, tool) = (before.filter(|_| tool == start.tool), start.tool);
        }
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
            Some(Ok(Segment { line: part.line, tool, joints, course, duration, block, rapid }))
        });
        segments.collect::<Vec<_>>()
    })
}
