//! G and M codes, and the words that belong to no motion.

use super::block::{BlockWord, CodeWord, GcodeBlock};
use super::modal::{BlockActions, GcodeMotion, group};
use super::reader::GcodeReader;
use super::remap::RemappedCode;
use super::tool_offsets::{ToolOffset, shift_tool};
use super::words::{keep_with, natural, not_understood};
use crate::read::arc::ArcSense;
use crate::read::control::{ControlState, DistanceMode, FeedMode, SurfaceSpeed};
use crate::read::dialect::Dialect;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::step::{LengthEntry, Smoothing};
use crate::read::step::{Step, Turning};
/// Returns true for `G73` to `G89` but `G80`.
fn is_cycle(code: CodeWord) -> bool {
    code.letter == b'G' && matches!(code.tenths, 730..=799 | 810..=890)
}

impl GcodeReader {
    /// Runs a block up to its motion.
    pub(super) fn words(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        now: &mut BlockActions,
    ) -> Result<(), ReadRemark> {
        // G65 and G66 take all letters of their line as arguments, axis letters among them.
        let calls = |code: &CodeWord| code.letter == b'G' && matches!(code.tenths, 650 | 660);
        if self.dialect != Dialect::LinuxCnc && block.codes.iter().any(calls) {
            return self.macro_call(block, text, now);
        }
        // A control runs a line in a fixed order, not as written: modes first, then F S T, the tool
        // length, the motion, and what stops or ends the program last.
        for at in 0..block.codes.len() {
            let Some(&code) = block.codes.get(at) else { break };
            if let Some(compensation) = &self.modal.compensation {
                self.check_compensated(compensation, code, text)?;
            }
            if let Some(remap) = self.remap_of(code) {
                return self.remapped(state, block, &RemappedCode { text, code, remap });
            }
            let group = if code.letter == b'G' {
                self.g_code(state, block, text, code, now)?
            } else {
                self.m_code(state, block, text, code, now)?
            };
            // Codes of one modal group exclude each other.
            let excludes = match group {
                // A cycle excludes G80 as well as other motions; G0 G80 go together.
                group::MOTION if self.dialect != Dialect::LinuxCnc && is_cycle(code) => {
                    group::CANCEL | group::MOTION
                }
                group => group,
            };
            if now.has(excludes) {
                let what = text.get(code.at..code.end).unwrap_or_default();
                let message = format!("{what} contradicts another code on this line");
                return Err(ReadRemark::new(code.at, message, "keep one of them"));
            }
            now.groups |= excludes;
        }
        self.plain_words(state, block, now)?;
        self.lengths(state, text, block, now)?;
        if let Some(code) = now.compensates {
            self.compensate(state, block, code)?;
        }
        // G66 calls its program behind every line that moves.
        let before = state.control.steps.len();
        self.motion(state, block, text, now)?;
        let mut made = state.control.steps.iter().skip(before);
        if self.modal.each.is_some() && made.any(|step| matches!(step, Step::Move(_))) {
            self.call_behind_move(now);
        }
        Ok(())
    }

    /// Applies a G code and returns its group.
    fn g_code(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: CodeWord,
        now: &mut BlockActions,
    ) -> Result<u32, ReadRemark> {
        let control = &mut state.control;
        let modal = &mut self.modal;
        Ok(match code.tenths {
            0 => self.moves(GcodeMotion::Rapid, now),
            10 => self.moves(GcodeMotion::Feed, now),
            20 => self.moves(GcodeMotion::Arc(ArcSense::Clockwise), now),
            30 => self.moves(GcodeMotion::Arc(ArcSense::Counterclockwise), now),
            730 | 740 | 810..=890 if code.tenths.is_multiple_of(10) => {
                self.cycle_code(code, now)?
            }
            // G80 ends the cycle: axis words behind it need a motion code again.
            800 => {
                // Another motion code of the line prevails: G80 G0.
                match modal.motion {
                    _ if now.motion => {}
                    _ if self.dialect == Dialect::LinuxCnc => modal.motion = None,
                    // Fanuc and Haas: the motion before the cycle, of another group, is active again.
                    Some(GcodeMotion::Cycle(_)) => modal.motion = modal.before_cycle,
                    _ => {}
                }
                group::CANCEL
            }
            // G17 is XY, G18 ZX, G19 YZ.
            170 | 180 | 190 => {
                modal.plane = usize::try_from((code.tenths - 170) / 10).unwrap_or_default();
                group::PLANE
            }
            200 | 210 => {
                control.inch = code.tenths == 200;
                group::UNITS
            }
            900 | 910 => {
                let absolute = code.tenths == 900;
                modal.distance =
                    if absolute { DistanceMode::Absolute } else { DistanceMode::Incremental };
                group::DISTANCE
            }
            // G90.1 and G91.1 concern centres only, beside G90 and G91.
            901 | 911 => {
                modal.arc_absolute = code.tenths == 901;
                group::ARC
            }
            930 => feed_mode(control, FeedMode::Inverse),
            940 => feed_mode(control, FeedMode::PerMinute),
            950 => feed_mode(control, FeedMode::PerRevolution),
            // G98 retracts from a hole to the initial level, G99 to R.
            980 | 990 => {
                modal.to_r = code.tenths == 990;
                group::RETRACT
            }
            // Needs H and P of the line, and is applied behind all codes.
            430 | 434 | 435 | 490 | 2340 => {
                now.length = Some(code);
                group::LENGTH
            }
            431 | 432 if self.dialect == Dialect::LinuxCnc => {
                now.length = Some(code);
                group::LENGTH
            }
            540..=599 | 1540 => self.offset_code(state, block, text, code)?,
            _ => return self.further_g_code(state, block, text, code, now),
        })
    }

    fn moves(&mut self, motion: GcodeMotion, now: &mut BlockActions) -> u32 {
        self.modal.motion = Some(motion);
        now.motion = true;
        group::MOTION
    }

    fn further_g_code(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: CodeWord,
        now: &mut BlockActions,
    ) -> Result<u32, ReadRemark> {
        let linuxcnc = self.dialect == Dialect::LinuxCnc;
        if !linuxcnc && let Some(group) = self.code_of_others(state, block, text, code, now) {
            return Ok(group);
        }
        Ok(match code.tenths {
            // These take the axis words of their line, which then are no target of a move.
            // LinuxCNC waits before the motion of the line.
            40 if linuxcnc => {
                now.dwells = Some(code.at);
                group::DWELL
            }
            40 | 100 | 280 | 281 | 300 | 301 | 520 | 531 | 682 | 920..=923 => {
                now.nonmodal = Some((code.tenths, code.at));
                group::NONMODAL
            }
            530 => {
                now.machine = true;
                group::NONMODAL
            }
            690 => {
                if !linuxcnc && !self.modal.mirrors() {
                    state.control.word_map = None;
                }
                state.control.untilt();
                group::TILT
            }
            121 if linuxcnc => {
                let kind = block.take('P').map(|word| word.value);
                // Which kinematics a number selects is the machine's own.
                if kind.is_none_or(|kind| (kind - 1.0).abs() > 0.0) {
                    return Err(ReadRemark::new(
                        code.at,
                        "G12.1 other than P1",
                        "P1 is TCP, G13.1 none",
                    ));
                }
                state.control.enable_tcp();
                group::TCP
            }
            131 if linuxcnc => {
                state.control.disable_tcp();
                group::TCP
            }
            // G61, G61.1 and G64 choose exact stops or blending; the programmed path stays.
            610 | 611 | 640 => {
                let smoothing = self.smoothing(state, block, code);
                state.control.smooth(state.log.line, smoothing);
                keep_with(state, block, text, code, "PQ");
                group::BLEND
            }
            // X counts in diameters (G7) or radii (G8).
            70 | 80 if linuxcnc => {
                self.modal.diameter = code.tenths == 70;
                group::LATHE
            }
            // G67 ends G66.
            670 => {
                self.modal.each = None;
                group::NONE
            }
            // S is a cutting speed: G21 m/min, G20 ft/min. D bounds the speed of the spindle.
            960 if linuxcnc => {
                let most = block.take('D').map(|word| word.value);
                if !block.has_any("S") {
                    return Err(ReadRemark::new(
                        code.at,
                        "G96 without S",
                        "write the cutting speed",
                    ));
                }
                state.control.surface = Some(SurfaceSpeed { most });
                group::SPEED
            }
            970 => {
                state.control.surface = None;
                group::SPEED
            }
            50..=52 if linuxcnc => {
                self.modal.spline_code = code.tenths;
                self.moves(GcodeMotion::Spline, now)
            }
            53 if linuxcnc => {
                now.nonmodal = Some((code.tenths, code.at));
                group::NONMODAL
            }
            330 | 331 | 760 if linuxcnc => self.moves(GcodeMotion::Thread(code.tenths), now),
            382..=385 if linuxcnc => self.moves(GcodeMotion::Probe(code.tenths), now),
            // Look-ahead, exact stop: nothing about where the machine goes.
            51 | 80 | 90 | 1030 | 1870 => {
                // Haas: G187 E is the largest rounding of corners, P a class of the machine.
                if code.tenths == 1870 {
                    let smoothing = stated(state, block, 'E').unwrap_or(Smoothing::OfMachine);
                    state.control.smooth(state.log.line, smoothing);
                }
                keep_with(state, block, text, code, "PQRE");
                group::NONE
            }
            400 if linuxcnc => {
                self.end_compensation(state)?;
                group::COMPENSATION
            }
            410 | 411 | 420 | 421 if linuxcnc => {
                now.compensates = Some(code);
                group::COMPENSATION
            }
            // States that hold anyway: polar coordinates, cutter compensation, scaling and mirror
            // image off (G15 G40 G50 G50.1).
            150 | 131 | 400 | 500 | 501 | 1230 | 1640 | 2550 => group::NONE,
            _ => return Err(not_understood(code, text, self.dialect)),
        })
    }

    /// Returns the distance from the path that `G61`, `G61.1` or `G64` allows.
    fn smoothing(&self, state: &ReaderState, block: &GcodeBlock, code: CodeWord) -> Smoothing {
        match code.tenths {
            610 => Smoothing::Exact,
            611 => Smoothing::Stop,
            // LinuxCNC: lines within Q of one line are joined to it, and corners rounded within P of what is left; Q is P
            // unless stated. Without P only speed counts. Elsewhere G64 is the usual cutting mode.
            _ if self.dialect == Dialect::LinuxCnc => {
                block.look('P').map_or(Smoothing::Unbounded, |corners| {
                    let lines = block.look('Q').unwrap_or(corners);
                    let [corners, lines] =
                        [corners, lines].map(|word| word.value * state.control.scale());
                    Smoothing::Blended { corners, lines }
                })
            }
            _ => Smoothing::OfMachine,
        }
    }

    /// Applies `G54` to `G59.3`, `G54.1 P1`, `G154 P1`.
    fn offset_code(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: CodeWord,
    ) -> Result<u32, ReadRemark> {
        let offset = match code.tenths {
            // G54.1 P1 (Fanuc) and G154 P1 (Haas) follow the nine offsets G54 to G59.3.
            541 | 1540 => {
                let number = block.take('P').ok_or_else(|| {
                    ReadRemark::new(
                        code.at,
                        "an extended work offset without P",
                        "write P1 and so on",
                    )
                })?;
                natural(number, 'P')?.saturating_add(8)
            }
            // G59.1 to G59.3 follow G59, the sixth, as offsets 7 to 9.
            591..=593 => code.tenths - 591 + 6,
            tenths if tenths % 10 == 0 => (tenths - 540) / 10,
            _ => return Err(not_understood(code, text, self.dialect)),
        };
        state.control.set_offset(u8::try_from(offset).unwrap_or(u8::MAX));
        Ok(group::OFFSET)
    }

    /// Applies tool length compensation and tool-centre-point control.
    fn lengths(
        &mut self,
        state: &mut ReaderState,
        text: &str,
        block: &mut GcodeBlock,
        now: &BlockActions,
    ) -> Result<(), ReadRemark> {
        let word = block.take('H');
        let number = word.map(|word| natural(word, 'H')).transpose()?;
        let of_others = |code: CodeWord| matches!(code.tenths, 434 | 435 | 2340);
        if self.dialect == Dialect::LinuxCnc && !now.length.is_some_and(of_others) {
            return self.linuxcnc_length(state, block, text, LengthWord { number, word }, now);
        }
        // H is a row of the length table. The length of another row than that of the tool is not
        // known.
        if let (Some(word), Some(number), Some(&tool)) = (word, number, state.control.tools.last())
            && number != 0
            && number != tool
        {
            let message = format!("H{number} with tool {tool} in the spindle");
            let help = "the length of the tool is taken, as if its number stood there";
            state.log.warn(text, ReadRemark::new(word.at, message, help));
        }
        if let Some(number) = number.filter(|number| *number != 0) {
            state.control.choose_length(state.log.line, LengthEntry::Row(number));
        }
        let control = &mut state.control;
        let Some(code) = now.length else {
            // A new number while the length counts is another length.
            if number.is_some() && control.length {
                control.enable_length();
            }
            return Ok(());
        };
        // G49 and H0 cancel the length, and with it TCP.
        let on = code.tenths != 490 && number != Some(0);
        // G43 compensates the length alone; G43.4, G43.5 and G234 follow the tip as well.
        let tcp = on && code.tenths != 430;
        // G43.5 programs the tool axis by I J K.
        self.modal.vector = code.tenths == 435;
        control.turning = None;
        // P0 turns the rotaries evenly, P1 keeps the tool in the plane between both ends.
        if tcp && let Some(posture) = block.take('P') {
            control.turning = match natural(posture, 'P')? {
                0 => Some(Turning::Rotary),
                1 => Some(Turning::GreatCircle),
                _ => {
                    return Err(ReadRemark::new(
                        posture.at,
                        "P other than 0 or 1",
                        "1 turns in a plane",
                    ));
                }
            };
        }
        if on {
            control.enable_length();
        } else {
            control.disable_length();
        }
        // LinuxCNC's M428 outlives a G43.
        match code.tenths {
            430 => {}
            _ if tcp => control.enable_tcp(),
            _ => control.disable_tcp(),
        }
        Ok(())
    }

    /// Applies F, S and T, and checks line numbers.
    fn plain_words(
        &self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        now: &mut BlockActions,
    ) -> Result<(), ReadRemark> {
        let linuxcnc = self.dialect == Dialect::LinuxCnc;
        match block.take('F') {
            // LinuxCNC takes F0, and refuses the moves that it would be for.
            Some(word) if linuxcnc && word.value.abs() <= 0.0 => state.control.feed = None,
            Some(word) => feed(state, word, now)?,
            None => {}
        }
        // Most lines have none of these words.
        if !block.has_any("DNST") && !now.changes_tool && !now.turns_spindle {
            return Ok(());
        }
        // RS274/NGC numbers lines by fractions, too.
        if let Some(word) = block.take('N')
            && !linuxcnc
        {
            natural(word, 'N')?;
        }
        // D is a radius for cutter compensation, or a fastest speed; other dialects take it anywhere.
        if !linuxcnc && let Some(word) = block.take('D') {
            natural(word, 'D')?;
        }
        if let Some(word) = block.take('T') {
            state.control.tool = natural(word, 'T')?;
        }
        if let Some(word) = block.take('S') {
            if word.value < 0.0 {
                let message = format!("S{} is no speed", word.value);
                return Err(ReadRemark::new(word.at, message, "M4 turns the other way"));
            }
            // A new S while the spindle turns changes its speed at once.
            let turned = (state.control.speed - word.value).abs() > 0.0;
            state.control.speed = word.value;
            now.turns_spindle |= turned && state.control.sense != 0;
        }
        let line = state.log.line;
        // T chooses the tool, M6 changes it.
        if now.changes_tool {
            let number = state.control.tool;
            state.control.change_tool(line, number);
            // LinuxCNC stops the spindle for M6, even for the tool that is in it; M61 changes nothing.
            let changes = block.codes.iter().any(|code| code.letter == b'M' && code.tenths == 60);
            if linuxcnc && changes && !now.turns_spindle && state.control.sense != 0 {
                state.control.sense = 0;
                now.turns_spindle = true;
            }
        }
        if now.turns_spindle {
            state.control.spindle(line);
        }
        Ok(())
    }

    /// Applies `G43`, `G43.1`, `G43.2` and `G49` as `LinuxCNC` has them.
    fn linuxcnc_length(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        length: LengthWord,
        now: &BlockActions,
    ) -> Result<(), ReadRemark> {
        let LengthWord { number, word } = length;
        let Some(code) = now.length else { return Ok(()) };
        let offset = match code.tenths {
            490 => {
                state.control.disable_length();
                state.control.set_tool_shift([0.0; 3]);
                // G49 ends TCP, as the length that it needs is gone.
                state.control.disable_tcp();
                return Ok(());
            }
            // H0 is the tool in the spindle; an empty spindle has no length.
            430 => {
                let number = number.filter(|number| *number > 0);
                if let Some(row) = number.or(state.control.tools.last().copied()) {
                    state.control.choose_length(state.log.line, LengthEntry::Row(row));
                }
                ToolOffset::Of { number, at: word.map(|word| word.at) }
            }
            _ => {
                let target = self.target(state, block, text)?;
                let values = state.control.xyz.map(|slot| target.get(slot));
                match code.tenths {
                    431 => ToolOffset::Given { values },
                    _ => ToolOffset::Added { number, values, at: code.at },
                }
            }
        };
        shift_tool(state, &offset)
    }
}

/// The H word of a line.
#[derive(Clone, Copy)]
struct LengthWord {
    number: Option<u32>,
    word: Option<BlockWord>,
}

/// Returns the tolerance of a word \[mm\], which stays in the block; `None` without one.
fn stated(state: &ReaderState, block: &GcodeBlock, letter: char) -> Option<Smoothing> {
    Some(Smoothing::Within(block.look(letter)?.value * state.control.scale()))
}

/// Switches between `G93`, `G94` and `G95`; a feed of one means nothing to the others.
fn feed_mode(control: &mut ControlState, mode: FeedMode) -> u32 {
    if control.feed_mode != mode {
        control.feed = None;
    }
    control.feed_mode = mode;
    group::FEED
}

fn feed(
    state: &mut ReaderState,
    word: BlockWord,
    now: &mut BlockActions,
) -> Result<(), ReadRemark> {
    if !(word.value > 0.0 && word.value.is_finite()) {
        let message = format!("F{} is no feed", word.value);
        return Err(ReadRemark::new(word.at, message, "give one above 0"));
    }
    // The digits of F bound the rounding of all feeds.
    state.control.note_feed(word.decimals);
    now.feed = Some(word.value);
    // In G93 F holds for its own line only.
    if state.control.feed_mode != FeedMode::Inverse {
        state.control.feed = now.feed;
    }
    Ok(())
}
