//! Tests of kinematics, axis paths and feed planning: one binary, one module a subject.

// Helpers are shared with the tests of the crate on top, under its name.
extern crate trunnion_motion as trunnion;

mod branches;
mod chains;
mod dice;
mod every_choice;
mod feed;
mod feed_directions;
mod feed_stream;
mod feed_strip;
mod given;
mod jerk;
mod jerk_ends;
mod jerk_override;
mod jerk_stream;
mod look_ahead;
mod property;
mod setup;
mod waves;
