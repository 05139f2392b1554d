//! What is placed on the way to a whole face.

use super::left::Column;
use super::options::{CoverOptions, Covering};
use super::region::Local;
use super::split::{Costs, Part};
use super::stretch::Stretch;
use super::sweep::Sweep;
use crate::positioning::PositioningError;

/// How a pass brought a task on.
pub(super) struct Step {
    /// How far across.
    pub(super) next: f64,
    /// Length of a step across by the parameter \[mm\].
    pub(super) rate: f64,
    /// What another pass over all of it costs \[mm\].
    pub(super) again: f64,
}

/// What is cut on one track, and what it leaves.
pub(super) struct Lot {
    /// Length of a step across by the parameter \[mm\].
    pub(super) rate: f64,
    pub(super) stretches: Vec<Stretch>,
    pub(super) columns: Vec<Column>,
    pub(super) parts: Vec<Part>,
    pub(super) costs: Costs,
    /// Where no location was found, and why.
    pub(super) refused: Option<(Local, PositioningError)>,
}

impl Lot {
    /// Length along \[mm\].
    pub(super) fn length(&self) -> f64 {
        self.parts.iter().map(|part| part.length).sum()
    }

    /// How far across all columns that count for `width` \[mm\] are finished.
    pub(super) fn reach(&self, width: f64) -> f64 {
        let counting = self.columns.iter().zip(&self.parts).filter(|(_, part)| part.width >= width);
        counting.map(|(column, _)| column.finished).fold(f64::INFINITY, f64::min)
    }
}

/// What was placed so far.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) done: Covering,
    pub(super) forward: bool,
    /// Curves of the last passes.
    pub(super) recent: Vec<Sweep>,
    /// Curves of all passes before these.
    pub(super) swept: Vec<Sweep>,
    /// Boxes in which something was left unfinished when it should have been finished.
    pub(super) missed: Vec<[[f64; 2]; 2]>,
}

impl State {
    /// What all passes cost, as a length that is cut \[mm\].
    pub(super) fn price(&self, options: &CoverOptions) -> f64 {
        price(&self.done, options)
    }
}

/// What passes cost, as a length that is cut \[mm\].
pub(super) fn price(done: &Covering, options: &CoverOptions) -> f64 {
    done.report.length + options.link * done.passes.len() as f64
}
