//! Random programs for any machine: wild moves, short blocks of a smooth curve, arcs and helices, tiny and zero moves.

use crate::observer::{Letters, letter_of, letters_of};
use crate::walk::Dice;
use std::f64::consts::TAU;
use trunnion::nalgebra::{Rotation3, Unit, Vector3};
use trunnion::types::AxisVector;
use trunnion_rt::MachineKinematics;
use trunnion_rt::planner::{
    BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart, MotionBlock,
};

/// Place of a machine, from which a program begins.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stand {
    pub(crate) coordinates: BlockCoordinates,
    pub(crate) length: f64,
    pub(crate) letters: Letters,
}

/// A program that is thrown.
pub(crate) struct Thrown<'a> {
    dice: &'a mut Dice,
    kinematics: &'a MachineKinematics,
    stand: Stand,
    tolerance: f64,
    speed: f64,
    blocks: Vec<MotionBlock>,
}

/// Joints in the middle of travel; of an axis without end at zero.
fn middle(kinematics: &MachineKinematics) -> AxisVector {
    kinematics.machine().vector(|axis| {
        let [low, high] = axis.limits.ends();
        if axis.cyclic || !(low.is_finite() && high.is_finite()) { 0.0 } else { 0.5 * (low + high) }
    })
}

/// Returns words of a stand's kinematics for joints.
fn words(kinematics: &MachineKinematics, stand: &Stand, joints: &AxisVector) -> Letters {
    let words = match stand.coordinates {
        BlockCoordinates::Axes => *joints,
        BlockCoordinates::Tip => kinematics.words(stand.length, joints),
    };
    letters_of(kinematics, &words)
}

/// Throws kind of kinematics and tool for a machine that rests at joints.
pub(crate) fn stand(dice: &mut Dice, kinematics: &MachineKinematics, joints: &AxisVector) -> Stand {
    let coordinates =
        [BlockCoordinates::Axes, BlockCoordinates::Tip][usize::from(dice.unit() < 0.7)];
    let length = if dice.unit() < 0.5 { 80.0 } else { dice.between(0.0, 150.0) };
    let stand = Stand { coordinates, length, letters: [0.0; 9] };
    Stand { letters: words(kinematics, &stand, joints), ..stand }
}

/// Throws a program from a stand.
pub(crate) fn program(
    dice: &mut Dice,
    kinematics: &MachineKinematics,
    stand: Stand,
) -> Vec<MotionBlock> {
    let tolerance = 10.0_f64.powf(dice.between(-2.5, -0.5));
    let speed = 10.0_f64.powf(dice.between(0.8, 2.6));
    let kind = dice.below(4);
    let blocks = Vec::new();
    let mut thrown = Thrown { dice, kinematics, stand, tolerance, speed, blocks };
    match kind {
        0 => thrown.wild(40),
        1 => thrown.short_blocks(),
        2 => thrown.arcs(24),
        _ => thrown.tiny(120),
    }
    thrown.modes();
    thrown.blocks
}

impl Thrown<'_> {
    fn at(&self) -> Letters {
        self.blocks.last().map_or(self.stand.letters, |block| block.end)
    }

    /// Appends a straight block.
    fn line_to(&mut self, end: Letters) {
        self.push(end, BlockShape::Line);
    }

    fn push(&mut self, end: Letters, shape: BlockShape) {
        self.blocks.push(MotionBlock {
            number: u32::try_from(self.blocks.len()).unwrap() + 1,
            start: self.at(),
            end,
            shape,
            kind: BlockKind::Feed,
            speed: self.speed,
            begins: BlockStart::Flow,
            ending: BlockEnding::Blend,
            tolerance: self.tolerance,
            coordinates: self.stand.coordinates,
            tool_length: self.stand.length,
        });
    }

    /// A step of so many mm at most, and of the rotaries in proportion, back towards the middle of travel now and then.
    fn step(&mut self, size: f64) -> Letters {
        let home = words(self.kinematics, &self.stand, &middle(self.kinematics));
        let mut at = self.at();
        for (letter, value) in at.iter_mut().enumerate().take(3) {
            *value += self.dice.between(-size, size) + 0.04 * (home[letter] - *value);
        }
        if self.dice.unit() < 0.6 {
            for axis in 3..5 {
                let letter = letter_of(self.kinematics, axis);
                at[letter] +=
                    0.02 * self.dice.between(-size, size) + 0.04 * (home[letter] - at[letter]);
            }
        }
        at
    }

    fn wild(&mut self, count: usize) {
        for _ in 0..count {
            let size = 10.0_f64.powf(self.dice.between(-2.0, 1.5));
            let end = self.step(size);
            self.line_to(end);
        }
    }

    /// A curve that all letters swing along, in blocks of one length.
    fn short_blocks(&mut self) {
        let step = 10.0_f64.powf(self.dice.between(-1.0, 0.3));
        let waves: Vec<[f64; 3]> = (0..9)
            .map(|letter| {
                let size = if (3..6).contains(&letter) { 0.08 } else { 4.0 };
                [
                    self.dice.between(0.0, size),
                    self.dice.between(0.02, 0.12),
                    self.dice.between(0.0, TAU),
                ]
            })
            .collect();
        let begin = self.at();
        let rounded = |value: f64| (value * 1e4).round() / 1e4;
        for index in 1..=300_u32 {
            let s = f64::from(index) * step;
            let mut end = begin;
            for letter in (0..5).map(|axis| letter_of(self.kinematics, axis)) {
                let [size, wave, phase] = waves[letter];
                let swing = size * ((wave * s + phase).sin() - phase.sin());
                // Four decimals, as programs have.
                end[letter] += if letter < 3 {
                    rounded(swing)
                } else {
                    rounded(swing.to_degrees()).to_radians()
                };
            }
            self.line_to(end);
        }
        self.speed = self.speed.max(20.0);
    }

    /// Arcs and helices about any axis, with lines between them, tangential or not.
    fn arcs(&mut self, count: usize) {
        for _ in 0..count {
            let size = 10.0_f64.powf(self.dice.between(-1.0, 1.2));
            if self.dice.unit() < 0.4 {
                let end = self.step(size);
                self.line_to(end);
                continue;
            }
            let axis = [Vector3::x(), Vector3::y(), Vector3::z()][self.dice.below(3)];
            let normal = if self.dice.unit() < 0.5 { axis } else { -axis };
            let along = Rotation3::from_axis_angle(
                &Unit::new_normalize(normal),
                self.dice.between(0.0, TAU),
            );
            let arm =
                along * Unit::new_normalize(normal.cross(&Vector3::new(0.3, 0.5, 0.8))).scale(size);
            let start = self.at();
            let center = Vector3::new(start[0], start[1], start[2]) - arm;
            let sweep = self.dice.between(0.05, TAU);
            let turned = Rotation3::from_axis_angle(&Unit::new_normalize(normal), sweep) * arm;
            let rise = if self.dice.unit() < 0.3 { self.dice.between(-size, size) } else { 0.0 };
            let to = center + turned + normal * rise;
            let mut end = start;
            end[..3].copy_from_slice(to.as_slice());
            let turns = i32::from(self.dice.unit() < 0.1);
            self.push(end, BlockShape::Arc { center: center.into(), normal: normal.into(), turns });
        }
    }

    /// Moves between nothing and a millimetre.
    fn tiny(&mut self, count: usize) {
        for _ in 0..count {
            let size = match self.dice.below(6) {
                0 => 0.0,
                1 => 1e-9,
                _ => 10.0_f64.powf(self.dice.between(-6.0, 0.0)),
            };
            let mut end = self.at();
            for value in end.iter_mut().take(3) {
                *value += self.dice.between(-size, size);
            }
            self.line_to(end);
        }
    }

    /// Throws kinds of blocks, and how they begin and end.
    fn modes(&mut self) {
        let mostly =
            [BlockEnding::Blend, BlockEnding::Blend, BlockEnding::Exact, BlockEnding::Stop]
                [self.dice.below(4)];
        let timed = self.dice.unit() < 0.25;
        for block in &mut self.blocks {
            block.ending = if self.dice.unit() < 0.95 { mostly } else { BlockEnding::Stop };
            block.kind = match self.dice.unit() {
                rapid if rapid < 0.06 => BlockKind::Rapid,
                _ if timed => BlockKind::Timed,
                _ => BlockKind::Feed,
            };
            block.speed = match block.kind {
                BlockKind::Rapid => 400.0,
                BlockKind::Timed => self.speed * self.dice.between(0.7, 1.4),
                BlockKind::Feed => self.speed,
            };
            block.begins = match self.dice.unit() {
                rest if rest < 0.01 => BlockStart::Rest,
                marked if marked < 0.05 => BlockStart::Marked,
                _ => BlockStart::Flow,
            };
        }
    }
}
