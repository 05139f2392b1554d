//! Motion of the axes at one servo tick.

use super::axis_path::AXES;
use super::path_state::PathState;
use nalgebra::SVector;

/// Motion of `N` axes at one servo tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoint<const N: usize = AXES> {
    /// Time \[s\].
    pub t: f64,
    /// Positions \[mm, rad\].
    pub position: SVector<f64, N>,
    /// Velocities \[mm/s, rad/s\].
    pub velocity: SVector<f64, N>,
    /// Accelerations \[mm/s², rad/s²\].
    pub acceleration: SVector<f64, N>,
    /// Jerks \[mm/s³, rad/s³\]; an acceleration that steps leaves no trace here.
    pub jerk: SVector<f64, N>,
}

impl<const N: usize> Setpoint<N> {
    /// Creates the setpoint at time `t` from value and three derivatives of the axes by the path parameter, and the
    /// motion along the path.
    ///
    /// Applies the chain rule: `q̇ = q' v`, `q̈ = q' u + q'' v²`, `q⃛ = q' j + 3 q'' u v + q''' v³`.
    pub fn on_path(t: f64, axes: [SVector<f64, N>; 4], state: &PathState) -> Self {
        let [v, u, j] = [state.speed, state.acceleration, state.jerk];
        // The third derivative by time has 3 q'' u v from the product rule on both q' u and q'' v².
        let [position, rate, curvature, third] = axes;
        Self {
            t,
            position,
            velocity: rate * v,
            acceleration: rate * u + curvature * (v * v),
            jerk: rate * j + curvature * (3.0 * u * v) + third * v.powi(3),
        }
    }
}
