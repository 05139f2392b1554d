//! Errors between tool path and axes.

use super::options::AxesOptions;
use crate::inverse::InverseError;
use crate::machine::AxisKind;
use crate::types::Cancelled;
use nalgebra::Point3;

/// Reason why a tool path has no axis path.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AxesError {
    /// An option is not a finite number above zero.
    #[error("{option} = {value}: must be a finite number above zero")]
    BadOption {
        /// Name of the option.
        option: &'static str,
        /// Its value.
        value: f64,
    },
    /// Bounds of a setup search are in the wrong order, or wider than there is.
    #[error(
        "{what} from {:.3} to {:.3} deg: the smaller angle comes first; a tilt is within 0 .. 180 deg, the others span a whole turn at most",
        low.to_degrees(), high.to_degrees()
    )]
    BadBounds {
        /// Name of the angle.
        what: &'static str,
        /// Lower bound \[rad\].
        low: f64,
        /// Upper bound \[rad\].
        high: f64,
    },
    /// A pose has no axis position.
    #[error("piece {piece} at u = {u:.4}: {source}")]
    Inverse {
        /// Index of the tool-path piece.
        piece: usize,
        /// Curve parameter.
        u: f64,
        /// Reason.
        source: InverseError,
    },
    /// A segment leaves travel on every branch and turn; the error has the nearest.
    #[error(
        "piece {piece}, node {node} (u = {u:.4}): axis {axis} would have to go to {}, beyond its end of travel {} by {} on the best branch; {remedy}",
        in_unit(*kind, *value), in_unit(*kind, *limit), in_unit(*kind, *excess)
    )]
    OutOfTravel {
        /// Index of the tool-path piece.
        piece: usize,
        /// Index of the node of the piece where it is worst.
        node: usize,
        /// Parameter of that node.
        u: f64,
        /// Name of the axis.
        axis: String,
        /// Linear or rotary, which is the unit of the numbers.
        kind: AxisKind,
        /// Position it would need \[mm or rad\].
        value: f64,
        /// End of travel \[mm or rad\].
        limit: f64,
        /// Distance beyond; positive.
        excess: f64,
        /// Remedy.
        remedy: String,
    },
    /// The axes cannot be followed within tolerance by steps of any size.
    #[error(
        "piece {piece} at u = {u:.4}: the axes stay {tip:.2e} mm, {axis:.2e} rad off the path however small the step; the tool path has a corner there, or passes a singular direction too close"
    )]
    NotFollowed {
        /// Index of the tool-path piece.
        piece: usize,
        /// Curve parameter.
        u: f64,
        /// Remaining distance of the tip \[mm\].
        tip: f64,
        /// Remaining angle of the tool axis \[rad\].
        axis: f64,
    },
    /// Two pieces do not meet.
    #[error("piece {piece} starts {tip:.4} mm and {axis:.2e} rad from where piece {before} ends")]
    Gap {
        /// Index of the piece that starts elsewhere.
        piece: usize,
        /// Index of the piece before.
        before: usize,
        /// Distance of the tips \[mm\].
        tip: f64,
        /// Angle between the tool axes \[rad\].
        axis: f64,
    },
    /// Two curves meet in the singular direction, but leave it in different directions.
    #[error(
        "between pieces {before} and {piece} a rotary axis must turn by {:.4} deg while the tool stands in the singular direction; put a link between them, or turn the setup so that the path keeps off that direction",
        turn.to_degrees()
    )]
    TurnAtRest {
        /// Index of the piece after.
        piece: usize,
        /// Index of the piece before.
        before: usize,
        /// Rotary move \[rad\].
        turn: f64,
    },
    /// Travel ends on the path, and the tool cannot be retracted there.
    #[error(
        "piece {piece}: a rotary axis reaches the end of its travel, and the tool cannot be retracted at X {:.3} Y {:.3} Z {:.3} (workpiece) to unwind: {why}; turn the setup, move its origin, or change [retract] of the machine file",
        tip.x, tip.y, tip.z
    )]
    NoRetract {
        /// Index of the piece.
        piece: usize,
        /// Tip there \[mm\].
        tip: Point3<f64>,
        /// Obstacle.
        why: &'static str,
    },
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Formats a position or distance \[mm or rad\] in mm or degrees with four decimals.
fn in_unit(kind: AxisKind, value: f64) -> String {
    match kind {
        AxisKind::Rotary => format!("{:.4} deg", value.to_degrees()),
        AxisKind::Linear => format!("{value:.4} mm"),
    }
}

/// Checks that all options are positive and finite.
pub(super) fn options(options: &AxesOptions) -> Result<(), AxesError> {
    // Comparisons are written so that a NaN is refused.
    for (option, value) in [
        ("tolerance.tip", options.tolerance.tip),
        ("tolerance.axis", options.tolerance.axis),
        ("max_rotary_step", options.max_rotary_step),
        ("rotary_weights.first", options.rotary_weights.first),
        ("rotary_weights.second", options.rotary_weights.second),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(AxesError::BadOption { option, value });
        }
    }
    if let Some(retract) = &options.retract {
        for (option, value) in [
            ("retract.plane", retract.plane.abs()),
            ("retract.least", retract.least),
            // Infinite means that the whole retract is run as a lead.
            ("retract.approach", retract.approach.min(f64::MAX)),
            ("retract.margin", retract.margin),
            ("retract.price", retract.price),
            ("retract.price_in_cut", retract.price_in_cut),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(AxesError::BadOption { option, value });
            }
        }
    }
    if let Some(singular) = &options.singular {
        for (option, value) in [
            ("singular.cone", singular.cone),
            ("singular.min_rotary", singular.min_rotary),
            ("singular.tilt", singular.tilt),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(AxesError::BadOption { option, value });
            }
        }
    }
    match options.start.iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(AxesError::BadOption { option: "start", value }),
        None => Ok(()),
    }
}
