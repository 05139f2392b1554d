//! Restoration: brings a profile that breaks its limits inside.
//!
//! The limits are loosened until the profile keeps them. The barrier then drives the profile off
//! the loosened limits, which are tightened after it, round by round. The problem is convex but
//! for the references of the jerk rows, so that a profile inside the limits is found if there is
//! one, or very nearly.

use super::newton::BarrierSolver;
use super::rows::{CellRows, reference};
use super::speed_caps::SpeedCaps;
use super::speed_spline::{FeasibleSpline, SpeedSpline};
use crate::feed::grid::FeedGrid;
use crate::feed::reciprocal::ReciprocalLimits;
use std::ops::Range;

/// Barrier weight: the 110 sides of rows a cell has pull twice as hard as the time. Ten times that would
/// bring the path to a stand, a third of it would run on along the loosened limits.
const WEIGHT: f64 = 0.018;
/// That of caps as a part of it, or a path that starts at one would be driven off it: a barrier of weight `w`
/// balances the time at `w` from its limit, that of caps at 1.8e-4 of them.
const CAUTION: f64 = 0.01;
const STEPS: usize = 3;
/// Limits are loosened to what is used and this much more: farther than the 1.8 % at which one
/// side alone balances the time, so that the barrier does not push against its own start.
const ROOM: f64 = 1.03;
/// Shares of limits that are inside: a solution found earlier comes close to 1, and is not to be moved.
const INSIDE: f64 = 1.0 - 1e-9;
/// Most rounds; each takes off a good part of the excess.
const ROUNDS: usize = 60;
/// A share above its limit has to fall to this part of itself in [`PATIENCE`] rounds.
const FALL: f64 = 0.97;
const PATIENCE: usize = 6;
/// Cells around those outside that move with them: all of a piece without rows of its own, which has 61 cells of
/// 0.0163 of its length and 16 towards each rest.
const AROUND: usize = 96;

/// Shares of its limits that a cell uses: accelerations, jerks, the caps of its control and of its
/// end.
type CellStrain = [f64; 4];

/// Returns a spline inside all limits near the given one, with the references that show it; `None`
/// if none is found.
pub(super) fn restore<const N: usize>(
    grid: &FeedGrid<N>,
    limits: &ReciprocalLimits<N>,
    caps: &SpeedCaps,
    start: FeasibleSpline,
) -> Option<FeasibleSpline> {
    let FeasibleSpline { mut spline, mut references } = start;
    let (mut before, mut waited) = (f64::INFINITY, 0);
    for _ in 0..ROUNDS {
        let strains = strains(grid, limits, caps, &spline, &references);
        let worst = strains.iter().flatten().copied().fold(0.0, f64::max);
        if worst <= INSIDE {
            return (caps.given <= 1.0).then_some(FeasibleSpline { spline, references });
        }
        // Give up once the excess has stopped falling.
        if worst < FALL * before {
            (before, waited) = (worst, 0);
        } else {
            waited += 1;
            if waited > PATIENCE {
                return None;
            }
        }
        let range = around(&strains, spline.len());
        // Just enough looser that this profile is inside, so that the barrier can start from it.
        // One factor for all: cells with factors of their own would rest against one another.
        let used = strains.iter().fold(0.0_f64, |most, strain| most.max(strain[0]).max(strain[1]));
        let loose = vec![[(ROOM * used).max(1.0); 2]; spline.len()];
        // A cap that is exceeded is moved out of the way of the cell that exceeds it.
        let mut wide = caps.clone();
        for cell in spline.cells() {
            let x = spline.coefficients(cell);
            for (cap, x) in [(&mut wide.control[cell], x[1]), (&mut wide.row[cell + 1], x[2])] {
                if x > INSIDE * *cap {
                    *cap = ROOM * x;
                }
            }
        }
        let mut solver = BarrierSolver::new(grid, limits, wide, &loose, spline);
        solver.keep_references(&references);
        solver.caution = CAUTION;
        let all = solver.spline.cells();
        solver.centre(WEIGHT, (range.start - 1).max(all.start)..(range.end + 1).min(all.end));
        let size = range.len();
        solver.sweep_over(range, WEIGHT, STEPS, [size, size]);
        (spline, references) = (solver.spline, solver.references);
    }
    None
}

/// Returns the controls near cells outside their limits.
fn around(strains: &[CellStrain], cells: usize) -> Range<usize> {
    let outside = |strain: &CellStrain| strain.iter().any(|used| *used > INSIDE);
    let first = strains.iter().position(outside).unwrap_or(0);
    let last = strains.iter().rposition(outside).unwrap_or(cells);
    let from = first.saturating_sub(AROUND).max(1);
    from..(last + AROUND).min(cells - 1).max(from)
}

/// Returns the shares of their limits that all cells use.
fn strains<const N: usize>(
    grid: &FeedGrid<N>,
    limits: &ReciprocalLimits<N>,
    caps: &SpeedCaps,
    spline: &SpeedSpline,
    references: &[f64],
) -> Vec<CellStrain> {
    let mut strains = vec![[0.0; 4]; spline.len()];
    for cell in spline.cells() {
        let x = spline.coefficients(cell);
        let rows = CellRows::new(&grid.cells[cell], limits);
        let [acceleration, mut jerk] = rows.shares(x, reference(x));
        if let Some(kept) = references.get(cell).filter(|kept| **kept > 0.0) {
            jerk = jerk.min(rows.shares(x, *kept)[1]);
        }
        strains[cell] = [acceleration, jerk, x[1] / caps.control[cell], x[2] / caps.row[cell + 1]];
    }
    strains
}
