//! Placing the passes of one face: cutter locations along a candidate pass, trimming, and the material that stays.

pub(super) mod axis_limit;
mod ball_cap;
mod barred;
pub(super) mod candidate;
pub(super) mod context;
pub(super) mod face;
pub(super) mod finish;
pub(super) mod fixed_axis;
pub(super) mod flank;
mod flank_pieces;
pub(super) mod floor;
pub(super) mod inclination;
pub(super) mod keep_off;
pub(super) mod leftover;
pub(super) mod locate;
pub(super) mod placed;
pub(super) mod planner;
pub(super) mod progress;
pub(super) mod rulings;
mod run_out;
pub(super) mod spots;
pub(super) mod tool_fit;
pub(super) mod touch_up;
pub(super) mod trial;
pub(super) mod trim;
pub(super) mod uncut;
pub(super) mod unreachable;
