//! Error curves of locations, traced and drawn.

pub(crate) mod picture;
pub(crate) mod trace;
