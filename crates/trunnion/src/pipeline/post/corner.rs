//! How far the path that is timed may round a corner between two straight stretches of axes.

use crate::blocks::arms;
use crate::machine::{FIRST_ROTARY, Kinematics};
use crate::types::AxisVector;

/// Between its straight part and a block end, the path that is timed strays from the stretches by at most a third of
/// the distance times the change of direction: from the Bernstein coefficients of the quintic, 0.3 of it, where the
/// neighbour is short.
const STRAY: f64 = 1.0 / 3.0;

/// Two stretches that meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    /// Where \[mm, rad\].
    pub(super) q: AxisVector,
    /// Changes of the axes by the path parameter, before and after.
    pub(super) rates: [AxisVector; 2],
    /// The longer of the two stretches, in the path parameter.
    pub(super) length: f64,
}

/// Sums of the linear and of the rotary parts.
fn sums(of: &AxisVector) -> [f64; 2] {
    [of.fixed_rows::<3>(0).abs().sum(), of.fixed_rows::<2>(FIRST_ROTARY).abs().sum()]
}

impl Corner {
    /// Distance from the corner, in the path parameter, over which tip \[mm\] and tool axis \[rad\] stay within
    /// `tolerance` of the stretches; infinite where nothing changes.
    ///
    /// The axes stray by `d`, a part of their change of direction `c`, at most `STRAY r c` within the distance `r`.
    /// To first order the tool strays by `J d`, `J` being the derivative of the forward map at the corner. `J` itself
    /// changes on the way `w` to where the axes are, at most `r (max |rate| + STRAY |c|)`: two changes `a` and `b` of
    /// the axes, with sums of linear parts `a_l`, `b_l` and rotary parts `a_w`, `b_w`, make the tip bend by at most
    /// `a_w b_l + a_l b_w + a_w b_w arm` and the tool axis by `a_w b_w`. Both together are a quadratic in `r`.
    pub(super) fn reach(&self, kinematics: &Kinematics, tolerance: [f64; 2]) -> f64 {
        let [before, after] = &self.rates;
        let change = after - before;
        let first = kinematics.forward_rate(&self.q, &change).map(|rate| STRAY * rate.norm());
        let way = before.abs().sup(&after.abs()) + change.abs() * STRAY;
        let [way, strays] = [sums(&way), sums(&change).map(|sum| STRAY * sum)];
        let arm = arms(kinematics.chain(), &self.q).into_iter().fold(0.0, f64::max);
        // Meanwhile the linear axes make it longer.
        let arm = arm + self.length * way[0];
        let turned = way[1] * strays[1];
        let second = [way[1] * strays[0] + way[0] * strays[1] + turned * arm, turned];
        [0, 1]
            .map(|k: usize| root(second[k], first[k], tolerance[k]))
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }
}

/// The `x` above 0 at which `a x^2 + b x` is `c`, in a form that loses no digits where `a` is small.
fn root(a: f64, b: f64, c: f64) -> f64 {
    2.0 * c / (b + (b * b + 4.0 * a * c).sqrt())
}
