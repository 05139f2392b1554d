//! Tool path to axis path: branch over the whole path, unwinding, singular cone.
//!
//! Along a curve the axes follow by continuity: nodes carry exact derivatives and stand so close
//! that the quintic between them stays within tolerance of the exact kinematics. Which branch and
//! which whole turn each segment between two links takes is chosen over the whole path
//! ([`follow`]), because a greedy choice can run into the end of a rotary's travel.

mod assemble;
mod axis_bounds;
mod branch_plan;
mod branch_run;
mod candidate;
mod error;
mod follow;
mod follower;
mod options;
mod origins;
mod path_motion;
mod result;
mod retract;
mod segments;
mod setup;
mod singular_passage;
mod travel;

pub use error::AxesError;
pub use follow::follow;
pub use options::{AxesOptions, FeedPoint, RetractOptions, SingularOptions};
pub use origins::{OriginRanges, origins};
pub use result::{FollowedPath, PathDeviation, RetractMove, SingularPassage};
pub use setup::{
    EvaluatedSetup, PathTravel, SearchAssurance, SetupOptions, SetupSearch, SetupVerdict,
    TiltBounds, WorkpieceTilt, setup,
};
