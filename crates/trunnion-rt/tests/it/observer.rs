//! Judge of a motion, cycle by cycle: rates of the joints by differences, and the distance of the tip from the program.
//!
//! It knows the machine, the program and the positions of the servo cycles, and nothing of the planner.

use std::f64::consts::TAU;
use trunnion::nalgebra::{Point3, Vector3};
use trunnion::types::AxisVector;
use trunnion_rt::MachineKinematics;
use trunnion_rt::planner::{BlockCoordinates, BlockShape, MotionBlock, ServoSample};

/// Position of all letters.
pub(crate) type Letters = [f64; 9];

/// Blocks on either side of the last one that may be the nearest.
const NEAR: usize = 70;

/// Steps by which the range that has the nearest place of a block gets smaller.
const HALVINGS: u32 = 40;

/// Largest findings over a motion.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Findings {
    /// Cycles that were judged.
    pub(crate) cycles: u64,
    /// Cycles in which something moved.
    pub(crate) moving: u64,
    /// Velocity, acceleration and jerk of a joint over their limits.
    pub(crate) rates: [f64; 3],
    /// Distance of the tip from the program over the tolerance.
    pub(crate) contour: f64,
}

impl Findings {
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            cycles: self.cycles + other.cycles,
            moving: self.moving + other.moving,
            rates: std::array::from_fn(|order| self.rates[order].max(other.rates[order])),
            contour: self.contour.max(other.contour),
        }
    }
}

/// Watches one machine.
pub(crate) struct Observer {
    kinematics: MachineKinematics,
    limits: [AxisVector; 3],
    period: f64,
    /// Joints of the last three cycles, the latest first, and how many of them there are.
    before: [AxisVector; 3],
    known: usize,
    program: Vec<MotionBlock>,
    /// Index of the block that runs.
    block: usize,
    pub(crate) findings: Findings,
}

/// Returns the words of the axes of a machine among all letters.
pub(crate) fn words_of(kinematics: &MachineKinematics, letters: &Letters) -> AxisVector {
    AxisVector::from_fn(|axis, _| letters[letter_of(kinematics, axis)])
}

/// Returns all letters with words for the axes of a machine.
pub(crate) fn letters_of(kinematics: &MachineKinematics, words: &AxisVector) -> Letters {
    let mut letters = [0.0; 9];
    words.iter().enumerate().for_each(|(axis, word)| letters[letter_of(kinematics, axis)] = *word);
    letters
}

pub(crate) fn letter_of(kinematics: &MachineKinematics, axis: usize) -> usize {
    let axis = &kinematics.machine().axes[axis];
    let letter = axis.output.letter.as_deref().unwrap_or(&axis.name);
    "XYZABCUVW".find(letter).unwrap()
}

impl Observer {
    pub(crate) fn new(kinematics: &MachineKinematics, period: f64) -> Self {
        let machine = kinematics.machine();
        let limits = [
            machine.vector(|axis| axis.vel),
            machine.vector(|axis| axis.acc),
            machine.vector(|axis| axis.jerk),
        ];
        Self {
            kinematics: kinematics.clone(),
            limits,
            period,
            before: [AxisVector::zeros(); 3],
            known: 0,
            program: Vec::new(),
            block: 0,
            findings: Findings::default(),
        }
    }

    /// Begins another program where the machine rests.
    pub(crate) fn begin(&mut self, program: &[MotionBlock]) {
        (self.program, self.block) = (program.to_vec(), 0);
    }

    /// Returns the joints for letters of the program.
    pub(crate) fn joints(&self, letters: &Letters) -> AxisVector {
        let words = words_of(&self.kinematics, letters);
        let block = &self.program[0];
        match block.coordinates {
            BlockCoordinates::Axes => words,
            BlockCoordinates::Tip => {
                self.kinematics.joints(block.tool_length, &words).unwrap().joints
            }
        }
    }

    /// Judges a cycle.
    pub(crate) fn watch(&mut self, sample: &ServoSample) {
        let letters = &sample.position;
        if !sample.rests {
            self.block = sample.block as usize - 1;
        }
        let joints = self.joints(letters);
        let [b, c, d] = self.before;
        let t = self.period;
        let rates = [
            (joints - b) / t,
            (joints - b * 2.0 + c) / (t * t),
            (joints - b * 3.0 + c * 3.0 - d) / (t * t * t),
        ];
        let known = rates.iter().zip(&self.limits).zip(&mut self.findings.rates).take(self.known);
        for ((rate, limit), worst) in known {
            *worst = worst.max(rate.component_div(limit).amax());
        }
        self.findings.cycles += 1;
        self.findings.moving += u64::from(self.known > 0 && (joints - b).amax() > 0.0);
        self.before = [joints, b, c];
        self.known = (self.known + 1).min(3);
        self.findings.contour = self.findings.contour.max(self.share(letters));
    }

    /// Returns the distance of the tip from the nearest block about the one that runs, over the tolerance.
    fn share(&self, letters: &Letters) -> f64 {
        let from = self.block.saturating_sub(NEAR);
        let to = (self.block + NEAR + 1).min(self.program.len());
        let legs = &self.program[from..to];
        let share = |leg: &MotionBlock| self.miss(leg, letters) / leg.tolerance;
        legs.iter().map(share).fold(f64::INFINITY, f64::min)
    }

    /// Returns the distance of the tip from a block.
    fn miss(&self, block: &MotionBlock, letters: &Letters) -> f64 {
        match (block.shape, block.coordinates) {
            (BlockShape::Arc { center, normal, turns }, _) => {
                miss_arc(block, center.into(), normal.into(), turns, letters)
            }
            (BlockShape::Line, BlockCoordinates::Tip) => miss_line(block, letters),
            (BlockShape::Line, BlockCoordinates::Axes) => self.miss_swept(block, letters),
        }
    }

    /// Returns the distance of the tip from the curve that it runs on while all axes move in proportion.
    fn miss_swept(&self, block: &MotionBlock, letters: &Letters) -> f64 {
        let straight = miss_line(block, letters);
        let turns = (3..6).any(|letter| (block.start[letter] - block.end[letter]).abs() > 0.0);
        // A tip that is far off by the linear axes alone is not near to this block.
        if !turns || straight > 4.0 * block.tolerance {
            return straight;
        }
        let tip = |letters: &Letters| {
            self.kinematics.pose(block.tool_length, &words_of(&self.kinematics, letters)).tip
        };
        let here = tip(letters);
        smallest([0.0, 1.0], |u| (tip(&between(block, u)) - here).norm())
    }
}

fn between(block: &MotionBlock, u: f64) -> Letters {
    std::array::from_fn(|letter| {
        block.start[letter] + u * (block.end[letter] - block.start[letter])
    })
}

fn tip(letters: &Letters) -> Point3<f64> {
    Point3::new(letters[0], letters[1], letters[2])
}

/// Returns the distance from a straight block in X, Y and Z.
fn miss_line(block: &MotionBlock, letters: &Letters) -> f64 {
    let [from, to, at] = [tip(&block.start), tip(&block.end), tip(letters)];
    let along = to - from;
    let square = along.norm_squared();
    let u = if square > 0.0 { ((at - from).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (at - from - along * u).norm()
}

/// Returns the distance from a circle or helix.
fn miss_arc(
    block: &MotionBlock,
    center: Point3<f64>,
    normal: Vector3<f64>,
    turns: i32,
    letters: &Letters,
) -> f64 {
    let axis = normal.normalize();
    let arm = |at: Point3<f64>| {
        let arm = at - center;
        (arm - axis * arm.dot(&axis), arm.dot(&axis))
    };
    let [(first, low), (last, high), (here, height)] =
        [tip(&block.start), tip(&block.end), tip(letters)].map(arm);
    let angle = |of: &Vector3<f64>| {
        let angle = axis.dot(&first.cross(of)).atan2(first.dot(of));
        let angle = if turns >= 0 { angle } else { -angle };
        angle.rem_euclid(TAU)
    };
    let full = |angle: f64| if angle < 1e-9 { TAU } else { angle };
    let rounds = f64::from(if turns >= 0 { turns } else { -1 - turns });
    let whole = full(angle(&last)) + TAU * rounds;
    // A point of the curve at a share of its angle, by its radius, its angle from the point and its height.
    let here_angle = angle(&here);
    let miss = |u: f64| {
        let radius = first.norm() + u * (last.norm() - first.norm());
        let chord = here.norm().powi(2) + radius * radius
            - 2.0 * here.norm() * radius * (u * whole - here_angle).cos();
        chord.max(0.0).sqrt().hypot(height - low - u * (high - low))
    };
    // On every turn the nearest point is at that angle or, of a steep helix, between there and that height.
    let mut nearest = miss(0.0).min(miss(1.0));
    let at_height = Some((height - low) / (high - low)).filter(|u| u.is_finite());
    let mut at = here_angle / whole;
    while at <= 1.0 + TAU / whole {
        let other = at_height.filter(|u| (u - at).abs() * whole < 0.5 * TAU).unwrap_or(at);
        let range = [at.min(other), at.max(other)].map(|u| u.clamp(0.0, 1.0));
        nearest = nearest.min(smallest(range, miss));
        at += TAU / whole;
    }
    nearest
}

/// Returns the smallest value in a range in which there is one valley.
fn smallest([mut low, mut high]: [f64; 2], of: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..HALVINGS {
        let [one, other] = [low + (high - low) * 0.45, low + (high - low) * 0.55];
        if of(one) < of(other) { high = other } else { low = one }
    }
    of(0.5 * (low + high))
}
