//! Space curves: what extrusions and revolutions are made of.

use super::analytic::SurfaceFrame;
use super::beyond::SplineExtension;
use super::error::{SurfaceError, SurfaceErrors};
use super::nurbs::{curve_quotient, turn_net};
use crate::math;
use crate::math::bspline::KnotVector;
use crate::math::bspline::LARGE;
use crate::math::bspline::SMALL;
use crate::math::bspline::bernstein;
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Rotation3;
use nalgebra::Vector3;
use nalgebra::Vector4;
use std::f64::consts::TAU;

/// Two ends closer than this share of the curve's size, with tangents that agree as well, meet.
const SEAM: f64 = 1e-7;

/// Point and derivatives to order 3 by the parameter.
pub type CurveJet = [Vector3<f64>; 4];

/// A space curve, parametrised as in ISO 10303-42.
#[derive(Debug, Clone, PartialEq)]
pub enum SpaceCurve {
    /// `origin + t direction`; the direction need not be a unit vector.
    Line {
        /// Point at `t = 0`.
        origin: Point3<f64>,
        /// Derivative \[mm per parameter\].
        direction: Vector3<f64>,
    },
    /// `origin + a cos t x + b sin t y`; a circle if both radii are equal.
    Ellipse {
        /// Frame of the ellipse.
        frame: SurfaceFrame,
        /// Half axes along x and y \[mm\].
        radii: [f64; 2],
    },
    /// B-spline, rational or not.
    Nurbs(NurbsCurve),
}

/// A B-spline or rational B-spline curve, evaluated from its Bezier pieces. Outside its range it
/// is continued with value and first two derivatives of its end, or periodically if it closes
/// smoothly.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsCurve {
    knots: KnotVector,
    net: Vec<Vector4<f64>>,
    pieces: Vec<Vector4<f64>>,
    closed: bool,
    /// Continuation below and above the range.
    beyond: [SplineExtension; 2],
}

impl SpaceCurve {
    /// Creates a straight line.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] for a direction without length, or numbers that are not finite.
    pub fn line(origin: Point3<f64>, direction: Vector3<f64>) -> Result<Self, SurfaceError> {
        let value = direction.norm();
        if !(value > 0.0 && value.is_finite() && origin.iter().all(|x| x.is_finite())) {
            let need = "finite and above 0";
            return Err(SurfaceError::Size { what: "length of the line's direction", value, need });
        }
        Ok(Self::Line { origin, direction })
    }

    /// Creates a circle or ellipse with half axes along x and y of `frame`.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] unless both radii are positive.
    pub fn ellipse(frame: SurfaceFrame, radii: [f64; 2]) -> Result<Self, SurfaceError> {
        for value in radii {
            if !(value > 0.0 && value.is_finite()) {
                let need = "finite and above 0";
                return Err(SurfaceError::Size { what: "radius of the curve", value, need });
            }
        }
        Ok(Self::Ellipse { frame, radii })
    }

    /// Returns the range of the parameter; endless for a line.
    pub fn domain(&self) -> Interval {
        match self {
            Self::Line { .. } => Interval::UNBOUNDED,
            Self::Ellipse { .. } => Interval::new(0.0, TAU),
            Self::Nurbs(curve) => curve.knots.range(),
        }
    }

    /// Returns the period, where the curve closes smoothly.
    pub fn period(&self) -> Option<f64> {
        match self {
            Self::Line { .. } => None,
            Self::Ellipse { .. } => Some(TAU),
            Self::Nurbs(curve) => {
                let Interval { low, high } = curve.knots.range();
                curve.closed.then_some(high - low)
            }
        }
    }

    /// Returns the curve turned about the origin of space, with the same parameter.
    pub(super) fn turned(&self, rotation: &Rotation3<f64>) -> Self {
        match self {
            Self::Line { origin, direction } => {
                Self::Line { origin: rotation * origin, direction: rotation * direction }
            }
            Self::Ellipse { frame, radii } => {
                Self::Ellipse { frame: frame.turned(rotation), radii: *radii }
            }
            Self::Nurbs(curve) => Self::Nurbs(curve.turned(rotation)),
        }
    }

    /// Returns the point at `t` \[mm\].
    pub fn point(&self, t: f64) -> Point3<f64> {
        Point3::from(self.jet(t)[0])
    }

    /// Returns the point and derivatives to order 3.
    pub fn jet(&self, t: f64) -> CurveJet {
        match self {
            Self::Line { origin, direction } => {
                let zero = Vector3::zeros();
                [origin.coords + direction * t, *direction, zero, zero]
            }
            Self::Ellipse { frame, radii: [a, b] } => {
                // C = O + e, C' = f, C'' = -e, C''' = -f.
                let (sin, cos) = math::sin_cos(t);
                let (x, y) = (frame.x().scale(*a), frame.y().scale(*b));
                let (e, f) = (x * cos + y * sin, y * cos - x * sin);
                [frame.origin().coords + e, f, -e, -f]
            }
            Self::Nurbs(curve) => curve.jet(t),
        }
    }
}

impl NurbsCurve {
    /// Checks and converts control points, weights (positive; none = all 1) and knots.
    ///
    /// # Errors
    ///
    /// All faults found.
    pub fn new(
        degree: usize,
        knots: Vec<f64>,
        points: &[Point3<f64>],
        weights: Option<&[f64]>,
    ) -> Result<Self, SurfaceErrors> {
        let mut faults = curve_faults(points, weights);
        let knots = KnotVector::new(degree, points.len(), knots).map_err(|errors| {
            let named = |error| SurfaceError::Knots { direction: "curve", error };
            faults.extend(errors.into_iter().map(named));
        });
        let (Ok(knots), true) = (knots, faults.is_empty()) else { return Err(faults.into()) };
        let weight = |i: usize| weights.and_then(|all| all.get(i)).copied().unwrap_or(1.0);
        // Homogeneous points (w x, w y, w z, w): the rational curve becomes a polynomial one.
        let lift = |(i, point): (usize, &Point3<f64>)| (point.coords * weight(i)).push(weight(i));
        let net: Vec<Vector4<f64>> = points.iter().enumerate().map(lift).collect();
        let pieces = knots.bezier(&net);
        let beyond = [SplineExtension::with(0.0); 2];
        let mut curve = Self { knots, net, pieces, closed: false, beyond };
        curve.closed = curve.closes(points);
        let Interval { low, high } = curve.knots.range();
        // One continuation for each end; at the low one the parameter falls outwards.
        curve.beyond = [(low, -1.0), (high, 1.0)].map(|(end, outwards)| {
            let [_, first, second, _] = curve.inner(end);
            SplineExtension::with(SplineExtension::pace([first, second], outwards))
        });
        Ok(curve)
    }

    /// Returns the curve turned about the origin of space.
    fn turned(&self, rotation: &Rotation3<f64>) -> Self {
        let mut turned = self.clone();
        turn_net(&mut turned.net, rotation);
        turn_net(&mut turned.pieces, rotation);
        turned
    }

    /// Returns the knot vector.
    pub fn knots(&self) -> &KnotVector {
        &self.knots
    }

    /// Returns the control points `(w x, w y, w z, w)`.
    pub(crate) fn net(&self) -> &[Vector4<f64>] {
        &self.net
    }

    /// Returns the control points of the Bezier pieces between the breaks, one piece after the
    /// other.
    pub fn pieces(&self) -> std::slice::ChunksExact<'_, Vector4<f64>> {
        self.pieces.chunks_exact(self.knots.degree() + 1)
    }

    fn closes(&self, points: &[Point3<f64>]) -> bool {
        let Interval { low, high } = self.knots.range();
        let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
        let (a, b) = (self.jet(low), self.jet(high));
        // Tangents are compared by the length they cover over the whole range, as points in mm.
        let rate = (high - low) * (a[1] - b[1]).norm();
        (a[0] - b[0]).norm() <= SEAM * size && rate <= SEAM * size.max((high - low) * a[1].norm())
    }

    /// Returns the point and derivatives to order 3.
    pub fn jet(&self, t: f64) -> CurveJet {
        let Interval { low, high } = self.knots.range();
        if self.closed && !(low..=high).contains(&t) && t.is_finite() {
            return self.inner((low + (t - low).rem_euclid(high - low)).clamp(low, high));
        }
        let inside = t.clamp(low, high);
        let (d, by) = (self.inner(inside), t - inside);
        if by == 0.0 {
            return d;
        }
        self.beyond[usize::from(by > 0.0)].at(d, by)
    }

    fn inner(&self, t: f64) -> CurveJet {
        if self.knots.degree() < SMALL {
            self.sized_inner::<SMALL>(t)
        } else {
            self.sized_inner::<LARGE>(t)
        }
    }

    #[inline]
    fn sized_inner<const N: usize>(&self, t: f64) -> CurveJet {
        let (degree, breaks) = (self.knots.degree(), self.knots.breaks());
        let piece = self.knots.piece(t);
        let [a, b] = [breaks[piece], breaks[piece + 1]];
        let rate = (b - a).recip();
        // Derivatives of the homogeneous curve; the quotient rule makes them Cartesian.
        let basis = bernstein::<N>(degree, (t - a) * rate, rate, 3);
        let mut net = [Vector4::zeros(); 4];
        let points = &self.pieces[piece * (degree + 1)..(piece + 1) * (degree + 1)];
        for (j, point) in points.iter().enumerate() {
            for (sum, row) in net.iter_mut().zip(&basis) {
                *sum += point * row[j];
            }
        }
        curve_quotient(&net)
    }
}

fn curve_faults(points: &[Point3<f64>], weights: Option<&[f64]>) -> Vec<SurfaceError> {
    let mut faults = Vec::new();
    for (i, point) in points.iter().enumerate() {
        for &value in point.iter().filter(|value| !value.is_finite()) {
            faults.push(SurfaceError::NotFinite { what: format!("curve point {i}"), value });
        }
    }
    if let Some(weights) = weights {
        if weights.len() != points.len() {
            let (found, expected) = (weights.len(), points.len());
            faults.push(SurfaceError::RowLength { what: "weights", row: 0, found, expected });
        }
        for (i, &value) in weights.iter().enumerate() {
            if !(value.is_finite() && value > 0.0) {
                faults.push(SurfaceError::Weight { place: format!("curve point {i}"), value });
            }
        }
    }
    faults
}
