//! The planned motion of the machine.

use crate::axes::FollowedPath;
use crate::feed::FeedPlan;
use crate::files::summary::{RetractSummary, SingularSummary};

/// Planned motion of the machine, with what the summary reports about it.
#[derive(Clone, Copy)]
pub(super) struct PlannedMotion<'a> {
    pub(super) followed: &'a FollowedPath,
    pub(super) plan: &'a FeedPlan,
    pub(super) retracts: &'a [RetractSummary],
    pub(super) singular: Option<SingularSummary>,
}
