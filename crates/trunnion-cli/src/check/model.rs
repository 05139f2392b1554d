//! What a check says of a control that is known by measurement.

use super::told::Fraction;
use trunnion::verify::{AxisRatio, ModelAudit};

/// Time on a named control, and the axes nearest to their limits there.
#[derive(Debug, serde::Serialize)]
pub(super) struct ModelTold {
    name: &'static str,
    seconds: f64,
    velocity: Worst,
    acceleration: Worst,
}

#[derive(Debug, serde::Serialize)]
struct Worst {
    axis: String,
    #[serde(flatten)]
    fraction: Fraction,
}

impl ModelTold {
    pub(super) fn of(model: &ModelAudit) -> Self {
        let worst = |AxisRatio { axis, ratio }: &AxisRatio| Worst {
            axis: axis.clone(),
            fraction: Fraction::of(ratio),
        };
        Self {
            name: "linuxcnc",
            seconds: model.seconds,
            velocity: worst(&model.velocity),
            acceleration: worst(&model.acceleration),
        }
    }

    /// For people.
    pub(super) fn words(&self) -> String {
        let Self { name, seconds, .. } = self;
        let worst = |Worst { axis, fraction: Fraction { ratio, line, .. } }: &Worst| {
            format!("{:.1} % of {axis} (line {line})", 100.0 * ratio)
        };
        format!(
            "{name}: {seconds:.1} s, no look-ahead over rotary moves; velocity up to {}, acceleration up to {}",
            worst(&self.velocity),
            worst(&self.acceleration)
        )
    }
}
