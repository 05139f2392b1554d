//! Errors of positioning.

use crate::cutter::{CutterError, CutterErrors};
use crate::positioning::active::ActiveConstraint;
use crate::surface::ClosestError;
use crate::types::{Interval, Uv};

/// Reason for which there is no cutter location. Points are given by parameters `(u, v)` of the face.
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
        .range.low.to_degrees(), .range.high.to_degrees()
    )]
    OffsetRange {
        /// The range given \[rad\].
        range: Interval,
    },
    /// The feed direction has no length on the surface, or the surface no normal.
    #[error(
        "the feed [{}, {}] has no direction at (u, v) = ({:.6}, {:.6})",
        .feed[0], .feed[1], .uv.u, .uv.v
    )]
    NoDirection {
        /// Feed `[du, dv]`.
        feed: [f64; 2],
        /// Parameters of the point.
        uv: Uv,
    },
    /// The rear of the cutter was asked to cut, but it cannot.
    #[error("the contact arc cannot lie behind the centre: inserts cut only outside {inner} mm")]
    NotCentreCutting {
        /// Inner cutting radius \[mm\].
        inner: f64,
    },
    /// The contact lies on the part of the underside that does not cut.
    #[error(
        "at (u, v) = ({:.6}, {:.6}) the contact lies {radius:.3} mm from the tool axis, inside the \
         inner cutting radius of {inner} mm",
        .uv.u, .uv.v
    )]
    NotCutting {
        /// Parameters of the point.
        uv: Uv,
        /// Distance of the contact from the tool axis \[mm\].
        radius: f64,
        /// Inner cutting radius \[mm\].
        inner: f64,
    },
    /// The surface bends more sharply than the corner of the cutter.
    #[error(
        "cutter too large for the concave radius here: {concave:.3} mm at (u, v) = ({:.6}, {:.6}), \
         the corner radius is {minor} mm",
        .uv.u, .uv.v
    )]
    ConcaveRadius {
        /// Parameters of the point.
        uv: Uv,
        /// Smallest concave radius of curvature there \[mm\].
        concave: f64,
        /// Corner radius `r` \[mm\].
        minor: f64,
    },
    /// The surface bends more sharply than the arc of the cutter.
    #[error(
        "cutter too large for the concave radius here: {concave:.3} mm at (u, v) = ({:.6}, {:.6}), where the arc of the \
         cutter touches with {radius:.3} mm",
        .uv.u, .uv.v
    )]
    ConcaveArc {
        /// Parameters of the point.
        uv: Uv,
        /// Concave radius in the direction that does not fit \[mm\].
        concave: f64,
        /// Radius of the cutter in that direction \[mm\].
        radius: f64,
    },
    /// No strip wider than what every inclination gives.
    #[error("{}", no_strip(*.uv, *.smallest, *.excess, *.binding))]
    NoStrip {
        /// Parameters of the point.
        uv: Uv,
        /// `sqrt(8 R e)` \[mm\].
        smallest: f64,
        /// Least breach of the band found \[mm\]; infinite where no pose was worth looking at.
        excess: f64,
        /// The constraint that is broken most.
        binding: ActiveConstraint,
    },
    /// The method's pose cuts too deep.
    #[error(
        "at (u, v) = ({:.6}, {:.6}) the cutter comes {depth:.6} mm too close with {binding}, and this \
         method cannot avoid it",
        .uv.u, .uv.v
    )]
    Gouges {
        /// Parameters of the point.
        uv: Uv,
        /// Depth below the band \[mm\].
        depth: f64,
        /// The part of the cutter that does: `Touch`, `Rear` or `Disc`.
        binding: ActiveConstraint,
    },
    /// No pose touches twice as the method wants.
    #[error(
        "at (u, v) = ({:.6}, {:.6}) no pose with an offset direction in [{:.3}, {:.3}] deg touches \
         twice with the error between at the tolerance: along the chord the surface has to bend more \
         than across it",
        .uv.u, .uv.v, .range.low.to_degrees(), .range.high.to_degrees()
    )]
    NoPair {
        /// Parameters of the point.
        uv: Uv,
        /// Range of the offset direction \[rad\].
        range: Interval,
    },
    /// The method places a circle, and a ball has none.
    #[error("the method needs a cutter with R above 0: a ball touches in one point")]
    NoCircle,
    /// The method places the tip of the cutter.
    #[error("the method places the tip of the cutter, and a barrel cuts with its large arc")]
    BarrelArc,
    /// An angle of the method is out of range.
    #[error("the {name} is {:.4} deg: must be {must}", .value.to_degrees())]
    Angle {
        /// Name of the value.
        name: &'static str,
        /// The value given \[rad\].
        value: f64,
        /// Condition it has to meet.
        must: &'static str,
    },
    /// A number of the nested search is out of range.
    #[error("nested search: {name} is {value}, must be {must}")]
    Parameter {
        /// Name of the value.
        name: &'static str,
        /// The value given; lengths in mm, angles in rad.
        value: f64,
        /// Condition it has to meet.
        must: &'static str,
    },
    /// No ball as large as the cutter can be made of its length and shank.
    #[error("a ball as large as the cutter: {}", list(.0))]
    Cutter(CutterErrors),
    /// Flank, shank or holder come too close.
    #[error(
        "the tool above its cutting end touches the face at (u, v) = ({:.6}, {:.6}), {height:.3} mm \
         above the tip: clearance {clearance:.4} mm",
        .uv.u, .uv.v
    )]
    Body {
        /// Parameters of the strip.
        uv: Uv,
        /// Height above the tip \[mm\].
        height: f64,
        /// Clearance that could be proven there \[mm\].
        clearance: f64,
    },
    /// The machine does not reach the pose.
    #[error(
        "at (u, v) = ({:.6}, {:.6}) the machine does not reach the pose of the tool", .uv.u, .uv.v
    )]
    OutOfReach {
        /// Parameters of the strip.
        uv: Uv,
    },
    /// The tool comes too close to another face of the part.
    #[error(
        "at (u, v) = ({:.6}, {:.6}) the tool goes into face {face}, by {depth:.4} mm or more",
        .uv.u, .uv.v
    )]
    Neighbour {
        /// Parameters of the strip.
        uv: Uv,
        /// Number of the face.
        face: usize,
        /// A depth below what has to be kept from it \[mm\].
        depth: f64,
    },
    /// The surface gave no closest point.
    #[error("near (u, v) = ({:.6}, {:.6}): {error}", .uv.u, .uv.v)]
    Closest {
        /// Parameters of the point.
        uv: Uv,
        /// Reason.
        error: ClosestError,
    },
}

impl PositioningError {
    /// Returns what to change so that there is a cutter location; `None` if the reason alone says it.
    pub fn remedy(&self) -> Option<String> {
        Some(match self {
            Self::EmptyBand { .. }
            | Self::OffsetRange { .. }
            | Self::Angle { .. }
            | Self::Parameter { .. }
            | Self::Cutter(_)
            | Self::Closest { .. } => return None,
            Self::NoDirection { .. } => {
                "give another feed, or move away from the collapsed edge".to_owned()
            }
            Self::NotCentreCutting { .. } => {
                "use side \"ahead\" or a centre-cutting tool".to_owned()
            }
            Self::NotCutting { .. } => {
                "incline the tool more, or take a cutter that cuts nearer to its axis".to_owned()
            }
            Self::ConcaveRadius { concave, .. } => {
                format!("take a corner radius below {concave:.3} mm")
            }
            Self::ConcaveArc { concave, .. } => {
                format!("take a radius below {concave:.3} mm, or another feed direction")
            }
            Self::NoStrip { binding, .. } => against(*binding).to_owned(),
            Self::Gouges { binding, .. } => {
                format!("{}, or let the end-point method find a pose", against(*binding))
            }
            Self::NoPair { .. } => "feed closer to the direction of smallest curvature, widen the offset range, or use the \
                                    end-point method"
                .to_owned(),
            Self::NoCircle => "use ball or sturz".to_owned(),
            Self::BarrelArc => "take end-point or ball".to_owned(),
            Self::Body { .. } => "use a longer or slimmer tool, or more lead".to_owned(),
            Self::OutOfReach { .. } => "turn the setup, or incline the tool otherwise".to_owned(),
            Self::Neighbour { .. } => {
                "use a smaller, slimmer or longer cutter, or another inclination".to_owned()
            }
        })
    }

    /// Returns reason and remedy in one line, for reports of many regions.
    pub(crate) fn in_one_line(&self) -> String {
        self.remedy().map_or_else(|| self.to_string(), |remedy| format!("{self}; {remedy}"))
    }
}

fn list(faults: &[CutterError]) -> String {
    let faults: Vec<String> = faults.iter().map(ToString::to_string).collect();
    faults.join("; ")
}

fn no_strip(Uv { u, v }: Uv, smallest: f64, excess: f64, binding: ActiveConstraint) -> String {
    let place = format!("no strip at (u, v) = ({u:.6}, {v:.6})");
    let broken = if excess.is_finite() {
        format!("the best pose found still breaks the band by {excess:.6} mm at {binding}")
    } else {
        "no pose was found to start from".to_owned()
    };
    format!(
        "{place}: {broken} (on a flat face no strip is narrower than sqrt(8 R e) = {smallest:.3} mm)"
    )
}

/// Returns the remedy against a constraint.
fn against(binding: ActiveConstraint) -> &'static str {
    match binding {
        ActiveConstraint::Rear => {
            "take a smaller R, another feed direction, or a contact arc on the other side"
        }
        ActiveConstraint::Disc => "take a smaller R, or more lead",
        ActiveConstraint::Touch => "take a smaller cutter, more lead, or another feed direction",
        ActiveConstraint::Middle | ActiveConstraint::FirstSlope | ActiveConstraint::SecondSlope => {
            "allow a wider tolerance, or take another feed direction"
        }
        ActiveConstraint::Chord => "take a larger R",
        ActiveConstraint::OffsetRange => "widen the offset range, or take another feed direction",
        ActiveConstraint::AxisTurn => "allow the tool axis to turn farther",
        ActiveConstraint::GivenLead => "give another lead",
    }
}
