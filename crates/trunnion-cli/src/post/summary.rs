//! Summary of posting, for people and for scripts.

use super::plan::Plan;
use super::posting::Posted;
use serde::Serialize;
use std::path::Path;
use trunnion::files::summary::TimesSummary;
use trunnion::nc::write::OutputFormat;
use trunnion::post::{AxisLoadRatios, MotionCount, PostMethod, PostReport};

/// Largest ratio that counts as within the limit: times are sums of rounded ones.
const KEPT: f64 = 1.0 + 1e-6;

/// Most lines that are listed.
const LISTED: usize = 20;

/// Answer of `--json`; mm, degrees, s.
#[derive(Debug, Serialize)]
pub(super) struct PostSummary {
    schema: &'static str,
    output: String,
    machine: String,
    dialect: &'static str,
    /// Meaning of F: an upper limit for the control's own planning, or the time of the block.
    feed_word: &'static str,
    /// Numbers of the tools, in order; a program posted as a whole may have several.
    tools: Vec<u32>,
    /// Blocks of the input and of the output; the same order below.
    blocks: [usize; 2],
    motion: ConservedMotion,
    /// Time of the output, rapid moves included.
    times: TimesSummary,
    /// Contents of the input beside it.
    left_out: LeftOutCount,
    /// Travel of the tip with feed.
    length: f64,
    /// Time with feed: as programmed, and with the limits of the axes kept.
    seconds: [f64; 2],
    /// Meaning of the second of them.
    #[serde(skip)]
    timed: &'static str,
    /// Time of last blocks that round to no word, which is in no block.
    #[serde(skip_serializing_if = "Option::is_none")]
    unwritten_seconds: Option<f64>,
    rapid_seconds: f64,
    control_model: &'static str,
    model_seconds: [f64; 2],
    linuxcnc_duration: [f64; 2],
    /// Largest axis velocity and acceleration over their limits.
    ratios_before: [f64; 2],
    ratios_after: [f64; 2],
    tip_tolerance: f64,
    axis_tolerance: f64,
    /// Bounds on the deviation of the program from the input, and on the tip movement by rounding.
    tip_bound: f64,
    axis_bound: f64,
    rounding: f64,
    /// Deviation that the program allows the control by asking for smoothing; all three together.
    smoothing_bound: f64,
    total_bound: f64,
    /// The same of rapid moves, before rounding and smoothing: mm, degrees.
    rapid_bound: [f64; 2],
    /// Line and axis velocity over its limit of the rapid move that the control would run fastest.
    #[serde(skip_serializing_if = "Option::is_none")]
    fastest_rapid: Option<(u32, f64)>,
    /// Moves that take longer than programmed.
    slowed: Slowed,
    /// Choices of `--smooth`.
    #[serde(skip_serializing_if = "Option::is_none")]
    smoothing: Option<SmoothingSummary>,
    /// Servo setpoints written beside the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    setpoints: Option<SetpointSummary>,
    /// Lines of the input before which the tool retracts so that rotaries can unwind.
    unwound: Vec<u32>,
    /// True if the text was read back and means what was intended; false if it has words that are not understood.
    read_back: bool,
    /// Tools that the tool table of the input's control has otherwise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    contradictions: Vec<String>,
    kept: bool,
}

/// Table of servo setpoints; s.
#[derive(Debug, Serialize)]
pub(super) struct SetpointSummary {
    pub(super) file: String,
    pub(super) period: f64,
    pub(super) rows: usize,
    pub(super) duration: f64,
}

impl SetpointSummary {
    fn describe(&self) -> String {
        let Self { file, period, rows, duration } = self;
        format!("{rows} rows, one every {period} s, {duration:.2} s in all: {file}")
    }
}

/// Motion of the input, and of the output as it was read back.
#[derive(Debug, Serialize)]
struct ConservedMotion {
    read: CountedMotion,
    written: CountedMotion,
    /// True if both were compared, and are the same; without reading back they cannot be.
    conserved: bool,
}

/// Motion that was counted: rapid, then with feed.
#[derive(Debug, Serialize)]
struct CountedMotion {
    moves: [usize; 2],
    /// Travel of the tip from end to end.
    length: [f64; 2],
    tools: usize,
}

impl From<MotionCount> for CountedMotion {
    fn from(of: MotionCount) -> Self {
        Self {
            moves: [of.rapids, of.cuts],
            length: [of.rapid_length, of.cut_length],
            tools: of.tools,
        }
    }
}

/// Parts of the input that are no motion of the tools that are posted.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(super) struct LeftOutCount {
    /// Moves of other tools, to the first place and away from the last.
    pub(super) moves: usize,
    pub(super) dwells: usize,
    /// Lines of words without motion.
    pub(super) words: usize,
}

/// Moves that take longer than programmed, because an axis cannot follow them.
#[derive(Debug, Serialize)]
struct Slowed {
    moves: usize,
    /// Lines of the input, the first of them.
    lines: Vec<u32>,
    /// Line of the one that is slowed most, and its time over the programmed one.
    #[serde(skip_serializing_if = "Option::is_none")]
    worst: Option<(u32, f64)>,
}

impl Slowed {
    fn new(report: &PostReport) -> Self {
        Self {
            moves: report.slowed_moves,
            lines: report.slowed.iter().take(LISTED).map(|one| one.line).collect(),
            worst: report.slowest.map(|one| (one.line, one.ratio())),
        }
    }

    fn describe(&self) -> Option<String> {
        let (first, (line, ratio)) = (self.lines.first()?, self.worst?);
        let moves = self.moves;
        Some(format!(
            "{moves} moves, because an axis cannot follow; the first at line {first}, the slowest at line {line}: {ratio:.2} times its time"
        ))
    }
}

/// Cuts that were smoothed where that is quicker.
#[derive(Debug, Serialize)]
struct SmoothingSummary {
    /// Cuts left as they are, changed in part, and as a whole.
    cuts: [usize; 3],
    /// Time with nothing changed, and as chosen.
    seconds: [f64; 2],
    /// Time that decided: `linuxcnc` (the control model) or `axes` (their limits).
    by: &'static str,
}

impl SmoothingSummary {
    fn describe(&self) -> String {
        let [kept, part, whole] = self.cuts;
        let [before, after] = self.seconds;
        let by =
            if self.by == "axes" { "by the limits of the axes" } else { "on the control model" };
        format!(
            "{whole} cuts, {part} in part; {kept} are quicker as they are: {before:.2} -> {after:.2} s {by}"
        )
    }
}

impl PostSummary {
    pub(super) fn new(plan: &Plan, posted: &Posted, output: &Path) -> Self {
        let Posted { report, head, .. } = posted;
        let tools = &head.tools;
        let style = &plan.style;
        let tolerance = plan.options.tolerance;
        let [before, after] = <[AxisLoadRatios; 2]>::from(report.loads)
            .map(|load| [load.velocity, load.acceleration]);
        Self {
            schema: "trunnion-post/1",
            output: output.display().to_string(),
            machine: plan.kinematics.machine().name.clone(),
            dialect: style.dialect.name(),
            feed_word: if style.inverse_time { "inverse time" } else { "tip feed" },
            tools: tools.clone(),
            blocks: report.blocks.into(),
            motion: ConservedMotion {
                read: CountedMotion::from(report.motion.input),
                written: CountedMotion::from(report.motion.output),
                // A difference is an error, and has no summary.
                conserved: report.unread.is_none(),
            },
            times: TimesSummary {
                // Feed blocks and rapid moves follow each other: their times add up.
                planned: report.seconds.output + report.rapid_seconds,
                certified_bound: None,
                linuxcnc: Some(report.linuxcnc_duration.output),
                ..TimesSummary::default()
            },
            left_out: posted.left_out,
            length: report.length,
            seconds: report.seconds.into(),
            timed: match plan.options.method {
                PostMethod::Optimal | PostMethod::Jerk => "s, as programmed -> limits kept",
                PostMethod::Blocks => "s, as programmed -> block after block",
                PostMethod::Programmed => "s, as programmed, and so written",
            },
            unwritten_seconds: Some(report.unwritten_seconds).filter(|seconds| *seconds > 0.0),
            rapid_seconds: report.rapid_seconds,
            control_model: "linuxcnc",
            model_seconds: report.model_seconds.into(),
            linuxcnc_duration: report.linuxcnc_duration.into(),
            ratios_before: before,
            ratios_after: after,
            tip_tolerance: tolerance.tip,
            axis_tolerance: tolerance.axis.to_degrees(),
            tip_bound: report.deviation.tip,
            // Summaries are in mm and degrees, reports of the library in mm and rad.
            axis_bound: report.deviation.axis.to_degrees(),
            rounding: report.rounding,
            smoothing_bound: report.smoothing_bound,
            // Deviations of different causes may point the same way, so the bounds add up.
            total_bound: report.deviation.tip + report.rounding + report.smoothing_bound,
            rapid_bound: [report.rapid_deviation.tip, report.rapid_deviation.axis.to_degrees()],
            fastest_rapid: report.fastest_rapid.map(|fast| (fast.line, fast.ratio)),
            slowed: Slowed::new(report),
            smoothing: report.smoothing.map(|of| SmoothingSummary {
                cuts: of.cuts,
                seconds: of.seconds.into(),
                by: if of.by_model { "linuxcnc" } else { "axes" },
            }),
            setpoints: None,
            unwound: report.unwound.clone(),
            read_back: report.unread.is_none(),
            contradictions: posted.contradictions.clone(),
            // A tip feed is an upper limit: the control keeps the limits of the axes itself.
            kept: posted.contradictions.is_empty()
                && ((plan.options.method == PostMethod::Programmed && !style.inverse_time)
                    || after.iter().all(|&ratio| ratio <= KEPT)),
        }
    }

    /// Adds the setpoints that were written.
    pub(super) fn with_setpoints(self, setpoints: Option<SetpointSummary>) -> Self {
        Self { setpoints, ..self }
    }

    /// Describes one kind of motion in the input and in the output.
    fn moves(&self, kind: usize) -> String {
        let ConservedMotion { read: from, written: to, .. } = &self.motion;
        let [moves, length] = [
            format!("{} -> {}", from.moves[kind], to.moves[kind]),
            format!("{:.4} -> {:.4} mm", from.length[kind], to.length[kind]),
        ];
        format!("{moves:>18}   {length}")
    }

    /// Returns true if the program keeps the limits of the axes, and the tools are those of the control.
    pub(super) fn kept(&self) -> bool {
        self.kept
    }

    pub(super) fn describe(&self) -> String {
        let row = |name: &str, value: String| format!("  {name:<22}{value}");
        let pair = |[a, b]: [f64; 2], unit: &str| format!("{a:>12.2} -> {b:<12.2}{unit}");
        let ratio = |which: usize| {
            pair([self.ratios_before[which], self.ratios_after[which]], "times the limit")
        };
        let mut lines = vec![
            format!("{}: {} for {}", self.output, self.dialect, self.machine),
            row("blocks", format!("{:>12} -> {}", self.blocks[0], self.blocks[1])),
            row("time with feed", pair(self.seconds, self.timed)),
            row(
                "on LinuxCNC",
                pair(self.linuxcnc_duration, "s with rapid moves: no look-ahead over rotary moves"),
            ),
            row("axis velocity", ratio(0)),
            row("axis acceleration", ratio(1)),
            row("rapid time", format!("{:>12.2} s by the limits of the axes", self.rapid_seconds)),
            row("rapid moves", self.moves(0)),
            row("moves with feed", self.moves(1)),
            row(
                "off the input",
                format!(
                    "at most {:.6} mm, {:.6} deg: program {:.6}, rounding {:.6}, smoothing of the control {:.6} mm",
                    self.total_bound,
                    self.axis_bound,
                    self.tip_bound,
                    self.rounding,
                    self.smoothing_bound
                ),
            ),
            row(
                "  in rapid moves",
                format!("at most {:.6} mm, {:.6} deg", self.rapid_bound[0], self.rapid_bound[1]),
            ),
        ];
        if let Some(seconds) = self.unwritten_seconds {
            let text = format!("{seconds:.6} s of last blocks that round to no word");
            lines.push(row("time without a block", text));
        }
        let LeftOutCount { moves, dwells, words } = self.left_out;
        if moves + dwells + words > 0 {
            let text = format!(
                "{moves} moves of other tools, {dwells} dwells, {words} lines of other words"
            );
            lines.push(row("left out", text));
        }
        lines.extend(self.contradictions.iter().map(|text| row("another tool", text.clone())));
        if let Some(slowed) = self.slowed.describe() {
            lines.push(row("slower than the input", slowed));
        }
        if self.tools.len() > 1 {
            let tools: Vec<String> = self.tools.iter().map(u32::to_string).collect();
            lines.push(row("tools", tools.join(", ")));
        }
        if let Some(smoothing) = &self.smoothing {
            lines.push(row("smoothed", smoothing.describe()));
        }
        if let Some(setpoints) = &self.setpoints {
            lines.push(row("setpoints", setpoints.describe()));
        }
        if let Some(first) = self.unwound.first() {
            let count = self.unwound.len();
            let times = if count == 1 { "once" } else { "times" };
            let count = if count == 1 { String::new() } else { format!("{count} ") };
            let text = format!(
                "{count}{times} off the part in a cut, first before line {first} of the input"
            );
            lines.push(row("rotaries unwind", text));
        }
        // APT has feeds, but no control that plans below them.
        let capped = self.feed_word == "tip feed"
            && OutputFormat::from_name(self.dialect) != Some(OutputFormat::Apt);
        if capped {
            lines.push(row(
                "F",
                "mm/min of the tip, an upper limit: the control plans its own speed below it"
                    .to_owned(),
            ));
        }
        lines.join("\n") + "\n"
    }
}
