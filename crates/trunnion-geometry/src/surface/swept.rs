//! Linear extrusion and revolution of a curve, parametrised as in ISO 10303-42.

use super::curve::SpaceCurve;
use super::error::{SurfaceError, SurfaceErrors};
use super::jet::DerivativeTable;
use super::nurbs::NurbsSurface;
use crate::math;
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Rotation3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;
use nalgebra::Vector4;
use std::f64::consts::FRAC_PI_2;
use std::f64::consts::TAU;

/// `curve(u) + v direction`.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtrusionSurface {
    curve: SpaceCurve,
    direction: Vector3<f64>,
}

/// `curve(v)` turned by `u` about an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct RevolutionSurface {
    curve: SpaceCurve,
    origin: Point3<f64>,
    axis: UnitVector3<f64>,
}

impl ExtrusionSurface {
    /// Creates the extrusion. The direction need not be a unit vector: `v` counts in its length.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] for a direction without length.
    pub fn new(curve: SpaceCurve, direction: Vector3<f64>) -> Result<Self, SurfaceError> {
        let value = direction.norm();
        if !(value > 0.0 && value.is_finite()) {
            let need = "finite and above 0";
            return Err(SurfaceError::Size { what: "length of the extrusion", value, need });
        }
        Ok(Self { curve, direction })
    }

    /// Returns the surface turned about the origin of space, with the same parameters.
    pub(super) fn turned(&self, rotation: &Rotation3<f64>) -> Self {
        Self { curve: self.curve.turned(rotation), direction: rotation * self.direction }
    }

    /// Returns a range of `v` that is short \[1e-3 mm\]: curvature is the same at every `v`.
    pub(crate) fn thin(&self) -> f64 {
        1e-3 / self.direction.norm()
    }

    /// Returns the curve that is moved.
    pub fn curve(&self) -> &SpaceCurve {
        &self.curve
    }

    pub(crate) fn domain(&self) -> [Interval; 2] {
        [self.curve.domain(), Interval::UNBOUNDED]
    }

    pub(crate) fn periods(&self) -> [Option<f64>; 2] {
        [self.curve.period(), None]
    }

    /// Returns the derivatives up to an order.
    #[inline]
    pub(crate) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        // S = C(u) + v D: derivatives by u are those of the curve, S_v = D, all others vanish.
        let jet = self.curve.jet(u);
        let mut d = [[Vector3::zeros(); 4]; 4];
        for (row, c) in d.iter_mut().zip(jet).take(ORDER + 1) {
            row[0] = c;
        }
        d[0][0] += self.direction * v;
        d[0][1] = self.direction;
        d
    }

    /// Converts the surface over a range of parameters to NURBS; see [`NurbsConversion`].
    pub(crate) fn to_nurbs(&self, [u, v]: [Interval; 2]) -> Result<NurbsConversion, SurfaceErrors> {
        let strip = SweptStrip::of_curve(&self.curve, u);
        // Degree 1 across: the homogeneous net of the curve, moved by v D times its weights, at
        // both ends of v.
        let ends = v.ends().map(|v| self.direction * v);
        let net = strip.net.iter().map(|point| {
            ends.iter().map(|end| (point.xyz() + end * point.w).push(point.w)).collect()
        });
        let surface =
            from_net([strip.degree, 1], [strip.knots, vec![v.low, v.low, v.high, v.high]], net)?;
        Ok(NurbsConversion { surface, arcs: [strip.arcs, false] })
    }
}

impl RevolutionSurface {
    /// A short range of `u` \[rad\]: curvature is the same at every `u`, and over such an arc
    /// tangents turn by no more than a thousandth.
    pub(crate) const THIN: f64 = 1e-3;

    /// Creates the surface of revolution of `curve` about the axis through `origin`.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::NotFinite`] for an origin that is not finite.
    pub fn new(
        curve: SpaceCurve,
        origin: Point3<f64>,
        axis: UnitVector3<f64>,
    ) -> Result<Self, SurfaceError> {
        let mut numbers = origin.iter().chain(axis.iter());
        if let Some(&value) = numbers.find(|value| !value.is_finite()) {
            return Err(SurfaceError::NotFinite { what: "axis of revolution".into(), value });
        }
        Ok(Self { curve, origin, axis })
    }

    /// Returns the surface turned about the origin of space, with the same parameters.
    pub(super) fn turned(&self, rotation: &Rotation3<f64>) -> Self {
        Self {
            curve: self.curve.turned(rotation),
            origin: rotation * self.origin,
            axis: UnitVector3::new_unchecked(rotation * self.axis.into_inner()),
        }
    }

    /// Returns the curve that is turned.
    pub fn curve(&self) -> &SpaceCurve {
        &self.curve
    }

    /// Returns the distance of a point from the axis \[mm\].
    pub fn radius(&self, point: &Vector3<f64>) -> f64 {
        self.axis.cross(&(point - self.origin.coords)).norm()
    }

    pub(crate) fn domain(&self) -> [Interval; 2] {
        [Interval::new(0.0, TAU), self.curve.domain()]
    }

    pub(crate) fn periods(&self) -> [Option<f64>; 2] {
        [Some(TAU), self.curve.period()]
    }

    /// Splits an offset from the origin: axial part, radial part, and the radial part a quarter
    /// turn further.
    fn split(&self, offset: &Vector3<f64>) -> [Vector3<f64>; 3] {
        let axial = self.axis.scale(offset.dot(&self.axis));
        [axial, offset - axial, self.axis.cross(offset)]
    }

    /// Returns the derivatives up to an order.
    #[inline]
    pub(crate) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        let (sin, cos) = math::sin_cos(u);
        // The point is taken from the axis; derivatives do not depend on an origin.
        let mut jet = self.curve.jet(v);
        jet[0] -= self.origin.coords;
        let mut d = [[Vector3::zeros(); 4]; 4];
        for (l, c) in jet.iter().enumerate().take(ORDER + 1) {
            let [axial, radial, quarter] = self.split(c);
            // S = O + axial + e(u): e' = f, e'' = -e, e''' = -f; the axial part does not turn.
            let (e, f) = (radial * cos + quarter * sin, quarter * cos - radial * sin);
            (d[0][l], d[1][l], d[2][l], d[3][l]) = (axial + e, f, -e, -f);
        }
        d[0][0] += self.origin.coords;
        d
    }

    /// Converts the surface over a range of parameters to NURBS; see [`NurbsConversion`].
    pub(crate) fn to_nurbs(&self, [u, v]: [Interval; 2]) -> Result<NurbsConversion, SurfaceErrors> {
        let strip = SweptStrip::of_curve(&self.curve, v);
        // A rational quadratic arc of half angle h: its middle control point is where the end
        // tangents meet, 1 / cos h times the radius out, with weight cos h (Piegl and Tiller, *The
        // NURBS Book*, chapter 7).
        let (breaks, half) = arcs(u);
        let turned = |point: &Vector4<f64>, angle: f64, weight: f64| {
            let offset = point.xyz() - self.origin.coords * point.w;
            let [axial, radial, quarter] = self.split(&offset);
            let ring = radial * math::cos(angle) + quarter * math::sin(angle);
            // Radial part 1/weight farther out, then everything times weight.
            let w = point.w * weight;
            (self.origin.coords * w + axial * weight + ring).push(w)
        };
        let row = |(angle, weight): (f64, f64)| -> Vec<Vector4<f64>> {
            strip.net.iter().map(|point| turned(point, angle, weight)).collect()
        };
        let net = arc_angles(&breaks, half).into_iter().map(row);
        let knots = [arc_knots(&breaks), strip.knots.clone()];
        let surface = from_net([2, strip.degree], knots, net)?;
        Ok(NurbsConversion { surface, arcs: [true, strip.arcs] })
    }
}

/// A NURBS surface with the same points over the same rectangle. Where `arcs` is set its
/// parameter runs through circular arcs at another pace: they agree at the breaks and
/// `tan(angle/2) = tan(half/2) (2t - 1)` between, angle counted from the arc's middle.
#[derive(Debug, Clone)]
pub(crate) struct NurbsConversion {
    pub(crate) surface: NurbsSurface,
    pub(crate) arcs: [bool; 2],
}

impl NurbsConversion {
    /// Returns the parameters of the original surface.
    pub(crate) fn original(&self, uv: [f64; 2]) -> [f64; 2] {
        self.map(uv, |x, half| (2.0 * math::atan(math::tan(0.5 * half) * x)) / half)
    }

    /// Returns the parameters of the NURBS surface.
    pub(crate) fn converted(&self, uv: [f64; 2]) -> [f64; 2] {
        self.map(uv, |x, half| math::tan(0.5 * half * x) / math::tan(0.5 * half))
    }

    /// Applies `bend` to the position in [-1, 1] within each arc.
    fn map(&self, uv: [f64; 2], bend: impl Fn(f64, f64) -> f64) -> [f64; 2] {
        [0, 1].map(|k| {
            let knots = &self.surface.knots()[k];
            let piece = knots.piece(uv[k]);
            let [a, b] = [knots.breaks()[piece], knots.breaks()[piece + 1]];
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
            if self.arcs[k] { middle + half * bend((uv[k] - middle) / half, half) } else { uv[k] }
        })
    }
}

/// A curve in B-spline form.
struct SweptStrip {
    degree: usize,
    knots: Vec<f64>,
    net: Vec<Vector4<f64>>,
    arcs: bool,
}

impl SweptStrip {
    fn of_curve(curve: &SpaceCurve, Interval { low, high }: Interval) -> Self {
        match curve {
            SpaceCurve::Line { .. } => {
                let net = [low, high].map(|t| curve.jet(t)[0].push(1.0)).to_vec();
                Self { degree: 1, knots: vec![low, low, high, high], net, arcs: false }
            }
            SpaceCurve::Ellipse { frame, .. } => {
                let (breaks, half) = arcs(Interval { low, high });
                let centre = frame.origin().coords;
                let point = |(t, weight): (f64, f64)| {
                    // Tangents meet 1/weight times as far from the centre.
                    (centre * weight + (curve.jet(t)[0] - centre)).push(weight)
                };
                let net = arc_angles(&breaks, half).into_iter().map(point).collect();
                Self { degree: 2, knots: arc_knots(&breaks), net, arcs: true }
            }
            SpaceCurve::Nurbs(spline) => {
                let knots = spline.knots().knots().to_vec();
                let degree = spline.knots().degree();
                Self { degree, knots, net: spline.net().to_vec(), arcs: false }
            }
        }
    }
}

/// Returns breaks of arcs of at most a right angle, and half the angle of each.
fn arcs(Interval { low, high }: Interval) -> (Vec<f64>, f64) {
    // The slack keeps a range of exactly n right angles at n arcs, whatever its last digits.
    let count = ((high - low) / FRAC_PI_2 - 1e-9).ceil().clamp(1.0, 8.0);
    let step = (high - low) / count;
    let breaks = (0..=8).take_while(|&i| f64::from(i) <= count).map(|i| low + step * f64::from(i));
    (breaks.collect(), 0.5 * step)
}

/// Returns angle and weight of every control point of the arcs.
fn arc_angles(breaks: &[f64], half: f64) -> Vec<(f64, f64)> {
    let mut angles = vec![(breaks[0], 1.0)];
    for pair in breaks.windows(2) {
        angles.extend([(0.5 * (pair[0] + pair[1]), math::cos(half)), (pair[1], 1.0)]);
    }
    angles
}

/// Returns quadratic knots with every break repeated twice, the ends thrice.
fn arc_knots(breaks: &[f64]) -> Vec<f64> {
    let ends = [breaks[0], breaks[breaks.len() - 1]];
    let inner = breaks.iter().flat_map(|&b| [b, b]);
    std::iter::once(ends[0]).chain(inner).chain([ends[1]]).collect()
}

/// Creates a NURBS surface from homogeneous control points.
fn from_net(
    degree: [usize; 2],
    knots: [Vec<f64>; 2],
    net: impl Iterator<Item = Vec<Vector4<f64>>>,
) -> Result<NurbsSurface, SurfaceErrors> {
    // The net is homogeneous; NURBS surfaces take points and weights apart.
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for row in net {
        points.push(row.iter().map(|point| Point3::from(point.xyz() / point.w)).collect());
        weights.push(row.iter().map(|point| point.w).collect());
    }
    NurbsSurface::new(degree, knots, points, Some(weights))
}
