//! How far a curve strays from the path it stands for, bounded by control points.

use super::Deviated;
use super::bezier::{Bezier, middle};
use crate::types::PoseCoordinates;
use nalgebra::Vector3;

/// What the axis of a path does between two stations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// Unit vector in the middle of the turn.
    middle: Vector3<f64>,
    /// Least and largest component of the path's axis vector along it, and largest across.
    along: [f64; 2],
    across: f64,
    /// Angle between the path's axis vector and the axis it stands for, at most \[rad\].
    shift: f64,
}

pub(super) fn axis(row: &PoseCoordinates) -> Vector3<f64> {
    Vector3::new(row[3], row[4], row[5])
}

pub(super) fn tip(row: &PoseCoordinates) -> Vector3<f64> {
    Vector3::new(row[0], row[1], row[2])
}

fn contact(row: &PoseCoordinates) -> Vector3<f64> {
    Vector3::new(row[6], row[7], row[8])
}

impl Frame {
    /// Of a chord between two unit axes that stands for the great circle at the same share.
    ///
    /// With half the angle between them `h`, the chord at the share `(1 + s) / 2` is turned by
    /// `atan(s tan h)` from its middle, the great circle by `s h`. The difference is largest where
    /// `s² = (tan h / h - 1) / tan² h`.
    pub(super) fn chord(from: &PoseCoordinates, to: &PoseCoordinates) -> Self {
        let [a, b] = [axis(from), axis(to)];
        let sum = a + b;
        let [cos, sin] = [0.5 * sum.norm(), 0.5 * (b - a).norm()];
        let tan = sin / cos;
        let half = tan.atan();
        // Below this, tan h / h - 1 is lost in rounding, and the shift, 0.13 h³, is below 1e-12.
        let shift = if half > 1e-4 {
            let s = ((tan / half - 1.0).max(0.0)).sqrt() / tan;
            ((s * tan).atan() - s * half).abs()
        } else {
            0.129 * half.powi(3)
        };
        Self { middle: sum / (2.0 * cos), along: [cos, cos], across: sin, shift }
    }

    /// Of a curve of axis vectors that is itself the path.
    pub(super) fn curve(path: &Bezier) -> Self {
        let sum = axis(&path[0]) + axis(&path[5]);
        let middle = sum / sum.norm();
        let mut frame =
            Self { middle, along: [f64::INFINITY, f64::NEG_INFINITY], across: 0.0, shift: 0.0 };
        for point in path {
            let axis = axis(point);
            let along = axis.dot(&middle);
            frame.along = [frame.along[0].min(along), frame.along[1].max(along)];
            frame.across = frame.across.max((axis - middle * along).norm());
        }
        frame
    }

    /// Angle to the path's axis where the axis vector differs by `across` and `along` the middle
    /// direction; infinite where the curve's axis could vanish.
    ///
    /// Central projection onto the plane that touches the sphere in the middle makes angles longer,
    /// never shorter: with the path's `B` and the curve's `B + D`,
    /// `(B·m)(B + D) - (B·m + D·m) B = (B·m) D⊥ - (D·m) B⊥`.
    fn angle(&self, across: f64, along: f64) -> f64 {
        let [least, most] = self.along;
        let room = least - along;
        if room <= 0.0 {
            return f64::INFINITY;
        }
        (most * across + along * self.across) / (least * room) + self.shift
    }
}

/// Deviation of `curve` from `path` over one interval, at equal parameters.
///
/// The bounds hold everywhere in between: the difference lies in the convex hull of its control points.
pub(super) fn deviation(curve: &Bezier, path: &Bezier, frame: &Frame) -> Deviated {
    let difference: Bezier = std::array::from_fn(|k| curve[k] - path[k]);
    let [mut place, mut touch, mut across, mut along] = [0.0_f64; 4];
    for d in &difference {
        place = place.max(tip(d).norm_squared());
        touch = touch.max(contact(d).norm_squared());
        let turn = axis(d);
        let lift = turn.dot(&frame.middle);
        along = along.max(lift.abs());
        across = across.max((turn - frame.middle * lift).norm_squared());
    }
    let half = middle(&difference);
    let off = [&difference[0], &half, &difference[5]].map(|d| {
        let turn = axis(d);
        let lift = turn.dot(&frame.middle);
        [tip(d).norm_squared(), (turn - frame.middle * lift).norm_squared()]
    });
    let seen = |part: usize| off.iter().map(|of| of[part]).fold(0.0, f64::max).sqrt();
    Deviated {
        tip: seen(0),
        tip_bound: place.sqrt(),
        axis: seen(1),
        axis_bound: frame.angle(across.sqrt(), along),
        contact_bound: touch.sqrt(),
    }
}
