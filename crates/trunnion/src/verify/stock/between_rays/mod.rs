//! Collisions between the rays: bodies that must not touch material and come so close to it that they may between two rays.
//!
//! The rays show where to inspect. The depth of a body there is found by a search over all points and times, against the
//! uncut stock and everything that earlier bodies held. For that the program is run again.

pub(crate) mod boxes;
pub(crate) mod inspect;
mod polytope;
mod search;
