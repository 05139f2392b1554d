//! A schedule sampled at the servo period.

use crate::types::{AxisPath, AxisPiece, AxisVector, Schedule, SchedulePiece, Setpoint};

/// Why nothing was sampled.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SetpointError {
    /// The servo period is not a positive time.
    #[error("servo period is {value} s; it must be finite and positive, for instance 0.001")]
    BadPeriod {
        /// Value given \[s\].
        value: f64,
    },
    /// Path and schedule have different numbers of pieces.
    #[error("the path has {path} pieces, the schedule {schedule}; plan the path again")]
    PieceCount {
        /// Pieces of the path.
        path: usize,
        /// Pieces of the schedule.
        schedule: usize,
    },
    /// A piece of the path or of the schedule has less than two rows, or its lists differ in length.
    #[error("piece {piece} of path or schedule has less than two rows or lists of unequal length")]
    BadPiece {
        /// Index of the piece.
        piece: usize,
    },
}

/// Setpoints at every multiple of the servo period, and one exactly at the end.
///
/// An iterator of constant memory over a path and its schedule; see [`sample`].
#[derive(Debug, Clone)]
pub struct Setpoints<'a> {
    path: &'a AxisPath,
    schedule: &'a Schedule,
    period: f64,
    /// Index of the next setpoint.
    next: u64,
    /// Index of the setpoint at the end.
    last: u64,
    /// Piece that holds the time reached.
    piece: usize,
}

/// Samples position, velocity and acceleration of every axis at times 0, `period`, 2 `period`, ...
/// and at the end of the schedule, where the axes rest exactly on the path's last node.
///
/// Exact: `s` is quadratic in time between rows and the path is its own quintic, so a setpoint
/// lies on the path and its derivatives are the path's. A time at which acceleration steps belongs
/// to the row it starts.
///
/// # Errors
///
/// [`SetpointError`] if the period is not positive or the schedule does not belong to the path.
pub fn sample<'a>(
    path: &'a AxisPath,
    schedule: &'a Schedule,
    period: f64,
) -> Result<Setpoints<'a>, SetpointError> {
    if !(period > 0.0 && period.is_finite()) {
        return Err(SetpointError::BadPeriod { value: period });
    }
    let counts = [path.pieces.len(), schedule.pieces.len()];
    if counts[0] != counts[1] {
        return Err(SetpointError::PieceCount { path: counts[0], schedule: counts[1] });
    }
    for (piece, (nodes, rows)) in path.pieces.iter().zip(&schedule.pieces).enumerate() {
        if nodes.nodes.len() < 2 || !well_formed(rows) {
            return Err(SetpointError::BadPiece { piece });
        }
    }
    let last = ticks(schedule.duration(), period);
    Ok(Setpoints { path, schedule, period, next: 0, last, piece: 0 })
}

fn well_formed(rows: &SchedulePiece) -> bool {
    let count = rows.s.len();
    count >= 2 && [rows.t.len(), rows.speed.len(), rows.acceleration.len()] == [count; 3]
}

/// Number of periods that start before the end.
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

impl Setpoints<'_> {
    /// Number of setpoints still to come.
    pub fn remaining(&self) -> u64 {
        if self.path.pieces.is_empty() { 0 } else { (self.last + 1).saturating_sub(self.next) }
    }

    fn at(&mut self, t: f64) -> Option<Setpoint> {
        while self.schedule.pieces.get(self.piece)?.t.last().is_some_and(|&end| end <= t)
            && self.piece + 1 < self.schedule.pieces.len()
        {
            self.piece += 1;
        }
        setpoint(self.path.pieces.get(self.piece)?, self.schedule.pieces.get(self.piece)?, t)
    }

    /// The setpoint at the end: the last node itself, at rest.
    fn end(&self) -> Option<Setpoint> {
        let q = self.path.pieces.last()?.nodes.last()?.q;
        let acceleration = *self.schedule.pieces.last()?.acceleration.last()?;
        Some(Setpoint {
            t: self.schedule.duration(),
            position: q[0],
            velocity: AxisVector::zeros(),
            acceleration: q[1] * acceleration,
        })
    }
}

impl Iterator for Setpoints<'_> {
    type Item = Setpoint;

    fn next(&mut self) -> Option<Setpoint> {
        if self.remaining() == 0 {
            return None;
        }
        let index = self.next;
        self.next += 1;
        if index == self.last { self.end() } else { self.at(index as f64 * self.period) }
    }
}

/// Chain rule: `q̇ = q' v`, `q̈ = q' u + q'' v²`.
fn setpoint(piece: &AxisPiece, rows: &SchedulePiece, t: f64) -> Option<Setpoint> {
    let moment = rows.at_time(t)?;
    let [position, rate, curvature, _] = piece.axes_at(moment.s)?;
    Some(Setpoint {
        t,
        position,
        velocity: rate * moment.speed,
        acceleration: rate * moment.acceleration + curvature * moment.speed.powi(2),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{AxisNode, Motion};

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
            assert_eq!((last.t, last.position[0], last.velocity[0]), (1.5, 2.0, 0.0));
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
    fn what_does_not_belong_together_is_refused() {
        let (path, mut schedule) = example();
        let error = |period, schedule: &Schedule| sample(&path, schedule, period).unwrap_err();
        assert_eq!(error(-1.0, &schedule), SetpointError::BadPeriod { value: -1.0 });
        schedule.pieces[0].t.pop();
        assert_eq!(error(1.0, &schedule), SetpointError::BadPiece { piece: 0 });
        schedule.pieces.clear();
        assert_eq!(error(1.0, &schedule), SetpointError::PieceCount { path: 1, schedule: 0 });
    }

    #[test]
    fn an_empty_path_has_no_setpoints() {
        let (path, schedule) = (AxisPath::default(), Schedule::default());
        assert_eq!(sample(&path, &schedule, 0.001).unwrap().count(), 0);
    }
}
