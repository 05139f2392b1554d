//! Options of a plan.

/// How a path is to be run. No `Default`: the caller knows the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedOptions {
    /// Speed of the programmed point on everything but links \[mm/s\]; `None` for as fast as the axes can.
    pub feed: Option<f64>,
    /// Speed of the programmed point on links \[mm/s\]; `None` for as fast as the axes can.
    pub link_feed: Option<f64>,
    /// Speed of the tool tip in the workpiece frame, on every motion \[mm/s\]; `None` for no limit.
    pub tip: Option<f64>,
    /// [`super::optimal`] inserts rows until the time still to gain is estimated below this fraction of the
    /// piece's time, [`super::jerk()`] goes on until a sweep gains less. Limits hold whatever the value; 1e-3
    /// is fine, 1 never goes on for speed.
    pub time_tolerance: f64,
    /// `ds/dt` at the start of the first piece and at the end of the last; pieces rest where they
    /// meet.
    pub ends: [f64; 2],
    /// Whether [`super::optimal`] keeps the limits everywhere. `false` looks at rows alone (TOPP-RA's
    /// interpolation scheme on the path's nodes) and may break limits in between, for comparison;
    /// [`FeedPlan::bounds`] tells by how much. [`super::jerk()`] always keeps them.
    pub guarantee: bool,
}
