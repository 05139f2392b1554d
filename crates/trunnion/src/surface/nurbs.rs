//! Tensor-product NURBS surfaces, evaluated from their Bezier patches.

use super::beyond::Beyond;
use super::error::SurfaceError;
use super::jet::SurfaceJet2;
use super::jet::Table;
use crate::math::bspline::Basis;
use crate::math::bspline::KnotVector;
use crate::math::bspline::bernstein;
use crate::math::bspline::bernstein2;
use crate::math::bspline::piece_of;
use nalgebra::Point3;
use nalgebra::Vector3;
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
    knots: [KnotVector; 2],
    points: Vec<Vec<Point3<f64>>>,
    weights: Option<Vec<Vec<f64>>>,
    /// `(w x, w y, w z, w)`; patch after patch, v running fastest over patches and within them.
    patches: Vec<Vector4<f64>>,
    rational: bool,
    closed: [bool; 2],
    /// Continuation below and above the range, by u and v.
    beyond: [[Beyond; 2]; 2],
}

/// One Bezier patch: control points `(w x, w y, w z, w)`, v running fastest, and its rectangle.
#[derive(Debug, Clone, Copy)]
pub struct Patch<'a> {
    /// Control points, `(p + 1)(q + 1)`.
    pub points: &'a [Vector4<f64>],
    /// Ranges of u and v.
    pub bounds: [[f64; 2]; 2],
}

/// Where the kernel works: basis functions by u and by v, and the patch.
struct Local<'a> {
    basis: [Basis; 2],
    block: &'a [Vector4<f64>],
}

impl NurbsSurface {
    /// Checks and converts a control net. `weights`, where given, has the shape of `points`.
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
    ) -> Result<Self, Vec<SurfaceError>> {
        let mut faults = net_faults(&points, weights.as_deref());
        let columns = points.first().map_or(0, Vec::len);
        let [u, v] = knots;
        let u = KnotVector::new(degree[0], points.len(), u);
        let v = KnotVector::new(degree[1], columns, v);
        let (u, v) = match (u, v) {
            (Ok(u), Ok(v)) if faults.is_empty() => (u, v),
            (u, v) => {
                for (direction, knots) in [("u", u), ("v", v)] {
                    let errors = knots.err().unwrap_or_default();
                    let named = |error| SurfaceError::Knots { direction, error };
                    faults.extend(errors.into_iter().map(named));
                }
                return Err(faults);
            }
        };
        let rational =
            weights.as_ref().is_some_and(|rows| !all_equal(rows.iter().flatten().copied()));
        let patches = bezier_patches(&[&u, &v], &homogeneous(&points, weights.as_deref()));
        let knots = [u, v];
        let beyond = [[Beyond::with(0.0); 2]; 2];
        let closed = [false; 2];
        let mut surface = Self { knots, points, weights, patches, rational, closed, beyond };
        let flat = surface.degenerate_patches();
        if !flat.is_empty() {
            return Err(flat);
        }
        surface.closed = [surface.closes(0), surface.closes(1)];
        surface.beyond = [0, 1].map(|k| [surface.continuation(k, 0), surface.continuation(k, 1)]);
        Ok(surface)
    }

    /// Degrees by u and v.
    pub fn degree(&self) -> [usize; 2] {
        [self.knots[0].degree(), self.knots[1].degree()]
    }

    /// Knot vectors by u and v.
    pub fn knots(&self) -> &[KnotVector; 2] {
        &self.knots
    }

    /// Control points, `points[i][j]` with `i` along u.
    pub fn points(&self) -> &[Vec<Point3<f64>>] {
        &self.points
    }

    /// Weights as given.
    pub fn weights(&self) -> Option<&[Vec<f64>]> {
        self.weights.as_deref()
    }

    /// Whether the weights differ.
    pub fn is_rational(&self) -> bool {
        self.rational
    }

    /// Ranges of u and v.
    pub fn domain(&self) -> [[f64; 2]; 2] {
        [self.knots[0].range(), self.knots[1].range()]
    }

    /// Period by u and v where opposite rims meet with equal tangents.
    pub fn periods(&self) -> [Option<f64>; 2] {
        let [u, v] = self.domain();
        [self.closed[0].then(|| u[1] - u[0]), self.closed[1].then(|| v[1] - v[0])]
    }

    /// Number of Bezier patches along u and v.
    pub fn patch_count(&self) -> [usize; 2] {
        [self.knots[0].breaks().len() - 1, self.knots[1].breaks().len() - 1]
    }

    /// The Bezier patch in column `i` (along u), row `j`; `None` beyond the last.
    pub fn patch(&self, i: usize, j: usize) -> Option<Patch<'_>> {
        let [columns, rows] = self.patch_count();
        if i >= columns || j >= rows {
            return None;
        }
        let [u, v] = [self.knots[0].breaks(), self.knots[1].breaks()];
        let bounds = [[u[i], u[i + 1]], [v[j], v[j + 1]]];
        Some(Patch { points: self.block(i, j), bounds })
    }

    fn block(&self, i: usize, j: usize) -> &[Vector4<f64>] {
        let [p, q] = self.degree();
        let size = (p + 1) * (q + 1);
        let first = (i * (self.knots[1].breaks().len() - 1) + j) * size;
        &self.patches[first..first + size]
    }

    /// Derivatives with total order up to `ORDER`.
    #[inline]
    pub(crate) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> Table {
        let ([u, du], [v, dv]) = (self.inside(0, u), self.inside(1, v));
        if du == 0.0 && dv == 0.0 {
            let local = self.local(u, v, [ORDER, ORDER]);
            let net = contract::<ORDER>(&local, self.knots[1].degree());
            if self.rational {
                quotient(&net, ORDER, ORDER)
            } else {
                cartesian(&net, self.patches[0].w)
            }
        } else {
            self.extended(u, v, [du, dv])
        }
    }

    /// Point and derivatives to order 2; what [`NurbsSurface::table`] gives, faster for the usual
    /// polynomial surfaces.
    #[inline]
    pub(crate) fn jet2(&self, u: f64, v: f64) -> SurfaceJet2 {
        let ([x, du], [y, dv]) = (self.inside(0, u), self.inside(1, v));
        if self.rational || du != 0.0 || dv != 0.0 {
            return SurfaceJet2::from_table(&self.table::<2>(u, v));
        }
        match self.degree() {
            [2, 2] => self.unrolled::<3, 3>(x, y),
            [2, 3] => self.unrolled::<3, 4>(x, y),
            [3, 2] => self.unrolled::<4, 3>(x, y),
            [3, 3] => self.unrolled::<4, 4>(x, y),
            _ => SurfaceJet2::from_table(&self.table::<2>(u, v)),
        }
    }

    /// [`NurbsSurface::jet2`] of a polynomial surface inside its domain, `M` by `N` points a patch.
    #[inline]
    fn unrolled<const M: usize, const N: usize>(&self, u: f64, v: f64) -> SurfaceJet2 {
        let at = |direction: usize, x: f64| {
            let breaks = self.knots[direction].breaks();
            let piece = piece_of(breaks, x);
            let [a, b] = [breaks[piece], breaks[piece + 1]];
            let rate = (b - a).recip();
            (piece, (x - a) * rate, rate)
        };
        let ((i, s, by_u), (j, t, by_v)) = (at(0, u), at(1, v));
        let (bu, bv) = (bernstein2::<M>(s, by_u), bernstein2::<N>(t, by_v));
        let block = self.block(i, j);
        let low = sums::<M, N>(block, 0, &bu, &bv);
        let high = sums::<M, N>(block, 2, &bu, &bv);
        let scale = self.patches[0].w.recip();
        let at = |k: usize| Vector3::new(low[k][0], low[k][1], high[k][0]) * scale;
        SurfaceJet2 {
            s: Point3::from(at(0)),
            su: at(1),
            sv: at(2),
            suu: at(3),
            suv: at(4),
            svv: at(5),
        }
    }

    /// Continuation by each parameter that lies outside, from the border point `(u, v)`: the
    /// product of both at a corner, so that second derivatives are continuous across all four
    /// lines.
    #[cold]
    fn extended(&self, u: f64, v: f64, by: [f64; 2]) -> Table {
        let local = self.local(u, v, [3, 3]);
        let net = contract_all(&local, self.knots[1].degree());
        let mut d = quotient(&net, 3, 6);
        let [du, dv] = by;
        let [along_u, along_v] = [0, 1].map(|k| self.beyond[k][usize::from(by[k] > 0.0)]);
        if du != 0.0 {
            for l in 0..4 {
                let column = along_u.at(d.map(|row| row[l]), du);
                for (row, value) in d.iter_mut().zip(column) {
                    row[l] = value;
                }
            }
        }
        if dv != 0.0 {
            d = d.map(|row| along_v.at(row, dv));
        }
        d
    }

    /// Continuation beyond one end (0 low, 1 high) of `direction`, after the place along that rim
    /// where the parametrisation slows down most.
    fn continuation(&self, direction: usize, end: usize) -> Beyond {
        let x = self.knots[direction].range()[end];
        let pace = |y: f64| {
            let [u, v] = if direction == 0 { [x, y] } else { [y, x] };
            let d = self.table::<2>(u, v);
            let slopes = if direction == 0 { [d[1][0], d[2][0]] } else { [d[0][1], d[0][2]] };
            Beyond::pace(slopes, if end == 0 { -1.0 } else { 1.0 })
        };
        let places: Vec<[f64; 2]> = self.rim(direction).map(|y| [y, pace(y)]).collect();
        let largest = (0..places.len()).fold(0.0, |largest: f64, k| {
            let around = [k.saturating_sub(1), k, (k + 1).min(places.len() - 1)];
            let [[low, before], [_, here], [high, after]] = around.map(|k| places[k]);
            let refined = if here >= before.max(after) { peak(pace, [low, high]) } else { here };
            largest.max(here).max(refined)
        });
        Beyond::with(largest)
    }

    /// Places along the rims across `direction`: more of them a piece than a polynomial of the
    /// squared first derivative's degree has zeros.
    fn rim(&self, direction: usize) -> impl Iterator<Item = f64> {
        let across = &self.knots[1 - direction];
        let samples = 2 * across.degree() + 1;
        across.breaks().windows(2).flat_map(move |piece| {
            let (low, width) = (piece[0], piece[1] - piece[0]);
            (0..=samples).map(move |k| low + width * k as f64 / samples as f64)
        })
    }

    /// Parameter inside the range, and how far the given one lies outside.
    #[inline]
    fn inside(&self, direction: usize, x: f64) -> [f64; 2] {
        let [low, high] = self.knots[direction].range();
        if self.closed[direction] && !(low..=high).contains(&x) && x.is_finite() {
            return [(low + (x - low).rem_euclid(high - low)).clamp(low, high), 0.0];
        }
        let nearest = x.clamp(low, high);
        [nearest, x - nearest]
    }

    #[inline]
    fn local(&self, u: f64, v: f64, order: [usize; 2]) -> Local<'_> {
        let at = |direction: usize, x: f64| {
            let breaks = self.knots[direction].breaks();
            let piece = piece_of(breaks, x);
            let [a, b] = [breaks[piece], breaks[piece + 1]];
            let rate = (b - a).recip();
            let t = (x - a) * rate;
            (piece, bernstein(self.knots[direction].degree(), t, rate, order[direction]))
        };
        let ((i, bu), (j, bv)) = (at(0, u), at(1, v));
        Local { basis: [bu, bv], block: self.block(i, j) }
    }

    /// Patches whose points lie on a line or in one point.
    fn degenerate_patches(&self) -> Vec<SurfaceError> {
        let [columns, rows] = self.patch_count();
        let all = (0..columns).flat_map(|i| (0..rows).filter_map(move |j| self.patch(i, j)));
        all.filter(|patch| self.is_degenerate(patch))
            .map(|patch| SurfaceError::DegeneratePatch { u: patch.bounds[0], v: patch.bounds[1] })
            .collect()
    }

    /// `|S_u x S_v|`, a polynomial of bounded degree, vanishes on a whole grid denser than that.
    fn is_degenerate(&self, patch: &Patch<'_>) -> bool {
        let [p, q] = self.degree();
        let [u, v] = patch.bounds;
        let size = net_size(patch.points);
        let (m, n) = (2 * p + 1, 2 * q + 1);
        let mut inner = (0..m).flat_map(|i| (0..n).map(move |j| (i, j)));
        inner.all(|(i, j)| {
            let s = (i as f64 + 0.5) / m as f64;
            let t = (j as f64 + 0.5) / n as f64;
            let d = self.table::<1>(u[0] + s * (u[1] - u[0]), v[0] + t * (v[1] - v[0]));
            let area = d[1][0].cross(&d[0][1]).norm() * (u[1] - u[0]) * (v[1] - v[0]);
            area.is_nan() || area <= FLAT * size * size
        })
    }

    /// Whether the rims across `direction` meet with equal first derivatives.
    fn closes(&self, direction: usize) -> bool {
        let [low, high] = self.knots[direction].range();
        let size = net_size(&self.patches);
        let at = |x: f64, y: f64| {
            let [u, v] = if direction == 0 { [x, y] } else { [y, x] };
            let d = self.table::<1>(u, v);
            (d[0][0], if direction == 0 { d[1][0] } else { d[0][1] })
        };
        self.rim(direction).all(|y| {
            let ((s0, d0), (s1, d1)) = (at(low, y), at(high, y));
            (s1 - s0).norm() <= SEAM * size
                && (d1 - d0).norm() * (high - low) <= SEAM * size.max(d0.norm() * (high - low))
        })
    }
}

/// Largest value of a function with one maximum between the bounds.
fn peak(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    // 2/3 of the range are left after a step: 1e-9 after 50.
    for _ in 0..50 {
        let third = (high - low) / 3.0;
        if f(low + third) < f(high - third) { low += third } else { high -= third }
    }
    f(0.5 * (low + high))
}

/// Coordinates `k` and `k + 1` of point, `u`, `v`, `uu`, `uv`, `vv` derivative: two lanes at a time,
/// so that all sums stay in registers.
#[expect(clippy::inline_always, reason = "called, it spills: jets then take half as long again")]
#[inline(always)]
fn sums<const M: usize, const N: usize>(
    block: &[Vector4<f64>],
    k: usize,
    bu: &[[f64; M]; 3],
    bv: &[[f64; N]; 3],
) -> [[f64; 2]; 6] {
    let add = |sum: &mut [f64; 2], x: [f64; 2], weight: f64| {
        sum[0] += x[0] * weight;
        sum[1] += x[1] * weight;
    };
    let mut sums = [[0.0; 2]; 6];
    for (row, i) in block.chunks_exact(N).zip(0..M) {
        let mut along = [[0.0; 2]; 3];
        for (point, j) in row.iter().zip(0..N) {
            let x = [point[k], point[k + 1]];
            add(&mut along[0], x, bv[0][j]);
            add(&mut along[1], x, bv[1][j]);
            add(&mut along[2], x, bv[2][j]);
        }
        add(&mut sums[0], along[0], bu[0][i]);
        add(&mut sums[1], along[0], bu[1][i]);
        add(&mut sums[2], along[1], bu[0][i]);
        add(&mut sums[3], along[0], bu[2][i]);
        add(&mut sums[4], along[1], bu[1][i]);
        add(&mut sums[5], along[2], bu[0][i]);
    }
    sums
}

/// Sums control points against the basis functions: derivatives with total order up to `ORDER`.
#[inline]
fn contract<const ORDER: usize>(local: &Local<'_>, q: usize) -> [[Vector4<f64>; 4]; 4] {
    let [bu, bv] = &local.basis;
    let mut out = [[Vector4::zeros(); 4]; 4];
    for (i, row) in local.block.chunks_exact(q + 1).enumerate() {
        let mut sums = [Vector4::zeros(); 4];
        for (j, point) in row.iter().enumerate() {
            for l in 0..=ORDER {
                sums[l] += point * bv[l][j];
            }
        }
        for k in 0..=ORDER {
            for l in 0..=ORDER - k {
                out[k][l] += sums[l] * bu[k][i];
            }
        }
    }
    out
}

/// As [`contract`], all derivatives up to order 3 by each parameter.
fn contract_all(local: &Local<'_>, q: usize) -> [[Vector4<f64>; 4]; 4] {
    let [bu, bv] = &local.basis;
    let mut out = [[Vector4::zeros(); 4]; 4];
    for (i, row) in local.block.chunks_exact(q + 1).enumerate() {
        for (j, point) in row.iter().enumerate() {
            for k in 0..4 {
                for l in 0..4 {
                    out[k][l] += point * (bu[k][i] * bv[l][j]);
                }
            }
        }
    }
    out
}

/// Derivatives of a net whose weights are all `weight`.
#[inline]
fn cartesian(net: &[[Vector4<f64>; 4]; 4], weight: f64) -> Table {
    let scale = weight.recip();
    net.map(|row| row.map(|d| d.xyz() * scale))
}

const BINOMIAL: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 2.0, 1.0, 0.0], [1.0, 3.0, 3.0, 1.0]];

/// Leibniz' rule on `A = w S`, solved for the derivatives of `S`, each parameter up to `each` and
/// both together up to `total`.
#[inline]
pub(crate) fn quotient(net: &[[Vector4<f64>; 4]; 4], each: usize, total: usize) -> Table {
    let mut s = [[Vector3::zeros(); 4]; 4];
    let over = net[0][0].w.recip();
    for k in 0..=each.min(3) {
        for l in 0..=each.min(3).min(total.saturating_sub(k)) {
            if k + l > total {
                continue;
            }
            let mut rest = net[k][l].xyz();
            for i in 0..=k {
                for j in 0..=l {
                    if i + j > 0 {
                        let weight = BINOMIAL[k][i] * BINOMIAL[l][j] * net[i][j].w;
                        rest -= s[k - i][l - j] * weight;
                    }
                }
            }
            s[k][l] = rest * over;
        }
    }
    s
}

/// Faults of the net's shape and numbers.
fn net_faults(points: &[Vec<Point3<f64>>], weights: Option<&[Vec<f64>]>) -> Vec<SurfaceError> {
    let columns = points.first().map_or(0, Vec::len);
    let mut faults = Vec::new();
    for (row, line) in points.iter().enumerate() {
        if line.len() != columns {
            let (found, expected) = (line.len(), columns);
            faults.push(SurfaceError::RowLength { what: "points", row, found, expected });
        }
        for (j, point) in line.iter().enumerate() {
            for (axis, value) in point.iter().enumerate().filter(|(_, value)| !value.is_finite()) {
                let what = format!("points[{row}][{j}][{axis}]");
                faults.push(SurfaceError::NotFinite { what, value: *value });
            }
        }
    }
    if let Some(weights) = weights {
        faults.extend(weight_faults(points, weights));
    }
    faults
}

fn weight_faults(points: &[Vec<Point3<f64>>], weights: &[Vec<f64>]) -> Vec<SurfaceError> {
    let mut faults = Vec::new();
    for row in 0..points.len().max(weights.len()) {
        let found = weights.get(row).map_or(0, Vec::len);
        let expected = points.get(row).map_or(0, Vec::len);
        if found != expected {
            faults.push(SurfaceError::RowLength { what: "weights", row, found, expected });
        }
    }
    for (i, row) in weights.iter().enumerate() {
        for (j, &value) in row.iter().enumerate() {
            let place = format!("weights[{i}][{j}]");
            if !value.is_finite() {
                faults.push(SurfaceError::NotFinite { what: place, value });
            } else if value <= 0.0 {
                faults.push(SurfaceError::Weight { place, value });
            }
        }
    }
    faults
}

fn all_equal(mut values: impl Iterator<Item = f64>) -> bool {
    let first = values.next();
    values.all(|value| Some(value) == first)
}

fn homogeneous(
    points: &[Vec<Point3<f64>>],
    weights: Option<&[Vec<f64>]>,
) -> Vec<Vec<Vector4<f64>>> {
    let weight =
        |i: usize, j: usize| weights.and_then(|rows| rows.get(i)?.get(j)).copied().unwrap_or(1.0);
    let row = |(i, line): (usize, &Vec<Point3<f64>>)| {
        let lift = |(j, point): (usize, &Point3<f64>)| {
            let w = weight(i, j);
            (point.coords * w).push(w)
        };
        line.iter().enumerate().map(lift).collect()
    };
    points.iter().enumerate().map(row).collect()
}

/// Bezier form along v of every row, then along u of every column of the result.
fn bezier_patches(knots: &[&KnotVector; 2], net: &[Vec<Vector4<f64>>]) -> Vec<Vector4<f64>> {
    let [u, v] = knots;
    let rows: Vec<Vec<Vector4<f64>>> = net.iter().map(|row| v.bezier(row)).collect();
    let across = rows.first().map_or(0, Vec::len);
    let columns: Vec<Vec<Vector4<f64>>> =
        (0..across).map(|j| u.bezier(&rows.iter().map(|row| row[j]).collect::<Vec<_>>())).collect();
    let [p, q] = [u.degree() + 1, v.degree() + 1];
    let mut patches = Vec::with_capacity(columns.iter().map(Vec::len).sum());
    for i in 0..u.breaks().len() - 1 {
        for j in 0..v.breaks().len() - 1 {
            for k in 0..p {
                patches.extend((0..q).map(|l| columns[j * q + l][i * p + k]));
            }
        }
    }
    patches
}

/// Diagonal of the box of the Cartesian control points.
fn net_size(points: &[Vector4<f64>]) -> f64 {
    let cartesian = || points.iter().map(|point| point.xyz() / point.w);
    let low = cartesian().reduce(|a, b| a.inf(&b));
    let high = cartesian().reduce(|a, b| a.sup(&b));
    low.zip(high).map_or(0.0, |(low, high)| (high - low).norm())
}
