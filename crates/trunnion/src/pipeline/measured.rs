//! Check of a written program: its text is read, and run as its control would run it.

use super::error::PipelineError;
use super::fixtures::MOST_COLLISIONS;
use super::job::Job;
use super::program_format::ProgramFormat;
use super::solids::Solids;
use crate::blocks::BlockInterpolation;
use crate::nc::read::{self, AxisWords, Step, Turning};
use crate::nc::write::OutputFormat;
use crate::post::{MOST_FAULTS, control_of};
use crate::surface::{Face, FaceIndex};
use crate::types::{Progress, UncutRegion};
use crate::verify::{
    CheckInput, CheckOptions, CoolantDemand, DeviationTolerance, FeedMeaning, Inspection,
    InspectionReport, Tool,
};

/// Returns true if every block has its time. Where F is a tip feed the control plans its own speeds, and only the
/// geometry is checked.
pub(super) fn is_timed(dialect: OutputFormat) -> bool {
    matches!(dialect, OutputFormat::LinuxCnc | OutputFormat::G93)
}

/// Checks a program of a job as `trunnion check` does: faces that are cut and those that are not, stock and fixtures.
pub(super) fn run(
    job: &Job,
    program: &WrittenProgram<'_>,
    against: &CheckedAgainst<'_>,
    progress: &dyn Progress,
) -> Result<InspectionReport, PipelineError> {
    let plain = |faces: Vec<&FaceIndex>| -> Vec<Face> {
        faces.into_iter().map(|face| face.face().clone()).collect()
    };
    let faces = CheckedFaces { cut: plain(job.cut_faces()), others: plain(job.avoided_faces()) };
    inspect(ProgramOfJob { job, program, faces: &faces }, against, progress)
}

/// Checks the motion of a program of a job alone: axes, stock, fixtures and bodies of the machine.
pub(super) fn motion(
    job: &Job,
    program: &WrittenProgram<'_>,
    against: &CheckedAgainst<'_>,
    progress: &dyn Progress,
) -> Result<InspectionReport, PipelineError> {
    inspect(ProgramOfJob { job, program, faces: &CheckedFaces::default() }, against, progress)
}

/// Faces that a check compares with.
#[derive(Default)]
struct CheckedFaces {
    cut: Vec<Face>,
    /// Faces that must not be cut.
    others: Vec<Face>,
}

/// Program with its job, and the faces that it is compared with.
#[derive(Clone, Copy)]
struct ProgramOfJob<'a> {
    job: &'a Job,
    program: &'a WrittenProgram<'a>,
    faces: &'a CheckedFaces,
}

fn inspect(
    checked: ProgramOfJob<'_>,
    against: &CheckedAgainst<'_>,
    progress: &dyn Progress,
) -> Result<InspectionReport, PipelineError> {
    let ProgramOfJob { job, program, faces } = checked;
    let &WrittenProgram { form, text, axes } = program;
    let options = read::ReadOptions::new(form.dialect.dialect(), axes, MOST_FAULTS);
    let failed = |faults| PipelineError::ReadBack { file: form.file, faults };
    let mut program = read::read(text, &options).map_err(failed)?;
    if control_of(&job.kinematics, form.dialect) == BlockInterpolation::GreatCircle {
        on_circles(&mut program);
    }
    let tools = tools(job);
    let input = CheckInput::program(&program, &job.kinematics, &job.cutter).tools(&tools);
    let input = input.faces(&faces.cut).rest(against.rest);
    let tolerance = DeviationTolerance { excess: job.budget.total, gouge: job.budget.gouge };
    let options = CheckOptions::of_tolerance(tolerance, job.file.verify_grid);
    // F of a control with tool-centre-point control caps the feed: its times reveal nothing about the axes.
    let feeds = if is_timed(form.dialect) { FeedMeaning::Timed } else { FeedMeaning::Cap };
    let coolant =
        if job.file.cutting.coolant { CoolantDemand::Needed } else { CoolantDemand::Unknown };
    let inspection = Inspection::new(input, options).others(&faces.others).feeds(feeds);
    let mut inspection = inspection.coolant(coolant);
    if let Some(stock) = &against.solids.stock {
        inspection = inspection.stock(stock, MOST_COLLISIONS);
    }
    if let Some(fixtures) = &against.solids.fixtures {
        inspection = inspection.fixtures(fixtures.all(), fixtures.watch());
    }
    if let Some(machine) = &against.solids.machine {
        inspection = inspection.bodies(machine.bodies(), machine.watch());
    }
    Ok(inspection.run(progress)?)
}

/// Returns the tools of a job of several operations, each once; none for a job of one.
fn tools(job: &Job) -> Vec<Tool<'_>> {
    let mut tools: Vec<Tool<'_>> = Vec::new();
    for one in job.operations().filter(|_| !job.following.is_empty()) {
        let tool = Tool { number: one.file.tool.number, cutter: &one.cutter };
        if tools.iter().all(|known| known.number != tool.number) {
            tools.push(tool);
        }
    }
    tools
}

/// Text of a program, as it was written.
pub(super) struct WrittenProgram<'a> {
    pub(super) form: &'a ProgramFormat,
    pub(super) text: &'a str,
    pub(super) axes: AxisWords,
}

/// References of the check besides the faces of the job.
pub(super) struct CheckedAgainst<'a> {
    /// Regions that are known to be unfinished.
    pub(super) rest: &'a [UncutRegion],
    pub(super) solids: &'a Solids,
}

/// Makes the tool turn on great circles between rotary words, as the control of the job does.
fn on_circles(program: &mut read::Program) {
    for step in &mut program.steps {
        if let Step::Move(one) = step {
            one.turning = Turning::GreatCircle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::{job, machine};
    use crate::import::surface_json;
    use crate::nc::read::{ProgramText, ReadOptions};
    use crate::surface::{NurbsSurface, Surface};
    use crate::types::Silent;
    use crate::verify::{Finding, Report};

    const PATCH: &str = include_str!("../../../../fixtures/small-patch/patch.json");
    const JOB: &str = include_str!("../../../../fixtures/small-patch/job.toml");
    const MACHINE: &str = include_str!("../../../../machines/bc-trunnion.toml");

    /// Flat neighbour over the middle of a face, a distance above it \[mm\].
    fn neighbour(face: &Face, above: f64) -> Face {
        let ([u, v], near) = (face.bounds(), 0.45);
        let normal = face.normal(u.at(0.5), v.at(0.5)).unwrap().into_inner();
        let corner = |a: f64, b: f64| face.point(u.at(a), v.at(b)) + normal * above;
        let far = 1.0 - near;
        let net = vec![
            vec![corner(near, near), corner(near, far)],
            vec![corner(far, near), corner(far, far)],
        ];
        let knots = || vec![0.0, 0.0, 1.0, 1.0];
        let surface = NurbsSurface::new([1, 1], [knots(), knots()], net, None).unwrap();
        let plate = Face::new(2, Surface::Nurbs(surface), Vec::new()).unwrap();
        let along = plate.normal(0.5, 0.5).unwrap().dot(&normal);
        if along < 0.0 { plate.flipped() } else { plate }
    }

    fn gouges(report: &Report) -> Vec<Finding> {
        let is_gouge = |finding: &&Finding| matches!(finding, Finding::Gouge(_));
        report.findings.iter().filter(is_gouge).cloned().collect()
    }

    #[test]
    fn run_and_check_find_the_same_fault_on_a_neighbour() {
        // One program whose blocks have times, and one whose feeds are a cap.
        let dialects = r#"dialects = ["g93", "fanuc"]"#;
        let text = JOB.replacen(r#"dialects = ["linuxcnc", "g93"]"#, dialects, 1);
        let text = text.replacen("grid = 0.5", "grid = 2.0", 1);
        let machine = machine::parse(MACHINE).unwrap().machine;
        let surface = surface_json::read(PATCH.as_bytes()).unwrap();
        let face = Face::new(1, surface, Vec::new()).unwrap();
        let faces = std::slice::from_ref(&face);
        let mut job = Job::new(job::parse(&text).unwrap(), faces, &machine).unwrap();
        let programs = crate::pipeline::run(&job, &Silent).unwrap().programs;
        // The neighbour comes after the plan, which would keep off it.
        let others = [neighbour(&face, 0.05)];
        job.others = others.iter().cloned().map(|face| FaceIndex::new(face).unwrap()).collect();
        let axes = AxisWords::of(job.kinematics.machine()).unwrap();
        let (solids, rest) = (Solids { stock: None, fixtures: None, machine: None }, []);
        let against = CheckedAgainst { rest: &rest, solids: &solids };
        for (program, dialect) in programs.iter().zip(&job.file.dialects) {
            let form = crate::pipeline::program_format::format_of(*dialect);
            let written = WrittenProgram { form: &form, text: &program.text, axes };
            let by_run = run(&job, &written, &against, &Silent).unwrap();

            let options = ReadOptions::new(form.dialect.dialect(), axes, MOST_FAULTS);
            let source = ProgramText::new(program.text.clone(), options).unwrap();
            let input = CheckInput::program(&source, &job.kinematics, &job.cutter).faces(faces);
            let tolerance =
                DeviationTolerance { excess: job.budget.total, gouge: job.budget.gouge };
            let options = CheckOptions::of_tolerance(tolerance, job.file.verify_grid);
            let by_check = Inspection::new(input, options).others(&others).run(&Silent).unwrap();

            let [Finding::Gouge(gouge)] = &gouges(&by_run.report)[..] else {
                panic!("{:?}", by_run.report.findings)
            };
            assert_eq!(gouge.face, 2);
            assert_eq!(by_run.others, by_check.others);
            assert!(by_run.others.gouge_bound.unwrap() >= by_run.others.deepest);
            assert_eq!(gouges(&by_run.report), gouges(&by_check.report));
            assert_eq!(by_run.report.deviation, by_check.report.deviation);
            if is_timed(form.dialect) {
                assert_eq!(by_run.report.findings, by_check.report.findings);
                assert_eq!(by_run.report.audit, by_check.report.audit);
            }
        }
    }
}
