//! Errors of covering and joining, with the point of the face that they are about.

use super::flank_refusal::FlankRefusal;
use crate::positioning::PositioningError;
use crate::surface::{FaceIndex, PrincipalCurvatures};
use crate::types::{Cancelled, Uv};
use nalgebra::Point3;
use std::fmt;

/// Point of a face, and the largest ball that fits there.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FacePoint {
    /// Parameters.
    pub uv: Uv,
    /// Point \[mm\].
    pub point: Point3<f64>,
    /// Least radius with which the face bends towards the cutter at the point \[mm\]: no larger ball fits.
    /// Infinite where the face does not bend towards the cutter.
    pub concave_radius: f64,
    /// The same over the whole face, or a little less.
    pub least_concave_radius: f64,
}

impl FacePoint {
    /// Evaluates the point of `face` at `uv`.
    pub(super) fn new(face: &FaceIndex, uv: Uv) -> Self {
        let Uv { u, v } = uv;
        let jet = face.face().surface.jet2(u, v);
        // Positive curvature is concave on the side of the surface's own normal; `flip` exchanges
        // the sides.
        let towards = |c: PrincipalCurvatures| if face.face().flip { -c.min } else { c.max };
        let bend = jet.curvature().map_or(0.0, towards).max(0.0);
        let concave_radius = bend.recip();
        // Both round on their own: on a cylinder the least one may come out a digit above.
        let least_concave_radius = face.smallest_concave_radius().min(concave_radius);
        Self { uv, point: jet.s, concave_radius, least_concave_radius }
    }
}

impl fmt::Display for FacePoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Uv { u, v }, p) = (self.uv, self.point);
        write!(
            f,
            "at (u, v) = ({u:.6}, {v:.6}), X {:.3} Y {:.3} Z {:.3}, the face is ",
            p.x, p.y, p.z
        )?;
        if self.concave_radius.is_finite() {
            let radius = self.concave_radius;
            write!(f, "hollow with a radius of {radius:.3} mm, the largest ball that fits there")?;
        } else {
            write!(f, "not hollow")?;
        }
        if self.least_concave_radius < self.concave_radius && self.least_concave_radius > 0.0 {
            write!(
                f,
                "; one of {:.3} mm fits all over the face, as far as it bends",
                self.least_concave_radius
            )?;
        }
        Ok(())
    }
}

/// Error of [`cover`](super::cover) or [`legs`](super::legs).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CoverError {
    /// An option is outside its range.
    #[error("{name} is {value}; it must be {must}")]
    BadOption {
        /// Name of the option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Range that it must be in.
        must: &'static str,
    },
    /// The tool cannot finish a single point of any face.
    #[error(
        "face {face}: the cutter cannot be placed anywhere, at any inclination: {}; {at}", .error.in_one_line()
    )]
    NoPose {
        /// Number of the face.
        face: usize,
        /// First point that was refused.
        at: Box<FacePoint>,
        /// Reason at that point.
        error: PositioningError,
    },
    /// The job asks for the flank, and it cannot cut the face.
    #[error("face {face} cannot be cut by the flank: {why}")]
    NoFlank {
        /// Number of the face.
        face: usize,
        /// Reason.
        why: FlankRefusal,
    },
    /// No lead connects a pass with the height of the links.
    #[error(
        "pass {pass} on face {face}: every lead between the pass and the link height gouges \
         (by {depth:.4} mm or more) or does not lead up; use a slimmer or longer tool, machine the face in a \
         setup of its own, or lower the plane of the links"
    )]
    LeadGouges {
        /// Index of the pass.
        pass: usize,
        /// Number of the face.
        face: usize,
        /// Deepest gouge seen on the leads that were tried \[mm\].
        depth: f64,
    },
    /// Both passes have leads, but no link connects them.
    #[error(
        "pass {pass} on face {face}: no link round the part from the pass before keeps the tool clear of all faces; use a slimmer or shorter tool or a larger clearance, or machine the face in several setups"
    )]
    NoWayRound {
        /// Index of the pass.
        pass: usize,
        /// Number of the face.
        face: usize,
    },
    /// Stopped through `Progress`.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
