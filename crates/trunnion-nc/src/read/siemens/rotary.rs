//! Rotary words with a sense of rotation: `DC`, `ACP`, `ACN`.

use super::value::ValueMode;
use super::word::SiemensWord;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use std::f64::consts::TAU;

/// Returns the target of a rotary word with `DC`, `ACP` or `ACN`, unwound \[rad\].
pub(super) fn unwound(
    state: &mut ReaderState,
    slot: usize,
    meant: f64,
    mode: ValueMode,
    item: &SiemensWord<'_>,
) -> Result<f64, ReadRemark> {
    if !matches!(mode, ValueMode::Shortest | ValueMode::Positive | ValueMode::Negative) {
        return Ok(meant);
    }
    if !state.control.is_rotary(slot) {
        let help = "write AC(..)";
        return Err(ReadRemark::new(item.at, "DC, ACP and ACN are of rotary axes", help));
    }
    let Some(stands) = state.control.reading(slot) else {
        let message = "DC, ACP or ACN before the axis stands anywhere: taken as written";
        state.log.warn(item.line, ReadRemark::new(item.at, message, ""));
        return Ok(meant);
    };
    // The control's positive sense is the other one where the axis is reversed.
    let positive = mode == ValueMode::Positive;
    // Way in the positive sense of the axis, in [0, 2π).
    let up = (meant - stands).rem_euclid(TAU);
    let way = match mode {
        // DC: at most half a turn. ACP and ACN: in the given sense, and not at all if there
        // already.
        ValueMode::Shortest if up > 0.5 * TAU => up - TAU,
        ValueMode::Shortest => up,
        _ if positive != state.control.is_reversed(slot) => up,
        _ if up > 0.0 => up - TAU,
        _ => 0.0,
    };
    Ok(stands + way)
}
