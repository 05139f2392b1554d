//! Times of the axis points, on the machine and on the control.
//!
//! [`PointTimer`] finds the times that the program asks for; [`ControlTiming`] and [`ControlClock`] the times that
//! a control takes; [`AxisLoad`] compares both with the limits of the axes.

mod block_motion;
mod control;
mod corner;
mod kept_times;
mod load;
mod look_ahead;
mod path_sampler;
mod smooth_path;
mod timed_point;
mod timer;

pub(super) use block_motion::position_error;
pub(super) use control::{ControlClock, ControlTiming, word_travel};
pub(super) use load::AxisLoad;
pub(super) use path_sampler::PathSampler;
pub(super) use smooth_path::SmoothPathTimer;
pub(super) use timed_point::TimedPoint;
pub(super) use timer::PointTimer;
