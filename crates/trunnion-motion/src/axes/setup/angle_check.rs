//! Distance of a path from the singular directions, for many rotations of the workpiece.

use super::rotary_triangle::{AxisTrail, RotaryTriangle, RotationBall};
use crate::axes::options::RetractOptions;
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Machine};
use crate::math;
use crate::math::angle::angle_between;
use crate::types::{Interval, PieceGeometry, PoseCurve, ToolPath};
use nalgebra::{Rotation3, UnitVector3, Vector3};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Samples of one span at most, however its axis turns.
const MOST_SAMPLES: f64 = 1e3;

/// Reach of the machine by tool direction, independent of the setup.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AngleCheck {
    /// Direction of the workpiece-side rotary, machine frame.
    pub(super) first: Vector3<f64>,
    /// Angles from it that the travel of the tool-side rotary allows \[rad\].
    band: Interval,
    /// `true` if the tool can point along it, and against it.
    poles: [bool; 2],
    /// Rotary angles by tool direction.
    pub(super) turning: RotaryTriangle,
    /// `true` if segments must be run without a retract, so that the ends of travel of the rotaries decide
    /// which rotations fit.
    whole: bool,
}

/// A path as one rotation shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AngleResult {
    /// Least angle between tool axis and singular directions \[rad\].
    pub(super) least: f64,
    /// Tilt of the tool needed beyond the travel of the tool-side rotary \[rad\]; 0 if
    /// it need not.
    pub(super) missing_tilt: f64,
    /// Turn of a rotary needed beyond its travel along the path \[rad\]; 0 if it need not, or
    /// if that is not known.
    pub(super) missing_turn: f64,
}

impl AngleResult {
    /// Returns `true` if the rotaries stay inside travel, judged by angles.
    pub(super) fn fits(&self) -> bool {
        self.missing_tilt <= 0.0 && self.missing_turn <= 0.0
    }

    /// Returns `true` if this is the better for the machine: inside travel before all, then the larger angle.
    pub(super) fn before(&self, other: &Self) -> bool {
        let [own, others] = [self, other].map(|check| check.missing_tilt + check.missing_turn);
        own < others || (own <= others && self.least > other.least)
    }
}

/// Sampled tool axes of a path.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AxisSamples {
    /// Angle between neighbouring samples, about \[rad\].
    step: f64,
    /// Samples in no order; one of those nearer together than `step`.
    axes: Vec<Vector3<f64>>,
    /// Samples in the order of the path.
    trail: AxisTrail,
}

/// Samples of one path, coarse to fine.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SampleLevels(Vec<AxisSamples>);

impl SampleLevels {
    /// Samples a path with steps \[rad\] from `coarse` to `fine`, each a quarter of the one before.
    pub(super) fn new(path: &ToolPath, coarse: f64, fine: f64) -> Self {
        let mut samples = Vec::new();
        let mut step = coarse;
        while step > fine {
            samples.push(AxisSamples::new(path, step));
            step *= 0.25;
        }
        samples.push(AxisSamples::new(path, fine));
        Self(samples)
    }

    /// Returns samples fine enough to distinguish rotations that differ by `radius`.
    pub(super) fn within(&self, radius: f64) -> &AxisSamples {
        // Sampling errs by half a step: a quarter of the radius is little beside their difference.
        let fine = self.0.iter().find(|samples| samples.step <= 0.25 * radius);
        fine.unwrap_or_else(|| self.finest())
    }

    /// Returns the finest samples.
    pub(super) fn finest(&self) -> &AxisSamples {
        const NONE: &AxisSamples = &AxisSamples {
            step: 0.0,
            axes: Vec::new(),
            trail: AxisTrail { step: 0.0, segments: Vec::new() },
        };
        self.0.last().unwrap_or(NONE)
    }
}

impl AxisSamples {
    fn new(path: &ToolPath, step: f64) -> Self {
        Self { step, axes: axes(path, step), trail: trail(path, step) }
    }

    pub(super) fn trail(&self) -> &AxisTrail {
        &self.trail
    }
}

impl AngleCheck {
    /// Creates the check for a machine. Without a retract each segment must be inside travel as a whole.
    pub(super) fn new(inverse: &Inverse, retract: Option<&RetractOptions>) -> Self {
        let machine: &Machine = inverse.kinematics().machine();
        let first = machine.axes.get(FIRST_ROTARY).map_or(Vector3::z(), |axis| *axis.dir);
        let Interval { low, high } = inverse.reach();
        let turning = RotaryTriangle::new(inverse);
        let whole = retract.is_none() && turning.ends();
        Self { first, band: machine.tilt_range(), poles: [low <= 0.0, high >= PI], turning, whole }
    }

    /// Judges the path with the workpiece rotated by `machine_from_workpiece`. Angles are good to 1e-8 rad,
    /// which is the accuracy of an arc cosine next to 1.
    pub(super) fn check(&self, samples: &AxisSamples, rotation: &Rotation3<f64>) -> AngleResult {
        let check = self.check_angles(samples, rotation);
        AngleResult {
            missing_turn: self.missing_turn(samples, rotation, RotationBall::POINT),
            ..check
        }
    }

    /// Judges the path as [`Self::check`], but leaves out the rotary travel, which takes longer.
    pub(super) fn check_angles(
        &self,
        samples: &AxisSamples,
        rotation: &Rotation3<f64>,
    ) -> AngleResult {
        // Seen from the workpiece one direction is rotated instead of all tool axes. The cosine falls with
        // the angle, so its range gives the farthest and the nearest tool axis.
        let first = rotation.inverse() * self.first;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for axis in &samples.axes {
            let along = first.dot(axis);
            range = [range[0].min(along), range[1].max(along)];
        }
        let [farthest, nearest] = range.map(|along| math::acos(along.clamp(-1.0, 1.0)));
        // A direction parallel to the first rotary is singular only if the tool can point that way.
        let [up, down] = self.poles;
        let least = [(up, nearest), (down, PI - farthest)]
            .into_iter()
            .filter_map(|(reached, angle)| reached.then_some(angle));
        let Interval { low, high } = self.band;
        AngleResult {
            least: least.fold(PI, f64::min),
            missing_tilt: (low - nearest).max(farthest - high).max(0.0),
            missing_turn: 0.0,
        }
    }

    /// Returns the turn that rotaries need beyond their travel along the path, for every rotation of a
    /// ball \[rad\].
    pub(super) fn missing_turn(
        &self,
        samples: &AxisSamples,
        rotation: &Rotation3<f64>,
        ball: RotationBall,
    ) -> f64 {
        if self.whole { self.turning.beyond(&samples.trail, rotation, ball) } else { 0.0 }
    }
}

/// Samples the tool axes of all curves about `step` \[rad\] apart; of those nearer together one is kept.
fn axes(path: &ToolPath, step: f64) -> Vec<Vector3<f64>> {
    let mut taken = BTreeSet::new();
    let mut axes = Vec::new();
    for piece in &path.pieces {
        let PieceGeometry::Curve(curve) = &piece.geometry else { continue };
        for axis in samples(curve, step) {
            // One sample for each cube of a grid; + 0 turns -0 into 0, which has other bits.
            let cell = [axis.x, axis.y, axis.z].map(|part| ((part / step).round() + 0.0).to_bits());
            if taken.insert(cell) {
                axes.push(axis.into_inner());
            }
        }
    }
    axes
}

/// Samples the tool axes in the order of the path, cut at links.
fn trail(path: &ToolPath, step: f64) -> AxisTrail {
    let mut segments: Vec<Vec<Vector3<f64>>> = Vec::new();
    let mut open = false;
    for (index, piece) in path.pieces.iter().enumerate() {
        match &piece.geometry {
            PieceGeometry::Curve(curve) => {
                if !open {
                    segments.push(Vec::new());
                    open = true;
                }
                let Some(segment) = segments.last_mut() else { continue };
                for axis in samples(curve, step) {
                    let near = |last: &Vector3<f64>| last.cross(&axis).norm() < 0.5 * step;
                    if !segment.last().is_some_and(near) {
                        segment.push(axis.into_inner());
                    }
                }
            }
            PieceGeometry::Reorient { from, to } => {
                if !open {
                    segments.push(vec![from.axis.into_inner()]);
                }
                open = false;
                if index + 1 == path.pieces.len() {
                    segments.push(vec![to.axis.into_inner()]);
                }
            }
        }
    }
    AxisTrail { step, segments }
}

/// Samples the tool axis on each span of a curve, ends included.
fn samples(curve: &PoseCurve, step: f64) -> impl Iterator<Item = UnitVector3<f64>> + use<'_> {
    curve.knots.windows(2).enumerate().flat_map(move |(span, pair)| {
        let [from, to] = [pair[0], pair[1]];
        let axis = move |u: f64| curve.rates_in(span, u).pose().map(|pose| pose.axis);
        // The turn over both halves: an axis that returns to its start still counts.
        let turn = match (axis(from), axis(0.5 * (from + to)), axis(to)) {
            (Some(a), Some(b), Some(c)) => angle_between(&a, &b) + angle_between(&b, &c),
            _ => 0.0,
        };
        let count = (turn / step).ceil().clamp(1.0, MOST_SAMPLES);
        let mut index = 0.0;
        std::iter::from_fn(move || {
            let u = from + (to - from) * index / count;
            index += 1.0;
            (index <= count + 1.0).then(|| axis(u))
        })
        .flatten()
    })
}
