//! Polar coordinates of `LinuxCNC`: `@` and `^` about the origin.

use super::block::PolarWords;
use super::reader::GcodeReader;
use crate::math;
use crate::read::control::{ControlState, DistanceMode, MoveTarget};
use crate::read::log::ReadRemark;

impl GcodeReader {
    /// Puts the end that `@` and `^` state into a target, as X and Y.
    pub(super) fn polar_end(
        &self,
        control: &ControlState,
        polar: &PolarWords,
        target: &mut MoveTarget,
    ) -> Result<(), ReadRemark> {
        let PolarWords { radius, angle } = *polar;
        let at = radius.or(angle).map_or(0, |word| word.at);
        let [x, y, _] = control.xyz;
        if target.get(x).is_some() || target.get(y).is_some() || target.machine {
            let message = "polar coordinates beside X, Y or G53";
            return Err(ReadRemark::new(at, message, "keep one of them"));
        }
        let scale = control.scale();
        let distance = radius.map(|word| scale * word.value);
        let turn = angle.map(|word| word.value.to_radians());
        let present = || {
            let help = "program X and Y absolutely before it";
            let message = "polar coordinates from a position that the program does not state";
            let stood = control.reading(x).zip(control.reading(y));
            stood.ok_or_else(|| ReadRemark::new(at, message, help))
        };
        let [distance, turn] = match (self.modal.distance, distance, turn) {
            (DistanceMode::Absolute, Some(distance), Some(turn)) => [distance, turn],
            (mode, distance, turn) => {
                let (stood_x, stood_y) = present()?;
                let [from, bearing] =
                    [math::hypot(stood_x, stood_y), math::atan2(stood_y, stood_x)];
                if from <= 0.0 && (mode == DistanceMode::Incremental || turn.is_none()) {
                    let message = "polar coordinates at the origin, where no angle is known";
                    return Err(ReadRemark::new(at, message, "write both @ and ^ under G90"));
                }
                match mode {
                    DistanceMode::Absolute => [distance.unwrap_or(from), turn.unwrap_or(bearing)],
                    DistanceMode::Incremental => {
                        [from + distance.unwrap_or(0.0), bearing + turn.unwrap_or(0.0)]
                    }
                }
            }
        };
        target.set(x, distance * math::cos(turn), DistanceMode::Absolute);
        target.set(y, distance * math::sin(turn), DistanceMode::Absolute);
        target.at = at;
        Ok(())
    }
}
