//! Truncated Taylor arithmetic: a formula written once gives its value and exact derivatives.

use crate::math;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Number of coefficients of a [`Jet`]: value and three derivatives.
pub const ORDERS: usize = 4;

/// Number type of a formula: a plain number or a [`Jet`].
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Add<f64, Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Returns a number that does not vary.
    fn constant(value: f64) -> Self;
    /// Returns the number itself, without derivatives; for decisions only.
    fn value(self) -> f64;
    /// Returns the square root. At zero the derivatives of a jet are infinite or NaN.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Returns the square root of a number that only rounding makes negative: zero there. The
    /// derivatives of a jet are then NaN, unless it does not vary at all.
    #[must_use]
    fn sqrt_clamped(self) -> Self;
    /// Returns the angle of the point (`x`, `self`) \[rad\], in `[-π, π]`.
    #[must_use]
    fn atan2(self, x: Self) -> Self;
    /// Returns sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Returns sine and cosine of the angle of the point (`x`, `self`), at any distance from zero, and
    /// the angle itself \[rad\], in `[-π, π]`.
    #[must_use]
    fn polar(self, x: Self) -> [Self; 3];
}

impl Real for f64 {
    #[inline]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline]
    fn value(self) -> f64 {
        self
    }
    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline]
    fn sqrt_clamped(self) -> Self {
        self.max(0.0).sqrt()
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        math::atan2(self, x)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        math::sin_cos(self)
    }
    #[inline]
    fn polar(self, x: Self) -> [Self; 3] {
        // One square root and one division for sine and cosine; the angle is separate.
        let inverse = 1.0 / (x * x + self * self).sqrt();
        [self * inverse, x * inverse, math::atan2(self, x)]
    }
}

/// `c[0] + c[1] h + c[2] h² + c[3] h³`, cut after the cube: Taylor coefficients of a quantity over
/// a path parameter, `c[k] = f^(k) / k!` \[unit per parameter^k\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet {
    /// Taylor coefficients.
    pub c: [f64; ORDERS],
}

impl Jet {
    /// Creates a jet from value and derivatives.
    #[inline]
    pub fn from_derivatives([f, f1, f2, f3]: [f64; ORDERS]) -> Self {
        Self { c: [f, f1, f2 / 2.0, f3 / 6.0] }
    }

    /// Returns value and derivatives.
    #[inline]
    pub fn derivatives(self) -> [f64; ORDERS] {
        let [f, f1, f2, f3] = self.c;
        [f, f1, 2.0 * f2, 6.0 * f3]
    }

    /// Returns the path parameter itself at `value`.
    pub fn variable(value: f64) -> Self {
        Self { c: [value, 1.0, 0.0, 0.0] }
    }

    /// Returns the derivative by the parameter. The last coefficient is unknown and set to zero.
    #[must_use]
    pub fn derivative(self) -> Self {
        let [_, c1, c2, c3] = self.c;
        Self { c: [c1, 2.0 * c2, 3.0 * c3, 0.0] }
    }

    /// Divides by the parameter's distance `h` from the point of expansion, for a quantity that
    /// vanishes there. The last coefficient is unknown and set to zero.
    #[must_use]
    pub fn deflated(self) -> Self {
        let [_, c1, c2, c3] = self.c;
        Self { c: [c1, c2, c3, 0.0] }
    }

    /// Multiplies by `h`: undoes [`Jet::deflated`].
    #[must_use]
    pub fn inflated(self) -> Self {
        let [c0, c1, c2, _] = self.c;
        Self { c: [0.0, c0, c1, c2] }
    }

    /// Returns the jet whose derivative has coefficients `d` and whose value is `value`.
    #[inline]
    fn integral(value: f64, d: [f64; 3]) -> Self {
        Self { c: [value, d[0], d[1] / 2.0, d[2] / 3.0] }
    }

    /// Returns the coefficients of the derivative.
    #[inline]
    fn rate(self) -> [f64; 3] {
        [self.c[1], 2.0 * self.c[2], 3.0 * self.c[3]]
    }

    /// Returns the coefficients of the derivative of `atan2(self, x)`, from `w' = (x y' - y x') / (x² + y²)`.
    #[inline]
    fn turning(self, x: Self) -> [f64; 3] {
        let y = self;
        let ([x0, x1, x2, _], [y0, y1, y2, _]) = (x.c, y.c);
        let ([dx0, dx1, dx2], [dy0, dy1, dy2]) = (x.rate(), y.rate());
        // Numerator and, below, denominator as Cauchy products.
        let n0 = x0 * dy0 - y0 * dx0;
        let n1 = x0 * dy1 + x1 * dy0 - y0 * dx1 - y1 * dx0;
        let n2 = x0 * dy2 + x1 * dy1 + x2 * dy0 - y0 * dx2 - y1 * dx1 - y2 * dx0;
        let inverse = 1.0 / (x0 * x0 + y0 * y0);
        let m1 = 2.0 * (x0 * x1 + y0 * y1);
        let m2 = 2.0 * (x0 * x2 + y0 * y2) + x1 * x1 + y1 * y1;
        // The quotient, coefficient by coefficient.
        let w0 = n0 * inverse;
        let w1 = (n1 - w0 * m1) * inverse;
        [w0, w1, (n2 - w0 * m2 - w1 * m1) * inverse]
    }

    /// Returns sine and cosine of an angle from their values and the coefficients of the angle's derivative:
    /// `sin' = cos · a'` and `cos' = -sin · a'`.
    #[inline]
    fn turned([s0, c0]: [f64; 2], [d0, d1, d2]: [f64; 3]) -> [Self; 2] {
        // Coefficient k of each is 1/k of coefficient k - 1 of the product of the other and `a'`.
        let (s1, c1) = (c0 * d0, -s0 * d0);
        let (s2, c2) = (0.5 * (c0 * d1 + c1 * d0), -0.5 * (s0 * d1 + s1 * d0));
        let s3 = (c0 * d2 + c1 * d1 + c2 * d0) / 3.0;
        let c3 = -(s0 * d2 + s1 * d1 + s2 * d0) / 3.0;
        [Self { c: [s0, s1, s2, s3] }, Self { c: [c0, c1, c2, c3] }]
    }
}

impl Add for Jet {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.c, other.c);
        Self { c: [a + e, b + f, c + g, d + h] }
    }
}

impl Add<f64> for Jet {
    type Output = Self;
    #[inline]
    fn add(self, other: f64) -> Self {
        let [a, b, c, d] = self.c;
        Self { c: [a + other, b, c, d] }
    }
}

impl Sub for Jet {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.c, other.c);
        Self { c: [a - e, b - f, c - g, d - h] }
    }
}

impl Neg for Jet {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { c: self.c.map(|c| -c) }
    }
}

impl Mul<f64> for Jet {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self { c: self.c.map(|c| c * factor) }
    }
}

impl Mul for Jet {
    type Output = Self;
    /// Multiplies by the Cauchy product.
    #[inline]
    fn mul(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.c, other.c);
        Self { c: [a * e, a * f + b * e, a * g + b * f + c * e, a * h + b * g + c * f + d * e] }
    }
}

impl Div for Jet {
    type Output = Self;
    /// Divides by `quotient * other = self`, coefficient by coefficient.
    #[inline]
    fn div(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.c, other.c);
        // Coefficient k of q * other is c_k: each gives the next q_k.
        let inverse = 1.0 / e;
        let q0 = a * inverse;
        let q1 = (b - q0 * f) * inverse;
        let q2 = (c - q0 * g - q1 * f) * inverse;
        let q3 = (d - q0 * h - q1 * g - q2 * f) * inverse;
        Self { c: [q0, q1, q2, q3] }
    }
}

impl Real for Jet {
    #[inline]
    fn constant(value: f64) -> Self {
        Self { c: [value, 0.0, 0.0, 0.0] }
    }

    #[inline]
    fn value(self) -> f64 {
        self.c[0]
    }

    /// Solves `root² = self`, coefficient by coefficient.
    #[inline]
    fn sqrt(self) -> Self {
        let [a, b, c, d] = self.c;
        let r0 = a.sqrt();
        // Coefficient k of r² is 2 r0 r_k plus the products of those between.
        let half = 0.5 / r0;
        let r1 = b * half;
        let r2 = (c - r1 * r1) * half;
        let r3 = (d - 2.0 * r1 * r2) * half;
        Self { c: [r0, r1, r2, r3] }
    }

    #[inline]
    fn sqrt_clamped(self) -> Self {
        let [a, rest @ ..] = self.c;
        if a > 0.0 {
            return self.sqrt();
        }
        // A root that rounding clamps has no derivatives, except that of a constant.
        let still = rest.iter().all(|c| c.abs() <= 0.0);
        let [b, c, d] = [if still { 0.0 } else { f64::NAN }; 3];
        Self { c: [0.0, b, c, d] }
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        // The derivative is rational and has no branches; only the value needs the quadrant.
        Self::integral(math::atan2(self.c[0], x.c[0]), self.turning(x))
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = math::sin_cos(self.c[0]);
        let [sin, cos] = Self::turned([sin, cos], self.rate());
        (sin, cos)
    }

    /// Derives sine and cosine from the angle's derivative, without square root and division of jets.
    #[inline]
    fn polar(self, x: Self) -> [Self; 3] {
        let [sin, cos, angle] = self.c[0].polar(x.c[0]);
        let turning = self.turning(x);
        let [sin, cos] = Self::turned([sin, cos], turning);
        [sin, cos, Self::integral(angle, turning)]
    }
}

/// Derivatives `[q', q'', q''']` by arc length `σ` from those by a parameter `u`, where `tip` holds
/// the tip's derivatives `[P_u, P_uu, P_uuu]`: `t`, `K` and `L` of `docs/sources.md#000`.
/// `None` where the tip stands still.
pub fn by_arc_length<const N: usize>(
    q: [nalgebra::SVector<f64, N>; 3],
    tip: [nalgebra::Vector3<f64>; 3],
) -> Option<[nalgebra::SVector<f64, N>; 3]> {
    let ([q1, q2, q3], [p1, p2, p3]) = (q, tip);
    let sigma = p1.norm();
    // Turning about a tip at rest has no arc length.
    if sigma.is_nan() || sigma <= 0.0 {
        return None;
    }
    // σ = |P_u| = d(arc length)/du, and its first two derivatives by u.
    let dot = p1.dot(&p2);
    let sigma1 = dot / sigma;
    let sigma2 = (p2.norm_squared() + p1.dot(&p3)) / sigma - dot * dot / sigma.powi(3);
    // The chain rule, inverted: u' = 1/σ, u'' = -σ1/σ³, u''' = 3 σ1²/σ⁵ - σ2/σ⁴.
    let t = q1 / sigma;
    let k = q2 / sigma.powi(2) - q1 * (sigma1 / sigma.powi(3));
    let l = q3 / sigma.powi(3) - q2 * (3.0 * sigma1 / sigma.powi(4))
        + q1 * (3.0 * sigma1.powi(2) / sigma.powi(5) - sigma2 / sigma.powi(4));
    Some([t, k, l])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Jet, b: [f64; 4]) -> bool {
        a.derivatives().iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-13 * b.abs().max(1.0))
    }

    #[test]
    fn derivatives_known_by_heart() {
        let u = Jet::variable(0.7);
        let (s, c) = 0.7_f64.sin_cos();
        assert!(close(u.sin_cos().0, [s, c, -s, -c]));
        assert!(close(u.sin_cos().1, [c, -s, -c, s]));
        assert!(close(u * u * u, [0.343, 3.0 * 0.49, 4.2, 6.0]));
        assert!(close(Jet::variable(4.0).sqrt(), [2.0, 0.25, -1.0 / 32.0, 3.0 / 256.0]));
        let over = Jet::constant(1.0) / Jet::variable(2.0);
        assert!(close(over, [0.5, -0.25, 0.25, -0.375]));
        let (sin, cos) = (u * 3.0).sin_cos();
        assert!(close(sin.atan2(cos), [2.1, 3.0, 0.0, 0.0]));
        let size = u * u + 2.0;
        let [s, c, angle] = (sin * size).polar(cos * size);
        assert!(close(s, sin.derivatives()) && close(c, cos.derivatives()));
        assert!(close(angle, [2.1, 3.0, 0.0, 0.0]));
    }

    #[test]
    fn deflating_divides_by_the_parameter() {
        let quadratic = Jet { c: [0.0, 2.0, 5.0, 0.0] };
        assert_eq!(quadratic.deflated(), Jet { c: [2.0, 5.0, 0.0, 0.0] });
        assert_eq!(quadratic.deflated().inflated(), quadratic);
        assert_eq!(quadratic.derivative(), Jet { c: [2.0, 10.0, 0.0, 0.0] });
    }
}
