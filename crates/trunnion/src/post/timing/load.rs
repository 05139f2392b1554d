//! Load on the axes: their velocities and accelerations over the limits.

use super::block_motion::BlockMotion;
use crate::machine::Machine;
use crate::post::report::AxisLoadRatios;
use crate::types::AxisVector;

/// Largest ratio of axis velocities and accelerations to their limits.
///
/// Blocks count with their mean velocities; accelerations are the changes of these over the time between the middles
/// of two blocks. The machine rests before and after. What the rounding of words can have added does not count.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AxisLoad {
    velocity: AxisVector,
    acceleration: AxisVector,
    /// Mean motion of the block before.
    before: Option<BlockMotion>,
    /// Largest ratios of velocity and of acceleration; 1 is the limit.
    pub(crate) worst: AxisLoadRatios,
}

impl AxisLoad {
    /// Creates the load of a machine at rest.
    pub(crate) fn new(machine: &Machine) -> Self {
        Self {
            velocity: machine.vector(|axis| axis.vel),
            acceleration: machine.vector(|axis| axis.acc),
            before: None,
            worst: AxisLoadRatios::default(),
        }
    }

    /// Adds a block that moves the axes by `travel` in a time; its ends may be off by `error`.
    pub(crate) fn push(&mut self, travel: &AxisVector, error: &AxisVector, seconds: f64) {
        let seconds = if seconds > 0.0 { seconds } else { self.least(travel) };
        if seconds <= 0.0 {
            return;
        }
        let motion = BlockMotion::new(travel, error, seconds);
        self.worst.velocity = self.worst.velocity.max(motion.over(&self.velocity));
        let last = self.before.unwrap_or_else(BlockMotion::rest);
        self.worst.acceleration =
            self.worst.acceleration.max(last.to(&motion).over(&self.acceleration));
        self.before = Some(motion);
    }

    /// Adds a part of a block in which the axes reach the velocity `travel / seconds`.
    pub(crate) fn inside(&mut self, travel: &AxisVector, seconds: f64) {
        if seconds > 0.0 {
            let velocity = travel / seconds;
            self.worst.velocity =
                self.worst.velocity.max(velocity.component_div(&self.velocity).amax());
        }
    }

    /// Brings the axes to rest.
    pub(crate) fn rest(&mut self) {
        if let Some(motion) = self.before.take() {
            // From the middle of the last block to its end, where the axes stand.
            let change = motion.to(&BlockMotion::rest());
            self.worst.acceleration = self.worst.acceleration.max(change.over(&self.acceleration));
        }
    }

    /// Returns the least time for a travel by the velocities of the axes \[s\].
    pub(crate) fn least(&self, travel: &AxisVector) -> f64 {
        travel.component_div(&self.velocity).amax()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample_machine::ac_trunnion;

    #[test]
    fn two_blocks_of_one_axis_are_a_pencil_calculation() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        let [velocity, acceleration] = [machine.axes[0].vel, machine.axes[0].acc];
        let mut load = AxisLoad::new(&machine);
        // 1 mm in 0.1 s, then 3 mm in 0.1 s: 10 and 30 mm/s; 20 mm/s in 0.1 s, and 30 mm/s to rest in 0.05 s.
        for travel in [1.0, 3.0] {
            load.push(&AxisVector::from([travel, 0.0, 0.0, 0.0, 0.0]), &AxisVector::zeros(), 0.1);
        }
        load.rest();
        assert!((load.worst.velocity - 30.0 / velocity).abs() < 1e-12);
        assert!((load.worst.acceleration - 600.0 / acceleration).abs() < 1e-12);
    }
}
