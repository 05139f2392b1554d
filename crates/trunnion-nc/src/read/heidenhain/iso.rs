//! DIN/ISO programs of Heidenhain controls, `N10 G01 X+10 F500 *`: each block is read as the Klartext it stands for.

use crate::read::log::{ReadRemark, excerpt};
use std::fmt::Write as _;

/// Axis letters.
const AXES: &str = "XYZABCUVW";

/// Help for codes that are not read.
const KLARTEXT: &str = "convert the program to Klartext (.H), as the control's editor can";

/// Modal state of a DIN/ISO program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct IsoModes {
    /// The last of G00 to G16 that moves.
    motion: u32,
    /// G91.
    incremental: bool,
    /// Letter of the tool axis.
    tool_axis: char,
    /// Sense of the last arc, which G05 repeats.
    sense: Option<&'static str>,
}

/// Words of a block, by what they are for.
#[derive(Debug, Default)]
struct IsoBlock {
    codes: Vec<u32>,
    axes: Vec<(char, String)>,
    pole: Vec<(char, String)>,
    feed: Option<String>,
    speed: Option<String>,
    tool: Option<String>,
    radius: Option<String>,
    angle: Option<String>,
    label: Option<String>,
    functions: Vec<String>,
}

impl IsoModes {
    pub(super) fn new() -> Self {
        Self { motion: 1, incremental: false, tool_axis: 'Z', sense: None }
    }

    /// Returns the Klartext blocks that a block stands for.
    pub(super) fn translate(&mut self, code: &str, from: usize) -> Result<Vec<String>, ReadRemark> {
        let text = code.get(from..).unwrap_or_default().trim_end().trim_end_matches('*').trim_end();
        let number = text.strip_prefix(['N', 'n']);
        let digits = |c: char| c.is_ascii_digit();
        let words = number.map_or(text, |rest| rest.trim_start_matches(digits)).trim_start();
        if words.is_empty() {
            return Ok(Vec::new());
        }
        // The name of the program stands at its end, too.
        if words.starts_with('%') {
            return Ok(vec!["END PGM".to_owned()]);
        }
        let at = code.find(words).unwrap_or(from);
        if let Some(cycle) = cycle_of(words) {
            return Ok(vec![cycle]);
        }
        let block = IsoBlock::read(words, at)?;
        self.klartext(&block, at)
    }

    fn klartext(&mut self, block: &IsoBlock, at: usize) -> Result<Vec<String>, ReadRemark> {
        let mut lines = Vec::new();
        let (mut motion, mut corner) = (None, None);
        let (mut call, mut shift, mut still) = (false, false, false);
        for code in &block.codes {
            match code {
                0..=3 | 5 | 6 | 10..=13 | 15 | 16 => motion = Some(*code),
                17..=19 => {
                    self.tool_axis = match code {
                        18 => 'Y',
                        19 => 'X',
                        _ => 'Z',
                    };
                }
                // No compensation; a label.
                40 | 98 => {}
                90 | 91 => self.incremental = *code == 91,
                24 => corner = Some("CHF "),
                25 => corner = Some("RND R"),
                29 => lines.push("CC".to_owned()),
                38 => lines.push("STOP".to_owned()),
                54 => shift = true,
                79 => call = true,
                // Blank, definition of a tool: they move nothing.
                30 | 31 | 99 => still = true,
                4 => {
                    let time = block.feed.clone().unwrap_or_default();
                    return Ok(vec![
                        "CYCL DEF 9.0 DWELL TIME".into(),
                        format!("CYCL DEF 9.1 DWELL {time}"),
                    ]);
                }
                41..=44 => {
                    let message = format!("G{code}: cutter compensation needs the whole contour");
                    return Err(ReadRemark::new(
                        at,
                        message,
                        "post the path of the cutter's centre with G40",
                    ));
                }
                _ => {
                    let message = format!("G{code:02} is not understood as heidenhain DIN/ISO");
                    return Err(ReadRemark::new(at, message, KLARTEXT));
                }
            }
        }
        if still {
            return Ok(Vec::new());
        }
        if let Some(label) = &block.label {
            let sets = block.codes.contains(&98);
            return Ok(vec![if sets { format!("LBL {label}") } else { call_of(label) }]);
        }
        if let (Some(corner), Some(size)) = (corner, &block.radius) {
            let feed = block.feed.as_ref().map_or(String::new(), |feed| format!(" F{feed}"));
            return Ok(vec![format!("{corner}{size}{feed}")]);
        }
        if shift {
            lines.push("CYCL DEF 7.0 DATUM SHIFT".to_owned());
            lines.extend(
                block
                    .axes
                    .iter()
                    .map(|(axis, value)| format!("CYCL DEF 7.1 {}{axis}{value}", self.prefix())),
            );
            return Ok(lines);
        }
        if let Some(tool) = &block.tool {
            let mut line = format!("TOOL CALL {tool} {}", self.tool_axis);
            if let Some(speed) = &block.speed {
                _ = write!(line, " S{speed}");
            }
            if let Some(feed) = &block.feed {
                _ = write!(line, " F{feed}");
            }
            lines.push(line);
        }
        if !block.pole.is_empty() {
            let pole =
                block.pole.iter().map(|(axis, value)| format!(" {}{axis}{value}", self.prefix()));
            lines.push(format!("CC{}", pole.collect::<String>()));
        }
        self.motion = motion.unwrap_or(self.motion);
        lines.extend(self.moving_line(block, at)?);
        if call {
            lines.push("CYCL CALL".to_owned());
        }
        Ok(lines)
    }

    /// Returns the Klartext of the move of a block, with its feed and functions.
    fn moving_line(&mut self, block: &IsoBlock, at: usize) -> Result<Option<String>, ReadRemark> {
        let moves = !block.axes.is_empty() || block.radius.is_some() || block.angle.is_some();
        let mut line = if moves { self.path(block, at)? } else { "L".to_owned() };
        if block.tool.is_none() {
            if let Some(feed) = &block.feed {
                _ = write!(line, " F{feed}");
            }
            if let Some(speed) = &block.speed {
                _ = write!(line, " S{speed}");
            }
        }
        if moves && matches!(self.motion, 0 | 10) {
            line.push_str(" FMAX");
        }
        for function in &block.functions {
            _ = write!(line, " M{function}");
        }
        Ok((line != "L").then_some(line))
    }

    fn prefix(&self) -> &'static str {
        if self.incremental { "I" } else { "" }
    }

    /// Returns the Klartext of a move, without feed and functions.
    fn path(&mut self, block: &IsoBlock, at: usize) -> Result<String, ReadRemark> {
        self.sense = match self.motion {
            2 | 12 => Some("DR-"),
            3 | 13 => Some("DR+"),
            _ => self.sense,
        };
        let sense = || {
            self.sense.ok_or_else(|| {
                let message = "G05 or G15 without an arc before it";
                ReadRemark::new(at, message, "write G02 or G03, G12 or G13")
            })
        };
        let mut ends: String = block
            .axes
            .iter()
            .map(|(axis, value)| format!(" {}{axis}{value}", self.prefix()))
            .collect();
        let polar = matches!(self.motion, 10..=16);
        if let (true, Some(angle)) = (polar, &block.angle) {
            _ = write!(ends, " {}PA{angle}", self.prefix());
        }
        if let (true, Some(radius)) = (polar, &block.radius) {
            _ = write!(ends, " {}PR{radius}", self.prefix());
        }
        Ok(match (self.motion, &block.radius) {
            (0 | 1, None) => format!("L{ends}"),
            (2 | 3 | 5, Some(radius)) => format!("CR{ends} R{radius} {}", sense()?),
            (2 | 3 | 5, None) => format!("C{ends} {}", sense()?),
            (6, None) => format!("CT{ends}"),
            (10 | 11, _) => format!("LP{ends}"),
            (12 | 13 | 15, None) => format!("CP{ends} {}", sense()?),
            (16, _) => format!("CTP{ends}"),
            (motion, _) => {
                let message = format!("R beside G{motion:02}");
                return Err(ReadRemark::new(at, message, KLARTEXT));
            }
        })
    }
}

impl IsoBlock {
    fn read(words: &str, at: usize) -> Result<Self, ReadRemark> {
        let mut block = Self::default();
        let mut rest = words.trim_start();
        while let Some(letter) = rest.chars().next() {
            let wrong = |rest: &str| {
                let message = format!("{} is not understood as heidenhain DIN/ISO", excerpt(rest));
                ReadRemark::new(at + words.len() - rest.len(), message, KLARTEXT)
            };
            let letter = letter.to_ascii_uppercase();
            let body = rest.get(1..).ok_or_else(|| wrong(rest))?.trim_start();
            let length = value_length(body);
            let (value, behind) = body.split_at(length);
            let value = value.to_owned();
            if value.is_empty() {
                return Err(wrong(rest));
            }
            match letter {
                'G' => block.codes.push(value.parse().map_err(|_| wrong(rest))?),
                'I' => block.pole.push(('X', value)),
                'J' => block.pole.push(('Y', value)),
                'K' => block.pole.push(('Z', value)),
                'F' => block.feed = Some(value),
                'S' => block.speed = Some(value),
                'T' => block.tool = Some(value),
                'R' => block.radius = Some(value),
                'H' => block.angle = Some(value),
                'L' => block.label = Some(value),
                'M' => block.functions.push(value),
                letter if AXES.contains(letter) => block.axes.push((letter, value)),
                _ => return Err(wrong(rest)),
            }
            rest = behind.trim_start();
        }
        Ok(block)
    }
}

/// Returns the bytes of `+10.5`, `-Q1`, `1,3`, `MAX`.
fn value_length(text: &str) -> usize {
    let upper = text.get(..3).unwrap_or_default().to_ascii_uppercase();
    if upper == "MAX" {
        return 3;
    }
    let sign = text.len() - text.trim_start_matches(['+', '-']).len();
    let body = text.get(sign..).unwrap_or_default();
    let parameter = body.len() - body.trim_start_matches(['Q', 'q']).len();
    let digits = |c: char| !(c.is_ascii_digit() || c == '.' || c == ',');
    let body = body.get(parameter..).unwrap_or_default();
    let length = body.find(digits).unwrap_or(body.len());
    if length == 0 { 0 } else { sign + parameter + length }
}

/// Returns the Klartext of `L1,3`, `L1`.
fn call_of(label: &str) -> String {
    match label.split_once([',', '.']) {
        Some((label, count)) if count.trim_start_matches('0').is_empty() => {
            format!("CALL LBL {label}")
        }
        Some((label, count)) => format!("CALL LBL {label} REP {count}"),
        None => format!("CALL LBL {label}"),
    }
}

/// Returns the Klartext of a cycle with Q parameters, `G200 Q200=2 Q201=-20`.
fn cycle_of(words: &str) -> Option<String> {
    let rest = words.strip_prefix(['G', 'g'])?;
    let number = rest.get(..3).filter(|digits| digits.bytes().all(|byte| byte.is_ascii_digit()))?;
    let behind = rest.get(3..).unwrap_or_default();
    (!behind.starts_with(|c: char| c.is_ascii_digit()))
        .then(|| format!("CYCL DEF {number}{behind}"))
}
