//! Planning piece by piece, and putting the pieces together.

use super::error::FeedError;
use super::grid::FeedGrid;
use super::plan::{BindingLimit, FeedPlan, LimitRatios};
use super::profile::SpeedProfile;
use super::reciprocal::ReciprocalLimits;
use super::{binding, bounds, measure};
use crate::types::{AxisPath, AxisPiece, Progress, Schedule, SchedulePiece, Stage};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// One piece's share of a [`FeedPlan`], with times from 0.
pub(super) struct PlannedPiece {
    pub(super) schedule: SchedulePiece,
    pub(super) lower_bound: f64,
    pub(super) measured: measure::MeasuredRatios,
    pub(super) bounds: LimitRatios,
    pub(super) binding: Vec<BindingLimit>,
    pub(super) inserted: usize,
}

/// Plans all pieces in parallel; the order of the results does not depend on the number of
/// threads.
pub(super) fn plan_all<const N: usize, T: Send>(
    path: &AxisPath<N>,
    progress: &dyn Progress,
    plan: impl Fn(usize, &AxisPiece<N>) -> Result<T, FeedError> + Sync,
) -> Result<Vec<T>, FeedError> {
    // Pieces finish in any order: the count is shared, the results are collected in path order.
    let done = AtomicU64::new(0);
    let total = path.pieces.len() as u64;
    progress.step(Stage::Feed, 0, total)?;
    // Waking another thread for one piece would take longer than many a plan.
    if let [piece] = path.pieces.as_slice() {
        let planned = plan(0, piece)?;
        progress.step(Stage::Feed, 1, total)?;
        return Ok(vec![planned]);
    }
    path.pieces
        .par_iter()
        .enumerate()
        .map(|(index, piece)| {
            let planned = plan(index, piece)?;
            progress.step(Stage::Feed, 1 + done.fetch_add(1, Ordering::Relaxed), total)?;
            Ok(planned)
        })
        .collect()
}

/// Turns a profile into a schedule with its measured ratios and bounds.
pub(super) fn planned<const N: usize>(
    piece: &AxisPiece<N>,
    grid: &FeedGrid<N>,
    profile: &SpeedProfile,
    limits: &ReciprocalLimits<N>,
    lower_bound: f64,
) -> PlannedPiece {
    let schedule = profile.schedule(grid.s.clone(), grid.cells.iter().map(|cell| cell.h));
    PlannedPiece {
        lower_bound,
        measured: measure::measure(piece, &schedule, limits),
        bounds: bounds::bounds(grid, profile, limits),
        binding: binding::binding(grid, profile, limits),
        inserted: schedule.s.len() - piece.nodes.len(),
        schedule,
    }
}

impl PlannedPiece {
    /// Returns true if the schedule consists of numbers, and takes time wherever it must.
    fn is_resolved(&self) -> bool {
        let SchedulePiece { s, t, speed, acceleration, .. } = &self.schedule;
        let finite = [s, t, speed, acceleration].into_iter().flatten().all(|one| one.is_finite());
        let time = t.last().copied().unwrap_or(0.0);
        // A path that moves takes time, whatever limits a method may break.
        finite && self.lower_bound.is_finite() && (time > 0.0 || self.lower_bound <= 0.0)
    }
}

/// Joins the pieces to one plan, each starting when the one before ends.
///
/// # Errors
///
/// [`FeedError::Unresolved`] where rounding left no schedule.
pub(super) fn assemble(planned: Vec<PlannedPiece>) -> Result<FeedPlan, FeedError> {
    if let Some(piece) = planned.iter().position(|piece| !piece.is_resolved()) {
        return Err(FeedError::Unresolved { piece });
    }
    let mut plan = FeedPlan {
        schedule: Schedule::default(),
        lower_bound: 0.0,
        ratios: LimitRatios::default(),
        bounds: LimitRatios::default(),
        acceleration_step: 0.0,
        binding: Vec::with_capacity(planned.len()),
        inserted: 0,
    };
    let mut start = 0.0;
    for mut piece in planned {
        for t in &mut piece.schedule.t {
            *t += start;
        }
        start = piece.schedule.t.last().copied().unwrap_or(start);
        plan.schedule.pieces.push(piece.schedule);
        // The axes rest between pieces, so that lower bounds add up; ratios are the largest of all.
        plan.lower_bound += piece.lower_bound;
        plan.ratios = plan.ratios.max(piece.measured.ratios);
        plan.bounds = plan.bounds.max(piece.bounds);
        plan.acceleration_step = plan.acceleration_step.max(piece.measured.acceleration_step);
        plan.binding.push(piece.binding);
        plan.inserted += piece.inserted;
    }
    Ok(plan)
}
