//! Sampling of a schedule at the servo period.

use super::error::SetpointError;
use crate::types::{AXES, AxisPath, PathState, Schedule, Setpoint};

/// Iterator over the setpoints at every multiple of the servo period, and one exactly at the end.
///
/// Its memory does not grow with the path; see [`sample`].
#[derive(Debug, Clone)]
pub struct SetpointIter<'a, const N: usize = AXES> {
    path: &'a AxisPath<N>,
    schedule: &'a Schedule,
    period: f64,
    /// Index of the next setpoint.
    next: u64,
    /// Index of the setpoint at the end.
    last: u64,
    /// Piece that holds the time reached.
    piece: usize,
}

/// Samples position, velocity, acceleration and jerk of every axis at times 0, `period`, 2 `period`, ...
/// and at the end of the schedule, where the axes are exactly on the path's last node.
///
/// The samples are exact: between rows `s` follows the schedule's acceleration profile, and the path is
/// its own quintic. A setpoint lies on the path and its derivatives are the path's: jerk is the
/// feed-forward of the motion itself, not a difference. A time at which acceleration steps belongs to the
/// row it starts.
///
/// # Errors
///
/// [`SetpointError`] if the period is not positive or the schedule does not belong to the path.
///
/// # Example
///
/// One axis at 2 mm/s over 1 mm, sampled every 0.25 s:
///
/// ```
/// use nalgebra::Vector1;
/// use trunnion_motion::setpoint::sample;
/// use trunnion_motion::types::{
///     AccelerationProfile, AxisNode, AxisPath, AxisPiece, Motion, Schedule, SchedulePiece,
/// };
///
/// let node = |s: f64| {
///     let q = [Vector1::new(s), Vector1::new(1.0), Vector1::zeros(), Vector1::zeros()];
///     AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
/// };
/// let nodes = vec![node(0.0), node(1.0)];
/// let path = AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] };
/// let rows = SchedulePiece {
///     s: vec![0.0, 1.0],
///     t: vec![0.0, 0.5],
///     speed: vec![2.0; 2],
///     acceleration: vec![0.0; 2],
///     profile: AccelerationProfile::Constant,
/// };
/// let schedule = Schedule { pieces: vec![rows] };
/// let positions: Vec<f64> =
///     sample(&path, &schedule, 0.25)?.map(|point| point.position.x).collect();
/// assert_eq!(positions, [0.0, 0.5, 1.0]);
/// # Ok::<(), trunnion_motion::setpoint::SetpointError>(())
/// ```
pub fn sample<'a, const N: usize>(
    path: &'a AxisPath<N>,
    schedule: &'a Schedule,
    period: f64,
) -> Result<SetpointIter<'a, N>, SetpointError> {
    if !(period > 0.0 && period.is_finite()) {
        return Err(SetpointError::BadPeriod { value: period });
    }
    schedule.check_against(path)?;
    let last = ticks(schedule.duration(), period);
    Ok(SetpointIter { path, schedule, period, next: 0, last, piece: 0 })
}

/// Returns the number of periods that start before the end.
///
/// The quotient is right to half a unit in its last place and the duration is a sum whose own
/// rounding is of that order: a quotient that close above a whole number is that number, or a
/// setpoint would precede the last one by less than rounding.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "positive; a duration of 2^64 periods saturates"
)]
fn ticks(duration: f64, period: f64) -> u64 {
    const QUOTIENT_ROUNDING: f64 = 64.0 * f64::EPSILON;
    (duration / period * (1.0 - QUOTIENT_ROUNDING)).ceil() as u64
}

impl<const N: usize> SetpointIter<'_, N> {
    /// Returns the number of setpoints still to come.
    pub fn remaining(&self) -> u64 {
        if self.path.pieces.is_empty() {
            0
        } else {
            self.last.saturating_add(1).saturating_sub(self.next)
        }
    }

    /// Returns the setpoint at time `t`, which does not decrease from call to call.
    fn at(&mut self, t: f64) -> Option<Setpoint<N>> {
        // A time at which two pieces meet belongs to the later one, which starts there.
        while self.schedule.pieces.get(self.piece)?.t.last().is_some_and(|&end| end <= t)
            && self.piece + 1 < self.schedule.pieces.len()
        {
            self.piece += 1;
        }
        let state = self.schedule.pieces.get(self.piece)?.at_time(t)?;
        let axes = self.path.pieces.get(self.piece)?.axes_at(state.s)?;
        Some(Setpoint::on_path(t, axes, &state))
    }

    /// Returns the setpoint at the end: exactly the last node.
    fn end(&self) -> Option<Setpoint<N>> {
        // The state at the end is that of the last row: sampling would round it.
        let node = self.path.pieces.last()?.nodes.last()?;
        let t = self.schedule.duration();
        let rows = self.schedule.pieces.last()?;
        let state = rows.at_time(t)?;
        let [speed, acceleration] = [*rows.speed.last()?, *rows.acceleration.last()?];
        Some(Setpoint::on_path(t, node.q, &PathState { s: node.s, speed, acceleration, ..state }))
    }
}

impl<const N: usize> Iterator for SetpointIter<'_, N> {
    type Item = Setpoint<N>;

    fn next(&mut self) -> Option<Setpoint<N>> {
        if self.remaining() == 0 {
            return None;
        }
        let index = self.next;
        self.next += 1;
        // A product instead of a sum: the times do not drift with the number of setpoints.
        if index == self.last { self.end() } else { self.at(index as f64 * self.period) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{
        AccelerationProfile, AxisNode, AxisPiece, AxisVector, Motion, ScheduleError, SchedulePiece,
    };

    /// X goes 1 mm in 1 s at constant acceleration 2 mm/s², then 1 mm at 2 mm/s: 1.5 s in all.
    fn example() -> (AxisPath, Schedule) {
        let at = |s: f64| {
            let [x, rate] = [s, 1.0].map(|x| AxisVector::from([x, 0.0, 0.0, 0.0, 0.0]));
            let q = [x, rate, AxisVector::zeros(), AxisVector::zeros()];
            AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
        };
        let piece = AxisPiece { motion: Motion::Cut, source: 0, nodes: vec![at(0.0), at(2.0)] };
        let rows = SchedulePiece {
            s: vec![0.0, 1.0, 2.0],
            t: vec![0.0, 1.0, 1.5],
            speed: vec![0.0, 2.0, 2.0],
            acceleration: vec![2.0, 0.0, 0.0],
            ..SchedulePiece::default()
        };
        (AxisPath { pieces: vec![piece] }, Schedule { pieces: vec![rows] })
    }

    #[test]
    fn the_last_setpoint_lies_exactly_on_the_end() {
        let (path, schedule) = example();
        for (period, count) in [(0.5, 4), (0.1, 16), (0.4, 5), (7.0, 2)] {
            let setpoints = sample(&path, &schedule, period).unwrap();
            assert_eq!(setpoints.remaining(), count);
            let all: Vec<Setpoint> = setpoints.collect();
            assert_eq!(all.len() as u64, count, "{period}");
            let last = all.last().unwrap();
            assert_eq!((last.t, last.position[0], last.velocity[0]), (1.5, 2.0, 2.0));
        }
    }

    /// X = s + s² at constant `ds/dt` = 2: x' = 1 + 2 s, so velocity 2 + 4 s, acceleration 8, jerk 0;
    /// Y = s³ / 6: jerk 8.
    #[test]
    fn jerk_is_that_of_the_motion() {
        let at = |s: f64| {
            let mut q = [AxisVector::zeros(); 4];
            (q[0][0], q[1][0], q[2][0]) = (s + s * s, 1.0 + 2.0 * s, 2.0);
            (q[0][1], q[1][1], q[2][1], q[3][1]) = (s.powi(3) / 6.0, s * s / 2.0, s, 1.0);
            AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
        };
        let piece = AxisPiece { motion: Motion::Cut, source: 0, nodes: vec![at(0.0), at(1.0)] };
        let path = AxisPath { pieces: vec![piece] };
        let rows = |t: f64, speed: [f64; 2], acceleration: [f64; 2], profile| Schedule {
            pieces: vec![SchedulePiece {
                s: vec![0.0, 1.0],
                t: vec![0.0, t],
                speed: speed.to_vec(),
                acceleration: acceleration.to_vec(),
                profile,
            }],
        };
        let even = rows(0.5, [2.0; 2], [0.0; 2], AccelerationProfile::Constant);
        for point in sample(&path, &even, 0.125).unwrap() {
            let s = 2.0 * point.t;
            assert!((point.velocity[0] - 2.0 - 4.0 * s).abs() < 1e-12);
            assert!((point.acceleration[0] - 8.0).abs() < 1e-11 && point.jerk[0].abs() < 1e-9);
            assert!((point.jerk[1] - 8.0).abs() < 1e-9, "{:?}", point.jerk);
        }
        // s = t³: X = t³ + t⁶, so velocity 3 t² + 6 t⁵ and jerk 6 + 120 t³.
        let from_rest = rows(1.0, [0.0, 3.0], [0.0, 6.0], AccelerationProfile::Linear);
        for point in sample(&path, &from_rest, 0.25).unwrap() {
            let t = point.t;
            assert!((point.velocity[0] - 3.0 * t * t - 6.0 * t.powi(5)).abs() < 1e-12);
            assert!(
                (point.jerk[0] - 6.0 - 120.0 * t.powi(3)).abs() < 1e-9,
                "{t}: {:?}",
                point.jerk
            );
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn samples_are_a_pencil_calculation() {
        let (path, schedule) = example();
        let all: Vec<Setpoint> = sample(&path, &schedule, 0.5).unwrap().collect();
        let x = |k: usize| [all[k].position[0], all[k].velocity[0], all[k].acceleration[0]];
        assert_eq!(x(0), [0.0, 0.0, 2.0]);
        assert_eq!(x(1), [0.25, 1.0, 2.0]);
        assert_eq!(x(2), [1.0, 2.0, 0.0]);
    }

    #[test]
    fn more_periods_than_can_be_counted_are_not_none() {
        let (path, schedule) = example();
        let mut endless = sample(&path, &schedule, 1e-300).unwrap();
        assert_eq!(endless.remaining(), u64::MAX);
        assert!(endless.next().is_some());
    }

    #[test]
    fn what_does_not_belong_together_is_refused() {
        let (path, mut schedule) = example();
        let error = |period, schedule: &Schedule| sample(&path, schedule, period).unwrap_err();
        assert_eq!(error(-1.0, &schedule), SetpointError::BadPeriod { value: -1.0 });
        schedule.pieces[0].t.pop();
        assert_eq!(
            error(1.0, &schedule),
            SetpointError::Schedule(ScheduleError::BadPiece { piece: 0 })
        );
        schedule.pieces.clear();
        assert_eq!(
            error(1.0, &schedule),
            SetpointError::Schedule(ScheduleError::PieceCount { path: 1, schedule: 0 })
        );
    }

    #[test]
    fn an_empty_path_has_no_setpoints() {
        let (path, schedule) = (AxisPath::<AXES>::default(), Schedule::default());
        assert_eq!(sample(&path, &schedule, 0.001).unwrap().count(), 0);
    }
}
