//! Smoothing that a program allows, for scripts and for people.

use trunnion::nc::read::Smoothing;
use trunnion::verify::StateReport;

/// Loosest smoothing during a cut.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(super) struct SmoothingSummary {
    kind: SmoothingKind,
    /// Distance from the path \[mm\]; null unless stated.
    distance: Option<f64>,
    /// Line that asks for it; null if none does.
    line: Option<u32>,
}

#[derive(Debug, Clone, Copy, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
enum SmoothingKind {
    /// No word of the program is about it.
    NotStated,
    /// The machine's own setting.
    OfMachine,
    Exact,
    Within,
    Unbounded,
}

impl SmoothingSummary {
    pub(super) fn of(state: &StateReport) -> Self {
        let Some(active) = state.smoothing else {
            return Self { kind: SmoothingKind::NotStated, distance: None, line: None };
        };
        let kind = match active.smoothing {
            Smoothing::Exact | Smoothing::Stop => SmoothingKind::Exact,
            Smoothing::Within(_) | Smoothing::Blended { .. } => SmoothingKind::Within,
            Smoothing::Unbounded => SmoothingKind::Unbounded,
            Smoothing::OfMachine => SmoothingKind::OfMachine,
        };
        // A sum of two words has no more decimals than they have.
        let distance = active.smoothing.bound().map(|sum| (sum * 1e9).round() / 1e9);
        Self { kind, distance, line: Some(active.line) }
    }

    pub(super) fn words(&self) -> String {
        let line = self.line.map_or_else(String::new, |line| format!(" (line {line})"));
        match (self.kind, self.distance) {
            (SmoothingKind::NotStated, _) => {
                "not stated: the machine's own smoothing adds to the deviations".to_owned()
            }
            (SmoothingKind::Exact, _) => format!("none{line}"),
            (SmoothingKind::Within, Some(distance)) => {
                format!("up to {distance} mm{line}, on top of the deviations")
            }
            (SmoothingKind::Unbounded, _) => {
                format!(
                    "not bounded{line}: the control may round corners by as much as the speed requires"
                )
            }
            _ => format!("the machine's own{line}, which adds to the deviations"),
        }
    }
}
