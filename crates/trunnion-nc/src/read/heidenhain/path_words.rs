//! Words of blocks that move.

use super::path_block::{PathBlock, PolarWord, Retraction};
use super::reader::HeidenhainReader;
use super::token::{Token, Tokens};
use super::units::feed_unit;
use crate::read::arc::ArcSense;
use crate::read::control::{COMPUTED, DistanceMode, FeedMode, LARGEST};
use crate::read::log::{ReadRemark, excerpt};
use crate::read::state::ReaderState;
use std::f64::consts::{PI, TAU};

impl HeidenhainReader {
    /// Takes in a word.
    pub(super) fn word<'a>(
        &mut self,
        state: &mut ReaderState,
        block: &mut PathBlock,
        token: Token<'a>,
        tokens: &mut Tokens<'a>,
    ) -> Result<(), ReadRemark> {
        let upper = token.text.to_ascii_uppercase();
        let bytes = upper.as_bytes();
        match bytes {
            // Letter pairs go first, as R, T, P and F also begin other words.
            // The angle of an approach on an arc, which is refused: its side is that of the compensation.
            b"R0" | [b'C', b'C', b'A', ..] => Ok(()),
            [b'L', b'E', b'N', ..] => {
                let value = tokens.value_of(&token, 3)?;
                block.length = Some(state.control.scale() * self.value(&value)?.value);
                Ok(())
            }
            b"RL" | b"RR" | b"R+" | b"R-" => {
                let help = "post the compensated path with R0";
                Err(ReadRemark::new(token.at, "cutter compensation needs the whole contour", help))
            }
            b"DR+" | b"DR-" => {
                let clockwise = bytes == b"DR-";
                let sense =
                    if clockwise { ArcSense::Clockwise } else { ArcSense::Counterclockwise };
                block.sense = Some(sense);
                Ok(())
            }
            [b'M', b'0'..=b'9' | b' ', ..] => self.m_code(state, block, token),
            [b'M', b'B', ..] if block.retract.is_some() => {
                let value = tokens.value_of(&token, 2)?;
                block.retract = Some(if value.text.trim().eq_ignore_ascii_case("MAX") {
                    Retraction::Limit
                } else {
                    Retraction::Distance(state.control.scale() * self.value(&value)?.value)
                });
                Ok(())
            }
            // The value may stand apart: `F 800`, `F MAX`.
            [b'F', ..] => self.feed(state, block, token, tokens.value_of(&token, 1)?),
            [b'S', ..] => {
                state.control.speed = self.value(&token.after(1))?.value;
                if state.control.sense != 0 {
                    state.control.spindle(state.log.line);
                }
                Ok(())
            }
            [b'R', ..] => {
                // CR R+ is an arc below half a turn, R- one above.
                block.radius = Some(state.control.scale() * self.value(&token.after(1))?.value);
                Ok(())
            }
            [b'T' | b'N', b'X' | b'Y' | b'Z', ..] => self.vector(block, token, bytes),
            [b'P', b'R' | b'A', ..] | [b'I', b'P', b'R' | b'A', ..] => {
                self.polar(state, block, token, bytes)
            }
            _ => self.coordinate(state, block, token, bytes),
        }
    }

    /// Reads `FMAX`, `F MAX`, `F800`.
    fn feed(
        &mut self,
        state: &mut ReaderState,
        block: &mut PathBlock,
        token: Token<'_>,
        value: Token<'_>,
    ) -> Result<(), ReadRemark> {
        if value.text.eq_ignore_ascii_case("MAX") {
            block.rapid = true;
            return Ok(());
        }
        if value.text.eq_ignore_ascii_case("AUTO") {
            // FAUTO is the feed of TOOL CALL.
            let feed = self.tool_feed.ok_or_else(|| {
                ReadRemark::new(token.at, "FAUTO without a feed", "write F in TOOL CALL")
            })?;
            block.feed = Some(feed);
            return Ok(());
        }
        let per_revolution = value.text.starts_with(['U', 'u']);
        let value = if per_revolution { value.after(1) } else { value };
        if value.text.starts_with(|c: char| c.is_ascii_alphabetic() && !"Qq".contains(c)) {
            let message = format!("{} is not understood", excerpt(token.text));
            let help = if value.text.starts_with(['Z', 'z']) {
                "the number of teeth is not in the program: write FU or F"
            } else {
                "write FMAX, FAUTO, FU or F in mm/min"
            };
            return Err(ReadRemark::new(token.at, message, help));
        }
        let found = self.value(&value)?;
        if !(found.value > 0.0 && found.value.is_finite()) {
            let message = format!("F{} is no feed", found.value);
            return Err(ReadRemark::new(token.at, message, "give one above 0"));
        }
        block.per_revolution = per_revolution;
        let turns = per_revolution || self.feed_mode == FeedMode::PerRevolution;
        let unit = if turns { 1.0 } else { feed_unit(state) };
        // A tenth of an inch has one digit more.
        let tenth = u8::from(unit < 1.0 && found.decimals != COMPUTED);
        state.control.note_feed(found.decimals.saturating_add(tenth));
        block.feed = Some(found.value * unit);
        Ok(())
    }

    /// Takes a component of the tool vector, `TX+0.5`. The surface normal `NX NY NZ` is passed over: it
    /// only shifts a tool with oversize.
    fn vector(
        &self,
        block: &mut PathBlock,
        token: Token<'_>,
        bytes: &[u8],
    ) -> Result<(), ReadRemark> {
        let value = self.value(&token.after(2))?.value;
        let [kind, letter, ..] = bytes else { return Ok(()) };
        let place = block.vector.get_mut(usize::from(letter - b'X'));
        if let (b'T', Some(place)) = (kind, place) {
            *place = Some(value);
        }
        Ok(())
    }

    /// Reads `PR+10`, `IPA+360`.
    fn polar(
        &self,
        state: &ReaderState,
        block: &mut PathBlock,
        token: Token<'_>,
        bytes: &[u8],
    ) -> Result<(), ReadRemark> {
        let incremental = bytes.first() == Some(&b'I');
        let skip = 2 + usize::from(incremental);
        // IPR and IPA count from the current polar coordinates.
        let angle = bytes.get(skip - 1) == Some(&b'A');
        let value = self.value(&token.after(skip))?.value;
        let value = if angle { value.to_radians() } else { state.control.scale() * value };
        if let Some(place) = block.polar.get_mut(usize::from(angle)) {
            *place = Some(PolarWord {
                value,
                mode: if incremental { DistanceMode::Incremental } else { DistanceMode::Absolute },
            });
        }
        Ok(())
    }

    /// Reads `X+10`, `IX+5`, `C+30`.
    fn coordinate(
        &mut self,
        state: &mut ReaderState,
        block: &mut PathBlock,
        token: Token<'_>,
        bytes: &[u8],
    ) -> Result<(), ReadRemark> {
        let incremental = bytes.first() == Some(&b'I') && bytes.len() > 1;
        let skip = usize::from(incremental);
        let letter = bytes.get(skip).copied().unwrap_or(0);
        if !letter.is_ascii_uppercase() || bytes.len() < skip + 2 {
            let message = format!("{} is not understood as heidenhain", excerpt(token.text));
            return Err(ReadRemark::new(token.at, message, "is it the right dialect?"));
        }
        let Some(slot) = state.control.slot(letter) else {
            return Err(state.control.no_axis(token.at, &excerpt(token.text)));
        };
        // PLANE .. STAY stores its rotary angles in Q120 to Q122; blocks with these turn to the
        // plane.
        if state.control.is_rotary(slot) && state.control.tilted.is_some_and(|plane| !plane.ready) {
            let value = token.after(skip + 1).text.trim_start_matches('+').to_ascii_uppercase();
            if matches!(value.as_str(), "Q120" | "Q121" | "Q122") {
                block.to_plane = true;
                block.target.at = block.target.at.min(token.at);
                return Ok(());
            }
        }
        let found = self.value(&token.after(skip + 1))?;
        if block.target.get(slot).is_some() {
            let message = format!("second {} word in this block", char::from(letter));
            return Err(ReadRemark::new(token.at, message, "keep one of them"));
        }
        if found.value.abs() > LARGEST {
            let message = format!("{} is beyond {LARGEST} mm or degrees", excerpt(token.text));
            return Err(ReadRemark::new(token.at, message, "is a point missing?"));
        }
        let rotary = state.control.is_rotary(slot);
        self.turned |= rotary && found.value.abs() > 0.0;
        if rotary && self.spatial {
            let help = "write AXIS POS";
            return Err(ReadRemark::new(token.at, "angles in space (AXIS SPAT)", help));
        }
        let mut meant = state.control.meant(slot, found.value, found.decimals);
        if let (true, false, Some(stands)) =
            (rotary && self.shortest, incremental, state.control.reading(slot))
        {
            // Half a turn is as short either way; the control takes the positive one.
            let way = (meant - stands).rem_euclid(TAU);
            meant = stands + if way > PI { way - TAU } else { way };
        }
        block.target.set(
            slot,
            meant,
            if incremental { DistanceMode::Incremental } else { DistanceMode::Absolute },
        );
        block.target.at = block.target.at.min(token.at);
        Ok(())
    }
}
