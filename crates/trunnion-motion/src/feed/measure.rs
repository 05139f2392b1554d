//! Dense measurement of a schedule with another discretisation.

use super::numeric::largest;
use super::plan::LimitRatios;
use super::reciprocal::ReciprocalLimits;
use crate::math::quintic::Quintic;
use crate::types::{AxisPiece, SchedulePiece};

/// Samples from a row to the next, evenly in time. Both ends are among them, each seen from
/// inside, because jerk jumps at nodes and is often largest there.
const SAMPLES: usize = 4;

/// Largest values found between and at rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeasuredRatios {
    pub(super) ratios: LimitRatios,
    pub(super) acceleration_step: f64,
}

/// Measures the schedule evenly in time, with the path in the power basis: neither the grid nor
/// the polynomial basis of the planner is used.
pub(super) fn measure<const N: usize>(
    piece: &AxisPiece<N>,
    schedule: &SchedulePiece,
    limits: &ReciprocalLimits<N>,
) -> MeasuredRatios {
    let mut most = LargestRatios { velocity: 0.0, acceleration: 0.0, jerk: 0.0, step: 0.0 };
    let mut before = 0.0;
    let mut row = 0;
    // Every node is a row, so a row interval lies in one node interval.
    for (interval, nodes) in piece.nodes.windows(2).enumerate() {
        let Some((origin, quintic)) = piece.quintic(interval) else { break };
        let curve = PowerCurve::new(&quintic);
        let feed = [nodes[0].feed_rate, nodes[1].feed_rate].map(|rate| rate * limits.feed);
        let tip = [nodes[0].tip_rate, nodes[1].tip_rate].map(|rate| rate * limits.tip);
        // Acceleration steps by |q'| |u - u before| at a row, where q' is continuous.
        while row + 1 < schedule.s.len() && schedule.s[row] < nodes[1].s {
            let motion = IntervalSamples::of(schedule, row, [origin, curve.per_length]);
            curve.take_in(&motion, limits, &mut most);
            most.step =
                largest(curve.start(&motion, limits) * (motion.u - before).abs(), most.step);
            before = motion.u;
            for (at, v) in motion.at.into_iter().zip(motion.v) {
                let [feed, tip] = [feed, tip].map(|[from, to]| from + at * (to - from));
                most.velocity = largest(v * largest(feed, tip), most.velocity);
            }
            row += 1;
        }
    }
    let ratios = LimitRatios {
        velocity: most.velocity,
        acceleration: most.acceleration,
        jerk: limits.jerk.map(|_| most.jerk),
    };
    MeasuredRatios { ratios, acceleration_step: most.step }
}

/// Largest shares of the limits seen.
struct LargestRatios {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    step: f64,
}

/// Some moments on one quintic under constant `u = d²s/dt²`.
struct IntervalSamples {
    /// Positions as shares of the length of the quintic.
    at: [f64; SAMPLES],
    v: [f64; SAMPLES],
    u: f64,
}

impl IntervalSamples {
    /// Samples the interval from a row of the schedule to the next, on a quintic that starts at
    /// `origin`.
    #[inline]
    fn of(schedule: &SchedulePiece, row: usize, [origin, per_length]: [f64; 2]) -> Self {
        let [s, v, u] = [schedule.s[row], schedule.speed[row], schedule.acceleration[row]];
        let step = (schedule.t[row + 1] - schedule.t[row]) * (1.0 / (SAMPLES - 1) as f64);
        let dt: [f64; SAMPLES] = std::array::from_fn(|k| k as f64 * step);
        // s(t) under constant u, as a share of the length of the quintic.
        let at = dt.map(|dt| (s - origin + dt * (v + 0.5 * u * dt)) * per_length);
        Self { at, v: dt.map(|dt| v + u * dt), u }
    }
}

/// Derivatives of a quintic in the power basis.
struct PowerCurve<const N: usize> {
    per_length: f64,
    /// Coefficients of `q'`, axis by axis; those of `q''` and `q'''` follow from them.
    rate: [[f64; 5]; N],
}

impl<const N: usize> PowerCurve<N> {
    #[inline]
    fn new(quintic: &Quintic<N>) -> Self {
        let per_length = 1.0 / quintic.length();
        let powers = quintic.powers();
        // d/ds of sum p_k t^k with t = s / length is sum (k + 1) p_(k+1) t^k / length.
        let rate = std::array::from_fn(|axis| {
            std::array::from_fn(|k| (k + 1) as f64 * powers[k + 1][axis] * per_length)
        });
        Self { per_length, rate }
    }

    /// Returns the largest `|q'|` over the acceleration limit at the first of the moments.
    #[inline]
    fn start(&self, motion: &IntervalSamples, limits: &ReciprocalLimits<N>) -> f64 {
        let mut most = 0.0;
        let sides = &limits.acceleration;
        for (axis, [c0, c1, c2, c3, c4]) in self.rate.into_iter().enumerate() {
            let t = motion.at[0];
            let rate = (((c4 * t + c3) * t + c2) * t + c1) * t + c0;
            most = largest(rate.abs() * sides.plus[axis].max(sides.minus[axis]), most);
        }
        most
    }

    /// Takes in `q̇ = q' v`, `q̈ = q' u + q'' v²`, `q⃛ = 3 q'' u v + q''' v³`, each over its
    /// limit.
    #[inline]
    fn take_in(
        &self,
        motion: &IntervalSamples,
        limits: &ReciprocalLimits<N>,
        most: &mut LargestRatios,
    ) {
        let IntervalSamples { at: t, v, u } = *motion;
        // Horner's scheme; each further derivative by s brings a factor 1 / length.
        let vv = v.map(|v| v * v * self.per_length);
        for (axis, [c0, c1, c2, c3, c4]) in self.rate.into_iter().enumerate() {
            let [mut velocity, mut acceleration] = [[0.0; SAMPLES]; 2];
            for k in 0..SAMPLES {
                let rate = (((c4 * t[k] + c3) * t[k] + c2) * t[k] + c1) * t[k] + c0;
                let bend = ((4.0 * c4 * t[k] + 3.0 * c3) * t[k] + 2.0 * c2) * t[k] + c1;
                velocity[k] = limits.velocity.share(axis, rate * v[k]);
                acceleration[k] = limits.acceleration.share(axis, rate * u + bend * vv[k]);
            }
            let [velocity, acceleration] =
                [velocity, acceleration].map(|[a, b, c, d]| largest(largest(a, b), largest(c, d)));
            most.velocity = largest(velocity, most.velocity);
            most.acceleration = largest(acceleration, most.acceleration);
        }
        // u is constant between rows, so that the term q' du/dt of the jerk is zero.
        let Some(inverse) = limits.jerk else { return };
        for (axis, [_, c1, c2, c3, c4]) in self.rate.into_iter().enumerate() {
            for k in 0..SAMPLES {
                let bend = ((4.0 * c4 * t[k] + 3.0 * c3) * t[k] + 2.0 * c2) * t[k] + c1;
                let third = (12.0 * c4 * t[k] + 6.0 * c3) * t[k] + 2.0 * c2;
                let jerk = (3.0 * bend * u + third * vv[k]) * v[k] * self.per_length;
                most.jerk = largest((jerk * inverse[axis]).abs(), most.jerk);
            }
        }
    }
}

/// Returns feed rate and tip rate at `s`, linear between nodes.
pub(super) fn rates_at<const N: usize>(piece: &AxisPiece<N>, interval: usize, s: f64) -> [f64; 2] {
    let (Some(from), Some(to)) = (piece.nodes.get(interval), piece.nodes.get(interval + 1)) else {
        return [0.0; 2];
    };
    let t = (s - from.s) / (to.s - from.s);
    let at = |from: f64, to: f64| from + t * (to - from);
    [at(from.feed_rate, to.feed_rate), at(from.tip_rate, to.tip_rate)]
}
