//! The whole chain from one job: [`Job`] in, [`Outcome`] out.
//!
//! [`run`] reads like the picture on the front page of the crate; each stage is one call. The [`Budget`] gives each
//! stage its share of the tolerance.

mod assemble;
mod bodies;
mod body_advice;
mod budget;
mod collisions;
mod error;
mod estimate;
mod fit;
mod fixture_advice;
mod fixtures;
mod guards;
mod holder;
mod inner_velocity;
mod job;
mod joined;
mod keep_clear;
mod leftover;
mod measured;
mod operations;
mod origin_advice;
mod origin_search;
mod out_of_reach;
mod outcome;
mod pass_cost;
mod pass_order;
mod planned_motion;
mod program;
mod program_format;
mod programs;
mod proposal;
mod reach;
mod regions;
mod retracts;
mod rotary_half;
mod rounding;
mod run;
mod setup_search;
mod sheets;
mod solids;
mod stages;
mod stock_solid;
mod summary;
mod tolerances;
mod too_concave;
mod turn_limit;
mod wording;

pub use bodies::{WatchedMachine, bodies_too_near, nearest_bodies};
pub use budget::{Budget, BudgetError, BudgetShares};
pub use collisions::{describe_collisions, stock_summary};
pub use error::PipelineError;
pub use fit::fit;
pub use fixtures::{
    Fixtures, Held, MOST_COLLISIONS, approach, collisions, nearest_fixture, too_near,
};
pub use holder::holder_profile;
pub use job::{Job, JobError};
pub use operations::PlannedOperation;
pub use out_of_reach::OutOfReach;
pub use outcome::Outcome;
pub use program::{CheckedProgram, LeftOutProgram, NearMoves, OperationProgram};
pub use proposal::{
    FaceReason, JobProposal, LeftOutFace, ProposalError, ProposalRequest, ProposedOperation,
    propose,
};
pub use reach::reach;
pub use run::{locations, run};
pub use setup_search::{BodiesInSetups, SetupResult, setup};
pub use solids::{MOST_RAYS, Solids, solids};
pub use stages::{SETUP_SHOWN, SETUP_WITHIN, motion_limits};
pub use too_concave::TooConcave;
