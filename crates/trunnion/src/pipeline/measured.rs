//! A program measured against the part: its text is read, and run as its control would run it.

use super::error::PipelineError;
use super::job::Job;
use super::post::control_of;
use super::programs::Form;
use super::read_back::reader_of;
use crate::blocks::Control;
use crate::nc::read::{self, AxisWords, ClFile, ClMotion, ClRecord, ClWay, Frame, Pace, Step};
use crate::nc::write::Dialect;
use crate::surface::Face;
use crate::types::{AxisVector, Progress, Rest, ToolPose};
use crate::verify::{self, Carving, Finding, Stock};
use nalgebra::{Point3, UnitVector3};

/// Material higher than this counts as uncut in the check \[mm\].
const REACH: f64 = 1.0;

/// Share of the total tolerance by which a ray may miss the swept cutter in the check.
const RAY_SHARE: f64 = 0.005;

/// Share of the total tolerance by which what is certain between the measured points may lie beyond the worst of them.
const MARGIN_SHARE: f64 = 0.05;

/// Grid on the faces that are not cut, over that on those that are.
const OTHERS_GRID: f64 = 3.0;

/// Most grid points on one face in the check.
const MOST_POINTS: usize = 20_000_000;

/// Most faults to report of a program that cannot be read back.
const MOST_FAULTS: usize = 20;

/// Every block has its time. Where F is a tip feed the control plans its own speeds, and only the way is measured.
pub(super) fn is_timed(dialect: Dialect) -> bool {
    matches!(dialect, Dialect::LinuxCnc | Dialect::G93)
}

/// What was found.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) check: Option<verify::Report>,
    /// On faces that are not cut: points, and the deepest gouge \[mm\].
    pub(super) others: (usize, f64),
    pub(super) carving: Option<(Carving, Stock)>,
}

/// What moves the tool.
enum Motion {
    /// Axes, or the tip with linear rotaries.
    Program(read::Program),
    /// The tool from place to place on great circles.
    Locations(ClFile),
}

/// Measures the faces that are cut and those that are not, and cuts the stock.
pub(super) fn run(
    job: &Job,
    (form, text, axes): (&Form, &str, AxisWords),
    (rest, stock): (&[Rest], Option<&Stock>),
    progress: &dyn Progress,
) -> Result<Found, PipelineError> {
    let options = read::ReadOptions::new(reader_of(form.dialect), axes, MOST_FAULTS);
    let failed = |faults| PipelineError::ReadBack { file: form.file, faults };
    let program = read::read(text, &options).map_err(failed)?;
    let circles = control_of(&job.kinematics, form.dialect) == Control::GreatCircle;
    let motion = if circles {
        Motion::Locations(locations(job, &program))
    } else {
        Motion::Program(program)
    };
    let faces: Vec<Face> = job.faces.iter().map(|face| face.face().clone()).collect();
    let mut check =
        motion.measure(job, (&faces, rest), &looks(job, job.file.verify_grid), progress)?;
    if !is_timed(form.dialect) {
        check.audit = None;
        check.findings.retain(|finding| {
            !matches!(finding, Finding::Velocity { .. } | Finding::Acceleration { .. })
        });
    }
    let others = others(job, &motion, &mut check, progress)?;
    let carve = |stock: &Stock| motion.carve(job, (&faces, stock), progress);
    let carving = stock.map(carve).transpose()?;
    Ok(Found { check: Some(check), others, carving })
}

impl Motion {
    fn measure(
        &self,
        job: &Job,
        (faces, rest): (&[Face], &[Rest]),
        options: &verify::Options,
        progress: &dyn Progress,
    ) -> Result<verify::Report, PipelineError> {
        let (believed, real, cutter) = (&job.kinematics, &job.kinematics, &job.cutter);
        Ok(match self {
            Self::Program(program) => {
                let input = verify::Input { program, believed, real, faces, cutter, rest };
                verify::check(&input, options, progress)?
            }
            Self::Locations(file) => {
                let input = verify::ClInput { file, faces, cutter, rest };
                verify::check_cl(&input, options, progress)?
            }
        })
    }

    /// Runs through the stock: what it does, and what is left.
    fn carve(
        &self,
        job: &Job,
        (faces, stock): (&[Face], &Stock),
        progress: &dyn Progress,
    ) -> Result<(Carving, Stock), PipelineError> {
        let (believed, real, cutter) = (&job.kinematics, &job.kinematics, &job.cutter);
        let mut left = stock.clone();
        let tolerance = left.tolerance(job.budget.total);
        let carving = match self {
            Self::Program(program) => {
                let input = verify::Input { program, believed, real, faces, cutter, rest: &[] };
                verify::simulate(&input, &mut left, &[], tolerance, progress)?
            }
            Self::Locations(file) => {
                let input = verify::ClInput { file, faces, cutter, rest: &[] };
                verify::simulate_cl(&input, &mut left, &[], tolerance, progress)?
            }
        };
        Ok((carving, left))
    }
}

/// Where a program with tool-centre-point control says that the tool goes, workpiece frame.
fn locations(job: &Job, program: &read::Program) -> ClFile {
    let back = job.kinematics.setup().rotation.inverse();
    let mut words: [Option<f64>; 5] = [None; 5];
    let mut axis: Option<UnitVector3<f64>> = None;
    let mut file = ClFile { records: Vec::new(), cutter: None, tool: None, warnings: Vec::new() };
    let mut before: Option<ToolPose> = None;
    for step in &program.steps {
        let Step::Move(one) = step else { continue };
        let Frame::Work { tcp, .. } = one.frame else { continue };
        for (slot, word) in words.iter_mut().zip(one.words) {
            *slot = word.or(*slot);
        }
        let [x, y, z, first, second] = words;
        if let Some(told) = one.axis {
            axis = Some(UnitVector3::new_normalize(back * told.into_inner()));
        } else if one.words[3].or(one.words[4]).is_some() {
            let turns = [first, second].map(Option::unwrap_or_default);
            let q = AxisVector::from([0.0, 0.0, 0.0, turns[0], turns[1]]);
            axis = Some(job.kinematics.forward(&q).axis);
        }
        let (true, Some(x), Some(y), Some(z), Some(axis)) = (tcp, x, y, z, axis) else { continue };
        let pose = ToolPose { tip: back * Point3::new(x, y, z), axis };
        let length = before.replace(pose).map_or(0.0, |before| (pose.tip - before.tip).norm());
        let motion = match one.pace {
            Pace::Rapid => ClMotion::Rapid,
            Pace::PerMinute { speed } => ClMotion::Feed(speed),
            Pace::Inverse { seconds } => ClMotion::Feed(length / seconds),
        };
        file.records.push(ClRecord { line: one.line, pose, motion, way: ClWay::Straight });
    }
    file
}

fn looks(job: &Job, grid: f64) -> verify::Options {
    verify::Options {
        grid,
        reach: REACH.max(2.0 * job.budget.total),
        ray_tolerance: RAY_SHARE * job.budget.total,
        total: job.budget.total,
        gouge: job.budget.gouge,
        most_points: MOST_POINTS,
        promise: Some(verify::Promise {
            margin: [MARGIN_SHARE * job.budget.total; 2],
            excess: true,
        }),
    }
}

/// Measures the faces that are not cut, and adds what is gouged of them to the findings.
fn others(
    job: &Job,
    motion: &Motion,
    check: &mut verify::Report,
    progress: &dyn Progress,
) -> Result<(usize, f64), PipelineError> {
    let faces: Vec<Face> = job.others.iter().map(|face| face.face().clone()).collect();
    if faces.is_empty() {
        return Ok((0, 0.0));
    }
    let options = looks(job, OTHERS_GRID * job.file.verify_grid);
    let options = verify::Options { promise: None, ..options };
    let report = motion.measure(job, (&faces, &[]), &options, progress)?;
    let gouges = report.findings.into_iter().filter(|f| matches!(f, Finding::Gouge(_)));
    check.findings.extend(gouges);
    let deepest = report.deviation.lowest.map_or(0.0, |lowest| (-lowest.height).max(0.0));
    Ok((report.deviation.points, deepest))
}
