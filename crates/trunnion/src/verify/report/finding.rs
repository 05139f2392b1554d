//! Findings, and the sentences that state them.

use super::axis_audit::{LimitRatio, TravelOverrun};
use super::deviation::ExtremeHeight;
use crate::types::Interval;
use crate::verify::state::StateFinding;
use nalgebra::Point3;
use std::fmt;

/// Something that breaks a tolerance or a limit.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Finding {
    /// The tool cuts too deep.
    Gouge(ExtremeHeight),
    /// The tool leaves too much material.
    Excess(ExtremeHeight),
    /// Gouges in further regions, each less deep than those named.
    FurtherGouges {
        /// Number of regions.
        regions: usize,
    },
    /// Excess in further regions, each lower than those named.
    FurtherExcess {
        /// Number of regions.
        regions: usize,
    },
    /// One shift of the tool along its axis would keep the tolerance everywhere, see [`Deviation::higher`](super::Deviation::higher).
    Length {
        /// Least and largest shift \[mm\].
        higher: Interval,
    },
    /// Points that no tool came near.
    Uncut {
        /// Number of points.
        points: usize,
        /// Their area \[mm²\].
        area: f64,
        /// One of the points, workpiece frame \[mm\].
        point: Point3<f64>,
    },
    /// A rapid move finishes a point that no cut finishes; the material that a rapid cuts does not count as finished.
    Rapid {
        /// Line of the program.
        line: u32,
    },
    /// Points that could not be measured: no normal, or a search that was given up.
    Unmeasured {
        /// Number of points.
        points: usize,
    },
    /// An axis leaves its travel.
    Travel {
        /// Name of the axis.
        axis: String,
        /// Position farthest outside.
        worst: TravelOverrun,
    },
    /// An axis is too fast.
    Velocity {
        /// Name of the axis.
        axis: String,
        /// Largest ratio.
        worst: LimitRatio,
    },
    /// An axis accelerates too much.
    Acceleration {
        /// Name of the axis.
        axis: String,
        /// Largest ratio.
        worst: LimitRatio,
    },
    /// The control is in a state in which no cut is right.
    State(StateFinding),
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gouge(e) => {
                let more = if e.or_deeper { " or more" } else { "" };
                write!(f, "gouge of {:.4} mm{more} {e}", 0.0 - e.height)
            }
            Self::Excess(e) => write!(f, "excess of {:.4} mm {e}", e.height),
            Self::FurtherGouges { regions } => {
                write!(f, "gouges in {regions} further regions, each less deep")
            }
            Self::FurtherExcess { regions } => {
                write!(f, "excess in {regions} further regions, each lower")
            }
            Self::Length { higher: Interval { low: least, high: most } } => {
                let (way, near, far) =
                    if least > &0.0 { ("low", *least, *most) } else { ("high", -most, -least) };
                write!(
                    f,
                    "as a whole the tool runs {near:.4} to {far:.4} mm too {way} along its axis: no line does by itself; \
                     check the tool length and the height of the work offset"
                )
            }
            Self::Uncut { points, area, point: p } => write!(
                f,
                "{points} points ({area:.2} mm²) stay uncut, one at X {:.3} Y {:.3} Z {:.3}",
                p.x, p.y, p.z
            ),
            Self::Rapid { line } => write!(
                f,
                "line {line}: the face is cut at rapid speed where no feed move finishes it; make it a feed move"
            ),
            Self::Unmeasured { points } => {
                write!(
                    f,
                    "{points} points could not be measured (no surface normal, or no end of the search)"
                )
            }
            Self::Travel { axis, worst } => write!(
                f,
                "line {}: {axis} at {} is {} outside its travel",
                worst.line,
                worst.kind.format_value(worst.value),
                worst.kind.format_value(worst.excess)
            ),
            Self::Velocity { axis, worst } => write!(f, "{axis} velocity {worst}"),
            Self::Acceleration { axis, worst } => write!(f, "{axis} acceleration {worst}"),
            Self::State(finding) => finding.fmt(f),
        }
    }
}
