//! State of a scheduled piece at one time, and the time at which it passes a point.

use super::linear_segment::LinearSegment;
use super::schedule::{AccelerationProfile, SchedulePiece};

/// Path parameter of a piece at one time, and its derivatives by time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathState {
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
    /// Returns path parameter, speed, acceleration and jerk at time `t` \[s\], clamped to the piece.
    ///
    /// `None` for a piece without rows.
    pub fn at_time(&self, t: f64) -> Option<PathState> {
        let row = interval(&self.t, t);
        let [s, start] = [*self.s.get(row)?, *self.t.get(row)?];
        let last = self.t.last().copied().unwrap_or(start);
        // Rounding may leave the row by a little: times and positions are kept inside it.
        let dt = (t.min(last) - start).max(0.0);
        let end = self.s.get(row + 1).copied().unwrap_or(s);
        let [advance, speed, acceleration, jerk] = self.advance(row, dt)?;
        Some(PathState {
            s: (s + advance).clamp(s, end),
            speed: speed.max(0.0),
            acceleration,
            jerk,
        })
    }

    /// Returns the advance `s - s[row]` and its first three derivatives by time, `dt` \[s\] after the row.
    pub fn advance(&self, row: usize, dt: f64) -> Option<[f64; 4]> {
        let [speed, acceleration] = [*self.speed.get(row)?, *self.acceleration.get(row)?];
        if let (AccelerationProfile::Linear, Some(segment)) = (self.profile, self.segment(row)) {
            return Some(segment.at(dt));
        }
        // Constant acceleration from row to row.
        let advance = dt * (speed + 0.5 * acceleration * dt);
        Some([advance, speed + acceleration * dt, acceleration, 0.0])
    }

    /// Returns the segment from a row to the next.
    fn segment(&self, row: usize) -> Option<LinearSegment> {
        let pair = |list: &[f64]| Some([*list.get(row)?, *list.get(row + 1)?]);
        let [from, to] = pair(&self.s)?;
        let [speed, acceleration] = [pair(&self.speed)?, pair(&self.acceleration)?];
        Some(LinearSegment { length: to - from, speed, acceleration })
    }

    /// Returns the time at which `s` is passed, clamped to the piece \[s\]; 0 for a piece without rows.
    pub fn time_at(&self, s: f64) -> f64 {
        let row = interval(&self.s, s);
        let (Some(&from), Some(&start)) = (self.s.get(row), self.t.get(row)) else {
            return 0.0;
        };
        let Some(segment) = self.segment(row) else { return start };
        let end = self.t.get(row + 1).copied().unwrap_or(start);
        // Rows themselves are exact.
        if s <= from {
            return start;
        }
        if s - from >= segment.length {
            return end;
        }
        match self.profile {
            AccelerationProfile::Constant => {
                constant_acceleration_time(&segment, s - from, [start, end])
            }
            AccelerationProfile::Linear => (start + segment.time_to(s - from)).clamp(start, end),
        }
    }
}

/// Returns the time at distance `ds` from the start of a segment of constant acceleration.
///
/// `dt = 2 ds / (v + sqrt(v² + 2 |a| ds))` from the slower end of the interval: nothing cancels, not
/// even on the way to rest, and `v = 0` or `a = 0` are no special cases.
fn constant_acceleration_time(segment: &LinearSegment, ds: f64, [start, end]: [f64; 2]) -> f64 {
    let acceleration = segment.acceleration[0];
    let elapsed = |ds: f64, slow: f64| {
        2.0 * ds / (slow + (slow * slow + 2.0 * acceleration.abs() * ds).sqrt())
    };
    // Braking: the slower end is the far one, so the time that is left is subtracted from the end.
    if acceleration < 0.0 {
        (end - elapsed(segment.length - ds, segment.speed[1])).max(start)
    } else {
        (start + elapsed(ds, segment.speed[0])).min(end)
    }
}

/// Returns the index of the interval of an increasing list that holds `value`; ends are clamped.
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
            profile: AccelerationProfile::Constant,
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn time_and_place_of_a_ramp_are_a_pencil_calculation() {
        let half = ramp().at_time(5.5).unwrap();
        assert_eq!(half, PathState { s: 0.25, speed: 1.0, acceleration: 2.0, jerk: 0.0 });
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
            profile: AccelerationProfile::Constant,
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
