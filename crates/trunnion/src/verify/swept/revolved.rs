//! Solids of revolution as triangles around them.

use crate::math;
use crate::types::Mesh;
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use std::f64::consts::{PI, TAU};

/// Least and most sides of a prism for a cylinder: at a radius of a metre, 1e5 sides are 0.5 nm off.
const SIDES: [f64; 2] = [8.0, 1e5];

/// Returns triangles around a solid of revolution, larger by at most `tolerance` \[mm\] beside its axis: the axis from a
/// point on, and radii and heights over it, from the lower end to the upper one.
pub(crate) fn revolved(
    from: &Point3<f64>,
    along: &UnitVector3<f64>,
    profile: &[[f64; 2]],
    tolerance: f64,
) -> Mesh {
    let turn = math::quaternion_between(&Vector3::z_axis(), along);
    let place = Isometry3::from_parts(from.coords.into(), turn);
    let widest = profile.iter().map(|[radius, _]| *radius).fold(0.0, f64::max);
    // From the axis, half a side subtends the angle whose cosine is the radius over that of the corners.
    let half = math::acos(widest / (widest + tolerance));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let sides = (PI / half).ceil().clamp(SIDES[0], SIDES[1]) as u32;
    let larger = math::cos(PI / f64::from(sides)).recip();
    let ends = [profile.first(), profile.last()].map(|end| end.map_or(0.0, |[_, height]| *height));
    let mut vertices: Vec<Point3<f64>> = ends.map(|height| Point3::new(0.0, 0.0, height)).into();
    // Corner k of ring i is 2 + i sides + k.
    for [radius, height] in profile {
        for k in 0..sides {
            let (sin, cos) = math::sin_cos(TAU * f64::from(k) / f64::from(sides));
            vertices.push(Point3::new(radius * larger * cos, radius * larger * sin, *height));
        }
    }
    let mut triangles = Vec::new();
    let rings = u32::try_from(profile.len()).unwrap_or_default();
    for k in 0..sides {
        let corner = |ring: u32, k: u32| 2 + ring * sides + k % sides;
        triangles.push([0, corner(0, k + 1), corner(0, k)]);
        for ring in 1..rings {
            let [a, b] = [ring - 1, ring].map(|ring| [corner(ring, k), corner(ring, k + 1)]);
            triangles.extend([[a[0], a[1], b[1]], [a[0], b[1], b[0]]]);
        }
        triangles.push([1, corner(rings - 1, k), corner(rings - 1, k + 1)]);
    }
    Mesh { vertices: vertices.iter().map(|p| place * p).collect(), triangles }
}
