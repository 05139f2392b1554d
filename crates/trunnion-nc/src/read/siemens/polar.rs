//! Polar coordinates: `G110`, `G111`, `G112`, `AP=`, `RP=`.

use super::line::{CenterWord, SiemensBlock, SiemensMotion};
use super::reader::SiemensReader;
use super::value::ValueMode;
use super::word::SiemensWord;
use crate::math;
use crate::read::control::DistanceMode;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;

impl SiemensReader {
    /// Reads `AP=30` \[degrees\] or `RP=IC(5)` \[mm\].
    pub(super) fn polar_word(
        &self,
        state: &ReaderState,
        line: &mut SiemensBlock,
        item: &SiemensWord<'_>,
        name: &str,
    ) -> Result<(), ReadRemark> {
        let (value, mode) = self.value(item)?;
        if self.distance == DistanceMode::Incremental && mode == ValueMode::Plain {
            let message = "polar coordinates in G91";
            return Err(ReadRemark::new(item.at, message, "write G90, or AC(..) and IC(..)"));
        }
        let mode = match mode {
            ValueMode::Incremental => DistanceMode::Incremental,
            _ => DistanceMode::Absolute,
        };
        let angle = name == "AP";
        let scale = if angle { 1.0 } else { state.control.scale() };
        line.polar[usize::from(angle)] = Some(CenterWord { value: scale * value.number, mode });
        line.target.at = line.target.at.min(item.at);
        Ok(())
    }

    /// Slots of the axes of the active plane.
    fn plane_slots(&self, state: &ReaderState) -> [usize; 2] {
        let axes = match self.plane {
            1 => [2, 0],
            2 => [1, 2],
            _ => [0, 1],
        };
        axes.map(|axis: usize| state.control.xyz[axis])
    }

    /// Sets the pole: `G110` from the present place, `G111` from the origin, `G112` from the last pole.
    pub(super) fn set_pole(
        &mut self,
        state: &ReaderState,
        line: &SiemensBlock,
        code: u32,
    ) -> Result<(), ReadRemark> {
        let slots = self.plane_slots(state);
        if line.polar.iter().any(Option::is_some) {
            let message = "a pole in polar coordinates";
            return Err(ReadRemark::new(line.target.at, message, "write it by X and Y"));
        }
        for (axis, slot) in slots.into_iter().enumerate() {
            let from = match code {
                110 => state.control.reading(slot).ok_or_else(|| {
                    let message = "G110 at a place that the program does not state";
                    ReadRemark::new(line.target.at, message, "write G111")
                })?,
                112 => self.polar.pole[axis],
                _ => 0.0,
            };
            self.polar.pole[axis] = from + line.target.get(slot).unwrap_or(0.0);
        }
        // Radius and angle hold until the pole changes.
        (self.polar.radius, self.polar.angle) = (None, None);
        Ok(())
    }

    /// Makes axis words of `AP=` and `RP=`; an arc without centre turns about the pole.
    pub(super) fn polar_end(
        &mut self,
        state: &ReaderState,
        line: &mut SiemensBlock,
    ) -> Result<(), ReadRemark> {
        let at = line.target.at;
        let slots = self.plane_slots(state);
        if slots.iter().any(|slot| line.target.get(*slot).is_some()) {
            let message = "polar coordinates beside axis words of the plane";
            return Err(ReadRemark::new(at, message, "keep one of them"));
        }
        let [radius, angle] = line.polar;
        let end = |word: Option<CenterWord>, last: Option<f64>| match word {
            Some(CenterWord { value, mode: DistanceMode::Incremental }) => {
                last.map(|at| at + value)
            }
            Some(CenterWord { value, .. }) => Some(value),
            None => last,
        };
        self.polar.radius = end(radius, self.polar.radius);
        self.polar.angle = end(angle, self.polar.angle);
        let (Some(radius), Some(angle)) = (self.polar.radius, self.polar.angle) else {
            let message = "polar coordinates with AP or RP alone";
            return Err(ReadRemark::new(at, message, "write both behind the pole"));
        };
        let (sin, cos) = math::sin_cos(angle.to_radians());
        let [u, v] = self.polar.pole;
        let place = [u + radius * cos, v + radius * sin];
        for (slot, value) in slots.into_iter().zip(place) {
            line.target.set(slot, value, DistanceMode::Absolute);
        }
        let centered = line.center.iter().any(Option::is_some) || line.radius.is_some();
        if matches!(self.motion, Some(SiemensMotion::Arc(_))) && !centered {
            for (slot, value) in slots.into_iter().zip([u, v]) {
                let axis = state.control.xyz.iter().position(|known| *known == slot);
                if let Some(word) = axis.and_then(|axis| line.center.get_mut(axis)) {
                    *word = Some(CenterWord { value, mode: DistanceMode::Absolute });
                }
            }
        }
        Ok(())
    }
}
