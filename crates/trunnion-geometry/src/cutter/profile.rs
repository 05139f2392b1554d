//! The outline of a cutter in the half plane through its axis.

use super::spec::CutterSpec;

/// A piece of the outline, directed from the tip to the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProfilePiece {
    /// Quarter circle, convex, from straight below its centre to straight outward of it.
    Arc {
        /// Centre `[rho, z]` \[mm\].
        center: [f64; 2],
        /// Radius \[mm\].
        radius: f64,
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
            Self::Arc { center: [rho, z], radius } => [rho, z - radius],
            Self::Line { from, .. } => from,
        }
    }

    /// Returns the end, `[rho, z]` \[mm\].
    pub fn end(&self) -> [f64; 2] {
        match *self {
            Self::Arc { center: [rho, z], radius } => [rho + radius, z],
            Self::Line { to, .. } => to,
        }
    }

    /// Returns the distance from start to end \[mm\].
    pub fn extent(&self) -> f64 {
        let ([x0, z0], [x1, z1]) = (self.start(), self.end());
        (x1 - x0).hypot(z1 - z0)
    }
}

/// Returns the whole outline; pieces without length are left out.
pub(super) fn lay_out(spec: &CutterSpec) -> Vec<ProfilePiece> {
    let [major, minor] = [spec.major, spec.minor];
    // Flat bottom up to the centre circle, then the corner arc out to the largest radius.
    let mut pieces = vec![ProfilePiece::Line { from: [0.0, 0.0], to: [major, 0.0] }];
    if minor > 0.0 {
        pieces.push(ProfilePiece::Arc { center: [major, minor], radius: minor });
    }
    let mut at = [major + minor, minor];
    let mut line_to = |to: [f64; 2]| {
        pieces.push(ProfilePiece::Line { from: at, to });
        at = to;
    };
    // The flank keeps the radius of the cutter up to the first entry of the shank.
    if let Some(&[height, _]) = spec.shank.first() {
        line_to([major + minor, height]);
    }
    for &[height, radius] in &spec.shank {
        line_to([radius, height]);
    }
    // From the last entry straight up to the gauge point.
    let last = spec.shank.last().map_or(major + minor, |&[_, radius]| radius);
    line_to([last, spec.length]);
    // No disc on a ball, no flank where the shank begins at the corner.
    pieces.retain(|piece| piece.extent() > 0.0);
    pieces
}
