//! Control nets and swept splines that are planes, cylinders, cones, spheres or tori.
//!
//! Many systems write every face as a control net. One that is an elementary surface is read as
//! that: closest points are then known in closed form, a sphere has no pole where its face has
//! none, and beyond the net's rim lies the same surface and not a continuation.
//!
//! A fit suggests the surface; the proof ([`proof`]) decides: over all of the net the two are
//! nowhere farther apart than the tolerance.

mod fit;
mod proof;
mod recognise;
mod sample;
mod swept;

pub(super) use recognise::known;
pub(super) use swept::swept_net;
