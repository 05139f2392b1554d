//! Modal states that `M70` and `M73` save.

use crate::read::control::{DistanceMode, FeedMode, SurfaceSpeed};

/// Saved states that stay in memory: one for each depth of calls.
#[derive(Debug, Clone)]
#[expect(clippy::struct_excessive_bools, reason = "modal switches are what a control has")]
pub(super) struct SavedState {
    /// Depth of calls at which it was saved.
    pub(super) level: usize,
    /// Restored when the call returns: `M73`.
    pub(super) at_return: bool,
    pub(super) distance: DistanceMode,
    pub(super) arc_absolute: bool,
    pub(super) plane: usize,
    pub(super) diameter: bool,
    pub(super) to_r: bool,
    pub(super) inch: bool,
    pub(super) feed_mode: FeedMode,
    pub(super) feed: Option<f64>,
    pub(super) speed: f64,
    pub(super) surface: Option<SurfaceSpeed>,
    pub(super) sense: i8,
    pub(super) offset: u8,
    pub(super) length: bool,
    pub(super) shift: [f64; 3],
}
