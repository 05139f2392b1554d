//! Counter of the work of placing passes. Work is counted and not timed, so that the same face always gets the same
//! passes.

use std::sync::atomic::{AtomicU64, Ordering};

/// Least work of a search without result, in locations found: a search fails only after every initial guess was tried.
const MISS: u64 = 10;

/// Closest-point queries of a search without result that count as a location. Usual failures take 200 to 2000 queries (bezier
/// patch, step face) and count as [`MISS`]; under a cutter that is far too large they take up to 80 000, which count in full.
const QUERIES: u64 = 400;

/// Work of checking a span for gouges, in locations.
const SPAN: u64 = 2;

/// Work of finding how far a column across the passes is finished, in locations.
const COLUMN: u64 = 1;

/// Work of a station of a pass at the fixed lead: its location, its span, which is divided about once,
/// and columns as far apart as a few of the least spacings.
const STATION: f64 = 6.0;

/// Least work of a face. On a small face that bends as the cutter does, stations lie where it bends, and
/// run-outs are longer than passes. A few seconds.
const FACE: f64 = 5000.0;

/// Outcome of the search for a cutter location.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SearchOutcome {
    /// There is a location, or its absence was found at once.
    Found,
    /// Every initial guess failed, after so many closest-point queries.
    Missed { queries: u64 },
}

/// Counter that threads may share: a sum does not depend on its order.
#[derive(Debug, Default)]
pub(crate) struct WorkCounter(AtomicU64);

impl WorkCounter {
    /// Returns the work of fixed-lead passes with this many stations over a face.
    pub(crate) fn of_stations(stations: f64) -> f64 {
        (STATION * stations).max(FACE)
    }

    /// Counts the search for a location.
    pub(crate) fn location(&self, outcome: SearchOutcome) {
        self.add(match outcome {
            SearchOutcome::Found => 1,
            SearchOutcome::Missed { queries } => MISS.max(queries / QUERIES),
        });
    }

    /// Counts spans that are checked for gouges.
    pub(crate) fn spans(&self, count: usize) {
        self.add(SPAN * count as u64);
    }

    /// Counts columns that are checked for remaining material.
    pub(crate) fn columns(&self, count: usize) {
        self.add(COLUMN * count as u64);
    }

    /// Returns the sum so far.
    pub(crate) fn done(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    fn add(&self, units: u64) {
        self.0.fetch_add(units, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_search_without_result_counts_by_its_queries() {
        let work = WorkCounter::default();
        work.location(SearchOutcome::Found);
        work.location(SearchOutcome::Missed { queries: 100 });
        assert_eq!(work.done(), 1 + MISS);
        work.location(SearchOutcome::Missed { queries: 60_000 });
        assert_eq!(work.done(), 1 + MISS + 60_000 / QUERIES);
    }
}
