//! Turned, mirrored and polar coordinates of Fanuc and Haas: `G68`, `G51.1`, `G101`, `G16`.

use super::block::{CodeWord, GcodeBlock};
use super::reader::GcodeReader;
use crate::math;
use crate::read::control::{DistanceMode, MoveTarget};
use crate::read::dialect::Dialect;
use crate::read::log::{ReadRemark, column};
use crate::read::state::ReaderState;
use crate::read::word_map::{WordMap, turn_about};
use nalgebra::{Matrix3, Vector3};

/// End of a move in polar coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct PolarEnd {
    slots: [usize; 2],
    place: [f64; 2],
    at: usize,
}

impl PolarEnd {
    /// Sets the words of the plane.
    pub(super) fn apply(&self, target: &mut MoveTarget, text: &str) {
        for (slot, value) in self.slots.into_iter().zip(self.place) {
            target.set(slot, value, DistanceMode::Absolute);
        }
        target.at = if target.column <= 1 { self.at } else { target.at.min(self.at) };
        target.column = column(text, target.at);
    }
}

impl GcodeReader {
    /// Runs `G68`, `G51`, `G51.1`, `G50.1`, `G100`, `G101`.
    pub(super) fn map_code(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: CodeWord,
    ) -> Result<(), ReadRemark> {
        let refused = |message: &str, help: &str| Err(ReadRemark::new(code.at, message, help));
        if state.control.tcp || state.control.tilted.is_some() {
            let message = "turned or mirrored coordinates under TCP or in a tilted plane";
            return refused(message, "post them in the coordinates of the work offset");
        }
        match code.tenths {
            // The unit of P (1, 0.001 or 0.00001) and the axes it scales are settings.
            510 => {
                let one = block.take('P').is_some_and(|word| (word.value - 1.0).abs() <= 0.0);
                if one && self.target(state, block, text)?.words.iter().all(Option::is_none) {
                    return Ok(());
                }
                refused("scaling (G51)", "settings say what P means; post scaled coordinates")
            }
            680 => self.turn_words(state, block, text, code.at),
            _ => self.mirror_words(state, block, text, code),
        }
    }

    /// Runs `G68 X1 Y2 R30`: words turn about a point in the plane.
    fn turn_words(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let refused = |message: &str, help: &str| Err(ReadRemark::new(at, message, help));
        if state.control.word_map.is_some() {
            return refused(
                "G68 on top of another G68 or a mirror image",
                "end it before (G69, G50.1)",
            );
        }
        if self.modal.distance == DistanceMode::Incremental {
            return refused("G68 in G91", "a parameter says what R means then; write G90");
        }
        let Some(angle) = block.take('R') else {
            return refused("G68 without R", "write the angle");
        };
        let (axes, _) = self.plane();
        let target = self.target(state, block, text)?;
        let mut center = Vector3::zeros();
        for axis in axes.into_iter().take(2) {
            let slot = state.control.xyz[axis];
            // Without words the point is where the tool stands.
            let Some(value) = target.get(slot).or_else(|| state.control.reading(slot)) else {
                return refused(
                    "G68 about a point that is not stated",
                    "write both words of the plane",
                );
            };
            center[axis] = value;
        }
        // Counterclockwise, seen against the axis of the plane.
        let turn = turn_about(axes[2], angle.value.to_radians());
        state.control.word_map = WordMap::about(turn, center);
        Ok(())
    }

    /// Runs `G51.1 X0`, `G50.1 X0`, `G101 X0`, `G100`.
    fn mirror_words(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: CodeWord,
    ) -> Result<(), ReadRemark> {
        let refused = |message: &str, help: &str| Err(ReadRemark::new(code.at, message, help));
        if matches!(code.tenths, 1000 | 1010) && self.dialect != Dialect::Haas {
            return refused("G100 and G101 are of Haas", "write G51.1 and G50.1");
        }
        if state.control.word_map.is_some() && !self.modal.mirrors() {
            return refused("a mirror image on top of G68", "end it before (G69)");
        }
        let on = matches!(code.tenths, 511 | 1010);
        let target = self.target(state, block, text)?;
        if (0..target.words.len())
            .any(|slot| target.get(slot).is_some() && state.control.is_rotary(slot))
        {
            return refused("a mirror image of a rotary axis", "X, Y and Z are");
        }
        let xyz = state.control.xyz;
        let named = xyz.iter().any(|slot| target.get(*slot).is_some());
        if on && !named {
            return refused("a mirror image without axes", "name them: G51.1 X0");
        }
        for (slot, mirror) in xyz.into_iter().zip(&mut self.modal.mirror) {
            match target.get(slot) {
                // G101 mirrors at the origin, whatever the value.
                Some(value) if on => *mirror = Some(if code.tenths == 1010 { 0.0 } else { value }),
                None if on || named => {}
                _ => *mirror = None,
            }
        }
        let mirror = self.modal.mirror;
        state.control.word_map = if self.modal.mirrors() {
            // x' = 2 c - x.
            let sign = mirror.map(|at| if at.is_some() { -1.0 } else { 1.0 });
            let center = Vector3::from(mirror.map(|at| at.unwrap_or(0.0)));
            WordMap::about(Matrix3::from_diagonal(&Vector3::from(sign)), center)
        } else {
            None
        };
        Ok(())
    }

    /// Takes the words of the plane as distance and angle, in `G16`.
    pub(super) fn polar_words(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
    ) -> Result<Option<PolarEnd>, ReadRemark> {
        let Some(mut polar) = self.modal.polar else { return Ok(None) };
        let (axes, _) = self.plane();
        let slots = [axes[0], axes[1]].map(|axis| state.control.xyz[axis]);
        let mut words = [None; 2];
        for (word, slot) in words.iter_mut().zip(slots) {
            *word = state.control.letter(slot).and_then(|letter| block.take(letter));
        }
        let [radius, angle] = words;
        let Some(first) = radius.or(angle) else { return Ok(None) };
        if self.modal.distance == DistanceMode::Incremental {
            let message = "polar coordinates (G16) in G91";
            return Err(ReadRemark::new(first.at, message, "write G90, or X and Y"));
        }
        polar.radius = radius.map(|word| state.control.scale() * word.value).or(polar.radius);
        polar.angle = angle.map(|word| word.value).or(polar.angle);
        self.modal.polar = Some(polar);
        let (Some(radius), Some(angle)) = (polar.radius, polar.angle) else {
            let message = "polar coordinates (G16) with a distance or an angle alone";
            return Err(ReadRemark::new(first.at, message, "write both behind G16"));
        };
        let (sin, cos) = math::sin_cos(angle.to_radians());
        let place = [radius * cos, radius * sin];
        Ok(Some(PolarEnd { slots, place, at: first.at }))
    }
}
