//! Time and loads on a control whose behaviour was measured.

use super::limit_ratio::LimitRatio;
use trunnion::verify::{AxisRatio, ModelAudit};
use trunnion_report::{Number, State};

/// Time on a named control, and the axes nearest to their limits there.
#[derive(Debug, serde::Serialize)]
pub(super) struct ControlModelSummary {
    name: &'static str,
    seconds: f64,
    velocity: Worst,
    acceleration: Worst,
    jerk: Worst,
}

#[derive(Debug, serde::Serialize)]
struct Worst {
    axis: String,
    #[serde(flatten)]
    fraction: LimitRatio,
}

impl ControlModelSummary {
    pub(super) fn of(model: &ModelAudit) -> Self {
        let worst = |AxisRatio { axis, ratio, .. }: &AxisRatio| Worst {
            axis: axis.clone(),
            fraction: LimitRatio::of(ratio),
        };
        Self {
            name: "linuxcnc",
            seconds: model.seconds,
            velocity: worst(&model.velocity),
            acceleration: worst(&model.acceleration),
            jerk: worst(&model.jerk),
        }
    }

    /// Returns the numbers for the page: time, and the axes with the largest velocity, acceleration and jerk. They are
    /// reported, not judged.
    pub(super) fn numbers(&self) -> Vec<Number> {
        let number = |what: &str, value: String, unit: &str, note: String| Number {
            label: format!("LinuxCNC {what}"),
            value,
            unit: unit.to_owned(),
            note,
            state: State::Plain,
            headline: false,
        };
        let note = "no look-ahead over rotary moves".to_owned();
        let mut numbers = vec![number("time", format!("{:.1}", self.seconds), "s", note)];
        let worst = [
            ("velocity", &self.velocity),
            ("acceleration", &self.acceleration),
            ("jerk", &self.jerk),
        ];
        numbers.extend(worst.map(
            |(what, Worst { axis, fraction: LimitRatio { ratio, line, .. } })| {
                let note = format!("of the limit of {axis}, at line {line}");
                number(what, format!("{:.1}", 100.0 * ratio), "%", note)
            },
        ));
        numbers
    }

    /// Returns the row of the table.
    pub(super) fn words(&self) -> String {
        let Self { name, seconds, .. } = self;
        let worst = |Worst { axis, fraction: LimitRatio { ratio, line, .. } }: &Worst| {
            format!("{:.1} % of {axis} (line {line})", 100.0 * ratio)
        };
        format!(
            "{name}: {seconds:.1} s, no look-ahead over rotary moves; velocity up to {}, acceleration up to {}, jerk up to {}, not judged",
            worst(&self.velocity),
            worst(&self.acceleration),
            worst(&self.jerk)
        )
    }
}
