//! From passes to a whole program of motions: hops, leads and links.

pub(super) mod around;
pub(super) mod axis_reach;
pub(super) mod hop;
pub(super) mod leads;
pub(super) mod legs;
pub(super) mod request;
pub(super) mod step;
