//! `FUNCTION TCPM`, `FUNCTION RESET TCPM`, `CYCL DEF`.

use super::drilling_cycle::KlartextCycle;
use super::flow::same;
use super::frame::ProgramFrame;
use super::reader::HeidenhainReader;
use super::reader::not_understood;
use super::token::{Token, Tokens};
use super::units::value_begins;
use crate::read::log::{ReadRemark, excerpt};
use crate::read::state::ReaderState;
use crate::read::step::{Smoothing, Turning};

impl HeidenhainReader {
    /// Runs `FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR`.
    pub(super) fn function(
        &mut self,
        state: &mut ReaderState,
        first: &Token<'_>,
        code: &str,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        if let Some(what) = tokens.clone().next_token()
            && same(what.text, "DWELL")
        {
            let time = std::iter::from_fn(|| tokens.next_token()).last();
            let time = time.filter(|time| value_begins(time.text).is_some());
            let help = "write FUNCTION DWELL TIME1.5";
            let time =
                time.ok_or_else(|| ReadRemark::new(first.at, "a dwell without time", help))?;
            return self.dwell(state, &time);
        }
        let words: Vec<String> = std::iter::from_fn(|| tokens.next_token())
            .map(|token| token.text.to_ascii_uppercase())
            .collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        match words.as_slice() {
            // M128 and FUNCTION TCPM are the same mode; RESET also ends the interpretation of the
            // angles.
            ["RESET", "TCPM"] => {
                state.control.disable_tcp();
                state.control.turning = None;
                self.spatial = false;
                Ok(())
            }
            ["TCPM", settings @ ..] => {
                self.tcpm(state, settings, first)?;
                state.control.enable_tcp();
                Ok(())
            }
            _ => Err(not_understood(first, code)),
        }
    }

    fn tcpm(
        &mut self,
        state: &mut ReaderState,
        settings: &[&str],
        first: &Token<'_>,
    ) -> Result<(), ReadRemark> {
        let unknown = |what: &str| {
            let message = format!("FUNCTION TCPM with {what}");
            ReadRemark::new(
                first.at,
                message,
                "F TCP, AXIS POS, PATHCTRL and REFPNT TIP-TIP are understood",
            )
        };
        let mut rest = settings;
        while let [name, value, after @ ..] = rest {
            rest = after;
            match (*name, *value) {
                ("F", "TCP") | ("REFPNT", "TIP-TIP") => {}
                // Under F CONT the feed is that of the axes together, which needs the machine.
                ("F", "CONT") => {
                    let message = "F CONT: feeds are taken as those of the tip";
                    state.log.warn("", ReadRemark::new(first.at, message, ""));
                }
                // POS: rotary words are axis positions. SPAT: they are angles of the tool in space.
                ("AXIS", "POS") => self.spatial = false,
                ("AXIS", "SPAT") => self.spatial = true,
                ("PATHCTRL", "AXIS") => state.control.turning = Some(Turning::Rotary),
                ("PATHCTRL", "VECTOR") => state.control.turning = Some(Turning::GreatCircle),
                (name, value) => return Err(unknown(&format!("{name} {value}"))),
            }
        }
        match rest {
            [] => Ok(()),
            // How fast the axes may compensate.
            [limit] if limit.starts_with('F') => Ok(()),
            [other, ..] => Err(unknown(other)),
        }
    }

    /// Runs `CYCL DEF 32.0 TOLERANCE`, `7.1 X+5`, `9.1 DWELL 2`, `247 .. Q339=1`.
    pub(super) fn cycle(
        &mut self,
        state: &mut ReaderState,
        first: &Token<'_>,
        code: &str,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let verb = tokens.expect()?.text.to_ascii_uppercase();
        if verb == "CALL" {
            return self.cycle_call(state, first, tokens);
        }
        if verb != "DEF" {
            return Err(not_understood(first, code));
        }
        let which = tokens.expect()?;
        // Cycles of old form have numbered lines: 7.0 names the cycle, 7.1 and on have its data.
        let (number, part) = which.text.split_once(['.', ',']).unwrap_or((which.text, "0"));
        let number: u32 = number.parse().unwrap_or(0);
        let begins = part == "0";
        let rest = code.get(which.at + which.text.len()..).unwrap_or_default();
        self.cycle = if begins { number } else { self.cycle };
        match (number, begins) {
            // Cycle 32 sets the path tolerance, which leaves the programmed path as it is.
            (32, _) => {
                // 32.1 has the tolerance of the path, 32.2 that of the tool axis.
                if part == "1" {
                    let smoothing = self.smoothing(tokens.clone())?;
                    state.control.smooth(state.log.line, smoothing);
                }
                state.control.keep(state.log.line, code.get(first.at..).unwrap_or_default());
                Ok(())
            }
            (7..=11 | 19 | 26, true) => Ok(()),
            (7, false) => self.datum_shift(state, tokens),
            (9, false) => {
                // `9.1 DWELL 2` or `9.1 V.ZEIT2`: the time is at the end.
                let text = std::iter::from_fn(|| tokens.next_token()).last();
                let time =
                    text.ok_or_else(|| ReadRemark::new(which.at, "a dwell without time", ""))?;
                self.dwell(state, &time)
            }
            (247, _) => self.preset(state, tokens, which.at),
            (1, true) => {
                self.drilling = Some(KlartextCycle::pecking());
                Ok(())
            }
            (1, false) => self.pecking_line(part, rest, which.at),
            (200..=203 | 205..=207 | 209 | 240, _) => {
                self.define_drilling(state, number, rest, which.at)
            }
            (8, false) => self.mirror(state, tokens, which.at),
            (10, false) => self.rotation(state, tokens, which.at),
            // Scales and the old tilt: only their cancellation.
            (11 | 19 | 26, false) => self.cancellation(state, number, tokens, which.at),
            _ => {
                let help = match number {
                    208 | 251..=254 | 256 | 257 | 262..=267 => {
                        "its moves depend on the radius of the tool: write them as L and CP"
                    }
                    204 => "the control steps aside with a stopped spindle: write its moves as L",
                    _ => {
                        "write its moves as L; 1, 7 to 10, 32, 200 to 203, 205 to 207, 209, 240 and 247 are understood"
                    }
                };
                Err(ReadRemark { help: help.to_owned(), ..not_understood(first, code) })
            }
        }
    }

    /// Reads `32.1 T0.02`; without T the cycle gives the machine its own setting back.
    fn smoothing(&self, mut tokens: Tokens<'_>) -> Result<Smoothing, ReadRemark> {
        let tolerance = std::iter::from_fn(|| tokens.next_token())
            .find(|token| token.text.starts_with(['T', 't']) && token.text.len() > 1);
        let tolerance = tolerance.map(|token| self.value(&token.after(1))).transpose()?;
        let stated = tolerance.map(|read| read.value).filter(|tolerance| *tolerance > 0.0);
        Ok(stated.map_or(Smoothing::OfMachine, Smoothing::Within))
    }

    /// Runs `CYCL CALL`, `CYCL CALL M3`.
    fn cycle_call(
        &mut self,
        state: &mut ReaderState,
        first: &Token<'_>,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        if let Some(word) = tokens.clone().next_token()
            && !word.text.starts_with(['M', 'm'])
        {
            let message = format!("CYCL CALL {} is not understood", excerpt(word.text));
            let help = "write L to each place, with M99";
            return Err(ReadRemark::new(word.at, message, help));
        }
        // M functions of the block come before the cycle.
        self.path(state, "L", first, tokens.clone())?;
        self.call_cycle(state, first.at)
    }

    /// Takes a transformation with the values that cancel it: `8.1`, `10.1 ROT+0`, `11.1 SCL 1`, `19.1 A+0`.
    fn cancellation(
        &self,
        state: &mut ReaderState,
        number: u32,
        tokens: &mut Tokens<'_>,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let neutral = if number == 19 { 0.0 } else { 1.0 };
        while let Some(token) = tokens.next_word() {
            let letters = token.text.find(|c: char| c.is_ascii_digit() || "+-.".contains(c));
            let value = match letters {
                Some(letters) => Some(self.value(&token.after(letters))?.value),
                // The name of the value, from which it stands apart.
                None => continue,
            };
            // The centre of scales counts only beside them.
            let is_center = number == 26 && token.text.to_ascii_uppercase().starts_with("CC");
            if !is_center && value.is_none_or(|value| (value - neutral).abs() > 0.0) {
                let (what, help) = match number {
                    11 => (
                        "a scale (cycle 11): a machine parameter says whether the tool axis is scaled",
                        "post without it",
                    ),
                    26 => ("scales of single axes (cycle 26)", "post without them"),
                    _ => (
                        "a tilted plane by cycle 19: a machine parameter says which angles are meant",
                        "write PLANE SPATIAL",
                    ),
                };
                return Err(ReadRemark::new(at, what, help));
            }
        }
        if number == 19 {
            state.control.untilt();
        }
        Ok(())
    }

    /// Runs `TRANS DATUM AXIS X+5`, `TRANS DATUM RESET`: the datum shift of cycle 7.
    pub(super) fn trans(
        &mut self,
        state: &mut ReaderState,
        first: &Token<'_>,
        code: &str,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let what = [tokens.next_token(), tokens.next_token()];
        let [of, how] = what.map(|token| token.map_or("", |token| token.text).to_ascii_uppercase());
        match (of.as_str(), how.as_str()) {
            ("DATUM", "AXIS") => self.datum_shift(state, tokens),
            ("DATUM", "RESET") => {
                self.plain_frame(first.at, "a datum shift")?;
                Self::unshift(state);
                Ok(())
            }
            ("MIRROR" | "ROTATION" | "SCALE", "RESET") => Ok(()),
            _ => {
                let help = "TRANS DATUM AXIS and TRANS DATUM RESET are; write cycles 8 and 10";
                Err(ReadRemark { help: help.to_owned(), ..not_understood(first, code) })
            }
        }
    }

    /// Runs a datum shift: `X+5`, `IX+5`.
    fn datum_shift(
        &mut self,
        state: &mut ReaderState,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        // The shift would be along the axes of the plane.
        if state.control.tilted.is_some() {
            let help = "shift before PLANE";
            return Err(ReadRemark::new(0, "a datum shift in a tilted plane", help));
        }
        self.plain_frame(0, "a datum shift")?;
        while let Some(token) = tokens.next_word() {
            let upper = token.text.to_ascii_uppercase();
            let incremental = upper.starts_with('I');
            let skip = usize::from(incremental);
            let letter = upper.as_bytes().get(skip).copied().unwrap_or(0);
            let slot = if letter.is_ascii_uppercase() { state.control.slot(letter) } else { None };
            let Some(slot) = slot else {
                let message = format!("{upper} in a datum shift");
                return Err(ReadRemark::new(token.at, message, "write axes and values"));
            };
            let found = self.value(&token.after(skip + 1))?;
            let meant = state.control.meant(slot, found.value, super::super::control::COMPUTED);
            if let Some(local) = state.control.local.get_mut(slot) {
                *local = if incremental { *local + meant } else { meant };
            }
        }
        Ok(())
    }

    /// Activates a preset; preset 1 is what other dialects call `G54`.
    fn preset(
        &mut self,
        state: &mut ReaderState,
        tokens: &mut Tokens<'_>,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let mut number = None;
        while let Some(token) = tokens.next_token() {
            if let Some(value) = token.text.to_ascii_uppercase().strip_prefix("Q339=") {
                let skip = token.text.len() - value.len();
                number = Some(self.value(&token.after(skip))?.value);
            }
        }
        // Q339 is the row of the preset table; row 0 is the manual one.
        let whole = number.filter(|n| n.fract().abs() <= 0.0 && (1.0..=200.0).contains(n));
        let Some(number) = whole else {
            let message = "a preset other than a number from 1";
            return Err(ReadRemark::new(at, message, "write Q339=+1 and so on in the same block"));
        };
        // Activating a preset cancels datum shift, mirror image and rotation.
        Self::unshift(state);
        self.frame = ProgramFrame::default();
        self.pole = [None; 3];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        state.control.set_offset(number as u8 - 1);
        Ok(())
    }
}
