//! Distance of the curves of a tool path from the straight moves between their stations.

use crate::math::angle::{angle_between, great_circle};
use crate::types::{Motion, PieceGeometry, PoseCurve, ToolPath};

/// Distance of the curves from a polyline of tips and from great circles of tool axes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct ChordDeviation {
    /// Largest distance of the tip from the chord between neighbouring stations \[mm\].
    pub tip: f64,
    /// Largest distance of the contact point from its chord \[mm\].
    pub contact: f64,
    /// Largest angle of the tool axis from the great circle at the same share \[rad\].
    pub axis: f64,
}

impl ChordDeviation {
    fn worst(self, other: Self) -> Self {
        Self {
            tip: self.tip.max(other.tip),
            contact: self.contact.max(other.contact),
            axis: self.axis.max(other.axis),
        }
    }
}

/// Returns the deviation of the cutting curves of `path` from the chords, at `samples` points
/// inside each span.
///
/// The value is sampled, not bounded. It shows by how much a control that knows only the stations would deviate.
///
/// # Example
///
/// Stations 0.4 mm apart on a circle of 20 mm: the chords bow by 0.4^2 / (8 * 20) = 0.001 mm.
///
/// ```
/// use trunnion::toolpath::{ToolPathOptions, deviation, through};
/// use trunnion::types::{Leg, Motion, Silent, Station, ToolPose};
///
/// let at = |k: u32| {
///     let (sin, cos) = (0.02 * f64::from(k)).sin_cos();
///     let pose = ToolPose::new([20.0 * cos, 20.0 * sin, 0.0], [0.0, 0.0, 1.0]).unwrap();
///     Station { pose, contact: pose.tip }
/// };
/// let legs = [Leg { motion: Motion::Cut, stations: (0..=50).map(at).collect() }];
/// let path = through(&legs, &ToolPathOptions::with_lever(10.0), &Silent)?;
/// let bow = deviation(&path, 3).tip;
/// assert!((bow - 0.001).abs() < 1e-6);
/// # Ok::<(), trunnion::toolpath::ToolPathError>(())
/// ```
pub fn deviation(path: &ToolPath, samples: u32) -> ChordDeviation {
    path.pieces
        .iter()
        .filter(|piece| piece.motion == Motion::Cut)
        .filter_map(|piece| match &piece.geometry {
            PieceGeometry::Curve(curve) => Some(curve),
            PieceGeometry::Reorient { .. } => None,
        })
        .flat_map(|curve| (0..curve.spans.len()).map(move |span| of_span(curve, span, samples)))
        .fold(ChordDeviation::default(), ChordDeviation::worst)
}

fn of_span(curve: &PoseCurve, span: usize, samples: u32) -> ChordDeviation {
    let Some(&[start, end]) = curve.knots.get(span..span + 2).and_then(<[f64]>::first_chunk) else {
        return ChordDeviation::default();
    };
    let [from, to] = [start, end].map(|u| curve.rates_in(span, u));
    let mut worst = ChordDeviation::default();
    for sample in 1..=samples {
        let t = f64::from(sample) / f64::from(samples + 1);
        let here = curve.rates_in(span, start + t * (end - start));
        // Relative to the start of the span, so that coordinates far from 0 lose no digits.
        let off = |a: &nalgebra::Vector3<f64>, b: &nalgebra::Vector3<f64>, p| {
            from_chord(&(b - a), &(p - a))
        };
        let axis = match (from.pose(), to.pose(), here.pose()) {
            (Some(from), Some(to), Some(here)) => great_circle(&from.axis, &to.axis, t)
                .map_or(f64::INFINITY, |straight| angle_between(&straight, &here.axis)),
            _ => f64::INFINITY,
        };
        worst = worst.worst(ChordDeviation {
            tip: off(&from.tip[0], &to.tip[0], here.tip[0]),
            contact: off(&from.contact[0], &to.contact[0], here.contact[0]),
            axis,
        });
    }
    worst
}

/// Returns the distance of the point at `p` from the segment `0..chord`.
fn from_chord(chord: &nalgebra::Vector3<f64>, p: &nalgebra::Vector3<f64>) -> f64 {
    let square = chord.norm_squared();
    // Foot of the perpendicular, clamped to the segment; a segment without length is a point.
    let along = if square > 0.0 { (p.dot(chord) / square).clamp(0.0, 1.0) } else { 0.0 };
    (p - chord * along).norm()
}
