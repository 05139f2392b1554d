//! Results of a run as the data of a report page.

use crate::figure::{Prominence, judged, none, plain, within};
use crate::path::chart;
use crate::path::profile::Profile;
use crate::{material, places};
use anyhow::Result;
use trunnion::cutter::{Cutter, CutterKind, CutterSide};
use trunnion::files::job::MotionMethod;
use trunnion::files::summary::{AxisSummary, CheckSummary, ProgramSummary, RestSummary, Summary};
use trunnion::machine::{Axis, AxisKind, FIRST_ROTARY};
use trunnion::pipeline::{self, CheckedProgram, Job, Outcome, PlannedOperation};
use trunnion::setpoint;
use trunnion::types::{Motion, PieceGeometry, PoseRates, ToolPiece};
use trunnion::verify::{self, ExtremeHeight, FaceMap};
use trunnion_report::{
    Axis as ReportAxis, Budget, Check, Histogram, MotionKind, Number, PathPiece, PathPoint,
    Recorder, ReportData, Sample, Share, State, Surface, SurfacePoint,
};

/// Slots of the charts over time: about three a pixel of a wide screen.
pub(crate) const SLOTS: usize = 6000;

/// Bins of the histogram of deviations.
const BINS: usize = 60;

/// Longest stretch between two drawn tool positions \[mm\].
const DRAWN_STEP: f64 = 1.0;

/// Steps in which the corner of the drawn tool is divided.
const ARC_STEPS: u32 = 12;

/// Renders the report page of a run.
pub(crate) fn page(job: &Job, outcome: &Outcome, summary: &Summary) -> Result<String> {
    // The checks of all programs measure the same part; the page shows the worst.
    let checked = outcome.programs.iter().filter(|program| program.check.is_some());
    let shown = checked.max_by(|a, b| worst(a).total_cmp(&worst(b)));
    let data = ReportData {
        job: summary.job.clone(),
        part: job.file.part.file.clone(),
        machine: summary.motion.machine.clone(),
        tool: tool(job),
        generator: summary.generator.clone(),
        passed: summary.passed,
        verdict: verdict(summary),
        warnings: summary.warnings.clone(),
        numbers: numbers(summary),
        budget: budget(job, outcome),
        tools: job.operations().map(|one| outline(&one.cutter)).collect(),
        surface: shown.map(surface).unwrap_or_default(),
        path: path(outcome),
        motion: motion(job, outcome)?,
        check: shown.map(|program| check(job, program, summary)).unwrap_or_default(),
        stock: material::left(outcome).map(|left| material::drawn(left, job.budget.total)),
        fixtures: outcome.fixtures.as_ref().map(material::held),
        smoothing: smoothing(job, outcome),
    };
    Ok(trunnion_report::render(&data)?)
}

fn worst(program: &CheckedProgram) -> f64 {
    let height = |extreme: &Option<ExtremeHeight>| extreme.as_ref().map_or(0.0, |e| e.height.abs());
    let of = |check: &verify::Report| {
        height(&check.deviation.lowest).max(height(&check.deviation.highest))
    };
    program.check.as_ref().map_or(0.0, of)
}

fn tool(job: &Job) -> String {
    let mut tools: Vec<String> = Vec::new();
    for one in job.operations() {
        let text = format!("T{} {}", one.file.tool.number, describe(&one.cutter));
        if !tools.contains(&text) {
            tools.push(text);
        }
    }
    tools.join("; ")
}

/// Describes a cutter by its kind, radii and length.
pub(crate) fn describe(cutter: &Cutter) -> String {
    let (diameter, tip, length) = (2.0 * cutter.radius(), cutter.minor(), cutter.length());
    let side = match cutter.spec().side {
        CutterSide::Straight => {
            return format!("{:?} D{diameter} r{tip}, length {length} mm", cutter.kind());
        }
        CutterSide::Cone { .. } => String::new(),
        CutterSide::Arc { radius, .. } if cutter.kind() == CutterKind::Lens => {
            format!(", corner r{radius}")
        }
        CutterSide::Arc { radius, .. } => format!(", barrel r{radius}"),
    };
    let angle = cutter.spec().side.taper_angle().to_degrees();
    let angle = if angle > 0.0 { format!(", side {angle:.4}°") } else { String::new() };
    format!("{} D{diameter}, tip r{tip}{side}{angle}, length {length} mm", cutter.kind().name())
}

fn verdict(summary: &Summary) -> Vec<String> {
    if summary.passed {
        vec!["every tolerance and limit is kept by the programs as written".to_owned()]
    } else {
        summary.failures.clone()
    }
}

/// Collects the numbers: checks first, then the plan, unfinished parts, and axes.
fn numbers(summary: &Summary) -> Vec<Number> {
    let checks = summary.programs.iter().enumerate().flat_map(|(index, program)| {
        let check = program.check.iter();
        check.flat_map(move |check| {
            // The first program alone stands at the top: the others repeat the same measurement.
            let prominence = if index == 0 { Prominence::Headline } else { Prominence::Body };
            checked(summary, program, check, prominence)
        })
    });
    checks
        .chain(planned_numbers(summary))
        .chain(summary.cover.rest.iter().map(left))
        .chain(summary.motion.axes.iter().map(axis_number))
        .collect()
}

/// Returns the numbers that the check of one program found.
fn checked(
    summary: &Summary,
    program: &ProgramSummary,
    check: &CheckSummary,
    prominence: Prominence,
) -> Vec<Number> {
    let tolerance = &summary.tolerance;
    let name = |what: &str| format!("{what}, {}", program.dialect);
    let micro = |value: f64| format!("{value:.4}");
    let at = |bound: Option<f64>| {
        let everywhere =
            bound.map_or_else(String::new, |b| format!("; everywhere <= {}", micro(b)));
        format!("{} points, {} mm apart{everywhere}", check.points, check.grid)
    };
    let excess = plain(&name("excess"), micro(check.excess), "mm", at(check.excess_bound));
    let gouge = plain(&name("gouge"), micro(check.gouge), "mm", at(check.gouge_bound));
    let of = format!("of {}", check.points);
    let uncut = plain(&name("uncut points"), check.uncut.to_string(), "", of);
    let mut numbers = vec![
        judged(within(check.excess, tolerance.total), excess, prominence),
        judged(within(check.gouge, tolerance.gouge), gouge, prominence),
        judged(none(check.uncut), uncut, Prominence::Body),
    ];
    // The acceleration is unknown if the control plans its own speeds.
    let ratios = [Some(check.velocity_ratio), check.acceleration_ratio];
    for (what, ratio) in ["velocity", "acceleration"].iter().zip(ratios) {
        let Some(ratio) = ratio else { continue };
        let label = name(&format!("largest {what} over its limit"));
        let note = "block by block, less the rounding of the text".to_owned();
        let number = plain(&label, micro(ratio), "", note);
        numbers.push(judged(within(ratio, 1.0), number, Prominence::Body));
    }
    numbers.push(plain(&name("blocks"), program.blocks.to_string(), "", String::new()));
    numbers.extend(program.stock.iter().flat_map(|stock| material::numbers(stock, name)));
    let fixtures = program.fixtures.iter();
    let label = name("least fixture distance");
    numbers.extend(fixtures.map(|fixtures| material::clearance_number(fixtures, &label)));
    numbers
}

fn planned_numbers(summary: &Summary) -> Vec<Number> {
    let (cover, motion) = (&summary.cover, &summary.motion);
    let large = |number: Number| Number { headline: true, ..number };
    let bound = format!("no schedule within the limits beats {:.1} s", motion.lower_bound);
    let passes = format!("{} cutter locations", cover.stations);
    let [least, mean, most] = cover.strip_width;
    let held = cover.turn_limit.map_or_else(String::new, |limit| {
        let [length, time] = [limit.length, limit.time].map(|share| 100.0 * share);
        format!("; the limit of the axis's turn costs {length:+.1} % of length, {time:+.1} % of time (estimated)")
    });
    let range = format!("{least:.2} to {most:.2} mm{held}");
    let length = format!("{:.0}", cover.cutting_length);
    vec![
        large(plain("planned time", format!("{:.1}", motion.duration), "s", bound)),
        plain("of it cutting", format!("{:.1}", motion.cutting), "s", String::new()),
        large(plain("passes", cover.passes.to_string(), "", passes)),
        large(plain("cutting length", length, "mm", "along the contact".to_owned())),
        plain("mean strip width", format!("{mean:.2}"), "mm", range),
    ]
}

/// Returns the number of a part that the tool does not finish.
fn left(rest: &RestSummary) -> Number {
    let [x, y, z] = rest.deepest;
    let ball =
        rest.ball.map_or_else(String::new, |radius| format!("; largest ball r {radius:.3} mm"));
    let note =
        format!("up to {:.3} mm at X {x:.3} Y {y:.3} Z {z:.3}: {}{ball}", rest.depth, rest.why);
    let label = format!("rest on face {}", rest.face);
    Number { state: State::Bad, ..plain(&label, format!("{:.3}", rest.area), "mm2", note) }
}

fn axis_number(axis: &AxisSummary) -> Number {
    let [low, high] = axis.range;
    let note = format!(
        "peak velocity {:.0} %, acceleration {:.0} % of the limit",
        100.0 * axis.velocity_ratio,
        100.0 * axis.acceleration_ratio
    );
    plain(&format!("{} range", axis.name), format!("{low:.2} to {high:.2}"), &axis.unit, note)
}

fn budget(job: &Job, outcome: &Outcome) -> Budget {
    let budget = &job.budget;
    // The largest rounding of all programs is what the share has to cover.
    let rounding = outcome.programs.iter().map(|program| program.rounding).reduce(f64::max);
    // A rotation of the tool axis moves the contact by up to the lever times its angle.
    let stray = |(one, of): (&PlannedOperation, &Job)| {
        let most = one.smoothing.0.deviated;
        most.tip_bound.max(most.contact_bound)
            + trunnion::cover::lever(&of.cutter) * most.axis_bound
    };
    let strays = planned(job, outcome).map(stray).fold(0.0, f64::max);
    let smoothing = (budget.shares.smoothing > 0.0).then_some(strays);
    // `used` is known only for shares that are measured or proven afterwards.
    let share = |name: &str, allowed: f64, used: Option<f64>| Share {
        name: name.to_owned(),
        allowed,
        used,
    };
    Budget {
        total: budget.total,
        gouge: budget.gouge,
        shares: vec![
            share("strips", budget.upper - budget.lower, None),
            share("curves between stations", budget.shares.path, None),
            share("blocks", budget.shares.linearisation, None),
            share("rounding of the words", budget.shares.rounding, rounding),
            share("the control's smoothing", budget.shares.control, None),
            share("tool axis at singular directions", budget.shares.singular, None),
            share("smoothing", budget.shares.smoothing, smoothing),
        ],
    }
}

/// Draws the deviation of the smoothed path.
fn smoothing(job: &Job, outcome: &Outcome) -> String {
    let share = job.budget.shares.smoothing;
    let mut profile = Profile::default();
    let mut before = 0.0;
    for one in &outcome.operations {
        let along = &one.smoothing.1;
        for (end, deviated) in along {
            profile.push(before + *end, deviated);
        }
        before += along.last().map_or(0.0, |(end, _)| *end);
    }
    if before <= 0.0 {
        return String::new();
    }
    chart::draw(
        &profile,
        trunnion::post::smoothing_tolerance(share, trunnion::cover::lever(&job.cutter)),
    )
}

/// Returns the cutter's outline as a chain of points.
pub(crate) fn outline(cutter: &Cutter) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    for piece in cutter.profile() {
        points.extend(piece.points(ARC_STEPS));
    }
    // Neighbouring pieces share their ends.
    points.dedup();
    points
}

fn surface(program: &CheckedProgram) -> Surface {
    let mut surface = Surface::default();
    for map in program.check.iter().flat_map(|check| &check.maps) {
        let points: Vec<_> = map
            .samples
            .iter()
            .map(|sample| {
                // Rest material is drawn as not cut, however near the tool comes.
                let height = |s: &trunnion::verify::HeightSample| s.height.filter(|_| !s.rest);
                sample
                    .as_ref()
                    .map(|s| SurfacePoint { position: s.point.coords.into(), deviation: height(s) })
            })
            .collect();
        surface.add_grid(columns(map), &points);
    }
    surface
}

fn columns(map: &FaceMap) -> usize {
    map.v.len()
}

/// Returns the operations that were planned, each with its job.
fn planned<'a>(
    job: &'a Job,
    outcome: &'a Outcome,
) -> impl Iterator<Item = (&'a PlannedOperation, &'a Job)> {
    outcome.operations.iter().filter_map(|one| Some((one, job.operations().nth(one.index)?)))
}

/// Returns the times at which the operations begin, as if changes of tool took none \[s\].
fn starts(outcome: &Outcome) -> impl Iterator<Item = f64> + '_ {
    outcome.operations.iter().scan(0.0, |time, one| {
        let start = *time;
        *time += one.plan.schedule.duration();
        Some(start)
    })
}

fn path(outcome: &Outcome) -> Vec<PathPiece> {
    let all = outcome.operations.iter().zip(starts(outcome));
    all.flat_map(|(operation, start)| operation_path(operation, start)).collect()
}

/// Returns the path of an operation that begins at `start` \[s\].
fn operation_path(operation: &PlannedOperation, start: f64) -> Vec<PathPiece> {
    let rows = operation.plan.schedule.pieces.iter().zip(&operation.followed.path.pieces);
    rows.filter_map(|(schedule, axes)| {
        // A piece of the axis path names the piece of the tool path that it follows.
        let piece = operation.tool_path.pieces.get(axes.source)?;
        let (first, last) = (*schedule.s.first()?, *schedule.s.last()?);
        // At least both ends, even of a rotation at a point.
        let steps = ((last - first) / DRAWN_STEP).ceil().max(1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let points = (0..=steps as u32)
            .filter_map(|step| {
                let s = first + (last - first) * f64::from(step) / steps;
                let t = start + schedule.time_at(s);
                point(piece, (s - first) / (last - first), s, t)
            })
            .collect();
        Some(PathPiece { motion: kind(axes.motion), tool: operation.index, points })
    })
    .collect()
}

/// Returns the tool at parameter `s`, at `fraction` of the length of a piece.
fn point(piece: &ToolPiece, fraction: f64, s: f64, t: f64) -> Option<PathPoint> {
    match &piece.geometry {
        PieceGeometry::Curve(curve) => {
            let rates: PoseRates = curve.rates(s);
            let pose = rates.pose()?;
            let contact = rates.contact[0].into();
            Some(PathPoint {
                t,
                tip: pose.tip.coords.into(),
                axis: pose.axis.into_inner().into(),
                contact,
            })
        }
        PieceGeometry::Reorient { from, to } => {
            let tip: [f64; 3] = (from.tip + (to.tip - from.tip) * fraction).coords.into();
            // A chord of the great circle, brought back to unit length: exact enough for a picture.
            let axis = from.axis.lerp(&to.axis, fraction).normalize().into();
            Some(PathPoint { t, tip, axis, contact: tip })
        }
    }
}

fn kind(motion: Motion) -> MotionKind {
    match motion {
        Motion::Link | Motion::Hop => MotionKind::Link,
        Motion::LeadIn => MotionKind::LeadIn,
        Motion::Cut | Motion::Step => MotionKind::Cut,
        Motion::LeadOut => MotionKind::LeadOut,
    }
}

fn motion(job: &Job, outcome: &Outcome) -> Result<trunnion_report::Motion> {
    let axes = &job.kinematics.machine().axes;
    let feed = job.file.cutting.feed;
    let jerk = job.file.motion.method == MotionMethod::Jerk;
    let (limits, chords) = pipeline::motion_limits(job)?;
    let report_axes = axes
        .iter()
        .enumerate()
        .map(|(index, of)| {
            let acceleration = limits.acceleration[index];
            axis(of, &AxisLimits { acceleration, chord: chords[index], jerk })
        })
        .collect();
    let duration = outcome.operations.iter().map(|one| one.plan.schedule.duration()).sum();
    let mut recorder = Recorder::new(report_axes, duration, SLOTS, feed);
    let units = |values: &trunnion::types::AxisVector| {
        let mut out: Vec<f64> = values.iter().copied().collect();
        for value in out.iter_mut().skip(FIRST_ROTARY) {
            *value = value.to_degrees();
        }
        out
    };
    for (one, start) in outcome.operations.iter().zip(starts(outcome)) {
        let (path, schedule) = (&one.followed.path, &one.plan.schedule);
        for setpoint in setpoint::sample(path, schedule, job.file.motion.servo_period)? {
            let ([speed, tip], cutting) = speeds(one, setpoint.t);
            recorder.add(&Sample {
                t: start + setpoint.t,
                position: &units(&setpoint.position),
                velocity: &units(&setpoint.velocity),
                acceleration: &units(&setpoint.acceleration),
                jerk: &units(&setpoint.jerk),
                speed,
                tip,
                cutting,
            });
        }
    }
    Ok(recorder.finish())
}

/// Limits that a plan keeps on one axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AxisLimits {
    /// Acceleration limit \[mm/s² or rad/s²\].
    pub(crate) acceleration: f64,
    /// True if the chord error lowers it below that of the axis.
    pub(crate) chord: bool,
    /// True if the plan keeps the jerk limit as well.
    pub(crate) jerk: bool,
}

/// Returns an axis with its limits for the charts, in mm and degrees.
pub(crate) fn axis(axis: &Axis, limits: &AxisLimits) -> ReportAxis {
    let AxisLimits { acceleration, chord, jerk } = *limits;
    let rotary = axis.kind == AxisKind::Rotary;
    let unit = |value: f64| if rotary { value.to_degrees() } else { value };
    ReportAxis {
        name: axis.name.clone(),
        unit: if rotary { "deg" } else { "mm" }.to_owned(),
        travel: (!axis.cyclic).then(|| axis.limits.ends().map(unit)),
        // The chart covers cuts and rapid moves: the larger limit is drawn.
        velocity: unit(axis.vel.max(axis.rapid)),
        acceleration: unit(acceleration),
        chord,
        jerk: if jerk { unit(axis.jerk) } else { 0.0 },
    }
}

/// Returns the speeds of the programmed point and of the tip at time `t` \[mm/s\], and true if the feed applies there.
fn speeds(operation: &PlannedOperation, t: f64) -> ([f64; 2], bool) {
    let nothing = ([0.0; 2], false);
    let pieces = &operation.plan.schedule.pieces;
    let index = pieces.partition_point(|piece| piece.t.last().is_some_and(|&end| end < t));
    let (Some(rows), Some(axes)) = (pieces.get(index), operation.followed.path.pieces.get(index))
    else {
        return nothing;
    };
    let Some(moment) = rows.at_time(t) else { return nothing };
    let after =
        axes.nodes.partition_point(|node| node.s <= moment.s).clamp(1, axes.nodes.len() - 1);
    let (Some(a), Some(b)) = (axes.nodes.get(after - 1), axes.nodes.get(after)) else {
        return nothing;
    };
    // Rates are linear between the nodes, as the axis path has them at nodes only.
    let weight = (moment.s - a.s) / (b.s - a.s);
    let [feed, tip] = [[a.feed_rate, b.feed_rate], [a.tip_rate, b.tip_rate]]
        .map(|[a, b]| moment.speed * (a + weight * (b - a)));
    ([feed, tip], !axes.motion.is_free())
}

fn check(job: &Job, program: &CheckedProgram, summary: &Summary) -> Check {
    let Some(report) = &program.check else { return Check::default() };
    let deviation = &report.deviation;
    let heights = || {
        let samples = report.maps.iter().flat_map(|map| map.samples.iter().flatten());
        samples.filter_map(|sample| sample.height)
    };
    let reach = 2.0 * job.budget.total;
    let summarised = summary.programs.iter().find(|of| of.file == program.file);
    let fixtures = summarised.and_then(|of| of.fixtures.as_ref());
    Check {
        method: format!(
            "{} read back, run as the control would run it, and measured along the surface normals",
            program.file
        ),
        grid: job.file.verify_grid,
        points: deviation.points as u64,
        uncut: deviation.uncut as u64,
        histogram: Histogram::of(heights(), [-reach, reach], BINS),
        places: places::worst(report, fixtures, [job.budget.total, job.budget.gouge]),
    }
}
