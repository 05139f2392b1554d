//! Accuracy and memory of stock that is cut for a picture.

/// Accuracy and memory of a [`TimedStock`](super::TimedStock). Begin with [`TimedStockOptions::within`] and change the rest by
/// struct update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedStockOptions {
    /// Accuracy of the cut on every ray, and largest distance of chords from arcs \[mm\].
    pub tolerance: f64,
    /// Most memory for keyframes \[bytes\]; one more is always there, the stock before the first cut.
    pub keyframe_memory: usize,
}

/// Memory for keyframes by default \[bytes\]: sixteen of half a million rays fit.
const KEYFRAME_MEMORY: usize = 400_000_000;

impl TimedStockOptions {
    /// Cuts to that accuracy \[mm\].
    #[must_use]
    pub const fn within(tolerance: f64) -> Self {
        Self { tolerance, keyframe_memory: KEYFRAME_MEMORY }
    }
}
