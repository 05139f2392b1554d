//! A smooth piece of axis path, as blocks are made from it.

use super::bend::{AxisRates, PoseBend, arms};
use super::deviation::{ControlledPath, PathPoint, PosePath};
use crate::machine::Kinematics;
use crate::types::{AxisPiece, AxisVector, Block, SchedulePiece};

/// Least and largest number of samples inside a block; between them, one per node interval.
const SAMPLES: [usize; 2] = [7, 63];

/// Piece of a path, with bounds on its rates.
pub(super) struct SmoothPiece<'a> {
    kinematics: &'a Kinematics,
    pub(super) piece: &'a AxisPiece,
    /// Bounds on the rates, by interval between nodes.
    rates: Vec<AxisRates>,
}

impl<'a> SmoothPiece<'a> {
    pub(super) fn new(kinematics: &'a Kinematics, piece: &'a AxisPiece) -> Self {
        let intervals = 0..piece.nodes.len().saturating_sub(1);
        let rates = intervals
            .filter_map(|interval| piece.quintic(interval))
            .map(|(_, quintic)| AxisRates::of(&quintic))
            .collect();
        Self { kinematics, piece, rates }
    }
}

impl PosePath for SmoothPiece<'_> {
    fn at(&self, s: f64) -> PathPoint {
        let q = self.piece.position_at(s).unwrap_or_else(AxisVector::zeros);
        PathPoint { s, q, pose: self.kinematics.forward(&q) }
    }

    fn bend(&self, [from, to]: [&PathPoint; 2]) -> PoseBend {
        let [first, last] = [from.s, to.s].map(|s| self.piece.interval_at(s));
        let none = AxisRates { first: AxisVector::zeros(), second: AxisVector::zeros() };
        // Largest rates of all intervals that the stretch touches.
        let touched = self.rates.get(first..=last).unwrap_or_default();
        let rates = touched.iter().fold(none, |most, rates| most.worst(rates));
        let chain = self.kinematics.chain();
        let both = [from, to].map(|end| arms(chain, &end.q));
        let arms = [0, 1].map(|k: usize| both[0][k].max(both[1][k]));
        PoseBend::of(chain, &rates.scaled(to.s - from.s), arms)
    }

    fn inside(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        // Kinks can only lie at nodes, where quintics meet; between them a few samples find the
        // largest deviation early.
        let intervals = self.piece.interval_at(to) - self.piece.interval_at(from);
        let samples = intervals.clamp(SAMPLES[0], SAMPLES[1]);
        (1..=samples).map(|k| from + (to - from) * k as f64 / (samples + 1) as f64).collect()
    }
}

impl ControlledPath<'_, SmoothPiece<'_>> {
    /// Makes the blocks between ends in order of `s`, the first of which is where the piece starts.
    pub(super) fn blocks(&self, ends: &[f64], rows: &SchedulePiece) -> Vec<Block> {
        ends.windows(2)
            .map(|pair| {
                let point = self.at(pair[1]);
                let duration = rows.time_at(pair[1]) - rows.time_at(pair[0]);
                let motion = self.poses.piece.motion;
                Block { motion, q: point.q, pose: point.pose, duration }
            })
            .collect()
    }
}
