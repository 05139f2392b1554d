//! Smooth random axis paths with exact derivatives.

#![allow(dead_code, reason = "every test binary uses its part of this module")]

use nalgebra::SVector;
use num_dual::{Dual3_64, DualNum};
use proptest::prelude::*;
use trunnion::feed::{FeedOptions, Limits};
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion};

/// Nothing but the axes limits the speed.
pub(crate) const FREE: FeedOptions = FeedOptions { time_tolerance: 2e-3, ..FeedOptions::fastest() };

/// Limits of a machine that is quick for its jerk.
pub(crate) fn machine() -> Limits<5> {
    machine_in(1.0)
}

/// The same with lengths in another unit, so many of which make a millimetre.
pub(crate) fn machine_in(unit: f64) -> Limits<5> {
    let vector = |linear: f64, tilt, turn| {
        SVector::from([linear * unit, linear * unit, linear * unit, tilt, turn])
    };
    Limits {
        velocity: vector(500.0, 6.0, 10.0),
        rapid: vector(800.0, 6.0, 10.0),
        acceleration: vector(5000.0, 60.0, 100.0),
        jerk: Some(vector(1e5, 1200.0, 2000.0)),
        minus: None,
    }
}

/// A straight pass of 80 mm on a table that tilts and turns, whose tool axis comes within 1.5 degrees of the pole: C
/// whips nearly half round, and X and Y with it.
pub(crate) fn whip(rows: u32) -> AxisPath {
    let node = |k: u32| {
        let s = 80.0 * f64::from(k) / f64::from(rows - 1);
        let dual = Dual3_64::new(s, 1.0, 0.0, 0.0);
        let x = dual - 40.0;
        let [i, j] = [x / 40.0 * 15.0_f64.to_radians().sin(), 1.5_f64.to_radians().sin().into()];
        let tilt = (i * i + j * j).sqrt().asin();
        let turn = (i / j).atan();
        let across = x * turn.sin();
        let axes = [x * turn.cos(), across * tilt.cos(), across * tilt.sin(), tilt, turn];
        let q = [
            axes.map(|axis| axis.re),
            axes.map(|axis| axis.v1),
            axes.map(|axis| axis.v2),
            axes.map(|axis| axis.v3),
        ];
        AxisNode { s, q: q.map(SVector::from), tip_rate: 1.0, feed_rate: 1.0 }
    };
    let nodes = (0..rows).map(node).collect();
    AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] }
}

/// What an operator and a slow feeder do.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Event {
    /// Nodes are pushed.
    Push(usize),
    /// Stretches are taken.
    Take(usize),
    Override(f64),
}

/// Pushes and takes of up to so many.
pub(crate) fn any_event([push, take]: [usize; 2]) -> impl Strategy<Value = Event> {
    prop_oneof![
        3 => (1..push).prop_map(Event::Push),
        3 => (1..take).prop_map(Event::Take),
        1 => prop_oneof![Just(0.0), Just(1.0), Just(2.0), 0.05..2.0f64].prop_map(Event::Override),
    ]
}

/// Every axis: a slope and three sine waves over `s` in `[0, length]`.
#[derive(Debug, Clone)]
pub(crate) struct Waves {
    pub(crate) length: f64,
    /// Per axis: slope, then amplitude, waves per length and phase, three times.
    pub(crate) axes: [[f64; 10]; 5],
}

impl Waves {
    /// Axes and three derivatives.
    pub(crate) fn at(&self, s: f64) -> [SVector<f64, 5>; 4] {
        let mut q = [SVector::zeros(); 4];
        for (axis, numbers) in self.axes.iter().enumerate() {
            q[0][axis] += numbers[0] * s;
            q[1][axis] += numbers[0];
            for wave in numbers[1..].chunks(3) {
                let w = wave[1] * std::f64::consts::TAU / self.length;
                let (sin, cos) = (w * s + wave[2]).sin_cos();
                let values = [sin, cos * w, -sin * w * w, -cos * w * w * w];
                for (order, value) in values.into_iter().enumerate() {
                    q[order][axis] += wave[0] * value;
                }
            }
        }
        q
    }

    /// Even nodes, one piece; programmed point and tip as X, Y, Z would move alone.
    pub(crate) fn piece(&self, motion: Motion, intervals: u32) -> AxisPiece {
        let nodes = (0..=intervals).map(|k| {
            let s = self.length * f64::from(k) / f64::from(intervals);
            let q = self.at(s);
            let rate = q[1].fixed_rows::<3>(0).norm();
            AxisNode { s, q, tip_rate: rate, feed_rate: rate }
        });
        AxisPiece { motion, source: 0, nodes: nodes.collect() }
    }

    pub(crate) fn path(&self, intervals: u32) -> AxisPath {
        AxisPath { pieces: vec![self.piece(Motion::Cut, intervals)] }
    }
}

/// Paths of 20 to 100 mm, a few millimetres and tenths of a radian of waves.
pub(crate) fn any_waves() -> impl Strategy<Value = Waves> {
    let wave = || (-1.0..1.0f64, 0.3..4.0f64, 0.0..6.3f64);
    let axis = (-1.0..1.0f64, wave(), wave(), wave());
    (20.0..100.0f64, prop::collection::vec(axis, 5)).prop_map(|(length, axes)| {
        let mut waves = Waves { length, axes: [[0.0; 10]; 5] };
        for (index, (slope, a, b, c)) in axes.into_iter().enumerate() {
            let scale = if index < 3 { 3.0 } else { 0.1 };
            let slope = if index < 3 { slope } else { 0.01 * slope };
            waves.axes[index] =
                [slope, scale * a.0, a.1, a.2, scale * b.0, b.1, b.2, scale * c.0, c.1, c.2];
        }
        waves
    })
}
