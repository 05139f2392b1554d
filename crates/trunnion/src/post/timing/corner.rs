//! Corner rounding: the distance from a corner at which the timed path may leave the straight segments.

use crate::blocks::arms;
use crate::machine::{FIRST_ROTARY, Kinematics};
use crate::types::AxisVector;

/// Deviation of the timed path from the segments, over the distance times the change of direction.
///
/// The Bernstein coefficients of the quintic give 0.3 where the neighbour is short; a third is an upper bound.
const STRAY: f64 = 1.0 / 3.0;

/// Corner where two straight segments of the axes meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct CornerBlend {
    /// Axes at the corner \[mm, rad\].
    pub(super) q: AxisVector,
    /// Changes of the axes by the path parameter, before and after.
    pub(super) rates: [AxisVector; 2],
    /// Length of the longer segment, in the path parameter.
    pub(super) length: f64,
}

/// Returns the sums of the linear and of the rotary parts.
fn sums(of: &AxisVector) -> [f64; 2] {
    [of.fixed_rows::<3>(0).abs().sum(), of.fixed_rows::<2>(FIRST_ROTARY).abs().sum()]
}

impl CornerBlend {
    /// Returns the distance from the corner, in the path parameter, over which tip \[mm\] and tool axis \[rad\] stay
    /// within `tolerance` of the segments; infinite if the direction does not change.
    ///
    /// The axes deviate by `d`, a part of their change of direction `c`, at most `STRAY r c` within the distance `r`.
    /// To first order the tool deviates by `J d`, `J` being the derivative of the forward map at the corner. `J` itself
    /// changes on the way `w` to where the axes are, at most `r (max |rate| + STRAY |c|)`: two changes `a` and `b` of
    /// the axes, with sums of linear parts `a_l`, `b_l` and rotary parts `a_w`, `b_w`, make the tip bend by at most
    /// `a_w b_l + a_l b_w + a_w b_w arm` and the tool axis by `a_w b_w`. Both together are a quadratic in `r`.
    pub(super) fn reach(&self, kinematics: &Kinematics, tolerance: [f64; 2]) -> f64 {
        let [before, after] = &self.rates;
        let change = after - before;
        // First order: the forward map applied to the deviation of the axes.
        let first = kinematics.forward_rate(&self.q, &change).map(|rate| STRAY * rate.norm());
        let way = before.abs().sup(&after.abs()) + change.abs() * STRAY;
        let [way, strays] = [sums(&way), sums(&change).map(|sum| STRAY * sum)];
        let arm = arms(kinematics.chain(), &self.q).into_iter().fold(0.0, f64::max);
        // The linear axes make the arm longer on the way.
        let arm = arm + self.length * way[0];
        // Second order: the bend of two changes of the axes.
        let turned = way[1] * strays[1];
        let second = [way[1] * strays[0] + way[0] * strays[1] + turned * arm, turned];
        [0, 1]
            .map(|k: usize| root(second[k], first[k], tolerance[k]))
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }
}

/// Returns the `x` above 0 at which `a x^2 + b x` is `c`, in a form that loses no digits where `a` is small.
fn root(a: f64, b: f64, c: f64) -> f64 {
    2.0 * c / (b + (b * b + 4.0 * a * c).sqrt())
}
