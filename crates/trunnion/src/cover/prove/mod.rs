//! Proofs about moving tools: clearance from faces, and coverage of the face that is cut.

pub(super) mod cell_passage;
pub(super) mod clearance;
pub(super) mod connected;
pub(super) mod coverage;
pub(super) mod deepest;
pub(super) mod face_cell;
pub(super) mod face_hull;
pub(super) mod face_tree;
pub(super) mod part_faces;
pub(super) mod span_strip;
pub(super) mod sweep;
mod swept_cell;
pub(super) mod time_slab;
