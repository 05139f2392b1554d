//! Tapping outside of `G17` as `LinuxCNC` runs it: its interpreter feeds along other axes than it should.

use super::cycle::DrilledHole;
use super::reader::GcodeReader;
use crate::read::control::{DistanceMode, MoveTarget};
use crate::read::dialect::Dialect;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::step::Way;

/// Axes among which the interpreter exchanges the coordinates of a hole.
pub(super) struct SwappedAxes {
    /// Slots that receive the height and both coordinates of the hole.
    receives: [usize; 3],
    /// Coordinates of the hole \[mm\].
    hole: [f64; 2],
    /// Slots of these coordinates.
    slots: [usize; 2],
}

impl GcodeReader {
    /// Returns the exchange of axes of a tapping cycle, which is warned of; `None` where there is none.
    pub(super) fn swapped_axes(
        &self,
        state: &mut ReaderState,
        hole: &DrilledHole,
    ) -> Option<SwappedAxes> {
        let plane = self.modal.plane;
        if self.dialect != Dialect::LinuxCnc || !matches!(hole.code, 740 | 840) || plane == 0 {
            return None;
        }
        let message = format!(
            "G{} in G18 or G19: the interpreter of LinuxCNC 2.9 feeds along another axis than the drill axis; it is read as \
             it runs",
            hole.code / 10
        );
        let help = "use G33.1, or write the moves";
        state.log.warn("", ReadRemark::new(hole.at, message, help));
        // Height, and the coordinates that follow the drill axis: G18 has Y, Z, X, G19 has X, Y, Z. It feeds X, Y, Z in
        // G18, and Y, Z, X in G19.
        let [x, y, z] = state.control.xyz;
        let (slots, receives) = if plane == 1 { ([z, x], [x, y, z]) } else { ([y, z], [y, z, x]) };
        let [Some(u), Some(v)] = slots.map(|slot| state.control.reading(slot)) else { return None };
        Some(SwappedAxes { receives, hole: [u, v], slots })
    }
}

impl SwappedAxes {
    /// Feeds to a height of the drill axis.
    pub(super) fn feed(
        &self,
        state: &mut ReaderState,
        hole: &DrilledHole,
        height: f64,
    ) -> Result<(), ReadRemark> {
        let mut target = MoveTarget::new(hole.at, hole.column);
        let [u, v] = self.hole;
        for (slot, value) in self.receives.into_iter().zip([height, u, v]) {
            target.set(slot, value, DistanceMode::Absolute);
        }
        state.control.go(hole.line, target, hole.feed, Way::Line)
    }

    /// Takes the axes to be where the cycle should have led, which the next move states.
    pub(super) fn end(&self, state: &mut ReaderState, hole: &DrilledHole) {
        let ([a, b], [u, v]) = (self.slots, self.hole);
        state.control.restate([hole.axis, a, b], [hole.clear, u, v]);
    }
}
