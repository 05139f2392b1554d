//! The path of a job with smoothed cuts.

use super::error::ToolPathError;
use super::options::ToolPathOptions;
use super::smooth::{
    PathDeviation, SmoothError, SmoothOptions, SmoothReport, SmoothedCurves, smooth,
};
use super::through::{check, joined, through};
use crate::types::{Leg, Motion, PieceGeometry, Progress, Silent, Stage, ToolPath, ToolPiece};
use std::ops::ControlFlow;

/// A job's path with smoothed cuts.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct SmoothedPath {
    /// The path; a cut has a piece between two stops.
    pub path: ToolPath,
    /// Counts and deviations over all cuts.
    pub report: SmoothReport,
    /// Length of all cuts up to the end of each span \[mm\], and the deviation of that span.
    pub along: Vec<(f64, PathDeviation)>,
}

/// Progress of one leg, among the stations of all.
struct LegProgress<'a> {
    of: &'a dyn Progress,
    /// Stations of the legs before.
    before: u64,
    /// Stations of all legs.
    total: u64,
}

impl Progress for LegProgress<'_> {
    fn report(&self, stage: Stage, done: u64, _: u64) -> ControlFlow<()> {
        self.of.report(stage, self.before + done, self.total)
    }
}

/// Lays curves as [`through`] does, but cutting legs become the C3 path that [`smooth`] lays within tolerance of them.
///
/// # Errors
///
/// [`ToolPathError`].
pub fn smoothed(
    legs: &[Leg],
    options: &ToolPathOptions,
    smoothing: &SmoothOptions,
    progress: &dyn Progress,
) -> Result<SmoothedPath, ToolPathError> {
    let mut all = SmoothedPath::default();
    let total = legs.iter().map(|leg| leg.stations.len() as u64).sum();
    let mut before = 0;
    for (leg, of) in legs.iter().enumerate() {
        progress.step(Stage::ToolPath, before, total)?;
        if leg > 0 {
            joined(leg, &legs[leg - 1], of)?;
        }
        if of.motion == Motion::Cut {
            check(leg, of)?;
            let smoothed =
                smooth(&of.stations, smoothing, &LegProgress { of: progress, before, total });
            all.take(smoothed.map_err(|error| refused(leg, error))?);
        } else {
            let plain = through(std::slice::from_ref(of), options, &Silent);
            all.path.pieces.extend(plain.map_err(|error| error.in_leg(leg))?.pieces);
        }
        before += of.stations.len() as u64;
    }
    progress.step(Stage::ToolPath, total, total)?;
    Ok(all)
}

fn refused(leg: usize, error: SmoothError) -> ToolPathError {
    match error {
        SmoothError::Cancelled(cancelled) => cancelled.into(),
        error => ToolPathError::Smooth { leg, error },
    }
}

impl SmoothedPath {
    /// Appends one cut.
    fn take(&mut self, cut: SmoothedCurves) {
        self.report.add(&cut.report);
        for (curve, deviated) in cut.curves.into_iter().zip(cut.deviated) {
            // Knots of a curve count from where the cut began: shift them to the length of all cuts
            // so far.
            let before = self.along.last().map_or(0.0, |(end, _)| *end) - curve.range().low;
            self.along.extend(curve.knots[1..].iter().map(|end| before + end).zip(deviated));
            self.path
                .pieces
                .push(ToolPiece { motion: Motion::Cut, geometry: PieceGeometry::Curve(curve) });
        }
    }
}
