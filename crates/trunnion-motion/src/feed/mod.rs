//! Speed along an axis path within axis limits; knows no machine.
//!
//! [`optimal()`] plans the fastest speed within velocity limits, acceleration limits and the programmed
//! feed. The limits hold everywhere on the path, not only at its nodes. [`jerk()`] keeps jerk limits as
//! well. The axes rest where two pieces meet.
//!
//! # Example
//!
//! Two axes run through six waypoints, each with at most 200 mm/s, 1000 mm/s² and 20 m/s³:
//!
//! ```
//! use nalgebra::Vector2;
//! use trunnion_motion::feed::{FeedOptions, Limits, jerk};
//! use trunnion_motion::types::{AxisPath, Silent};
//!
//! let waypoints = [[0.0, 0.0], [20.0, 5.0], [40.0, 30.0], [60.0, 20.0], [70.0, 0.0], [100.0, 0.0]];
//! let path = AxisPath::through(&waypoints.map(Vector2::from))?;
//! let [velocity, acceleration, change] = [200.0, 1e3, 2e4].map(Vector2::repeat);
//! let limits = Limits::symmetric(velocity, acceleration, change);
//!
//! let plan = jerk(&path, &limits, &FeedOptions::fastest(), &Silent)?;
//! let seconds = plan.schedule.duration();
//! // 100 mm take at least half a second at 200 mm/s, and no limit is broken anywhere.
//! assert!(seconds > 0.5 && seconds >= plan.lower_bound);
//! assert!(plan.bounds.velocity <= 1.0 && plan.bounds.acceleration <= 1.0);
//! assert!(plan.bounds.jerk.is_some_and(|jerk| jerk <= 1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`setpoint::sample`](crate::setpoint::sample) gives the axis positions of the plan at every servo
//! period.
//!
//! # Symbols
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `s` | path parameter | mm, or the unit that the path is given in |
//! | `v = ds/dt` | path velocity | mm/s |
//! | `x = v²` | squared speed, the unknown of the planners | mm²/s² |
//! | `u = d²s/dt² = x'/2` | path acceleration | mm/s² |
//! | `c = u' = x''/2` | change of `u` along the path; `d³s/dt³ = c v` | 1/s² |
//! | `q` | positions of the `N` axes | mm or rad |
//! | `q' = dq/ds`, also `t` | axis rates | axis unit/mm |
//! | `q'' = d²q/ds²`, also `K` | axis curvature | axis unit/mm² |
//! | `q''' = d³q/ds³`, also `L` | third derivative of the axes | axis unit/mm³ |
//! | `h` | length of a cell, which is the stretch between two rows | mm |
//!
//! A prime is a derivative by `s`. At every point of the path every axis `j` keeps
//!
//! ```text
//! |q'_j| sqrt(x)                                <= velocity_j
//! |q'_j u + q''_j x|                            <= acceleration_j
//! |q'_j c + 3 q''_j u + q'''_j x| sqrt(x)       <= jerk_j
//! ```
//!
//! The first bounds `x` alone, and the second is linear in `(x, u)`. The third is neither; [`jerk()`]
//! keeps a stronger one that is linear in `x`, `u` and `c`.
//!
//! # Rooms
//!
//! ```text
//! limits, options, plan, error   input and output of all planners
//! reciprocal, directional        limits of one kind of motion, towards plus and minus
//! cell, accelerations            one cell: Bernstein coefficients and linear constraints
//! cell_program                   the two-variable linear program of one cell
//! grid, profile, refine          rows and cells; backward and forward pass; rows where they pay
//! lower_bound                    certified lower bound of the time
//! measure, bounds, binding       figures of a plan, by another discretisation than the planner's
//! optimal, jerk                  the planners, without and with jerk limits
//! ceiling, speed_limit           speed limits of single points
//! blocks                         the classical planner: straight blocks with look-ahead
//! stream                         a path that arrives bit by bit, with feed hold and override
//! given                          the user's own speed: axis motion and broken limits
//! ```

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
    LookAhead, LookAheadOptions, PlannedBlock, SpeedRamp, StraightMoves, TinyBlocks, blocks,
    look_ahead,
};
pub use ceiling::{SpeedCeiling, ceiling};
pub use error::{FeedError, LimitKind};
pub use given::{GivenSpeed, LimitBreach, given};
pub use jerk::{jerk, jerk_between};
pub use limits::{Limits, MinusLimits};
pub use optimal::{optimal, optimal_schedule};
pub use options::{FeedOptions, PathEnds, ProgrammedSpeeds, SpeedOverrides};
pub use plan::{BindingLimit, FeedPlan, LimitRatios};
pub use speed_limit::limit_speeds;
pub use stream::{
    AnyStream, FeedStream, JerkStream, RowCount, StepSampler, StreamKind, StreamOptions,
    StreamStep, jerk_through_window,
};
