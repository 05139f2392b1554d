//! The answer for scripts and for people.

use super::conserved::ClMotionCount;
use super::smoothed::{ARC_SHARE, SHARE, Sheet, WRITTEN};
use serde::Serialize;
use std::path::Path;
use trunnion::toolpath::SAME;
use trunnion::types::PoseTolerance;

/// Answer of `--json`.
#[derive(Debug, Default, Serialize)]
pub(super) struct Answer {
    schema: &'static str,
    /// Cutter locations read, and written.
    locations: [usize; 2],
    motion: ConservedMotion,
    smoothing: Option<SmoothingAnswer>,
}

/// Motion as it was read, and as it was read back from what was written.
#[derive(Debug, Default, Serialize)]
struct ConservedMotion {
    read: ClMotionCount,
    written: ClMotionCount,
    /// A difference is an error, and has no answer.
    conserved: bool,
}

/// Result of smoothing; mm and degrees.
#[derive(Debug, Serialize)]
struct SmoothingAnswer {
    tip_tolerance: f64,
    axis_tolerance: f64,
    tip_deviation: f64,
    tip_bound: f64,
    axis_deviation: f64,
    axis_bound: f64,
    spans: usize,
    merged: usize,
    corners_blended: usize,
    corners_kept: usize,
}

/// Returns the answer.
pub(super) fn answer(sheet: &Sheet, smooth: Option<PoseTolerance>) -> Answer {
    let [read, written] = sheet.conserved;
    Answer {
        schema: "trunnion-path/1",
        locations: sheet.locations,
        motion: ConservedMotion { read, written, conserved: true },
        smoothing: smooth.map(|tolerance| smoothing(sheet, tolerance)),
    }
}

fn smoothing(sheet: &Sheet, tolerance: PoseTolerance) -> SmoothingAnswer {
    let report = &sheet.report;
    let most = &report.deviated;
    // Without spans nothing was smoothed; merged locations lie within SAME of the tolerance on either side.
    let [tip_share, axis_share] = match (report.spans, report.merged) {
        (0, 0) => [0.0; 2],
        (0, _) => [2.0 * SAME; 2],
        _ => [SHARE + ARC_SHARE, SHARE],
    };
    SmoothingAnswer {
        tip_tolerance: tolerance.tip,
        axis_tolerance: tolerance.axis.to_degrees(),
        tip_deviation: most.tip,
        // Deviation of the path, division into straight moves, and rounding add up.
        tip_bound: most.tip_bound + tip_share * tolerance.tip + WRITTEN[0],
        axis_deviation: most.axis.to_degrees(),
        axis_bound: (most.axis_bound + axis_share * tolerance.axis + WRITTEN[1]).to_degrees(),
        spans: report.spans,
        merged: report.merged,
        corners_blended: report.blended,
        corners_kept: report.stops,
    }
}

/// Describes the answer for people.
pub(super) fn describe(answer: &Answer, place: &Path) -> String {
    let [read, written] = answer.locations;
    let mut lines = vec![format!("{}: {written} cutter locations", place.display())];
    let row = |name: &str, value: String| format!("  {name:<18}{value}");
    let ConservedMotion { read: from, written: to, .. } = &answer.motion;
    for (kind, name) in ["rapid moves", "moves with feed"].into_iter().enumerate() {
        let moves = format!("{} -> {}", from.moves[kind], to.moves[kind]);
        let length = format!("{:.4} -> {:.4} mm", from.length[kind], to.length[kind]);
        lines.push(row(name, format!("{moves:<18}{length}")));
    }
    if let Some(of) = &answer.smoothing {
        let SmoothingAnswer { tip_bound, axis_bound, corners_blended, corners_kept, .. } = of;
        lines.extend([
            row("read", format!("{read}, {} of them the same as the one before", of.merged)),
            row(
                "tip",
                format!(
                    "at most {tip_bound:.6} mm from the input path, {} mm allowed",
                    of.tip_tolerance
                ),
            ),
            row(
                "axis",
                format!("at most {axis_bound:.6} deg, {:.6} deg allowed", of.axis_tolerance),
            ),
            row("spans", of.spans.to_string()),
            row("corners", format!("{corners_blended} blended, {corners_kept} kept as stops")),
        ]);
    }
    lines.join("\n") + "\n"
}
