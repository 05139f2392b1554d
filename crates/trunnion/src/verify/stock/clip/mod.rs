//! Clips the rays of one tile by everything that moves near it.

pub(crate) mod batch;
pub(crate) mod candidates;
pub(crate) mod chain;
pub(crate) mod closest_approach;
pub(crate) mod cover;
pub(crate) mod front;
pub(crate) mod ray;
pub(crate) mod tile;
pub(crate) mod trace;
