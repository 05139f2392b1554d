//! Jobs of several operations: what one tool leaves, the next finishes, in one program with changes of tool.
//!
//! The oracle takes the setpoints of each operation through the machine's chain and measures, in closed form, how near
//! its ball comes to points of both faces: it knows nothing of cells, regions and passes.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Vector3};
use std::f64::consts::FRAC_PI_2;
use trunnion::axes::TiltBounds;
use trunnion::files::{job, machine};
use trunnion::pipeline::{self, Job, Outcome, PipelineError};
use trunnion::setpoint;
use trunnion::surface::{
    CylinderSurface, Face, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop,
};
use trunnion::types::{AXES, AxisPath, Diagnostics, Interval, Motion, Silent};

/// Radius of the fillet \[mm\].
const FILLET: f64 = 5.0;

const DEEP: f64 = 8.0;

const JOB: &str = r#"schema = "trunnion-job/1"
name = "floor and fillet"
[part]
file = "part.json"
[setup]
origin = [-381, -254, -505]
clearance = 10
OPERATIONS
[tolerance]
total = 0.05
gouge = 0.01
[strategy]
along = "v"
[cutting]
feed = 3000
spindle = 8000
[machine]
file = "machine.toml"
[motion]
servo_period = 0.004
[output]
dialects = ["linuxcnc", "g93", "fanuc", "fanuc-vector", "haas", "siemens", "siemens-axes", "heidenhain", "heidenhain-axes"]
programs = "each"
[verify]
grid = 1.0
"#;

/// A ball that does not fit the fillet, and one that does.
const TWO: &str = r#"
[[operation]]
tool = { number = 1, kind = "ball", diameter = 14, length = 80 }
[[operation]]
name = "fillet"
tool = { number = 2, kind = "ball", diameter = 8, length = 60 }
method = "rest"
"#;

fn face(number: usize, surface: Surface, [low, high]: [[f64; 2]; 2]) -> Face {
    let corners = [low, [high[0], low[1]], high, [low[0], high[1]], low];
    let trim = TrimLoop::new(vec![TrimCurve::polyline(&corners).unwrap()], [None, None], 1e-9);
    Face::new(number, surface, vec![trim.unwrap()]).unwrap()
}

/// The floor z = 0, and a concave fillet that rises from its edge x = 0.
fn part() -> Vec<Face> {
    let origin = Point3::origin();
    let floor = SurfaceFrame::new(origin, Vector3::z(), Vector3::x()).unwrap();
    let centre = Point3::new(0.0, 0.0, FILLET);
    // Angles from +x, where the fillet ends, to -z, where it begins.
    let frame = SurfaceFrame::new(centre, Vector3::y(), Vector3::x()).unwrap();
    let fillet = Surface::Cylinder(CylinderSurface::new(frame, FILLET).unwrap());
    vec![
        face(1, Surface::Plane(PlaneSurface { frame: floor }), [[-12.0, 0.0], [0.0, DEEP]]),
        face(2, fillet, [[0.0, 0.0], [FRAC_PI_2, DEEP]]).flipped(),
    ]
}

fn points() -> Vec<Point3<f64>> {
    let deep = |j: u32| DEEP * f64::from(j) / 16.0;
    let floor = |i: u32, j: u32| Point3::new(-0.25 * f64::from(i), deep(j), 0.0);
    let fillet = |i: u32, j: u32| {
        let (sin, cos) = (FRAC_PI_2 * f64::from(i) / 32.0).sin_cos();
        Point3::new(FILLET * sin, deep(j), FILLET * (1.0 - cos))
    };
    let all = |at: &dyn Fn(u32, u32) -> Point3<f64>, count: u32| -> Vec<Point3<f64>> {
        (0..=count).flat_map(|i| (0..=16).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect()
    };
    [all(&floor, 48), all(&fillet, 32)].concat()
}

fn job(operations: &str) -> Result<Job, Diagnostics> {
    let text = include_str!("../../../../machines/bc-trunnion.toml");
    let machine = machine::parse(text).unwrap().machine;
    let file = job::parse(&JOB.replace("OPERATIONS", operations))?;
    Job::new(file, &part(), &machine)
}

/// Least distance of each place from the ball of an operation while it cuts \[mm\].
fn nearest(job: &Job, outcome: &Outcome, index: usize, places: &[Point3<f64>]) -> Vec<f64> {
    let operation = &outcome.operations[index];
    let of = job.operations().nth(operation.index).unwrap();
    let (path, schedule) = (&operation.followed.path, &operation.plan.schedule);
    let mut least = vec![f64::INFINITY; places.len()];
    for setpoint in setpoint::sample(path, schedule, 0.004).unwrap() {
        let pose = of.kinematics.forward(&setpoint.position);
        let radius = of.cutter.radius();
        let centre = pose.tip + pose.axis.scale(radius);
        for (least, place) in least.iter_mut().zip(places) {
            *least = least.min((place - centre).norm() - radius);
        }
    }
    least
}

/// The moves of each program are those of the program of all operations, in the same order; it calls its own tool alone.
fn each_operation_has_its_own_program(outcome: &Outcome) {
    for program in &outcome.programs {
        let of_parts: usize = program.parts.iter().map(|part| part.blocks).sum();
        assert_eq!((program.parts.len(), of_parts), (2, program.blocks.len()));
    }
    let program = &outcome.programs[0];
    let is_move = |line: &&str| line.contains(" X") && line.contains(" F");
    let moves =
        |text: &str| -> Vec<String> { text.lines().filter(is_move).map(str::to_owned).collect() };
    let [first, second] = [0, 1].map(|index| &program.parts[index]);
    assert_eq!(first.file, "program-1.linuxcnc.ngc");
    assert_eq!(
        (second.file.as_str(), second.operation.as_str()),
        ("program-2.linuxcnc.ngc", "fillet")
    );
    assert_eq!([moves(&first.text), moves(&second.text)].concat(), moves(&program.text));
    assert!(moves(&second.text).len() > 20);
    let calls = |text: &str, tool: &str| text.lines().any(|line| line.contains(tool));
    assert!(calls(&first.text, "T1 M6") && !calls(&first.text, "T2 M6"));
    assert!(calls(&second.text, "T2 M6") && !calls(&second.text, "T1 M6"));
    // Every head names the tools of its program, in the order of their cuts.
    let named = |text: &str| -> Vec<String> {
        let tools = text.lines().filter_map(|line| line.split_once("tool     "));
        tools.filter_map(|(_, of)| of.split_whitespace().next().map(str::to_owned)).collect()
    };
    assert_eq!(named(&program.text), ["T1", "T2"]);
    assert_eq!([named(&first.text), named(&second.text)].concat(), ["T1", "T2"]);
}

#[test]
fn the_second_tool_finishes_what_the_first_leaves() {
    let job = job(TWO).unwrap();
    let outcome = pipeline::run(&job, &Silent).unwrap();
    assert!(outcome.summary.passed, "{:#?}", outcome.summary.failures);
    assert!(outcome.left_out.is_empty(), "{:#?}", outcome.left_out);
    assert_eq!(outcome.programs.len(), 9);
    each_operation_has_its_own_program(&outcome);

    // The first ball leaves most of the fillet, both together leave nothing, and neither gouges.
    let places = points();
    let [first, second] = [0, 1].map(|index| nearest(&job, &outcome, index, &places));
    let uncut = |of: &dyn Fn(usize) -> f64| (0..places.len()).filter(|i| of(*i) > 0.055).count();
    assert!(uncut(&|i| first[i]) > 32 * 16 / 2);
    assert_eq!(uncut(&|i| first[i].min(second[i])), 0);
    let deepest = first.iter().chain(&second).copied().fold(f64::INFINITY, f64::min);
    assert!(deepest > -0.01, "{deepest}");

    // The second cuts far less than all of both faces, and no pass of it runs where the floor is finished.
    let [_, rest] = &outcome.summary.operations[..] else { panic!() };
    assert_eq!((rest.name.as_str(), rest.tool), ("fillet", 2));
    assert!(rest.cover.area < 0.7 * outcome.summary.cover.area);
    let passes = &outcome.operations[1].covering.passes;
    let contacts = passes.iter().flat_map(|pass| &pass.stations).map(|station| station.contact.x);
    assert!(contacts.fold(f64::INFINITY, f64::min) > -6.0);
    assert!(outcome.operations[1].legs.iter().any(|leg| leg.motion == Motion::Cut));

    // The sheet and the cutter locations have both tools.
    assert!(outcome.setup.contains("tool length H2        Z 60.0000"), "{}", outcome.setup);
    assert_eq!(outcome.cl.matches("LOADTL/").count(), 2);
}

#[test]
fn an_operation_without_work_is_named() {
    // The first ball fits everywhere: nothing is left for the second.
    let small = TWO.replace("diameter = 14", "diameter = 8").replace("number = 2", "number = 1");
    let small = small.replace("length = 60", "length = 80");
    let outcome = pipeline::run(&job(&small).unwrap(), &Silent).unwrap();
    assert!(outcome.summary.passed, "{:#?}", outcome.summary.failures);
    assert_eq!((outcome.operations.len(), outcome.summary.operations.len()), (1, 1));
    let idle = "fillet: nothing is left for it to cut";
    assert!(outcome.summary.warnings.iter().any(|text| text == idle));
}

#[test]
fn a_face_that_two_operations_cut_whole_is_named() {
    let twice = TWO.replace("method = \"rest\"", "faces = [1]");
    let warnings = pipeline::fit(&job(&twice).unwrap());
    // The fillet is left to the first ball, which does not fit it.
    assert!(matches!(warnings, Err(PipelineError::TooConcave(_))));
    let both = twice.replace("diameter = 14", "diameter = 8");
    let warnings = pipeline::fit(&job(&both).unwrap()).unwrap();
    let expected = "face 1 is cut whole by operation 1, T1 and by fillet: write method = \"rest\"";
    assert!(warnings.len() == 1 && warnings[0].starts_with(expected), "{warnings:?}");
}

#[test]
fn a_fillet_that_no_ball_fits_is_refused_at_once() {
    let large = TWO.replace("diameter = 8", "diameter = 12");
    let error = pipeline::run(&job(&large).unwrap(), &Silent).unwrap_err();
    let PipelineError::TooConcave(tight) = &error else { panic!("{error}") };
    assert_eq!((tight.face, tight.corner), (2, 6.0));
    assert!((tight.share - 1.0).abs() < 1e-12 && (tight.radius - FILLET).abs() < 1e-9);
    let message = error.to_string();
    assert!(message.contains("a corner of at most 5.000 mm"), "{message}");
    // A ball of the radius of the fillet itself touches all of it at once: that is no gouge.
    let equal = TWO.replace("diameter = 8", "diameter = 10");
    assert_eq!(pipeline::fit(&job(&equal).unwrap()).unwrap(), Vec::<String>::new());
}

#[test]
fn faults_of_operations_name_their_line() {
    let message = |operations: &str| {
        let faults = job(operations).unwrap_err();
        faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    let cases = [
        ("[[operation]]\nmethod = \"rest\"", "1:1: missing table [tool]"),
        (
            "[[operation]]\ntool = { number = 1, kind = \"ball\", diameter = 8, length = 60 }\nmethod = \"rest\"",
            "10:10: method \"rest\" cuts what the operations before have left, and this is the first",
        ),
        (&TWO.replace("number = 2", "number = 1"), "13:1: tool 1 is given twice, and differently"),
        (&format!("{TWO}[[operation]]\ntool = 4"), "16:8: tool 4 is not described in this job"),
        (&format!("{TWO}[[operation]]\ntool = 2\nfaces = [3]"), "17:9: the part has no face 3"),
        (&format!("{TWO}strategy = {{ lead_angel = 5 }}"), "15:14: unknown key `lead_angel`"),
    ];
    for (operations, expected) in cases {
        let found = message(operations);
        assert!(found.contains(expected), "{expected}\n{found}");
    }
}

#[test]
fn an_operation_takes_what_it_leaves_out_from_the_job() {
    let text = format!("{TWO}strategy = {{ lead_angle = 25 }}\ncutting = {{ feed = 600 }}");
    let job = job(&text).unwrap();
    let [first, second] = &job.file.operations[..] else { panic!() };
    assert_eq!(first.strategy.along, second.strategy.along);
    assert!((second.cutting.feed - 10.0).abs() < 1e-12);
    assert!((second.cutting.spindle - first.cutting.spindle).abs() < 1e-12);
    let lead = |of: &job::JobOperation| match of.strategy.method {
        job::JobPlacement::Leaning { angle: lead } | job::JobPlacement::Fixed { lead, .. } => {
            lead.to_degrees()
        }
        job::JobPlacement::Widest => f64::NAN,
    };
    assert!((lead(first) - 10.0).abs() < 1e-9 && (lead(second) - 25.0).abs() < 1e-9);
    assert_eq!(first.name, "operation 1, T1");
    // The tools of later operations are those that a check may meet, too.
    assert_eq!(job.other_tools.iter().map(|(number, _)| *number).collect::<Vec<_>>(), [2]);
}

/// Ranges of the axes while the tool cuts.
fn cutting_ranges<'a>(paths: impl Iterator<Item = &'a AxisPath>) -> [Interval; AXES] {
    let mut ranges = [Interval::new(f64::INFINITY, f64::NEG_INFINITY); AXES];
    let pieces = paths.flat_map(|path| &path.pieces).filter(|piece| piece.motion == Motion::Cut);
    for node in pieces.flat_map(|piece| &piece.nodes) {
        let q: &[f64] = node.q[0].as_slice();
        for (range, q) in ranges.iter_mut().zip(q) {
            *range = Interval::new(range.low.min(*q), range.high.max(*q));
        }
    }
    ranges
}

/// The search moves the machine along the paths of all operations, each with the length of its own tool.
#[test]
fn a_setup_is_searched_for_all_operations() {
    let job = job(TWO).unwrap();
    let as_it_is = |low: f64, high: f64| Interval::new(low, high);
    let bounds = TiltBounds {
        tilt: as_it_is(0.0, 0.02),
        towards: as_it_is(0.0, 0.0),
        turn: as_it_is(0.0, 0.0),
    };
    let found = pipeline::setup(&job, &bounds, &Silent).unwrap();
    let searched = found.search.before_axes.unwrap();
    let searched = cutting_ranges(std::iter::once(&searched.path));

    let outcome = pipeline::run(&job, &Silent).unwrap();
    let paths = || outcome.operations.iter().map(|operation| &operation.followed.path);
    let run = cutting_ranges(paths());
    for (axis, (a, b)) in searched.iter().zip(&run).enumerate() {
        let off = (a.low - b.low).abs().max((a.high - b.high).abs());
        assert!(off < 0.01, "axis {axis}: {a:?} {b:?}");
    }
    // The second tool is shorter: with that of the first its axes would stand elsewhere.
    let first = cutting_ranges(paths().take(1));
    assert!((first[2].low - run[2].low).abs() > 5.0, "{first:?} {run:?}");
}

#[test]
fn an_operation_is_a_job_of_its_own() {
    let alone = |index: usize| job(TWO).unwrap().into_operation(index);
    let second = alone(1).unwrap();
    assert_eq!((second.name.as_str(), second.file.tool.number), ("fillet", 2));
    assert!(second.following.is_empty() && second.other_tools.is_empty());
    let first = alone(0).unwrap();
    assert_eq!(first.file.tool.number, 1);
    assert!(first.following.is_empty() && first.other_tools.is_empty());
    assert!(alone(2).is_none());
}
