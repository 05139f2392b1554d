//! Independent checks of a pose: the strip it leaves, the body above it, where it cuts.

pub(crate) mod acceptance;
pub(crate) mod arc_contact;
pub(crate) mod ball_strip;
pub(crate) mod body;
pub(crate) mod cutting_zone;
pub(crate) mod findings;
pub(crate) mod proposal;
pub(crate) mod strip_of_pose;
pub(crate) mod survey;
