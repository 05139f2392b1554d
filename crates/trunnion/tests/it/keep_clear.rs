//! A job is planned so that the bodies of its machine and the fixtures keep clear; where that is not possible, what helps is said.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::bodies::{body, place};

use nalgebra::{Point3, Vector3};
use trunnion::axes::TiltBounds;
use trunnion::files::{self, machine};
use trunnion::import::surface_json;
use trunnion::machine::{Machine, MachineBody};
use trunnion::pipeline::{self, Job, Outcome, SetupResult};
use trunnion::surface::{Face, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop};
use trunnion::types::{AxisVector, Interval, Silent};

const JOB: &str = include_str!("../../../../fixtures/small-patch/job.toml");

/// Tool of the job, and a ball whose lean the planner chooses.
const BULL: &str = "kind = \"bull\"\nmajor_radius = 5\nminor_radius = 3\n";
const BALL: &str = "kind = \"ball\"\ndiameter = 12\n";

/// Distance of arm and post at home \[mm\].
const APART: f64 = 80.0;

fn plain_machine() -> Machine {
    machine::parse(include_str!("../../../../machines/bc-trunnion.toml")).unwrap().machine
}

/// Returns the job on a patch that looks up, with some of its text replaced.
fn job_text(changes: &[[&str; 2]]) -> String {
    let level = JOB.replacen("[0, 20, 0]", "[0, 0, 0]", 1).replacen(", \"g93\"]", "]", 1).replacen(
        "total = 0.02",
        "total = 0.05",
        1,
    );
    changes.iter().fold(level, |text, [from, to]| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

/// Returns a job on a machine with bodies.
fn job(text: &str, bodies: Vec<MachineBody>) -> Job {
    let patch = include_str!("../../../../fixtures/small-patch/patch.json");
    let face = Face::new(1, surface_json::read(patch.as_bytes()).unwrap(), Vec::new()).unwrap();
    job_on(&[face], text, bodies)
}

/// Returns a job on faces, on a machine with bodies.
fn job_on(faces: &[Face], text: &str, bodies: Vec<MachineBody>) -> Job {
    let mut machine = plain_machine();
    machine.bodies = bodies;
    Job::new(files::job::parse(text).unwrap(), faces, &machine).unwrap()
}

/// Returns a flat face of 20 x 20 mm that begins at an x \[mm\].
fn flat(id: usize, x: f64) -> Face {
    let frame = SurfaceFrame::new(Point3::new(x, 0.0, 0.0), Vector3::z(), Vector3::x()).unwrap();
    let corners = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0], [0.0, 0.0]];
    let trim = TrimLoop::new(vec![TrimCurve::polyline(&corners).unwrap()], [None, None], 1e-9);
    Face::new(id, Surface::Plane(PlaneSurface { frame }), vec![trim.unwrap()]).unwrap()
}

/// Runs a job on a machine with bodies.
fn outcome(text: &str, bodies: Vec<MachineBody>) -> Outcome {
    pipeline::run(&job(text, bodies), &Silent).unwrap()
}

/// Returns the end of the travel of B that is farther from home \[rad\].
fn farthest(outcome: &Outcome) -> f64 {
    let b = outcome.summary.motion.axes.iter().find(|axis| axis.name == "B").unwrap();
    let [low, high] = b.range.map(f64::to_radians);
    if low.abs() > high.abs() { low } else { high }
}

fn cube(name: &str, link: &str, middle: Point3<f64>) -> MachineBody {
    let [low, high] = [-5.0, 5.0].map(|by| (middle + Vector3::repeat(by)).into());
    body(name, link, low, high)
}

/// An arm on B, and posts that it reaches at some angles \[rad\]; all beside part and tool.
fn arm_and_posts(angles: &[f64]) -> Vec<MachineBody> {
    let machine = plain_machine();
    let b = machine.axes.iter().position(|axis| axis.name == "B").unwrap();
    let long = APART / angles[0].abs().sin();
    let arm = machine.axes[b].point + Vector3::new(long, -300.0, 0.0);
    let mut bodies = vec![cube("arm", "B", arm)];
    for (number, angle) in angles.iter().enumerate() {
        let mut q = machine.home();
        q[b] = *angle;
        let [bed, turned] = ["b", "B"].map(|link| place(&machine, link, &q));
        bodies.push(cube(&format!("post {number}"), "b", bed.inverse() * turned * arm));
    }
    bodies
}

/// Asserts that a job passed with nothing too near, and returns the warning that says how.
fn assert_clear(outcome: &Outcome) -> String {
    assert!(outcome.summary.passed, "{:?}", outcome.summary.failures);
    for program in &outcome.programs {
        assert!(program.bodies.iter().all(|found| found.near.is_empty()));
        assert!(program.clearance.iter().all(|found| found.near.is_empty()));
    }
    let how = outcome.summary.warnings.iter().find(|line| line.contains("where all keeps clear"));
    how.unwrap().clone()
}

#[test]
fn axes_take_another_branch_where_bodies_keep_clear() {
    let text = job_text(&[]);
    let worst = farthest(&outcome(&text, Vec::new()));
    assert!(worst.abs() > 0.05, "{worst}");
    let met = 0.8 * worst;

    let clear = outcome(&text, arm_and_posts(&[met]));
    let how = assert_clear(&clear);
    assert!(farthest(&clear) * worst < 0.0, "{} {worst}", farthest(&clear));
    assert!(how.contains("arm and post 0 come too near") && how.contains("B stays in"), "{how}");

    // With a post on either side no branch is left: the pair is named, with its line.
    let blocked = outcome(&text, arm_and_posts(&[met, -met]));
    assert!(!blocked.summary.passed);
    let named =
        |line: &String| line.contains("post") && line.contains("arm") && line.contains("line ");
    assert!(blocked.summary.failures.iter().any(named), "{:?}", blocked.summary.failures);
    assert!((farthest(&blocked) - worst).abs() < 1e-6);
}

#[test]
fn tool_leans_less_where_bodies_keep_clear() {
    let text = job_text(&[[BULL, BALL], ["\"widest\"", "\"auto\""]]);
    let worst = farthest(&outcome(&text, Vec::new()));
    assert!(worst.abs() > 0.15, "{worst}");
    let met = 0.9 * worst;
    let how = assert_clear(&outcome(&text, arm_and_posts(&[met, -met])));
    assert!(how.contains("the tool leans by 5 instead of 10 deg"), "{how}");
}

#[test]
fn links_go_up_over_a_body_of_the_table() {
    let text = job_text(&[[BULL, BALL], ["\"widest\"", "\"auto\""]]);
    let faces = [flat(1, 0.0), flat(2, 60.0)];
    let with_bar = |top: f64| {
        let bar = body("bar", "C", [-343.0, -264.0, -560.0], [-339.0, -214.0, top]);
        pipeline::run(&job_on(&faces, &text, vec![bar]), &Silent).unwrap()
    };
    for (top, how) in
        [(-487.0, "clearance above the part, without hops"), (-478.0, "30 mm above the part")]
    {
        let said = assert_clear(&with_bar(top));
        assert!(said.contains("bar and") && said.contains(how), "{said}");
    }
}

/// Returns the number in front of some words \[mm\].
fn length_before(text: &str, words: &str) -> f64 {
    let before = text.split(words).next().unwrap();
    before.split(' ').next_back().unwrap().parse().unwrap()
}

#[test]
fn advice_names_changes_after_which_all_keeps_clear() {
    // A wide head above a short tool, and a post on the table beside the part.
    let head = body("head", "Z", [-200.0, -200.0, 0.0], [200.0, 200.0, 300.0]);
    let post = body("post", "C", [-300.0, -264.0, -560.0], [-290.0, -244.0, -380.0]);
    let bodies = || vec![head.clone(), post.clone()];
    let text = job_text(&[]);
    let near = outcome(&text, bodies());
    assert!(!near.summary.passed, "{:?}", near.summary.warnings);
    let advice = near.summary.warnings.iter().find(|line| line.contains("bodies of the machine:"));
    let advice = advice.unwrap();
    assert!(advice.contains("post and head come nearest"), "{advice}");
    // Both are true: the job passes with either.
    let longer = length_before(advice, " mm more");
    let text = job_text(&[["length = 100", &format!("length = {}", 100.0 + longer)]]);
    assert!(outcome(&text, bodies()).summary.passed, "{advice}");
    let higher = length_before(advice, " mm higher");
    let origin = format!("-254, {}]", -505.0 + higher);
    let text = job_text(&[["-254, -505]", &origin]]);
    assert!(outcome(&text, bodies()).summary.passed, "{advice}");
}

/// Searches a setup of the job on a machine with bodies.
fn searched(bodies: Vec<MachineBody>) -> SetupResult {
    let job = job(&job_text(&[]), bodies);
    let usual = TiltBounds::usual(&job.kinematics);
    let bounds = TiltBounds { tilt: Interval::new(0.0, 0.4), ..usual };
    pipeline::setup(&job, &bounds, &Silent).unwrap()
}

/// An arm on the table, and a post that it reaches in one position of the axes; far beside part and tool.
fn arm_and_post_at(number: usize, q: &AxisVector) -> [MachineBody; 2] {
    let machine = plain_machine();
    let c = machine.axes.iter().position(|axis| axis.name == "C").unwrap();
    let arm = machine.axes[c].point + Vector3::new(500.0 + 100.0 * number as f64, 0.0, -200.0);
    let [bed, turned] = ["b", "C"].map(|link| place(&machine, link, q));
    let post = bed.inverse() * turned * arm;
    [cube(&format!("arm {number}"), "C", arm), cube(&format!("post {number}"), "b", post)]
}

#[test]
fn setup_search_passes_over_a_setup_that_meets_on_every_branch() {
    let middle = |found: &SetupResult| {
        let (_, followed) = found.search.best.as_ref().unwrap();
        let nodes: Vec<_> = followed.path.pieces.iter().flat_map(|piece| &piece.nodes).collect();
        nodes[nodes.len() / 2].q[0]
    };
    let free = searched(Vec::new());
    let best = free.search.best.as_ref().unwrap().0.setup;
    let mut bodies = Vec::from(arm_and_post_at(0, &middle(&free)));
    for number in 1.. {
        let found = searched(bodies.clone());
        let what = found.bodies.as_ref().unwrap();
        assert!(what.clear && number < 8, "{what:?}");
        if what.passed_over > 0 {
            assert_ne!(found.search.best.as_ref().unwrap().0.setup, best);
            assert_eq!(found.search.others[0].setup, best);
            return;
        }
        // Another branch of the same setup: a post for that one as well.
        bodies.extend(arm_and_post_at(number, &middle(&found)));
    }
}

#[test]
fn setup_search_takes_another_branch_where_bodies_meet() {
    let free = searched(Vec::new());
    assert_eq!(free.bodies, None);
    let (best, followed) = free.search.best.unwrap();
    let nodes = followed.path.pieces.iter().flat_map(|piece| &piece.nodes);
    let tilts = nodes.map(|node| node.q[0][4]);
    let met = 0.9 * tilts.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    // A post is met on the quickest branch of the best setup alone: the other branch keeps clear.
    let found = searched(arm_and_posts(&[met]));
    let bodies = found.bodies.unwrap();
    assert!(bodies.clear && bodies.passed_over == 0, "{bodies:?}");
    assert!(bodies.branch.as_ref().is_some_and(|how| how.contains("B stays in")), "{bodies:?}");
    let (same, followed) = found.search.best.unwrap();
    assert_eq!(same.setup, best.setup);
    let nodes = followed.path.pieces.iter().flat_map(|piece| &piece.nodes);
    assert!(nodes.map(|node| node.q[0][4] * met).all(|side| side <= 1e-9));
    // With a post on either side no setup keeps clear: the others tilt as far, and the best stays the best.
    let found = searched(arm_and_posts(&[met, -met]));
    let bodies = found.bodies.unwrap();
    assert!(!bodies.clear && bodies.passed_over > 1 && bodies.branch.is_none(), "{bodies:?}");
    assert_eq!(found.search.best.unwrap().0.setup, best.setup);
}

#[test]
fn a_pair_that_is_too_near_at_home_is_named_as_such() {
    // A plate on B, 3 mm over one on the bed and far beside everything; 10 mm are wanted.
    let table = body("table", "B", [-800.0, -264.0, -600.0], [-790.0, -244.0, -590.0]);
    let bed = body("bed", "b", [-800.0, -264.0, -613.0], [-790.0, -244.0, -603.0]);
    let wanted = "grid = 0.5\nfixture_clearance = 10";
    let near = outcome(&job_text(&[["grid = 0.5", wanted]]), vec![table, bed]);
    assert!(!near.summary.passed);
    let advice = near.summary.warnings.iter().find(|line| line.contains("at home already"));
    assert!(advice.unwrap().contains("nearer than 10 mm"), "{:?}", near.summary.warnings);
}
