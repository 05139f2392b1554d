//! Programmable frames: `TRANS`, `ROT`, `MIRROR`, `SCALE`, and those that add to them.

use super::line::{FrameEffect, FrameWord, ShiftMode};
use crate::read::control::{MoveTarget, SLOTS};
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::word_map::{WordMap, turn_about};
use nalgebra::{Matrix3, Vector3};

/// Runs a block with a frame; `plane` is 0 for G17, 1 for G18, 2 for G19.
pub(super) fn apply(
    state: &mut ReaderState,
    target: &MoveTarget,
    frame: &FrameWord,
    plane: usize,
) -> Result<(), ReadRemark> {
    let refused = |message: &str, help: &str| Err(ReadRemark::new(frame.at, message, help));
    if state.control.tilted.is_some() {
        let message = "a frame (TRANS, ROT ..) in a tilted plane";
        return refused(message, "put it in CYCLE800, or end the plane before: CYCLE800()");
    }
    let linear = linear_of(frame, plane)?;
    let control = &mut state.control;
    // TRANS, ROT and so on replace all frames, ATRANS and so on add to them.
    if frame.mode == ShiftMode::Replacing {
        control.local = [0.0; SLOTS];
        control.word_map = None;
    }
    if let (FrameEffect::Shift, Some(map)) = (frame.kind, control.word_map) {
        // Behind a turn a shift counts along the turned axes.
        let along = Vector3::from(control.xyz.map(|slot| target.get(slot).unwrap_or(0.0)));
        control.word_map = WordMap::new(map.linear, map.shift + map.linear * along);
    }
    for slot in 0..SLOTS {
        let turned = control.word_map.is_some() && control.xyz.contains(&slot);
        if let (Some(word), Some(local), false) =
            (target.get(slot), control.local.get_mut(slot), turned)
        {
            *local += word;
        }
    }
    if frame.kind != FrameEffect::Shift && linear != Matrix3::identity() {
        let before = control
            .word_map
            .map_or((Matrix3::identity(), Vector3::zeros()), |map| (map.linear, map.shift));
        // p_work = before(linear p): what is added last acts on the words first.
        let Some(map) = WordMap::new(before.0 * linear, before.1) else {
            return refused("a scale of zero", "write factors above 0");
        };
        control.word_map = Some(map);
    }
    Ok(())
}

/// Returns the matrix of a turn, mirror image or scale.
fn linear_of(frame: &FrameWord, plane: usize) -> Result<Matrix3<f64>, ReadRemark> {
    // The axis that the plane turns about: Z, Y, X.
    let normal = 2 - plane.min(2);
    match frame.kind {
        FrameEffect::Shift => Ok(Matrix3::identity()),
        FrameEffect::Turn => {
            let out = |axis: usize| axis != normal;
            let tilts = frame.values.iter().enumerate();
            let mut tilts = tilts.filter(|(axis, value)| out(*axis) && value.is_some());
            if tilts.any(|(_, value)| value.is_some_and(|angle| angle.abs() > 0.0)) {
                let message = "a turn (ROT) out of the active plane";
                let help = "swivel with CYCLE800, which turns the tool as well";
                return Err(ReadRemark::new(frame.at, message, help));
            }
            let angle = frame.in_plane.or(frame.values[normal]).unwrap_or(0.0);
            Ok(turn_about(normal, angle.to_radians()))
        }
        FrameEffect::Mirror => {
            // The values behind the letters have no meaning.
            let sign = frame.values.map(|value| if value.is_some() { -1.0 } else { 1.0 });
            Ok(Matrix3::from_diagonal(&Vector3::from(sign)))
        }
        FrameEffect::Scale => {
            let factors = frame.values.map(|value| value.unwrap_or(1.0));
            if factors.iter().any(|factor| *factor <= 0.0) {
                let message = "a scale that is not above 0";
                return Err(ReadRemark::new(frame.at, message, "MIRROR makes mirror images"));
            }
            Ok(Matrix3::from_diagonal(&Vector3::from(factors)))
        }
    }
}
