//! Sample points spread over a face at about equal distances.

use super::error::SurfaceError;
use super::face::Face;
use crate::types::Interval;
use crate::types::Uv;
use nalgebra::Point3;
use nalgebra::UnitVector3;

/// Steps by which lengths along parameter lines are summed up.
const STEPS: usize = 128;

/// Lines of the other parameter over which the longest step is taken.
const LINES: usize = 16;

/// More samples than this are a slip of the spacing's unit, not a wish.
const MOST: f64 = 5e7;

/// A point of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceSample {
    /// Parameters.
    pub uv: Uv,
    /// Point \[mm\].
    pub point: Point3<f64>,
    /// Unit normal on the cutter's side.
    pub normal: UnitVector3<f64>,
}

impl Face {
    /// Samples points inside the trims, at most about `spacing` \[mm\] apart along u and along v:
    /// rows of constant v, laid by the longest step over u, and on each row points at equal arc
    /// length. Points without a normal (poles) are left out.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] unless `spacing` is positive and gives at most 5e7 points.
    pub fn grid(&self, spacing: f64) -> Result<Vec<FaceSample>, SurfaceError> {
        let [u, v] = self.bounds();
        // Largest |S_v| over a few u: rows keep their distance where they are farthest apart.
        let across = |v: f64| {
            let step = |k: usize| {
                let u = u.low + (u.high - u.low) * k as f64 / LINES as f64;
                self.surface.jet1(u, v).sv.norm()
            };
            (0..=LINES).map(step).fold(0.0, f64::max)
        };
        let rows = ArcLengthTable::new(v, across);
        let middle = ArcLengthTable::new(u, |u| self.surface.jet1(u, v.middle()).su.norm());
        // Estimated from the middle row, before any sample is stored.
        let estimate = (rows.length() / spacing + 1.0) * (middle.length() / spacing + 1.0);
        if !(spacing > 0.0 && estimate <= MOST) {
            let need = "above 0 and coarse enough for at most 5e7 points";
            return Err(SurfaceError::Size { what: "grid spacing", value: spacing, need });
        }
        let mut samples = Vec::new();
        for v in rows.centres(spacing) {
            // Every row has its own arc length: points stay evenly spaced where rows grow.
            let along = ArcLengthTable::new(u, |u| self.surface.jet1(u, v).su.norm());
            samples.extend(along.centres(spacing).filter_map(|u| self.sample([u, v])));
        }
        Ok(samples)
    }

    /// Returns the sample at `uv` if it lies inside the trims and has a normal.
    fn sample(&self, uv: [f64; 2]) -> Option<FaceSample> {
        if !self.contains(uv[0], uv[1]) {
            return None;
        }
        let normal = self.normal(uv[0], uv[1])?;
        Some(FaceSample { uv: uv.into(), point: self.point(uv[0], uv[1]), normal })
    }
}

/// Arc length over a parameter, piecewise linear.
struct ArcLengthTable {
    range: Interval,
    /// Length up to each of the `STEPS + 1` nodes.
    lengths: Vec<f64>,
}

impl ArcLengthTable {
    /// Sums `speed` over `range` by the trapezoidal rule.
    fn new(range: Interval, speed: impl Fn(f64) -> f64) -> Self {
        let step = (range.high - range.low) / STEPS as f64;
        let mut lengths = vec![0.0];
        let (mut before, mut length) = (speed(range.low), 0.0);
        for k in 1..=STEPS {
            let here = speed(range.low + step * k as f64);
            length += 0.5 * (before + here) * step;
            lengths.push(length);
            before = here;
        }
        Self { range, lengths }
    }

    fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Returns the middles of equal parts not longer than `spacing`; at least one.
    fn centres(&self, spacing: f64) -> impl Iterator<Item = f64> + '_ {
        let length = self.length();
        let count = (length / spacing).ceil().clamp(1.0, MOST);
        (0_u32..)
            .map(f64::from)
            .take_while(move |part| *part < count)
            .map(move |part| self.parameter(length * (part + 0.5) / count))
    }

    /// Returns the parameter at a length.
    fn parameter(&self, length: f64) -> f64 {
        let after = self.lengths.partition_point(|&known| known < length).clamp(1, STEPS);
        let [a, b] = [self.lengths[after - 1], self.lengths[after]];
        // A step without length, beside a pole, is represented by its middle.
        let share = if b > a { (length - a) / (b - a) } else { 0.5 };
        let step = (self.range.high - self.range.low) / STEPS as f64;
        self.range.low + step * (after as f64 - 1.0 + share)
    }
}
