//! How near a path comes to the singular directions, for many rotations of the workpiece.

use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Machine};
use crate::math::angle::angle_between;
use crate::types::{Geometry, PoseCurve, ToolPath};
use nalgebra::{Rotation3, UnitVector3, Vector3};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Samples of one span at most, however its axis turns.
const MOST_SAMPLES: f64 = 1e3;

/// What the machine can do with a tool direction, whatever the setup.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sight {
    /// Direction of the workpiece-side rotary, machine frame.
    first: Vector3<f64>,
    /// Angles from it that the travel of the tool-side rotary allows \[rad\].
    band: [f64; 2],
    /// Whether the tool can stand along it, and against it.
    poles: [bool; 2],
}

/// A path as one rotation shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    /// Least angle between tool axis and singular directions \[rad\].
    pub(super) least: f64,
    /// How far the tool would have to lean beyond the travel of the tool-side rotary \[rad\]; 0 if
    /// it need not.
    pub(super) beyond: f64,
}

impl Seen {
    /// The better for the machine: inside travel before all, then the larger angle.
    pub(super) fn before(&self, other: &Self) -> bool {
        self.beyond < other.beyond || (self.beyond <= other.beyond && self.least > other.least)
    }
}

impl Sight {
    pub(super) fn new(inverse: &Inverse) -> Self {
        let machine: &Machine = inverse.kinematics().machine();
        let first = machine.axes.get(FIRST_ROTARY).map_or(Vector3::z(), |axis| *axis.dir);
        let [low, high] = inverse.reach();
        Self { first, band: machine.lean_inside(), poles: [low <= 0.0, high >= PI] }
    }

    /// A path with these tool axes, the workpiece rotated by `machine_from_workpiece`. The angles are
    /// good to 1e-8 rad, what an arc cosine keeps next to 1.
    pub(super) fn look(&self, axes: &[Vector3<f64>], rotation: &Rotation3<f64>) -> Seen {
        let first = rotation.inverse() * self.first;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for axis in axes {
            let along = first.dot(axis);
            range = [range[0].min(along), range[1].max(along)];
        }
        let [farthest, nearest] = range.map(|along| along.clamp(-1.0, 1.0).acos());
        let [up, down] = self.poles;
        let least = [(up, nearest), (down, PI - farthest)]
            .into_iter()
            .filter_map(|(reached, angle)| reached.then_some(angle));
        let [low, high] = self.band;
        Seen {
            least: least.fold(PI, f64::min),
            beyond: (low - nearest).max(farthest - high).max(0.0),
        }
    }
}

/// Tool axes of all curves, neighbours about `step` \[rad\] apart, one of those nearer together.
pub(super) fn axes(path: &ToolPath, step: f64) -> Vec<Vector3<f64>> {
    let mut seen = BTreeSet::new();
    let mut axes = Vec::new();
    for piece in &path.pieces {
        let Geometry::Curve(curve) = &piece.geometry else { continue };
        for axis in samples(curve, step) {
            // + 0 turns -0 into 0.
            let cell = [axis.x, axis.y, axis.z].map(|part| ((part / step).round() + 0.0).to_bits());
            if seen.insert(cell) {
                axes.push(axis.into_inner());
            }
        }
    }
    axes
}

fn samples(curve: &PoseCurve, step: f64) -> impl Iterator<Item = UnitVector3<f64>> + use<'_> {
    curve.knots.windows(2).enumerate().flat_map(move |(span, pair)| {
        let [from, to] = [pair[0], pair[1]];
        let axis = move |u: f64| curve.rates_in(span, u).pose().map(|pose| pose.axis);
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
