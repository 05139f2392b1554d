//! The control's modal state, and what one line makes of it.

use super::lexer::Word;
use super::{AxisWords, Frame, Move, Pace, Step, Turning, Way};
use crate::types::AXES;

/// A fault on a line: byte offset, what is wrong, what to do.
pub(super) struct LineFault {
    pub(super) at: usize,
    pub(super) message: String,
    pub(super) help: &'static str,
}

/// Largest coordinate a program may ask for \[mm or degrees\]: beyond it is a slip, not a machine.
const LARGEST: f64 = 1e6;
/// Millimetres in an inch, by definition.
const INCH: f64 = 25.4;

/// How a block moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Course {
    Rapid,
    Feed,
}

/// Everything a control remembers from line to line.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "modal switches are what a control has")]
pub(super) struct Modal {
    course: Option<Course>,
    incremental: bool,
    inch: bool,
    inverse_time: bool,
    /// F as written under `G94`, in mm or inch units per minute.
    feed: Option<f64>,
    offset: u8,
    length: bool,
    tcp: bool,
    tool: u32,
    /// Tools that `M6` put into the spindle.
    pub(super) tools: Vec<u32>,
    /// `M2` or `M30` was read.
    pub(super) ended: bool,
    /// Smallest last digit of each axis word so far \[mm or degrees\]; 0 before the first.
    pub(super) finest_units: [f64; AXES],
    /// The same of the feed words.
    pub(super) finest_feed: f64,
}

/// What stands on one line.
struct Line {
    axes: [Option<f64>; AXES],
    feed: Option<f64>,
    dwell: Option<f64>,
    machine_frame: bool,
    is_dwell: bool,
    groups: u32,
    /// Letters that are only allowed beside certain G codes, with their places.
    arguments: [Option<usize>; 2],
    first_axis: usize,
    faults: Vec<LineFault>,
}

/// Modal groups, as bits: two codes of one group cannot stand on one line.
mod group {
    pub(super) const NONMODAL: u32 = 1;
    pub(super) const COURSE: u32 = 1 << 1;
    pub(super) const PLANE: u32 = 1 << 2;
    pub(super) const UNITS: u32 = 1 << 3;
    pub(super) const DISTANCE: u32 = 1 << 4;
    pub(super) const FEED: u32 = 1 << 5;
    pub(super) const RADIUS: u32 = 1 << 6;
    pub(super) const LENGTH: u32 = 1 << 7;
    pub(super) const OFFSET: u32 = 1 << 8;
    pub(super) const BLEND: u32 = 1 << 9;
    pub(super) const ARC: u32 = 1 << 10;
    pub(super) const STOP: u32 = 1 << 11;
    pub(super) const SPINDLE: u32 = 1 << 12;
    pub(super) const TOOL: u32 = 1 << 13;
    pub(super) const TCP: u32 = 1 << 14;
}

impl Modal {
    /// What a control knows after `G21 G90 G94 G54 G49`; a program that relies on anything else
    /// has to say so.
    pub(super) fn new() -> Self {
        Self {
            course: None,
            incremental: false,
            inch: false,
            inverse_time: false,
            feed: None,
            offset: 0,
            length: false,
            tcp: false,
            tool: 0,
            tools: Vec::new(),
            ended: false,
            finest_units: [0.0; AXES],
            finest_feed: 0.0,
        }
    }

    /// Takes in the words of one line; the step it makes, if it makes one.
    pub(super) fn line(
        &mut self,
        words: &[Word<'_>],
        axes: &AxisWords,
        number: u32,
    ) -> Result<Option<Step>, Vec<LineFault>> {
        let mut line = Line::new();
        // G and M first: units and modes hold for the whole line, wherever they stand on it.
        for word in words {
            match word.letter {
                'G' => self.g_code(&mut line, word),
                'M' => self.m_code(&mut line, word),
                'T' => self.tool = line.natural(word).unwrap_or(0),
                _ => {}
            }
        }
        for word in words {
            self.value(&mut line, word, axes, words.len());
        }
        line.check_arguments();
        if line.has(group::TOOL) {
            self.tools.push(self.tool);
        }
        let step = self.step(&mut line, number);
        if line.faults.is_empty() { Ok(step) } else { Err(line.faults) }
    }

    /// A G code.
    fn g_code(&mut self, line: &mut Line, word: &Word<'_>) {
        let tenths = tenths(word);
        let group = match tenths {
            Some(40) => {
                line.is_dwell = true;
                group::NONMODAL
            }
            Some(530) => {
                line.machine_frame = true;
                group::NONMODAL
            }
            Some(0) => self.set(|m| m.course = Some(Course::Rapid), group::COURSE),
            Some(10) => self.set(|m| m.course = Some(Course::Feed), group::COURSE),
            Some(800) => self.set(|m| m.course = None, group::COURSE),
            Some(170 | 180 | 190) => group::PLANE,
            Some(200) => self.set(|m| m.inch = true, group::UNITS),
            Some(210) => self.set(|m| m.inch = false, group::UNITS),
            Some(900) => self.set(|m| m.incremental = false, group::DISTANCE),
            Some(910) => self.set(|m| m.incremental = true, group::DISTANCE),
            Some(930) => self.set(|m| m.feed_mode(true), group::FEED),
            Some(940) => self.set(|m| m.feed_mode(false), group::FEED),
            Some(400) => group::RADIUS,
            Some(430) => self.set(|m| m.length = true, group::LENGTH),
            Some(434 | 2340) => self.set(|m| (m.length, m.tcp) = (true, true), group::LENGTH),
            Some(490) => self.set(|m| (m.length, m.tcp) = (false, false), group::LENGTH),
            Some(code @ (540 | 550 | 560 | 570 | 580 | 590 | 591 | 592 | 593)) => {
                let offset = if code > 590 { code - 591 + 6 } else { (code - 540) / 10 };
                self.offset = u8::try_from(offset).unwrap_or(u8::MAX);
                group::OFFSET
            }
            Some(610 | 611 | 640) => group::BLEND,
            Some(901 | 911) => group::ARC,
            _ => return line.not_understood(word),
        };
        line.enter(group, word);
    }

    /// Changes the state and hands the group through.
    fn set(&mut self, change: impl FnOnce(&mut Self), group: u32) -> u32 {
        change(self);
        group
    }

    /// `G93` and `G94`: a feed of the one means nothing to the other.
    fn feed_mode(&mut self, inverse_time: bool) {
        if self.inverse_time != inverse_time {
            self.feed = None;
        }
        self.inverse_time = inverse_time;
    }

    /// An M code.
    fn m_code(&mut self, line: &mut Line, word: &Word<'_>) {
        let group = match tenths(word) {
            Some(0 | 10) => group::STOP,
            Some(20 | 300) => self.set(|m| m.ended = true, group::STOP),
            Some(30 | 40 | 50) => group::SPINDLE,
            Some(60) => group::TOOL,
            Some(70 | 80 | 90 | 480 | 490) => 0,
            Some(4280) => self.set(|m| m.tcp = true, group::TCP),
            Some(4290) => self.set(|m| m.tcp = false, group::TCP),
            _ => return line.not_understood(word),
        };
        line.enter(group, word);
    }

    /// A word that carries a value.
    fn value(&mut self, line: &mut Line, word: &Word<'_>, axes: &AxisWords, count: usize) {
        match word.letter {
            'G' | 'M' | 'T' => {}
            'O' if count == 1 => _ = line.natural(word),
            'N' | 'H' | 'D' => _ = line.natural(word),
            'S' if word.value >= 0.0 => {}
            'F' => {
                if line.feed.replace(word.value).is_some() {
                    line.twice(word);
                }
                if !(word.value > 0.0 && word.value <= f64::MAX) {
                    line.fault(word, format!("{} is no feed", word.text), "give one above 0");
                }
                finer(&mut self.finest_feed, word.decimals, if self.inch { INCH } else { 1.0 });
            }
            'P' | 'Q' => line.argument(word),
            letter => match axes.index_of(letter) {
                Some(index) => self.axis(line, word, axes, index),
                None => line.no_such_word(word, axes),
            },
        }
    }

    /// An axis word.
    fn axis(&mut self, line: &mut Line, word: &Word<'_>, axes: &AxisWords, index: usize) {
        let (Some(format), Some(place)) = (axes.0.get(index), line.axes.get_mut(index)) else {
            return;
        };
        let scale = if self.inch && !format.rotary { INCH } else { 1.0 };
        let written = word.value * scale;
        if place.replace(format.meant(written)).is_some() {
            line.twice(word);
        }
        if written.abs() > LARGEST {
            let message = format!("{} is beyond {LARGEST} mm or degrees", word.text);
            line.fault(word, message, "");
        }
        line.first_axis = line.first_axis.min(word.at);
        if let Some(unit) = self.finest_units.get_mut(index) {
            finer(unit, word.decimals, scale);
        }
    }

    /// The step that a line without faults makes.
    fn step(&mut self, line: &mut Line, number: u32) -> Option<Step> {
        if let (Some(feed), false) = (line.feed, self.inverse_time) {
            self.feed = Some(feed);
        }
        let moves = line.axes.iter().any(Option::is_some);
        if line.is_dwell {
            return dwell(line, number, moves);
        }
        if !moves {
            if line.machine_frame {
                line.plain_fault(0, "G53 without axis words", "name the axes that are to move");
            }
            return None;
        }
        let Some(course) = self.course else {
            let at = line.first_axis;
            line.plain_fault(at, "axis words without G0 or G1", "write G0 or G1 before them");
            return None;
        };
        if line.machine_frame && self.incremental {
            line.plain_fault(line.first_axis, "G53 with distances (G91)", "write G90");
        }
        let pace = self.pace(line, course)?;
        let frame = if line.machine_frame {
            Frame::Machine
        } else {
            Frame::Work { offset: self.offset, length: self.length, tcp: self.tcp }
        };
        let incremental = self.incremental;
        Some(Step::Move(Move {
            line: number,
            column: u32::try_from(line.first_axis + 1).unwrap_or(u32::MAX),
            words: line.axes,
            sixth: None,
            incremental,
            frame,
            plane: 0,
            axis: None,
            pace,
            way: Way::Line,
            turning: Turning::Rotary,
        }))
    }

    /// How fast a block with axis words is run; faults if no feed is known.
    fn pace(&self, line: &mut Line, course: Course) -> Option<Pace> {
        if course == Course::Rapid {
            return Some(Pace::Rapid);
        }
        let scale = if self.inch { INCH } else { 1.0 };
        let pace = if self.inverse_time {
            line.feed.map(|feed| Pace::Inverse { seconds: 60.0 / feed })
        } else {
            self.feed.map(|feed| Pace::PerMinute { speed: feed * scale / 60.0 })
        };
        if pace.is_none() {
            let help = if self.inverse_time {
                "G93 needs an F word on every G1 line"
            } else {
                "write an F word; G93 and G94 do not share one"
            };
            line.plain_fault(line.first_axis, "feed move without a feed", help);
        }
        pace
    }
}

/// `G4 P`.
fn dwell(line: &mut Line, number: u32, moves: bool) -> Option<Step> {
    if moves {
        let at = line.first_axis;
        line.plain_fault(at, "axis words beside G4", "put them on a line of their own");
    }
    match line.dwell {
        Some(seconds) if seconds >= 0.0 => Some(Step::Dwell { line: number, seconds }),
        _ => {
            line.plain_fault(0, "G4 without a time", "write G4 P and the seconds");
            None
        }
    }
}

/// Notes that a word has `decimals` digits after its point.
fn finer(finest: &mut f64, decimals: u8, scale: f64) {
    let unit = scale * 10f64.powi(-i32::from(decimals));
    if *finest <= 0.0 || unit < *finest {
        *finest = unit;
    }
}

/// A code number in tenths: `43.4` is 434.
fn tenths(word: &Word<'_>) -> Option<u32> {
    let tenths = (word.value * 10.0).round();
    let whole = (tenths - word.value * 10.0).abs() < 1e-6 && (0.0..1e5).contains(&tenths);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    whole.then_some(tenths as u32)
}

impl Line {
    fn new() -> Self {
        Self {
            axes: [None; AXES],
            feed: None,
            dwell: None,
            machine_frame: false,
            is_dwell: false,
            groups: 0,
            arguments: [None; 2],
            first_axis: usize::MAX,
            faults: Vec::new(),
        }
    }

    fn has(&self, group: u32) -> bool {
        self.groups & group != 0
    }

    /// Notes that a group has spoken; twice is a fault.
    fn enter(&mut self, group: u32, word: &Word<'_>) {
        if self.has(group) {
            let message = format!("{} contradicts another code on this line", word.text);
            self.fault(word, message, "keep one of them");
        }
        self.groups |= group;
    }

    fn fault(&mut self, word: &Word<'_>, message: String, help: &'static str) {
        self.faults.push(LineFault { at: word.at, message, help });
    }

    fn plain_fault(&mut self, at: usize, message: &str, help: &'static str) {
        let at = if at == usize::MAX { 0 } else { at };
        self.faults.push(LineFault { at, message: message.to_owned(), help });
    }

    fn not_understood(&mut self, word: &Word<'_>) {
        let message = format!("{} is not understood", word.text);
        let help = match (word.letter, tenths(word)) {
            ('G', Some(20 | 30)) => "arcs are not replayed; post the program with straight moves",
            ('G', Some(280 | 300)) => "write the positions with G53 G0",
            ('M', _) => "it may move the machine; leave it out of the program to be checked",
            _ => "",
        };
        self.fault(word, message, help);
    }

    fn no_such_word(&mut self, word: &Word<'_>, axes: &AxisWords) {
        let message = format!("{} is not understood: the machine's axes are {axes}", word.text);
        self.fault(word, message, "");
    }

    fn twice(&mut self, word: &Word<'_>) {
        let message = format!("second {} word on this line", word.letter);
        self.fault(word, message, "keep one of them");
    }

    /// `P` and `Q`, which mean something only beside `G4` and `G64`.
    fn argument(&mut self, word: &Word<'_>) {
        let place = usize::from(word.letter == 'Q');
        if word.letter == 'P' {
            self.dwell = Some(word.value);
        }
        if let Some(argument) = self.arguments.get_mut(place)
            && argument.replace(word.at).is_some()
        {
            self.twice(word);
        }
    }

    /// `P` only beside `G4` or `G64`, `Q` only beside `G64`.
    fn check_arguments(&mut self) {
        let blend = self.has(group::BLEND);
        let [p, q] = self.arguments;
        if let (Some(at), false) = (p, blend || self.is_dwell) {
            self.plain_fault(at, "P word without G4 or G64", "leave it out");
        }
        if let (Some(at), false) = (q, blend) {
            self.plain_fault(at, "Q word without G64", "leave it out");
        }
    }

    /// A number that counts something.
    fn natural(&mut self, word: &Word<'_>) -> Option<u32> {
        let whole = word.value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&word.value);
        if !whole {
            let message = format!("{} must be a whole number from 0", word.text);
            self.fault(word, message, "");
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        whole.then_some(word.value as u32)
    }
}
