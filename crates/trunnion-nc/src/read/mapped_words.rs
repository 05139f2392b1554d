//! Moves by words that are turned, mirrored or scaled.

use super::control::{ControlState, DistanceMode, MoveTarget, SLOTS};
use super::log::ReadRemark;
use super::step::{Arc, Way};
use super::word_map::{NOTHING, WordMap};
use nalgebra::Matrix2;

impl ControlState {
    /// Returns 0 for X, 1 for Y, 2 for Z.
    fn linear_axis(&self, slot: usize) -> Option<usize> {
        self.xyz.iter().position(|axis| *axis == slot)
    }

    /// Returns the current value of a mapped word \[mm\], as far as the axes it depends on are known.
    pub(super) fn mapped_reading(&self, map: &WordMap, slot: usize) -> Option<f64> {
        let Some(axis) = self.linear_axis(slot) else {
            return Some(self.stands(slot)? - self.tool_offset(slot) - self.shift(slot));
        };
        let mut reading = 0.0;
        for (of, slot) in self.xyz.into_iter().enumerate() {
            let part = map.inverse[(axis, of)];
            if part.abs() > NOTHING {
                let place = self.stands(slot)? - self.tool_offset(slot) - self.shift(slot);
                reading += part * (place - map.shift[of]);
            }
        }
        Some(reading)
    }

    /// Returns mapped readings in the coordinates without map, before any shift.
    pub(super) fn mapped(
        &self,
        map: &WordMap,
        readings: &[Option<f64>; SLOTS],
    ) -> [Option<f64>; SLOTS] {
        let mut mapped = *readings;
        let of = |slot: usize| readings.get(slot).copied().flatten();
        for (axis, slot) in self.xyz.into_iter().enumerate() {
            let mut sum = Some(map.shift[axis]);
            for (from, slot) in self.xyz.into_iter().enumerate() {
                let part = map.linear[(axis, from)];
                if part.abs() > NOTHING {
                    sum = sum.zip(of(slot)).map(|(sum, value)| sum + part * value);
                }
            }
            if let Some(place) = mapped.get_mut(slot) {
                *place = sum;
            }
        }
        mapped
    }

    /// Maps the words of a move, and its arc.
    pub(super) fn map_move(
        &self,
        map: &WordMap,
        target: &mut MoveTarget,
        way: Way,
    ) -> Result<Way, ReadRemark> {
        if target.axis.is_some() {
            let message = "a tool-axis vector in turned, mirrored or scaled coordinates";
            return Err(ReadRemark::new(
                target.at,
                message,
                "post them in those of the work offset",
            ));
        }
        self.map_words(map, target)?;
        match way {
            Way::Line => Ok(way),
            Way::Arc(arc) => self.map_arc(map, arc, target.at).map(Way::Arc),
        }
    }

    fn map_words(&self, map: &WordMap, target: &mut MoveTarget) -> Result<(), ReadRemark> {
        let written = self.xyz.map(|slot| target.get(slot));
        let distance = self.xyz.map(|slot| target.is_incremental(slot));
        // Distances alone are mapped as they are: the shift cancels.
        let distances = written.iter().zip(distance).all(|(word, is)| word.is_none() || is);
        let component = |axis: usize| {
            let stood = || {
                self.reading(self.xyz[axis]).ok_or_else(|| {
                    let message = "turned coordinates from a position that is not stated";
                    ReadRemark::new(target.at, message, "program X, Y and Z absolutely before")
                })
            };
            match written[axis] {
                word if distances => Ok(word.unwrap_or(0.0)),
                None => stood(),
                Some(word) if distance[axis] => Ok(stood()? + word),
                Some(word) => Ok(word),
            }
        };
        let mut words = [None; 3];
        for (axis, word) in words.iter_mut().enumerate() {
            let parts = [0, 1, 2].map(|from: usize| map.linear[(axis, from)]);
            // An axis moves if a written word takes part in it.
            let moves = parts.iter().zip(written).any(|(p, w)| p.abs() > NOTHING && w.is_some());
            if !moves {
                continue;
            }
            let mut sum = if distances { 0.0 } else { map.shift[axis] };
            for (from, part) in parts.into_iter().enumerate() {
                if part.abs() > NOTHING {
                    sum += part * component(from)?;
                }
            }
            *word = Some(sum);
        }
        let mode = if distances { DistanceMode::Incremental } else { DistanceMode::Absolute };
        for (slot, word) in self.xyz.into_iter().zip(words) {
            target.unset(slot);
            if let Some(word) = word {
                target.set(slot, word, mode);
            }
        }
        Ok(())
    }

    /// Maps an arc that stays one: in a plane of axes, scaled alike along both.
    fn map_arc(&self, map: &WordMap, arc: Arc, at: usize) -> Result<Arc, ReadRemark> {
        let refused = || {
            let message = "an arc that the turned or scaled coordinates tilt or stretch";
            ReadRemark::new(at, message, "write lines, or turn in the plane of the arc")
        };
        let axes = arc.plane.map(|slot| self.linear_axis(slot));
        let [Some(u), Some(v)] = axes else { return Err(refused()) };
        let w = 3 - u - v;
        let linear = &map.linear;
        let leaves = [(w, u), (w, v), (u, w), (v, w)];
        let inner = Matrix2::new(linear[(u, u)], linear[(u, v)], linear[(v, u)], linear[(v, v)]);
        let (first, second) = (inner.column(0), inner.column(1));
        let even = (first.norm() - second.norm()).abs() < 1e-9 * first.norm()
            && first.dot(&second).abs() < 1e-9 * first.norm_squared();
        if leaves.iter().any(|at| linear[*at].abs() > NOTHING) || !even {
            return Err(refused());
        }
        let center = inner * nalgebra::Vector2::from(arc.center);
        // A mirrored arc runs the other way round.
        let sweep = arc.sweep * inner.determinant().signum();
        Ok(Arc { center: [center.x, center.y], sweep, ..arc })
    }
}
