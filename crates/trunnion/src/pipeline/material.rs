//! The stock of a job under its programs.

use super::error::PipelineError;
use super::job::Job;
use super::programs::Program;
use crate::files::job;
use crate::files::summary::{CollisionSummary, StockSummary};
use crate::verify::{self, Carving, CollisionKind, Solid, Stock};

/// Rays of one stock at most: some gigabytes.
pub const MOST_RAYS: usize = 30_000_000;

/// Collisions of a program that are told one by one.
const TOLD: usize = 10;

/// What a job says of its stock as a solid: not what stands on the part alone, nor what is in a file.
pub(super) fn solid(stock: &job::Stock) -> Option<Solid> {
    match *stock {
        job::Stock::Box { min, max } => Some(Solid::Box { low: min, high: max }),
        job::Stock::Cylinder { base, radius, height } => {
            Some(Solid::Cylinder { base, radius, height })
        }
        job::Stock::Offset { .. } | job::Stock::Stl { .. } => None,
    }
}

/// Material of the job's stock, uncut; `None` if it is not known as a solid.
///
/// # Errors
///
/// [`PipelineError::Verify`] for a stock without volume, one that is not closed, or one with too many rays.
pub fn stock(job: &Job) -> Result<Option<Stock>, PipelineError> {
    let Some(solid) = &job.stock else { return Ok(None) };
    let cell = job.file.stock_cell.unwrap_or_else(|| solid.usual_cell());
    Ok(Some(Stock::new(solid, cell, MOST_RAYS)?))
}

/// The numbers of a stock that was cut.
pub fn summary(carving: &Carving, left: &Stock) -> StockSummary {
    let collision = |collision: &verify::Collision| CollisionSummary {
        kind: match collision.kind {
            CollisionKind::Rapid => "rapid",
            CollisionKind::Holder => "holder",
            CollisionKind::Fixture => "fixture",
        }
        .to_owned(),
        line: collision.line,
        depth: collision.depth,
        point: collision.point.coords.into(),
    };
    StockSummary {
        cell: left.cell(),
        removed: carving.removed,
        left: carving.left,
        collisions: carving.collisions.iter().map(collision).collect(),
    }
}

/// Collisions in words: the first of them, and how many more.
pub fn collided(carving: &Carving) -> Vec<String> {
    let all = &carving.collisions;
    let mut told: Vec<String> = all.iter().take(TOLD).map(ToString::to_string).collect();
    if all.len() > TOLD {
        told.push(format!("and {} more lines that run into something", all.len() - TOLD));
    }
    told
}

/// Collisions of a program.
pub(super) fn failures(program: &Program) -> Vec<String> {
    let told = program.carving.as_ref().map(|(carving, _)| collided(carving));
    let name = program.file;
    told.into_iter().flatten().map(|what| format!("{name}: {what}")).collect()
}

/// A stock that the check passes over.
pub(super) fn unknown(job: &Job) -> Option<String> {
    let offset = matches!(job.file.stock, Some(job::Stock::Offset { .. }));
    let message = "stock of kind \"offset\" is taken into account by links and leads, but no material is cut away in the \
                   check; name a closed mesh with kind = \"stl\" for that";
    offset.then(|| message.to_owned())
}
