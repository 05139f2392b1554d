//! Bounds on the second derivatives of paths of tool poses.

use crate::machine::{ChainGeometry, FIRST_ROTARY, SECOND_ROTARY};
use crate::math;
use crate::math::quintic::Quintic;
use crate::types::{AXES, AxisVector};
use nalgebra::Vector3;

/// Largest first and second derivatives of each axis over an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisRates {
    pub(super) first: AxisVector,
    pub(super) second: AxisVector,
}

/// Largest second derivatives of tip \[mm\] and tool axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PoseBend {
    pub(super) tip: f64,
    pub(super) axis: f64,
}

/// Distances of the tip from the two rotary axes, workpiece side first \[mm\].
pub(crate) type RotaryArms = [f64; 2];

impl AxisRates {
    /// Returns the rates of a straight move by `travel` over an interval of length 1.
    pub(super) fn straight(travel: &AxisVector) -> Self {
        Self { first: travel.abs(), second: AxisVector::zeros() }
    }

    /// Bounds the rates of a quintic: its derivatives lie in the convex hull of their Bernstein
    /// coefficients.
    pub(super) fn of(quintic: &Quintic<AXES>) -> Self {
        let c = quintic.powers();
        let width = quintic.length();
        // Coefficients of the derivatives by powers: k c_k, and once more.
        let first: [AxisVector; 5] = std::array::from_fn(|k| c[k + 1] * (k as f64 + 1.0));
        let second: [AxisVector; 4] = std::array::from_fn(|k| first[k + 1] * (k as f64 + 1.0));
        // The powers count the interval as length 1: each derivative brings one division by its
        // width.
        Self { first: largest(first) / width, second: largest(second) / (width * width) }
    }

    /// Returns the larger of both, axis by axis.
    pub(super) fn worst(&self, other: &Self) -> Self {
        Self { first: self.first.sup(&other.first), second: self.second.sup(&other.second) }
    }

    /// Returns the rates over an interval of `width`, taken as interval of length 1.
    pub(super) fn scaled(&self, width: f64) -> Self {
        Self { first: self.first * width, second: self.second * (width * width) }
    }
}

/// Returns the largest sizes of the Bernstein coefficients of a polynomial given by its powers:
/// `b_j = sum_k C(j,k) / C(n,k) c_k`.
fn largest<const N: usize>(mut row: [AxisVector; N]) -> AxisVector {
    let degree = N - 1;
    let mut choose = 1.0;
    for (k, c) in row.iter_mut().enumerate() {
        *c /= choose;
        choose *= (degree - k) as f64 / (k as f64 + 1.0);
    }
    // Sums of binomials: the scaled powers become Bernstein coefficients by repeated addition of
    // neighbours.
    for step in (1..=degree).rev() {
        for i in step..=degree {
            let before = row[i - 1];
            row[i] += before;
        }
    }
    // A polynomial lies in the convex hull of its Bernstein coefficients.
    row.iter().fold(AxisVector::zeros(), |most, c| most.sup(&c.abs()))
}

/// Sums the linear axes before, between and after the rotaries.
fn stages(chain: &ChainGeometry, of: &AxisVector) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (axis, &stage) in chain.stage.iter().enumerate() {
        if let Some(sum) = sums.get_mut(stage) {
            *sum += of[axis];
        }
    }
    sums
}

/// Returns the distances of the tip from the rotary axes at `q`.
pub(crate) fn arms(chain: &ChainGeometry, q: &AxisVector) -> RotaryArms {
    let [first, second] = &chain.rotary;
    let linear = Vector3::new(q[0], q[1], q[2]);
    // Tip as seen from the second rotary, turned with it, then as seen from the first.
    let inner = chain.slides[2] * linear + (chain.tip - second.point);
    let turned = math::rotation_about(&second.dir, q[SECOND_ROTARY]) * inner;
    let middle = chain.slides[1] * linear + (second.point - first.point) + turned;
    // Distance of a point from an axis through the origin: |p x d| for a unit vector d.
    [middle.cross(&first.dir).norm(), inner.cross(&second.dir).norm()]
}

impl PoseBend {
    /// Bounds the forward map along axes with these rates over an interval of length 1, both ends of
    /// which have at most these arms. In between, an arm is longer by at most what half the interval adds.
    ///
    /// Twice differentiated, `R(q) v` is at most `|v''| + 2 |q'| |v'| + (q'² + |q''|) arm`.
    pub(super) fn of(chain: &ChainGeometry, rates: &AxisRates, ends: RotaryArms) -> Self {
        let AxisRates { first, second } = rates;
        // Linear axes before, between and after the rotaries add to different parts of the chain.
        let [speed, change] = [stages(chain, first), stages(chain, second)];
        let [w1, w2] = [first[FIRST_ROTARY], first[SECOND_ROTARY]];
        let [a1, a2] = [second[FIRST_ROTARY], second[SECOND_ROTARY]];
        // An arm grows by no more than the linear axes move in half the interval.
        let inner_arm = ends[1] + 0.5 * speed[2];
        let inner_speed = speed[1] + speed[2] + w2 * inner_arm;
        let outer_arm = ends[0] + 0.5 * inner_speed;
        // |(R(q) v)''| <= |v''| + 2 |q'| |v'| + (q'^2 + |q''|) arm for the rotary nearer the tip.
        let inner = change[1] + change[2] + 2.0 * w2 * speed[2] + (w2 * w2 + a2) * inner_arm;
        // The same for the outer rotary, which turns all of the inner chain.
        let tip = change[0] + inner + 2.0 * w1 * inner_speed + (w1 * w1 + a1) * outer_arm;
        // The axis vector is the same with arm 1 and no linear motion, both rotaries together: (w1
        // + w2)^2 + a1 + a2.
        Self { tip, axis: (w1 + w2).powi(2) + a1 + a2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Kinematics, Machine, Setup};
    use crate::sample_machine::ac_trunnion;

    #[test]
    fn a_turning_table_bends_the_tip_by_its_arm() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        let setup = Setup::new(Vector3::zeros(), [0.0; 3], 100.0);
        let kinematics = Kinematics::new(&machine, &setup);
        let chain = kinematics.chain();
        let rest = AxisVector::from([50.0, 0.0, 0.0, 0.0, 0.0]);
        let mut travel = AxisVector::zeros();
        travel[FIRST_ROTARY] = 0.1;
        let ends = arms(chain, &rest);
        let bend = PoseBend::of(chain, &AxisRates::straight(&travel), ends);
        assert!((bend.tip - 0.01 * ends[0]).abs() < 1e-12 && (bend.axis - 0.01).abs() < 1e-15);
    }

    /// Against second differences of the forward map along random quintics.
    #[test]
    fn nothing_bends_more_than_its_bound() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        let setup = Setup::new(Vector3::new(40.0, -30.0, 20.0), [0.1, 0.2, 0.3], 120.0);
        let kinematics = Kinematics::new(&machine, &setup);
        for seed in 0..20 {
            let row = |k: u32| {
                AxisVector::from_fn(|i, _| {
                    let size = if i < 3 { 5.0 } else { 0.2 };
                    size * (f64::from(7 * seed + 5 * k) + 1.7 * i as f64).sin()
                })
            };
            let quintic = Quintic::new(1.0, [row(0), row(1), row(2)], [row(3), row(4), row(5)]);
            let rates = AxisRates::of(&quintic);
            let pose = |x: f64| kinematics.forward(&quintic.value(x));
            let ends = [0.0, 1.0].map(|x| arms(kinematics.chain(), &quintic.value(x)));
            let ends = [0, 1].map(|k: usize| ends[0][k].max(ends[1][k]));
            let bound = PoseBend::of(kinematics.chain(), &rates, ends);
            for k in 1..100 {
                let [x, h] = [f64::from(k) / 100.0, 1e-3];
                let [a, b, c] = [x - h, x, x + h].map(pose);
                let tip = (a.tip.coords + c.tip.coords - b.tip.coords * 2.0).norm() / (h * h);
                let axis = (*a.axis + *c.axis - *b.axis * 2.0).norm() / (h * h);
                assert!(tip <= bound.tip * 1.0001 && axis <= bound.axis * 1.0001, "{seed} {k}");
            }
        }
    }
}
