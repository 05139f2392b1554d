//! The numbers of a run, for people and scripts.

use super::body_advice;
use super::collisions;
use super::error::PipelineError;
use super::fixture_advice;
use super::guards;
use super::job::Job;
use super::joined;
use super::leftover::Leftover;
use super::operations::OperationMotion;
use super::planned_motion::PlannedMotion;
use super::program::{CheckedProgram, LeftOutProgram, OperationProgram};
use super::regions;
use super::retracts;
use super::solids::Solids;
use super::wording::counted;
use crate::cover::{Covering, FaceLayout, GivenUp, LayoutCost, PassLayout};
use crate::feed::FeedPlan;
use crate::files::job::MotionMethod;
use crate::files::summary::{
    AxisSummary, CheckSummary, CoverSummary, LAYOUT, LayoutSummary, LayoutTime, MotionSummary,
    OperationProgramSummary, OperationSummary, ProgramSummary, SingularSummary, Summary,
    TimesSummary,
};
use crate::machine::{Axis, AxisKind};
use crate::nc::write::WriteError;
use crate::setpoint;
use crate::types::{AxisVector, Uv};

/// Name and version of this library, as files name their maker.
const GENERATOR: &str = concat!("trunnion ", env!("CARGO_PKG_VERSION"));

/// Results of all stages, to be summarised.
#[derive(Clone, Copy)]
pub(super) struct StageResults<'a> {
    /// Operations that cut something; at least one.
    pub(super) operations: &'a [OperationMotion<'a>],
    /// Regions that they leave.
    pub(super) left: &'a Leftover,
    /// Warnings about faces that the cutters fit in part, and operations that cut nothing.
    pub(super) warnings: &'a [String],
    pub(super) programs: &'a [CheckedProgram],
    pub(super) left_out: &'a [LeftOutProgram],
    pub(super) solids: &'a Solids,
}

/// Returns the summary of a run.
pub(super) fn summary(job: &Job, results: &StageResults<'_>) -> Result<Summary, PipelineError> {
    let &StageResults { operations, left, warnings: found, programs, left_out, solids } = results;
    let failures: Vec<String> = programs
        .iter()
        .flat_map(|program| {
            let name = program.file;
            let findings = program.check.iter().flat_map(|check| &check.findings);
            findings.map(move |finding| format!("{name}: {finding}"))
        })
        .chain(left_out.iter().map(|left| format!("{} was not written: {}", left.file, left.why)))
        .chain(programs.iter().flat_map(|program| collisions::failures(program, solids)))
        .chain(operations.iter().filter_map(|one| broken(job, one.motion().plan)))
        .chain(regions::unfinished(job, left))
        .collect();
    let parts = operations.iter().map(operation).collect::<Result<Vec<_>, _>>()?;
    let checked: Vec<_> = programs.iter().map(|one| program(job, one, solids)).collect();
    let motion = joined::motion(&parts).ok_or(WriteError::Empty)?;
    let cover = CoverSummary {
        area: left.area(),
        rest: left.regions.iter().map(|rest| regions::rest(job, rest)).collect(),
        ..joined::cover(&parts)
    };
    Ok(Summary {
        schema: LAYOUT.to_owned(),
        generator: GENERATOR.to_owned(),
        job: job.file.name.clone(),
        passed: failures.is_empty(),
        failures,
        warnings: found
            .iter()
            .cloned()
            .chain(operations.iter().flat_map(operation_warnings))
            .chain(regions::unguarded(job))
            .chain(guards::unplanned(job))
            .chain(operations.iter().flat_map(motion_warnings))
            .chain(fixture_advice::remedy(job, programs))
            .chain(body_advice::remedy(job, programs, solids))
            .collect(),
        tolerance: job.budget.summary(),
        cover,
        times: TimesSummary {
            planned: motion.duration,
            certified_bound: Some(motion.lower_bound),
            linuxcnc: checked.iter().find_map(|program| program.linuxcnc_duration),
            ..TimesSummary::default()
        },
        motion,
        chords: job.file.chords(),
        programs: checked,
        operations: if job.following.is_empty() { Vec::new() } else { parts },
        files: Vec::new(),
    })
}

/// Returns the summary of one operation.
fn operation(one: &OperationMotion<'_>) -> Result<OperationSummary, PipelineError> {
    Ok(OperationSummary {
        name: one.job.name.clone(),
        tool: one.job.file.tool.number,
        cover: CoverSummary { turn_limit: one.turn_limit, ..cover(one.job, &one.covering) },
        motion: motion(one.job, &one.motion())?,
    })
}

/// Puts the name of an operation in front of a warning, if the job has several.
fn named(job: &Job, warning: String) -> String {
    if job.name.is_empty() { warning } else { format!("{}: {warning}", job.name) }
}

/// Returns the warnings about the passes of an operation.
fn operation_warnings(one: &OperationMotion<'_>) -> Vec<String> {
    warnings(one.job, &one.covering).into_iter().map(|text| named(one.job, text)).collect()
}

/// Returns the warnings about the motion of an operation.
fn motion_warnings(one: &OperationMotion<'_>) -> Vec<String> {
    let motion = one.motion();
    let singular = idle_share(one.job.budget.shares.singular, motion.singular.as_ref());
    let all = retracts::warning(motion.retracts).into_iter().chain(singular);
    all.map(|text| named(one.job, text)).collect()
}

/// Warns if the tolerance share for singular directions saves less than the hundredth of a second that is shown.
///
/// That share narrows all strips.
fn idle_share(share: f64, singular: Option<&SingularSummary>) -> Option<String> {
    let what = match singular {
        None => "no cut passes a singular direction where moving the tool axis would help",
        Some(moved) if moved.seconds_saved < 0.005 => {
            "moving the tool axis at singular directions saves no time here"
        }
        Some(_) => return None,
    };
    (share > 0.0).then(|| {
        format!(
            "{what}, but tolerance.split.singular = {share} mm is taken from both sides of the strips' \
             band, which makes them narrower: leave it out"
        )
    })
}

/// Returns the warnings about the passes, although no tolerance is broken.
fn warnings(job: &Job, covering: &Covering) -> Vec<String> {
    let report = &covering.report;
    let mut warnings = Vec::new();
    warnings.extend(regions::fixed(&job.faces, covering));
    if let Some(GivenUp { face, uv: Uv { u, v }, share }) = report.given_up {
        warnings.push(if share > 0.0 {
            format!(
                "wide strips were given up on face {face} from u {u:.4}, v {v:.4} on, after {:.0} % of it: they had \
                 taken the work that is allowed them; the rest is finished at a fixed lead; passes along the \
                 other parameter or a smaller cutter may do better",
                100.0 * share
            )
        } else {
            format!(
                "wide strips were given up on face {face}: they were no wider than those of a ball, or had taken the work \
                 that is allowed them over a small part of it; all of it is finished at a fixed lead"
            )
        });
    }
    if report.shortened > 0 {
        let passes = match report.shortened {
            1 => "1 pass".to_owned(),
            count => format!("{count} passes"),
        };
        warnings.push(format!("{passes} could not be run out in full beyond the face"));
    }
    if report.worst_gouge > 0.0 {
        warnings.push(format!(
            "{} spans leave the strips' band even at the least station spacing, towards the \
             surface by at most {:.5} mm",
            report.coarse_spans, report.worst_gouge
        ));
    }
    if report.fast_turns > 0 {
        warnings.push(format!(
            "the tool axis turns faster than strategy.max_axis_turn at {}, by up to {:.2} deg/mm",
            counted(report.fast_turns, "place"),
            report.axis_turn.to_degrees()
        ));
    }
    warnings
}

fn cover(job: &Job, covering: &Covering) -> CoverSummary {
    let widths = || covering.passes.iter().flat_map(|pass| pass.widths.iter().copied());
    let count = widths().count().max(1) as f64;
    let strip_width = [
        widths().fold(f64::INFINITY, f64::min),
        widths().sum::<f64>() / count,
        widths().fold(0.0, f64::max),
    ];
    CoverSummary {
        turn_limit: None,
        faces: job.faces.iter().map(|face| face.face().number).collect(),
        passes: covering.passes.len(),
        stations: covering.report.stations,
        cutting_length: covering.report.length,
        strip_width,
        area: covering.report.area,
        along: job.faces.iter().map(|face| along(face.face().number, covering)).collect(),
        layouts: layouts(job, covering),
        fixed: regions::summaries(&job.faces, covering),
        rest: covering.report.rest.iter().map(|rest| regions::rest(job, rest)).collect(),
    }
}

/// Returns the direction of the passes on a face.
fn along(face: usize, covering: &Covering) -> String {
    let of_face = covering.report.layouts.iter().find(|one| one.face == face);
    of_face.map_or("none", |one| layout_name(one.layout)).to_owned()
}

fn layout_name(layout: PassLayout) -> &'static str {
    match layout {
        PassLayout::U => "u",
        PassLayout::V => "v",
        PassLayout::Bent => "bent",
        PassLayout::Flank => "flank",
        PassLayout::Floor => "floor",
        PassLayout::FixedAxis => "fixed-axis",
    }
}

/// Returns the layouts of the faces on which several were planned.
fn layouts(job: &Job, covering: &Covering) -> Vec<LayoutSummary> {
    let time = |one: &LayoutCost| LayoutTime {
        along: layout_name(one.layout).to_owned(),
        seconds: one.cost / job.file.cutting.feed,
        rest: one.rest,
    };
    let compared = covering.report.layouts.iter().filter(|face| !face.others.is_empty());
    let summary = |face: &FaceLayout| LayoutSummary {
        face: face.face,
        chosen: time(&face.planned),
        others: face.others.iter().map(time).collect(),
    };
    compared.map(summary).collect()
}

/// Reports the limits that the classical planner exceeds; the other planners keep them.
fn broken(job: &Job, plan: &FeedPlan) -> Option<String> {
    let [velocity, acceleration] = [plan.ratios.velocity, plan.ratios.acceleration];
    let broken = job.file.motion.method == MotionMethod::Blocks && velocity.max(acceleration) > 1.0;
    broken.then(|| {
        format!(
            "motion.csv: velocities are up to {velocity:.3}, accelerations up to {acceleration:.3} of \
             their limits: blocks know no curvature; write motion.method = \"jerk\""
        )
    })
}

fn method(job: &Job) -> &'static str {
    match job.file.motion.method {
        MotionMethod::Jerk => "jerk: velocity, acceleration and jerk limits",
        MotionMethod::Optimal => "optimal: velocity and acceleration limits; jerk is not limited",
        MotionMethod::Blocks => "blocks: classical look-ahead; axis limits are not certain to hold",
    }
}

fn motion(job: &Job, moved: &PlannedMotion<'_>) -> Result<MotionSummary, PipelineError> {
    let (path, plan) = (&moved.followed.path, moved.plan);
    let machine = job.kinematics.machine();
    let cutting = path
        .pieces
        .iter()
        .zip(&plan.schedule.pieces)
        .filter(|(piece, _)| piece.motion.is_cut())
        .map(|(_, rows)| rows.t.last().unwrap_or(&0.0) - rows.t.first().unwrap_or(&0.0))
        .sum();
    let mut peaks = AxisPeaks::default();
    for setpoint in setpoint::sample(path, &plan.schedule, job.file.motion.servo_period)? {
        peaks.add(&setpoint.position, &setpoint.velocity, &setpoint.acceleration);
    }
    let axes = machine.axes.iter().enumerate().map(|(index, axis)| peaks.axis(index, axis));
    Ok(MotionSummary {
        machine: machine.name.clone(),
        method: method(job).to_owned(),
        jerk_ratio: plan.ratios.jerk,
        duration: plan.schedule.duration(),
        cutting,
        lower_bound: plan.lower_bound,
        axes: axes.collect(),
        retracts: moved.retracts.to_vec(),
        singular: moved.singular,
    })
}

/// Extremes of the axes over all setpoints.
#[derive(Default)]
struct AxisPeaks {
    seen: Option<[AxisVector; 2]>,
    velocity: AxisVector,
    acceleration: AxisVector,
}

impl AxisPeaks {
    fn add(&mut self, position: &AxisVector, velocity: &AxisVector, acceleration: &AxisVector) {
        let [low, high] = self.seen.unwrap_or([*position; 2]);
        self.seen = Some([low.inf(position), high.sup(position)]);
        self.velocity = self.velocity.sup(&velocity.abs());
        self.acceleration = self.acceleration.sup(&acceleration.abs());
    }

    fn axis(&self, index: usize, axis: &Axis) -> AxisSummary {
        let rotary = axis.kind == AxisKind::Rotary;
        let range = self
            .seen
            .unwrap_or_default()
            .map(|end| if rotary { end[index].to_degrees() } else { end[index] });
        AxisSummary {
            name: axis.name.clone(),
            unit: if rotary { "deg" } else { "mm" }.to_owned(),
            range,
            velocity_ratio: self.velocity[index] / axis.vel.max(axis.rapid),
            acceleration_ratio: self.acceleration[index] / axis.acc,
        }
    }
}

/// Returns the summary of a program and its check.
fn program(job: &Job, program: &CheckedProgram, solids: &Solids) -> ProgramSummary {
    let height = |extreme: &Option<crate::verify::ExtremeHeight>| {
        extreme.as_ref().map_or(0.0, |extreme| extreme.height)
    };
    let worst = |check: &crate::verify::Report, pick: fn(&crate::verify::AxisAudit) -> f64| {
        check.audit.iter().flat_map(|audit| &audit.axes).map(pick).fold(0.0, f64::max)
    };
    let audit = program.check.as_ref().and_then(|check| check.audit.as_ref());
    ProgramSummary {
        dialect: program.dialect.to_owned(),
        file: program.file.to_owned(),
        blocks: program.blocks.len(),
        linuxcnc_duration: audit.map(|audit| audit.linuxcnc.seconds),
        same_as: program.same_as.map(str::to_owned),
        check: program.check.as_ref().map(|check| CheckSummary {
            grid: job.file.verify_grid,
            points: check.deviation.points,
            rest: check.deviation.rest,
            uncut: check.deviation.uncut,
            gouge: (-height(&check.deviation.lowest)).max(program.others.deepest),
            excess: height(&check.deviation.highest).max(0.0),
            gouge_bound: check.deviation.bounds.map(|bounds| bounds.gouge),
            excess_bound: check.deviation.bounds.and_then(|bounds| bounds.excess),
            unbounded_area: check.deviation.bounds.map_or(0.0, |bounds| bounds.open),
            others: program.others.points,
            duration: check.audit.as_ref().map_or(0.0, |audit| audit.duration),
            velocity_ratio: worst(check, |axis| axis.velocity.worst),
            acceleration_ratio: check
                .audit
                .is_some()
                .then(|| worst(check, |axis| axis.acceleration.worst)),
        }),
        stock: program
            .carving
            .as_ref()
            .map(|stock| collisions::stock_summary(&stock.report, &stock.remaining)),
        fixtures: collisions::fixtures_summary(program, solids),
        bodies: collisions::bodies_summary(program, solids),
        parts: program.parts.iter().map(part).collect(),
    }
}

fn part(part: &OperationProgram) -> OperationProgramSummary {
    let OperationProgram { operation, file, blocks, .. } = part;
    OperationProgramSummary { operation: operation.clone(), file: file.clone(), blocks: *blocks }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_that_saves_nothing_is_told() {
        let moved = |seconds_saved: f64| SingularSummary {
            passages: 1,
            through: 1,
            tilt: 0.01,
            turn_saved: 180.0,
            seconds_saved,
        };
        assert_eq!(idle_share(0.0, None), None);
        assert_eq!(idle_share(0.001, Some(&moved(2.0))), None);
        let told = idle_share(0.001, Some(&moved(-0.001))).unwrap();
        assert!(told.contains("saves no time") && told.contains("singular = 0.001 mm"), "{told}");
        assert!(idle_share(0.001, None).unwrap().starts_with("no cut passes"));
    }
}
