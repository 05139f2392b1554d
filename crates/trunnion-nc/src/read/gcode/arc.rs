//! `G2`, `G3`: from I J K or R to centre and sweep.

use super::block::GcodeBlock;
use super::compensation::ProgrammedArc;
use super::reader::GcodeReader;
use super::words::natural;
use crate::read::arc;
use crate::read::arc::{ArcForm, ArcSense, GivenArc};
use crate::read::control::{INCH, MoveTarget};
use crate::read::dialect::Dialect;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;

/// Difference of the radii at both ends that `LinuxCNC` takes \[mm\]: 0.01 mm or 0.001 inch in each word of
/// the end and of the centre, along the diagonal.
const LINUXCNC_ROUNDED: f64 = 2.0 * 0.01 * std::f64::consts::SQRT_2;
const LINUXCNC_ROUNDED_INCH: f64 = 2.0 * 0.001 * std::f64::consts::SQRT_2 * INCH;

impl GcodeReader {
    /// Returns the axes of the active plane (G17, G18, G19) as indices of X Y Z, and the letters of its centre.
    pub(super) fn plane(&self) -> ([usize; 3], [char; 2]) {
        match self.modal.plane {
            // The order makes G3 run from the first axis to the second: Z to X under G18.
            1 => ([2, 0, 1], ['K', 'I']),
            2 => ([1, 2, 0], ['J', 'K']),
            _ => ([0, 1, 2], ['I', 'J']),
        }
    }

    pub(super) fn arc(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        target: MoveTarget,
        sense: ArcSense,
        feed: Option<f64>,
    ) -> Result<(), ReadRemark> {
        // Under G43.5, I J K are the tool axis, so a centre would be ambiguous.
        if self.modal.vector && block.has_any("IJK") {
            let message = "I J K of an arc, or the tool axis (G43.5)";
            return Err(ReadRemark::new(target.at, message, "write arcs with R"));
        }
        let (axes, letters) = self.plane();
        let [u, v, _] = axes.map(|axis| state.control.xyz[axis]);
        let scale = state.control.scale();
        // Both forms are taken from the block before they are judged, so that no word is left over.
        let radius = block.take('R');
        let center = letters.map(|letter| block.take(letter).map(|word| scale * word.value));
        let form = match (radius, center) {
            (Some(radius), [None, None]) => ArcForm::Radius(scale * radius.value),
            (None, [None, None]) => {
                let message = "arcs need their centre or radius";
                let help = format!("write {} and {} in this plane, or R", letters[0], letters[1]);
                return Err(ReadRemark::new(target.at, message, help));
            }
            (None, center) if self.is_compensating() && self.modal.arc_absolute => {
                ArcForm::Center(center.map(|value| value.unwrap_or(0.0)))
            }
            (None, center) => self.center(state, [u, v], center, target.at)?,
            (Some(radius), _) => {
                return Err(ReadRemark::new(
                    radius.at,
                    "centre and radius of an arc",
                    "keep one of them",
                ));
            }
        };
        // P counts turns (LinuxCNC): P1 or no P is an arc of one turn at most.
        let turns = block.take('P').map_or(Ok(1), |word| natural(word, 'P'))?;
        let rounded = match self.dialect {
            Dialect::LinuxCnc if state.control.inch => LINUXCNC_ROUNDED_INCH,
            Dialect::LinuxCnc => LINUXCNC_ROUNDED,
            _ => arc::ROUNDED,
        };
        if self.is_compensating() {
            let absolute = self.modal.arc_absolute;
            let programmed = ProgrammedArc { form, absolute, sense, turns, rounded };
            return self.contour_arc(state, target, &programmed, feed);
        }
        let given = GivenArc { plane: [u, v], form, sense, turns, rounded };
        let way = arc::way(&state.control, &target, &given)?;
        let pace = state.control.pace(&target, feed)?;
        state.control.go(state.log.line, target, pace, way)
    }

    /// Returns the centre relative to the start of the arc.
    fn center(
        &self,
        state: &ReaderState,
        slots: [usize; 2],
        center: [Option<f64>; 2],
        at: usize,
    ) -> Result<ArcForm, ReadRemark> {
        // G91.1: the centre is relative to the start, whatever G90 or G91 is active; a missing word is zero.
        if !self.modal.arc_absolute {
            return Ok(ArcForm::Center(center.map(|value| value.unwrap_or(0.0))));
        }
        // G90.1: the centre is a coordinate like any word, and needs the current position.
        let from_start = |slot: usize, value: Option<f64>| {
            let value = value.ok_or_else(|| {
                ReadRemark::new(at, "half of an absolute centre (G90.1)", "write both of its words")
            })?;
            let place = state.control.reading(slot).ok_or_else(|| arc::unknown_start(at))?;
            Ok::<f64, ReadRemark>(value - place)
        };
        let [u, v] = slots;
        Ok(ArcForm::Center([from_start(u, center[0])?, from_start(v, center[1])?]))
    }
}
