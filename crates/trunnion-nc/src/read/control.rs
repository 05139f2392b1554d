//! Modal state of a control of any dialect, and the steps it makes.

use super::log::ReadRemark;
use super::options::ReadOptions;
use super::step::{Frame, Step, Turning};
use super::tool_table::ToolTable;
use super::word_map::WordMap;
use crate::types::{AXES, AxisVector};
use crate::words::AxisWords;
use nalgebra::UnitVector3;
use std::collections::VecDeque;

/// Number of slots: the five axes of the machine and a sixth one.
pub(super) const SLOTS: usize = AXES + 1;
/// Slot of the sixth axis.
pub(super) const SIXTH: usize = AXES;

/// Largest coordinate a program may ask for \[mm or degrees\]: beyond it is a slip, not a machine.
pub(super) const LARGEST: f64 = 1e6;
/// Millimetres in an inch, by definition.
pub(super) const INCH: f64 = 25.4;

/// Stands for the digits of a computed value, which has none.
pub(super) const COMPUTED: u8 = u8::MAX;

/// Meaning of an F word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FeedMode {
    PerMinute,
    Inverse,
    PerRevolution,
}

/// Unit of length in an F word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FeedUnit {
    Millimetre,
    Inch,
}

/// Distance mode: meaning of an axis word (`G90`, `G91`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DistanceMode {
    /// A coordinate.
    Absolute,
    /// A distance from the current position.
    Incremental,
}

/// Constant cutting speed (`G96`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SurfaceSpeed {
    /// Fastest speed of the spindle \[1/min\].
    pub(super) most: Option<f64>,
}

/// Target of the move of one block.
#[derive(Debug, Clone, Copy)]
pub(super) struct MoveTarget {
    /// \[mm, rad\]
    pub(super) words: [Option<f64>; SLOTS],
    /// Bits of the words that are distances.
    pub(super) incremental: u8,
    pub(super) axis: Option<UnitVector3<f64>>,
    /// Axis positions, `G53`.
    pub(super) machine: bool,
    /// Byte offset of the first word, for messages; its column.
    pub(super) at: usize,
    pub(super) column: u32,
}

impl MoveTarget {
    pub(super) fn new(at: usize, column: u32) -> Self {
        Self { words: [None; SLOTS], incremental: 0, axis: None, machine: false, at, column }
    }

    pub(super) fn set(&mut self, slot: usize, value: f64, mode: DistanceMode) {
        if let Some(word) = self.words.get_mut(slot) {
            *word = Some(value);
        }
        // One bit for each slot; a byte holds the six of them.
        self.incremental &= !(1 << slot);
        self.incremental |= u8::from(mode == DistanceMode::Incremental) << slot;
    }

    /// Takes the word of a slot away.
    pub(super) fn unset(&mut self, slot: usize) -> Option<f64> {
        self.incremental &= !(1 << slot);
        self.words.get_mut(slot)?.take()
    }

    pub(super) fn get(&self, slot: usize) -> Option<f64> {
        self.words.get(slot).copied().flatten()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.axis.is_none() && self.words.iter().all(Option::is_none)
    }

    pub(super) fn is_incremental(&self, slot: usize) -> bool {
        self.incremental >> slot & 1 == 1
    }
}

/// The plane that words of a tilted plane belong to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ActivePlane {
    pub(super) number: u16,
    pub(super) normal: UnitVector3<f64>,
    /// The tool stands along its normal.
    pub(super) ready: bool,
}

/// Everything a control remembers that motion depends on.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "modal switches are what a control has")]
pub(super) struct ControlState {
    axes: AxisWords,
    sixth_allowed: bool,
    pub(super) sixth: Option<char>,
    /// Slot of each letter; `NONE`: no axis.
    slots: [u8; 26],
    /// Slots of X, Y, Z.
    pub(super) xyz: [usize; 3],
    /// Current words in the present frame, with `shift`; `None`: the text does not determine them.
    pub(super) place: [Option<f64>; SLOTS],
    /// Axis positions, as far as the program defines them.
    pub(super) machine: [Option<f64>; SLOTS],
    /// Turn, mirror image and scale of X Y Z words.
    pub(super) word_map: Option<WordMap>,
    /// Shift that `G52`, `TRANS` and the like add to words.
    pub(super) local: [f64; SLOTS],
    /// Shift that `G92` adds to words.
    pub(super) set_by_92: [f64; SLOTS],
    /// A tool offset that is added to words beside the length of the tool: `G43.1`, `G43.2`, `G10 L1`.
    pub(super) tool_shift: [f64; SLOTS],
    /// Slots that the next move states although its line does not: behind cutter compensation the control
    /// takes the axes to be where they were programmed.
    pub(super) restated: u8,
    /// Positions of those slots as they are.
    pub(super) beside: [Option<f64>; SLOTS],
    /// Tool table as the options give it, and as the program wrote it since.
    pub(super) tool_table: ToolTable,
    /// Work offsets as the program wrote them.
    pub(super) written_offsets: WrittenOffsets,
    pub(super) offset: u8,
    pub(super) length: bool,
    /// Tool whose length was switched on.
    length_of: Option<u32>,
    pub(super) tcp: bool,
    /// Interpolation of the tool axis; `None`: not programmed.
    pub(super) turning: Option<Turning>,
    pub(super) tilted: Option<ActivePlane>,
    planes: u16,
    pub(super) inch: bool,
    pub(super) feed_mode: FeedMode,
    /// F as written, in mm or inch units.
    pub(super) feed: Option<f64>,
    /// Unit of F where it is not that of the words: at Sinumerik each F keeps that of its block.
    pub(super) feed_unit: Option<FeedUnit>,
    /// \[1/min\]
    pub(super) speed: f64,
    /// `G96`: S is the speed of the cut, not of the spindle.
    pub(super) surface: Option<SurfaceSpeed>,
    /// 1 clockwise, -1 counterclockwise, 0 stopped.
    pub(super) sense: i8,
    /// Chosen by `T`.
    pub(super) tool: u32,
    pub(super) tools: Vec<u32>,
    pub(super) steps: VecDeque<Step>,
    finest: [f64; SLOTS],
    finest_feed: f64,
    pub(super) ended: bool,
}

/// Returns the axis positions before the first block, as far as they are known.
fn start_of(options: &ReadOptions) -> [Option<f64>; SLOTS] {
    let mut start = [None; SLOTS];
    if let Some(given) = options.start {
        // A sixth axis has no position of its own here, and stands at zero as well.
        start = [Some(0.0); SLOTS];
        start.iter_mut().zip(given).for_each(|(to, from)| *to = Some(from));
    }
    start
}

const NONE: u8 = u8::MAX;

/// Work offsets that a program can write: `G54` to `G59.3`.
const OFFSETS: usize = 9;

/// Values that the program wrote into work offsets.
#[derive(Debug, Default)]
pub(super) struct WrittenOffsets {
    origins: [[Option<f64>; SLOTS]; OFFSETS],
    turns: [f64; OFFSETS],
}

impl WrittenOffsets {
    /// Returns the axis position of the origin of an offset \[mm, rad\], if the program wrote it.
    pub(super) fn origin(&self, offset: u8, slot: usize) -> Option<f64> {
        self.origins.get(usize::from(offset))?.get(slot).copied().flatten()
    }

    /// Notes the origin of an offset along an axis; `None`: it is no longer known.
    pub(super) fn set_origin(&mut self, offset: u8, slot: usize, value: Option<f64>) {
        let origin = self.origins.get_mut(usize::from(offset)).and_then(|of| of.get_mut(slot));
        if let Some(origin) = origin {
            *origin = value;
        }
    }

    /// Returns the angle of an offset about Z \[rad\].
    pub(super) fn turn(&self, offset: u8) -> f64 {
        self.turns.get(usize::from(offset)).copied().unwrap_or(0.0)
    }

    pub(super) fn set_turn(&mut self, offset: u8, angle: f64) {
        if let Some(turn) = self.turns.get_mut(usize::from(offset)) {
            *turn = angle;
        }
    }
}

impl ControlState {
    /// Returns the state of a control after `G21 G90 G94 G54 G49`; a program that relies on any other
    /// state has to program it.
    pub(super) fn new(options: &ReadOptions) -> Self {
        let axes = options.axes;
        // A table from letter to slot: it is asked for each word of the program.
        let mut slots = [NONE; 26];
        for (index, word) in (0_u8..).zip(&axes.0) {
            if let Some(slot) = letter_index(word.letter).and_then(|at| slots.get_mut(at)) {
                *slot = index;
            }
        }
        // A machine whose linear axes have other letters has them in the order X Y Z.
        let [x, y, z] = [('X', 0), ('Y', 1), ('Z', 2)];
        let xyz = [x, y, z].map(|(letter, usual)| axes.index_of(letter).unwrap_or(usual));
        let start = start_of(options);
        let mut tool_table = ToolTable::new(&options.tools);
        let mut written_offsets = WrittenOffsets::default();
        if options.start.is_some() {
            written_offsets.origins = [[Some(0.0); SLOTS]; OFFSETS];
            tool_table.empty_spindle();
        }
        Self {
            axes,
            sixth_allowed: options.sixth,
            sixth: None,
            slots,
            xyz,
            place: start,
            machine: start,
            word_map: None,
            local: [0.0; SLOTS],
            set_by_92: [0.0; SLOTS],
            tool_shift: [0.0; SLOTS],
            restated: 0,
            beside: [None; SLOTS],
            tool_table,
            written_offsets,
            offset: 0,
            length: false,
            length_of: None,
            tcp: false,
            turning: None,
            tilted: None,
            planes: 0,
            inch: false,
            feed_mode: FeedMode::PerMinute,
            feed: None,
            feed_unit: None,
            speed: 0.0,
            surface: None,
            sense: 0,
            tool: 0,
            tools: Vec::new(),
            steps: VecDeque::new(),
            finest: [0.0; SLOTS],
            finest_feed: 0.0,
            ended: false,
        }
    }

    /// Returns the slot of an axis letter (upper case).
    #[inline]
    pub(super) fn slot(&mut self, letter: u8) -> Option<usize> {
        let slot = self.slots.get(usize::from(letter.wrapping_sub(b'A'))).copied()?;
        if slot != NONE {
            return Some(usize::from(slot));
        }
        let letter = char::from(letter);
        // The first further axis letter takes the sixth slot and keeps it.
        if !self.sixth_allowed || !"XYZABCUVW".contains(letter) {
            return None;
        }
        (*self.sixth.get_or_insert(letter) == letter).then_some(SIXTH)
    }

    /// Returns the slot of a letter, without admitting a new axis.
    pub(super) fn known_slot(&self, letter: char) -> Option<usize> {
        if self.sixth == Some(letter) {
            return Some(SIXTH);
        }
        self.axes.index_of(letter)
    }

    /// Returns the letter of a slot.
    pub(super) fn letter(&self, slot: usize) -> Option<char> {
        self.axes.0.get(slot).map(|word| word.letter).or(self.sixth)
    }

    /// Explains why a letter is no axis.
    pub(super) fn no_axis(&self, at: usize, text: &str) -> ReadRemark {
        let axes = &self.axes;
        let message = format!("{text} is not understood: the machine's axes are {axes}");
        ReadRemark::new(at, message, "read it for the machine it was written for")
    }

    pub(super) fn is_rotary(&self, slot: usize) -> bool {
        match self.axes.0.get(slot) {
            Some(word) => word.rotary,
            // Beyond the five axes only the letter shows the kind: by ISO 841, A B C turn.
            None => self.sixth.is_some_and(|letter| "ABC".contains(letter)),
        }
    }

    pub(super) fn is_reversed(&self, slot: usize) -> bool {
        self.axes.0.get(slot).is_some_and(|word| word.reversed)
    }

    /// Returns the millimetres in a unit of a linear word.
    pub(super) fn scale(&self) -> f64 {
        if self.inch { INCH } else { 1.0 }
    }

    /// Converts a written word to mm or rad; `decimals` digits stood behind its point.
    #[inline]
    pub(super) fn meant(&mut self, slot: usize, written: f64, decimals: u8) -> f64 {
        // Inch units are those of linear words; degrees stay degrees.
        let scale = if self.inch && !self.is_rotary(slot) { INCH } else { 1.0 };
        // The digits of a computed value reveal nothing about the resolution of the program.
        if let (Some(finest), true) = (self.finest.get_mut(slot), decimals != COMPUTED) {
            finer(finest, decimals, scale);
        }
        match self.axes.0.get(slot) {
            Some(word) => word.meant(written * scale),
            None if self.is_rotary(slot) => written.to_radians(),
            None => written * scale,
        }
    }

    /// Converts mm or rad to the number that the program would write.
    pub(super) fn written(&self, slot: usize, value: f64) -> f64 {
        let scale = if self.inch && !self.is_rotary(slot) { INCH } else { 1.0 };
        match self.axes.0.get(slot) {
            Some(word) => word.written(value) / scale,
            None if self.is_rotary(slot) => value.to_degrees(),
            None => value / scale,
        }
    }

    /// Switches tool-centre-point control on.
    pub(super) fn enable_tcp(&mut self) {
        // X Y Z change between axis positions and tip, so their values become unknown. Rotary words
        // are axis positions in both modes.
        if !self.tcp {
            self.forget_linear();
        }
        self.tcp = true;
    }

    /// Switches tool-centre-point control off.
    pub(super) fn disable_tcp(&mut self) {
        if self.tcp {
            self.forget_linear();
        }
        self.tcp = false;
    }

    /// Switches tool length compensation on, for whatever tool is now in the spindle.
    pub(super) fn enable_length(&mut self) {
        let spindle = self.tools.last().copied();
        match self.known_length() {
            // The same tool again: its offset is that of the table, which words carry beside the length.
            Some(_) if self.length && self.length_of == spindle => {}
            Some(length) if !self.length => self.move_along_tool(-length),
            // Another tool may be meant even if compensation was on.
            _ => self.forget_along_tool(),
        }
        (self.length, self.length_of) = (true, spindle);
    }

    /// Switches tool length compensation off.
    pub(super) fn disable_length(&mut self) {
        if self.length {
            let same = self.length_of == self.tools.last().copied();
            match self.known_length() {
                Some(length) if same => self.move_along_tool(length),
                _ => self.forget_along_tool(),
            }
        }
        self.length = false;
    }

    /// Sets the offset that is added to X Y Z beside the length of the tool.
    pub(super) fn set_tool_shift(&mut self, shift: [f64; 3]) {
        for (slot, shift) in self.xyz.into_iter().zip(shift) {
            if let Some(known) = self.tool_shift.get_mut(slot) {
                *known = shift;
            }
        }
    }

    /// Returns the length of the tool in the spindle \[mm\] where the tool table has it and it counts along Z.
    fn known_length(&self) -> Option<f64> {
        let tool = self.tools.last().filter(|_| !self.tcp && self.tilted.is_none())?;
        self.tool_table.get(*tool).map(|row| row.length)
    }

    /// Adds a length to the word of Z, whose axis stays.
    fn move_along_tool(&mut self, length: f64) {
        let [.., z] = self.xyz;
        if let Some(Some(place)) = self.place.get_mut(z) {
            *place += length;
        }
    }

    /// Marks as unknown the words that another tool length changes.
    fn forget_along_tool(&mut self) {
        let [.., z] = self.xyz;
        if self.tcp {
            // The tool may stand in any direction, so the gauge point shifts along all of X Y Z.
            self.forget_linear();
        } else if let Some(place) = self.place.get_mut(z) {
            // Without TCP a control adds the length along Z whatever the rotaries are.
            *place = None;
        }
    }

    /// Switches to another work offset.
    pub(super) fn set_offset(&mut self, offset: u8) {
        if self.offset != offset {
            let known = |slot: usize| {
                let of = |offset| self.written_offsets.origin(offset, slot);
                // Under TCP the frame turns with the rotaries: a difference of axes is none of words.
                let change = of(self.offset).zip(of(offset)).filter(|_| !self.tcp);
                Some(self.stands(slot)? + change.map(|(before, after)| before - after)?)
            };
            // Where the program wrote both offsets, words change by the difference; else no word
            // keeps its value, not even that of a rotary axis.
            self.place = std::array::from_fn(known);
        }
        self.offset = offset;
    }

    /// Returns the number of a new tilted plane.
    pub(super) fn next_plane(&mut self) -> u16 {
        // Numbers start at 1; 0 stands for no plane.
        self.planes = self.planes.saturating_add(1);
        self.planes
    }

    /// Returns the frame of absolute words.
    pub(super) fn frame(&self) -> Frame {
        // In a tilted plane the tool stands along the normal and its length is compensated there: X
        // Y Z are the tip.
        let tcp = self.tcp || self.tilted.is_some();
        Frame::Work { offset: self.offset, length: self.length, tcp }
    }

    /// Notes a feed word's digits.
    pub(super) fn note_feed(&mut self, decimals: u8) {
        if decimals != COMPUTED {
            let scale = self.scale();
            finer(&mut self.finest_feed, decimals, scale);
        }
    }

    /// Returns half of the last digit of each axis word \[mm, rad\].
    pub(super) fn rounding(&self) -> AxisVector {
        let mut rounding = AxisVector::zeros();
        // A word rounded to a unit is off by half of it at most; units are mm or degrees.
        for ((half, unit), word) in rounding.iter_mut().zip(self.finest).zip(&self.axes.0) {
            *half = 0.5 * if word.rotary { unit.to_radians() } else { unit };
        }
        rounding
    }

    /// Returns half of the last digit of the feed words, in their own unit.
    pub(super) fn feed_rounding(&self) -> f64 {
        0.5 * self.finest_feed
    }
}

/// Notes that a word has `decimals` digits after its point.
#[inline]
fn finer(finest: &mut f64, decimals: u8, scale: f64) {
    /// Units of the first digits.
    const UNITS: [f64; 10] = [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
    // The table spares a power for each word.
    let unit = match UNITS.get(usize::from(decimals)) {
        Some(unit) => scale * unit,
        None => scale * 10f64.powi(-i32::from(decimals)),
    };
    // Zero: no word of this axis was read yet.
    if *finest <= 0.0 || unit < *finest {
        *finest = unit;
    }
}

/// Returns the index of a letter in the alphabet: 0 for `A`.
#[inline]
pub(super) fn letter_index(letter: char) -> Option<usize> {
    let index = (letter as u32).checked_sub('A' as u32)?;
    usize::try_from(index).ok().filter(|index| *index < 26)
}
