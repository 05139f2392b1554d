//! Control nets of swept surfaces, to be recognised as elementary ones: a wavy line that is swept in its own plane is a
//! plane.

use crate::import::step::curve::{Spline, StepCurve};
use crate::import::step::model::StepFrame;
use crate::import::step::shape::StepShape;
use crate::import::step::topology::FaceBoundary;
use crate::surface::NurbsSurface;
use nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::FRAC_1_SQRT_2;

/// Builds the control net of a swept spline: an extrusion as far as the boundaries reach, a revolution all round; `None`
/// for other surfaces.
pub(in crate::import::step) fn swept_net(
    shape: &StepShape,
    boundaries: &[FaceBoundary],
) -> Option<NurbsSurface> {
    match shape {
        StepShape::Extrusion { curve: StepCurve::Spline(profile), direction } => {
            extruded(profile, UnitVector3::try_new(*direction, f64::MIN_POSITIVE)?, boundaries)
        }
        StepShape::Revolution { curve: StepCurve::Spline(profile), axis } => {
            revolved(profile, axis)
        }
        _ => None,
    }
}

/// Returns the control points of a spline, with their weights.
fn control_points(profile: &Spline) -> impl Iterator<Item = (Point3<f64>, f64)> {
    profile.points.iter().map(|h| (Point3::from(h.xyz() / h.w), h.w))
}

fn extruded(
    profile: &Spline,
    direction: UnitVector3<f64>,
    boundaries: &[FaceBoundary],
) -> Option<NurbsSurface> {
    let height = |p: &Point3<f64>| p.coords.dot(&direction);
    let ends = || boundaries.iter().flat_map(|b| &b.edges).flat_map(|edge| &edge.ends).map(height);
    let profile_heights = || control_points(profile).map(|(p, _)| height(&p));
    // Every control point is moved so far that the net reaches beyond all vertices.
    let low = ends().fold(f64::INFINITY, f64::min) - profile_heights().fold(f64::MIN, f64::max);
    let high =
        ends().fold(f64::NEG_INFINITY, f64::max) - profile_heights().fold(f64::MAX, f64::min);
    let moved = |(p, w): (Point3<f64>, f64)| {
        ([low, high].map(|by| p + direction.scale(by)).to_vec(), vec![w; 2])
    };
    let (points, weights) = control_points(profile).map(moved).unzip();
    let knots = [profile.knots.knots().to_vec(), vec![0.0, 0.0, 1.0, 1.0]];
    NurbsSurface::new([profile.knots.degree(), 1], knots, points, Some(weights)).ok()
}

fn revolved(profile: &Spline, axis: &StepFrame) -> Option<NurbsSurface> {
    // A circle as four rational quadratic quarters: corners of the square around it have the weight cos(45 deg).
    const CIRCLE: [[f64; 3]; 9] = [
        [1.0, 0.0, 1.0],
        [1.0, 1.0, FRAC_1_SQRT_2],
        [0.0, 1.0, 1.0],
        [-1.0, 1.0, FRAC_1_SQRT_2],
        [-1.0, 0.0, 1.0],
        [-1.0, -1.0, FRAC_1_SQRT_2],
        [0.0, -1.0, 1.0],
        [1.0, -1.0, FRAC_1_SQRT_2],
        [1.0, 0.0, 1.0],
    ];
    let turned = |[x, y, share]: [f64; 3]| -> (Vec<Point3<f64>>, Vec<f64>) {
        let of = |(p, w): (Point3<f64>, f64)| {
            let from = p - axis.origin;
            let along: Vector3<f64> = axis.z.scale(axis.z.dot(&from));
            let out = from - along;
            (axis.origin + along + out.scale(x) + axis.z.cross(&out).scale(y), w * share)
        };
        control_points(profile).map(of).unzip()
    };
    let (points, weights) = CIRCLE.into_iter().map(turned).unzip();
    let quarters = [0.0, 0.0, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1.0, 1.0, 1.0].to_vec();
    let knots = [quarters, profile.knots.knots().to_vec()];
    NurbsSurface::new([2, profile.knots.degree()], knots, points, Some(weights)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::step::known::known;
    use crate::import::step::topology::LoopEdge;
    use crate::math::bspline::KnotVector;
    use nalgebra::Vector4;

    fn spline(points: &[[f64; 4]]) -> Spline {
        let n = points.len();
        let degree = 2;
        let inner = (1..n - degree).map(|k| k as f64 / (n - degree) as f64);
        let knots = std::iter::repeat_n(0.0, degree + 1)
            .chain(inner)
            .chain(std::iter::repeat_n(1.0, degree + 1))
            .collect();
        let points = points.iter().map(|[x, y, z, w]| Vector4::new(x * w, y * w, z * w, *w));
        Spline { knots: KnotVector::new(degree, n, knots).unwrap(), points: points.collect() }
    }

    /// A boundary with vertices at these heights along y and z.
    fn boundary(heights: [f64; 2]) -> FaceBoundary {
        let ends = heights.map(|z| Point3::new(3.0, z, z));
        let curve = StepCurve::Line { origin: ends[0], direction: ends[1] - ends[0] };
        FaceBoundary { id: 1, edges: vec![LoopEdge { id: 2, curve, range: [0.0, 1.0], ends }] }
    }

    fn extrusion(points: &[[f64; 4]], direction: Vector3<f64>) -> StepShape {
        StepShape::Extrusion { curve: StepCurve::Spline(spline(points)), direction }
    }

    fn kind(shape: &StepShape, heights: [f64; 2]) -> Option<&'static str> {
        let net = swept_net(shape, &[boundary(heights)])?;
        let known = known(&net, 1e-6)?;
        Some(crate::import::step::convert::surface(&known.shape, 0).unwrap().kind())
    }

    const WAVE: [[f64; 4]; 5] = [
        [0.0, 0.0, 20.0, 1.0],
        [10.0, 0.0, 26.0, 1.0],
        [20.0, 0.0, 15.0, 1.0],
        [30.0, 0.0, 22.0, 1.0],
        [40.0, 0.0, 18.0, 1.0],
    ];

    #[test]
    fn a_wave_swept_in_its_own_plane_is_a_plane_and_across_it_is_not() {
        let down = Vector3::new(0.0, 0.0, -1.0);
        assert_eq!(kind(&extrusion(&WAVE, down), [0.0, 20.0]), Some("plane"));
        assert_eq!(kind(&extrusion(&WAVE, Vector3::y()), [0.0, 20.0]), None);
        // A hair out of the plane: over the height of the face more than the tolerance.
        let tilted = Vector3::new(0.0, 1e-6, -1.0);
        assert_eq!(kind(&extrusion(&WAVE, tilted), [0.0, 20.0]), None);
    }

    #[test]
    fn the_net_reaches_beyond_all_vertices_on_the_same_side() {
        let net = swept_net(&extrusion(&WAVE, Vector3::z()), &[boundary([-7.0, 31.0])]).unwrap();
        for u in [0.0, 0.3, 1.0] {
            let [low, high] = [0.0, 1.0].map(|v| net.jet2(u, v).s.z);
            assert!(low <= -7.0 && high >= 31.0, "{low} {high}");
        }
    }

    #[test]
    fn a_swept_arc_is_a_cylinder_and_a_turned_one_a_torus_or_a_sphere() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let arc =
            |x: f64| [[x + 4.0, 0.0, 0.0, 1.0], [x + 4.0, 0.0, 4.0, half], [x, 0.0, 4.0, 1.0]];
        assert_eq!(kind(&extrusion(&arc(0.0), Vector3::y()), [0.0, 1.0]), Some("cylinder"));
        let axis = StepFrame {
            origin: Point3::origin(),
            z: Vector3::z_axis(),
            x: Vector3::x_axis(),
            y: Vector3::y_axis(),
        };
        let turned = |x: f64| {
            let curve = StepCurve::Spline(spline(&arc(x)));
            kind(&StepShape::Revolution { curve, axis }, [0.0, 1.0])
        };
        assert_eq!(turned(0.0), Some("sphere"));
        assert_eq!(turned(20.0), Some("torus"));
    }
}
