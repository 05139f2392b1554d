//! Cells that are faster than wanted, to be made as slow as the other limits allow.
//!
//! A lower feed cannot be had at once. Where the motion is above a wanted cap, that cap is left
//! out and the objective pulls down, until the motion is below it.

use super::speed_caps::SpeedCaps;
use super::speed_spline::SpeedSpline;

/// A cap that was left out comes in where the motion is this far below it: a barrier needs room.
const BELOW: f64 = 0.99;

/// Share of a cap to aim at, for the motion to come that far below.
const TARGET: f64 = 0.97;

/// Caps that are wanted, those that hold in any case, and the cells that are above the wanted ones.
#[derive(Debug)]
pub(super) struct SlowDown {
    pub(super) wanted: SpeedCaps,
    pub(super) most: SpeedCaps,
    pub(super) slow: Vec<bool>,
}

impl SlowDown {
    /// Returns the squared speed that a cell is to come down to, if it is to be slower.
    pub(super) fn target(&self, cell: usize) -> Option<f64> {
        let wanted = self.wanted.control[cell].min(self.wanted.row[cell + 1]);
        self.slow.get(cell).filter(|slow| **slow).map(|_| TARGET * wanted)
    }

    /// Takes caps that are not kept out of the way, and puts those that are into place; returns
    /// the cells that changed.
    pub(super) fn update(&mut self, caps: &mut SpeedCaps, spline: &SpeedSpline) -> Vec<usize> {
        let mut changed = Vec::new();
        for cell in spline.cells() {
            let [_, control, end] = spline.coefficients(cell);
            let set = |cap: &mut f64, [wanted, most]: [f64; 2], x: f64| {
                let before = *cap;
                *cap = if x <= BELOW * wanted || before <= wanted { wanted } else { most };
                // Kept already, or above it from the beginning.
                *cap = if x < *cap { *cap } else { most };
                before.to_bits() != cap.to_bits()
            };
            let row = cell + 1;
            let both = [self.wanted.control[cell], self.most.control[cell]];
            let one = set(&mut caps.control[cell], both, control);
            let both = [self.wanted.row[row], self.most.row[row]];
            let other = set(&mut caps.row[row], both, end);
            let above = |cap: f64, wanted: f64| cap > wanted;
            self.slow[cell] = above(caps.control[cell], self.wanted.control[cell])
                || above(caps.row[row], self.wanted.row[row]);
            if one || other {
                changed.push(cell);
            }
        }
        changed
    }
}
