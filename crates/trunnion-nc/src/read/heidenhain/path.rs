//! Blocks that move: `L`, `LN`, `C`, `CR`, `CT`, `CP`, `LP`, `CTP`, and `CC`.

use super::reader::{HeidenhainReader, LastPace};
use super::token::{Token, Tokens};
use super::units::feed_unit;
use crate::read::arc;
use crate::read::arc::{ArcForm, ArcSense, GivenArc};
use crate::read::control::{COMPUTED, DistanceMode, FeedMode, LARGEST, MoveTarget, SLOTS};
use crate::read::gcode::axis_of;
use crate::read::log::{ReadRemark, column, excerpt};
use crate::read::state::ReaderState;
use crate::read::step::{Arc, Pace, Way};
use crate::read::tilt::HeldPoint;
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// A polar word: `PR`, `PA`, `IPR`, `IPA`.
#[derive(Debug, Clone, Copy)]
struct PolarWord {
    /// Radius \[mm\] or angle \[rad\].
    value: f64,
    mode: DistanceMode,
}

/// Retraction along the tool axis.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Retraction {
    /// `M140`: `MB` is to follow.
    Unstated,
    /// `MB50` \[mm\].
    Distance(f64),
    /// `MB MAX`.
    Limit,
}

/// Words of a block.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "words that stand in a block or do not")]
pub(super) struct PathBlock {
    pub(super) target: MoveTarget,
    /// `TX TY TZ`.
    vector: [Option<f64>; 3],
    pub(super) feed: Option<f64>,
    /// `FU`: the feed is one per revolution.
    per_revolution: bool,
    pub(super) rapid: bool,
    /// `DR+` is counterclockwise.
    sense: Option<ArcSense>,
    pub(super) radius: Option<f64>,
    /// `LEN` \[mm\].
    pub(super) length: Option<f64>,
    /// `PR`, `PA`.
    polar: [Option<PolarWord>; 2],
    /// `M128` stood in the block: F is how fast it may compensate.
    tcpm: bool,
    /// `M99`.
    calls: bool,
    /// `M140`, and how far `MB` retracts.
    retract: Option<Retraction>,
    /// `C+Q122`: the rotary axes go where `PLANE` reckoned.
    to_plane: bool,
    ends: bool,
    stop: Option<(usize, usize)>,
}

impl HeidenhainReader {
    /// Reads the words of a block and moves.
    pub(super) fn path(
        &mut self,
        state: &mut ReaderState,
        word: &str,
        first: &Token<'_>,
        mut tokens: Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let mut block = PathBlock {
            target: MoveTarget::new(usize::MAX, 1),
            vector: [None; 3],
            feed: None,
            per_revolution: false,
            rapid: false,
            sense: None,
            radius: None,
            length: None,
            polar: [None; 2],
            tcpm: false,
            calls: false,
            retract: None,
            to_plane: false,
            ends: false,
            stop: None,
        };
        while let Some(token) = tokens.next_word() {
            self.word(state, &mut block, token, &mut tokens)?;
        }
        // A block without axis words is placed at its first word.
        if block.target.at == usize::MAX {
            block.target.at = first.at;
        }
        let line = state.log.line;
        block.target.column = column(tokens.text(), block.target.at);
        if word == "CC" {
            return self.set_pole(state, &block);
        }
        if let Some(retraction) = block.retract {
            self.retract(state, &block, retraction)?;
        } else {
            self.go(state, word, &mut block)?;
        }
        if !block.target.is_empty() {
            self.last_pace = Some(if block.rapid { LastPace::Rapid } else { LastPace::Feed });
        }
        if block.calls {
            self.call_cycle(state, first.at)?;
        }
        if let Some((at, end)) = block.stop {
            state.control.keep(line, tokens.text().get(at..end).unwrap_or_default());
        }
        state.control.ended |= block.ends;
        Ok(())
    }

    fn word(
        &mut self,
        state: &mut ReaderState,
        block: &mut PathBlock,
        token: Token<'_>,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let upper = token.text.to_ascii_uppercase();
        let bytes = upper.as_bytes();
        match bytes {
            // Letter pairs go first, as R, T, P and F also begin other words.
            // The angle of an approach on an arc, which is refused: its side is that of the compensation.
            b"R0" | [b'C', b'C', b'A', ..] => Ok(()),
            [b'L', b'E', b'N', ..] => {
                let value = if token.text.len() == 3 { tokens.expect()? } else { token.after(3) };
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
                let value = if token.text.len() == 2 { tokens.expect()? } else { token.after(2) };
                block.retract = Some(if value.text.trim().eq_ignore_ascii_case("MAX") {
                    Retraction::Limit
                } else {
                    Retraction::Distance(state.control.scale() * self.value(&value)?.value)
                });
                Ok(())
            }
            [b'F', ..] => self.feed(state, block, token, tokens),
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
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        // The value may stand apart: `F 800`, `F MAX`.
        let value = if token.text.len() == 1 { tokens.expect()? } else { token.after(1) };
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

    /// Runs an M function.
    fn m_code(
        &mut self,
        state: &mut ReaderState,
        block: &mut PathBlock,
        token: Token<'_>,
    ) -> Result<(), ReadRemark> {
        let number =
            token.text.get(1..).unwrap_or_default().trim().parse::<u32>().unwrap_or(u32::MAX);
        let line = state.log.line;
        match number {
            2 | 30 => block.ends = true,
            0 | 1 => block.stop = Some((token.at, token.at + token.text.len())),
            3 | 4 | 5 | 13 | 14 => {
                let cw = i8::from(matches!(number, 3 | 13));
                state.control.sense = cw - i8::from(matches!(number, 4 | 14));
                state.control.spindle(line);
                // M13 and M14 switch the coolant on as well.
                if number > 5 {
                    state.control.keep(line, token.text);
                }
            }
            // Coolant, messages, look-ahead, and ends of modes that are refused where they begin.
            6..=9 | 90 | 102 | 107 | 108 | 111 | 113 | 115 | 117 | 120 | 141 | 145 | 148 | 149 => {
                state.control.keep(line, token.text);
            }
            // Cutting feeds are per revolution of the spindle.
            136 | 137 => {
                self.feed_mode =
                    if number == 136 { FeedMode::PerRevolution } else { FeedMode::PerMinute };
                state.control.feed_mode = self.feed_mode;
                state.control.feed = None;
            }
            // M91: axis positions, in its block.
            91 => block.target.machine = true,
            99 => block.calls = true,
            140 => block.retract = Some(Retraction::Unstated),
            // M126: rotaries take the shorter way; M127 ends it.
            126 | 127 => self.shortest = number == 126,
            // M128 is FUNCTION TCPM; an F beside it limits the compensation only.
            128 => {
                state.control.enable_tcp();
                block.tcpm = true;
            }
            129 => {
                state.control.disable_tcp();
                state.control.turning = None;
            }
            89 | 92 | 94 | 97 | 98 | 101..=119 | 121..=125 | 130..=150 => {
                let message = format!("{} is not understood", excerpt(token.text));
                let help = match number {
                    // A machine parameter decides what M89 does.
                    89 => "write M99 in each block that is to call the cycle",
                    92 => "write axis positions with M91",
                    94 => "write M126, or rotary words that count on",
                    116 => "write the feed in degrees a minute, or move under TCPM",
                    124 => "the control leaves out points of the path: post with all of them",
                    _ => "it changes what words or feeds mean; post without it",
                };
                return Err(ReadRemark::new(token.at, message, help));
            }
            u32::MAX => return Err(ReadRemark::new(token.at, "M without a number", "")),
            _ => {
                let message = format!(
                    "{} is not known: it is kept, and taken to move nothing",
                    excerpt(token.text)
                );
                state.log.warn("", ReadRemark::new(token.at, message, ""));
                state.control.keep(line, token.text);
            }
        }
        Ok(())
    }

    /// Sets the pole: `CC X+0 Y+0`; alone: the current position.
    fn set_pole(&mut self, state: &ReaderState, block: &PathBlock) -> Result<(), ReadRemark> {
        // CC without axes takes the current position as the pole.
        let all = block.target.is_empty();
        let mut target = block.target;
        self.frame.place(&state.control, &mut target, self.plane_slots(state))?;
        for axis in 0..3 {
            let slot = state.control.xyz[axis];
            let stands = state.control.reading(slot);
            let value = match target.get(slot) {
                Some(word) if target.is_incremental(slot) => {
                    Some(word + stands.ok_or_else(|| arc::unknown_start(block.target.at))?)
                }
                Some(word) => Some(word),
                None if all => stands,
                None => continue,
            };
            if let Some(place) = self.pole.get_mut(axis) {
                *place = value;
            }
        }
        Ok(())
    }

    fn go(
        &mut self,
        state: &mut ReaderState,
        word: &str,
        block: &mut PathBlock,
    ) -> Result<(), ReadRemark> {
        let at = block.target.at;
        // F is modal, unless it stands beside M128 as the speed of compensation.
        if let (Some(feed), false) = (block.feed, block.tcpm && block.target.is_empty()) {
            state.control.feed = Some(feed);
            let per_revolution = block.per_revolution || self.feed_mode == FeedMode::PerRevolution;
            state.control.feed_mode =
                if per_revolution { FeedMode::PerRevolution } else { FeedMode::PerMinute };
        }
        if block.to_plane {
            if !block.target.is_empty() {
                let help = "turn the rotary axes in a block of its own";
                return Err(ReadRemark::new(at, "Q120 to Q122 beside other axes", help));
            }
            let held = if state.control.tcp { HeldPoint::Tip } else { HeldPoint::LinearAxes };
            return state.control.turn_to_plane(state.log.line, at, held);
        }
        if block.vector.iter().any(Option::is_some) {
            self.turned = true;
            // Tool vectors need TCPM: without it X Y Z would be axis positions.
            if word != "LN" || !state.control.tcp {
                let message = "TX TY TZ without LN or without TCPM";
                return Err(ReadRemark::new(at, message, "write FUNCTION TCPM or M128 before"));
            }
            let [x, y, z] = block.vector.map(|value| value.unwrap_or(0.0));
            block.target.axis = Some(axis_of(Vector3::new(x, y, z), at)?);
        }
        let plane = self.plane_slots(state);
        self.frame.place(&state.control, &mut block.target, plane)?;
        if let Some(kind) = word.strip_prefix("APPR ") {
            return self.approach(state, kind, block);
        }
        if let Some(kind) = word.strip_prefix("DEP ") {
            return self.depart(state, kind, block);
        }
        let way = match word {
            "C" => Some(self.circle_about_pole(state, block)?),
            "CR" => Some(self.circle_by_radius(state, block)?),
            "CT" => Some(self.tangent_circle(state, block)?),
            "CTP" => {
                self.polar_end(state, block)?;
                Some(self.tangent_circle(state, block)?)
            }
            "CP" => Some(self.polar_circle(state, block)?),
            // A polar end is reckoned into X Y Z; the move is straight.
            "LP" => {
                self.polar_end(state, block)?;
                None
            }
            _ => None,
        };
        if block.target.is_empty() && way.is_none() {
            return Ok(());
        }
        let pace = Self::pace(state, block)?;
        state.control.go(state.log.line, block.target, pace, way.unwrap_or(Way::Line))
    }

    /// Returns the pace of a block.
    pub(super) fn pace(state: &ReaderState, block: &PathBlock) -> Result<Pace, ReadRemark> {
        if block.rapid {
            return Ok(Pace::Rapid);
        }
        let linear = state.control.xyz.iter().any(|slot| block.target.get(*slot).is_some());
        if state.control.inch && !linear && block.target.axis.is_none() {
            let message = "a feed of rotary axes alone in an INCH program";
            let help = "move them with FMAX, or together with X, Y or Z";
            return Err(ReadRemark::new(block.target.at, message, help));
        }
        state.control.pace(&block.target, block.feed)
    }

    /// Returns the slots of the plane of circles.
    pub(super) fn plane_slots(&self, state: &ReaderState) -> [usize; 2] {
        self.plane.map(|axis| state.control.xyz[axis])
    }

    /// Retracts along the tool axis: `M140 MB50 F500`, `M140 MB MAX`.
    fn retract(
        &self,
        state: &mut ReaderState,
        block: &PathBlock,
        retraction: Retraction,
    ) -> Result<(), ReadRemark> {
        let at = block.target.at;
        if !block.target.is_empty() {
            let help = "retract in a block of its own";
            return Err(ReadRemark::new(at, "M140 beside axis words", help));
        }
        // Which way a turned tool points is known to the machine, not to the text.
        let stands = |slot: usize| match state.control.reading(slot) {
            Some(angle) => angle.abs() <= 0.0,
            None => !self.turned,
        };
        let upright = (0..SLOTS).all(|slot| !state.control.is_rotary(slot) || stands(slot));
        let in_plane = state.control.tilted.is_some_and(|plane| plane.ready);
        let axis = 3 - self.plane[0] - self.plane[1];
        let slot = state.control.xyz.get(axis).copied().unwrap_or(2);
        let mut target = MoveTarget::new(at, block.target.column);
        match retraction {
            Retraction::Distance(distance) if upright || in_plane => {
                target.set(slot, distance, DistanceMode::Incremental);
            }
            Retraction::Limit if upright && !in_plane && axis == 2 => {
                let Some(height) = self.retract_height else {
                    let help = "write L Z with M91 and the upper end of its travel";
                    return Err(ReadRemark::new(at, "M140 MB MAX without a machine", help));
                };
                target.machine = true;
                target.set(slot, height, DistanceMode::Absolute);
            }
            Retraction::Unstated => {
                return Err(ReadRemark::new(at, "M140 without MB", "write MB MAX or a distance"));
            }
            _ => {
                let help = "write the retract as L with its coordinates, or with M91";
                return Err(ReadRemark::new(at, "M140 with a turned tool", help));
            }
        }
        // Without F the control retracts in rapid.
        let pace = match block.feed {
            None => Pace::Rapid,
            Some(feed) => Pace::PerMinute { speed: feed * state.control.scale() / 60.0 },
        };
        state.control.go(state.log.line, target, pace, Way::Line)
    }

    /// Returns the pole relative to the current position \[mm\].
    fn pole_from_here(&self, state: &ReaderState, at: usize) -> Result<[f64; 2], ReadRemark> {
        let from = |axis: usize| {
            // The pole is in words, as the current position is: shifts cancel.
            let pole = self.pole.get(axis).copied().flatten().ok_or_else(|| {
                ReadRemark::new(at, "a circle or polar word without its pole", "write CC before it")
            })?;
            let place = state.control.reading(state.control.xyz[axis]);
            Ok::<f64, ReadRemark>(pole - place.ok_or_else(|| arc::unknown_start(at))?)
        };
        Ok([from(self.plane[0])?, from(self.plane[1])?])
    }

    fn sense(&self, block: &PathBlock) -> Result<ArcSense, ReadRemark> {
        let written = block.sense.ok_or_else(|| {
            ReadRemark::new(block.target.at, "a circle without its sense", "write DR+ or DR-")
        })?;
        Ok(self.frame.sense(written))
    }

    /// Returns the arc of `C X Y DR+`: about the pole.
    fn circle_about_pole(&self, state: &ReaderState, block: &PathBlock) -> Result<Way, ReadRemark> {
        let sense = self.sense(block)?;
        let form = ArcForm::Center(self.pole_from_here(state, block.target.at)?);
        let plane = self.plane.map(|axis| state.control.xyz[axis]);
        arc::way(
            &state.control,
            &block.target,
            &GivenArc { plane, form, sense, turns: 1, rounded: arc::ROUNDED },
        )
    }

    /// Returns the arc of `CR X Y R+20 DR+`.
    fn circle_by_radius(&self, state: &ReaderState, block: &PathBlock) -> Result<Way, ReadRemark> {
        let at = block.target.at;
        let sense = self.sense(block)?;
        let radius = block.radius;
        let radius =
            radius.ok_or_else(|| ReadRemark::new(at, "CR without R", "write its radius"))?;
        let form = ArcForm::Radius(radius);
        let plane = self.plane.map(|axis| state.control.xyz[axis]);
        arc::way(
            &state.control,
            &block.target,
            &GivenArc { plane, form, sense, turns: 1, rounded: arc::ROUNDED },
        )
    }

    /// Returns the arc of `CP IPA+720 DR+ IZ-5`: about the pole, any number of turns.
    fn polar_circle(&self, state: &ReaderState, block: &mut PathBlock) -> Result<Way, ReadRemark> {
        let at = block.target.at;
        let clockwise = self.sense(block)? == ArcSense::Clockwise;
        let center = self.pole_from_here(state, at)?;
        // Polar angle of the current position about the pole.
        let start = (-center[1]).atan2(-center[0]);
        let Some(PolarWord { value: angle, mode }) = block.polar[1] else {
            return Err(ReadRemark::new(at, "CP without its angle", "write PA or IPA"));
        };
        let angle = self.frame.angle(angle, mode);
        let sweep = if mode == DistanceMode::Incremental {
            angle
        } else {
            // PA is absolute: the sweep in [0, 2π), less a turn for DR-.
            let up = (angle - start).rem_euclid(TAU);
            if clockwise { up - TAU } else { up }
        };
        // The sign of IPA is the sense of rotation, which DR repeats.
        if (sweep < 0.0) != clockwise || sweep.abs() > LARGEST {
            let message = "the angle of CP runs against DR";
            return Err(ReadRemark::new(at, message, "their signs must agree"));
        }
        let plane = self.plane.map(|axis| state.control.xyz[axis]);
        let arc = Arc { plane, center, sweep };
        // The end follows from centre and sweep, as a distance from the start.
        for (slot, change) in plane.into_iter().zip(arc.at(1.0)) {
            block.target.set(slot, change, DistanceMode::Incremental);
        }
        Ok(Way::Arc(arc))
    }

    /// Sets the end of `LP PR+10 PA+30`.
    pub(super) fn polar_end(
        &self,
        state: &ReaderState,
        block: &mut PathBlock,
    ) -> Result<(), ReadRemark> {
        let at = block.target.at;
        let center = self.pole_from_here(state, at)?;
        let [from_radius, from_angle] =
            [center[0].hypot(center[1]), (-center[1]).atan2(-center[0])];
        let value = |given: Option<PolarWord>, from: f64| match given {
            Some(PolarWord { value, mode: DistanceMode::Incremental }) => from + value,
            Some(PolarWord { value, mode: DistanceMode::Absolute }) => value,
            None => from,
        };
        let radius = value(block.polar[0], from_radius);
        let turned = block.polar[1].map(|word| {
            let value = self.frame.angle(word.value, word.mode);
            PolarWord { value, ..word }
        });
        let angle = value(turned, from_angle);
        // Pole plus radius in the direction of the angle, relative to the current position.
        let end = [center[0] + radius * angle.cos(), center[1] + radius * angle.sin()];
        let plane = self.plane.map(|axis| state.control.xyz[axis]);
        for (slot, change) in plane.into_iter().zip(end) {
            block.target.set(slot, change, DistanceMode::Incremental);
        }
        Ok(())
    }
}
