//! A program in any dialect, written block by block: memory is that of the modal state.

use super::apt::LocationWriter;
use super::error::WriteError;
use super::error_bound::Coordinates;
use super::feed_word::{self, FeedTravel};
use super::format::{BlockSyntax, OrientationWords, OutputFormat};
use super::note::Note;
use super::note::comment;
use super::number::{FixedNumber, NumberForm};
use super::position::WrittenPosition;
use super::sheet::{HeadNote, SheetTool, work_offset};
use super::style::Style;
use super::template::{Template, TemplateFrame};
use super::words_of;
use crate::machine::{FIRST_ROTARY, Kinematics, TurnFormat};
use crate::math;
use crate::types::{AXES, ToolPose};
use crate::words::{AxisWords, Coolant};
use nalgebra::Vector3;

/// Feed or time of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BlockPace {
    /// As fast as the machine can.
    Rapid,
    /// In a time.
    Timed {
        /// Time \[s\].
        seconds: f64,
        /// Way of the tip in the workpiece frame \[mm\].
        length: f64,
        /// Way of the rotaries, the root of the sum of both squares \[rad\]; where the tip stands, F is theirs.
        turn: f64,
    },
}

/// Note, style and template of a program.
#[derive(Debug, Clone, Copy)]
pub struct ProgramForm<'a> {
    /// Facts for the head of the program.
    pub note: &'a Note<'a>,
    /// Format, words and feed.
    pub style: &'a Style,
    /// Text around the blocks.
    pub template: &'a Template,
    /// Tools that the program changes to, for its head.
    pub changes: &'a [SheetTool],
}

/// Change of rotary words from which on they may hide whole turns \[degrees\].
const HALF_TURN: f64 = 180.0;

/// Words of a block, rounded.
struct RoundedBlock {
    /// X Y Z and the rotaries.
    words: [FixedNumber; AXES],
    /// Number of `words` that the format writes: with a tool vector X Y Z only.
    count: usize,
    /// Tool vector, where the format writes one.
    vector: Option<[FixedNumber; 3]>,
}

/// Time and travel of blocks whose words all round to those before; the next block takes them over.
#[derive(Debug, Clone, Copy, Default)]
struct PendingBlock {
    seconds: f64,
    length: f64,
    turn: f64,
}

/// Writes a program block by block.
#[derive(Debug)]
pub struct ProgramWriter {
    pub(super) kinematics: Kinematics,
    pub(super) style: Style,
    pub(super) syntax: BlockSyntax,
    frame: TemplateFrame,
    shift: Vector3<f64>,
    /// Axes in the order of their words: X Y Z, rotaries by letter.
    pub(super) order: [usize; AXES],
    pub(super) last: [Option<FixedNumber>; AXES],
    pub(super) vector: Option<[FixedNumber; 3]>,
    rapid: Option<bool>,
    feed: Option<FixedNumber>,
    locations: LocationWriter,
    waiting: PendingBlock,
    /// Coolant that the text has running.
    pub(super) coolant: Coolant,
    /// The end of the template stops the coolant.
    ends_coolant: bool,
    /// Time of blocks that no later block could take over \[s\].
    unwritten: f64,
    line: u64,
    blocks: usize,
    /// Index of the block at hand; 0 is the starting position.
    index: usize,
}

impl ProgramWriter {
    /// Writes the start of a program, up to the starting position.
    ///
    /// # Errors
    ///
    /// [`WriteError`].
    pub fn new(
        out: &mut String,
        kinematics: &Kinematics,
        form: ProgramForm<'_>,
        start: WrittenPosition<'_>,
    ) -> Result<Self, WriteError> {
        let ProgramForm { note, style, template, changes } = form;
        let offset = work_offset(kinematics).ok_or(WriteError::WorkOffset)?;
        let empty = TemplateFrame {
            start: String::new(),
            toolchange: None,
            end: String::new(),
            comment: [const { String::new() }; 2],
            number: [const { String::new() }; 2],
        };
        let mut writer = Self {
            kinematics: kinematics.clone(),
            style: *style,
            syntax: style.dialect.syntax(),
            frame: empty,
            // Without TCP: axis = word + offset + length along Z, hence word = axis - shift.
            shift: offset + Vector3::z() * kinematics.setup().tool_length,
            order: order(&style.axes),
            last: [None; AXES],
            vector: None,
            rapid: None,
            feed: None,
            locations: LocationWriter::default(),
            waiting: PendingBlock::default(),
            coolant: Coolant::Off,
            ends_coolant: false,
            unwritten: 0.0,
            line: 0,
            blocks: 0,
            index: 0,
        };
        let first = writer.first(start)?;
        let context = writer.context(HeadNote { note, changes }, offset, first)?;
        let strings = &kinematics.machine().dialect.strings;
        writer.frame = template.fill(&context, strings)?;
        let text = std::mem::take(&mut writer.frame.start);
        writer.lines(out, &text);
        (writer.coolant, writer.ends_coolant) = (note.coolant, note.coolant.is_on());
        // The template may end with either: the first block states G0 or G1.
        writer.rapid = None;
        Ok(writer)
    }

    /// Writes the change to another tool, up to its starting position. The setup of `kinematics`
    /// has the length of the new tool.
    ///
    /// # Errors
    ///
    /// [`WriteError`]; [`WriteError::NoToolChange`] for a template without such a block.
    pub fn change_tool(
        &mut self,
        out: &mut String,
        kinematics: &Kinematics,
        note: &Note<'_>,
        template: &Template,
        start: WrittenPosition<'_>,
    ) -> Result<(), WriteError> {
        let offset = work_offset(kinematics).ok_or(WriteError::WorkOffset)?;
        self.kinematics = kinematics.clone();
        self.shift = offset + Vector3::z() * kinematics.setup().tool_length;
        // The template of the change brings the tool to the new start; nothing is pending there.
        self.drop_waiting();
        let first = self.first(start)?;
        let context = self.context(HeadNote { note, changes: &[] }, offset, first)?;
        self.frame = template.fill(&context, &kinematics.machine().dialect.strings)?;
        let text = self.frame.toolchange.take().ok_or(WriteError::NoToolChange)?;
        self.lines(out, &text);
        (self.coolant, self.ends_coolant) = (note.coolant, note.coolant.is_on());
        (self.rapid, self.feed) = (None, None);
        self.locations = LocationWriter::default();
        Ok(())
    }

    /// Writes the end of the program; returns the number of its blocks.
    pub fn finish(mut self, out: &mut String) -> usize {
        // The end was made for the coolant of the start.
        if !self.ends_coolant {
            self.switch_coolant(out, Coolant::Off);
        }
        let end = std::mem::take(&mut self.frame.end);
        self.lines(out, &end);
        self.blocks
    }

    /// Returns the number of blocks written so far.
    pub fn blocks(&self) -> usize {
        self.blocks
    }

    /// Returns the time of blocks that no block of the text has \[s\]: their words rounded to those before, and no feed
    /// block followed that could take the time over.
    pub fn unwritten(&self) -> f64 {
        self.unwritten + self.waiting.seconds
    }

    /// Returns the coolant that the text has running.
    pub fn coolant(&self) -> Coolant {
        self.coolant
    }

    /// Switches the coolant, on lines of their own.
    pub fn switch_coolant(&mut self, out: &mut String, to: Coolant) {
        if self.coolant == to {
            return;
        }
        for line in self.style.dialect.coolant_switch(self.coolant, to) {
            self.number(out);
            out.push_str(line);
            out.push('\n');
        }
        self.coolant = to;
    }

    /// Gives up the time that waits for a next feed block.
    fn drop_waiting(&mut self) {
        self.unwritten += std::mem::take(&mut self.waiting).seconds;
    }

    /// Writes a comment on a line of its own.
    pub fn comment(&mut self, out: &mut String, text: &str) {
        let text = comment(text);
        self.number(out);
        out.push_str(&self.frame.comment[0]);
        out.push_str(&text);
        out.push_str(&self.frame.comment[1]);
        out.push('\n');
    }

    /// Writes a block that ends at `to`. A block whose words all round to those before is left out,
    /// and its time is added to the next.
    ///
    /// # Errors
    ///
    /// [`WriteError`].
    pub fn block(
        &mut self,
        out: &mut String,
        to: WrittenPosition<'_>,
        pace: BlockPace,
    ) -> Result<(), WriteError> {
        self.index += 1;
        let words = self.rounded(to)?;
        let vector = match self.syntax.pointing {
            OrientationWords::Vector(_) => Some(self.components(to.pose)?),
            OrientationWords::Angles => None,
        };
        // With a tool vector the control chooses the rotaries: they are not written.
        let count = if vector.is_some() { 3 } else { AXES };
        let same = words.iter().take(count).zip(&self.last).all(|(now, last)| Some(*now) == *last)
            && vector == self.vector;
        let feed = match pace {
            BlockPace::Rapid => None,
            BlockPace::Timed { seconds, length, turn } => {
                // Time and travel of blocks that were left out belong to the next one that is
                // written.
                self.waiting.seconds += seconds;
                self.waiting.length += length;
                self.waiting.turn += turn;
                Some(self.waiting)
            }
        };
        if same {
            return Ok(());
        }
        // A rapid move has no time that could be longer.
        match feed {
            Some(_) => self.waiting = PendingBlock::default(),
            None => self.drop_waiting(),
        }
        let feed = feed.map(|of| self.feed_word(&of, &words)).transpose()?;
        let block = RoundedBlock { words, count, vector };
        self.blocks += 1;
        if self.style.dialect == OutputFormat::Apt {
            self.location(out, &block, feed);
        } else {
            self.write(out, &block, feed);
        }
        Ok(())
    }

    /// Writes a block: the words that changed, and the feed; `None`: rapid.
    fn write(&mut self, out: &mut String, block: &RoundedBlock, feed: Option<FixedNumber>) {
        let &RoundedBlock { ref words, count, vector } = block;
        let BlockSyntax { form, pointing, moves, every_block, whole_tip, rapid_tail } = self.syntax;
        self.number(out);
        let start = out.len();
        let rapid = feed.is_none();
        // G0 and G1 are modal where the format allows.
        if every_block || self.rapid != Some(rapid) {
            out.push_str(moves[usize::from(!rapid)]);
        }
        let mut word = |name: &str, value: FixedNumber| {
            if out.len() > start {
                out.push(' ');
            }
            out.push_str(name);
            value.push(out, form);
        };
        for &index in self.order.iter().take(count) {
            let parts = (self.style.axes.0.get(index), self.last.get_mut(index), words.get(index));
            let (Some(axis), Some(last), Some(&now)) = parts else { continue };
            if *last != Some(now) || (whole_tip && !axis.rotary) {
                word(axis.letter.encode_utf8(&mut [0; 4]), now);
                *last = Some(now);
            }
        }
        // The components of a vector belong together, so all of them are written where one changes.
        if let (OrientationWords::Vector(names), Some(now)) = (pointing, vector)
            && (self.vector != vector || whole_tip)
        {
            names.iter().zip(now).for_each(|(name, value)| word(name, value));
            self.vector = vector;
        }
        match feed {
            None => {
                out.push_str(rapid_tail);
                self.feed = None;
            }
            // G93 needs F in every block; a speed is modal.
            Some(feed) if self.style.inverse_time || self.feed != Some(feed) => {
                out.push_str(" F");
                feed.push(out, form_of_feed(form));
                self.feed = Some(feed);
            }
            Some(_) => {}
        }
        self.rapid = Some(rapid);
        out.push('\n');
    }

    /// Writes a block as a cutter location.
    fn location(&mut self, out: &mut String, block: &RoundedBlock, feed: Option<FixedNumber>) {
        let &RoundedBlock { ref words, vector, .. } = block;
        if let (&[x, y, z, ..], Some([i, j, k])) = (words, vector) {
            self.locations.go(out, feed, &[x, y, z, i, j, k]);
        }
        self.vector = vector;
        self.last = words.map(Some);
    }

    /// Returns the feed word of a block that ends at `words`.
    fn feed_word(
        &self,
        of: &PendingBlock,
        words: &[FixedNumber; AXES],
    ) -> Result<FixedNumber, WriteError> {
        let failed = WriteError::Duration { block: self.index, duration: of.seconds };
        if !(of.seconds > 0.0 && of.seconds.is_finite()) {
            return Err(failed);
        }
        let feed = if self.style.inverse_time {
            feed_word::inverse_time(of.seconds)
        } else {
            feed_word::per_minute(self.travel(of, words), of.seconds)
        };
        feed.ok_or(failed)
    }

    /// Returns the travel along which F counts: that of the tip if it moves, else that of the rotaries in degrees.
    fn travel(&self, of: &PendingBlock, words: &[FixedNumber; AXES]) -> FeedTravel {
        let change = |axis: usize| {
            let (now, last) = (words.get(axis), self.last.get(axis).copied().flatten());
            now.zip(last).map_or(0.0, |(now, last)| now.value() - last.value())
        };
        let tip = Vector3::from_fn(|axis, _| change(axis)).norm();
        // Where no word of the tip changes, a control takes F as the speed of the rotaries.
        if tip > 0.0 || of.turn <= 0.0 {
            return FeedTravel { planned: of.length, written: tip };
        }
        let planned = of.turn.to_degrees();
        // Of a tool vector the control reckons the rotaries, and modulo words hide whole turns.
        let turn = math::hypot(change(FIRST_ROTARY), change(FIRST_ROTARY + 1));
        let is_own = matches!(self.syntax.pointing, OrientationWords::Angles);
        let is_near = (turn - planned).abs() < HALF_TURN;
        FeedTravel { planned, written: if is_own && is_near { turn } else { planned } }
    }

    /// Returns the words of X Y Z and the rotaries, rounded.
    pub(super) fn rounded(
        &self,
        at: WrittenPosition<'_>,
    ) -> Result<[FixedNumber; AXES], WriteError> {
        let WrittenPosition { q, pose } = at;
        let dialect = self.style.dialect;
        let tip = match dialect.coordinates() {
            // Axis positions less offset and length, or the tip in the frame of the format.
            Coordinates::Axes => q.fixed_rows::<3>(0).into_owned() - self.shift,
            Coordinates::Tip => words_of::tip(&self.kinematics, dialect, pose),
        };
        let values = [tip.x, tip.y, tip.z, q[3], q[4]];
        let mut rounded = [self.fixed(0.0, 0)?; AXES];
        let axes = &self.kinematics.machine().axes;
        for (((slot, word), value), axis) in
            rounded.iter_mut().zip(&self.style.axes.0).zip(values).zip(axes)
        {
            // Rounded before turns are taken off: 359.99999 becomes 0, not 360.
            let fixed = self.fixed(word.written(value), word.decimals)?;
            *slot = match axis.output.modulo {
                TurnFormat::Positive if word.rotary => fixed.within_turn(0),
                TurnFormat::Signed if word.rotary => fixed.within_turn(-180),
                _ => fixed,
            };
        }
        Ok(rounded)
    }

    /// Components of the tool vector: in the table frame, in a CL file in the workpiece frame.
    pub(super) fn components(&self, pose: &ToolPose) -> Result<[FixedNumber; 3], WriteError> {
        let dialect = self.style.dialect;
        let decimals = words_of::vector_decimals(dialect);
        let axis = words_of::vector(&self.kinematics, dialect, pose);
        Ok([
            self.fixed(axis.x, decimals)?,
            self.fixed(axis.y, decimals)?,
            self.fixed(axis.z, decimals)?,
        ])
    }

    pub(super) fn fixed(&self, value: f64, decimals: u8) -> Result<FixedNumber, WriteError> {
        let block = self.index;
        FixedNumber::nearest(value, decimals).ok_or(WriteError::Number { block, value, decimals })
    }

    /// Writes lines of a template, numbered; empty ones are left out.
    fn lines(&mut self, out: &mut String, text: &str) {
        for line in text.lines().map(str::trim_end).filter(|line| !line.is_empty()) {
            // Program marks, program numbers and comments stand without a line number.
            let bare = matches!(self.syntax.form, NumberForm::Signed)
                || !line.starts_with(['%', 'O', '(', ';']);
            if bare {
                self.number(out);
            }
            out.push_str(line);
            out.push('\n');
        }
    }

    /// Writes the number of the next line.
    fn number(&mut self, out: &mut String) {
        let [before, behind] = &self.frame.number;
        if before.is_empty() && behind.is_empty() {
            return;
        }
        out.push_str(before);
        // Klartext counts lines from 0; elsewhere the first number is the step.
        let klartext = matches!(self.syntax.form, NumberForm::Signed);
        let step = u64::from(self.style.numbers.max(1));
        let number = if klartext { self.line } else { (self.line + 1) * step };
        out.push_str(&number.to_string());
        out.push_str(behind);
        self.line += 1;
    }
}

/// Returns the order of the words: X Y Z, then the rotaries by letter, `A` before `C` whatever
/// carries what.
fn order(axes: &AxisWords) -> [usize; AXES] {
    let letter = |axis: usize| axes.0.get(axis).map(|word| word.letter);
    if letter(3) <= letter(4) { [0, 1, 2, 3, 4] } else { [0, 1, 2, 4, 3] }
}

/// Returns the number form of feeds, which have no sign.
fn form_of_feed(form: NumberForm) -> NumberForm {
    if form == NumberForm::Point { NumberForm::Point } else { NumberForm::Plain }
}
