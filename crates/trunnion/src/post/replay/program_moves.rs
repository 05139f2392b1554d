//! Steps of a program as moves of the tool.

use super::bare_moves::BareMoves;
use super::control::PostControl;
use super::left_out::LeftOut;
use super::only_tool::{OnlyTool, ToolMotion};
use crate::blocks::BlockInterpolation;
use crate::machine::{FIRST_ROTARY, Kinematics, Setup};
use crate::nc::control::{
    ArcChords, BlockFrames, BlockStart, NumberedLength, WorkOffset, WorkOffsets, block_end,
    block_end_from, end_words, keeps_xy, path_length, read_words,
};
use crate::nc::read::{Coolant, Frame, Move, Offset, OffsetKind, Pace, Step, Turning, Way};
use crate::nc::write::{WriteError, work_offset};
use crate::post::error::{PostError, PostRemedy};
use crate::post::options::{PostMove, PostPace};
use crate::post::refusal::refused;
use crate::types::{AXES, AxisVector, ToolPose};
use nalgebra::Vector3;

/// Most chords of one arc.
const MOST_CHORDS: u32 = 65_535;

/// Position of a control in its program, and the moves that the program makes.
///
/// The work offset is taken to hold the workpiece origin, as in the setup sheets of this crate: whichever of G54 to
/// G59.3 the program uses, as long as it is one. Moves before all of X, Y and Z were commanded are how the machine
/// gets to the part, and moves in machine coordinates (`G53`) before and after all others are how it gets away:
/// they are left out.
#[derive(Debug)]
pub struct ProgramMoves {
    control: PostControl,
    /// Work offset of the setup \[mm\].
    offset: Vector3<f64>,
    frames: BlockFrames,
    /// Largest distance of chords from arcs \[mm\].
    arc_tolerance: f64,
    q: AxisVector,
    /// X, Y, Z that words have stated.
    known: [bool; 3],
    /// Number of the work offset that the program uses.
    work: Option<u8>,
    tool: Option<u32>,
    only: Option<OnlyTool>,
    /// Lengths of the tools that may be called; none: one tool, whose length is that of the setup.
    lengths: Vec<NumberedLength>,
    /// Moves in machine coordinates of which is not known yet whether others follow.
    away: Vec<PostMove>,
    left: LeftOut,
    /// First line that cuts without a tool length.
    gauge_point: Option<u32>,
    /// Moves before the first tool length.
    bare: BareMoves,
    /// Spindle speed, clockwise positive \[1/min\].
    spindle: f64,
    coolant: Coolant,
}

impl ProgramMoves {
    /// Starts with the machine at home; chords keep within `arc_tolerance` \[mm\] of arcs.
    ///
    /// # Errors
    ///
    /// [`PostError::Reach`], [`PostError::Write`] for a setup without numbers or work offset.
    pub fn new(kinematics: &Kinematics, arc_tolerance: f64) -> Result<Self, PostError> {
        let offset = work_offset(kinematics).ok_or(WriteError::WorkOffset)?;
        Ok(Self {
            control: PostControl::new(kinematics)?,
            offset,
            frames: BlockFrames::default(),
            arc_tolerance,
            q: kinematics.machine().home(),
            known: [false; 3],
            work: None,
            tool: None,
            only: None,
            lengths: Vec::new(),
            away: Vec::new(),
            left: LeftOut::default(),
            gauge_point: None,
            bare: BareMoves::default(),
            spindle: 0.0,
            coolant: Coolant::Off,
        })
    }

    /// Takes only the moves of one tool, for which the tool length of the setup is.
    #[must_use]
    pub fn only(self, tool: u32) -> Self {
        Self { only: Some(OnlyTool::new(tool)), ..self }
    }

    /// Takes the moves of all these tools. They begin anew where a tool is first given X, Y and Z; moves
    /// to and from the change are left out.
    #[must_use]
    pub fn with_lengths(self, lengths: &[NumberedLength]) -> Self {
        Self { lengths: lengths.to_vec(), ..self }
    }

    /// Returns the machine with the tool that is in the spindle.
    pub fn kinematics(&self) -> &Kinematics {
        self.control.kinematics()
    }

    /// Returns the present axis positions \[mm, rad\].
    pub fn axes(&self) -> AxisVector {
        self.q
    }

    /// Returns the number of the tool in the spindle, if the program gives one.
    pub fn tool(&self) -> Option<u32> {
        self.tool
    }

    /// Returns the spindle speed \[1/min\]; 0 if it does not turn.
    pub fn spindle(&self) -> f64 {
        self.spindle
    }

    /// Returns the coolant that runs.
    pub fn coolant(&self) -> Coolant {
        self.coolant
    }

    /// Returns the present pose of the tool in the workpiece.
    pub fn pose(&self) -> ToolPose {
        self.control.pose(&self.q)
    }

    /// Takes the axes to these positions.
    fn stand(&mut self, q: AxisVector) {
        self.q = q;
        self.control.stand(q);
    }

    /// Returns the first line that cuts with no tool length in force, so that X Y Z are the gauge point.
    pub fn gauge_point(&self) -> Option<u32> {
        self.gauge_point
    }

    /// Returns the first line that moves the gauge point, if no tool length is in force at a line either.
    ///
    /// A length that comes into force later counts: the lines before it approach the part without one.
    pub fn gauge_point_at(&self, line: u32) -> Option<u32> {
        self.gauge_point.filter(|first| *first <= line).or(self.bare.first(line))
    }

    /// Returns what was left out so far.
    pub fn left(&self) -> LeftOut {
        LeftOut { moves: self.left.moves + self.away.len(), ..self.left }
    }

    /// Runs a step; the moves it makes are appended to `out`.
    ///
    /// # Errors
    ///
    /// [`PostError::Refused`] for what cannot be posted, with what to do; [`PostError::Reach`].
    pub fn step(&mut self, step: &Step, out: &mut Vec<PostMove>) -> Result<(), PostError> {
        match step {
            Step::Move(block) => return self.run(block, out),
            Step::Dwell { .. } => self.left.dwells += 1,
            Step::Words { text, .. } => self.keep(text),
            // Lengths are compensated with those of the tools, smoothing words are counted as words, and the origin that was
            // given holds, as for a program that states where it stands.
            Step::Smoothing { .. }
            | Step::LengthEntry { .. }
            | Step::Offset(Offset { kind: OffsetKind::Standing, .. }) => {}
            Step::Spindle { speed, .. } => {
                let over = self.only.is_some_and(OnlyTool::is_over);
                if *speed != 0.0 && !over {
                    self.spindle = *speed;
                }
            }
            Step::Tool { line, number } => return self.change(*line, *number),
            Step::Offset(of) => {
                let what = "a work offset written by the program";
                return Err(refused(of.line, what, PostRemedy::GiveOrigin));
            }
            Step::Probe { line } if self.is_wanted() => {
                let help = "a probe must not be posted as a cut: take its lines out";
                return Err(refused(*line, "a probing move", help));
            }
            Step::Probe { .. } => {}
            Step::Plane(of) => self.frames.plane = Some(*of),
        }
        Ok(())
    }

    /// Follows the coolant in words without motion, and counts all others as left out.
    fn keep(&mut self, text: &str) {
        let over = self.only.is_some_and(OnlyTool::is_over);
        let running = self.coolant.after(text);
        // Words that start what runs, or end what does not, are those of the coolant as well.
        let switches = Coolant::Off.after(text).is_on() || !Coolant::Flood.after(text).is_on();
        if !switches {
            self.left.words += 1;
        }
        if !over {
            self.coolant = running;
        }
    }

    fn run(&mut self, block: &Move, out: &mut Vec<PostMove>) -> Result<(), PostError> {
        if self.is_wanted() && block.sixth.is_some() {
            return Err(refused(block.line, "a sixth axis", "only five axes are posted"));
        }
        let Frame::Work { offset, length, tcp } = block.frame else {
            return self.run_in_machine(block);
        };
        // Tool-centre-point control alone brings no length where a code of its own switches it (M428 of `LinuxCNC`).
        let has_length = length || self.control.tool_length() == 0.0;
        if self.is_wanted() && !has_length && block.pace != Pace::Rapid {
            self.gauge_point = self.gauge_point.or(Some(block.line));
        }
        if has_length {
            self.bare.end();
        } else if self.is_wanted() {
            self.bare.add(block.line);
        }
        self.use_offset(block.line, offset)?;
        if block.axis.is_some() && !tcp && block.words != [None; AXES] {
            let what = "a tool vector without tool-centre-point control";
            let help = "switch tool-centre-point control on before it";
            return Err(refused(block.line, what, help));
        }
        self.starts_by_rapid(block)?;
        // An incremental word states no position: the start of the motion needs absolute ones.
        for (known, word) in self.known.iter_mut().zip(block.words) {
            *known |= word.is_some() && !block.incremental;
        }
        if self.is_wanted() {
            out.append(&mut self.away);
        }
        match self.run_chords(block, out) {
            // Moves of other tools are not written, but the position is not known from here on.
            Err(_) if !self.is_wanted() => {
                self.known = [false; 3];
                Ok(())
            }
            result => result,
        }
    }

    /// Refuses a cut that leads to the first known position: its start is not known.
    fn starts_by_rapid(&self, block: &Move) -> Result<(), PostError> {
        let cuts = block.pace != Pace::Rapid && block.words.iter().take(3).any(Option::is_some);
        if self.is_wanted() && !self.is_placed() && cuts {
            let what = "a cut before X, Y and Z are all commanded";
            let help = "its start is not known: command X, Y and Z by rapid moves before it";
            return Err(refused(block.line, what, help));
        }
        Ok(())
    }

    /// A straight block, or an arc chord by chord.
    fn run_chords(&mut self, block: &Move, out: &mut Vec<PostMove>) -> Result<(), PostError> {
        let unknown = |_| refused(block.line, "a second work offset", ONE_OFFSET);
        let frame = self.frames.frame_of(block, self.control.tool_length()).map_err(unknown)?;
        let from = read_words(&self.control, &self.q, &frame);
        let to = end_words(from, block, &AxisVector::zeros());
        let length = path_length(block, &from, &to);
        match block.way {
            Way::Line => {
                let start = BlockStart { axes: self.q, words: from };
                self.stand(block_end_from(&self.control, &start, block, &frame)?.axes);
                self.push(block, self.pace(block, length, &start.axes), out);
            }
            Way::Arc(arc) => {
                let count = arc.parts(self.arc_tolerance).min(MOST_CHORDS);
                let chords = f64::from(count);
                for chord in ArcChords::new(block, arc, [from, to], count) {
                    let before = self.q;
                    let pace = match chord.pace {
                        Pace::Inverse { seconds } => Pace::Inverse { seconds: seconds / chords },
                        pace => pace,
                    };
                    let chord = Move { pace, ..chord };
                    self.stand(block_end(&self.control, &self.q, &chord, &frame)?.axes);
                    self.push(&chord, self.pace(&chord, length / chords, &before), out);
                }
            }
        }
        Ok(())
    }

    /// `G53`: axis positions. Kept back until it is known whether the program goes on.
    fn run_in_machine(&mut self, block: &Move) -> Result<(), PostError> {
        for (value, word) in self.q.iter_mut().zip(block.words) {
            *value = word.unwrap_or(*value);
        }
        if block.pace != Pace::Rapid {
            let what = "a move with feed in machine coordinates";
            return Err(refused(block.line, what, "program it in a work offset"));
        }
        if self.is_placed() && self.is_wanted() {
            let (pose, way) = (self.pose(), BlockInterpolation::Axes);
            let (line, q) = (block.line, Some(self.q));
            self.away.push(PostMove { line, pose, q, pace: PostPace::Rapid, way });
        } else {
            self.left.moves += 1;
        }
        Ok(())
    }

    /// The first offset that the wanted tool uses is the one of the setup.
    fn use_offset(&mut self, line: u32, number: u8) -> Result<(), PostError> {
        if self.is_wanted() && *self.work.get_or_insert(number) != number {
            return Err(refused(line, "a second work offset", ONE_OFFSET));
        }
        if self.frames.offsets.get(number).is_none() {
            // Whatever its number, the offset in use holds the workpiece origin of the setup.
            let mut offsets = WorkOffsets::default();
            offsets.set(WorkOffset { number, origin: self.offset }, Vector3::zeros());
            self.frames.offsets = offsets;
        }
        Ok(())
    }

    fn push(&mut self, block: &Move, pace: PostPace, out: &mut Vec<PostMove>) {
        if !self.is_wanted() || (!self.is_placed() && self.known != [true; 3]) {
            self.left.moves += 1;
            return;
        }
        self.control.motion = ToolMotion::Moved;
        let way = match (block.frame, block.turning) {
            (Frame::Work { tcp: true, .. }, Turning::Rotary) => BlockInterpolation::RotaryLinear,
            (Frame::Work { tcp: true, .. }, Turning::GreatCircle) => {
                BlockInterpolation::GreatCircle
            }
            _ => BlockInterpolation::Axes,
        };
        out.push(PostMove { line: block.line, pose: self.pose(), q: Some(self.q), pace, way });
    }

    /// Speed of a straight block whose words run through `length` \[mm\].
    fn pace(&self, block: &Move, length: f64, before: &AxisVector) -> PostPace {
        // The travel that F counts: X, Y, Z as programmed, or the rotaries where these stand.
        let turn = (self.q - before).fixed_rows::<2>(FIRST_ROTARY).norm();
        let tcp = matches!(block.frame, Frame::Work { tcp: true, .. });
        match block.pace {
            Pace::Rapid => PostPace::Rapid,
            Pace::Inverse { seconds } => PostPace::Seconds(seconds),
            Pace::PerMinute { speed } if length > 0.0 && tcp => PostPace::Feed(speed),
            Pace::PerMinute { speed } if length > 0.0 => PostPace::Seconds(length / speed),
            // F counts degrees while X, Y and Z stand still.
            Pace::PerMinute { speed } => PostPace::Seconds(turn.to_degrees() / speed),
        }
    }

    fn is_placed(&self) -> bool {
        self.control.motion == ToolMotion::Moved
    }

    /// Moves are those of the tool that is wanted.
    fn is_wanted(&self) -> bool {
        self.only.is_none_or(OnlyTool::is_running)
    }

    /// Another tool goes into the spindle.
    fn change(&mut self, line: u32, number: u32) -> Result<(), PostError> {
        if !self.lengths.is_empty() {
            return self.change_length(line, number);
        }
        let Some(only) = self.only else {
            if self.tool.is_some_and(|before| before != number) && self.is_placed() {
                return Err(refused(line, "a second tool", PostRemedy::ToolLengths));
            }
            self.tool = Some(number);
            return Ok(());
        };
        let only = only.after_change(line, number, self.control.motion)?;
        self.only = Some(only);
        if only.is_running() {
            self.start_anew(number);
        }
        Ok(())
    }

    /// Another tool with its own length.
    fn change_length(&mut self, line: u32, number: u32) -> Result<(), PostError> {
        if self.tool == Some(number) {
            return Ok(());
        }
        let Some(tool) = self.lengths.iter().find(|tool| tool.number == number) else {
            let what = "a tool whose length is not known";
            return Err(refused(line, what, PostRemedy::ToolLength));
        };
        let setup = Setup { tool_length: tool.length, ..*self.kinematics().setup() };
        self.control = PostControl::new(&Kinematics::new(self.kinematics().machine(), &setup))?;
        self.start_anew(number);
        Ok(())
    }

    /// The motion starts where this tool is first given a position.
    ///
    /// A tool along Z of the table leaves X and Y as they stand: its length counts along Z alone.
    fn start_anew(&mut self, tool: u32) {
        self.control.motion = ToolMotion::Unplaced;
        let keeps = keeps_xy(&self.control, &self.q);
        let [x, y, _] = self.known.map(|known| known && keeps);
        (self.known, self.work) = ([x, y, false], None);
        self.left.moves += self.away.len();
        self.away.clear();
        self.tool = Some(tool);
    }
}

/// Remedy for several work offsets.
const ONE_OFFSET: &str = "post the parts of the program with one work offset each";
