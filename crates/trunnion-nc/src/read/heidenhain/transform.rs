//! Coordinates of a program that is mirrored or rotated: cycles 8 and 10.

use super::reader::HeidenhainReader;
use super::token::Tokens;
use crate::read::arc::ArcSense;
use crate::read::control::{ControlState, DistanceMode, MoveTarget, rotate};
use crate::read::log::{ReadRemark, excerpt};
use crate::read::state::ReaderState;
use std::f64::consts::PI;

/// Mirror image and rotation about the active datum.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ProgramFrame {
    /// The two axes of the plane that count the other way.
    mirrored: [bool; 2],
    /// Angle in the plane \[rad\].
    turn: f64,
}

impl ProgramFrame {
    /// Returns true if words are as written.
    pub(super) fn is_plain(&self) -> bool {
        *self == Self::default()
    }

    fn is_mirrored(&self) -> bool {
        self.mirrored[0] != self.mirrored[1]
    }

    /// Returns the sense of an arc as it is run.
    pub(super) fn sense(&self, written: ArcSense) -> ArcSense {
        match (written, self.is_mirrored()) {
            (sense, false) => sense,
            (ArcSense::Clockwise, true) => ArcSense::Counterclockwise,
            (ArcSense::Counterclockwise, true) => ArcSense::Clockwise,
        }
    }

    /// Returns a polar angle as it is run \[rad\].
    pub(super) fn angle(&self, written: f64, mode: DistanceMode) -> f64 {
        let sign = if self.is_mirrored() { -1.0 } else { 1.0 };
        match mode {
            DistanceMode::Incremental => sign * written,
            // A mirrored first axis takes a to π - a, a mirrored second to -a.
            DistanceMode::Absolute => {
                let start = if self.mirrored[0] { PI } else { 0.0 };
                self.turn + start + sign * written
            }
        }
    }

    /// Turns the words of a move into those of the work offset.
    pub(super) fn place(
        &self,
        control: &ControlState,
        target: &mut MoveTarget,
        plane: [usize; 2],
    ) -> Result<(), ReadRemark> {
        // M91 is in axis positions.
        if self.is_plain() || target.machine {
            return Ok(());
        }
        let rotary = |slot: usize| target.get(slot).is_some() && control.is_rotary(slot);
        if target.axis.is_some() || (0..target.words.len()).any(rotary) {
            let message = "rotary words or tool vectors in a mirrored or rotated program";
            return Err(ReadRemark::new(target.at, message, "cancel cycles 8 and 10 before"));
        }
        for (slot, mirrored) in plane.into_iter().zip(self.mirrored) {
            if let (true, Some(word)) = (mirrored, target.words.get_mut(slot)) {
                *word = word.map(|word| -word);
            }
        }
        if self.turn.abs() > 0.0 { self.rotate(control, target, plane) } else { Ok(()) }
    }

    fn rotate(
        &self,
        control: &ControlState,
        target: &mut MoveTarget,
        [u, v]: [usize; 2],
    ) -> Result<(), ReadRemark> {
        let slots = [u, v];
        if slots.iter().all(|slot| target.get(*slot).is_none()) {
            return Ok(());
        }
        let distance = |slot: usize| target.get(slot).is_none() || target.is_incremental(slot);
        let (mode, written) = if slots.iter().all(|slot| distance(*slot)) {
            let distances = slots.map(|slot| target.get(slot).unwrap_or(0.0));
            (DistanceMode::Incremental, distances)
        } else {
            // One word of two moves both axes, so that the place has to be known.
            let stands = control.reading(u).zip(control.reading(v));
            let stands = stands.map(|(u, v)| rotate([u, v], -self.turn));
            let mut written = [0.0; 2];
            for (axis, slot) in slots.into_iter().enumerate() {
                let stood = || {
                    stands.map(|stands| stands[axis]).ok_or_else(|| {
                        let message = "one axis in a rotated program, the other is not stated";
                        ReadRemark::new(target.at, message, "program both absolutely first")
                    })
                };
                written[axis] = match target.get(slot) {
                    None => stood()?,
                    Some(word) if target.is_incremental(slot) => stood()? + word,
                    Some(word) => word,
                };
            }
            (DistanceMode::Absolute, written)
        };
        for (slot, value) in slots.into_iter().zip(rotate(written, self.turn)) {
            target.set(slot, value, mode);
        }
        Ok(())
    }
}

impl HeidenhainReader {
    /// Takes `8.1 X Y`; without axes it ends the mirror image.
    pub(super) fn mirror(
        &mut self,
        state: &ReaderState,
        tokens: &mut Tokens<'_>,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let mut mirrored = [false; 2];
        while let Some(token) = tokens.next_token() {
            let letters = ["X", "Y", "Z"];
            let axis = letters.iter().position(|letter| token.text.eq_ignore_ascii_case(letter));
            let in_plane = self.plane.iter().position(|slot| Some(*slot) == axis);
            let Some(place) = in_plane.and_then(|place| mirrored.get_mut(place)) else {
                let message = format!("a mirror image of {} (cycle 8)", excerpt(token.text));
                return Err(ReadRemark::new(token.at, message, "post without it"));
            };
            *place = true;
        }
        let turned = self.frame.turn.abs() > 0.0;
        if turned && mirrored.contains(&true) {
            let help = "cancel cycle 10 before, or post without them";
            return Err(ReadRemark::new(at, "a mirror image of a rotated program", help));
        }
        self.reframe(state, ProgramFrame { mirrored, ..self.frame }, at)
    }

    /// Takes `10.1 ROT+30`, `10.1 IROT+5`; zero ends the rotation.
    pub(super) fn rotation(
        &mut self,
        state: &ReaderState,
        tokens: &mut Tokens<'_>,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let text: String = std::iter::from_fn(|| tokens.next_token())
            .map(|token| token.text.to_ascii_uppercase())
            .collect();
        let (incremental, written) = match text.strip_prefix("IROT") {
            Some(written) => (true, written),
            None => (false, text.strip_prefix("ROT").unwrap_or(&text)),
        };
        let angle = self.arithmetic(written, at)?.to_radians();
        let turn = if incremental { self.frame.turn + angle } else { angle };
        if turn.abs() > 0.0 && self.frame.mirrored.contains(&true) {
            let help = "cancel cycle 8 before, or post without them";
            return Err(ReadRemark::new(at, "a rotation of a mirrored program", help));
        }
        self.reframe(state, ProgramFrame { turn, ..self.frame }, at)
    }

    fn reframe(
        &mut self,
        state: &ReaderState,
        frame: ProgramFrame,
        at: usize,
    ) -> Result<(), ReadRemark> {
        if state.control.tilted.is_some() && !frame.is_plain() {
            let help = "post without it, or write the angle into PLANE";
            return Err(ReadRemark::new(at, "cycles 8 and 10 in a tilted plane", help));
        }
        // Poles are kept as they are run, so that one of another frame would be another place.
        self.pole = [None; 3];
        self.frame = frame;
        Ok(())
    }

    /// Checks that words are as written.
    pub(super) fn plain_frame(&self, at: usize, what: &str) -> Result<(), ReadRemark> {
        if self.frame.is_plain() {
            return Ok(());
        }
        let message = format!("{what} in a mirrored or rotated program");
        Err(ReadRemark::new(at, message, "cancel cycles 8 and 10 before"))
    }
}
