//! Guaranteed bounds of a profile over a whole piece.

use super::grid::FeedGrid;
use super::numeric::{largest, scaled};
use super::plan::LimitRatios;
use super::profile::SpeedProfile;
use super::reciprocal::ReciprocalLimits;

/// Returns upper bounds of the velocity and acceleration ratios over the whole piece.
pub(super) fn bounds<const N: usize>(
    grid: &FeedGrid<N>,
    profile: &SpeedProfile,
    limits: &ReciprocalLimits<N>,
) -> LimitRatios {
    let acceleration = profile.acceleration.unwrap_or_default();
    let mut bounds = LimitRatios { acceleration, ..LimitRatios::default() };
    let mut square = 0.0_f64;
    for (index, cell) in grid.cells.iter().enumerate() {
        let x = profile.ends(index);
        if profile.acceleration.is_none() {
            let most = cell.accelerations(limits).most::<5>(x);
            bounds.acceleration = largest(most, bounds.acceleration);
        }
        let mut speed = |line: [f64; 2]| {
            // The exact maximum only where it can be above what was seen.
            let rate = largest(line[0], line[1]);
            if largest(x[0], x[1]) * rate * rate > square {
                square = largest(peak_square(x, line), square);
            }
        };
        cell.speed_lines(limits).into_iter().for_each(&mut speed);
        speed(scaled(cell.feed_rate, limits.feed));
        speed(scaled(cell.tip_rate, limits.tip));
    }
    bounds.velocity = square.sqrt();
    bounds
}

/// Returns the maximum of `x rate²` with both linear over a cell: at an end, or where `(x rate²)'
/// = rate (x' rate + 2 x rate') = 0`.
fn peak_square(x: [f64; 2], rate: [f64; 2]) -> f64 {
    let [dx, dr] = [x[1] - x[0], rate[1] - rate[0]];
    let ends = (x[0] * rate[0] * rate[0]).max(x[1] * rate[1] * rate[1]);
    let [above, below] = [-(dx * rate[0] + 2.0 * dr * x[0]), 3.0 * dx * dr];
    // Fraction above / below strictly between 0 and 1; the division only where it is.
    if above * below > 0.0 && above.abs() < below.abs() {
        let t = above / below;
        return ends.max((x[0] + t * dx) * (rate[0] + t * dr).powi(2));
    }
    ends
}
