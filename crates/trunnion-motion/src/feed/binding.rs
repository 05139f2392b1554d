//! The limits that bind along a profile.

use super::cell::FeedCell;
use super::grid::FeedGrid;
use super::plan::BindingLimit;
use super::profile::SpeedProfile;
use super::reciprocal::ReciprocalLimits;

/// Returns the limit that binds from each row to the next; the last entry repeats.
pub(super) fn binding<const N: usize>(
    grid: &FeedGrid<N>,
    profile: &SpeedProfile,
    limits: &ReciprocalLimits<N>,
) -> Vec<BindingLimit> {
    let mut binding: Vec<BindingLimit> = grid
        .cells
        .iter()
        .enumerate()
        .map(|(index, cell)| binding_in_cell(cell, limits, profile.ends(index)))
        .collect();
    binding.extend(binding.last().copied());
    binding
}

/// Returns the limit used most in the middle of a cell. Time goes with the root of the
/// acceleration, so the share of an acceleration is its root; shares are compared as squares.
fn binding_in_cell<const N: usize>(
    cell: &FeedCell<N>,
    limits: &ReciprocalLimits<N>,
    x: [f64; 2],
) -> BindingLimit {
    // x is linear over the cell, so that its middle is the mean of the ends, and u = x'/2.
    let [rate, bend] = cell.rates_in_the_middle();
    let [square, u] = [0.5 * (x[0] + x[1]), 0.5 * (x[1] - x[0]) / cell.h];
    let [mut accelerations, mut velocities] = [[0.0; N]; 2];
    for axis in 0..N {
        let acceleration = rate[axis] * u + bend[axis] * square;
        accelerations[axis] = limits.acceleration.share(axis, acceleration);
        let velocity = limits.velocity.share(axis, rate[axis]);
        velocities[axis] = square * velocity * velocity;
    }
    let point = |rates: [f64; 2], inverse: f64| {
        let rate = 0.5 * (rates[0] + rates[1]) * inverse;
        square * rate * rate
    };
    let [feed, tip] = [point(cell.feed_rate, limits.feed), point(cell.tip_rate, limits.tip)];
    let mut most = (0.0, BindingLimit::Still);
    // Strictly greater: of equal shares the first in this order is named.
    for axis in 0..N {
        let name = u8::try_from(axis).unwrap_or(u8::MAX);
        if accelerations[axis] > most.0 {
            most = (accelerations[axis], BindingLimit::Acceleration(name));
        }
        if velocities[axis] > most.0 {
            most = (velocities[axis], BindingLimit::Velocity(name));
        }
    }
    for (square, name) in [(feed, BindingLimit::Feed), (tip, BindingLimit::Tip)] {
        if square > most.0 {
            most = (square, name);
        }
    }
    most.1
}
