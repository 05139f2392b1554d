//! Axis paths through waypoints.

use super::axis_path::{AxisNode, AxisPath, AxisPiece};
use super::tool_path::Motion;
use crate::math::spline::{CubicSpan, cubic_spline};
use nalgebra::SVector;

/// Reasons why no path runs through a list of waypoints. Waypoints count from 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WaypointError {
    /// A path needs two waypoints.
    #[error("{points} waypoint(s) given; a path needs at least two")]
    TooFew {
        /// Number of waypoints given.
        points: usize,
    },
    /// A waypoint is the same as the one before.
    #[error("waypoint {index} is the same as the one before; remove it")]
    Repeated {
        /// Index of the waypoint.
        index: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("waypoint {index}: axis {axis} is {value}; it must be finite")]
    NotFinite {
        /// Index of the waypoint.
        index: usize,
        /// Index of the axis.
        axis: usize,
        /// The value.
        value: f64,
    },
}

impl<const N: usize> AxisPath<N> {
    /// Makes a path of one piece through waypoints: a C2 cubic spline, with its exact derivatives at
    /// every node.
    ///
    /// The path parameter `s` is the length of the chords between the waypoints, in the unit of the
    /// axes. The spline has not-a-knot ends, as in [`cubic_spline`]; two waypoints give a straight
    /// line. The tip and the programmed point move with the speed `|dq/ds|` of the axes.
    ///
    /// # Errors
    ///
    /// [`WaypointError`] for less than two waypoints, for repeated ones, and for numbers that are not
    /// finite.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::Vector2;
    /// use trunnion_types::types::AxisPath;
    ///
    /// let path = AxisPath::through(&[Vector2::new(0.0, 0.0), Vector2::new(3.0, 4.0)])?;
    /// let end = path.pieces[0].nodes[1];
    /// assert_eq!(end.s, 5.0); // the distance of both points
    /// assert!((end.q[1] - Vector2::new(0.6, 0.8)).norm() < 1e-15); // the direction of the line
    /// # Ok::<(), trunnion_types::types::WaypointError>(())
    /// ```
    pub fn through(points: &[SVector<f64, N>]) -> Result<Self, WaypointError> {
        if points.len() < 2 {
            return Err(WaypointError::TooFew { points: points.len() });
        }
        for (index, point) in points.iter().enumerate() {
            if let Some((axis, &value)) = point.iter().enumerate().find(|(_, q)| !q.is_finite()) {
                return Err(WaypointError::NotFinite { index, axis, value });
            }
        }
        let mut knots = vec![0.0];
        let mut s = 0.0;
        for (index, pair) in points.windows(2).enumerate() {
            let after = s + (pair[1] - pair[0]).norm();
            // A distance that is lost in the rounding of `s` counts as none.
            if after <= s {
                return Err(WaypointError::Repeated { index: index + 1 });
            }
            s = after;
            knots.push(s);
        }
        let spans = cubic_spline(&knots, points);
        let starts = spans.iter().zip(&knots).map(|(span, &s)| node(s, span, 0.0));
        let mut nodes: Vec<AxisNode<N>> = starts.collect();
        if let (Some(span), Some(&[before, last])) = (spans.last(), knots.last_chunk()) {
            nodes.push(node(last, span, last - before));
        }
        // Evaluating a span at its end rounds; the waypoint itself is known.
        for (node, point) in nodes.iter_mut().zip(points) {
            node.q[0] = *point;
        }
        Ok(Self { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] })
    }
}

/// Returns the node at distance `d` from the start of a span.
fn node<const N: usize>(s: f64, [a, b, c, e]: &CubicSpan<N>, d: f64) -> AxisNode<N> {
    let q = [
        a + (b + (c + e * d) * d) * d,
        b + (c * 2.0 + e * (3.0 * d)) * d,
        c * 2.0 + e * (6.0 * d),
        e * 6.0,
    ];
    let rate = q[1].norm();
    AxisNode { s, q, tip_rate: rate, feed_rate: rate }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector1, Vector2};

    /// Between nodes the path is the quintic through three derivatives of both: a cubic is its own.
    #[test]
    fn the_path_is_the_spline_between_waypoints_as_well() {
        let points: Vec<_> =
            [[0.0, 0.0], [2.0, 1.0], [3.0, 3.0], [2.5, 5.0], [0.0, 4.0]].map(Vector2::from).into();
        let path = AxisPath::through(&points).unwrap();
        let piece = &path.pieces[0];
        let knots: Vec<f64> = piece.nodes.iter().map(|node| node.s).collect();
        let spans = cubic_spline(&knots, &points);
        for (index, pair) in knots.windows(2).enumerate() {
            for share in [0.0, 0.3, 0.9] {
                let d = share * (pair[1] - pair[0]);
                let [q, rate, ..] = piece.axes_at(pair[0] + d).unwrap();
                let want = node(0.0, &spans[index], d).q;
                assert!((q - want[0]).norm() < 1e-14 && (rate - want[1]).norm() < 1e-13);
            }
        }
        assert_eq!(piece.nodes[4].q[0], points[4]);
    }

    #[test]
    fn a_waypoint_that_makes_no_sense_is_named() {
        let one = Vector1::new(1.0);
        let through = |points: &[_]| AxisPath::through(points).unwrap_err().to_string();
        assert!(through(&[one]).contains("1 waypoint(s)"));
        assert!(through(&[one * 0.0, one, one]).contains("waypoint 2 is the same"));
        assert!(through(&[one, one * f64::NAN]).contains("waypoint 1: axis 0 is NaN"));
    }
}
