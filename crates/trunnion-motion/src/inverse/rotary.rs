//! Two rotary angles for a tool direction: the spherical triangle.

use crate::machine::ChainGeometry;
use crate::math;
use crate::math::jet::{Jet, Real};
use nalgebra::{UnitVector3, Vector3};

/// Largest error of the sine of an angle computed from dot and cross products of unit vectors: a
/// unit vector is off by half an ulp (2^-53) a component, a product of two by 2^-53 a term, six
/// terms a cross product. Smaller angles cannot be distinguished from zero in `f64`.
pub(super) const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Sine and cosine of a rotary axis, and its angle in `[-π, π]` \[rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotaryAngle<T> {
    /// Sine.
    pub sin: T,
    /// Cosine.
    pub cos: T,
    /// Angle \[rad\].
    pub angle: T,
}

impl<T: Real> RotaryAngle<T> {
    /// Creates it from an angle \[rad\].
    #[inline]
    pub fn from_angle(angle: T) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { sin, cos, angle }
    }

    /// Creates it from the point (`x`, `y`), at any distance from zero.
    #[inline]
    fn of(y: T, x: T) -> Self {
        let [sin, cos, angle] = y.polar(x);
        Self { sin, cos, angle }
    }
}

/// The fixed parts of the spherical triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RotaryTriangle {
    /// Frame of the first rotary: towards `w2`, across, and `w1` itself.
    pub(super) frame: [Vector3<f64>; 3],
    /// `cos a1` and `cos a2`.
    m: f64,
    v: f64,
    /// Cosine and sine of `a1 - a2`, of `a1 + a2`; the sine is zero exactly where it is within
    /// rounding of zero, which is where the pole of that side can be reached.
    difference: [f64; 2],
    sum: [f64; 2],
    /// `cos a2 - cos a1` and `cos a2 + cos a1`, zero exactly in the same cases.
    v_minus_m: f64,
    v_plus_m: f64,
    /// Cosine and sine of the azimuth of `o0` about `w2`, from `w1`.
    azimuth2: [f64; 2],
}

/// Direction in the first rotary's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameDirection<T> {
    /// `sin φ` times cosine and sine of its azimuth.
    x: T,
    y: T,
    /// `cos φ`.
    u: T,
}

/// Parts of the triangle that both branches share.
#[derive(Debug, Clone, Copy)]
struct TriangleAngles<T> {
    seen: FrameDirection<T>,
    /// `sin a1 sin φ cos B1` and `sin a1 sin φ sin B1`, both divided by `h` as often as `seen` is.
    b1: [T; 2],
    /// `sin a1 sin a2 cos B2` and `sin a1 sin a2 sin B2`.
    b2: [T; 2],
}

/// A direction outside the cone the machine can reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ReachMiss {
    /// Angle outside \[rad\].
    pub(super) angle: f64,
    /// Nearest direction within reach.
    pub(super) nearest: UnitVector3<f64>,
}

/// Reachability of a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reachability {
    /// Two solutions.
    Regular,
    /// Parallel to the first rotary.
    Pole,
}

impl<T: Real> FrameDirection<T> {
    /// `cos φ`.
    #[inline]
    pub(super) fn cos(&self) -> T {
        self.u
    }
}

impl RotaryTriangle {
    pub(super) fn new(chain: &ChainGeometry) -> Self {
        let [w1, w2] = [*chain.rotary[0].dir, *chain.rotary[1].dir];
        let o0 = *chain.axis;
        let [m, v] = [w1.dot(&w2), w2.dot(&o0)];
        let [s1, s2] = [w1.cross(&w2).norm(), w2.cross(&o0).norm()];
        let snap = |sin: f64| if sin.abs() <= ROUNDING { 0.0 } else { sin };
        // Cosine and sine of a1 - a2 and a1 + a2 by the addition theorems.
        let difference = [v * m + s1 * s2, snap(s1 * v - m * s2)];
        let sum = [m * v - s1 * s2, snap(s1 * v + m * s2)];
        // `a1 - a2` can only be near 0, never near π; `a1 + a2` near π but not near 0: both sides
        // are away from 0 and π in a checked machine.
        let equal = |sin: f64, value: f64| if sin.abs() > 0.0 { value } else { 0.0 };
        let e1 = (w2 - w1 * m) / s1;
        let f1 = (w1 - w2 * m) / s1;
        let azimuth2 = [o0.dot(&f1) / s2, o0.dot(&w2.cross(&f1)) / s2];
        Self {
            frame: [e1, w1.cross(&e1), w1],
            m,
            v,
            difference,
            sum,
            v_minus_m: equal(difference[1], v - m),
            v_plus_m: equal(sum[1], v + m),
            azimuth2,
        }
    }

    /// Returns direction `o` (unit) in the first rotary's frame.
    #[inline]
    pub(super) fn see<T: Real>(&self, o: [T; 3]) -> FrameDirection<T> {
        let [x, y, u] = self.frame.map(|row| dot(&row, o));
        FrameDirection { x, y, u }
    }

    /// Classifies the reachability of a direction.
    ///
    /// `φ` must lie in `[|a1 - a2|, min(a1 + a2, 2π - a1 - a2)]`; rounding errors are accepted.
    #[inline]
    pub(super) fn place(
        &self,
        seen: &FrameDirection<f64>,
        pole: f64,
    ) -> Result<Reachability, ReachMiss> {
        let sin2 = seen.x * seen.x + seen.y * seen.y;
        let [low, high] = [self.below(seen.u, sin2), self.above(seen.u, sin2)];
        let at_pole = sin2 <= pole * pole;
        if low >= 0.0 && high >= 0.0 {
            return Ok(if at_pole { Reachability::Pole } else { Reachability::Regular });
        }
        let miss = self.miss(seen);
        if miss.angle <= ROUNDING.max(if at_pole { pole } else { 0.0 }) {
            return Ok(if at_pole { Reachability::Pole } else { Reachability::Regular });
        }
        Err(miss)
    }

    /// Returns the reachable band of `φ` \[rad\].
    pub(super) fn band(&self) -> [f64; 2] {
        let [low, high] = [self.difference, self.sum].map(|[cos, sin]| math::atan2(sin.abs(), cos));
        [low, high]
    }

    fn miss(&self, seen: &FrameDirection<f64>) -> ReachMiss {
        let [low, high] = self.band();
        let sin = math::hypot(seen.x, seen.y);
        let phi = math::atan2(sin, seen.u);
        let to = phi.clamp(low, high);
        let (sin_to, cos_to) = math::sin_cos(to);
        let [e1, e2, w1] = self.frame;
        // At a pole any azimuth is as near as any other.
        let [x, y] = if sin > 0.0 { [seen.x / sin, seen.y / sin] } else { [1.0, 0.0] };
        let nearest = (e1 * x + e2 * y) * sin_to + w1 * cos_to;
        ReachMiss { angle: (phi - to).abs(), nearest: UnitVector3::new_normalize(nearest) }
    }

    /// Returns `cos(a1 - a2) - cos φ` without cancellation near the pole, where
    /// `cos a - cos b = (sin² b - sin² a) / (cos a + cos b)`.
    #[inline]
    fn below<T: Real>(&self, u: T, sin2: T) -> T {
        let [cos, sin] = self.difference;
        if u.value() + cos > 1.0 { (sin2 + -sin * sin) / (u + cos) } else { -u + cos }
    }

    /// Returns `cos φ - cos(a1 + a2)`, likewise near the opposite pole.
    #[inline]
    fn above<T: Real>(&self, u: T, sin2: T) -> T {
        let [cos, sin] = self.sum;
        if u.value() + cos < -1.0 { -(sin2 + -sin * sin) / (u + cos) } else { u + -cos }
    }

    /// Returns `cos a2 - cos a1 cos φ` without cancellation near either pole.
    #[inline]
    fn cos_b1<T: Real>(&self, u: T, sin2: T) -> T {
        let one = T::constant(1.0);
        if u.value() > 0.0 {
            sin2 / (u + one) * self.m + self.v_minus_m
        } else {
            sin2 / (u - one) * self.m + self.v_plus_m
        }
    }

    #[inline]
    fn angles<T: Real>(&self, seen: FrameDirection<T>) -> TriangleAngles<T> {
        let FrameDirection { x, y, u } = seen;
        let sin2 = x * x + y * y;
        // Sine law: sin a1 sin φ sin B1 = sin a1 sin a2 sin B2, the root of
        // (cos(a1 - a2) - cos φ)(cos φ - cos(a1 + a2)).
        let root = (self.below(u, sin2) * self.above(u, sin2)).sqrt_clamped();
        let b1 = [self.cos_b1(u, sin2), root];
        TriangleAngles { seen, b1, b2: [u + -self.m * self.v, root] }
    }

    /// Returns both angles of branch `g` = ±1 away from the poles.
    #[inline]
    pub(super) fn turns<T: Real>(&self, seen: FrameDirection<T>, g: f64) -> [RotaryAngle<T>; 2] {
        self.branch(&self.angles(seen), g)
    }

    /// Returns both branches at once, + first.
    #[inline]
    pub(super) fn both<T: Real>(&self, seen: FrameDirection<T>) -> [[RotaryAngle<T>; 2]; 2] {
        let angles = self.angles(seen);
        [self.branch(&angles, 1.0), self.branch(&angles, -1.0)]
    }

    #[inline]
    fn branch<T: Real>(&self, angles: &TriangleAngles<T>, g: f64) -> [RotaryAngle<T>; 2] {
        let TriangleAngles { seen: FrameDirection { x, y, .. }, b1: [c1, s1], b2: [c2, s2] } =
            *angles;
        let [s1, s2] = [s1 * g, s2 * g];
        // Azimuth less B1, by the addition theorems.
        let first = RotaryAngle::of(y * c1 - x * s1, x * c1 + y * s1);
        [first, self.second(c2, s2)]
    }

    /// Returns `t2 = -B2 - azimuth` from a multiple of cosine and sine of `B2`.
    #[inline]
    fn second<T: Real>(&self, cos: T, sin: T) -> RotaryAngle<T> {
        let [c, s] = self.azimuth2;
        RotaryAngle::of(-(sin * c + cos * s), cos * c - sin * s)
    }

    /// Returns the second angle at a pole, where the first is free.
    pub(super) fn second_at_pole(&self, u: f64) -> RotaryAngle<f64> {
        // The triangle is flat there: B2 = 0 at +w1, π at -w1.
        self.second(u.signum(), 0.0)
    }

    /// Returns both angles of branch `g` at a pole that the direction passes through.
    ///
    /// They are the limits from the side of growing parameter; the side of falling parameter has the other
    /// `g`. The number counts the lost derivatives: so many of the highest are unknown (and zero).
    ///
    /// At the pole `x`, `y` and `sin B2` vanish like `h^k`; divided by `h^k` they have an azimuth.
    /// Returns `None` if the direction stays at the pole to third order. `least[k - 1]` is the smallest
    /// coefficient of `h^k` that is not noise.
    pub(super) fn through_pole(
        &self,
        seen: FrameDirection<Jet>,
        g: f64,
        least: [f64; 3],
    ) -> Option<([RotaryAngle<Jet>; 2], usize)> {
        let FrameDirection { mut x, mut y, u } = seen;
        let mut lost = 0;
        for (order, least) in (1..).zip(least) {
            [x, y] = [x.deflated(), y.deflated()];
            if math::hypot(x.c[0], y.c[0]) > least {
                lost = order;
                break;
            }
        }
        if lost == 0 {
            return None;
        }
        let sin2 = x * x + y * y;
        let upper = u.value() > 0.0;
        // Of the two factors of S one is sin² φ / |cos φ ± 1|, the other regular.
        let (over, other) =
            if upper { (u + 1.0, u + -self.sum[0]) } else { (-u + 1.0, -u + self.difference[0]) };
        let root = (sin2 / over * other).sqrt();
        let inflate = |jet: Jet| (0..lost).fold(jet, |jet, _| jet.inflated());
        let c1 = inflate(sin2 / over) * if upper { self.m } else { -self.m };
        let b2 = [u + -self.m * self.v, inflate(root)];
        let seen = FrameDirection { x, y, u };
        Some((self.branch(&TriangleAngles { seen, b1: [c1, root], b2 }, g), lost))
    }
}

#[inline]
fn dot<T: Real>(row: &Vector3<f64>, v: [T; 3]) -> T {
    v[0] * row.x + v[1] * row.y + v[2] * row.z
}
