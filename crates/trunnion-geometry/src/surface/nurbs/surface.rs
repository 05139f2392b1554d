//! Tensor-product NURBS surfaces, evaluated from their Bezier patches.

use super::net::all_equal;
use super::net::bezier_patches;
use super::net::homogeneous;
use super::net::net_faults;
use super::net::net_size;
use super::net::turn_net;
use crate::math::bspline::KnotVector;
use crate::surface::beyond::SplineExtension;
use crate::surface::error::{SurfaceError, SurfaceErrors};
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Rotation3;
use nalgebra::Vector4;

/// Files carry 7 to 16 digits: opposite rims closer than this share of the size of the control
/// net, with tangents that agree as well, are taken as one seam.
const SEAM: f64 = 1e-7;

/// Below this share of (size of the net)^2 a patch's largest `|S_u x S_v|` (by local parameters)
/// is rounding of its control points, for coordinates up to 1e3 times its size.
const FLAT: f64 = 1e-12;

/// B-spline, Bezier or rational tensor surface. `points[i][j]`, `i` along u.
///
/// Evaluation runs on Bezier patches made once, by convex combinations: no knot arithmetic, no
/// allocation. Outside the domain the surface is continued with the point and the first two
/// derivatives of the nearest border point, or periodically where its rims close smoothly.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsSurface {
    pub(super) knots: [KnotVector; 2],
    points: Vec<Vec<Point3<f64>>>,
    pub(super) weights: Option<Vec<Vec<f64>>>,
    /// `(w x, w y, w z, w)`; patch after patch, v running fastest over patches and within them.
    pub(super) patches: Vec<Vector4<f64>>,
    pub(super) rational: bool,
    pub(super) closed: [bool; 2],
    /// `true` for rims that are points: below and above the range, by u and v.
    pub(super) collapsed: [[bool; 2]; 2],
    /// Continuation below and above the range, by u and v.
    pub(super) beyond: [[SplineExtension; 2]; 2],
}

/// One Bezier patch: control points `(w x, w y, w z, w)`, v running fastest, and its rectangle.
#[derive(Debug, Clone, Copy)]
pub struct BezierPatch<'a> {
    /// Control points, `(p + 1)(q + 1)`.
    pub points: &'a [Vector4<f64>],
    /// Ranges of u and v.
    pub bounds: [Interval; 2],
}

impl NurbsSurface {
    /// Checks and converts a control net. `weights`, where given, has the shape of `points`.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trunnion_geometry::surface::{NurbsSurface, Surface};
    /// use trunnion_geometry::types::Interval;
    ///
    /// // The plane z = 0 over a square of 40 mm.
    /// let point = |x, y| Point3::new(x, y, 0.0);
    /// let points =
    ///     vec![vec![point(0.0, 0.0), point(0.0, 40.0)], vec![point(40.0, 0.0), point(40.0, 40.0)]];
    /// let knots = vec![0.0, 0.0, 1.0, 1.0];
    /// let plane = NurbsSurface::new([1, 1], [knots.clone(), knots], points, None).unwrap();
    /// let surface = Surface::Nurbs(plane);
    /// assert_eq!(surface.domain(), [Interval::new(0.0, 1.0); 2]);
    /// assert_eq!(surface.point(0.25, 0.5), Point3::new(10.0, 20.0, 0.0));
    /// # Ok::<(), trunnion_geometry::surface::SurfaceError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// All faults found: knots, row lengths, numbers that are not finite, weights that are not
    /// positive, patches without area.
    pub fn new(
        degree: [usize; 2],
        knots: [Vec<f64>; 2],
        points: Vec<Vec<Point3<f64>>>,
        weights: Option<Vec<Vec<f64>>>,
    ) -> Result<Self, SurfaceErrors> {
        let mut faults = net_faults(&points, weights.as_deref());
        let columns = points.first().map_or(0, Vec::len);
        let [u, v] = knots;
        let u = KnotVector::new(degree[0], points.len(), u);
        let v = KnotVector::new(degree[1], columns, v);
        let (u, v) = match (u, v) {
            (Ok(u), Ok(v)) if faults.is_empty() => (u, v),
            (u, v) => {
                for (direction, knots) in [("u", u), ("v", v)] {
                    let errors = knots.err().into_iter().flatten();
                    let named = |error| SurfaceError::Knots { direction, error };
                    faults.extend(errors.map(named));
                }
                return Err(faults.into());
            }
        };
        let rational =
            weights.as_ref().is_some_and(|rows| !all_equal(rows.iter().flatten().copied()));
        let patches = bezier_patches(&[&u, &v], &homogeneous(&points, weights.as_deref()));
        let knots = [u, v];
        let beyond = [[SplineExtension::with(0.0); 2]; 2];
        let (closed, collapsed) = ([false; 2], [[false; 2]; 2]);
        let mut surface =
            Self { knots, points, weights, patches, rational, closed, collapsed, beyond };
        let flat = surface.degenerate_patches();
        if !flat.is_empty() {
            return Err(flat.into());
        }
        // Found by evaluation inside the domain, which does not use them.
        surface.closed = [surface.closes(0), surface.closes(1)];
        surface.collapsed = [0, 1].map(|k| [0, 1].map(|end| surface.is_point(k, end)));
        surface.beyond = [0, 1].map(|k| [surface.continuation(k, 0), surface.continuation(k, 1)]);
        Ok(surface)
    }

    /// Returns the surface turned about the origin of space, with the same parameters. Knots, seams, poles and
    /// continuations stay: none depends on directions in space.
    pub(in super::super) fn turned(&self, rotation: &Rotation3<f64>) -> Self {
        let mut turned = self.clone();
        for point in turned.points.iter_mut().flatten() {
            *point = rotation * *point;
        }
        turn_net(&mut turned.patches, rotation);
        turned
    }

    /// Returns the degrees by u and v.
    pub fn degree(&self) -> [usize; 2] {
        [self.knots[0].degree(), self.knots[1].degree()]
    }

    /// Returns the knot vectors by u and v.
    pub fn knots(&self) -> &[KnotVector; 2] {
        &self.knots
    }

    /// Returns the control points, `points[i][j]` with `i` along u \[mm\].
    pub fn points(&self) -> &[Vec<Point3<f64>>] {
        &self.points
    }

    /// Returns the weights as given.
    pub fn weights(&self) -> Option<&[Vec<f64>]> {
        self.weights.as_deref()
    }

    /// Returns `true` if the weights differ.
    pub fn is_rational(&self) -> bool {
        self.rational
    }

    /// Returns the ranges of u and v.
    pub fn domain(&self) -> [Interval; 2] {
        [self.knots[0].range(), self.knots[1].range()]
    }

    /// Returns the periods by u and v where opposite rims meet with equal tangents.
    pub fn periods(&self) -> [Option<f64>; 2] {
        let [u, v] = self.domain();
        [self.closed[0].then(|| u.width()), self.closed[1].then(|| v.width())]
    }

    /// Returns the parameters at which the surface ends: at rims that are points.
    pub(crate) fn ends(&self) -> [Interval; 2] {
        let outside = [f64::NEG_INFINITY, f64::INFINITY];
        let domain = self.domain();
        let end = |k: usize, end: usize| {
            if self.collapsed[k][end] { domain[k].ends()[end] } else { outside[end] }
        };
        [0, 1].map(|k| Interval::new(end(k, 0), end(k, 1)))
    }

    /// Returns the number of Bezier patches along u and v.
    pub fn patch_count(&self) -> [usize; 2] {
        [self.knots[0].breaks().len() - 1, self.knots[1].breaks().len() - 1]
    }

    /// Returns the Bezier patch in column `i` (along u), row `j`; `None` beyond the last.
    pub fn patch(&self, i: usize, j: usize) -> Option<BezierPatch<'_>> {
        let [columns, rows] = self.patch_count();
        if i >= columns || j >= rows {
            return None;
        }
        let [u, v] = [self.knots[0].breaks(), self.knots[1].breaks()];
        let bounds = [Interval::new(u[i], u[i + 1]), Interval::new(v[j], v[j + 1])];
        Some(BezierPatch { points: self.block(i, j), bounds })
    }

    pub(super) fn block(&self, i: usize, j: usize) -> &[Vector4<f64>] {
        let [p, q] = self.degree();
        let size = (p + 1) * (q + 1);
        let first = (i * (self.knots[1].breaks().len() - 1) + j) * size;
        &self.patches[first..first + size]
    }

    /// Returns the continuation beyond one end (0 low, 1 high) of `direction`, for the point of
    /// that rim at which the parametrisation slows down most.
    fn continuation(&self, direction: usize, end: usize) -> SplineExtension {
        let x = self.knots[direction].range().ends()[end];
        let pace = |y: f64| {
            let [u, v] = if direction == 0 { [x, y] } else { [y, x] };
            let d = self.table::<2>(u, v);
            let slopes = if direction == 0 { [d[1][0], d[2][0]] } else { [d[0][1], d[0][2]] };
            SplineExtension::pace(slopes, if end == 0 { -1.0 } else { 1.0 })
        };
        // One rate for the whole rim, so that the continuation is as smooth along it as the rim is.
        let places: Vec<[f64; 2]> = self.rim(direction).map(|y| [y, pace(y)]).collect();
        let largest = (0..places.len()).fold(0.0, |largest: f64, k| {
            let around = [k.saturating_sub(1), k, (k + 1).min(places.len() - 1)];
            let [[low, before], [_, here], [high, after]] = around.map(|k| places[k]);
            // A sample not below its neighbours brackets a maximum.
            let refined = if here >= before.max(after) { peak(pace, [low, high]) } else { here };
            largest.max(here).max(refined)
        });
        SplineExtension::with(largest)
    }

    /// Returns parameters along the rims across `direction`: more of them a piece than a polynomial
    /// of the squared first derivative's degree has zeros.
    fn rim(&self, direction: usize) -> impl Iterator<Item = f64> {
        let across = &self.knots[1 - direction];
        let samples = 2 * across.degree() + 1;
        across.breaks().windows(2).flat_map(move |piece| {
            let (low, width) = (piece[0], piece[1] - piece[0]);
            (0..=samples).map(move |k| low + width * k as f64 / samples as f64)
        })
    }

    /// Lists patches whose points lie on a line or in one point.
    fn degenerate_patches(&self) -> Vec<SurfaceError> {
        let [columns, rows] = self.patch_count();
        let all = (0..columns).flat_map(|i| (0..rows).filter_map(move |j| self.patch(i, j)));
        all.filter(|patch| self.is_degenerate(patch))
            .map(|patch| {
                let [u, v] = patch.bounds.map(Interval::from);
                SurfaceError::DegeneratePatch { u, v }
            })
            .collect()
    }

    /// Returns `true` if `|S_u x S_v|`, a polynomial of bounded degree, vanishes on a whole grid
    /// denser than that.
    fn is_degenerate(&self, patch: &BezierPatch<'_>) -> bool {
        let [p, q] = self.degree();
        let [u, v] = patch.bounds;
        let size = net_size(patch.points);
        let (m, n) = (2 * p + 1, 2 * q + 1);
        let mut inner = (0..m).flat_map(|i| (0..n).map(move |j| (i, j)));
        inner.all(|(i, j)| {
            let s = (i as f64 + 0.5) / m as f64;
            let t = (j as f64 + 0.5) / n as f64;
            let d = self.table::<1>(u.low + s * (u.high - u.low), v.low + t * (v.high - v.low));
            // |S_u x S_v| by parameters in [0, 1]: mm^2, comparable with the square of the net's
            // size.
            let area = d[1][0].cross(&d[0][1]).norm() * (u.high - u.low) * (v.high - v.low);
            area.is_nan() || area <= FLAT * size * size
        })
    }

    /// Returns `true` if the rim at an end of `direction` is a point: all of its control points are
    /// equal.
    fn is_point(&self, direction: usize, end: usize) -> bool {
        let at = |line: &[Point3<f64>]| if end == 0 { line.first() } else { line.last() }.copied();
        let rim: Vec<Point3<f64>> = if direction == 0 {
            let row = if end == 0 { self.points.first() } else { self.points.last() };
            row.cloned().unwrap_or_default()
        } else {
            self.points.iter().filter_map(|row| at(row)).collect()
        };
        let size = net_size(&self.patches);
        rim.first().is_some_and(|p| rim.iter().all(|q| (q - p).norm() <= SEAM * size))
    }

    /// Returns `true` if the rims across `direction` meet with equal first derivatives.
    fn closes(&self, direction: usize) -> bool {
        let Interval { low, high } = self.knots[direction].range();
        let size = net_size(&self.patches);
        let at = |x: f64, y: f64| {
            let [u, v] = if direction == 0 { [x, y] } else { [y, x] };
            let d = self.table::<1>(u, v);
            (d[0][0], if direction == 0 { d[1][0] } else { d[0][1] })
        };
        self.rim(direction).all(|y| {
            let ((s0, d0), (s1, d1)) = (at(low, y), at(high, y));
            // Tangents by the length they cover over the whole range, in mm as the points are.
            (s1 - s0).norm() <= SEAM * size
                && (d1 - d0).norm() * (high - low) <= SEAM * size.max(d0.norm() * (high - low))
        })
    }
}

/// Returns the largest value of a function with one maximum between the bounds.
fn peak(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    // 2/3 of the range are left after a step: 1e-9 after 50.
    for _ in 0..50 {
        let third = (high - low) / 3.0;
        if f(low + third) < f(high - third) { low += third } else { high -= third }
    }
    f(0.5 * (low + high))
}
