//! Jerk-limited schedules.
//!
//! The squared speed is a spline (`speed_spline`) whose rows (`rows`) bound velocities,
//! accelerations and jerks everywhere. An interior-point method makes it as fast as they allow
//! (`newton`, `derivatives`, `band_matrix`, `barrier`). It starts from a slow profile (`initial`),
//! which `restore` brings inside the limits where an end moves, on a grid that resolves rest
//! (`graded_grid`).
//!
//! `planner` plans whole paths, `rolling_plan` extends a plan that is under way, and `stop` stops
//! it.

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
pub(super) use rolling_plan::{CellMotion, PathAhead, RollingPlan};
pub(super) use stop::stop;
