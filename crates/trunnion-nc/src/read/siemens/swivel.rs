//! `CYCLE800(1,"TC1",200000,57,0,0,0,0,30,0,0,0,0,-1,0,1)`: a tilted plane.

use super::codes;
use super::reader::SiemensReader;
use super::word::SiemensWord;
use crate::read::arithmetic;
use crate::read::arithmetic::FormulaText;
use crate::read::log::ReadRemark;
use crate::read::number::DecimalMark;
use crate::read::state::ReaderState;
use crate::read::tilt::{HeldPoint, about};
use nalgebra::{UnitQuaternion, Vector3};

/// Places of the arguments.
const RETRACT: usize = 0;
const RECORD: usize = 1;
const STATUS: usize = 2;
const MODE: usize = 3;
const BEFORE: usize = 4;
const ANGLES: usize = 7;
const BEHIND: usize = 10;
const DIRECTION: usize = 13;

impl SiemensReader {
    /// Begins or ends a tilted plane.
    pub(super) fn swivel(
        &self,
        state: &mut ReaderState,
        item: &SiemensWord<'_>,
    ) -> Result<(), ReadRemark> {
        let text = codes::arguments(item);
        let record = text.split(',').nth(RECORD).unwrap_or_default().trim();
        // CYCLE800() and the swivel record "0" deselect the plane.
        if text.is_empty() || record == "\"0\"" {
            state.control.untilt();
            return Ok(());
        }
        let refused = |message: &str, help: &str| Err(ReadRemark::new(item.at, message, help));
        let value = |place: usize| self.argument(text, place, item);
        let vector = |from: usize| {
            Ok::<_, ReadRemark>(Vector3::new(value(from)?, value(from + 1)?, value(from + 2)?))
        };
        let [status, mode] = [value(STATUS)?, value(MODE)?];
        // The ones of the status: 0 is a new plane, 1 one in addition to the active one.
        if status.rem_euclid(10.0) >= 1.0 {
            return refused("CYCLE800 on top of another", "write the whole plane in one call");
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        // Two bits each name the axes of the three turns; the upper two bits the kind of
        // swivelling.
        let mode = if (0.0..256.0).contains(&mode) { mode as u32 } else { 256 };
        if mode >= 64 {
            let message = "CYCLE800 other than by angles about axes";
            return refused(message, "swivel axis by axis (mode 57, 27 and the like)");
        }
        if state.control.word_map.is_some() {
            return refused("CYCLE800 in a turned frame (ROT, MIRROR, SCALE)", "end it before");
        }
        if state.control.linear_shift().norm() > 0.0 && state.control.tilted.is_none() {
            return refused("CYCLE800 in a shift (TRANS)", "end it before, or put it in the call");
        }
        let mut turn = UnitQuaternion::identity();
        for (place, shift) in [0, 2, 4].into_iter().enumerate() {
            let axis = match mode >> shift & 3 {
                1 => Vector3::x_axis(),
                2 => Vector3::y_axis(),
                3 => Vector3::z_axis(),
                _ => continue,
            };
            // Axis by axis: each turn is about an axis of the frame that the turns before have
            // made.
            turn *= about(axis, value(ANGLES + place)?.to_radians());
        }
        // The shift before the turn is in work coordinates, the one behind in those of the plane.
        let origin = vector(BEFORE)? + turn * vector(BEHIND)?;
        if value(RETRACT)? > 0.0 {
            let message = "the retract of CYCLE800 is left out";
            state.log.warn(item.line, ReadRemark::new(item.at, message, ""));
        }
        let line = state.log.line;
        state.control.tilt(line, origin, turn);
        if value(DIRECTION)?.abs() > 0.0 {
            // The tens of the status: the tip is tracked.
            let tracked = (status / 10.0).floor().rem_euclid(10.0) >= 1.0;
            let held = if tracked { HeldPoint::Tip } else { HeldPoint::LinearAxes };
            state.control.turn_to_plane(line, item.at, held)?;
        }
        Ok(())
    }

    /// Returns a number of a call; 0 where it is left out.
    fn argument(
        &self,
        text: &str,
        place: usize,
        item: &SiemensWord<'_>,
    ) -> Result<f64, ReadRemark> {
        let text = text.split(',').nth(place).unwrap_or_default().trim();
        if text.is_empty() {
            return Ok(0.0);
        }
        let written = FormulaText { text, from: 0, at: item.value_at, mark: DecimalMark::Point };
        arithmetic::value(&written, &self.variables)
    }
}
