//! The report of a check.

use super::control_model::ControlModelSummary;
use super::limit_ratio::LimitRatio;
use super::planner_time::PlannerTime;
use super::subject::Subject;
use super::summary::{Heights, PartCheckSummary};
use crate::figure::{Prominence, judged, none, plain, within};
use crate::outcome::Failure;
use crate::{material, places, report};
use trunnion::cutter::Cutter;
use trunnion::verify::{HeightSample, InspectionReport, TimedPose, Track};
use trunnion_report::{
    Budget, Check, Histogram, MotionKind, Number, PathPiece, PathPoint, ReportData, Surface,
    SurfacePoint,
};

/// Bins of the histogram of deviations.
const BINS: usize = 60;

/// Renders the report page of a check.
pub(super) fn page(
    subject: &Subject,
    found: &InspectionReport,
    summary: &PartCheckSummary,
) -> Result<String, Failure> {
    let data = ReportData {
        job: subject.program.clone(),
        part: subject.part.clone().unwrap_or_default(),
        machine: subject.machine.clone().unwrap_or_default(),
        tool: tools(subject),
        generator: format!("trunnion {}", env!("CARGO_PKG_VERSION")),
        passed: summary.passed,
        verdict: if summary.passed {
            // One sentence for success; failures list their reasons.
            vec![summary.verdict()]
        } else {
            summary.failures.clone()
        },
        warnings: summary.warnings.clone(),
        numbers: numbers(subject, summary),
        budget: Budget {
            total: subject.options.total,
            gouge: subject.options.gouge,
            // A program from elsewhere has no budget of its own.
            shares: Vec::new(),
        },
        tools: outlines(subject),
        surface: surface(found),
        path: subject.track()?.iter().map(piece).collect(),
        motion: trunnion_report::Motion::default(),
        check: check(subject, found, summary),
        stock: found
            .stock
            .as_ref()
            .map(|stock| material::drawn(&stock.remaining, subject.options.total)),
        fixtures: subject.fixtures.as_ref().map(material::held),
        smoothing: String::new(),
    };
    Ok(trunnion_report::render(&data).map_err(anyhow::Error::from)?)
}

/// Returns the outlines of the tools, in the order of their table.
pub(super) fn outlines(subject: &Subject) -> Vec<Vec<[f64; 2]>> {
    if subject.tools.is_empty() {
        return vec![report::outline(&subject.cutter)];
    }
    subject.tools.iter().map(|(_, cutter)| report::outline(cutter)).collect()
}

/// Describes the tool, or all tools by number.
fn tools(subject: &Subject) -> String {
    let words = |cutter: &Cutter| {
        if subject.meets_nothing() {
            // No cutter was described: only its length counts.
            return format!("length {} mm", cutter.length());
        }
        report::describe(cutter)
    };
    if subject.tools.is_empty() {
        return words(&subject.cutter);
    }
    let tool = |(number, cutter): &(u32, Cutter)| format!("T{number} {}", words(cutter));
    subject.tools.iter().map(tool).collect::<Vec<_>>().join("; ")
}

/// Returns the deviation of the faces with its verdicts.
fn deviation_numbers(subject: &Subject, left: &Heights) -> [Number; 3] {
    let options = &subject.options;
    let at = |bound: Option<f64>| {
        let everywhere = bound.map_or_else(String::new, |b| format!("; everywhere <= {b:.4}"));
        format!("{} points, {} mm apart{everywhere}", left.points, left.grid)
    };
    let excess = format!("{:.4}", left.excess);
    let excess = plain("largest excess", excess, "mm", at(left.excess_bound));
    let gouge = plain("gouge", format!("{:.4}", left.gouge), "mm", at(left.gouge_bound));
    let of = format!("of {}, {:.2} mm2", left.points, left.uncut_area);
    let uncut = plain("uncut points", left.uncut.to_string(), "", of);
    [
        judged(within(left.excess, options.total), excess, Prominence::Headline),
        judged(within(left.gouge, options.gouge), gouge, Prominence::Headline),
        judged(none(left.uncut), uncut, Prominence::Headline),
    ]
}

fn numbers(subject: &Subject, summary: &PartCheckSummary) -> Vec<Number> {
    let left = summary.deviation.iter();
    let mut numbers: Vec<Number> = left.flat_map(|left| deviation_numbers(subject, left)).collect();
    numbers.extend(summary.time());
    if let Some(stock) = &summary.stock {
        numbers.extend(material::numbers(stock, str::to_owned));
    }
    let fixtures = summary.fixtures.iter();
    numbers.extend(fixtures.map(|of| material::clearance_number(of, "least fixture distance")));
    let percent = |label: String, of: LimitRatio| {
        let note = format!("of its limit, at line {}", of.line);
        let number = plain(&label, format!("{:.1}", 100.0 * of.ratio), "%", note);
        judged(within(of.ratio, 1.0), number, Prominence::Body)
    };
    for axis in &summary.axes {
        numbers.push(axis.number());
        numbers.push(percent(format!("{} velocity", axis.name), axis.velocity));
        numbers.push(percent(format!("{} acceleration", axis.name), axis.acceleration));
    }
    numbers.extend(summary.control_model.iter().flat_map(ControlModelSummary::numbers));
    numbers.extend(summary.planner_time.iter().map(PlannerTime::number));
    numbers
}

fn surface(found: &InspectionReport) -> Surface {
    let mut surface = Surface::default();
    for map in &found.report.maps {
        let drawn = |s: &HeightSample| SurfacePoint {
            position: s.point.coords.into(),
            // Rest material is drawn as not cut, however near the tool comes.
            deviation: s.height.filter(|_| !s.rest),
        };
        let points: Vec<_> = map.samples.iter().map(|s| s.as_ref().map(drawn)).collect();
        surface.add_grid(map.v.len(), &points);
    }
    surface
}

fn piece(track: &Track) -> PathPiece {
    let point = |&TimedPose { time, pose }: &TimedPose| {
        let tip: [f64; 3] = pose.tip.coords.into();
        PathPoint { t: time, tip, axis: pose.axis.into_inner().into(), contact: tip }
    };
    PathPiece {
        // A program does not distinguish leads from cuts: every feed move counts as a cut.
        motion: if track.rapid { MotionKind::Link } else { MotionKind::Cut },
        tool: track.tool,
        points: track.poses.iter().map(point).collect(),
    }
}

fn check(subject: &Subject, found: &InspectionReport, summary: &PartCheckSummary) -> Check {
    let report = &found.report;
    let samples = || report.maps.iter().flat_map(|map| map.samples.iter().flatten());
    // The histogram shows twice the tolerance on either side; the ends collect the rest.
    let reach = 2.0 * subject.options.total;
    Check {
        method: match subject.part {
            Some(_) => format!(
                "{} run as the control would run it, and measured along the surface normals",
                subject.program
            ),
            None => format!("{} replayed as the control would", subject.program),
        },
        grid: subject.options.grid,
        points: report.deviation.points as u64,
        uncut: report.deviation.uncut as u64,
        histogram: Histogram::of(samples().filter_map(|s| s.height), [-reach, reach], BINS),
        places: places::worst(
            report,
            summary.fixtures.as_ref(),
            [subject.options.total, subject.options.gouge],
        ),
    }
}
