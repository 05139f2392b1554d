//! Coordinates of a program that is mirrored or rotated.

use crate::read::arc::ArcSense;
use crate::read::control::{ControlState, DistanceMode, MoveTarget};
use crate::read::log::ReadRemark;
use crate::read::positions::rotate;
use std::f64::consts::PI;

/// Mirror image and rotation about the active datum.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ProgramFrame {
    /// The two axes of the plane that count the other way.
    pub(super) mirrored: [bool; 2],
    /// Angle in the plane \[rad\].
    pub(super) turn: f64,
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
