//! Positions of a control: what its words read, with shifts, turns and tool offsets, and which of them are known.

use super::control::{ControlState, SLOTS};
use crate::math;

impl ControlState {
    /// Returns the shift added to an absolute word.
    #[inline]
    pub(super) fn shift(&self, slot: usize) -> f64 {
        // A tilted plane has taken the shifts into its origin.
        if self.tilted.is_some() {
            return 0.0;
        }
        self.local.get(slot).copied().unwrap_or(0.0)
            + self.set_by_92.get(slot).copied().unwrap_or(0.0)
    }

    /// Returns the current value of a word as the program would write it \[mm, rad\], without shift.
    pub(super) fn reading(&self, slot: usize) -> Option<f64> {
        let place = self.place.get(slot).copied().flatten()?;
        if let Some(map) = &self.word_map {
            return self.mapped_reading(map, slot);
        }
        // The position contains the shift, the word that leads to it does not.
        if self.turn().abs() > 0.0
            && let Some(axis) = self.turned_axis(slot)
        {
            let [x, y, _] = self.xyz;
            let unturned = rotate(
                [self.stands(x)? - self.tool_offset(x), self.stands(y)? - self.tool_offset(y)],
                -self.turn(),
            );
            return Some(unturned[axis] - self.shift(slot));
        }
        Some(place - self.tool_offset(slot) - self.shift(slot))
    }

    /// Returns the angle by which the active work offset turns X Y words about Z \[rad\].
    pub(super) fn turn(&self) -> f64 {
        self.written_offsets.turn(self.offset)
    }

    /// Returns 0 for X, 1 for Y: the axes that a turned work offset mixes.
    pub(super) fn turned_axis(&self, slot: usize) -> Option<usize> {
        self.xyz.iter().take(2).position(|axis| *axis == slot)
    }

    /// Returns what the tool offset adds to a word, beside the length of the tool.
    pub(super) fn tool_offset(&self, slot: usize) -> f64 {
        self.tool_shift.get(slot).copied().unwrap_or(0.0)
    }

    /// Returns the position that belongs to readings of the program: shifted, turned, with the tool offset.
    pub(super) fn place_of(&self, reading: &[Option<f64>; SLOTS]) -> [Option<f64>; SLOTS] {
        self.place_in(reading, self.turn())
    }

    /// Returns the position that belongs to readings in a work offset with a turn about Z \[rad\].
    pub(super) fn place_in(
        &self,
        reading: &[Option<f64>; SLOTS],
        turn: f64,
    ) -> [Option<f64>; SLOTS] {
        let mapped = self.word_map.map(|map| self.mapped(&map, reading));
        let reading = mapped.as_ref().unwrap_or(reading);
        let shifted = |slot: usize| {
            let reading = reading.get(slot).copied().flatten();
            reading.map(|reading| reading + self.shift(slot))
        };
        let mut place: [Option<f64>; SLOTS] = std::array::from_fn(shifted);
        let [x, y, _] = self.xyz;
        if turn.abs() > 0.0 {
            // Both are needed for either.
            let both = shifted(x).zip(shifted(y));
            let turned = both.map(|(x, y)| rotate([x, y], turn));
            for (axis, slot) in [x, y].into_iter().enumerate() {
                if let Some(place) = place.get_mut(slot) {
                    *place = turned.map(|turned| turned[axis]);
                }
            }
        }
        for (slot, place) in place.iter_mut().enumerate() {
            *place = place.map(|place| place + self.tool_offset(slot));
        }
        place
    }

    /// Takes axes to be at positions of the program, to which the next move leads.
    pub(super) fn restate<const N: usize>(&mut self, slots: [usize; N], position: [f64; N]) {
        let mut readings = self.readings();
        self.beside = self.place;
        for (slot, value) in slots.into_iter().zip(position) {
            self.restated |= 1 << slot;
            if let Some(reading) = readings.get_mut(slot) {
                *reading = Some(value);
            }
        }
        self.place = self.place_of(&readings);
    }

    /// Returns what the program would read at the present position.
    pub(super) fn readings(&self) -> [Option<f64>; SLOTS] {
        std::array::from_fn(|slot| self.reading(slot))
    }

    /// Returns the position of a slot including its shift \[mm, rad\].
    pub(super) fn stands(&self, slot: usize) -> Option<f64> {
        self.place.get(slot).copied().flatten()
    }

    /// Marks the positions of the linear axes as unknown.
    pub(super) fn forget_linear(&mut self) {
        self.forget(|rotary| !rotary);
    }

    pub(super) fn forget(&mut self, which: impl Fn(bool) -> bool) {
        for slot in 0..SLOTS {
            let rotary = self.is_rotary(slot);
            if let (Some(place), true) = (self.place.get_mut(slot), which(rotary)) {
                *place = None;
            }
        }
    }
}

/// Turns a vector counterclockwise.
pub(super) fn rotate([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = math::sin_cos(angle);
    [x * cos - y * sin, x * sin + y * cos]
}
