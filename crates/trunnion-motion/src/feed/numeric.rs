//! Comparisons without care for NaN, and lines over a cell.

/// Returns a line, given by both its ends, times a factor.
#[inline]
pub(super) fn scaled(line: [f64; 2], factor: f64) -> [f64; 2] {
    line.map(|end| end * factor)
}

/// Returns the larger number, without the care for NaN that `f64::max` takes.
#[inline]
pub(super) fn largest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Returns the smaller number, the second if they cannot be compared; see [`largest`].
#[inline]
pub(super) fn smallest(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns a line below the convex `1 / rate²` for a linear `rate`. It is the tangent in the
/// middle where the rate hardly changes, else at the end where the rate is largest, which would
/// otherwise lose most.
pub(super) fn tangent(rate: [f64; 2]) -> [f64; 2] {
    let largest = rate[0].max(rate[1]);
    let middle = 0.5 * (rate[0] + rate[1]);
    let at = if largest <= 1.1 * middle { middle } else { largest };
    if at > 0.0 { rate.map(|end| (3.0 - 2.0 * end / at) / (at * at)) } else { [f64::INFINITY; 2] }
}
