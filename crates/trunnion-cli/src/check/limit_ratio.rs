//! Largest ratio of an axis rate to its limit.

use trunnion::verify;

/// Largest ratio to a limit, for scripts.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(super) struct LimitRatio {
    pub(super) ratio: f64,
    pub(super) line: u32,
    broken: usize,
}

impl LimitRatio {
    pub(super) fn of(ratio: &verify::LimitRatio) -> Self {
        Self { ratio: ratio.worst, line: ratio.line, broken: ratio.broken }
    }
}
