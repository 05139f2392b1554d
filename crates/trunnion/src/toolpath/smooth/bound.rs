//! Deviation of a curve from the path it stands for, bounded by control points.

use super::bezier::{DEGREE, QuinticBezier, from_powers, middle};
use super::coordinates::{axis, contact, tip};
use super::report::PathDeviation;
use crate::math;
use crate::types::PoseCoordinates;
use nalgebra::Vector3;

/// Range of the tool axis of a path between two stations, about the middle of its turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisFrame {
    /// Unit vector in the middle of the turn.
    middle: Vector3<f64>,
    /// Least and largest component of the path's axis vector along it, and largest across.
    along: [f64; 2],
    across: f64,
    /// Angle between the path's axis vector and the axis it stands for, at most \[rad\].
    shift: f64,
}

impl AxisFrame {
    /// Bounds a chord between two unit axes that stands for the great circle at the same share.
    ///
    /// With half the angle between them `h`, the chord at the share `(1 + s) / 2` is turned by
    /// `atan(s tan h)` from its middle, the great circle by `s h`. The difference is largest where
    /// `s² = (tan h / h - 1) / tan² h`.
    pub(super) fn chord(from: &PoseCoordinates, to: &PoseCoordinates) -> Self {
        // |a + b| = 2 cos h, |b - a| = 2 sin h.
        let [a, b] = [axis(from), axis(to)];
        let sum = a + b;
        let [cos, sin] = [0.5 * sum.norm(), 0.5 * (b - a).norm()];
        let tan = sin / cos;
        let half = math::atan(tan);
        // Below this, tan h / h - 1 is lost in rounding, and the shift, 0.13 h³, is below 1e-12.
        let shift = if half > 1e-4 {
            // Where the derivative of atan(s tan h) - s h by s vanishes: tan h / (1 + s^2 tan^2 h)
            // = h.
            let s = ((tan / half - 1.0).max(0.0)).sqrt() / tan;
            (math::atan(s * tan) - s * half).abs()
        } else {
            0.129 * half.powi(3)
        };
        Self { middle: sum / (2.0 * cos), along: [cos, cos], across: sin, shift }
    }

    /// Bounds a curve of axis vectors that is itself the path.
    pub(super) fn curve(path: &QuinticBezier) -> Self {
        let sum = axis(&path[0]) + axis(&path[5]);
        let middle = sum / sum.norm();
        let mut frame =
            Self { middle, along: [f64::INFINITY, f64::NEG_INFINITY], across: 0.0, shift: 0.0 };
        for point in path {
            let axis = axis(point);
            // The curve lies in the hull of its control points: so do its components along and
            // across.
            let along = axis.dot(&middle);
            frame.along = [frame.along[0].min(along), frame.along[1].max(along)];
            frame.across = frame.across.max((axis - middle * along).norm());
        }
        frame
    }

    /// Returns the largest angle to the path's axis if the axis vector differs by `across` and
    /// `along` the middle direction; infinite if the curve's axis could vanish.
    ///
    /// Central projection onto the plane that touches the sphere in the middle makes angles longer,
    /// never shorter: with the path's `B` and the curve's `B + D`,
    /// `(B·m)(B + D) - (B·m + D·m) B = (B·m) D⊥ - (D·m) B⊥`.
    fn angle(&self, across: f64, along: f64) -> f64 {
        let [least, most] = self.along;
        // Least component of the curve's axis along the middle; 0 or less, and the projection
        // fails.
        let room = least - along;
        if room <= 0.0 {
            return f64::INFINITY;
        }
        (most * across + along * self.across) / (least * room) + self.shift
    }
}

/// Bound on the rounding of a deviation, by the size of the numbers it is computed from.
///
/// With `u = 2^-53` and `A` the largest distance from the origin of any control point of span and path, in
/// each of tip, axis and contact, to first order in `u`:
///
/// | step | at most |
/// |---|---|
/// | moving the span's Bernstein form to the origin, its Horner form back | `2 u A` |
/// | one split (de Casteljau, five levels of `a + (b - a) t`, convex, so that errors only add) | `5 * 6 u A` |
/// | the share at which it splits: three roundings, times the rate of a quintic, `5 * 2 A` | `31 u A` |
/// | width of the span: one rounding, times the same rate | `10 u A` |
/// | control points of the path: a line, or a cubic raised by two degrees | `20 u A` |
/// | their difference | `2 u A` |
/// | differences of order `k` (`k 2^k u A`), binomials and powers of the width, summed: `sum C(5,k) 2^k (2k+3)` | `2349 u A` |
/// | the span cut at its start for a blend: a shift by Horner's scheme, `10 u 3^5 A` | `2440 u A` |
/// | its value by Horner's scheme wherever it is asked for, `10 u (3^5 + 1) A`, and the distance from its start | `2470 u A` |
/// | norms | `8 u A` |
///
/// A span over `n` steps of the path has been split `n` times at most, a part of a blend four times: together
/// `(7301 + 61 n) u A`, rounded up for the terms of second order.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoundingBound {
    /// Largest control points \[mm, 1, mm\].
    size: [f64; 3],
    /// In units of the size.
    share: f64,
}

/// Rounding in units of `u A`: once, and for every split.
const ROUNDED: [f64; 2] = [7400.0, 64.0];

/// The angle from its tangents: twenty operations on numbers of the order of 1.
const ANGLE: f64 = 16.0 * f64::EPSILON;

impl RoundingBound {
    /// Bounds the rounding of a span over `splits` steps of the path, given relative to `origin`.
    pub(super) fn new(curve: &QuinticBezier, origin: &PoseCoordinates, splits: usize) -> Self {
        let far = |part: fn(&PoseCoordinates) -> Vector3<f64>| {
            let most = curve.iter().map(|point| part(point).norm_squared()).fold(0.0, f64::max);
            most.sqrt() + part(origin).norm()
        };
        let share = (ROUNDED[0] + ROUNDED[1] * splits as f64) * 0.5 * f64::EPSILON;
        Self { size: [far(tip), far(axis), far(contact)], share }
    }

    /// Returns the bound for one part of the coordinates: tip, axis or contact. The control points of
    /// the path can be larger than those of the span by the `difference` of both.
    fn of(&self, part: usize, difference: f64) -> f64 {
        self.share * (self.size[part] + difference)
    }
}

/// Rounding of second derivatives, see [`bend`].
const BENT: f64 = 1000.0 * 0.5 * f64::EPSILON;

/// Returns the largest second derivatives of tip and axis vector by the share of a span \[mm, 1\],
/// rounding included. They lie in the convex hull of twenty times the second differences of its
/// Bernstein form.
///
/// With `S` the sum of the sizes of its coefficients over the width, the Bernstein form has an error of `10 u S`
/// (five sums, a quotient and four products each), its second differences `4 * 10 u S + 6 u S`, twenty times of
/// that are below `1000 u S`.
pub(super) fn bend(coefficients: &QuinticBezier, width: f64) -> [f64; 2] {
    let mut powers = *coefficients;
    powers[0] = PoseCoordinates::zeros();
    let curve = from_powers(&powers, width);
    let [mut place, mut turn] = [0.0_f64; 2];
    for w in curve.windows(3) {
        // n (n - 1) times the second differences, n = 5: control points of the second derivative by
        // the share.
        let bend = (w[0] + w[2] - w[1] * 2.0) * 20.0;
        place = place.max(tip(&bend).norm());
        turn = turn.max(axis(&bend).norm());
    }
    let mut scale = 1.0;
    let mut sums = [0.0_f64; 2];
    for row in powers.iter().take(DEGREE + 1) {
        // Sum of the sizes of the terms at the end of the span, which the rounding is proportional
        // to.
        sums = [sums[0] + tip(row).norm() * scale, sums[1] + axis(row).norm() * scale];
        scale *= width;
    }
    [place + BENT * sums[0], turn + BENT * sums[1]]
}

/// Bounds the deviation of `curve` from `path` over one interval, at equal parameters.
///
/// The bounds hold everywhere in between: the difference lies in the convex hull of its control points. They hold
/// for the polynomial as it is handed out and evaluated, in the numbers it is made of.
pub(super) fn deviation(
    curve: &QuinticBezier,
    path: &QuinticBezier,
    frame: &AxisFrame,
    rounding: &RoundingBound,
) -> PathDeviation {
    let difference: QuinticBezier = std::array::from_fn(|k| curve[k] - path[k]);
    let [mut place, mut touch, mut across, mut along] = [0.0_f64; 4];
    for d in &difference {
        place = place.max(tip(d).norm_squared());
        touch = touch.max(contact(d).norm_squared());
        let turn = axis(d);
        // Difference of the axis vectors, split into its part along the middle direction and
        // across.
        let lift = turn.dot(&frame.middle);
        along = along.max(lift.abs());
        across = across.max((turn - frame.middle * lift).norm_squared());
    }
    // What is seen: the ends and the middle, evaluated; what is bounded: all control points.
    let half = middle(&difference);
    let off = [&difference[0], &half, &difference[5]].map(|d| {
        let turn = axis(d);
        let lift = turn.dot(&frame.middle);
        [tip(d).norm_squared(), (turn - frame.middle * lift).norm_squared()]
    });
    let seen = |part: usize| off.iter().map(|of| of[part]).fold(0.0, f64::max).sqrt();
    let [place, touch, across] = [place, touch, across].map(f64::sqrt);
    // Rounding enters before the projection, which could magnify it.
    let turned = rounding.of(1, across + along);
    PathDeviation {
        tip: seen(0),
        tip_bound: place + rounding.of(0, place),
        axis: seen(1),
        axis_bound: frame.angle(across + turned, along + turned) + ANGLE,
        contact_bound: touch + rounding.of(2, touch),
    }
}
