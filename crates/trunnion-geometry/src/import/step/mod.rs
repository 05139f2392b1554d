//! STEP files (ISO 10303-21 with AP203, AP214 or AP242 geometry): bytes to faces.
//!
//! ```text
//! part21   text -> numbered records with their line
//! model    typed fields, points, placements        units     file -> mm, rad
//! curve    edges, profiles                         shape     surfaces as stated
//! placement assemblies
//! topology faces, loops, side                      chart     point in space -> (u, v)
//! trim     edge loops -> trim loops                known     control nets of elementary surfaces
//! solid    all faces -> a closed mesh
//! convert  stated surface -> `Surface`
//! ```
//!
//! Every layer trusts nothing below it: a reference may lead nowhere, to the wrong kind of entity
//! or round in a circle, a count may be astronomical, a number out of range. Anything unreadable
//! becomes a [`Warning`](super::Warning) with the entity and its line, and the face it belongs to
//! is left out; numbers of the other faces do not change.

mod chart;
mod convert;
mod curve;
mod known;
mod model;
mod part21;
mod placement;
mod reader;
mod shape;
mod solid;
mod topology;
mod trim;
mod units;

pub use reader::StepReader;
