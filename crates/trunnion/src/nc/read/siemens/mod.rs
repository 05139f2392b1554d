//! Sinumerik programs: `X10`, `A3=0.5`, `C=ACP(33)`, `CYCLE832(..)`, `R1=5`.

mod codes;
mod flow;
mod value;
mod word;

use super::arc::{self, Form, Given};
use super::control::{LARGEST, SLOTS, Target};
use super::gcode::axis_of;
use super::log::{Remark, column};
use super::reader::State;
use super::{Pace, ReadOptions, Step, Turning, Way};
use flow::{Flow, Head};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::f64::consts::TAU;
use value::Mode;
use word::{Item, Name};

/// What axis words do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Rapid,
    Feed,
    Arc { clockwise: bool },
}

/// Reader of Sinumerik programs.
#[derive(Debug)]
pub(super) struct Siemens {
    motion: Option<Motion>,
    incremental: bool,
    /// 0: XY, 1: ZX, 2: YZ.
    plane: usize,
    /// R parameters and variables, upper case.
    variables: HashMap<Box<str>, f64>,
    flow: Flow,
    lines: u32,
    block_delete: Option<bool>,
}

/// What one block says.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "what a block may say")]
struct Line {
    target: Target,
    /// `A3= B3= C3=`.
    vector: [Option<f64>; 3],
    /// `I J K`, and whether absolute.
    center: [Option<(f64, bool)>; 3],
    radius: Option<f64>,
    turns: u32,
    feed: Option<f64>,
    speed: Option<f64>,
    dwell: bool,
    machine: bool,
    motion: bool,
    tool: Option<u32>,
    changes_tool: bool,
    turns_spindle: bool,
    /// `TRANS`, `ATRANS`.
    shift: Option<bool>,
    ends: bool,
}

impl Line {
    fn new() -> Self {
        Self {
            target: Target::new(usize::MAX, 1),
            vector: [None; 3],
            center: [None; 3],
            radius: None,
            turns: 0,
            feed: None,
            speed: None,
            dwell: false,
            machine: false,
            motion: false,
            tool: None,
            changes_tool: false,
            turns_spindle: false,
            shift: None,
            ends: false,
        }
    }
}

impl Siemens {
    pub(super) fn new(options: &ReadOptions) -> Self {
        let name = |name: &str| name.trim().to_ascii_uppercase().into_boxed_str();
        let given = options.parameters.iter().map(|(key, value)| (name(key), *value));
        Self {
            motion: None,
            incremental: false,
            plane: 0,
            variables: given.collect(),
            flow: Flow::new(options.most_repeated),
            lines: 0,
            block_delete: options.block_delete,
        }
    }

    /// There are lines to run before the file's next.
    pub(super) fn is_busy(&self) -> bool {
        self.flow.tape.is_busy()
    }

    /// Runs one of them.
    pub(super) fn advance(&mut self, state: &mut State) {
        match self.flow.tape.play() {
            Ok(Some((number, text))) => self.run_line(state, (number, &text)),
            Ok(None) => {}
            Err(remark) => {
                state.log.fault("", remark);
                state.control.ended = true;
            }
        }
    }

    /// What is missing at the end.
    pub(super) fn finish(&self, state: &mut State) {
        if let Some((line, remark)) = self.flow.open().filter(|_| !state.control.ended) {
            state.log.line = line;
            state.log.fault("", remark);
        } else if !state.control.ended {
            let message = "the program has no end: a line is missing, or the file was cut";
            state.log.whole(message, "end it with M30, M17 or RET");
        }
    }

    /// Reads a line of the file.
    pub(super) fn line(&mut self, state: &mut State, text: &str) {
        self.lines = self.lines.saturating_add(1);
        self.flow.tape.record(self.lines, text);
        self.run_line(state, (self.lines, text));
    }

    fn run_line(&mut self, state: &mut State, (number, text): (u32, &str)) {
        state.log.line = number;
        let code = word::without_comment(text);
        state.control.length |= self.lines == 1;
        let start = code.len() - code.trim_start().len();
        // `%_N_NAME_MPF`, `$PATH=..`: names of the file.
        if code.trim().is_empty() || code.trim_start().starts_with(['%', '$']) {
            return;
        }
        let mut from = start;
        if code.as_bytes().get(from) == Some(&b'/') {
            match self.block_delete {
                Some(true) => from += 1,
                Some(false) => return,
                None => {
                    let message = "block delete: whether the control runs this block is not known";
                    let help = "say when reading whether such blocks are run";
                    return state.log.fault(text, Remark::new(from, message, help));
                }
            }
        }
        let head = Head::of(code, from);
        if head.may_return() {
            self.flow.tape.keep(text);
        }
        if self.flow.passes(&head) {
            return;
        }
        let done = match head.word {
            Some(word) => self.decide(state, (code, &head), word),
            None => self.block(state, code, head.at),
        };
        if let Err(remark) = done {
            state.log.fault(text, remark);
        }
    }

    fn block(&mut self, state: &mut State, code: &str, from: usize) -> Result<(), Remark> {
        let mut items = word::Items::new(code, from);
        let mut line = Line::new();
        while let Some(item) = items.next_item()? {
            match item.name {
                Name::Code(letter, tenths) if item.is_code() => {
                    self.code(state, &mut line, (&item, letter, tenths, code))?;
                }
                _ => self.word(state, &mut line, (&item, code))?,
            }
        }
        if line.target.at == usize::MAX {
            line.target.at = from;
        }
        line.target.column = column(code, line.target.at);
        self.run(state, line)
    }

    /// A word that carries a value, or a call.
    fn word(
        &mut self,
        state: &mut State,
        line: &mut Line,
        (item, code): (&Item<'_>, &str),
    ) -> Result<(), Remark> {
        let name = item.text_name().to_ascii_uppercase();
        let named = name.bytes().take(2).all(|byte| byte.is_ascii_alphabetic() || byte == b'_');
        let known = name.len() > 1 && named && self.variables.contains_key(name.as_str());
        if (known || item.number_of("R").is_some()) && item.is_assignment() {
            let (value, _) = self.value(item)?;
            self.variables.insert(name.into(), value.number);
            // From here on a loop may count, and lead back to any block number.
            self.flow.tape.keep(code);
            return Ok(());
        }
        if let Some(at) = ["A3", "B3", "C3"].iter().position(|known| *known == name) {
            if let Some(place) = line.vector.get_mut(at) {
                *place = Some(self.value(item)?.0.number);
            }
            line.target.at = line.target.at.min(item.at);
            return Ok(());
        }
        match name.as_str() {
            "I" | "J" | "K" => self.center(state, line, (item, &name)),
            "CR" => {
                line.radius = Some(state.control.scale() * self.value(item)?.0.number);
                Ok(())
            }
            "TURN" => {
                line.turns = value::natural(self.value(item)?.0.number, item.at)?;
                Ok(())
            }
            "F" => {
                let value = self.value(item)?.0;
                state.control.note_feed(value.decimals);
                line.feed = Some(value.number);
                Ok(())
            }
            "S" => {
                line.speed = Some(self.value(item)?.0.number);
                Ok(())
            }
            "T" => self.tool(state, line, (item, code)),
            "D" => {
                let length = self.value(item)?.0.number.abs() > 0.0;
                state.control.set_length(length);
                Ok(())
            }
            "N" | "H" => Ok(()),
            _ => self.axis_or_keyword(state, line, (item, &name, code)),
        }
    }

    fn center(
        &self,
        state: &State,
        line: &mut Line,
        (item, name): (&Item<'_>, &str),
    ) -> Result<(), Remark> {
        let (value, mode) = self.value(item)?;
        let at = usize::from(name.as_bytes().first().map_or(0, |byte| byte - b'I'));
        if let Some(place) = line.center.get_mut(at) {
            *place = Some((state.control.scale() * value.number, mode == Mode::Absolute));
        }
        Ok(())
    }

    /// `T="NAME"` or `T5`: a name is kept, and counts as the number in it.
    fn tool(
        &self,
        state: &mut State,
        line: &mut Line,
        (item, code): (&Item<'_>, &str),
    ) -> Result<(), Remark> {
        let number = if let Some(name) = item.quoted() {
            let text = code.get(item.at..item.end).unwrap_or_default();
            state.control.keep(state.log.line, text);
            let digits = name.chars().filter(char::is_ascii_digit).take(9).collect::<String>();
            digits.parse().unwrap_or(0)
        } else {
            value::natural(self.value(item)?.0.number, item.at)?
        };
        line.tool = Some(number);
        Ok(())
    }

    /// `X10`, `X=IC(2)`, `C=ACP(33)`; or a word without motion.
    fn axis_or_keyword(
        &mut self,
        state: &mut State,
        line: &mut Line,
        (item, name, code): (&Item<'_>, &str, &str),
    ) -> Result<(), Remark> {
        let slot = match name.as_bytes() {
            [letter] => state.control.slot(*letter),
            _ => None,
        };
        let Some(slot) = slot else {
            if matches!(name.as_bytes(), [b'A'..=b'Z']) && item.has_value() {
                let text = code.get(item.at..item.end).unwrap_or_default();
                return Err(state.control.no_axis(item.at, text));
            }
            return Self::keyword(state, line, (item, name, code));
        };
        let (value, mode) = self.value(item)?;
        if line.target.get(slot).is_some() {
            let message = format!("second {name} word on this line");
            return Err(Remark::new(item.at, message, "keep one of them"));
        }
        if value.number.abs() > LARGEST {
            let message = format!("{name} is beyond {LARGEST} mm or degrees");
            return Err(Remark::new(item.at, message, "is a point missing?"));
        }
        let meant = state.control.meant(slot, value.number, value.decimals);
        let incremental = match mode {
            Mode::Plain => self.incremental,
            Mode::Incremental => true,
            _ => false,
        };
        let meant = unwound(state, (slot, meant, mode), item)?;
        line.target.set(slot, meant, incremental);
        line.target.at = line.target.at.min(item.at);
        Ok(())
    }

    /// Does what a block says.
    fn run(&mut self, state: &mut State, mut line: Line) -> Result<(), Remark> {
        technology(state, &line)?;
        if line.dwell {
            return dwell(state, &line);
        }
        if let Some(further) = line.shift {
            shift(state, &line, further);
            return Ok(());
        }
        if line.vector.iter().any(Option::is_some) {
            check_vector(state, &line)?;
            let [a, b, c] = line.vector.map(|value| value.unwrap_or(0.0));
            line.target.axis = Some(axis_of(Vector3::new(a, b, c), line.target.at)?);
        }
        line.target.machine = line.machine;
        let centered = line.center.iter().any(Option::is_some) || line.radius.is_some();
        let arc = matches!(self.motion, Some(Motion::Arc { .. }));
        if !line.target.is_empty() || (arc && centered) {
            self.go(state, &line)?;
        }
        state.control.ended |= line.ends;
        Ok(())
    }

    fn go(&mut self, state: &mut State, line: &Line) -> Result<(), Remark> {
        let target = line.target;
        let motion = self.motion.ok_or_else(|| {
            Remark::new(target.at, "axis words without G0 or G1", "write G0 or G1 before them")
        })?;
        let way = match motion {
            Motion::Arc { clockwise } => self.arc(state, line, clockwise)?,
            _ => Way::Line,
        };
        let pace = match motion {
            Motion::Rapid => Pace::Rapid,
            _ => state.control.pace(&target, line.feed)?,
        };
        state.control.go(state.log.line, target, (pace, way))
    }

    fn arc(&self, state: &State, line: &Line, clockwise: bool) -> Result<Way, Remark> {
        let at = line.target.at;
        let [u, v] = match self.plane {
            1 => [2, 0],
            2 => [1, 2],
            _ => [0, 1],
        };
        let slots = [u, v].map(|axis: usize| state.control.xyz[axis]);
        let form = if let Some(radius) = line.radius {
            Form::Radius(radius)
        } else {
            if line.center[u].is_none() && line.center[v].is_none() {
                let message = "arcs need their centre or radius";
                return Err(Remark::new(at, message, "write I J K of this plane, or CR="));
            }
            let from_start = |axis: usize, slot: usize| match line.center[axis] {
                None => Ok(0.0),
                Some((value, false)) => Ok(value),
                Some((value, true)) => {
                    let place = state.control.reading(slot);
                    Ok(value - place.ok_or_else(|| arc::unknown_start(at))?)
                }
            };
            Form::Center([from_start(u, slots[0])?, from_start(v, slots[1])?])
        };
        let turns = line.turns.saturating_add(1);
        arc::way(&state.control, &line.target, &Given { plane: slots, form, clockwise, turns })
    }
}

/// `G4 F2` seconds, `G4 S10` turns.
fn dwell(state: &mut State, line: &Line) -> Result<(), Remark> {
    let seconds = match (line.feed, line.speed) {
        (Some(seconds), None) => seconds,
        (None, Some(turns)) if state.control.speed > 0.0 => 60.0 * turns / state.control.speed,
        _ => {
            let message = "G4 without a time";
            return Err(Remark::new(line.target.at, message, "write G4 F and the seconds"));
        }
    };
    if !(seconds >= 0.0 && line.target.is_empty()) {
        return Err(Remark::new(line.target.at, "G4 beside other words", "put it on its own line"));
    }
    let line = state.log.line;
    state.control.steps.push_back(Step::Dwell { line, seconds });
    Ok(())
}

/// `TRANS X Y Z`, `ATRANS`: words are shifted.
fn shift(state: &mut State, line: &Line, further: bool) {
    if !further {
        state.control.local = [0.0; SLOTS];
    }
    for slot in 0..SLOTS {
        if let (Some(word), Some(local)) =
            (line.target.get(slot), state.control.local.get_mut(slot))
        {
            *local += word;
        }
    }
}

/// How the tool turns from now on.
fn set_turning(state: &mut State, great_circle: bool) {
    state.control.turning = if great_circle { Turning::GreatCircle } else { Turning::Rotary };
}

/// `DC`, `ACP`, `ACN`: the way round that leads to an angle.
fn unwound(
    state: &mut State,
    (slot, meant, mode): (usize, f64, Mode),
    item: &Item<'_>,
) -> Result<f64, Remark> {
    if !matches!(mode, Mode::Shortest | Mode::Positive | Mode::Negative) {
        return Ok(meant);
    }
    if !state.control.is_rotary(slot) {
        let help = "write AC(..)";
        return Err(Remark::new(item.at, "DC, ACP and ACN are of rotary axes", help));
    }
    let Some(stands) = state.control.reading(slot) else {
        let message = "DC, ACP or ACN before the axis stands anywhere: taken as written";
        state.log.warn(item.line, Remark::new(item.at, message, ""));
        return Ok(meant);
    };
    // The control's positive sense is the other one where the axis is reversed.
    let positive = mode == Mode::Positive;
    let up = (meant - stands).rem_euclid(TAU);
    let way = match mode {
        Mode::Shortest if up > 0.5 * TAU => up - TAU,
        Mode::Shortest => up,
        _ if positive != state.control.is_reversed(slot) => up,
        _ if up > 0.0 => up - TAU,
        _ => 0.0,
    };
    Ok(stands + way)
}

fn check_vector(state: &State, line: &Line) -> Result<(), Remark> {
    if !state.control.tcp {
        let message = "a tool-axis vector without TRAORI";
        return Err(Remark::new(line.target.at, message, "write TRAORI before"));
    }
    let rotary = (0..SLOTS).any(|s| line.target.get(s).is_some() && state.control.is_rotary(s));
    if rotary || line.machine {
        let message = "a tool-axis vector beside rotary words or SUPA";
        return Err(Remark::new(line.target.at, message, "keep one of them"));
    }
    Ok(())
}

/// F, S, T, M6, M3.
fn technology(state: &mut State, line: &Line) -> Result<(), Remark> {
    let at = line.target.at;
    let control = &mut state.control;
    if let (Some(feed), false) = (line.feed, line.dwell) {
        if !(feed > 0.0 && feed.is_finite()) {
            return Err(Remark::new(at, format!("F{feed} is no feed"), "give one above 0"));
        }
        control.feed = Some(feed);
    }
    if let Some(tool) = line.tool {
        control.tool = tool;
    }
    if line.changes_tool {
        let tool = control.tool;
        control.change_tool(state.log.line, tool);
    }
    let speed = line.speed.filter(|_| !line.dwell);
    let turned = speed.is_some_and(|speed| (speed - control.speed).abs() > 0.0);
    control.speed = speed.unwrap_or(control.speed);
    if line.turns_spindle || (turned && control.sense != 0) {
        control.spindle(state.log.line);
    }
    Ok(())
}
