//! Bounds between the measured points: the deepest gouge and the highest excess over a whole face.
//!
//! * `h >= -G` everywhere if no tool ever reaches the face offset inwards by `G`. A convex tool that holds a point of the
//!   face and gets below `-G` on its normal is at `-G` as well.
//!   At an edge it is enough that no point of the face lies deeper inside a tool than `G` (`DepthRule::InsideTool`).
//! * `h <= E` over a piece of the face if one tool, at one instant, holds the whole piece offset outwards by `E`, or holds
//!   its points one after the other while it moves.
//!
//! Both are tested on pieces that are planes to within a known error; pieces that fail are quartered.

mod excess;
pub(super) mod faces;
mod gather;
mod gouge;
pub(super) mod margin;
mod shape;
mod survey;
pub(super) mod trim_segments;
