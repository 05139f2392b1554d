//! Dense measurement of a jerk-limited schedule with another discretisation.

use crate::feed::measure::{MeasuredRatios, rates_at};
use crate::feed::plan::{BindingLimit, LimitRatios};
use crate::feed::reciprocal::ReciprocalLimits;
use crate::types::{AxisPiece, SchedulePiece};
use nalgebra::SVector;

/// Even steps in time per row; their ends are measured too, as jerk steps at rows.
const STEPS: u32 = 4;

/// Ratios of velocities, accelerations and jerks at one time.
struct MomentRatios<const N: usize> {
    axes: [SVector<f64, N>; 3],
    /// Programmed feed and tip speed.
    points: [f64; 2],
}

/// Calls `visit` with the row and the ratios at moments even in time. The path is evaluated in the power
/// basis, so that neither the points nor the basis of the planner are used.
fn each_moment<const N: usize>(
    piece: &AxisPiece<N>,
    schedule: &SchedulePiece,
    limits: &ReciprocalLimits<N>,
    mut visit: impl FnMut(usize, &MomentRatios<N>),
) {
    let jerk_limits = limits.jerk.unwrap_or_else(SVector::zeros);
    let mut interval = usize::MAX;
    let mut curve = None;
    for row in 0..schedule.s.len().saturating_sub(1) {
        // Every node is a row, so that a row interval lies in one interval between nodes.
        let here = piece.interval_at(schedule.s[row]);
        if here != interval {
            (interval, curve) = (here, piece.quintic(here));
        }
        let Some((origin, quintic)) = curve else { break };
        let duration = schedule.t[row + 1] - schedule.t[row];
        for step in 0..=STEPS {
            let dt = duration * f64::from(step) / f64::from(STEPS);
            let Some([x, v, a, j]) = schedule.advance(row, dt) else { continue };
            let s = schedule.s[row] + x;
            // q' j + 3 q'' v a + q''' v³: jerk by the chain rule, with j = d³s/dt³.
            let [_, q1, q2, q3] = quintic.at(s - origin);
            let [feed, tip] = rates_at(piece, interval, s);
            visit(
                row,
                &MomentRatios {
                    axes: [
                        (q1 * v).component_mul(&limits.velocity.plus),
                        (q1 * a + q2 * (v * v)).component_mul(&limits.acceleration.plus),
                        (q1 * j + q2 * (3.0 * v * a) + q3 * v.powi(3)).component_mul(&jerk_limits),
                    ],
                    points: [v * feed * limits.feed, v * tip * limits.tip],
                },
            );
        }
    }
}

/// Measures the largest ratios of a schedule, evenly in time.
pub(super) fn measure<const N: usize>(
    piece: &AxisPiece<N>,
    schedule: &SchedulePiece,
    limits: &ReciprocalLimits<N>,
) -> MeasuredRatios {
    let mut ratios = LimitRatios { jerk: Some(0.0), ..LimitRatios::default() };
    each_moment(piece, schedule, limits, |_, state| {
        let [velocity, acceleration, jerk] = state.axes.map(|values| values.amax());
        let velocity = velocity.max(state.points[0]).max(state.points[1]);
        ratios = ratios.max(LimitRatios { velocity, acceleration, jerk: Some(jerk) });
    });
    MeasuredRatios { ratios, acceleration_step: 0.0 }
}

/// Returns the limit used most from each row to the next; the last entry repeats.
pub(super) fn binding<const N: usize>(
    piece: &AxisPiece<N>,
    schedule: &SchedulePiece,
    limits: &ReciprocalLimits<N>,
) -> Vec<BindingLimit> {
    let mut most = vec![(0.0, BindingLimit::Still); schedule.s.len()];
    each_moment(piece, schedule, limits, |row, state| {
        let mut add = |share: f64, name: BindingLimit| {
            if share > most[row].0 {
                most[row] = (share, name);
            }
        };
        let kinds = [BindingLimit::Velocity, BindingLimit::Acceleration, BindingLimit::Jerk];
        for (values, kind) in state.axes.iter().zip(kinds) {
            for (axis, value) in values.iter().enumerate() {
                add(value.abs(), kind(u8::try_from(axis).unwrap_or(u8::MAX)));
            }
        }
        add(state.points[0], BindingLimit::Feed);
        add(state.points[1], BindingLimit::Tip);
    });
    // No interval begins at the last row.
    if let [.., before, last] = most.as_mut_slice() {
        *last = *before;
    }
    most.into_iter().map(|(_, name)| name).collect()
}
