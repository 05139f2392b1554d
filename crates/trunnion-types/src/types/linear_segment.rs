//! Motion between two rows of a schedule while acceleration is linear in the path parameter.

use crate::math;
/// A segment on which `d²s/dt² = u + c σ` is linear in the distance `σ` from its start.
///
/// `s` then obeys a linear differential equation: hyperbolic functions for `c > 0`, trigonometric
/// ones for `c < 0`, a parabola for `c = 0`; Stumpff's functions make one formula of the three.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearSegment {
    /// Length in `s`.
    pub length: f64,
    /// `ds/dt` at both ends.
    pub speed: [f64; 2],
    /// `d²s/dt²` at both ends.
    pub acceleration: [f64; 2],
}

/// Distance from the start of a segment, and its first three derivatives by time.
pub(crate) type Advance = [f64; 4];

impl LinearSegment {
    /// Returns `c = du/ds`, the change of the acceleration along the path.
    fn slope(&self) -> f64 {
        (self.acceleration[1] - self.acceleration[0]) / self.length
    }

    /// Returns `true` if an end is at rest: no speed and no acceleration, so that jerk alone moves it.
    fn rests(&self, end: usize) -> bool {
        self.speed[end] <= 0.0 && self.acceleration[end].abs() <= 0.0
    }

    /// Returns the same motion run backwards in time.
    fn reversed(&self) -> Self {
        // Speeds keep their sign, accelerations change it.
        let [from, to] = [self.speed, self.acceleration];
        Self { length: self.length, speed: [from[1], from[0]], acceleration: [-to[1], -to[0]] }
    }

    /// Returns the time from end to end \[s\]; 0 where nothing ever moves.
    pub fn time(&self) -> f64 {
        let sum = self.speed[0] + self.speed[1];
        match [self.rests(0), self.rests(1)] {
            [true, true] => 0.0,
            // s goes with t³, so the mean speed is a third of the largest.
            [true, false] | [false, true] => 3.0 * self.length / sum,
            [false, false] => passage(self.length, sum, self.slope()),
        }
    }

    /// Returns the time to the distance `x` from the start, inside the segment.
    pub(crate) fn time_to(&self, x: f64) -> f64 {
        // From the slower end: nothing cancels, not even on the way to rest.
        if self.rests(1) || (self.speed[1] < self.speed[0] && !self.rests(0)) {
            return self.time() - self.reversed().time_from_slower(self.length - x);
        }
        self.time_from_slower(x)
    }

    fn time_from_slower(&self, x: f64) -> f64 {
        if self.rests(0) {
            // s goes with t³ from rest.
            return self.time() * math::cbrt(x / self.length);
        }
        // v dv/ds = u + c s, so that v² at x is v0² + 2 u x + c x².
        let [v, u, c] = [self.speed[0], self.acceleration[0], self.slope()];
        let end = (v * v + (2.0 * u + c * x) * x).max(0.0).sqrt();
        if v + end > 0.0 { passage(x, v + end, c) } else { 0.0 }
    }

    /// Returns the advance at time `t` \[s\] after the start, inside the segment, and its derivatives.
    pub fn at(&self, t: f64) -> Advance {
        if self.rests(1) && !self.rests(0) {
            let [x, v, a, j] = self.reversed().at(self.time() - t);
            return [self.length - x, v, -a, j];
        }
        // From rest: s = j t³ / 6 with the jerk that covers the length in this time.
        if self.rests(0) {
            let time = self.time();
            let share = if time > 0.0 { t / time } else { 0.0 };
            let jerk = if time > 0.0 { 6.0 * self.length / time.powi(3) } else { 0.0 };
            let [v, a] = [0.5 * jerk * t * t, jerk * t];
            return [self.length * share.powi(3), v, a, jerk];
        }
        let [v, u, c] = [self.speed[0], self.acceleration[0], self.slope()];
        // v = v0 cosh wt + u sinh wt / w with w² = c; s is its integral.
        let [c0, c1, c2] = stumpff(c * t * t);
        let x = t * (v * c1 + u * t * c2);
        let speed = v * c0 + u * t * c1;
        [x, speed, u + c * x, c * speed]
    }
}

/// Returns the time over `length` where speed obeys `d²v/dt² = c v` and `sum` is the speed at both ends added.
///
/// `v` is a hyperbolic or trigonometric cosine about some time, so `tanh(w T / 2) = w length / sum`
/// with `w² = c`, and for `c < 0` the same with `tan`: `2 length / sum` times a factor near 1.
fn passage(length: f64, sum: f64, c: f64) -> f64 {
    // y is positive for a growing, negative for a falling acceleration; the factor is 1 at y = 0.
    let y = c * (length / sum).powi(2);
    let factor = if y.abs() < SERIES {
        // atanh(sqrt y) / sqrt y
        1.0 + y * (1.0 / 3.0 + y * (1.0 / 5.0 + y * (1.0 / 7.0 + y * (1.0 / 9.0 + y / 11.0))))
    } else if y > 0.0 {
        y.sqrt().atanh() / y.sqrt()
    } else {
        math::atan((-y).sqrt()) / (-y).sqrt()
    };
    2.0 * length / sum * factor
}

/// Below this the series are used: the first terms left out are `1e-18 / 13` of the sum at most.
const SERIES: f64 = 1e-3;

/// Returns `cosh r`, `sinh r / r` and `(cosh r - 1) / r²` with `r² = z` of either sign.
fn stumpff(z: f64) -> [f64; 3] {
    if z.abs() < SERIES {
        let c2 = 0.5 + z * (1.0 / 24.0 + z * (1.0 / 720.0 + z * (1.0 / 40320.0 + z / 3_628_800.0)));
        let c1 = 1.0 + z * (1.0 / 6.0 + z * (1.0 / 120.0 + z * (1.0 / 5040.0 + z / 362_880.0)));
        return [1.0 + z * c2, c1, c2];
    }
    // (cosh r - 1) / r² = (sinh (r/2) / (r/2))² / 2: nothing cancels.
    let r = z.abs().sqrt();
    let half = 0.5 * r;
    if z > 0.0 {
        [math::cosh(r), math::sinh(r) / r, 0.5 * (math::sinh(half) / half).powi(2)]
    } else {
        [math::cos(r), math::sin(r) / r, 0.5 * (math::sin(half) / half).powi(2)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ends with the speed that the start and the accelerations lead to.
    fn segment(length: f64, speed: f64, acceleration: [f64; 2]) -> LinearSegment {
        let square = speed * speed + (acceleration[0] + acceleration[1]) * length;
        LinearSegment { length, speed: [speed, square.sqrt()], acceleration }
    }

    #[test]
    fn a_segment_ends_where_and_as_fast_as_it_should() {
        for acceleration in [[1.0, 3.0], [3.0, -2.0], [2.0, 2.0], [2.0, 2.0001], [-1.0, 6.0]] {
            for (length, speed) in [(1.0, 1.5), (1e-3, 0.1), (2.0, 4.0)] {
                let it = segment(length, speed, acceleration);
                let end = it.at(it.time());
                assert!((end[0] / length - 1.0).abs() < 1e-13, "{it:?}: {end:?}");
                assert!((end[1] / it.speed[1] - 1.0).abs() < 1e-12, "{it:?}: {end:?}");
                assert!((end[2] - acceleration[1]).abs() < 1e-12 * 6.0, "{it:?}: {end:?}");
            }
        }
    }

    #[test]
    fn time_to_inverts_at() {
        let moving = [segment(1.0, 1.5, [3.0, -2.0]), segment(2.0, 4.0, [-2.0, -1.0])];
        let from_rest = LinearSegment { length: 1.0, speed: [0.0, 3.0], acceleration: [0.0, 6.0] };
        let to_rest = LinearSegment { length: 1.0, speed: [3.0, 0.0], acceleration: [-6.0, 0.0] };
        for it in moving.into_iter().chain([from_rest, to_rest]) {
            for k in 0..=10 {
                let t = it.time() * f64::from(k) / 10.0;
                let back = it.time_to(it.at(t)[0]);
                // Next to rest s goes with the cube of the time left: a rounding becomes its root.
                assert!((back - t).abs() < 1e-5 * it.time() || k < 10 && (back - t).abs() < 1e-13);
            }
        }
    }

    /// 1 mm from rest in 1 s: s = t³, v = 3 t², a = 6 t, jerk 6.
    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn from_rest_jerk_is_constant() {
        let it = LinearSegment { length: 1.0, speed: [0.0, 3.0], acceleration: [0.0, 6.0] };
        assert_eq!(it.time(), 1.0);
        assert_eq!(it.at(0.5), [0.125, 0.75, 3.0, 6.0]);
        let stop = it.reversed();
        assert_eq!(stop.at(0.5), [0.875, 0.75, -3.0, 6.0]);
    }
}
