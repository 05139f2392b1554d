//! G and M codes, and the words that belong to no motion.

use super::super::control::{Control, FeedMode};
use super::super::log::Remark;
use super::super::{Dialect, Step, Turning};
use super::block::{Block, Code, Word};
use super::{Gcode, Motion, State};

/// Modal groups, as bits: two codes of one group cannot stand on one line.
pub(super) mod group {
    pub(in super::super) const NONE: u32 = 0;
    pub(in super::super) const NONMODAL: u32 = 1;
    pub(in super::super) const MOTION: u32 = 1 << 1;
    pub(in super::super) const PLANE: u32 = 1 << 2;
    pub(in super::super) const UNITS: u32 = 1 << 3;
    pub(in super::super) const DISTANCE: u32 = 1 << 4;
    pub(in super::super) const FEED: u32 = 1 << 5;
    pub(in super::super) const LENGTH: u32 = 1 << 6;
    pub(in super::super) const OFFSET: u32 = 1 << 7;
    pub(in super::super) const BLEND: u32 = 1 << 8;
    pub(in super::super) const ARC: u32 = 1 << 9;
    pub(in super::super) const RETRACT: u32 = 1 << 10;
    pub(in super::super) const STOP: u32 = 1 << 11;
    pub(in super::super) const SPINDLE: u32 = 1 << 12;
    pub(in super::super) const TOOL: u32 = 1 << 13;
    pub(in super::super) const TCP: u32 = 1 << 14;
    pub(in super::super) const TILT: u32 = 1 << 15;
}

/// What a line says beside its motion.
#[derive(Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "what a line may say")]
pub(super) struct Now {
    groups: u32,
    /// `G4`, `G10`, `G28`, `G52`, `G92`, `G68.2`, `G53.1`: tenths and place.
    pub(super) nonmodal: Option<(u32, usize)>,
    /// `G53`.
    pub(super) machine: bool,
    /// A motion code stood on the line.
    pub(super) motion: bool,
    /// `G43` and its kin.
    length: Option<Code>,
    pub(super) changes_tool: bool,
    pub(super) turns_spindle: bool,
    /// The F word.
    pub(super) feed: Option<f64>,
    /// `M0`, `M1`: places of what is kept behind the motion.
    pub(super) stops: [Option<(usize, usize)>; 2],
    pub(super) ends: bool,
    pub(super) returns: bool,
    /// `M99 P10`: the line that is run next, and its place.
    pub(super) return_to: Option<(f64, usize)>,
    /// Subprogram, times, place.
    pub(super) call: Option<(Box<str>, u32, usize)>,
    /// Parameters of its own.
    pub(super) arguments: Option<Vec<f64>>,
}

impl Now {
    fn has(&self, group: u32) -> bool {
        self.groups & group != 0
    }
}

impl Gcode {
    /// Does what a block says, up to its motion.
    pub(super) fn words(
        &mut self,
        state: &mut State,
        block: &mut Block,
        (text, now): (&str, &mut Now),
    ) -> Result<(), Remark> {
        let calls = |code: &Code| code.letter == b'G' && matches!(code.tenths, 650 | 660);
        if self.dialect != Dialect::LinuxCnc && block.codes.iter().any(calls) {
            return self.macro_call(block, (text, now));
        }
        for at in 0..block.codes.len() {
            let Some(&code) = block.codes.get(at) else { break };
            let group = if code.letter == b'G' {
                self.g_code(state, block, (text, code, now))?
            } else {
                self.m_code(state, block, (text, code, now))?
            };
            if now.has(group) {
                let what = text.get(code.at..code.end).unwrap_or_default();
                let message = format!("{what} contradicts another code on this line");
                return Err(Remark::new(code.at, message, "keep one of them"));
            }
            now.groups |= group;
        }
        plain_words(state, block, now)?;
        self.lengths(state, (text, block), now)?;
        let before = state.control.steps.len();
        self.motion(state, block, (text, now))?;
        let mut made = state.control.steps.iter().skip(before);
        if self.modal.each.is_some() && made.any(|step| matches!(step, Step::Move(_))) {
            self.call_behind_move(now);
        }
        Ok(())
    }

    /// A G code: takes it in, and says its group.
    fn g_code(
        &mut self,
        state: &mut State,
        block: &mut Block,
        (text, code, now): (&str, Code, &mut Now),
    ) -> Result<u32, Remark> {
        let control = &mut state.control;
        let modal = &mut self.modal;
        Ok(match code.tenths {
            0 => self.moves(Motion::Rapid, now),
            10 => self.moves(Motion::Feed, now),
            20 => self.moves(Motion::Arc { clockwise: true }, now),
            30 => self.moves(Motion::Arc { clockwise: false }, now),
            730 | 740 | 810..=890 if code.tenths % 10 == 0 => self.cycle_code(code, now)?,
            800 => {
                modal.motion = None;
                group::MOTION
            }
            170 | 180 | 190 => {
                modal.plane = usize::try_from((code.tenths - 170) / 10).unwrap_or_default();
                group::PLANE
            }
            200 | 210 => {
                control.inch = code.tenths == 200;
                group::UNITS
            }
            900 | 910 => {
                modal.incremental = code.tenths == 910;
                group::DISTANCE
            }
            901 | 911 => {
                modal.arc_absolute = code.tenths == 901;
                group::ARC
            }
            930 => feed_mode(control, FeedMode::Inverse),
            940 => feed_mode(control, FeedMode::PerMinute),
            950 => feed_mode(control, FeedMode::PerRevolution),
            980 | 990 => {
                modal.to_r = code.tenths == 990;
                group::RETRACT
            }
            430 | 434 | 435 | 490 | 2340 => {
                now.length = Some(code);
                group::LENGTH
            }
            540..=599 | 1540 => self.offset_code(state, block, (text, code))?,
            _ => return self.further_g_code(state, block, (text, code, now)),
        })
    }

    fn moves(&mut self, motion: Motion, now: &mut Now) -> u32 {
        self.modal.motion = Some(motion);
        now.motion = true;
        group::MOTION
    }

    fn further_g_code(
        &mut self,
        state: &mut State,
        block: &mut Block,
        (text, code, now): (&str, Code, &mut Now),
    ) -> Result<u32, Remark> {
        let linuxcnc = self.dialect == Dialect::LinuxCnc;
        Ok(match code.tenths {
            40 | 100 | 280 | 281 | 300 | 301 | 520 | 531 | 682 | 920..=922 => {
                now.nonmodal = Some((code.tenths, code.at));
                group::NONMODAL
            }
            530 => {
                now.machine = true;
                group::NONMODAL
            }
            690 => {
                state.control.untilt();
                group::TILT
            }
            121 if linuxcnc => {
                let kind = block.take('P').map(|word| word.value);
                // Which kinematics a number selects is the machine's own.
                if kind.is_none_or(|kind| (kind - 1.0).abs() > 0.0) {
                    return Err(Remark::new(
                        code.at,
                        "G12.1 other than P1",
                        "P1 is TCP, G13.1 none",
                    ));
                }
                state.control.set_tcp(true);
                group::TCP
            }
            131 if linuxcnc => {
                state.control.set_tcp(false);
                group::TCP
            }
            610 | 611 | 640 => {
                keep_with(state, block, (text, code, "PQ"));
                group::BLEND
            }
            // Look-ahead, exact stop: nothing about where the machine goes.
            51 | 80 | 90 | 1030 | 1870 => {
                keep_with(state, block, (text, code, "PQRE"));
                group::NONE
            }
            670 => {
                self.modal.each = None;
                group::NONE
            }
            150 | 400 | 500 | 501 | 970 | 1230 | 1640 => group::NONE,
            _ => return Err(not_understood(code, text, self.dialect)),
        })
    }

    /// `G54` to `G59.3`, `G54.1 P1`, `G154 P1`.
    fn offset_code(
        &mut self,
        state: &mut State,
        block: &mut Block,
        (text, code): (&str, Code),
    ) -> Result<u32, Remark> {
        let offset = match code.tenths {
            541 | 1540 => {
                let number = block.take('P').ok_or_else(|| {
                    Remark::new(code.at, "an extended work offset without P", "write P1 and so on")
                })?;
                natural(number, 'P')?.saturating_add(8)
            }
            591..=593 => code.tenths - 591 + 6,
            tenths if tenths % 10 == 0 => (tenths - 540) / 10,
            _ => return Err(not_understood(code, text, self.dialect)),
        };
        state.control.set_offset(u8::try_from(offset).unwrap_or(u8::MAX));
        Ok(group::OFFSET)
    }

    /// Tool length and tool-centre-point control.
    fn lengths(
        &mut self,
        state: &mut State,
        (text, block): (&str, &mut Block),
        now: &Now,
    ) -> Result<(), Remark> {
        let word = block.take('H');
        let number = word.map(|word| natural(word, 'H')).transpose()?;
        if let (Some(word), Some(number), Some(&tool)) = (word, number, state.control.tools.last())
            && number != 0
            && number != tool
        {
            let message = format!("H{number} with tool {tool} in the spindle");
            let help = "the length of the tool is taken, as if its number stood there";
            state.log.warn(text, Remark::new(word.at, message, help));
        }
        let control = &mut state.control;
        let Some(code) = now.length else {
            // A new number while the length counts is another length.
            if number.is_some() && control.length {
                control.set_length(true);
            }
            return Ok(());
        };
        let on = code.tenths != 490 && number != Some(0);
        let tcp = on && code.tenths != 430;
        self.modal.vector = code.tenths == 435;
        control.turning = None;
        if tcp && let Some(posture) = block.take('P') {
            control.turning = match natural(posture, 'P')? {
                0 => Some(Turning::Rotary),
                1 => Some(Turning::GreatCircle),
                _ => {
                    return Err(Remark::new(
                        posture.at,
                        "P other than 0 or 1",
                        "1 turns in a plane",
                    ));
                }
            };
        }
        control.set_length(on);
        // LinuxCNC's M428 outlives a G43.
        if code.tenths != 430 {
            control.set_tcp(tcp);
        }
        Ok(())
    }
}

/// F, S, T, and numbers of lines.
fn plain_words(state: &mut State, block: &mut Block, now: &mut Now) -> Result<(), Remark> {
    if let Some(word) = block.take('F') {
        feed(state, word, now)?;
    }
    if !block.has_any("DNST") && !now.changes_tool && !now.turns_spindle {
        return Ok(());
    }
    if let Some(word) = block.take('N') {
        natural(word, 'N')?;
    }
    if let Some(word) = block.take('D') {
        natural(word, 'D')?;
    }
    if let Some(word) = block.take('T') {
        state.control.tool = natural(word, 'T')?;
    }
    if let Some(word) = block.take('S') {
        if word.value < 0.0 {
            let message = format!("S{} is no speed", word.value);
            return Err(Remark::new(word.at, message, "M4 turns the other way"));
        }
        let turned = (state.control.speed - word.value).abs() > 0.0;
        state.control.speed = word.value;
        now.turns_spindle |= turned && state.control.sense != 0;
    }
    let line = state.log.line;
    if now.changes_tool {
        let number = state.control.tool;
        state.control.change_tool(line, number);
    }
    if now.turns_spindle {
        state.control.spindle(line);
    }
    Ok(())
}

/// `G93`, `G94`, `G95`: a feed of the one means nothing to the other.
fn feed_mode(control: &mut Control, mode: FeedMode) -> u32 {
    if control.feed_mode != mode {
        control.feed = None;
    }
    control.feed_mode = mode;
    group::FEED
}

fn feed(state: &mut State, word: Word, now: &mut Now) -> Result<(), Remark> {
    if !(word.value > 0.0 && word.value.is_finite()) {
        let message = format!("F{} is no feed", word.value);
        return Err(Remark::new(word.at, message, "give one above 0"));
    }
    state.control.note_feed(word.decimals);
    now.feed = Some(word.value);
    if state.control.feed_mode != FeedMode::Inverse {
        state.control.feed = now.feed;
    }
    Ok(())
}

/// Keeps a code with some of the words beside it.
pub(super) fn keep_with(
    state: &mut State,
    block: &mut Block,
    (text, code, letters): (&str, Code, &str),
) {
    let mut kept = text.get(code.at..code.end).unwrap_or_default().to_owned();
    for letter in letters.chars() {
        if let Some(word) = block.take(letter) {
            kept.push(' ');
            kept.push_str(text.get(word.at..word.end).unwrap_or_default());
        }
    }
    state.control.keep(state.log.line, &kept);
}

/// A number that counts something.
pub(super) fn natural(word: Word, letter: char) -> Result<u32, Remark> {
    let whole = word.value.round();
    // Counts come from expressions, too: as exact as a parameter's number.
    if (whole - word.value).abs() > 1e-4 || !(0.0..=f64::from(u32::MAX)).contains(&whole) {
        let message = format!("{letter}{} must be a whole number from 0", word.value);
        return Err(Remark::new(word.at, message, ""));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    let whole = whole as u32;
    Ok(whole)
}

pub(super) fn not_understood(code: Code, text: &str, dialect: Dialect) -> Remark {
    let what = text.get(code.at..code.end).unwrap_or_default();
    let help = match (code.letter, code.tenths) {
        (b'G', 410..=429) => {
            "cutter compensation needs the whole contour; post the compensated path"
        }
        (b'G', 50..=69) => "splines are not replayed; post straight moves or arcs",
        (b'G', 330..=339 | 760) => "threading follows the spindle; read the program without it",
        (b'G', 380..=389 | 310) => "where a probe stops is not in the program",
        (b'G', 160 | 510 | 511 | 680) => "polar, scaled or turned coordinates: post plain ones",
        (b'G', 650..=669) => "macro calls: write M98 at each place",
        (b'G', 70 | 80 | 960) => "of lathes",
        (b'G', 2540 | 2550) => "the control's own offsets are not in the program",
        (b'M', _) => "it may move the machine; leave it out of the program to be checked",
        _ => "is it the right dialect?",
    };
    Remark::new(code.at, format!("{what} is not understood as {dialect}"), help)
}

/// A word that no code of its line wants.
pub(super) fn left_over(letter: char, text: &str, at: usize, control: &Control) -> Remark {
    match letter {
        'X' | 'Y' | 'Z' | 'A' | 'B' | 'C' | 'U' | 'V' | 'W' => control.no_axis(at, text),
        'P' => Remark::new(
            at,
            "P word without G4 or G64 or another code that wants it",
            "leave it out",
        ),
        'Q' => Remark::new(at, "Q word without G64 or a cycle", "leave it out"),
        'I' | 'J' | 'K' | 'R' => {
            Remark::new(at, format!("{text} without G2, G3 or a cycle"), "leave it out")
        }
        _ => Remark::new(at, format!("{text} is not understood"), "leave it out"),
    }
}
