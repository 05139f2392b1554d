//! Guaranteed bounds of curvature over a piece of a patch, from derivative control nets.

use super::jet::SurfaceJet2;
use super::nurbs::BezierPatch;
use super::nurbs::NurbsSurface;
use super::parameter_box::ParameterBox;
use super::patches::hull_box;
use crate::math;
use crate::math::bspline::binomial;
use crate::types::Interval;
use nalgebra::Vector3;
use nalgebra::Vector4;

type HomogeneousPoint = Vector4<f64>;

/// Vectors within `radius` of `centre`, and within `height` of it along the normal.
#[derive(Debug, Clone, Copy)]
struct DerivativeBall {
    centre: Vector3<f64>,
    radius: f64,
    height: f64,
}

/// Part of a Bezier patch with a bound of its curvatures.
pub(super) struct PatchCell {
    net: ControlNet,
    pub(super) bounds: ParameterBox,
    /// Curvatures of mean derivatives, and the largest deviation of others in the cell.
    range: [f64; 2],
    spread: f64,
    /// Upper bound on the rate of normal curvature \[1/mm^2\].
    rate: f64,
}

/// Homogeneous control points, v running fastest, over the unit square.
#[derive(Clone)]
struct ControlNet {
    points: Vec<Vector4<f64>>,
    columns: usize,
}

impl PatchCell {
    pub(super) fn of_patch(patch: &BezierPatch<'_>, degree: usize) -> Self {
        Self::new(ControlNet { points: patch.points.to_vec(), columns: degree + 1 }, patch.bounds)
    }

    fn new(net: ControlNet, bounds: ParameterBox) -> Self {
        // Without a bound on the turn of the tangents in the cell there is none on curvature.
        let (range, spread, rate) =
            net.curvatures().unwrap_or(([0.0; 2], f64::INFINITY, f64::INFINITY));
        Self { net, bounds, range, spread, rate }
    }

    /// Returns the halves across the direction in which the derivatives vary more.
    pub(super) fn halves(&self) -> [Self; 2] {
        let [by_u, by_v] = self.net.variation();
        let k = usize::from(by_v > by_u);
        let (mut low, mut high) = (self.bounds, self.bounds);
        let middle = low[k].middle();
        (low[k].high, high[k].low) = (middle, middle);
        let (first, second) = self.net.split(k, 0.5);
        [Self::new(first, low), Self::new(second, high)]
    }

    /// Returns the box of its control points, and so of its points: low and high corner.
    pub(super) fn hull(&self) -> [Vector3<f64>; 2] {
        let (low, high) = hull_box(&self.net.points);
        [low, high]
    }

    /// Returns a range that no normal curvature in the cell leaves; at most 0, at least 0.
    pub(super) fn bound(&self) -> Interval {
        Interval::from(self.range).widened(self.spread)
    }

    /// Returns the largest value of `|d II (t, t, t)|` in the cell for unit tangents `t`: of the
    /// covariant derivative of the second fundamental form \[1/mm^2\]. Infinite where weights
    /// differ.
    pub(super) fn rate(&self) -> f64 {
        self.rate
    }

    /// Returns upper bounds of `|S_u|`, `|S_v|`, `|S_uu|`, `|S_uv|`, `|S_vv|` over the unit square.
    pub(super) fn derivatives(&self) -> Option<[f64; 5]> {
        Some(self.net.derivatives()?.map(|ball| ball.reach()))
    }

    /// Returns the curvatures in the middle, likewise.
    pub(super) fn attained(&self, surface: &NurbsSurface) -> Interval {
        let [u, v] = self.bounds.map(|range| range.middle());
        let curvature = surface.jet2(u, v).curvature();
        curvature.map_or(Interval::point(0.0), |curvature| {
            Interval::new(curvature.min.min(0.0), curvature.max.max(0.0))
        })
    }
}

impl ControlNet {
    fn rows(&self) -> usize {
        self.points.len() / self.columns
    }

    /// Splits by de Casteljau at `t` by parameter `k`.
    fn split(&self, k: usize, t: f64) -> (Self, Self) {
        let (lines, count) =
            if k == 0 { (self.columns, self.rows()) } else { (self.rows(), self.columns) };
        let (step, stride) = if k == 0 { (1, self.columns) } else { (self.columns, 1) };
        let (mut low, mut high) = (self.clone(), self.clone());
        for line in 0..lines {
            let at = |i: usize| line * step + i * stride;
            for level in 0..count {
                low.points[at(level)] = high.points[at(0)];
                for i in 0..count - 1 - level {
                    let (a, b) = (high.points[at(i)], high.points[at(i + 1)]);
                    high.points[at(i)] = a * (1.0 - t) + b * t;
                }
            }
        }
        (low, high)
    }

    /// Returns the control net of the derivative by parameter `k`; empty for degree 0.
    fn differences(&self, k: usize) -> Self {
        let rows = self.rows();
        let (m, n) =
            if k == 0 { (rows.saturating_sub(1), self.columns) } else { (rows, self.columns - 1) };
        let degree = if k == 0 { m } else { n } as f64;
        let step = if k == 0 { self.columns } else { 1 };
        let mut points = Vec::with_capacity(m * n);
        for i in 0..m {
            for j in 0..n {
                let at = i * self.columns + j;
                points.push((self.points[at + step] - self.points[at]) * degree);
            }
        }
        Self { points, columns: n.max(1) }
    }

    /// Returns the variation of first and second derivatives by parameters 0 and 1, relative to the
    /// first.
    fn variation(&self) -> [f64; 2] {
        let size = |net: &Self| net.points.iter().map(Vector4::norm).fold(0.0, f64::max);
        let (u, v) = (self.numerator(0), self.numerator(1));
        let (a, b) = (size(&u), size(&v));
        // N_uu, N_uv, N_vv, N_u and N_v, each with the size that its change is relative to.
        let both = [
            (u.differences(0), a),
            (u.differences(1), a.max(b)),
            (v.differences(1), b),
            (u, a),
            (v, b),
        ];
        let change = |k: usize| {
            let share = |(net, whole): &(Self, f64)| match size(&net.differences(k)) {
                change if *whole > 0.0 => change / whole,
                _ => 0.0,
            };
            both.iter().map(share).sum::<f64>()
        };
        [change(0), change(1)]
    }

    /// Returns the mean of all vectors of a derivative net; zero for an empty one.
    fn middle(&self) -> Vector3<f64> {
        let count = self.points.len().max(1) as f64;
        self.points.iter().map(Vector4::xyz).sum::<Vector3<f64>>() / count
    }

    /// Returns a ball round all vectors of a derivative net, `normal` being the direction of its
    /// height.
    fn ball(&self, normal: &Vector3<f64>) -> DerivativeBall {
        let centre = self.middle();
        let off = || self.points.iter().map(|p| p.xyz() - centre);
        let radius = off().map(|d| d.norm()).fold(0.0, f64::max);
        let height = off().map(|d| d.dot(normal).abs()).fold(0.0, f64::max);
        DerivativeBall { centre, radius, height }
    }

    /// Returns middle and half width of an interval around `2 w_k / w`, of the net of a weight's
    /// derivative and the range of the weight itself.
    fn pace(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let rates = || self.points.iter().map(|p| 2.0 * p.w);
        // w_k / w is least for the least w_k: over the lowest weight if negative, else over the
        // highest.
        let least = rates().map(|x| if x < 0.0 { x / low } else { x / high }).reduce(f64::min);
        let most = rates().map(|x| if x > 0.0 { x / low } else { x / high }).reduce(f64::max);
        let (least, most) = (least.unwrap_or(0.0), most.unwrap_or(0.0));
        [0.5 * (least + most), 0.5 * (most - least)]
    }

    /// Returns the net of `A_k w - A w_k`: the numerator of `S_k`, of degree `2p` or `2p - 1`.
    /// Unlike `A_k` and `w_k S` apart it does not depend on where the origin is.
    fn numerator(&self, k: usize) -> Self {
        let d = self.differences(k);
        // Quotient rule: S_k = (A_k w - A w_k) / w^2.
        let up = d.times(self, |d, p| (d.xyz() * p.w).push(0.0));
        let down = d.times(self, |d, p| (p.xyz() * d.w).push(0.0));
        let points = up.points.iter().zip(&down.points).map(|(a, b)| a - b).collect();
        Self { points, columns: up.columns }
    }

    /// Returns the Bernstein form of a product: `c_k = sum C(m,i) C(n,j) / C(m+n,k) a_i b_j`,
    /// `i + j = k`, by both parameters.
    fn times(
        &self,
        other: &Self,
        product: impl Fn(&HomogeneousPoint, &HomogeneousPoint) -> HomogeneousPoint,
    ) -> Self {
        let (m, n) = ([self.rows(), self.columns], [other.rows(), other.columns]);
        let columns = m[1] + n[1] - 1;
        let rows = m[0] + n[0] - 1;
        let mut points = vec![Vector4::zeros(); rows * columns];
        // The factor of a pair of points is a product of one by each parameter: two small tables.
        let shares = [0, 1].map(|k| product_shares(m[k], n[k]));
        for i in 0..m[0] {
            for j in 0..m[1] {
                let x = &self.points[i * m[1] + j];
                for k in 0..n[0] {
                    let share = shares[0][i * n[0] + k];
                    let ys = &other.points[k * n[1]..(k + 1) * n[1]];
                    let by_v = &shares[1][j * n[1]..(j + 1) * n[1]];
                    let sums = &mut points[(i + k) * columns + j..][..n[1]];
                    for ((sum, y), other_share) in sums.iter_mut().zip(ys).zip(by_v) {
                        *sum += product(x, y) * (share * other_share);
                    }
                }
            }
        }
        Self { points, columns }
    }

    /// Returns curvatures `[min or 0, max or 0]` of the shape operator made from the balls'
    /// centres, a bound of its distance from the shape operator anywhere in the cell, and
    /// [`PatchCell::rate`].
    fn curvatures(&self) -> Option<([f64; 2], f64, f64)> {
        let d = self.derivatives()?;
        let [su, sv, suu, suv, svv] = d;
        // Shape operator of the mean derivatives; the point has no part in it.
        let jet = SurfaceJet2 {
            s: nalgebra::Point3::origin(),
            su: su.centre,
            sv: sv.centre,
            suu: suu.centre,
            suv: suv.centre,
            svv: svv.centre,
        };
        let curvature = jet.curvature()?;
        let tangents = TangentBounds::new(&d)?;
        // Weyl's inequality: principal curvatures differ by no more than the operators' distance.
        let spread = tangents.spread(&d);
        let range = [curvature.min.min(0.0), curvature.max.max(0.0)];
        // Largest curvature of either sign in the cell: the rate has a term in proportion to it.
        let most = range[1].max(-range[0]) + spread;
        let rate = self.thirds(&tangents.unit).map(|thirds| tangents.rate(&d, &thirds, most));
        Some((range, spread, rate.unwrap_or(f64::INFINITY)))
    }

    /// Returns balls round `S_uuu, S_uuv, S_uvv, S_vvv`; `None` where weights differ.
    fn thirds(&self, normal: &Vector3<f64>) -> Option<[DerivativeBall; 4]> {
        let mut weights = self.points.iter().map(|p| p.w);
        let weight = weights.next()?;
        if weights.any(|w| (w - weight).abs() > 0.0) {
            return None;
        }
        let [u, v] = [0, 1].map(|k| self.differences(k));
        let (uu, vv) = (u.differences(0), v.differences(1));
        let all = [uu.differences(0), uu.differences(1), vv.differences(0), vv.differences(1)];
        Some(all.map(|net| divide(net.ball(normal), normal, [weight; 2])))
    }

    /// Returns balls round `S_u, S_v, S_uu, S_uv, S_vv`.
    ///
    /// With `N_k` the numerator of `S_k = N_k / w^2`: `S_kl = (N_k)_l / w^2 - 2 w_l S_k / w`.
    fn derivatives(&self) -> Option<[DerivativeBall; 5]> {
        let weights = self.points.iter().map(|p| p.w);
        let (low, high) = weights.fold((f64::INFINITY, 0.0_f64), |(a, b), w| (a.min(w), b.max(w)));
        let [wu, wv] = [0, 1].map(|k| self.differences(k).pace([low, high]));
        // Equal weights cancel: derivatives are then those of a polynomial, of half the degree.
        let plain = [wu, wv].iter().all(|[middle, spread]| middle.abs() + spread <= 0.0);
        let [u, v] = [0, 1].map(|k| if plain { self.differences(k) } else { self.numerator(k) });
        // N_k is divided by w^2, the derivative of a polynomial by the one weight.
        let range = if plain { [low, high] } else { [low * low, high * high] };
        // Heights count from the tangent plane of the mean derivatives.
        let normal = u.middle().cross(&v.middle()).try_normalize(f64::MIN_POSITIVE)?;
        let ball = |net: &Self| divide(net.ball(&normal), &normal, range);
        let (su, sv) = (ball(&u), ball(&v));
        // The middle of 2 w_l / w moves the centre, its half width widens the ball.
        let second = |net: Self, [middle, spread]: [f64; 2], first: &DerivativeBall| {
            let DerivativeBall { centre, radius, height } = ball(&net);
            DerivativeBall {
                centre: centre - first.centre * middle,
                radius: radius + middle.abs() * first.radius + spread * first.reach(),
                height: height + (middle.abs() + spread) * first.height,
            }
        };
        let suu = second(u.differences(0), wu, &su);
        let suv = second(u.differences(1), wv, &su);
        let svv = second(v.differences(1), wv, &sv);
        let all = [su, sv, suu, suv, svv];
        all.iter().all(|ball| ball.reach().is_finite()).then_some(all)
    }
}

impl DerivativeBall {
    /// Returns the largest length in the ball.
    fn reach(&self) -> f64 {
        self.centre.norm() + self.radius
    }
}

/// Returns a ball round `x / w` for `x` in `ball`, `w` in the range.
fn divide(ball: DerivativeBall, normal: &Vector3<f64>, [low, high]: [f64; 2]) -> DerivativeBall {
    // 1 / w = inverse +- spread: deviations are scaled, and the centre itself adds its share.
    let inverse = 0.5 * (low.recip() + high.recip());
    let spread = 0.5 * (low.recip() - high.recip());
    let grown = |off: f64, centre: f64| off * (inverse + spread) + centre * spread;
    DerivativeBall {
        centre: ball.centre * inverse,
        radius: grown(ball.radius, ball.centre.norm()),
        height: grown(ball.height, ball.centre.dot(normal).abs()),
    }
}

/// Returns `C(m-1,i) C(n-1,j) / C(m+n-2,i+j)` for `m` and `n` points, `j` running fastest.
fn product_shares(m: usize, n: usize) -> Vec<f64> {
    let share = |i, j| binomial(m - 1, i) * binomial(n - 1, j) / binomial(m + n - 2, i + j);
    (0..m).flat_map(|i| (0..n).map(move |j| share(i, j))).collect()
}

/// The tangents of a cell, as columns `J` scaled to unit length at the centres of their balls, so
/// that `|J+| = 1 / sqrt(1 - |cos|)` there.
struct TangentBounds {
    /// Lengths at the centres.
    lengths: [f64; 2],
    /// Normal of the centres.
    unit: Vector3<f64>,
    /// `|J+|` at the centres, and what it is at most anywhere.
    at_centre: f64,
    anywhere: f64,
    /// Upper bound on the change of `J`.
    change: f64,
    /// Upper bound on the length of the normal's change.
    chord: f64,
}

impl TangentBounds {
    /// Bounds the tangents; `None` where they may become parallel. `|J+| <= m / (1 - m d)` for
    /// `|dJ| <= d`, `m = |J+|` at the centres (Wedin, *Perturbation theory for pseudo-inverses*,
    /// 1973).
    fn new([su, sv, ..]: &[DerivativeBall; 5]) -> Option<Self> {
        let (a, b) = (su.centre.norm(), sv.centre.norm());
        // Columns of unit length have the Gram matrix [[1, c], [c, 1]], least eigenvalue 1 - |c|.
        let cosine = su.centre.dot(&sv.centre) / (a * b);
        let at_centre = (1.0 - cosine.abs()).sqrt().recip();
        // Frobenius norm of the largest change of both columns.
        let change = math::hypot(su.radius / a, sv.radius / b);
        let room = 1.0 - at_centre * change;
        let unit = su.centre.cross(&sv.centre).try_normalize(f64::MIN_POSITIVE)?;
        let anywhere = at_centre / room;
        // A unit tangent is J x with |x| <= |J+|; its height over the middle plane is the sine of
        // the normal's turn, and chord = sine / cos(turn/2).
        let sine = anywhere * math::hypot(su.height / a, sv.height / b);
        if !(room > 0.0 && sine < 1.0) {
            return None;
        }
        let chord = sine / (0.5 + 0.5 * (1.0 - sine * sine).sqrt()).sqrt();
        Some(Self { lengths: [a, b], unit, at_centre, anywhere, change, chord })
    }

    /// Bounds the distance between the shape operators `W = J+^T H J+`, `H_ij = n . S_ij`, of the
    /// centres and of any vectors of the balls. By Weyl's inequality no curvature differs by more.
    /// Of other pseudo-inverses, `|dJ+| <= sqrt 2 m |J+| d` (Wedin).
    fn spread(&self, [_, _, suu, suv, svv]: &[DerivativeBall; 5]) -> f64 {
        let Self { lengths: [a, b], at_centre, anywhere, .. } = *self;
        // n . S_ij at the centres; elsewhere n is off by `chord` and S_ij by its height.
        let entry = |s: &DerivativeBall, scale: f64| {
            [self.unit.dot(&s.centre) / scale, (self.chord * s.reach() + s.height) / scale]
        };
        let all = [entry(suu, a * a), entry(suv, a * b), entry(suv, a * b), entry(svv, b * b)];
        let norm = |k: usize| all.iter().map(|entry| entry[k] * entry[k]).sum::<f64>().sqrt();
        let turned = std::f64::consts::SQRT_2 * at_centre * anywhere * self.change;
        // |dW| <= |J+|^2 |dH| + |H| |dJ+| (|J+| + m), all in the Frobenius norm.
        norm(1) * anywhere * anywhere + norm(0) * turned * (anywhere + at_centre)
    }

    /// Bounds the rate of curvature: `(d II)(t, t, t) = n . S_xxx - 3 II(P S_xx, t)` for the unit
    /// tangent `t = J x`, `P` the projection on the tangent plane; curvatures are at most `most`.
    /// Norms of the tensors over `x` are at most Frobenius'.
    fn rate(
        &self,
        [_, _, suu, suv, svv]: &[DerivativeBall; 5],
        thirds: &[DerivativeBall; 4],
        most: f64,
    ) -> f64 {
        let [a, b] = self.lengths;
        let up =
            |s: &DerivativeBall| self.unit.dot(&s.centre).abs() + self.chord * s.reach() + s.height;
        // Part in the tangent plane, which turns with the normal.
        let along = |s: &DerivativeBall| {
            let flat = s.centre - self.unit * self.unit.dot(&s.centre);
            flat.norm() + s.radius + self.chord * s.reach()
        };
        let sum = |terms: &[f64]| terms.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [uuu, uuv, uvv, vvv] = thirds;
        // Mixed entries stand three times, or twice, in the whole tensor.
        let root = 3.0_f64.sqrt();
        let third = sum(&[
            up(uuu) / (a * a * a),
            root * up(uuv) / (a * a * b),
            root * up(uvv) / (a * b * b),
            up(vvv) / (b * b * b),
        ]);
        let root = std::f64::consts::SQRT_2;
        let second =
            sum(&[along(suu) / (a * a), root * along(suv) / (a * b), along(svv) / (b * b)]);
        // |x| <= m: the third derivative takes x three times, P S_xx twice and II is at most
        // `most`.
        let m = self.anywhere;
        m * m * (m * third + 3.0 * most * second)
    }
}
