//! Random numbers whose seed is printed and can be stated.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "the seed is what repeats a failure")]
#![allow(dead_code, reason = "every test binary uses its own part of this module")]

use nalgebra::{UnitVector3, Vector3};
use std::f64::consts::TAU;
use std::time::{SystemTime, UNIX_EPOCH};

type V3 = Vector3<f64>;

/// Whether the full count is asked for.
pub(crate) fn full() -> bool {
    std::env::var("TRUNNION_TORTURE").is_ok_and(|word| word != "0")
}

/// The seed: stated, or new for the full count, or always the same.
pub(crate) fn seed() -> u64 {
    let stated = std::env::var("TRUNNION_TORTURE_SEED").ok().map(|word| word.parse().unwrap());
    let clock = || SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs();
    let seed = stated.unwrap_or_else(|| if full() { clock() } else { 1 });
    println!("TRUNNION_TORTURE_SEED={seed}");
    seed
}

/// Steele, Lea and Flood's splitmix64.
#[derive(Debug)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In `[low, high)`.
    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    pub(crate) fn below(&mut self, count: u64) -> usize {
        usize::try_from(self.bits() % count).unwrap()
    }

    pub(crate) fn point(&mut self, size: f64) -> V3 {
        V3::from_fn(|_, _| self.within(-size, size))
    }

    pub(crate) fn direction(&mut self) -> UnitVector3<f64> {
        let (z, turn) = (self.within(-1.0, 1.0), self.within(0.0, TAU));
        let across = (1.0 - z * z).sqrt();
        UnitVector3::new_normalize(V3::new(across * turn.cos(), across * turn.sin(), z))
    }
}
