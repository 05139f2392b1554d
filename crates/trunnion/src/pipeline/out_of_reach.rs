//! Report of a face that is out of reach.

use crate::inverse::InverseError;
use crate::machine::FIRST_ROTARY;
use crate::types::{Interval, Uv};
use nalgebra::Point3;

/// Angles between tool axis and normal that are tried \[deg\]. The last is a little more than the largest inclination
/// of strips.
pub(super) const INCLINATIONS: [f64; 9] = [0.0, 2.5, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0];

/// Part of a face that is out of reach of the machine.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct OutOfReach {
    /// Number of the face.
    pub face: usize,
    /// Share of its area, by samples.
    pub share: f64,
    /// Range of the inclinations that were tried \[deg\].
    pub inclinations: Interval,
    /// Share of its area for a tool at the least inclination: square to the face, as it nearly is in wide strips, but for
    /// a barrel.
    pub upright: f64,
    /// Parameters of the point that is farthest out.
    pub uv: Uv,
    /// That point \[mm\], workpiece frame.
    pub point: Point3<f64>,
    /// Axis or axes that most of it is beyond, with their share of it.
    pub axes: String,
    /// Error at that point with the inclination that comes nearest.
    pub error: InverseError,
    /// Advice.
    pub remedy: String,
}

impl std::error::Error for OutOfReach {}

impl std::fmt::Display for OutOfReach {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            face,
            share,
            inclinations,
            upright,
            uv: Uv { u, v },
            point,
            axes,
            error,
            remedy,
        } = self;
        let Interval { low, high } = *inclinations;
        let inclined = if low > 0.0 {
            format!("from {low:.1} to {high:.1} deg, with which its arc touches")
        } else {
            format!("up to {high} deg ({:.1} % if it stands square to the face)", 100.0 * upright)
        };
        write!(
            f,
            "face {face}: {:.1} % of it is out of reach in this setup, at any inclination of the cutter {inclined}, \
             because of {axes}; worst at (u, v) = ({u:.4}, {v:.4}), X {:.3} Y {:.3} Z {:.3}: {}; \
             {remedy}",
            100.0 * share,
            point.x,
            point.y,
            point.z,
            why(error)
        )
    }
}

/// Describes the error of a pose.
fn why(error: &InverseError) -> String {
    let InverseError::OutOfTravel(out) = error else { return error.to_string() };
    let (unit, factor) =
        if out.index < FIRST_ROTARY { ("mm", 1.0) } else { ("deg", 1.0_f64.to_degrees()) };
    // The end of travel on the side of the value.
    let end = if out.value > out.high { out.high } else { out.low };
    let [value, end, excess] = [out.value, end, out.excess].map(|number| number * factor);
    format!(
        "axis {} would have to go to {value:.3} {unit}, beyond its end of travel {end:.3} {unit} by {excess:.3} {unit} \
         at best",
        out.axis
    )
}
