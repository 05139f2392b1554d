//! Jerk-limited schedules.
//!
//! The squared speed is a spline (`spline`) whose rows (`rows`) bound velocities, accelerations and
//! jerks everywhere; an interior-point method (`newton`, `local`, `band`, `barrier`) makes it as fast as they
//! allow, from a slow profile (`start`, brought inside the limits by `restore` where an end moves) on a
//! grid that resolves rest (`grid`).

mod band_matrix;
mod barrier;
mod braking;
mod derivatives;
mod end_motion;
mod graded_grid;
mod initial;
mod measure;
mod newton;
mod planner;
mod restore;
mod rolling_plan;
mod rows;
mod slow_down;
mod solve;
mod speed_caps;
mod speed_spline;
mod stop;

pub(super) use planner::known_of;
pub use planner::{jerk, jerk_between};
pub(super) use rolling_plan::{PathAhead, RollingPlan};
pub(super) use stop::stop;
