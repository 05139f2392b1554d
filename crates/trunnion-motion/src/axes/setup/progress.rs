//! Progress of the setup search.

use crate::types::{Progress, Stage};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

/// Progress of the search itself, without that of the paths it tries.
pub(super) struct SearchProgress<'a> {
    pub(super) progress: &'a dyn Progress,
    pub(super) done: AtomicU64,
    pub(super) total: u64,
}

impl Progress for SearchProgress<'_> {
    fn report(&self, stage: Stage, _: u64, _: u64) -> ControlFlow<()> {
        self.progress.report(stage, self.done.load(Ordering::Relaxed), self.total)
    }
}
