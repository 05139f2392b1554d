//! Modal state of a control of any dialect, and the steps it makes.

use super::log::ReadRemark;
use super::options::ReadOptions;
use super::step::{Frame, LengthEntry, Smoothing, Step, Turning};
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
    beside: [Option<f64>; SLOTS],
    /// Tool table as the options give it, and as the program wrote it since.
    pub(super) tool_table: ToolTable,
    /// Work offsets as the program wrote them.
    pub(super) written_offsets: WrittenOffsets,
    pub(super) offset: u8,
    pub(super) length: bool,
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

    /// Returns the shift added to an absolute word.
    #[inline]
    pub(super) fn shift(&self, slot: usize) -> f64 {
        // A tilted plane has taken the shifts into its origin.
        if self.tilted.is_some() {
            return 0.0;
        }
        self.local.get(slot).copied().unwrap_or(0.0)
            + self.set_by_92.get(slot).copied().unwrap_or(0.0)
    }

    /// Returns the current value of a word as the program would write it \[mm, rad\], without shift.
    pub(super) fn reading(&self, slot: usize) -> Option<f64> {
        let place = self.place.get(slot).copied().flatten()?;
        if let Some(map) = &self.word_map {
            return self.mapped_reading(map, slot);
        }
        // The position contains the shift, the word that leads to it does not.
        if self.turn().abs() > 0.0
            && let Some(axis) = self.turned_axis(slot)
        {
            let [x, y, _] = self.xyz;
            let unturned = rotate(
                [self.stands(x)? - self.tool_offset(x), self.stands(y)? - self.tool_offset(y)],
                -self.turn(),
            );
            return Some(unturned[axis] - self.shift(slot));
        }
        Some(place - self.tool_offset(slot) - self.shift(slot))
    }

    /// Returns the angle by which the active work offset turns X Y words about Z \[rad\].
    pub(super) fn turn(&self) -> f64 {
        self.written_offsets.turn(self.offset)
    }

    /// Returns 0 for X, 1 for Y: the axes that a turned work offset mixes.
    pub(super) fn turned_axis(&self, slot: usize) -> Option<usize> {
        self.xyz.iter().take(2).position(|axis| *axis == slot)
    }

    /// Returns what the tool offset adds to a word, beside the length of the tool.
    pub(super) fn tool_offset(&self, slot: usize) -> f64 {
        self.tool_shift.get(slot).copied().unwrap_or(0.0)
    }

    /// Returns the position that belongs to readings of the program: shifted, turned, with the tool offset.
    pub(super) fn place_of(&self, reading: &[Option<f64>; SLOTS]) -> [Option<f64>; SLOTS] {
        self.place_in(reading, self.turn())
    }

    /// Returns the position that belongs to readings in a work offset with a turn about Z \[rad\].
    pub(super) fn place_in(
        &self,
        reading: &[Option<f64>; SLOTS],
        turn: f64,
    ) -> [Option<f64>; SLOTS] {
        let mapped = self.word_map.map(|map| self.mapped(&map, reading));
        let reading = mapped.as_ref().unwrap_or(reading);
        let shifted = |slot: usize| {
            let reading = reading.get(slot).copied().flatten();
            reading.map(|reading| reading + self.shift(slot))
        };
        let mut place: [Option<f64>; SLOTS] = std::array::from_fn(shifted);
        let [x, y, _] = self.xyz;
        if turn.abs() > 0.0 {
            // Both are needed for either.
            let both = shifted(x).zip(shifted(y));
            let turned = both.map(|(x, y)| rotate([x, y], turn));
            for (axis, slot) in [x, y].into_iter().enumerate() {
                if let Some(place) = place.get_mut(slot) {
                    *place = turned.map(|turned| turned[axis]);
                }
            }
        }
        for (slot, place) in place.iter_mut().enumerate() {
            *place = place.map(|place| place + self.tool_offset(slot));
        }
        place
    }

    /// Takes two axes to be at positions of the program, to which the next move leads.
    pub(super) fn restate(&mut self, slots: [usize; 2], position: [f64; 2]) {
        let mut readings = self.readings();
        self.beside = self.place;
        for (slot, value) in slots.into_iter().zip(position) {
            self.restated |= 1 << slot;
            if let Some(reading) = readings.get_mut(slot) {
                *reading = Some(value);
            }
        }
        self.place = self.place_of(&readings);
    }

    /// Returns what the program would read at the present position.
    pub(super) fn readings(&self) -> [Option<f64>; SLOTS] {
        std::array::from_fn(|slot| self.reading(slot))
    }

    /// Returns the position of a slot including its shift \[mm, rad\].
    pub(super) fn stands(&self, slot: usize) -> Option<f64> {
        self.place.get(slot).copied().flatten()
    }

    /// Marks the positions of the linear axes as unknown.
    pub(super) fn forget_linear(&mut self) {
        self.forget(|rotary| !rotary);
    }

    pub(super) fn forget(&mut self, which: impl Fn(bool) -> bool) {
        for slot in 0..SLOTS {
            let rotary = self.is_rotary(slot);
            if let (Some(place), true) = (self.place.get_mut(slot), which(rotary)) {
                *place = None;
            }
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
        // Another tool may be meant even if compensation was on.
        self.forget_along_tool();
        self.length = true;
    }

    /// Switches tool length compensation off.
    pub(super) fn disable_length(&mut self) {
        if self.length {
            self.forget_along_tool();
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

    /// Puts a tool into the spindle.
    pub(super) fn change_tool(&mut self, line: u32, number: u32) {
        // Behind a tool change the control looks where the axes are.
        for slot in (0..SLOTS).filter(|slot| self.restated >> slot & 1 == 1) {
            if let (Some(place), Some(beside)) = (self.place.get_mut(slot), self.beside.get(slot)) {
                *place = *beside;
            }
        }
        self.restated = 0;
        self.tools.push(number);
        self.steps.push_back(Step::Tool { line, number });
    }

    /// Emits the present state of the spindle.
    pub(super) fn spindle(&mut self, line: u32) {
        // The sign is the sense of rotation: M3 positive, M4 negative, M5 zero.
        let [x, ..] = self.xyz;
        let speed = self.spindle_speed(self.reading(x)).unwrap_or(self.speed);
        let speed = f64::from(self.sense) * speed;
        self.steps.push_back(Step::Spindle { line, speed });
    }

    /// Emits the distance that the control may keep from the path.
    pub(super) fn smooth(&mut self, line: u32, smoothing: Smoothing) {
        self.steps.push_back(Step::Smoothing { line, smoothing });
    }

    /// Emits the entry of the table of tool lengths.
    pub(super) fn choose_length(&mut self, line: u32, entry: LengthEntry) {
        self.steps.push_back(Step::LengthEntry { line, entry });
    }

    /// Returns the speed of the spindle \[1/min\] at a position of X, which a constant cutting speed
    /// depends on.
    pub(super) fn spindle_speed(&self, x: Option<f64>) -> Option<f64> {
        let Some(SurfaceSpeed { most }) = self.surface else { return Some(self.speed) };
        // S in m/min or ft/min, over the circumference in mm.
        let unit = if self.inch { 12.0 * INCH } else { 1000.0 };
        let turns = x.map(|x| unit * self.speed / (std::f64::consts::TAU * x.abs()));
        match (turns.filter(|turns| turns.is_finite()), most) {
            (Some(turns), Some(most)) => Some(turns.min(most)),
            (turns, most) => turns.or(most),
        }
    }

    /// Keeps words without motion.
    pub(super) fn keep(&mut self, line: u32, text: &str) {
        self.steps.push_back(Step::Words { line, text: text.trim().into() });
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

/// Turns a vector counterclockwise.
pub(super) fn rotate([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
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
pub(super) fn letter_index(letter: char) -> Option<usize> {
    let index = (letter as u32).checked_sub('A' as u32)?;
    usize::try_from(index).ok().filter(|index| *index < 26)
}
