//! How much work placing passes takes, counted and not timed, so that the same face is given the same.

use std::sync::atomic::{AtomicU64, Ordering};

/// Work of a location that is not found, in locations that are: a search ends in failure only after
/// every start was tried.
const MISS: u64 = 10;

/// Work of a span that is looked at for gouges, and of a column across the passes that is looked at for
/// what is left, in locations.
const SPAN: u64 = 2;
const COLUMN: u64 = 1;

/// Work of a station of a pass at the fixed lead: its location, its span, which is divided about once,
/// and columns as far apart as a few of the least spacings.
const STATION: f64 = 6.0;

/// Work of a face at least: on a small one, that bends as the cutter does, stations lie where it bends, and
/// run-outs are longer than passes. A few seconds.
const FACE: f64 = 5000.0;

/// Counter that threads may share: a sum does not depend on its order.
#[derive(Debug, Default)]
pub(super) struct Work(AtomicU64);

impl Work {
    /// What stations of fixed-lead passes take over a face.
    pub(super) fn of_stations(stations: f64) -> f64 {
        (STATION * stations).max(FACE)
    }

    pub(super) fn location(&self, found: bool) {
        self.add(if found { 1 } else { MISS });
    }

    pub(super) fn spans(&self, count: usize) {
        self.add(SPAN * count as u64);
    }

    pub(super) fn columns(&self, count: usize) {
        self.add(COLUMN * count as u64);
    }

    /// The sum so far.
    pub(super) fn done(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    fn add(&self, units: u64) {
        self.0.fetch_add(units, Ordering::Relaxed);
    }
}
