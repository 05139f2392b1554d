//! Bounds on the error between two samples of the circle.

use crate::positioning::distance::circle::ErrorSample;
use crate::positioning::distance::probe::DistanceReading;
use crate::surface::FaceIndex;
use nalgebra::UnitVector3;

/// Largest angle between points that bounds start from \[rad\].
pub(crate) const SPACING: f64 = 0.7;

/// Bounds of the derivatives of the error along the circle.
///
/// `E'' = n . a + H(t, t)`, `t` the tangent of length `R` and `a` the vector to the centre: the circle's own
/// part and the surface's, `H` the second derivative of the distance, whose eigenvalues are
/// `-k / (1 - k d)` for the principal curvatures `k` at the foot and 0 along the normal. Axis, radius and
/// tangent are orthogonal, so that `n . a` and `E' = n . t` are at most `R sin(beta)`, `beta` the angle
/// between tool axis and normal, whose sine grows by at most `R max |H|` per rad.
///
/// `E''' = 3 H(t, a) - n . t + D(t, t, t)`: all but the third derivative `D` of the distance is known where
/// the surface was read. For tangents `D = -(d II)(t', t', t')`, their feet moving `1 / (1 - k d)` times as
/// fast; along the normal `H` changes by `-H^2`, which adds `-3 E' H^2(t, t)`. What is known changes by
/// `3 (H(a, a) - H(t, t) + D(t, t, a)) - E''` per rad.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapBounds {
    /// Radius of the circle \[mm\].
    pub(crate) radius: f64,
    /// Corner radius \[mm\].
    pub(crate) minor: f64,
    /// Tool axis.
    pub(crate) axis: UnitVector3<f64>,
    /// Range of the curvatures below the circle.
    pub(crate) under: CurvatureRange,
}

/// Range of the normal curvatures under the circle, and of their rate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurvatureRange {
    /// No normal curvature leaves this range \[1/mm\].
    pub(crate) curvatures: [f64; 2],
    /// None changes faster than this \[1/mm^2\]; infinite where that is not known.
    pub(crate) rate: f64,
}

/// Proven range of the error over a gap.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapRange {
    /// Lower and upper bound on the error \[mm\].
    pub(crate) range: [f64; 2],
    /// `true` if there is at most one extremum between the ends, which the signs of their slopes
    /// reveal.
    pub(crate) plain: bool,
}

/// Bounds over a gap.
struct DerivativeBounds {
    /// Range of `E''`.
    second: [f64; 2],
    /// At a distance `s` from an end, `E'''` differs from what is known of it there by at most
    /// `third + fourth s`.
    third: f64,
    fourth: f64,
}

impl GapBounds {
    /// Returns the proven range of the error between two samples.
    pub(crate) fn range_between(&self, a: &ErrorSample, b: &ErrorSample) -> GapRange {
        let h = b.psi - a.psi;
        let Some(bounds) = self.bounds([a, b], h) else {
            return GapRange { range: [f64::NEG_INFINITY, f64::INFINITY], plain: false };
        };
        // First bound: the error lies below both parabolas that bend by the largest E'', and above
        // those that bend by the least.
        let [low, high] = bounds.second;
        let range = [-peak([a, b], -1.0, -low), peak([a, b], 1.0, high)];
        // An E'' of one sign leaves room for one extremum at most.
        let plain = low > 0.0 || high < 0.0;
        if !bounds.third.is_finite() {
            return GapRange { range, plain };
        }
        // Second bound, by Taylor's formula of third order from either end to the middle; sharper
        // where the curvature has a bounded rate.
        let halves = [(a, 1.0), (b, -1.0)].map(|(end, sign)| HalfGap::new(end, sign, h, &bounds));
        let [one, two] = halves.each_ref().map(HalfGap::range);
        let range = [range[0].max(one[0].min(two[0])), range[1].min(one[1].max(two[1]))];
        // Both halves bend, or both rise, the same way: then so does the whole gap.
        let agree = |of: fn(&HalfGap) -> Option<bool>| {
            let [one, two] = halves.each_ref().map(of);
            one.is_some() && one == two
        };
        GapRange { range, plain: plain || agree(HalfGap::bends_up) || agree(HalfGap::rises) }
    }

    /// Bounds over a gap of `h` \[rad\]; `None` where there are none.
    fn bounds(&self, [a, b]: [&ErrorSample; 2], h: f64) -> Option<DerivativeBounds> {
        let radius = self.radius;
        // Every point of the gap lies within half its arc of an end.
        let way = 0.5 * radius * h;
        let far = self.minor + a.error.max(b.error) + way;
        let near = self.minor + a.error.min(b.error) - way;
        let ([low, high], pace) = self.second(near, far)?;
        // Sine of the angle beta between tool axis and normal at the ends; in between it grows by
        // at most R max|H| per rad.
        let sine = |s: &ErrorSample| self.axis.cross(&s.reading.normal()).norm();
        let most = high.max(-low);
        let lean = sine(a).max(sine(b)) + way * most;
        // Rate of n . a: the normal's turn across, at most half the spread of H, and E'.
        let rate = radius * (0.5 * radius * (high - low) + lean);
        // E'' lies within half the growth of its plane part, plus the surface's part.
        let own = 0.5 * (a.plane_bend + b.plane_bend);
        let spread = (0.5 * h * rate).min(radius * lean + own.abs());
        let square = radius * radius;
        let second = [(own - spread) + square * low, (own + spread) + square * high];
        // The unknown part of E''', and the rate of its known part.
        let turn = self.under.rate * pace * pace * pace + 3.0 * lean * most * most;
        // R^3 times the bound on D per unit of length: the feet move `pace` times as fast as the
        // points.
        let third = radius * square * turn;
        let fourth = radius * lean + square * most + 3.0 * (square * (high - low) + third);
        Some(DerivativeBounds { second, third, fourth })
    }

    /// Returns the range of the eigenvalues of `H`, 0 included, and the largest ratio of the speed of a
    /// foot to that of its point; `None` where there is no bound.
    fn second(&self, near: f64, far: f64) -> Option<([f64; 2], f64)> {
        let [least, most] = self.under.curvatures;
        // The eigenvalue 0 along the normal belongs to the range.
        let [least, most] = [least.min(0.0), most.max(0.0)];
        // -k / (1 - k d) is monotone in k: the largest k at the farthest point gives the lowest
        // eigenvalue, the least k at the nearest point the highest.
        let (falling, rising) = (1.0 - most * far.max(0.0), 1.0 - least * near);
        let bounded = falling > 0.0 && rising > 0.0 && least.is_finite() && most.is_finite();
        // A foot moves 1 / (1 - k d) times as fast as its point.
        let pace = falling.min(rising).min(1.0).recip();
        bounded.then(|| ([-most / falling, -least / rising], pace))
    }
}

/// Half of a gap, seen from its end: Taylor's formula with bounds of what is left.
struct HalfGap {
    /// Length \[rad\].
    length: f64,
    /// 1 where the angle grows inwards, -1 where it falls.
    sign: f64,
    /// Value, slope, bend and the known part of the third derivative at the end, going inwards.
    known: [f64; 4],
    /// Constants that, integrated one to three times from the end, bound the integrals of
    /// `third + fourth s`: `third + fourth L / 2`, `third + fourth L / 3`, `third + fourth L / 4`.
    off: [f64; 3],
}

impl HalfGap {
    fn new(end: &ErrorSample, sign: f64, h: f64, bounds: &DerivativeBounds) -> Self {
        let length = 0.5 * h;
        // Going inwards from the second end reverses the angle, so the odd derivatives change sign.
        let known = [end.error, sign * end.slope, end.bend, sign * end.twist];
        let off = [2.0, 3.0, 4.0].map(|n| bounds.third + bounds.fourth * length / n);
        Self { length, sign, known, off }
    }

    /// Returns the range of the error.
    fn range(&self) -> [f64; 2] {
        [-1.0, 1.0].map(|sign| sign * self.most(sign))
    }

    /// Returns an upper bound on `sign E`.
    fn most(&self, sign: f64) -> f64 {
        let [value, slope, bend, twist] = self.known.map(|x| sign * x);
        // The unknown part of E''' counts with its bound, averaged over three integrations.
        let twist = twist + self.off[2];
        let at = |s: f64| value + s * (slope + s * (bend / 2.0 + s * twist / 6.0));
        let mut most = value.max(at(self.length));
        // Where the slope `slope + bend s + twist s^2 / 2` vanishes.
        let square = bend * bend - 2.0 * slope * twist;
        if square > 0.0 {
            // Roots of twist s^2 / 2 + bend s + slope without cancellation: q = -(b + sign(b)
            // sqrt(b^2 - 2 c a)), s = q / a and 2 c / q.
            let sum = -(bend + square.sqrt().copysign(bend));
            for s in [sum / twist, 2.0 * slope / sum] {
                if s > 0.0 && s < self.length {
                    most = most.max(at(s));
                }
            }
        }
        most
    }

    /// Returns `Some(true)` if the error bends upwards over the whole half, `Some(false)` if downwards,
    /// `None` if neither is proven.
    fn bends_up(&self) -> Option<bool> {
        let [_, _, bend, twist] = self.known;
        // E'' is linear but for what is unknown: its range is that of its values at both ends,
        // widened.
        let inner = bend + twist * self.length;
        let off = self.off[0] * self.length;
        sign([bend.min(inner - off), bend.max(inner + off)])
    }

    /// Returns `Some(true)` if the error rises with the angle over the whole half, `Some(false)` if it
    /// falls, `None` if neither is proven.
    fn rises(&self) -> Option<bool> {
        let [_, slope, bend, twist] = self.known;
        let most = |sign: f64| {
            let [slope, bend, twist] = [sign * slope, sign * bend, sign * twist + self.off[1]];
            let at = |s: f64| slope + s * (bend + 0.5 * s * twist);
            let ends = slope.max(at(self.length));
            // A slope that is concave in s has its maximum inside.
            let top = -bend / twist;
            if twist < 0.0 && top > 0.0 && top < self.length { ends.max(at(top)) } else { ends }
        };
        sign([-most(-1.0), most(1.0)]).map(|inwards| inwards == (self.sign > 0.0))
    }
}

/// Returns `Some(true)` for a positive range, `Some(false)` for a negative one.
fn sign([low, high]: [f64; 2]) -> Option<bool> {
    if low > 0.0 {
        Some(true)
    } else if high < 0.0 {
        Some(false)
    } else {
        None
    }
}

/// Returns an upper bound on `sign * error` between two points.
///
/// The error lies under both parabolas that start with value and slope of a point and bend upward
/// by `bend` or, where that is negative, not at all.
fn peak([a, b]: [&ErrorSample; 2], sign: f64, bend: f64) -> f64 {
    let h = b.psi - a.psi;
    let bend = bend.max(0.0);
    let [ea, eb] = [sign * a.error, sign * b.error];
    let [sa, sb] = [sign * a.slope, sign * b.slope];
    let ends = ea.max(eb);
    // Both parabolas bend by `bend`, so their difference is linear in s and grows at the rate
    // `closing`; without a positive rate they do not cross inside.
    let closing = sa - sb + bend * h;
    if !bend.is_finite() {
        return f64::INFINITY;
    }
    if closing <= 0.0 {
        return ends;
    }
    // The parabolas meet at s; the lower one bounds on either side.
    let s = ((eb - ea - sb * h + 0.5 * bend * h * h) / closing).clamp(0.0, h);
    let left = ea + s * (sa + 0.5 * bend * s);
    let t = h - s;
    let right = eb - t * (sb - 0.5 * bend * t);
    ends.max(left.min(right))
}

/// Bounds the curvatures under all points within a step of those read; infinite where there is no
/// bound.
///
/// A foot moves at most `1 / (1 - k d)` times as fast as its point, `k` bounded over all there is
/// within the reach of such feet: as it starts inside, it never leaves.
pub(crate) fn curvatures_under<'a, Readings: Iterator<Item = &'a DistanceReading> + Clone>(
    face: &FaceIndex,
    readings: &Readings,
    way: f64,
    far: f64,
) -> CurvatureRange {
    /// Each widens the reach to what the last one asked for; more than twice is rare.
    const WIDENINGS: u32 = 8;
    let mut reach = 1.25 * way;
    for _ in 0..WIDENINGS {
        let feet = readings.clone().map(|reading| &reading.foot);
        let around = face.curvature_around(feet, reach).ends();
        // Of the continuation beyond the domain the feet are all there is to go by.
        let [low, high] = readings.clone().fold(around, |[low, high], reading| {
            let [least, most] = reading.curvatures();
            [low.min(least), high.max(most)]
        });
        let left = 1.0 - high * far.max(0.0);
        // Feet of points within `way` move at most way / (1 - k d): if that is within the reach for
        // which k was bounded, the bound holds.
        if left > 0.0 && way <= reach * left {
            let feet = readings.clone().map(|reading| &reading.foot);
            let rate = face.curvature_rate_around(feet, reach);
            return CurvatureRange { curvatures: [low, high], rate };
        }
        if left <= 0.0 {
            break;
        }
        // Widen to what the bound on k asks for, with a quarter to spare.
        reach = 1.25 * way / left;
    }
    CurvatureRange { curvatures: [f64::NEG_INFINITY, f64::INFINITY], rate: f64::INFINITY }
}
