//! Tests of surfaces and part files: one binary, one module a subject.

// Helpers are shared with the tests of the crate on top, under its name.
extern crate trunnion_geometry as trunnion;

mod curvature_rate;
mod drop_cutter;
#[path = "../../../trunnion-motion/tests/it/property/mod.rs"]
mod property;
mod step;
mod surface;
