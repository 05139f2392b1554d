//! Splits a face into pieces that are flat to within a stated error.

use crate::surface::{BezierPatch, Face, NurbsSurface, SpaceCurve, Surface};
use crate::types::Interval;
use crate::verify::swept::rays::RayBundle;
use nalgebra::{Point3, Vector3, Vector4};

/// Rectangle of parameters.
pub(crate) type UvRectangle = [[f64; 2]; 2];

/// Face with bounds on its second derivatives.
pub(crate) struct FaceShape<'a> {
    pub(crate) face: &'a Face,
    /// Parameters at which derivatives may jump, for u and v.
    breaks: [Vec<f64>; 2],
    /// Bounds per patch, v running fastest.
    bends: Vec<[f64; 3]>,
    /// Global bound, used beyond the seam of a periodic surface.
    anywhere: Option<[f64; 3]>,
    /// Largest curvature, if known \[1/mm\].
    curvature: Option<f64>,
}

/// Flat piece of a face: every point is within `bulge` of `centre + s a + t b`, with s and t in -1..=1; every normal is
/// within `turn` of `normal`.
pub(crate) struct FlatCell {
    pub(crate) centre: Point3<f64>,
    pub(crate) normal: Vector3<f64>,
    pub(crate) half: [Vector3<f64>; 2],
    pub(crate) bulge: f64,
    pub(crate) turn: f64,
}

impl FlatCell {
    /// Bounds the distance of its points from the centre \[mm\].
    pub(crate) fn radius(&self) -> f64 {
        let [a, b] = &self.half;
        (a + b).norm().max((a - b).norm()) + self.bulge
    }

    /// Returns the bundle of rays along its normals.
    pub(crate) fn bundle(&self) -> RayBundle {
        let (centre, normal, radius) = (self.centre, self.normal, self.radius());
        RayBundle { centre, normal, radius, bulge: self.bulge, turn: self.turn }
    }

    /// Returns its approximate area \[mm²\].
    pub(crate) fn area(&self) -> f64 {
        4.0 * self.half[0].cross(&self.half[1]).norm()
    }
}

impl<'a> FaceShape<'a> {
    /// Computes the bounds of a face.
    pub(crate) fn new(face: &'a Face) -> Self {
        let [u, v] = face.bounds();
        let ends = |range: Interval| range.ends().to_vec();
        let jet = |u: f64, v: f64| face.surface.jet2(u, v);
        let size = |vector: Vector3<f64>| vector.norm();
        let plain = |second: [f64; 3], curvature: f64| {
            let breaks = [ends(u), ends(v)];
            let (bends, curvature) = (vec![second], Some(curvature));
            Self { face, breaks, bends, anywhere: None, curvature }
        };
        match &face.surface {
            Surface::Plane(_) => plain([0.0; 3], 0.0),
            Surface::Cylinder(_) => {
                let radius = size(jet(u.low, v.low).suu);
                plain([radius, 0.0, 0.0], 1.0 / radius)
            }
            Surface::Cone(_) => {
                // |S_uu| is the local radius and |S_uv| the constant slope of the radius. The curvature is at
                // most 1 / radius.
                let radii = v.ends().map(|v| size(jet(u.low, v).suu));
                let second = [radii[0].max(radii[1]), size(jet(u.low, v.low).suv), 0.0];
                plain(second, 1.0 / radii[0].min(radii[1]))
            }
            Surface::Sphere(_) => {
                // |S_uu| = r cos v, |S_uv| = r |sin v| and |S_vv| = r: all at most r.
                let radius = size(jet(0.0, 0.0).svv);
                plain([radius; 3], 1.0 / radius)
            }
            Surface::Torus(_) => {
                // |S_uu| is largest at the outer equator, |S_uv| and |S_vv| are at most the minor radius. The
                // curvature is that of the tube or that of the inner equator.
                let [outer, minor] = [size(jet(0.0, 0.0).suu), size(jet(0.0, 0.0).svv)];
                let inner = outer - 2.0 * minor;
                let curvature = (1.0 / minor).max(if inner > 0.0 { 1.0 / inner } else { 0.0 });
                plain([outer, minor, minor], curvature)
            }
            Surface::Nurbs(surface) => Self::of_nurbs(face, surface),
            Surface::Extrusion(surface) => {
                // Straight along v: only the second derivative of the curve remains.
                let ControlStrip { breaks, bounds } =
                    ControlStrip::new(surface.curve(), u, |_| 0.0);
                let bends = bounds.iter().map(|[_, second, _]| [*second, 0.0, 0.0]).collect();
                Self::of_pieces(face, [breaks, ends(v)], bends)
            }
            Surface::Revolution(surface) => {
                // |S_uu| is the distance from the axis; the curve's derivatives bound |S_uv| and |S_vv|.
                let radius = |start: &Vector3<f64>| surface.radius(start);
                let ControlStrip { breaks, bounds } = ControlStrip::new(surface.curve(), v, radius);
                let bends = bounds.iter().map(|[first, second, radius]| [*radius, *first, *second]);
                Self::of_pieces(face, [ends(u), breaks], bends.collect())
            }
        }
    }

    fn of_nurbs(face: &'a Face, surface: &NurbsSurface) -> Self {
        let [columns, rows] = surface.patch_count();
        let degree = surface.degree();
        let breaks = [0, 1].map(|k: usize| surface.knots()[k].breaks().to_vec());
        let patches = (0..columns).flat_map(|i| (0..rows).filter_map(move |j| surface.patch(i, j)));
        let bends: Vec<[f64; 3]> = patches.map(|patch| second(&patch, degree)).collect();
        Self::of_pieces(face, breaks, bends)
    }

    /// Returns the intervals between breaks, repeated with the period if the face is periodic.
    fn of_pieces(face: &'a Face, mut breaks: [Vec<f64>; 2], bends: Vec<[f64; 3]>) -> Self {
        let bounds = face.bounds();
        // A face across the seam of a periodic surface leaves the parameters of the patches.
        let beyond = |k: usize| {
            let [first, last] = [breaks[k].first(), breaks[k].last()];
            first.is_none_or(|low| bounds[k].low < *low)
                || last.is_none_or(|high| bounds[k].high > *high)
        };
        let most = |k: usize| bends.iter().map(|bend| bend[k]).fold(0.0, f64::max);
        let anywhere = (beyond(0) || beyond(1)).then(|| [most(0), most(1), most(2)]);
        for (breaks, period) in breaks.iter_mut().zip(face.surface.periods()) {
            if let (Some(period), Some(_)) = (period, anywhere) {
                let once = breaks.clone();
                breaks.extend(once.iter().flat_map(|x| [x - period, x + period]));
                breaks.sort_by(f64::total_cmp);
            }
        }
        Self { face, breaks, bends, anywhere, curvature: None }
    }

    /// Splits a rectangle into parts on which no derivative jumps.
    pub(crate) fn smooth_parts(&self, [u, v]: UvRectangle) -> Vec<UvRectangle> {
        let (us, vs) = (cuts(&self.breaks[0], u), cuts(&self.breaks[1], v));
        us.iter().flat_map(|&u| vs.iter().map(move |&v| [u, v])).collect()
    }

    /// Returns the flat piece over a rectangle that crosses no break; `None` where there is no normal.
    pub(crate) fn cell(&self, rectangle: &UvRectangle) -> Option<FlatCell> {
        let [u, v] = rectangle.map(|[low, high]| 0.5 * (low + high));
        let [du, dv] = rectangle.map(|[low, high]| 0.5 * (high - low));
        let jet = self.face.surface.jet1(u, v);
        let cross = jet.su.cross(&jet.sv);
        let normal = jet.normal()?.into_inner();
        let normal = if self.face.flip { -normal } else { normal };
        let [uu, uv, vv] = self.bend(u, v);
        // Taylor's theorem with remainder, plus the change of both tangents from those in the middle.
        let bulge = 0.5 * (uu * du * du + 2.0 * uv * du * dv + vv * dv * dv);
        // `a` and `b` bound the changes of S_u and S_v, `spread` that of their cross product.
        let [a, b] = [uu * du + uv * dv, uv * du + vv * dv];
        let spread = a * jet.sv.norm() + b * jet.su.norm() + a * b;
        // |x/|x| - y/|y|| <= 2 |x - y| / |x|.
        let turn = (2.0 * spread / cross.norm()).min(2.0);
        let mut cell =
            FlatCell { centre: jet.s, normal, half: [jet.su * du, jet.sv * dv], bulge, turn };
        // A known curvature bounds the turn as well; the smaller bound counts.
        if let Some(curvature) = self.curvature {
            cell.turn = cell.turn.min(curvature * cell.radius());
        }
        Some(cell)
    }

    fn bend(&self, u: f64, v: f64) -> [f64; 3] {
        if let Some(anywhere) = self.anywhere {
            return anywhere;
        }
        let pieces = |k: usize| self.breaks[k].len().saturating_sub(1).max(1);
        let piece = |k: usize, x: f64| {
            // Index of the interval that holds x, clamped at the ends.
            let after = self.breaks[k].partition_point(|&end| end <= x);
            after.clamp(1, pieces(k)) - 1
        };
        let (i, j, rows) = (piece(0, u), piece(1, v), pieces(1));
        self.bends.get(i * rows + j).copied().unwrap_or([f64::INFINITY; 3])
    }
}

/// Cuts an interval at the breaks inside it.
fn cuts(breaks: &[f64], [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
    let inner = breaks.iter().copied().filter(|&x| x > low && x < high);
    let ends: Vec<f64> = std::iter::once(low).chain(inner).chain([high]).collect();
    ends.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Control points in rows.
struct HomogeneousNet {
    points: Vec<Vector4<f64>>,
    columns: usize,
}

impl HomogeneousNet {
    /// Returns the control net of the derivative by parameter `k`; all zero for degree 0.
    fn derivative(&self, k: usize) -> Self {
        let rows = self.points.len() / self.columns;
        let count = if k == 0 { rows } else { self.columns };
        if count < 2 {
            return Self { points: vec![Vector4::zeros()], columns: 1 };
        }
        let (m, n) = if k == 0 { (rows - 1, self.columns) } else { (rows, self.columns - 1) };
        let step = if k == 0 { self.columns } else { 1 };
        let at = |index: usize| self.points.get(index).copied().unwrap_or_default();
        let degree = (count - 1) as f64;
        let points = (0..m * n).map(|index| {
            let start = index / n * self.columns + index % n;
            (at(start + step) - at(start)) * degree
        });
        Self { points: points.collect(), columns: n }
    }

    /// Returns the largest vector and the largest weight.
    fn size(&self) -> [f64; 2] {
        let most = |of: fn(&Vector4<f64>) -> f64| self.points.iter().map(of).fold(0.0, f64::max);
        [most(|p| p.xyz().norm()), most(|p| p.w.abs())]
    }
}

/// Centres control points, in rows of a given length, on their middle; returns the least weight and the largest
/// distance from the middle as well.
fn centred(points: &[Vector4<f64>], columns: usize) -> (HomogeneousNet, f64, f64) {
    let count = points.len().max(1) as f64;
    // The bounds grow with |S|, so the origin moves to the middle m of the points. The homogeneous point
    // (w x, w) becomes (w (x - m), w).
    let middle = points.iter().map(|p| p.xyz() / p.w).sum::<Vector3<f64>>() / count;
    let shifted = points.iter().map(|p| (p.xyz() - middle * p.w).push(p.w));
    let net = HomogeneousNet { points: shifted.collect(), columns };
    let least = net.points.iter().map(|p| p.w).fold(f64::INFINITY, f64::min);
    let far = net.points.iter().map(|p| p.xyz().norm() / p.w).fold(0.0, f64::max);
    (net, least, far)
}

/// Bounds `|S_uu|`, `|S_uv|` and `|S_vv|` over a patch.
///
/// With `S = A / w` about the middle of the control points: `S_u = (A_u - w_u S) / w` and
/// `S_uv = (A_uv - w_u S_v - w_v S_u - w_uv S) / w`, each derivative within the hull of its net.
fn second(patch: &BezierPatch<'_>, degree: [usize; 2]) -> [f64; 3] {
    let (net, least, far) = centred(patch.points, degree[1] + 1);
    // Step 1: each derivative is in the convex hull of its net, so its largest control value bounds it.
    let [u, v] = [net.derivative(0), net.derivative(1)];
    let first = [u.size(), v.size()];
    // Step 2: |S_u| <= (|A_u| + |w_u| |S|) / w, with |S| <= far and w >= least; the same for S_v.
    let slope = first.map(|[vector, weight]| (vector + weight * far) / least);
    // Step 3: the same for the second derivatives. For j = k the mixed term counts twice, as 2 w_u S_u.
    let bound = |net: HomogeneousNet, j: usize, k: usize| {
        let [vector, weight] = net.size();
        let mixed = first[j][1] * slope[k] + first[k][1] * slope[j];
        (vector + mixed + weight * far) / least
    };
    // Step 4: convert from the unit square to the parameters of the surface.
    let [du, dv] = patch.bounds.map(|range| range.width());
    [
        bound(u.derivative(0), 0, 0) / (du * du),
        bound(u.derivative(1), 0, 1) / (du * dv),
        bound(v.derivative(1), 1, 1) / (dv * dv),
    ]
}

/// Bounds of a curve between breaks.
struct ControlStrip {
    breaks: Vec<f64>,
    /// Bounds per piece: first and second derivative, and a distance that is convex in the point.
    bounds: Vec<[f64; 3]>,
}

impl ControlStrip {
    fn new(
        curve: &SpaceCurve,
        Interval { low, high }: Interval,
        distance: impl Fn(&Vector3<f64>) -> f64,
    ) -> Self {
        let plain = |bound: [f64; 3]| Self { breaks: vec![low, high], bounds: vec![bound] };
        let at = |t: f64| curve.point(t).coords;
        match curve {
            SpaceCurve::Line { direction, .. } => {
                plain([direction.norm(), 0.0, distance(&at(low)).max(distance(&at(high)))])
            }
            SpaceCurve::Ellipse { frame, radii } => {
                // Both derivatives of (a cos t, b sin t) are at most the larger radius, as is the distance
                // from the centre.
                let most = radii[0].max(radii[1]);
                plain([most, most, distance(&frame.origin().coords) + most])
            }
            SpaceCurve::Nurbs(curve) => {
                let breaks = curve.knots().breaks().to_vec();
                let bounds = curve.pieces().zip(breaks.windows(2)).map(|(points, ends)| {
                    let [first, second] = along(points, ends[1] - ends[0]);
                    // A convex function is largest at a corner of the convex hull.
                    let far = points.iter().map(|p| distance(&(p.xyz() / p.w)));
                    [first, second, far.fold(0.0, f64::max)]
                });
                Self { bounds: bounds.collect(), breaks }
            }
        }
    }
}

/// Bounds the first and second derivative over a Bezier piece of a curve; see [`second`].
fn along(points: &[Vector4<f64>], length: f64) -> [f64; 2] {
    let (net, least, far) = centred(points, 1);
    // As in `second`: S' = (A' - w' S) / w about the middle of the control points.
    let first = net.derivative(0);
    let [vector, weight] = first.size();
    let slope = (vector + weight * far) / least;
    // S'' = (A'' - 2 w' S' - w'' S) / w.
    let [bend, flare] = first.derivative(0).size();
    let second = (bend + 2.0 * weight * slope + flare * far) / least;
    [slope / length, second / (length * length)]
}

/// Returns the halves of a rectangle by parameter `k`.
pub(crate) fn halves(rectangle: UvRectangle, k: usize) -> [UvRectangle; 2] {
    let [low, high] = rectangle[k];
    let middle = 0.5 * (low + high);
    let mut parts = [rectangle; 2];
    (parts[0][k], parts[1][k]) = ([low, middle], [middle, high]);
    parts
}

/// Returns the quarters of a rectangle.
pub(crate) fn quarters([[u0, u1], [v0, v1]]: UvRectangle) -> [UvRectangle; 4] {
    let [u, v] = [0.5 * (u0 + u1), 0.5 * (v0 + v1)];
    [[[u0, u], [v0, v]], [[u0, u], [v, v1]], [[u, u1], [v0, v]], [[u, u1], [v, v1]]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rational_arc_is_bounded_by_no_less_than_its_acceleration() {
        // A quarter of a circle of radius 10, along v straight: |S_uu| is largest at the ends.
        let w = 0.5f64.sqrt();
        let rows = [[10.0, 0.0, 1.0], [10.0, 10.0, w], [0.0, 10.0, 1.0]];
        let points: Vec<Vec<Point3<f64>>> = rows
            .iter()
            .map(|[x, y, _]| vec![Point3::new(*x, *y, 0.0), Point3::new(*x, *y, 5.0)])
            .collect();
        let weights = rows.iter().map(|row| vec![row[2]; 2]).collect();
        let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
        let surface = NurbsSurface::new([2, 1], knots, points, Some(weights)).unwrap();
        let face = Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap();
        let shape = FaceShape::new(&face);
        let [uu, uv, vv] = shape.bend(0.5, 0.5);
        for k in 0..=20 {
            let jet = face.surface.jet2(f64::from(k) / 20.0, 0.3);
            assert!(jet.suu.norm() <= uu && jet.suv.norm() <= uv && jet.svv.norm() <= vv);
        }
        assert!(uu < 300.0, "{uu}");
    }

    #[test]
    fn a_cell_holds_its_points_and_normals() {
        let row = |i: i32| {
            let point = |j: i32| {
                let [x, y] = [f64::from(i), f64::from(j)];
                Point3::new(10.0 * x, 10.0 * y, 2.0 * x * x - 3.0 * y * y + x * y)
            };
            (0..4).map(point).collect()
        };
        let knots = || vec![0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0];
        let surface =
            NurbsSurface::new([2, 2], [knots(), knots()], (0..4).map(row).collect(), None).unwrap();
        let face = Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap().flipped();
        let shape = FaceShape::new(&face);
        let rectangle = [[0.1, 0.3], [0.55, 0.8]];
        assert_eq!(shape.smooth_parts([[0.4, 0.6], [0.0, 0.5]]).len(), 2);
        let cell = shape.cell(&rectangle).unwrap();
        for k in 0..100 {
            let [s, t] = [f64::from(k % 10) / 4.5 - 1.0, f64::from(k / 10) / 4.5 - 1.0];
            let [u, v] = [0.2 + 0.1 * s, 0.675 + 0.125 * t];
            let flat = cell.centre + cell.half[0] * s + cell.half[1] * t;
            assert!((face.point(u, v) - flat).norm() <= cell.bulge + 1e-12);
            let normal = face.normal(u, v).unwrap().into_inner();
            assert!((normal - cell.normal).norm() <= cell.turn);
        }
    }
}
