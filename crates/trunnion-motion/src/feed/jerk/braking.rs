//! Steps of the solver that slow a motion down.

use super::newton::BarrierSolver;
use super::slow_down::SlowDown;
use super::speed_caps::SpeedCaps;

/// A sweep that lengthens the time by less is the last.
const SLOWS: f64 = 1.001;

impl<const N: usize> BarrierSolver<'_, N> {
    /// Keeps the caps `most`, and `wanted` as soon as that is possible.
    pub(super) fn brake_to(&mut self, wanted: SpeedCaps, most: SpeedCaps) {
        // Cells above the wanted caps keep the others until the motion has come down.
        let slow = vec![false; self.spline.len()];
        self.caps.given = most.given;
        let mut slower = SlowDown { wanted, most, slow };
        slower.update(&mut self.caps, &self.spline);
        self.slower = slower.slow.iter().any(|slow| *slow).then_some(slower);
    }

    /// Brings in the caps that are kept by now, and returns their number.
    pub(super) fn brake_on(&mut self, weight: f64) -> usize {
        let Some(mut slower) = self.slower.take() else { return 0 };
        let changed = slower.update(&mut self.caps, &self.spline);
        for cell in &changed {
            self.centre_caps(weight, *cell);
        }
        self.slower = Some(slower);
        changed.len()
    }

    /// Sweeps over the whole spline until no more caps come in and the time grows no more.
    pub(super) fn brake(&mut self, weight: f64, steps: usize, sweeps: usize) {
        let mut before = 0.0;
        for _ in 0..sweeps {
            if self.slower.is_none() {
                return;
            }
            let last = self.spline.len() - 1;
            self.sweep(weight, steps, [last; 2]);
            let time = self.spline.time();
            if self.brake_on(weight) == 0 && time < SLOWS * before {
                return;
            }
            before = time;
        }
    }
}
