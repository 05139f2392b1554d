//! Blocks that move: `L`, `LN`, `C`, `CR`, `CT`, `CP`, `LP`, `CTP`, and `CC`.

use super::path_block::{PathBlock, Retraction};
use super::reader::{HeidenhainReader, LastPace};
use super::token::{Token, Tokens};
use crate::read::arc;
use crate::read::control::{DistanceMode, FeedMode, MoveTarget, SLOTS};
use crate::read::gcode::axis_of;
use crate::read::log::{ReadRemark, column};
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Way};
use crate::read::tilt::HeldPoint;
use nalgebra::Vector3;

impl HeidenhainReader {
    /// Reads the words of a block and moves.
    pub(super) fn path(
        &mut self,
        state: &mut ReaderState,
        word: &str,
        first: &Token<'_>,
        mut tokens: Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let mut block = PathBlock::new();
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
}
