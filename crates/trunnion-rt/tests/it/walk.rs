//! Random joints and paths inside the travel of a machine.

use std::f64::consts::TAU;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Axis, Machine};
use trunnion::types::AxisVector;

/// Every machine that comes with the library.
pub(crate) fn machines() -> Vec<Machine> {
    BUILT_IN.iter().map(|(_, text)| parse(text).unwrap().machine).collect()
}

/// Reproducible numbers.
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(2) | 1)
    }

    /// Any 64 bits, by xorshift.
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// A number between 0 and 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A whole number below `count`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        usize::try_from((self.bits() >> 11) % count as u64).unwrap()
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Joints inside travel; an axis without end within three turns.
    pub(crate) fn joints(&mut self, machine: &Machine) -> AxisVector {
        let one = |axis: &Axis| {
            if axis.cyclic { [-3.0 * TAU, 3.0 * TAU] } else { axis.limits.ends() }
        };
        let ends: Vec<[f64; 2]> = machine.axes.iter().map(one).collect();
        AxisVector::from_fn(|row, _| self.between(ends[row][0], ends[row][1]))
    }
}
