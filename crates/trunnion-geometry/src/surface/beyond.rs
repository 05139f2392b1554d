//! Continuation of splines beyond their ends.

use nalgebra::Vector3;

/// Continuation of a spline beyond one end of its range: at a distance `x` of the parameter it is
/// `S + x S' + x^2 / (2 (1 + rate |x|)) S''`, value and derivatives taken at the end.
///
/// Value and first two derivatives are continuous. The Taylor polynomial (`rate` 0) turns back
/// where the parametrisation slows down towards the end, `S'' . S' < 0` outwards; with the rate of
/// [`SplineExtension::with`] the derivative keeps at least half of its share along `S'` at any
/// distance, and the curvature decays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SplineExtension {
    rate: f64,
}

impl SplineExtension {
    /// Creates the continuation from the pace at which the parametrisation slows down outwards,
    /// [`SplineExtension::pace`], at its largest along the end. The factor of `S''` in the
    /// derivative grows to `1 / (2 rate)`: one half of `S'` is left.
    pub(super) fn with(pace: f64) -> Self {
        Self { rate: pace.max(0.0) }
    }

    /// Returns `-S'' . S' / |S'|^2`, the parameter counted outwards: along `outwards` = 1 or -1. 0
    /// for an end without derivative, which has no direction that could be kept.
    pub(super) fn pace([first, second]: [Vector3<f64>; 2], outwards: f64) -> f64 {
        // Relative loss of speed: of |S'|^2 / 2 by the parameter, over |S'|^2.
        let pace = -outwards * second.dot(&first) / first.norm_squared();
        if pace.is_finite() { pace } else { 0.0 }
    }

    /// Returns value and derivatives to order 3 at `x` beyond an end with value and derivatives
    /// `d`.
    pub(super) fn at(self, d: [Vector3<f64>; 4], x: f64) -> [Vector3<f64>; 4] {
        let [a, b, c, _] = d;
        // x^2 / (2 (1 + k |x|)) and its derivatives: x (1 + k |x| / 2) / (1 + k |x|)^2, 1 / (1 + k
        // |x|)^3 and -3 k sign(x) / (1 + k |x|)^4.
        let slow = (1.0 + self.rate * x.abs()).recip();
        let bend = 0.5 * x * x * slow;
        let slope = x * (1.0 + 0.5 * self.rate * x.abs()) * slow * slow;
        let second = slow * slow * slow;
        let third = -3.0 * self.rate * x.signum() * second * slow;
        [a + b * x + c * bend, b + c * slope, c * second, c * third]
    }
}
