//! Why there is no cutter location.

use super::Active;
use crate::surface::ClosestError;

/// Why a cutter location is not given. Places are parameters `(u, v)` of the face.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PositioningError {
    /// The band is empty or not finite.
    #[error(
        "the error band [{lower}, {upper}] mm is empty: upper must be above lower, both finite"
    )]
    EmptyBand {
        /// Lower end \[mm\].
        lower: f64,
        /// Upper end \[mm\].
        upper: f64,
    },
    /// The range of the offset direction is empty or leaves (-90, 90) degrees.
    #[error(
        "the offset range [{:.4}, {:.4}] deg must be ascending and inside (-90, 90)",
        .range[0].to_degrees(), .range[1].to_degrees()
    )]
    OffsetRange {
        /// The range given \[rad\].
        range: [f64; 2],
    },
    /// The feed direction has no length on the surface, or the surface no normal.
    #[error(
        "the feed [{}, {}] has no direction at (u, v) = ({:.6}, {:.6}): give another feed, or move \
         away from the collapsed edge",
        .feed[0], .feed[1], .uv[0], .uv[1]
    )]
    NoDirection {
        /// Feed `[du, dv]`.
        feed: [f64; 2],
        /// Place.
        uv: [f64; 2],
    },
    /// The rear of the cutter was asked to cut, but it cannot.
    #[error(
        "the contact arc cannot lie behind the centre: inserts cut only outside {inner} mm; use \
         side \"ahead\" or a centre-cutting tool"
    )]
    NotCentreCutting {
        /// Inner cutting radius \[mm\].
        inner: f64,
    },
    /// The contact lies on the part of the underside that does not cut.
    #[error(
        "at (u, v) = ({:.6}, {:.6}) the contact lies {radius:.3} mm from the tool axis, inside the \
         inner cutting radius of {inner} mm",
        .uv[0], .uv[1]
    )]
    NotCutting {
        /// Place.
        uv: [f64; 2],
        /// Distance of the contact from the tool axis \[mm\].
        radius: f64,
        /// Inner cutting radius \[mm\].
        inner: f64,
    },
    /// The surface bends more sharply than the corner of the cutter.
    #[error(
        "cutter too large for the concave radius here: {concave:.3} mm at (u, v) = ({:.6}, {:.6}), \
         the corner radius is {minor} mm; take a corner radius below {concave:.3} mm",
        .uv[0], .uv[1]
    )]
    ConcaveRadius {
        /// Place.
        uv: [f64; 2],
        /// Smallest concave radius of curvature there \[mm\].
        concave: f64,
        /// Corner radius `r` \[mm\].
        minor: f64,
    },
    /// No strip wider than what every inclination gives.
    #[error(
        "no strip at (u, v) = ({:.6}, {:.6}): the band is broken by {excess:.6} mm ({binding:?}); a \
         strip of sqrt(8 R e) = {smallest:.3} mm is the least a fitting cutter leaves; use a smaller \
         cutter, another feed direction, or a wider tolerance",
        .uv[0], .uv[1]
    )]
    NoStrip {
        /// Place.
        uv: [f64; 2],
        /// `sqrt(8 R e)` \[mm\].
        smallest: f64,
        /// Least breach of the band found \[mm\].
        excess: f64,
        /// The constraint that is broken most.
        binding: Active,
    },
    /// Flank, shank or holder come too close.
    #[error(
        "the tool above its cutting end touches the face at (u, v) = ({:.6}, {:.6}), {height:.3} mm \
         above the tip: clearance {clearance:.4} mm; use a longer or slimmer tool, or more lead",
        .uv[0], .uv[1]
    )]
    Body {
        /// Place of the strip.
        uv: [f64; 2],
        /// Height above the tip \[mm\].
        height: f64,
        /// Clearance that could be proven there \[mm\].
        clearance: f64,
    },
    /// The surface gave no closest point.
    #[error("near (u, v) = ({:.6}, {:.6}): {error}", .uv[0], .uv[1])]
    Closest {
        /// Place.
        uv: [f64; 2],
        /// Why not.
        error: ClosestError,
    },
}
