//! Stock and fixtures of a job, ready for the check of its programs.

use super::bodies::WatchedMachine;
use super::error::PipelineError;
use super::fixtures::Fixtures;
use super::job::Job;
use crate::files::job;
use crate::verify::{Solid, Stock};

/// Most dexel rays of a stock: they take some gigabytes.
pub const MOST_RAYS: usize = 30_000_000;

/// Stock and fixtures with which the programs of a job are checked.
#[derive(Debug)]
pub struct Solids {
    /// Uncut stock; `None` if it is not known as a solid.
    pub stock: Option<Stock>,
    /// Fixtures; `None` without any.
    pub fixtures: Option<Fixtures>,
    /// Bodies of the machine, with stock and fixtures; `None` without any.
    pub machine: Option<WatchedMachine>,
}

/// Builds stock and fixtures of a job.
///
/// # Errors
///
/// [`PipelineError::Solids`] with all that are without volume, not closed, or of too many rays, each at its line of the job.
pub fn solids(job: &Job) -> Result<Solids, PipelineError> {
    let (file, mut faults) = (&job.file, Vec::new());
    let mut refuse = |path: &str, what: String| faults.push(file.places.fault(path, what));
    let stock = job.stock.as_ref().and_then(|solid| {
        let cell = file.stock_cell.unwrap_or_else(|| solid.usual_cell());
        let refused = |error| refuse(stock_key(file, solid), format!("the stock: {error}"));
        Stock::new(solid, cell, MOST_RAYS).map_err(refused).ok()
    });
    let mut fixtures = Fixtures::new(job.budget.total, file.fixture_clearance);
    for (number, held) in job.fixtures.iter().enumerate() {
        if let Err(error) = fixtures.add(held) {
            let path = format!("fixture.{number}.file");
            refuse(&path, format!("fixture {}: {error}", held.name));
        }
    }
    let machine = WatchedMachine::new(job.kinematics.machine(), file.fixture_clearance);
    let mut machine = machine.unwrap_or_else(|error| {
        faults.push(file.places.fault("machine.file", error.to_string()));
        None
    });
    if !faults.is_empty() {
        return Err(PipelineError::Solids(faults.into()));
    }
    if let Some(machine) = &mut machine {
        for held in &job.fixtures {
            held.solid.iter().for_each(|solid| machine.hold(&held.name, solid, held.allowance));
        }
        job.stock.iter().for_each(|stock| machine.hold_stock(stock));
    }
    Ok(Solids { stock, fixtures: Some(fixtures).filter(|all| !all.all().is_empty()), machine })
}

/// Returns the key of the job to report a bad stock at: the ray spacing, if another spacing works.
fn stock_key(file: &job::JobFile, solid: &Solid) -> &'static str {
    // The solid is to blame only if it fails with the default spacing as well.
    let sound = || Stock::new(solid, solid.usual_cell(), MOST_RAYS).is_ok();
    if file.stock_cell.is_some() && sound() { "verify.stock_cell" } else { "stock.file" }
}
