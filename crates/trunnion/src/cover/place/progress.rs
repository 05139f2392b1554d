//! Progress of the passes over a face.

use crate::cover::place::placed::PlacedPasses;
use crate::types::{Cancelled, Progress, Stage};
use std::sync::atomic::{AtomicU64, Ordering};

/// Steps of progress per face.
const STEPS: u64 = 1000;

/// Faces that are covered side by side: how far each is, and who hears of it.
pub(crate) struct FacesProgress<'a> {
    progress: &'a dyn Progress,
    done: Vec<AtomicU64>,
}

impl<'a> FacesProgress<'a> {
    /// Starts with `count` faces of which nothing is covered.
    pub(crate) fn new(progress: &'a dyn Progress, count: usize) -> Self {
        Self { progress, done: (0..count).map(|_| AtomicU64::new(0)).collect() }
    }

    /// Returns the progress of the face at `index`, whose number is `number`.
    pub(crate) fn face(&self, index: usize, number: usize) -> FaceProgress<'_> {
        FaceProgress { faces: self, index, number, range: [0.0, 1.0] }
    }
}

/// Progress of one face, or of a part of the work on it.
#[derive(Clone, Copy)]
pub(crate) struct FaceProgress<'a> {
    faces: &'a FacesProgress<'a>,
    index: usize,
    number: usize,
    /// Shares of the face between which this part of the work lies.
    range: [f64; 2],
}

impl FaceProgress<'_> {
    /// Returns the progress of the work between two shares of this one.
    pub(crate) fn within(&self, [from, to]: [f64; 2]) -> Self {
        let [start, end] = self.range;
        let at = |share: f64| start + (end - start) * share;
        Self { range: [at(from), at(to)], ..*self }
    }

    /// Reports the share of the work that is done, 0 to 1.
    pub(crate) fn report(&self, share: f64) -> Result<(), Cancelled> {
        let [start, end] = self.range;
        let share = start + (end - start) * share;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to STEPS")]
        let steps = (share.clamp(0.0, 1.0) * STEPS as f64) as u64;
        let FacesProgress { progress, done } = self.faces;
        // Parts of the work on a face may be done side by side.
        done[self.index].fetch_max(steps, Ordering::Relaxed);
        let sum = done.iter().map(|face| face.load(Ordering::Relaxed)).sum();
        progress.step(Stage::Cover, sum, STEPS * done.len() as u64)
    }

    /// Shows the passes as far as they are placed.
    pub(crate) fn show(&self, placed: &PlacedPasses) {
        self.faces.progress.report_passes(self.number, &placed.passes);
    }
}
