//! The outline of a cutter in the half plane through its axis.

use super::spec::CutterSpec;
use super::tangent::{ProfileSide, TangentProfile};
use crate::math;

/// A piece of the outline, directed from the tip to the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProfilePiece {
    /// Convex arc of at most a quarter of a circle.
    Arc {
        /// Centre `[rho, z]` \[mm\]; that of a barrel arc may lie beyond the axis, at a negative distance.
        center: [f64; 2],
        /// Radius \[mm\].
        radius: f64,
        /// Outward normal at the start, a unit vector: `[0, -1]` is straight down.
        from: [f64; 2],
        /// Outward normal at the end, a unit vector: `[1, 0]` is straight outward.
        to: [f64; 2],
    },
    /// Straight line.
    Line {
        /// Start `[rho, z]` \[mm\].
        from: [f64; 2],
        /// End `[rho, z]` \[mm\].
        to: [f64; 2],
    },
}

impl ProfilePiece {
    /// Returns the start, `[rho, z]` \[mm\].
    pub fn start(&self) -> [f64; 2] {
        match *self {
            Self::Arc { center, radius, from, .. } => on_circle(center, radius, from),
            Self::Line { from, .. } => from,
        }
    }

    /// Returns the end, `[rho, z]` \[mm\].
    pub fn end(&self) -> [f64; 2] {
        match *self {
            Self::Arc { center, radius, to, .. } => on_circle(center, radius, to),
            Self::Line { to, .. } => to,
        }
    }

    /// Returns the point at a share of the length, from 0 at the start to 1 at the end, `[rho, z]` \[mm\].
    pub fn at(&self, share: f64) -> [f64; 2] {
        match *self {
            Self::Arc { center, radius, from, to } => {
                // Angles from straight down.
                let [first, last] = [from, to].map(|[out, up]| math::atan2(out, -up));
                let angle = first + (last - first) * share;
                [center[0] + radius * math::sin(angle), center[1] - radius * math::cos(angle)]
            }
            Self::Line { from, to } => {
                [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
            }
        }
    }

    /// Returns points along an arc that divide it into `steps` equal parts, with both ends, or the ends of a line,
    /// `[rho, z]` \[mm\].
    pub fn points(&self, steps: u32) -> Vec<[f64; 2]> {
        match *self {
            Self::Arc { .. } => {
                (0..=steps).map(|step| self.at(f64::from(step) / f64::from(steps))).collect()
            }
            Self::Line { from, to } => vec![from, to],
        }
    }

    /// Returns the distance from start to end \[mm\].
    pub fn extent(&self) -> f64 {
        let ([x0, z0], [x1, z1]) = (self.start(), self.end());
        math::hypot(x1 - x0, z1 - z0)
    }
}

fn on_circle(center: [f64; 2], radius: f64, [out, up]: [f64; 2]) -> [f64; 2] {
    [center[0] + radius * out, center[1] + radius * up]
}

/// Returns the whole outline; pieces without length are left out. `tangent` is the cutting end of a cutter with a side.
pub(super) fn lay_out(spec: &CutterSpec, tangent: Option<&TangentProfile>) -> Vec<ProfilePiece> {
    let [major, minor] = [spec.major, spec.minor];
    // Flat bottom up to the centre circle, then the tip arc.
    let mut pieces = vec![ProfilePiece::Line { from: [0.0, 0.0], to: [major, 0.0] }];
    let mut at = tangent.map_or([major + minor, minor], TangentProfile::end);
    if let Some(profile) = tangent {
        pieces.extend(profile.pieces());
    } else if minor > 0.0 {
        let (from, to) = ([0.0, -1.0], [1.0, 0.0]);
        pieces.push(ProfilePiece::Arc { center: [major, minor], radius: minor, from, to });
    }
    let outer = at[0];
    let mut line_to = |to: [f64; 2]| {
        pieces.push(ProfilePiece::Line { from: at, to });
        at = to;
    };
    // The flank keeps the radius of the cutter up to the first entry of the shank.
    if let Some(&[height, _]) = spec.shank.first() {
        line_to([outer, height]);
    }
    for &[height, radius] in &spec.shank {
        line_to([radius, height]);
    }
    // From the last entry straight up to the gauge point.
    let last = spec.shank.last().map_or(outer, |&[_, radius]| radius);
    line_to([last, spec.length]);
    // No disc on a ball, no flank where the shank begins at the corner.
    pieces.retain(|piece| piece.extent() > 0.0);
    pieces
}

impl TangentProfile {
    /// Returns the tip arc and the side.
    pub fn pieces(&self) -> [ProfilePiece; 2] {
        let [joint, last] = self.normals();
        let tip = self.tip();
        let (center, radius) = (tip.center, tip.radius);
        let below = ProfilePiece::Arc { center, radius, from: [0.0, -1.0], to: joint };
        let beside = match self.side() {
            ProfileSide::Cone => ProfilePiece::Line { from: self.joint(), to: self.end() },
            ProfileSide::Arc(arc) => {
                let (center, radius) = (arc.center, arc.radius);
                ProfilePiece::Arc { center, radius, from: joint, to: last }
            }
        };
        [below, beside]
    }
}
