//! Summary of a check, for scripts and for people.

use super::assumptions::{AssumedSolutions, ToolChanges};
use super::control_model::ControlModelSummary;
use super::creeping::creeping;
use super::limit_ratio::LimitRatio;
use super::planner_time::PlannerTime;
use super::smoothing::SmoothingSummary;
use super::subject::{CheckedMotion, Subject};
use super::what_if::AssumedDeviation;
use crate::figure::plain;
use crate::material;
use std::path::PathBuf;
use trunnion::files::summary::{
    BodiesSummary, ChordSummary, FixturesSummary, StockSummary, TimesSummary,
};
use trunnion::machine::AxisKind;
use trunnion::pipeline;
use trunnion::verify::{self, AuditedMotion, AxisAudit, ExtremeHeight, Finding, InspectionReport};
use trunnion_report::Number;

/// Summary of a program checked against part and machine: `summary.json` and `--json`; mm, degrees, s.
#[derive(Debug, serde::Serialize)]
pub(super) struct PartCheckSummary {
    schema: &'static str,
    generator: String,
    program: String,
    /// Null without a part: nothing was measured.
    part: Option<String>,
    machine: Option<String>,
    pub(super) passed: bool,
    /// Tolerance and deviation of the faces; null without a part.
    tolerance: Option<Tolerance>,
    pub(super) deviation: Option<Heights>,
    /// Tool directions given instead of rotary positions, with the solutions assumed; null without any.
    choices: Option<AssumedSolutions>,
    /// Tool changes, and rapid moves not measured after them; null without any.
    tool_changes: Option<ToolChanges>,
    /// Deviations under the errors that were assumed; empty without any.
    what_if: Vec<AssumedDeviation>,
    /// Time of all blocks, and that of rapid moves at rapid speed \[s\]; null without an audit of the axes.
    duration: Option<f64>,
    rapid: Option<f64>,
    moves: Option<usize>,
    /// Motion of the program; null without an audit of the axes.
    motion: Option<ReadMotion>,
    /// Times of the program; null without an audit of the axes.
    times: Option<TimesSummary>,
    /// Time if no block is shorter than its fastest axis needs \[s\].
    held: Option<f64>,
    /// Time on a control that does not look ahead over rotary moves; null without a machine.
    pub(super) control_model: Option<ControlModelSummary>,
    /// Time on `LinuxCNC` with the planner of trunnion; left out if it was not asked for, or is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) planner_time: Option<PlannerTime>,
    /// Blocks shorter than the servo period, the shortest of them and its line; null if there are none.
    brief: Option<BriefBlocks>,
    /// Passages through the singular cone; null if there are none.
    singular: Option<SingularPassages>,
    pub(super) axes: Vec<AxisLoad>,
    /// Loosest smoothing that the program allows during a cut; null for cutter locations.
    smoothing: Option<SmoothingSummary>,
    /// Null without stock.
    pub(super) stock: Option<StockSummary>,
    /// Chord tolerances of the triangles that represent STEP solids; empty without any.
    chords: Vec<ChordSummary>,
    /// Null without fixtures.
    pub(super) fixtures: Option<FixturesSummary>,
    /// Null without bodies of the machine.
    pub(super) bodies: Option<BodiesSummary>,
    pub(super) warnings: Vec<String>,
    pub(super) failures: Vec<String>,
    /// Findings of accepted kinds, which do not count as failures.
    accepted: Vec<String>,
    /// Files beside this one.
    pub(super) files: Vec<String>,
}

/// Motion of the program.
#[derive(Debug, Clone, Copy, serde::Serialize)]
struct ReadMotion {
    read: CountedMotion,
}

/// Motion that was counted: rapid, then with feed; mm.
#[derive(Debug, Clone, Copy, serde::Serialize)]
struct CountedMotion {
    moves: [usize; 2],
    length: [f64; 2],
}

impl From<AuditedMotion> for CountedMotion {
    fn from(of: AuditedMotion) -> Self {
        Self { moves: [of.rapids, of.cuts], length: [of.rapid_length, of.cut_length] }
    }
}

#[derive(Debug, Clone, Copy, serde::Serialize)]
struct Tolerance {
    total: f64,
    gouge: f64,
}

/// Deviation of the faces after the program.
#[derive(Debug, serde::Serialize)]
pub(super) struct Heights {
    pub(super) grid: f64,
    pub(super) points: usize,
    pub(super) uncut: usize,
    pub(super) uncut_area: f64,
    pub(super) area: f64,
    pub(super) unmeasured: usize,
    /// Deepest gouge and largest excess measured \[mm\].
    pub(super) gouge: f64,
    pub(super) excess: f64,
    lowest: Option<Place>,
    highest: Option<Place>,
    /// Upper bounds all over the faces, between the points as well, for the modelled geometry \[mm\].
    pub(super) gouge_bound: Option<f64>,
    pub(super) excess_bound: Option<f64>,
    /// Area without such bounds \[mm²\].
    pub(super) unbounded_area: f64,
    /// Largest change of the deviation by 0.01 mm of tool length, and of corner radius \[mm\].
    length_adds: f64,
    radius_adds: f64,
    /// Largest change by 0.01 mm of the position of a rotary axis \[mm\]; null without a machine.
    pivot_adds: Option<f64>,
    /// Number of points on faces that are not cut, and the deepest gouge there \[mm\].
    pub(super) others: usize,
    pub(super) others_gouge: f64,
}

#[derive(Debug, serde::Serialize)]
struct Place {
    face: usize,
    uv: [f64; 2],
    point: [f64; 3],
    height: f64,
    /// True if the gouge may be deeper than measured.
    or_deeper: bool,
    line: u32,
    /// True if it occurs on a control that runs each axis of a rapid move at its own speed.
    dog_leg: bool,
}

impl Place {
    fn of(extreme: &ExtremeHeight) -> Self {
        let ExtremeHeight { face, uv, point, height, or_deeper, line, dog_leg, .. } = *extreme;
        Self { face, uv: uv.into(), point: point.coords.into(), height, or_deeper, line, dog_leg }
    }
}

/// Load of one axis relative to its limits.
#[derive(Debug, serde::Serialize)]
pub(super) struct AxisLoad {
    pub(super) name: String,
    unit: &'static str,
    range: [f64; 2],
    pub(super) velocity: LimitRatio,
    pub(super) acceleration: LimitRatio,
    /// Jerk if the control keeps the times of the blocks; reported, not judged.
    pub(super) jerk: LimitRatio,
}

#[derive(Debug, serde::Serialize)]
struct BriefBlocks {
    count: usize,
    line: u32,
    shortest: f64,
    period: f64,
}

#[derive(Debug, serde::Serialize)]
struct SingularPassages {
    passages: usize,
    line: u32,
    angle: f64,
    turn: f64,
}

impl BriefBlocks {
    fn of(verify::ShortBlocks { count, line, shortest, period, .. }: verify::ShortBlocks) -> Self {
        Self { count, line, shortest, period }
    }
}

impl SingularPassages {
    fn of(
        verify::SingularPassages { passages, line, angle, turn, .. }: verify::SingularPassages,
    ) -> Self {
        Self { passages, line, angle: angle.to_degrees(), turn: turn.to_degrees() }
    }
}

impl PartCheckSummary {
    pub(super) fn new(
        subject: &Subject,
        found: &InspectionReport,
        what_if: Vec<AssumedDeviation>,
    ) -> Self {
        let report = &found.report;
        let audit = report.audit.as_ref();
        let carving = found.stock.as_ref().map(|stock| &stock.report);
        let (collisions, count) = pipeline::collisions(carving, found.clearance.as_ref());
        let (stock, fixtures) = (found.stock.as_ref(), fixtures(subject, found));
        let is_accepted = |finding: &&Finding| subject.accepted.contains(&finding.kind());
        let (accepted, failed): (Vec<&Finding>, Vec<&Finding>) =
            report.findings.iter().partition(is_accepted);
        let mut failures: Vec<String> = failed.iter().map(ToString::to_string).collect();
        failures.extend(subject.contradictions.iter().cloned());
        // Findings of the faces first, then collisions, then approaches: the order of their weight.
        failures.extend(pipeline::describe_collisions(&collisions, count, fixtures.as_ref()));
        failures.extend(fixtures.iter().flat_map(pipeline::too_near));
        let bodies = bodies(subject, found);
        failures.extend(bodies.iter().flat_map(pipeline::bodies_too_near));
        let choices = AssumedSolutions::of(&report.choices, subject);
        let changes = report.changes.map(ToolChanges::of);
        // Assumptions of the replay are warnings: they hold unless the control decides otherwise.
        let mut warnings = subject.warnings.clone();
        warnings.extend(choices.iter().flat_map(|choices| choices.warnings(&subject.program)));
        warnings.extend(changes.iter().flat_map(|changes| changes.warnings(&subject.program)));
        // Odd, but no harm to the part by themselves.
        let unended = audit.and_then(|audit| audit.unended).map(|of| of.to_string());
        let slow = audit.and_then(|audit| audit.slow).map(|of| of.to_string());
        let creeping = audit.and_then(|audit| creeping(audit, &report.findings));
        let odd = unended.into_iter().chain(slow).chain(creeping);
        warnings.extend(odd.map(|text| format!("{}: {text}", subject.program)));
        Self {
            schema: "trunnion-check/1",
            generator: format!("trunnion {}", env!("CARGO_PKG_VERSION")),
            program: subject.program.clone(),
            part: subject.part.clone(),
            machine: subject.machine.clone(),
            // A collision or an approach fails the program even if every face is within tolerance.
            passed: failed.is_empty()
                && subject.contradictions.is_empty()
                && collisions.is_empty()
                && fixtures.iter().all(|fixtures| fixtures.near.is_empty())
                && bodies.iter().all(|bodies| bodies.near.is_empty()),
            tolerance: subject
                .part
                .as_ref()
                .map(|_| Tolerance { total: subject.options.total, gouge: subject.options.gouge }),
            deviation: subject.part.as_ref().map(|_| heights(subject, found)),
            choices,
            tool_changes: changes,
            what_if,
            duration: audit.map(|audit| audit.duration),
            rapid: audit.map(|audit| audit.rapid),
            moves: audit.map(|audit| audit.moves),
            motion: audit.map(|audit| ReadMotion { read: CountedMotion::from(audit.motion) }),
            times: audit.map(|audit| TimesSummary {
                planned: audit.duration,
                certified_bound: Some(audit.held),
                linuxcnc: Some(audit.linuxcnc.seconds),
                ..TimesSummary::default()
            }),
            held: audit.map(|audit| audit.held),
            control_model: audit.map(|audit| ControlModelSummary::of(&audit.linuxcnc)),
            planner_time: None,
            brief: audit.and_then(|audit| audit.brief).map(BriefBlocks::of),
            singular: audit.and_then(|audit| audit.singular).map(SingularPassages::of),
            axes: audit.iter().flat_map(|audit| &audit.axes).map(|of| axis(subject, of)).collect(),
            warnings,
            stock: stock.map(|stock| pipeline::stock_summary(&stock.report, &stock.remaining)),
            chords: subject.chords.clone(),
            fixtures,
            bodies,
            failures,
            accepted: accepted.iter().map(ToString::to_string).collect(),
            smoothing: found.state.as_ref().map(SmoothingSummary::of),
            // Filled in when the files are written.
            files: Vec::new(),
        }
    }

    /// Sets the time on `LinuxCNC` with the planner of trunnion, or warns of the reason why there is none.
    pub(super) fn set_planner_time(&mut self, time: Result<PlannerTime, String>) {
        match time {
            Ok(time) => {
                if let Some(times) = &mut self.times {
                    times.linuxcnc_trunnion = Some(time.seconds);
                }
                self.planner_time = Some(time);
            }
            Err(warning) => self.warnings.push(warning),
        }
    }

    /// Returns the verdict of a program that passed; it mentions only what was measured and audited.
    pub(super) fn kept(&self) -> &'static str {
        match (&self.deviation, self.axes.is_empty()) {
            (Some(_), true) => "every tolerance is kept",
            (Some(_), false) => "every tolerance and limit is kept",
            (None, true) => "no collision",
            (None, false) => "every limit is kept; no part was measured",
        }
    }

    /// Returns the verdict as a sentence for the page.
    pub(super) fn verdict(&self) -> String {
        let kept = match &self.deviation {
            Some(_) => self.kept(),
            None if self.axes.is_empty() => "nothing is touched",
            None => "every limit is kept",
        };
        let rest = if self.deviation.is_some() { "" } else { "; no part was measured" };
        format!("{kept} by the program as written{rest}")
    }

    /// Returns the time of the program for the page.
    pub(super) fn time(&self) -> Option<Number> {
        let (duration, rapid, moves) = (self.duration?, self.rapid?, self.moves?);
        let note = format!("of which {rapid:.1} s rapid, for {moves} moves");
        Some(plain("time", format!("{duration:.1}"), "s", note))
    }

    /// Returns the table for people.
    pub(super) fn table(&self, places: &[PathBuf]) -> String {
        let verdict = if self.passed { self.kept() } else { "NOT KEPT" };
        let mut lines = vec![format!("{}: {verdict}", self.program)];
        let mut row = |name: &str, value: String| lines.push(format!("  {name:<14}{value}"));
        if let Some(Tolerance { total, gouge }) = self.tolerance {
            row("tolerance", format!("excess {total} mm, gouge {gouge} mm"));
        }
        for (name, value) in self.deviation.iter().flat_map(Heights::rows) {
            row(name, value);
        }
        for assumed in &self.what_if {
            row("what if", assumed.words());
        }
        // A CL file has no axes, so neither time nor loads.
        if let (Some(duration), Some(rapid), Some(moves)) = (self.duration, self.rapid, self.moves)
        {
            row("time", format!("{duration:.1} s, of which {rapid:.1} s rapid, for {moves} moves"));
        }
        if let Some(ReadMotion { read: CountedMotion { moves, length } }) = self.motion {
            let [rapid, feed] =
                [0, 1].map(|k: usize| format!("{} moves, {:.3} mm", moves[k], length[k]));
            row("motion", format!("rapid {rapid}; with feed {feed}"));
        }
        if let Some(held) = self.held {
            row("with limits", format!("{held:.1} s with every axis within its velocity limit"));
        }
        if let Some(model) = &self.control_model {
            row("control model", model.words());
        }
        if let Some(time) = &self.planner_time {
            row("", time.words());
        }
        if let Some(BriefBlocks { count, line, shortest, period }) = &self.brief {
            let short = format!(
                "{count} shorter than the servo period {:.3} ms, the shortest {:.3} ms at line {line}",
                // Shown in ms, the unit of servo periods.
                1e3 * period,
                1e3 * shortest
            );
            row("blocks", short);
        }
        if let Some(SingularPassages { passages, line, angle, turn }) = &self.singular {
            let passages = format!(
                "{passages} passages, nearest {angle:.3} deg at line {line}, turns up to {turn:.2} deg a block"
            );
            row("singular", passages);
        }
        for axis in &self.axes {
            row(&format!("axis {}", axis.name), axis.words());
        }
        if let Some(smoothing) = &self.smoothing {
            row("smoothing", smoothing.words());
        }
        if let Some(stock) = &self.stock {
            let [volumes, hit] = material::words(stock);
            lines.push(format!("  {:<14}{volumes}", "stock"));
            lines.push(format!("  {:<14}{hit}", "collisions"));
        }
        if !self.chords.is_empty() {
            lines.push(format!("  {:<14}{}", "STEP solids", material::chord_words(&self.chords)));
        }
        if let Some(fixtures) = &self.fixtures {
            lines.push(format!("  {:<14}{}", "fixtures", pipeline::nearest_fixture(fixtures)));
        }
        if let Some(bodies) = &self.bodies {
            lines.push(format!("  {:<14}{}", "bodies", pipeline::nearest_bodies(bodies)));
        }
        lines.extend(self.warnings.iter().map(|warning| format!("warning: {warning}")));
        lines.extend(self.accepted.iter().map(|finding| format!("accepted: {finding}")));
        lines.extend(self.failures.iter().map(|failure| format!("broken: {failure}")));
        lines.extend(places.iter().map(|place| format!("wrote {}", place.display())));
        lines.join("\n") + "\n"
    }
}

fn bodies(subject: &Subject, found: &InspectionReport) -> Option<BodiesSummary> {
    Some(subject.bodies.as_ref()?.summary(found.bodies.as_ref()?))
}

fn fixtures(subject: &Subject, found: &InspectionReport) -> Option<FixturesSummary> {
    Some(subject.fixtures.as_ref()?.summary(found.clearance.as_ref()?))
}

impl Heights {
    fn rows(&self) -> Vec<(&'static str, String)> {
        let place = |place: &Option<Place>| {
            place.as_ref().map_or_else(String::new, |place| {
                let ([x, y, z], Place { face, line, .. }) = (place.point, place);
                let dog_leg = if place.dog_leg { ", each axis at its own speed" } else { "" };
                format!(" at X {x:.3} Y {y:.3} Z {z:.3} (face {face}, line {line}{dog_leg})")
            })
        };
        let lowest = self.lowest.as_ref().map_or(0.0, |place| place.height);
        let deeper = self.lowest.as_ref().is_some_and(|place| place.or_deeper);
        // The search for the deepest point met its limit: the truth may be below.
        let or_less = if deeper { " or less" } else { "" };
        let mut rows = vec![
            ("points", format!("{}, {} mm apart, on {:.1} mm2", self.points, self.grid, self.area)),
            ("lowest point", format!("{lowest:.4} mm{or_less}{}", place(&self.lowest))),
            ("highest point", format!("{:.4} mm{}", self.excess, place(&self.highest))),
            ("uncut", format!("{} points, {:.2} mm2", self.uncut, self.uncut_area)),
        ];
        if let (Some(gouge), Some(excess)) = (self.gouge_bound, self.excess_bound) {
            // A bound over part of the face only must not be read as one over all of it.
            let open = match self.unbounded_area {
                area if area > 0.0 => format!("; except on {area:.3} mm2"),
                _ => String::new(),
            };
            let bounds = format!("gouge max <= {gouge:.4}, excess max <= {excess:.4} mm{open}");
            rows.push(("everywhere", bounds));
        }
        let pivot = |adds: f64| format!(", of a rotary axis's position {adds:.4}");
        let sensitivity = format!(
            "tool length adds up to {:.4}, of corner radius {:.4}{} mm",
            self.length_adds,
            self.radius_adds,
            self.pivot_adds.map_or_else(String::new, pivot)
        );
        rows.push(("0.01 mm of", sensitivity));
        // Faces that are not cut can only be gouged: excess means nothing there.
        if self.others > 0 {
            let others = format!("{} points, gouge {:.4} mm", self.others, self.others_gouge);
            rows.push(("other faces", others));
        }
        rows
    }
}

/// Collects the deviation of the cut faces and of the others.
fn heights(subject: &Subject, found: &InspectionReport) -> Heights {
    let deviation = &found.report.deviation;
    let height = |extreme: &Option<ExtremeHeight>| extreme.as_ref().map_or(0.0, |e| e.height);
    Heights {
        grid: subject.options.grid,
        points: deviation.points,
        uncut: deviation.uncut,
        uncut_area: deviation.uncut_area.max(0.0),
        area: deviation.area,
        unmeasured: deviation.unmeasured,
        // A lowest point above the face is no gouge.
        gouge: (-height(&deviation.lowest)).max(0.0),
        excess: height(&deviation.highest).max(0.0),
        // Sensitivities are in mm per mm.
        length_adds: 0.01 * deviation.sensitivity.length,
        radius_adds: 0.01 * deviation.sensitivity.radius,
        pivot_adds: deviation.sensitivity.pivot.map(|pivot| 0.01 * pivot),
        gouge_bound: deviation.bounds.map(|bounds| bounds.gouge),
        excess_bound: deviation.bounds.and_then(|bounds| bounds.excess),
        unbounded_area: deviation.bounds.map_or(0.0, |bounds| bounds.open),
        lowest: deviation.lowest.as_ref().map(Place::of),
        highest: deviation.highest.as_ref().map(Place::of),
        others: found.others.points,
        others_gouge: found.others.deepest,
    }
}

fn axis(subject: &Subject, audit: &AxisAudit) -> AxisLoad {
    let machine = match &subject.motion {
        CheckedMotion::Program(_, kinematics) => Some(kinematics.machine()),
        CheckedMotion::Locations(_) => None,
    };
    let mut axes = machine.iter().flat_map(|machine| &machine.axes);
    // The audit knows axes by name; the unit follows from the machine.
    let rotary = axes.any(|axis| axis.name == audit.name && axis.kind == AxisKind::Rotary);
    AxisLoad {
        name: audit.name.clone(),
        unit: if rotary { "deg" } else { "mm" },
        range: if rotary { audit.range.ends().map(f64::to_degrees) } else { audit.range.ends() },
        velocity: LimitRatio::of(&audit.velocity),
        acceleration: LimitRatio::of(&audit.acceleration),
        jerk: LimitRatio::of(&audit.jerk),
    }
}

impl AxisLoad {
    /// Returns the range of the axis for the page.
    pub(super) fn number(&self) -> Number {
        let [low, high] = self.range;
        plain(
            &format!("{} range", self.name),
            format!("{low:.3} to {high:.3}"),
            self.unit,
            String::new(),
        )
    }

    fn words(&self) -> String {
        let [low, high] = self.range;
        // A limit that no line comes to names none.
        let share = |LimitRatio { ratio, line, .. }: LimitRatio| match line {
            0 => format!("{:.1} %", 100.0 * ratio),
            _ => format!("{:.1} % (line {line})", 100.0 * ratio),
        };
        format!(
            "{low:.3} .. {high:.3} {}, velocity {}, acceleration {}, jerk {} at the blocks' own times, not judged",
            self.unit,
            share(self.velocity),
            share(self.acceleration),
            share(self.jerk),
        )
    }
}
