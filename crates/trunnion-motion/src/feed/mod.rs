//! Axis path and limits to speed along the path; knows no machine.

mod accelerations;
mod binding;
mod blocks;
mod bounds;
mod ceiling;
mod cell;
mod cell_program;
mod directional;
mod ends;
mod error;
mod given;
mod grid;
mod jerk;
mod limits;
mod lower_bound;
mod measure;
mod numeric;
mod optimal;
mod options;
mod pieces;
mod plan;
mod profile;
mod reciprocal;
mod refine;
mod speed_limit;
mod stream;
mod validate;

pub use blocks::{
    LookAhead, LookAheadOptions, PlannedBlock, SpeedRamp, TinyBlocks, blocks, look_ahead,
};
pub use ceiling::{SpeedCeiling, ceiling};
pub use error::{FeedError, LimitKind};
pub use given::{GivenSpeed, LimitBreach, given};
pub use jerk::{jerk, jerk_between};
pub use limits::{Limits, MinusLimits};
pub use optimal::{optimal, optimal_schedule};
pub use options::FeedOptions;
pub use plan::{BindingLimit, FeedPlan, LimitRatios};
pub use speed_limit::limit_speeds;
pub use stream::{
    AnyStream, FeedStream, JerkStream, StreamOptions, StreamStep, jerk_through_window,
};
