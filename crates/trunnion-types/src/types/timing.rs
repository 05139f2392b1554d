//! Where an axis path is at a given time, and when it is at a given place.

use super::{AxisPiece, Law, SchedulePiece, Stretch};
use crate::math::quintic::Quintic;
use nalgebra::SVector;

/// Place and speed along a piece at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Path parameter.
    pub s: f64,
    /// `ds/dt`.
    pub speed: f64,
    /// `d²s/dt²`.
    pub acceleration: f64,
    /// `d³s/dt³`; 0 between rows at which the acceleration steps.
    pub jerk: f64,
}

impl SchedulePiece {
    /// Place, speed, acceleration and jerk at time `t`, clamped to the piece.
    ///
    /// `None` for a piece without rows.
    pub fn at_time(&self, t: f64) -> Option<Moment> {
        let row = interval(&self.t, t);
        let [s, start] = [*self.s.get(row)?, *self.t.get(row)?];
        let last = self.t.last().copied().unwrap_or(start);
        let dt = (t.min(last) - start).max(0.0);
        let end = self.s.get(row + 1).copied().unwrap_or(s);
        let [advance, speed, acceleration, jerk] = self.advance(row, dt)?;
        Some(Moment { s: (s + advance).clamp(s, end), speed: speed.max(0.0), acceleration, jerk })
    }

    /// Distance from a row and its derivatives by time, a time after it.
    pub fn advance(&self, row: usize, dt: f64) -> Option<[f64; 4]> {
        let [speed, acceleration] = [*self.speed.get(row)?, *self.acceleration.get(row)?];
        if let (Law::Ramps, Some(stretch)) = (self.law, self.stretch(row)) {
            return Some(stretch.at(dt));
        }
        let advance = dt * (speed + 0.5 * acceleration * dt);
        Some([advance, speed + acceleration * dt, acceleration, 0.0])
    }

    /// The stretch from a row to the next under [`Law::Ramps`].
    fn stretch(&self, row: usize) -> Option<Stretch> {
        let pair = |list: &[f64]| Some([*list.get(row)?, *list.get(row + 1)?]);
        let [from, to] = pair(&self.s)?;
        let [speed, acceleration] = [pair(&self.speed)?, pair(&self.acceleration)?];
        Some(Stretch { length: to - from, speed, acceleration })
    }

    /// Time at which `s` is passed, clamped to the piece \[s\]; 0 for a piece without rows.
    pub fn time_at(&self, s: f64) -> f64 {
        let row = interval(&self.s, s);
        let (Some(&from), Some(&start)) = (self.s.get(row), self.t.get(row)) else {
            return 0.0;
        };
        let Some(stretch) = self.stretch(row) else { return start };
        let end = self.t.get(row + 1).copied().unwrap_or(start);
        if s <= from {
            return start;
        }
        if s - from >= stretch.length {
            return end;
        }
        match self.law {
            Law::Steps => steps_time(&stretch, s - from, [start, end]),
            Law::Ramps => (start + stretch.time_to(s - from)).clamp(start, end),
        }
    }
}

/// `dt = 2 ds / (v + sqrt(v² + 2 |a| ds))` from the slower end of the interval: nothing cancels, not
/// even on the way to rest, and `v = 0` or `a = 0` are no special cases.
fn steps_time(stretch: &Stretch, ds: f64, [start, end]: [f64; 2]) -> f64 {
    let acceleration = stretch.acceleration[0];
    let elapsed = |ds: f64, slow: f64| {
        2.0 * ds / (slow + (slow * slow + 2.0 * acceleration.abs() * ds).sqrt())
    };
    if acceleration < 0.0 {
        (end - elapsed(stretch.length - ds, stretch.speed[1])).max(start)
    } else {
        (start + elapsed(ds, stretch.speed[0])).min(end)
    }
}

impl<const N: usize> AxisPiece<N> {
    /// Index of the interval between nodes that holds `s`; ends are clamped.
    pub fn interval_at(&self, s: f64) -> usize {
        let after = self.nodes.partition_point(|node| node.s <= s);
        after.saturating_sub(1).min(self.nodes.len().saturating_sub(2))
    }

    /// The quintic from node `interval` to the next, in `s` from that node, and the node's `s`;
    /// `None` if there is no such interval.
    pub fn quintic(&self, interval: usize) -> Option<(f64, Quintic<N>)> {
        let [from, to] = [self.nodes.get(interval)?, self.nodes.get(interval + 1)?];
        let jet = |q: &[SVector<f64, N>; 4]| [q[0], q[1], q[2]];
        Some((from.s, Quintic::new(to.s - from.s, jet(&from.q), jet(&to.q))))
    }

    /// Axes and their first three derivatives by `s`, clamped to the piece; exact at nodes.
    /// `None` for a piece of less than two nodes.
    pub fn axes_at(&self, s: f64) -> Option<[SVector<f64, N>; 4]> {
        let interval = self.interval_at(s);
        let (start, quintic) = self.quintic(interval)?;
        let end = self.nodes.get(interval + 1)?;
        Some(if s < end.s { quintic.at((s - start).max(0.0)) } else { end.q })
    }

    /// Axes at `s`, clamped to the piece; exact at nodes. `None` for a piece of less than two nodes.
    pub fn position_at(&self, s: f64) -> Option<SVector<f64, N>> {
        let interval = self.interval_at(s);
        let (start, quintic) = self.quintic(interval)?;
        let end = self.nodes.get(interval + 1)?;
        Some(if s < end.s { quintic.value((s - start).max(0.0)) } else { end.q[0] })
    }
}

/// Index of the interval of an increasing list that holds `value`; ends are clamped.
fn interval(list: &[f64], value: f64) -> usize {
    let after = list.partition_point(|&entry| entry <= value);
    after.saturating_sub(1).min(list.len().saturating_sub(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 s from rest at 2 mm/s², then 1 s at 2 mm/s.
    fn ramp() -> SchedulePiece {
        SchedulePiece {
            s: vec![0.0, 1.0, 3.0],
            t: vec![5.0, 6.0, 7.0],
            speed: vec![0.0, 2.0, 2.0],
            acceleration: vec![2.0, 0.0, 0.0],
            law: Law::Steps,
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn time_and_place_of_a_ramp_are_a_pencil_calculation() {
        let half = ramp().at_time(5.5).unwrap();
        assert_eq!(half, Moment { s: 0.25, speed: 1.0, acceleration: 2.0, jerk: 0.0 });
        assert_eq!(ramp().at_time(6.5).unwrap().s, 2.0);
        assert_eq!(ramp().at_time(9.0).unwrap().s, 3.0);
        assert_eq!(ramp().at_time(0.0).unwrap().s, 0.0);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn time_at_inverts_at_time() {
        for k in 0..=20 {
            let t = 5.0 + 0.1 * f64::from(k);
            let s = ramp().at_time(t).unwrap().s;
            assert!((ramp().time_at(s) - t).abs() < 1e-14 * 10.0, "{t}");
        }
        // 1 mm to rest at 2 mm/s²: a quarter of a millimetre before the end is half a second.
        let stop = SchedulePiece {
            s: vec![0.0, 1.0],
            t: vec![0.0, 1.0],
            speed: vec![2.0, 0.0],
            acceleration: vec![-2.0; 2],
            law: Law::Steps,
        };
        assert_eq!((stop.time_at(0.75), stop.time_at(1.0)), (0.5, 1.0));
        assert_eq!(ramp().time_at(-1.0), 5.0);
        assert_eq!(ramp().time_at(4.0), 7.0);
    }

    #[test]
    fn an_empty_piece_has_no_moment() {
        assert_eq!(SchedulePiece::default().at_time(0.0), None);
    }
}
