//! Points and derivatives of a NURBS surface, and its continuation beyond the domain.

use super::surface::NurbsSurface;
use crate::math::bspline::BasisTable;
use crate::math::bspline::LARGE;
use crate::math::bspline::SMALL;
use crate::math::bspline::bernstein;
use crate::math::bspline::bernstein_values;
use crate::math::bspline::bernstein2;
use crate::math::bspline::fill_bernstein_values;
use crate::math::bspline::piece_of;
use crate::surface::jet::DerivativeTable;
use crate::surface::jet::SurfaceJet2;
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Vector3;
use nalgebra::Vector4;

/// Homogeneous derivatives, first index by u.
type ControlNet = [[Vector4<f64>; 4]; 4];

/// Workspace of the kernel: basis functions by u and by v, and the patch.
struct EvaluationWorkspace<'a, const N: usize> {
    basis: [BasisTable<N>; 2],
    block: &'a [Vector4<f64>],
}

impl NurbsSurface {
    /// Returns the derivatives with total order up to `ORDER`.
    #[inline]
    pub(crate) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        if self.is_small() {
            self.sized_table::<ORDER, SMALL>(u, v)
        } else {
            self.sized_table::<ORDER, LARGE>(u, v)
        }
    }

    /// Returns `true` if the small arrays hold the basis functions of both directions.
    #[inline]
    fn is_small(&self) -> bool {
        self.degree().iter().all(|&degree| degree < SMALL)
    }

    #[inline]
    fn sized_table<const ORDER: usize, const N: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        let ([u, du], [v, dv]) = (self.inside(0, u), self.inside(1, v));
        if du == 0.0 && dv == 0.0 {
            let local = self.local::<N>(u, v, [ORDER, ORDER]);
            let net = contract::<ORDER, N>(&local, self.knots[1].degree());
            if self.rational { quotient::<ORDER>(&net) } else { cartesian(&net, self.patches[0].w) }
        } else {
            self.extended::<ORDER, N>(u, v, [du, dv])
        }
    }

    /// Returns the point: the value of [`NurbsSurface::table`], faster for the usual degrees.
    #[inline]
    pub(crate) fn point(&self, u: f64, v: f64) -> Point3<f64> {
        let ([x, du], [y, dv]) = (self.inside(0, u), self.inside(1, v));
        if du == 0.0 && dv == 0.0 {
            match self.degree() {
                [2, 1] => return self.unrolled_point::<3, 2>(x, y),
                [2, 2] => return self.unrolled_point::<3, 3>(x, y),
                [2, 3] => return self.unrolled_point::<3, 4>(x, y),
                [3, 2] => return self.unrolled_point::<4, 3>(x, y),
                [3, 3] => return self.unrolled_point::<4, 4>(x, y),
                _ if self.is_small() => return self.looped_point::<SMALL>(x, y),
                _ => return self.looped_point::<LARGE>(x, y),
            }
        }
        Point3::from(self.table::<0>(u, v)[0][0])
    }

    /// Evaluates [`NurbsSurface::point`] inside the domain, `N` points a row of a patch at most.
    #[inline]
    fn looped_point<const N: usize>(&self, u: f64, v: f64) -> Point3<f64> {
        let ((i, s, _), (j, t, _)) = (self.place(0, u), self.place(1, v));
        let [p, q] = self.degree();
        let (mut bu, mut bv) = ([0.0; N], [0.0; N]);
        fill_bernstein_values(s, &mut bu[..=p]);
        fill_bernstein_values(t, &mut bv[..=q]);
        let mut sum = Vector4::zeros();
        for (row, weight) in self.block(i, j).chunks_exact(q + 1).zip(&bu) {
            let mut along = Vector4::zeros();
            for (point, weight) in row.iter().zip(&bv) {
                along += point * *weight;
            }
            sum += along * *weight;
        }
        self.divided_point(&sum)
    }

    /// Divides a point by its weight.
    #[inline]
    fn divided_point(&self, sum: &Vector4<f64>) -> Point3<f64> {
        let weight = if self.rational { sum.w } else { self.patches[0].w };
        Point3::from(sum.xyz() * weight.recip())
    }

    /// Evaluates [`NurbsSurface::point`] inside the domain, `M` by `N` points a patch.
    #[inline]
    fn unrolled_point<const M: usize, const N: usize>(&self, u: f64, v: f64) -> Point3<f64> {
        let ((i, s, _), (j, t, _)) = (self.place(0, u), self.place(1, v));
        let (bu, bv) = (bernstein_values::<M>(s), bernstein_values::<N>(t));
        let mut sum = Vector4::zeros();
        for (row, weight) in self.block(i, j).chunks_exact(N).zip(bu) {
            let mut along = Vector4::zeros();
            for (point, weight) in row.iter().zip(bv) {
                along += point * weight;
            }
            sum += along * weight;
        }
        self.divided_point(&sum)
    }

    /// Returns the point and derivatives to order 2: the values of [`NurbsSurface::table`], faster
    /// for the usual degrees.
    #[inline]
    pub(crate) fn jet2(&self, u: f64, v: f64) -> SurfaceJet2 {
        let ([x, du], [y, dv]) = (self.inside(0, u), self.inside(1, v));
        let by = [du, dv];
        match self.degree() {
            [2, 1] => self.unrolled::<3, 2>(x, y, by),
            [2, 2] => self.unrolled::<3, 3>(x, y, by),
            [2, 3] => self.unrolled::<3, 4>(x, y, by),
            [3, 2] => self.unrolled::<4, 3>(x, y, by),
            [3, 3] => self.unrolled::<4, 4>(x, y, by),
            _ if by.iter().any(|x| *x != 0.0) => SurfaceJet2::from_table(&self.table::<2>(u, v)),
            _ if self.is_small() => self.looped::<SMALL>(x, y),
            _ => self.looped::<LARGE>(x, y),
        }
    }

    /// Evaluates [`NurbsSurface::jet2`] at a place of the domain or beyond it by a step, `M` by `N` points a patch.
    #[inline]
    fn unrolled<const M: usize, const N: usize>(
        &self,
        u: f64,
        v: f64,
        by: [f64; 2],
    ) -> SurfaceJet2 {
        let ((i, s, by_u), (j, t, by_v)) = (self.place(0, u), self.place(1, v));
        let (bu, bv) = (bernstein2::<M>(s, by_u), bernstein2::<N>(t, by_v));
        let block = self.block(i, j);
        if by.iter().any(|x| *x != 0.0) {
            // A wide cutter over a small face reads most of its distances here.
            let net = contract_unrolled::<M, N>(block, &bu, &bv);
            return SurfaceJet2::from_table(&self.continued::<2>(&net, by, [2, 2]));
        }
        let (low, high) = (sums::<M, N>(block, 0, &bu, &bv), sums::<M, N>(block, 2, &bu, &bv));
        let whole = |k: usize| Vector4::new(low[k][0], low[k][1], high[k][0], high[k][1]);
        let sums = [0, 1, 2, 3, 4, 5].map(whole);
        self.divided_jet(&sums)
    }

    /// Evaluates [`NurbsSurface::jet2`] at a place of the domain, `N` points a row of a patch at most.
    fn looped<const N: usize>(&self, u: f64, v: f64) -> SurfaceJet2 {
        let local = self.local::<N>(u, v, [2, 2]);
        let [bu, bv] = &local.basis;
        let mut sums = [Vector4::zeros(); 6];
        for (i, row) in local.block.chunks_exact(self.knots[1].degree() + 1).enumerate() {
            // Row by row, as in [`sums`].
            let mut along = [Vector4::zeros(); 3];
            for (j, point) in row.iter().enumerate() {
                along[0] += point * bv[0][j];
                along[1] += point * bv[1][j];
                along[2] += point * bv[2][j];
            }
            sums[0] += along[0] * bu[0][i];
            sums[1] += along[0] * bu[1][i];
            sums[2] += along[1] * bu[0][i];
            sums[3] += along[0] * bu[2][i];
            sums[4] += along[1] * bu[1][i];
            sums[5] += along[2] * bu[0][i];
        }
        self.divided_jet(&sums)
    }

    /// Divides point and derivatives by the weight.
    #[inline]
    fn divided_jet(&self, sums: &[Vector4<f64>; 6]) -> SurfaceJet2 {
        if self.rational {
            return divided(sums);
        }
        // Equal weights: one factor instead of the quotient rule.
        let scale = self.patches[0].w.recip();
        let [s, su, sv, suu, suv, svv] = sums.map(|d| d.xyz() * scale);
        SurfaceJet2 { s: Point3::from(s), su, sv, suu, suv, svv }
    }

    /// Evaluates the continuation by each parameter that lies outside, from the border point
    /// `(u, v)`: the product of both at a corner, so that second derivatives are continuous across
    /// all four lines. Orders above 2 by the parameter that lies outside are not looked at.
    fn extended<const ORDER: usize, const N: usize>(
        &self,
        u: f64,
        v: f64,
        by: [f64; 2],
    ) -> DerivativeTable {
        // A continuation needs value and two derivatives at the rim, whatever order is asked of it.
        let orders = by.map(|x| if x == 0.0 { ORDER } else { 2 });
        let local = self.local::<N>(u, v, orders);
        let net = contract_all(&local, self.knots[1].degree(), orders);
        self.continued::<ORDER>(&net, by, orders)
    }

    /// Continues derivatives at the border, up to the orders by u and v, beyond it.
    #[inline]
    fn continued<const ORDER: usize>(
        &self,
        net: &ControlNet,
        by: [f64; 2],
        orders: [usize; 2],
    ) -> DerivativeTable {
        let mut d = if self.rational {
            quotient_all(net, orders)
        } else {
            cartesian(net, self.patches[0].w)
        };
        let [du, dv] = by;
        let along = |k: usize| self.beyond[k][usize::from(by[k] > 0.0)];
        // By u for every derivative by v, then by v for every derivative by u of the result.
        if du != 0.0 {
            let along_u = along(0);
            for l in 0..=orders[1] {
                let column = along_u.at([d[0][l], d[1][l], d[2][l], d[3][l]], du);
                for (row, value) in d.iter_mut().zip(column) {
                    row[l] = value;
                }
            }
        }
        if dv != 0.0 {
            let along_v = along(1);
            for row in d.iter_mut().take(ORDER + 1) {
                *row = along_v.at(*row, dv);
            }
        }
        d
    }

    /// Returns the piece of a parameter, the parameter within it, in \[0, 1\], and the rate of that by the surface's.
    #[inline]
    fn place(&self, direction: usize, x: f64) -> (usize, f64, f64) {
        let breaks = self.knots[direction].breaks();
        let piece = piece_of(breaks, x);
        let [a, b] = [breaks[piece], breaks[piece + 1]];
        let rate = (b - a).recip();
        (piece, (x - a) * rate, rate)
    }

    /// Returns the parameter inside the range, and the signed distance of the given one outside.
    #[inline]
    fn inside(&self, direction: usize, x: f64) -> [f64; 2] {
        let Interval { low, high } = self.knots[direction].range();
        if self.closed[direction] && !(low..=high).contains(&x) && x.is_finite() {
            // The sum may be rounded to beyond the end.
            return [(low + (x - low).rem_euclid(high - low)).clamp(low, high), 0.0];
        }
        let nearest = x.clamp(low, high);
        [nearest, x - nearest]
    }

    #[inline]
    fn local<const N: usize>(
        &self,
        u: f64,
        v: f64,
        order: [usize; 2],
    ) -> EvaluationWorkspace<'_, N> {
        let at = |direction: usize, x: f64| {
            let (piece, t, rate) = self.place(direction, x);
            (piece, bernstein(self.knots[direction].degree(), t, rate, order[direction]))
        };
        let ((i, bu), (j, bv)) = (at(0, u), at(1, v));
        EvaluationWorkspace { basis: [bu, bv], block: self.block(i, j) }
    }
}

/// Sums coordinates `k` and `k + 1` of point, `u`, `v`, `uu`, `uv`, `vv` derivative: two at a time,
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
        // Row by row: sums over v to order 2, then their products with the functions of u.
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
fn contract<const ORDER: usize, const N: usize>(
    local: &EvaluationWorkspace<'_, N>,
    q: usize,
) -> ControlNet {
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
            // Orders k by u and l by v with k + l <= ORDER.
            for l in 0..=ORDER - k {
                out[k][l] += sums[l] * bu[k][i];
            }
        }
    }
    out
}

/// Sums as [`contract_all`] does to order 2 by each parameter, in loops that unroll.
#[inline]
fn contract_unrolled<const M: usize, const N: usize>(
    block: &[Vector4<f64>],
    bu: &[[f64; M]; 3],
    bv: &[[f64; N]; 3],
) -> ControlNet {
    let mut out = [[Vector4::zeros(); 4]; 4];
    for (row, i) in block.chunks_exact(N).zip(0..M) {
        let mut sums = [Vector4::zeros(); 3];
        for (point, j) in row.iter().zip(0..N) {
            for l in 0..3 {
                sums[l] += point * bv[l][j];
            }
        }
        for k in 0..3 {
            for l in 0..3 {
                out[k][l] += sums[l] * bu[k][i];
            }
        }
    }
    out
}

/// Sums as [`contract`] does, all derivatives up to the order given by each parameter.
#[inline]
fn contract_all<const N: usize>(
    local: &EvaluationWorkspace<'_, N>,
    q: usize,
    [by_u, by_v]: [usize; 2],
) -> ControlNet {
    let [bu, bv] = &local.basis;
    let mut out = [[Vector4::zeros(); 4]; 4];
    for (i, row) in local.block.chunks_exact(q + 1).enumerate() {
        let mut sums = [Vector4::zeros(); 4];
        for (j, point) in row.iter().enumerate() {
            for l in 0..=by_v.min(3) {
                sums[l] += point * bv[l][j];
            }
        }
        for k in 0..=by_u.min(3) {
            for l in 0..=by_v.min(3) {
                out[k][l] += sums[l] * bu[k][i];
            }
        }
    }
    out
}

/// Returns the derivatives of a net whose weights are all `weight`.
#[inline]
fn cartesian(net: &ControlNet, weight: f64) -> DerivativeTable {
    let scale = weight.recip();
    // Loops: a map over both calls for every entry.
    let mut table = [[Vector3::zeros(); 4]; 4];
    for (to, row) in table.iter_mut().zip(net) {
        for (to, d) in to.iter_mut().zip(row) {
            *to = d.xyz() * scale;
        }
    }
    table
}

const BINOMIAL: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 2.0, 1.0, 0.0], [1.0, 3.0, 3.0, 1.0]];

/// Applies Leibniz' rule to `A = w S`, solved for the derivatives of `S` with total order up to
/// `ORDER`.
#[inline]
fn quotient<const ORDER: usize>(net: &ControlNet) -> DerivativeTable {
    let mut s = [[Vector3::zeros(); 4]; 4];
    let over = net[0][0].w.recip();
    for k in 0..=ORDER {
        for l in 0..=ORDER - k {
            s[k][l] = leibniz(net, &s, [k, l]) * over;
        }
    }
    s
}

/// Divides as [`quotient`] does, all derivatives up to the order given by each parameter.
#[inline]
fn quotient_all(net: &ControlNet, [by_u, by_v]: [usize; 2]) -> DerivativeTable {
    let mut s = [[Vector3::zeros(); 4]; 4];
    let over = net[0][0].w.recip();
    for k in 0..=by_u.min(3) {
        for l in 0..=by_v.min(3) {
            s[k][l] = leibniz(net, &s, [k, l]) * over;
        }
    }
    s
}

/// Returns `w S_kl` from the derivatives of lower order.
#[inline]
fn leibniz(net: &ControlNet, s: &DerivativeTable, [k, l]: [usize; 2]) -> Vector3<f64> {
    // A_kl = sum C(k, i) C(l, j) w_ij S_(k-i)(l-j); the term i = j = 0 is the one looked for.
    let mut rest = net[k][l].xyz();
    for i in 0..=k {
        for j in 0..=l {
            if i + j > 0 {
                let weight = BINOMIAL[k][i] * BINOMIAL[l][j] * net[i][j].w;
                rest -= s[k - i][l - j] * weight;
            }
        }
    }
    rest
}

/// Applies Leibniz' rule, written out to order 2, bit for bit as [`quotient`] does:
/// `A, A_u, A_v, A_uu, A_uv, A_vv`.
#[inline]
fn divided(net: &[Vector4<f64>; 6]) -> SurfaceJet2 {
    let [a, au, av, auu, auv, avv] = net;
    let over = a.w.recip();
    let s = a.xyz() * over;
    let su = (au.xyz() - s * au.w) * over;
    let sv = (av.xyz() - s * av.w) * over;
    let suu = (auu.xyz() - su * (2.0 * au.w) - s * auu.w) * over;
    let suv = (auv.xyz() - su * av.w - sv * au.w - s * auv.w) * over;
    let svv = (avv.xyz() - sv * (2.0 * av.w) - s * avv.w) * over;
    SurfaceJet2 { s: Point3::from(s), su, sv, suu, suv, svv }
}

/// Applies Leibniz' rule to a curve, to order 3.
#[inline]
pub(crate) fn curve_quotient([a, b, c, d]: &[Vector4<f64>; 4]) -> [Vector3<f64>; 4] {
    let over = a.w.recip();
    let s = a.xyz() * over;
    let first = (b.xyz() - s * b.w) * over;
    let second = (c.xyz() - first * (2.0 * b.w) - s * c.w) * over;
    let third = (d.xyz() - second * (3.0 * b.w) - first * (3.0 * c.w) - s * d.w) * over;
    [s, first, second, third]
}
