//! Recognition of an elementary surface: fitted, then proven.

use super::sample::samples;
use super::{fit, proof};
use crate::import::step::model::StepFrame;
use crate::import::step::shape::StepShape;
use crate::math;
use crate::surface::NurbsSurface;
use nalgebra::Point3;
use nalgebra::Vector3;

/// An elementary surface that a control net is.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::import::step) struct RecognisedSurface {
    pub(in crate::import::step) shape: StepShape,
    /// `true` if its normal points the other way than the net's.
    pub(in crate::import::step) opposed: bool,
}

/// Finds the elementary surface that `net` is nowhere farther from than `tolerance` \[mm\].
pub(in crate::import::step) fn known(
    net: &NurbsSurface,
    tolerance: f64,
) -> Option<RecognisedSurface> {
    let samples = samples(net);
    let middle = samples.get(samples.len() / 2)?;
    let proven =
        |shape: &StepShape| proof::distance(net, shape).is_some_and(|off| off <= tolerance);
    let plane = fit::plane(&samples, middle).filter(proven);
    // No polynomials but linear ones keep a distance from a point or a line.
    let curved = || {
        let fits = [fit::sphere, fit::cylinder, fit::cone, fit::torus];
        fits.into_iter().find_map(|fit| fit(&samples, middle).filter(proven))
    };
    let shape = plane.or_else(|| if net.is_rational() { curved() } else { None })?;
    let opposed = outward(&shape, &middle.point)?.dot(&middle.normal) < 0.0;
    Some(RecognisedSurface { shape, opposed })
}

/// Returns a normal of the shape near a point, on the side of `S_u x S_v`, of any length.
fn outward(shape: &StepShape, p: &Point3<f64>) -> Option<Vector3<f64>> {
    let out = |frame: &StepFrame, x: f64, y: f64, z: f64| {
        Some(frame.x.scale(x) + frame.y.scale(y) + frame.z.scale(z))
    };
    match shape {
        StepShape::Plane(frame) => Some(frame.z.into_inner()),
        StepShape::Sphere { frame, .. } => Some(p - frame.origin),
        StepShape::Cylinder { frame, .. } => {
            let q = frame.local(p);
            out(frame, q.x, q.y, 0.0)
        }
        StepShape::Cone { frame, angle, .. } => {
            let q = frame.local(p);
            // Gradient of rho - z tan a.
            out(frame, q.x, q.y, -math::hypot(q.x, q.y) * math::tan(*angle))
        }
        StepShape::Torus { frame, major, .. } => {
            let q = frame.local(p);
            // From the centre of the tube in the half plane of p: (rho - R) out, z up.
            let inner = 1.0 - major / math::hypot(q.x, q.y);
            out(frame, q.x * inner, q.y * inner, q.z)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::SurfaceFrame as Axes;
    use std::f64::consts::FRAC_PI_2;

    fn place() -> (Point3<f64>, Vector3<f64>, Vector3<f64>) {
        (Point3::new(12.0, -7.0, 30.0), Vector3::new(0.3, -0.5, 0.8), Vector3::new(1.0, 0.2, 0.1))
    }

    /// Rational quadratic arc about the origin of the half plane `(rho, z)`.
    fn arc([from, to]: [f64; 2], radius: f64, centre: [f64; 2]) -> Vec<([f64; 2], f64)> {
        let half = 0.5 * (to - from);
        let at = |angle: f64, far: f64| {
            [centre[0] + radius * far * angle.cos(), centre[1] + radius * far * angle.sin()]
        };
        vec![
            (at(from, 1.0), 1.0),
            (at(from + half, half.cos().recip()), half.cos()),
            (at(to, 1.0), 1.0),
        ]
    }

    /// A quarter of a turn, or less, of a profile of three points.
    fn turned(profile: &[([f64; 2], f64)], turn: f64) -> NurbsSurface {
        let (origin, z, x) = place();
        let frame = Axes::new(origin, z, x).unwrap();
        let circle = arc([0.4, 0.4 + turn], 1.0, [0.0, 0.0]);
        let row = |([c, s], w): &([f64; 2], f64)| {
            let point = |([rho, height], _): &([f64; 2], f64)| {
                origin
                    + frame.x().scale(rho * c)
                    + frame.y().scale(rho * s)
                    + frame.z().scale(*height)
            };
            let points = profile.iter().map(point).collect::<Vec<_>>();
            (points, profile.iter().map(|(_, other)| w * other).collect::<Vec<_>>())
        };
        let (points, weights): (Vec<_>, Vec<_>) = circle.iter().map(row).unzip();
        let v = if profile.len() == 2 {
            vec![0.0, 0.0, 1.0, 1.0]
        } else {
            vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
        };
        let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], v];
        NurbsSurface::new([2, profile.len() - 1], knots, points, Some(weights)).unwrap()
    }

    /// Largest distance of a point of the net from the shape, by dense samples.
    fn off(net: &NurbsSurface, known: &RecognisedSurface) -> f64 {
        let all = (0..=20).flat_map(|i| (0..=20).map(move |j| [i, j].map(|k| f64::from(k) / 20.0)));
        let far = |[u, v]: [f64; 2]| gap(&known.shape, &net.jet2(u, v).s).abs();
        all.map(far).fold(0.0, f64::max)
    }

    fn gap(shape: &StepShape, p: &Point3<f64>) -> f64 {
        let polar = |frame: &StepFrame| (frame.local(p).xy().norm(), frame.local(p).z);
        match shape {
            StepShape::Sphere { frame, radius } => frame.local(p).norm() - radius,
            StepShape::Cylinder { frame, radius } => polar(frame).0 - radius,
            StepShape::Cone { frame, radius, angle } => {
                let (rho, z) = polar(frame);
                (rho - radius - z * angle.tan()) * angle.cos()
            }
            StepShape::Torus { frame, major, minor } => {
                let (rho, z) = polar(frame);
                (rho - major).hypot(z) - minor
            }
            _ => f64::NAN,
        }
    }

    #[test]
    fn quarters_of_all_kinds_are_recognised_exactly() {
        let line = |a: [f64; 2], b: [f64; 2]| vec![(a, 1.0), (b, 1.0)];
        let nets = [
            ("sphere", turned(&arc([0.0, FRAC_PI_2], 5.0, [0.0, 0.0]), FRAC_PI_2)),
            ("sphere", turned(&arc([-0.6, 0.5], 5.0, [0.0, 3.0]), 1.0)),
            ("cylinder", turned(&line([8.0, -3.0], [8.0, 11.0]), FRAC_PI_2)),
            ("cone", turned(&line([8.0, -3.0], [2.0, 11.0]), 0.7)),
            ("cone", turned(&line([0.0, -3.0], [2.0, 11.0]), FRAC_PI_2)),
            ("torus", turned(&arc([0.2, 1.4], 3.0, [20.0, 1.0]), FRAC_PI_2)),
            ("torus", turned(&arc([2.0, 3.4], 3.0, [4.0, 1.0]), 1.2)),
        ];
        for (kind, net) in nets {
            let known = known(&net, 1e-6).expect(kind);
            let surface = crate::import::step::convert::surface(&known.shape, 0).unwrap();
            assert_eq!(surface.kind(), kind);
            assert!(off(&net, &known) < 1e-10, "{kind}: {}", off(&net, &known));
            let proven = proof::distance(&net, &known.shape).unwrap();
            // The samples themselves are rounded.
            assert!(off(&net, &known) <= proven + 1e-13 && proven < 1e-6, "{kind}: {proven:e}");
        }
    }

    #[test]
    fn what_is_a_little_off_is_not_recognised_and_the_bound_holds() {
        let mut profile = arc([0.2, 1.4], 3.0, [20.0, 1.0]);
        profile[1].0[0] += 1e-3;
        let net = turned(&profile, FRAC_PI_2);
        assert_eq!(known(&net, 1e-5), None);
        let near = known(&net, 1e-2).unwrap();
        let proven = proof::distance(&net, &near.shape).unwrap();
        assert!(off(&net, &near) <= proven, "{} {proven}", off(&net, &near));
        assert!(off(&net, &near) > 1e-5);
    }

    #[test]
    fn the_side_of_the_normal_is_reported() {
        let net = turned(&arc([0.2, 1.4], 3.0, [20.0, 1.0]), FRAC_PI_2);
        assert!(!known(&net, 1e-6).unwrap().opposed);
        let [u, v] = net.knots().clone();
        let swap = |rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
            (0..3).map(|j| rows.iter().map(|row| row[j]).collect()).collect()
        };
        let points = (0..3).map(|j| net.points().iter().map(|row| row[j]).collect()).collect();
        let weights = swap(net.weights().unwrap());
        let knots = [v.knots().to_vec(), u.knots().to_vec()];
        let swapped = NurbsSurface::new([2, 2], knots, points, Some(weights)).unwrap();
        assert!(known(&swapped, 1e-6).unwrap().opposed);
    }

    #[test]
    fn a_net_of_no_elementary_surface_stays_what_it_is() {
        let bulge = arc([0.2, 1.4], 3.0, [20.0, 1.0]);
        let mut bulge = bulge.into_iter().map(|(p, _)| (p, 1.0)).collect::<Vec<_>>();
        bulge[2].0[1] += 1.0;
        assert_eq!(known(&turned(&bulge, FRAC_PI_2), 1e-5), None);
    }
}
