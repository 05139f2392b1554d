//! A plan that is under way, ends at rest, and is extended when more of the path is known.
//!
//! Extended as it is, the motion would come to rest where the plan ended, and start again. Both
//! cells of rest there become one parabola, whose jerk is three times theirs, and four times that
//! of a short one beside a long one; at such ends they are kept that much below their limits. From
//! there the search goes on, and the stop becomes as fast as the path allows.

use super::barrier::{FIRST_WEIGHT, LAST_WEIGHT, STEPS};
use super::newton::BarrierSolver;
use super::rows::{CellRows, reference};
use super::solve::{kept, lengths};
use super::speed_caps::SpeedCaps;
use super::speed_spline::{EndMotion, FeasibleSpline, SpeedSpline};
use super::{graded_grid, initial, restore};
use crate::feed::cell::FeedCell;
use crate::feed::grid::FeedGrid;
use crate::feed::plan::LimitRatios;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::math;
use crate::types::AxisPiece;
use nalgebra::SVector;

/// Share of their cap that cells of rest keep which become one: four times the jerk, a tenth to spare.
const RESERVE: f64 = 0.37;

/// Path expected after the end of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PathAhead {
    /// More path: the stop there is not meant to happen.
    More,
    /// Nothing; should more come after all, the axes may have to stop here.
    Nothing,
}

impl PathAhead {
    fn reserve(self) -> f64 {
        if self == Self::More { RESERVE } else { 1.0 }
    }
}

/// On a curved path a stop may be this much longer than on a straight one.
///
/// Where the curvature takes all of an axis' acceleration at `x0`, braking from `x` has `a (1 - x / x0)` left:
/// `dx/ds = -(2 a / q') (1 - x / x0)` takes `ln(1 / (1 - x / x0))` times the straight way `x0 q' / 2 a`. Three is
/// `ln 20`: enough up to 95 % of `x0`. Beyond it the window grows later than it could, which costs time but breaks
/// no limit.
const CURVED: f64 = 3.0;

/// Controls before the last way down to rest that are set free with it.
const BEFORE: usize = 128;
/// Most sweeps in which a motion that is too fast is made slower.
const BRAKING: usize = 32;
/// Weight of the barrier from which a stop dissolves. All but the stop is fast already; from the first weight, or in
/// a narrow range at first, the profile comes to a stand around the stop: where it is slow it may bend much, and
/// faster it may not.
const DISSOLVING: f64 = 1e-4;
/// Eighths of the way down to a stop that are kept where a slow plan is to take its place: the more, the slower it
/// begins, and the more surely there is one.
const KEPT: [usize; 4] = [0, 4, 6, 7];
/// Share of the time of the searched part by which it may still be slow.
const TOLERANCE: f64 = 3e-4;
/// Fewest cells that a plan is led on from.
const FEWEST: usize = 8;

/// Plan that ends at rest.
#[derive(Debug, Clone)]
pub(crate) struct RollingPlan<const N: usize> {
    grid: FeedGrid<N>,
    spline: SpeedSpline,
    references: Vec<f64>,
    /// `ds/dt` and `d²s/dt²` at the rows.
    motion: [Vec<f64>; 2],
    /// Number of cells that were run.
    done: usize,
    ahead: PathAhead,
    /// Cell from which a stop takes what is left of it.
    down: usize,
    /// Upper bounds of all ratios everywhere on it.
    pub(crate) bounds: LimitRatios,
}

/// A cell that is run: `s`, `ds/dt` and `d²s/dt²` at both ends.
pub(crate) type CellMotion = [[f64; 2]; 3];

impl<const N: usize> RollingPlan<N> {
    /// Plans a piece from rest to rest; `None` if it is so short beside its `s` that it has no room for rows, or no profile
    /// moves on it.
    pub(crate) fn new(
        piece: &AxisPiece<N>,
        limits: &ReciprocalLimits<N>,
        ahead: PathAhead,
    ) -> Option<Self> {
        let (grid, start) = slow(piece, limits, [1.0, ahead.reserve()]);
        if grid.cells.len() < graded_grid::FEWEST_CELLS {
            return None;
        }
        let FeasibleSpline { spline, references } = start;
        if !moves(&spline) {
            return None;
        }
        let motion = spline.motion();
        let bounds = LimitRatios::default();
        let mut course = Self { grid, spline, references, motion, done: 0, ahead, down: 1, bounds };
        course.search(1, FIRST_WEIGHT, [limits; 2]);
        Some(course)
    }

    /// Wraps a stop from the motion under way.
    pub(super) fn halting(
        grid: FeedGrid<N>,
        stop: FeasibleSpline,
        caps: SpeedCaps,
        limits: &ReciprocalLimits<N>,
    ) -> Self {
        let FeasibleSpline { spline, references } = stop;
        let mut solver = BarrierSolver::new(&grid, limits, caps, &[], spline.clone());
        solver.keep_references(&references);
        let bounds = solver.bounds();
        let motion = spline.motion();
        Self {
            grid,
            spline,
            references,
            motion,
            done: 0,
            ahead: PathAhead::Nothing,
            down: 1,
            bounds,
        }
    }

    /// Returns `s`, `ds/dt` and `d²s/dt²` where the next cell begins.
    pub(crate) fn here(&self) -> Option<[f64; 3]> {
        let at = |list: &[f64]| list.get(self.done).copied();
        Some([at(&self.grid.s)?, at(&self.motion[0])?, at(&self.motion[1])?])
    }

    /// Returns `s` at the end of the plan.
    pub(crate) fn end(&self) -> Option<f64> {
        self.grid.s.last().copied()
    }

    /// Returns `true` if the stop at the end is felt within so many cells.
    pub(crate) fn stops_within(&self, cells: usize) -> bool {
        self.down < self.done + cells
    }

    /// Changes to other limits from the motion under way.
    pub(crate) fn change_limits(&mut self, limits: [&ReciprocalLimits<N>; 2]) {
        if self.done + FEWEST <= self.spline.len() {
            self.forget();
            self.search(1, FIRST_WEIGHT, limits);
        }
    }

    /// Returns `true` if the stop at the end has a reserve that can be removed.
    pub(crate) fn is_open(&self) -> bool {
        self.ahead == PathAhead::More && self.done + FEWEST <= self.spline.len()
    }

    /// Removes the reserve of the stop: the path ends where the plan does, which was not known
    /// when it was made.
    pub(crate) fn end_here(&mut self, limits: [&ReciprocalLimits<N>; 2]) {
        if self.is_open() {
            self.forget();
            self.ahead = PathAhead::Nothing;
            let last = self.spline.len() - 2;
            self.search(self.way_down(last), DISSOLVING, limits);
        }
    }

    /// Takes the next cell.
    pub(crate) fn take_cell(&mut self) -> Option<CellMotion> {
        let run = self.cell(self.done)?;
        self.done += 1;
        Some(run)
    }

    /// Returns the cells that were not run, down to rest.
    pub(crate) fn cells(&self) -> impl Iterator<Item = CellMotion> {
        (self.done..).map_while(|cell| self.cell(cell))
    }

    fn cell(&self, cell: usize) -> Option<CellMotion> {
        let pair = |list: &[f64]| Some([*list.get(cell)?, *list.get(cell + 1)?]);
        Some([pair(&self.grid.s)?, pair(&self.motion[0])?, pair(&self.motion[1])?])
    }

    /// Extends the plan over a piece that begins where this ends; returns `false` if it cannot,
    /// and stays as it is.
    pub(crate) fn extend(
        &mut self,
        piece: &AxisPiece<N>,
        limits: [&ReciprocalLimits<N>; 2],
        ahead: PathAhead,
    ) -> bool {
        if self.done + FEWEST > self.spline.len() || self.motion[0].iter().all(|v| *v <= 0.0) {
            return false;
        }
        self.forget();
        // The new part is planned from rest to rest; both rests where they meet become one parabola.
        let (onward, start) = slow(piece, limits[0], [RESERVE, ahead.reserve()]);
        let mut other = start.spline;
        if !moves(&other) {
            return false;
        }
        let stop = self.spline.len();
        let mut grid = self.grid.clone();
        grid.s.extend(onward.s.iter().skip(1));
        grid.cells.extend(&onward.cells);
        for _ in 0..FEWEST {
            let joined = self.joined(&other);
            let worst = strain(&grid, &joined, limits[0], stop - 1..stop + 1);
            if worst < 1.0 {
                self.references.resize(joined.len(), 0.0);
                (self.grid, self.spline, self.ahead) = (grid, joined, ahead);
                let from = self.way_down(stop);
                // A slow profile from somewhere on the way down replaces the stop, from as early as one is found.
                let later = KEPT.map(|share| from + share * (stop - from) / 8);
                let anew = later.into_iter().find_map(|cell| self.slow_from(cell, limits[0]));
                let first = if anew.is_some() { FIRST_WEIGHT } else { DISSOLVING };
                if let Some(anew) = anew {
                    (self.spline, self.references) = (anew.spline, anew.references);
                }
                self.search(from, first, limits);
                return true;
            }
            // The rows where both meet break a limit: the new part is made slower. Jerks go with x^(3/2).
            let less = math::cbrt(0.8 / worst).powi(2);
            // A part that stands still is no plan.
            if !(less > 0.0 && worst.is_finite()) {
                return false;
            }
            other.controls.iter_mut().for_each(|control| *control *= less);
        }
        false
    }

    /// Returns the plan with a slow one from cell `from` on in place of the stop. A profile that
    /// bends much around the stop would have to bend less everywhere at once, and may come to a
    /// stand. `None` if none is found.
    fn slow_from(&self, from: usize, limits: &ReciprocalLimits<N>) -> Option<FeasibleSpline> {
        let s = self.grid.s.get(from..)?.to_vec();
        let grid = FeedGrid { s, cells: self.grid.cells.get(from..)?.to_vec() };
        // Starts with the speed and acceleration that the plan has there.
        let motion = [self.spline.coefficients(from)[0], *self.motion[1].get(from)?];
        let ends = [EndMotion::Moving(motion), EndMotion::Rest];
        let mut spline = SpeedSpline::new(lengths(&grid), vec![0.0; grid.cells.len()], ends);
        let caps = caps(&grid, &spline, limits, self.ahead)?;
        initial::feasible(&grid, limits, &caps, &mut spline);
        let slow = restore::restore(&grid, limits, &caps, FeasibleSpline::unproven(spline))?;
        let mut plan =
            FeasibleSpline { spline: self.spline.clone(), references: self.references.clone() };
        // The control of the first cell is given by the motion there, and stays.
        let splice = |into: &mut Vec<f64>, of: &[f64]| {
            into.truncate(from + 1);
            into.extend(of.iter().skip(1));
        };
        splice(&mut plan.spline.controls, &slow.spline.controls);
        splice(&mut plan.references, &slow.references);
        plan.references.resize(plan.spline.len(), 0.0);
        Some(plan)
    }

    /// Drops the cells that were run.
    fn forget(&mut self) {
        let cell = std::mem::take(&mut self.done);
        if cell == 0 {
            return;
        }
        let [speed, acceleration] = [self.motion[0][cell], self.motion[1][cell]];
        let x = if cell < self.spline.cells().end {
            self.spline.coefficients(cell)[0]
        } else {
            speed * speed
        };
        self.down = self.down.saturating_sub(cell);
        self.grid.s.drain(..cell);
        for list in &mut self.motion {
            list.drain(..cell);
        }
        self.grid.cells.drain(..cell);
        for list in [&mut self.spline.lengths, &mut self.spline.controls, &mut self.references] {
            list.drain(..cell);
        }
        self.spline.ends[0] = EndMotion::Moving([x, acceleration]);
    }

    /// Joins this plan and another from rest to rest after it, with one parabola where both rest.
    fn joined(&self, other: &SpeedSpline) -> SpeedSpline {
        let mut spline = self.spline.clone();
        let stop = spline.len();
        let [before, after] = [self.spline.coefficients(stop - 2)[2], other.coefficients(1)[0]];
        spline.lengths.extend(&other.lengths);
        spline.controls.extend(&other.controls);
        // The slopes at both borders, 4/3 x / h, over half a cell.
        spline.controls[stop - 1] = before / 3.0;
        spline.controls[stop] = after / 3.0;
        spline
    }

    /// Returns the control from which the speed only falls up to the stop, or from which the stop
    /// is felt, less a margin.
    fn way_down(&self, stop: usize) -> usize {
        let mut from = stop - 1;
        while from > 1 && self.spline.controls[from - 1] > self.spline.controls[from] {
            from -= 1;
        }
        from.min(self.down).saturating_sub(BEFORE).max(1)
    }

    /// Returns the first cell from whose speed a stop takes what is left of the path, or nearly.
    fn stops_from(&self, limits: &ReciprocalLimits<N>) -> usize {
        let end = self.end().unwrap_or_default();
        let near = |((s, speed), cell): ((&f64, &f64), &FeedCell<N>)| {
            let largest =
                |inverse: &SVector<f64, N>| cell.rates[0].component_mul(inverse).amax().recip();
            let a = largest(&limits.acceleration.plus);
            let j = limits.jerk.as_ref().map_or(f64::INFINITY, largest);
            let v = *speed;
            // Straight stop: jerk alone takes 2 sqrt(v / j), with a phase at the largest deceleration
            // v / a + a / j; the mean speed is v / 2 both times.
            let time = if v * j < a * a { 2.0 * (v / j).sqrt() } else { v / a + a / j };
            end - s < CURVED * 0.5 * v * time
        };
        let rows = self.grid.s.iter().zip(&self.motion[0]);
        rows.zip(&self.grid.cells).position(near).unwrap_or(self.spline.len())
    }

    /// Makes the plan fast from control `from` on, the barrier's weight falling from `first`, and
    /// then all of it. Where it is faster than `limits` allow, which `axes` bound in any case, it
    /// brakes.
    fn search(&mut self, from: usize, first: f64, [limits, axes]: [&ReciprocalLimits<N>; 2]) {
        let caps = |limits| caps(&self.grid, &self.spline, limits, self.ahead);
        let [Some(wanted), Some(most)] = [caps(limits), caps(axes)] else { return };
        let slow =
            FeasibleSpline { spline: self.spline.clone(), references: self.references.clone() };
        let last = self.spline.len() - 1;
        let mut solver =
            BarrierSolver::new(&self.grid, limits, wanted.clone(), &[], slow.spline.clone());
        solver.keep_references(&slow.references);
        solver.brake_to(wanted, most);
        let cells = solver.spline.cells();
        solver.centre(LAST_WEIGHT, cells.clone());
        solver.centre(first, from.max(cells.start)..cells.end);
        solver.brake(first, STEPS, BRAKING);
        solver.hurry(from..last, first, TOLERANCE);
        solver.hurry(1..last, LAST_WEIGHT, TOLERANCE);
        if !kept(&solver.bounds()) {
            // Steps stay off the limits by far more than rounding: not expected.
            solver.restart(slow);
        }
        self.bounds = solver.bounds();
        (self.spline, self.references) = (solver.spline, solver.references);
        self.motion = self.spline.motion();
        self.down = self.stops_from(limits);
    }
}

/// Returns the caps with the reserve of cells of rest.
pub(super) fn caps<const N: usize>(
    grid: &FeedGrid<N>,
    spline: &SpeedSpline,
    limits: &ReciprocalLimits<N>,
    ahead: PathAhead,
) -> Option<SpeedCaps> {
    caps_with(grid, spline, limits, [1.0, ahead.reserve()])
}

fn caps_with<const N: usize>(
    grid: &FeedGrid<N>,
    spline: &SpeedSpline,
    limits: &ReciprocalLimits<N>,
    reserves: [f64; 2],
) -> Option<SpeedCaps> {
    let mut caps = SpeedCaps::new(grid, spline, limits)?;
    let ends = [1, spline.len() - 2].into_iter().zip(spline.ends).zip(reserves);
    for ((cell, end), reserve) in ends {
        if !end.moves() {
            caps.control[cell] *= reserve;
        }
    }
    Some(caps)
}

/// True if a profile stands nowhere but at its ends.
fn moves(spline: &SpeedSpline) -> bool {
    spline.cells().all(|cell| spline.controls.get(cell).is_some_and(|control| *control > 0.0))
}

/// Returns a slow plan from rest to rest.
fn slow<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &ReciprocalLimits<N>,
    reserves: [f64; 2],
) -> (FeedGrid<N>, FeasibleSpline) {
    let ends = [EndMotion::Rest; 2];
    let grid = graded_grid::graded(piece, limits, &ends);
    let mut spline = SpeedSpline::new(lengths(&grid), vec![0.0; grid.cells.len()], ends);
    if let Some(caps) = caps_with(&grid, &spline, limits, reserves) {
        initial::feasible(&grid, limits, &caps, &mut spline);
    }
    let references = vec![0.0; spline.len()];
    (grid, FeasibleSpline { spline, references })
}

/// Returns the largest share of accelerations and jerks in these cells.
fn strain<const N: usize>(
    grid: &FeedGrid<N>,
    spline: &SpeedSpline,
    limits: &ReciprocalLimits<N>,
    cells: std::ops::Range<usize>,
) -> f64 {
    let share = |cell: usize| {
        let x = spline.coefficients(cell);
        let [a, j] = CellRows::new(&grid.cells[cell], limits).shares(x, reference(x));
        a.max(j)
    };
    cells.map(share).fold(0.0, f64::max)
}
