//! Proposal of a job for a part: faces, cutter and setup that run as they are.

mod borders;
mod candidates;
mod corners;
mod cutters;
mod ladder;
mod left_out;
mod orientation;
mod origin;
mod part_measure;
mod propose;
mod request;

pub use left_out::{FaceReason, LeftOutFace, ProposalError};
pub use propose::propose;
pub use request::{JobProposal, ProposalRequest, ProposedOperation};
