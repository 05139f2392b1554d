//! Grids of nearly equidistant points over a face.

use crate::surface::Face;
use crate::types::Interval;
use crate::verify::error::VerifyError;
use crate::verify::options::CheckOptions;

/// Grid of parameters.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FaceGrid {
    /// Increasing values of u.
    pub(crate) u: Vec<f64>,
    /// Increasing values of v.
    pub(crate) v: Vec<f64>,
}

/// Steps in which the length of a parameter line is summed.
const STEPS: usize = 512;
/// Number of parameter lines of which the longest counts.
const LINES: usize = 17;

impl FaceGrid {
    /// Builds a grid whose neighbours are at most about `options.grid` apart, borders included.
    pub(crate) fn over(face: &Face, options: &CheckOptions) -> Result<Self, VerifyError> {
        let bounds = face.bounds();
        let lengths = [0, 1].map(|k| lengths(face, bounds, k));
        let counts = lengths.each_ref().map(|l| {
            let total = l.last().copied().unwrap_or(0.0);
            (total / options.grid).ceil().max(1.0)
        });
        let points = (counts[0] + 1.0) * (counts[1] + 1.0);
        if points.is_nan() || points > options.most_points as f64 {
            return Err(VerifyError::TooManyPoints {
                face: face.number,
                points,
                most: options.most_points,
            });
        }
        let [u, v] = [0, 1].map(|k| breaks(&lengths[k], bounds[k], counts[k]));
        Ok(Self { u, v })
    }

    /// Returns the numbers of values of u and of v.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.u.len(), self.v.len()]
    }

    /// Returns the parameters of a point.
    pub(crate) fn at(&self, i: usize, j: usize) -> Option<[f64; 2]> {
        Some([*self.u.get(i)?, *self.v.get(j)?])
    }

    /// Returns the area in (u, v) that a point represents.
    pub(crate) fn cell(&self, i: usize, j: usize) -> f64 {
        share(&self.u, i) * share(&self.v, j)
    }
}

/// Returns half the distance between both neighbours of a value.
fn share(values: &[f64], i: usize) -> f64 {
    let at = |i: usize| values.get(i).copied();
    let Some(here) = at(i) else { return 0.0 };
    // At a border the missing half counts as nothing: a trapezoidal rule.
    let before = i.checked_sub(1).and_then(at).unwrap_or(here);
    0.5 * (at(i + 1).unwrap_or(here) - before)
}

/// Sums the length along parameter `k` \[mm\] over [`STEPS`] steps; at each step the fastest of [`LINES`] lines counts.
fn lengths(face: &Face, bounds: [Interval; 2], k: usize) -> Vec<f64> {
    let along = |t: f64| bounds[k].at(t);
    let across = |t: f64| bounds[1 - k].at(t);
    let step = (bounds[k].high - bounds[k].low) / STEPS as f64;
    let mut total = 0.0;
    let mut sums = vec![0.0];
    for index in 0..STEPS {
        // Midpoint rule along the parameter; over the lines across it the longest counts, so that no gap is wider than asked.
        let here = along((index as f64 + 0.5) / STEPS as f64);
        let speeds = (0..LINES).map(|line| {
            let there = across(line as f64 / (LINES - 1) as f64);
            let [u, v] = if k == 0 { [here, there] } else { [there, here] };
            let jet = face.surface.jet1(u, v);
            if k == 0 { jet.su.norm() } else { jet.sv.norm() }
        });
        total += speeds.fold(0.0, f64::max) * step;
        sums.push(total);
    }
    sums
}

/// Returns the values of the parameter that cut the length into `count` equal parts.
fn breaks(sums: &[f64], Interval { low, high }: Interval, count: f64) -> Vec<f64> {
    let total = sums.last().copied().unwrap_or(0.0);
    let mut values = vec![low];
    let mut index = 1.0;
    while index < count {
        let length = total * index / count;
        // Invert the cumulative length: find the step that holds it, and interpolate within.
        let after = sums.partition_point(|&sum| sum <= length).clamp(1, STEPS);
        let [a, b] = [after - 1, after].map(|i| sums.get(i).copied().unwrap_or(total));
        let part = if b > a { (length - a) / (b - a) } else { 0.0 };
        values.push(low + (high - low) * ((after - 1) as f64 + part) / STEPS as f64);
        index += 1.0;
    }
    values.push(high);
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn breaks_cut_a_length_into_equal_parts() {
        // Length grows as the square of the parameter.
        let sums: Vec<f64> = (0..=STEPS).map(|i| (i as f64 / STEPS as f64).powi(2)).collect();
        let values = breaks(&sums, Interval::new(2.0, 4.0), 4.0);
        let expected = [2.0, 3.0, 2.0 + 2.0 * 0.5f64.sqrt(), 2.0 + 2.0 * 0.75f64.sqrt(), 4.0];
        for (value, expected) in values.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-5, "{value} {expected}");
        }
        assert!((share(&values, 0) - 0.5).abs() < 1e-15);
    }
}
