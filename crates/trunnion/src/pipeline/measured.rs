//! A program measured against the part: its text is read, and run as its control would run it.

use super::error::PipelineError;
use super::fixtures;
use super::job::Job;
use super::material::{MOST_COLLISIONS, Solids};
use super::programs::Form;
use crate::blocks::BlockInterpolation;
use crate::nc::read::{self, AxisWords, Step, Turning};
use crate::nc::write::Dialect;
use crate::post::{MOST_FAULTS, control_of, reader_of};
use crate::surface::Face;
use crate::types::{Progress, UncutRegion};
use crate::verify::{self, ClearanceReport, Finding, Stock, StockReport};

/// Grid on the faces that are not cut, over that on those that are.
const OTHERS_GRID: f64 = 3.0;

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
    pub(super) carving: Option<(StockReport, Stock)>,
    pub(super) clearance: Option<ClearanceReport>,
}

/// Measures the faces that are cut and those that are not, cuts the stock, and looks how near fixtures are.
pub(super) fn run(
    job: &Job,
    (form, text, axes): (&Form, &str, AxisWords),
    (rest, solids): (&[UncutRegion], &Solids),
    progress: &dyn Progress,
) -> Result<Found, PipelineError> {
    let options = read::ReadOptions::new(reader_of(form.dialect), axes, MOST_FAULTS);
    let failed = |faults| PipelineError::ReadBack { file: form.file, faults };
    let mut program = read::read(text, &options).map_err(failed)?;
    if control_of(&job.kinematics, form.dialect) == BlockInterpolation::GreatCircle {
        on_circles(&mut program);
    }
    let faces: Vec<Face> = job.faces.iter().map(|face| face.face().clone()).collect();
    let all = input(job, &program, (&faces, rest));
    let mut check = verify::check(&all, &looks(job, job.file.verify_grid), progress)?;
    if !is_timed(form.dialect) {
        check.audit = None;
        // Told by vectors the control chooses the rotaries: those of the plan were planned inside travel.
        let vectors = check.choices.vectors > 0;
        check.findings.retain(|finding| match finding {
            Finding::Velocity { .. } | Finding::Acceleration { .. } => false,
            Finding::Travel { .. } => !vectors,
            _ => true,
        });
    }
    let others = others(job, &program, &mut check, progress)?;
    let carve = |stock: &Stock| {
        let mut left = stock.clone();
        let tolerance = left.tolerance(job.budget.total);
        let cutting = verify::StockOptions { tolerance, worst: MOST_COLLISIONS };
        let carving = verify::simulate(&all, &mut left, &cutting, progress)?;
        Ok::<_, PipelineError>((carving, left))
    };
    let mut carving = solids.stock.as_ref().map(carve).transpose()?;
    let near = |of: &fixtures::Fixtures| verify::clearance(&all, of.all(), of.watch(), progress);
    let clearance = solids.fixtures.as_ref().map(near).transpose()?;
    if let (Some((carving, _)), Some(clearance)) = (&mut carving, &clearance) {
        fixtures::add_hits(carving, clearance);
    }
    Ok(Found { check: Some(check), others, carving, clearance })
}

/// The control of a job turns the tool on great circles between rotary words, too.
fn on_circles(program: &mut read::Program) {
    for step in &mut program.steps {
        if let Step::Move(one) = step {
            one.turning = Turning::GreatCircle;
        }
    }
}

fn input<'a>(
    job: &'a Job,
    program: &'a read::Program,
    (faces, rest): (&'a [Face], &'a [UncutRegion]),
) -> verify::Input<'a> {
    let (believed, real, cutter) = (&job.kinematics, &job.kinematics, &job.cutter);
    verify::Input { program, believed, real, faces, cutter, rest, tables: verify::Tables::NONE }
}

fn looks(job: &Job, grid: f64) -> verify::Options {
    verify::Options::of_tolerance([job.budget.total, job.budget.gouge], grid)
}

/// Measures the faces that are not cut, and adds what is gouged of them to the findings.
fn others(
    job: &Job,
    program: &read::Program,
    check: &mut verify::Report,
    progress: &dyn Progress,
) -> Result<(usize, f64), PipelineError> {
    let faces: Vec<Face> = job.others.iter().map(|face| face.face().clone()).collect();
    if faces.is_empty() {
        return Ok((0, 0.0));
    }
    let options = looks(job, OTHERS_GRID * job.file.verify_grid);
    let options = verify::Options { promise: None, ..options };
    let report = verify::check(&input(job, program, (&faces, &[])), &options, progress)?;
    let gouges = report.findings.into_iter().filter(|f| matches!(f, Finding::Gouge(_)));
    check.findings.extend(gouges);
    let deepest = report.deviation.lowest.map_or(0.0, |lowest| (-lowest.height).max(0.0));
    Ok((report.deviation.points, deepest))
}
