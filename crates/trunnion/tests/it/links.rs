//! Ways between passes keep off faces that are not cut.
//!
//! The oracle takes the setpoints of the whole run back through the machine's chain and measures, in closed form, how
//! near the tool comes to points of the wall at every instant: it knows nothing of leads, hops and planes.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Vector3};
use trunnion::files::{job, machine};
use trunnion::pipeline::{self, Job, Outcome};
use trunnion::setpoint;
use trunnion::surface::{Face, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop};
use trunnion::types::{Motion, Silent, ToolPose};

const MAJOR: f64 = 3.0;
const MINOR: f64 = 2.0;

/// Height of the wall \[mm\].
const HIGH: f64 = 30.0;

const JOB: &str = r#"schema = "trunnion-job/1"
name = "two floors and a wall"
[part]
file = "part.json"
faces = [1, 2]
avoid = AVOID
[setup]
origin = [-381, -254, -505]
rotation = [0, 30, 0]
clearance = 10
[tool]
number = 1
kind = "bull"
major_radius = 3
minor_radius = 2
length = 60
construction = "solid"
[tolerance]
total = 0.06
gouge = 0.01
[strategy]
method = "widest"
along = "v"
direction = "zigzag"
side = "ahead"
max_axis_turn = 3
links = "LINKS"
[cutting]
feed = 3000
reference = "contact"
spindle = 8000
[machine]
file = "machine.toml"
[motion]
method = "jerk"
servo_period = 0.004
[output]
dialects = ["g93"]
[verify]
grid = 1.0
"#;

fn face(number: usize, surface: Surface, [low, high]: [[f64; 2]; 2]) -> Face {
    let corners = [low, [high[0], low[1]], high, [low[0], high[1]], low];
    let trim = TrimLoop::new(vec![TrimCurve::polyline(&corners).unwrap()], [None, None], 1e-9);
    Face::new(number, surface, vec![trim.unwrap()]).unwrap()
}

/// The wall x = 0 from y = -3 to 18 between two floors z = 0 from 7 to 15 mm beside it, y from 0 to 15.
fn part() -> Vec<Face> {
    let plane = |z: Vector3<f64>, x: Vector3<f64>| {
        Surface::Plane(PlaneSurface { frame: SurfaceFrame::new(Point3::origin(), z, x).unwrap() })
    };
    let floor = || plane(Vector3::z(), Vector3::x());
    vec![
        face(1, floor(), [[-15.0, 0.0], [-7.0, 15.0]]),
        face(2, floor(), [[7.0, 0.0], [15.0, 15.0]]),
        face(3, plane(Vector3::x(), Vector3::y()), [[-3.0, 0.0], [18.0, HIGH]]),
    ]
}

fn wall() -> Vec<Point3<f64>> {
    let at = |j: u32, k: u32| Point3::new(0.0, 0.25 * f64::from(j) - 3.0, 0.25 * f64::from(k));
    (0..=84).flat_map(|j| (0..=120).map(move |k| at(j, k))).collect()
}

/// Distance of a place from the tool, below 0 inside: the rounded corner, the flat end, the flank.
fn distance(pose: &ToolPose, place: &Point3<f64>) -> f64 {
    let from = place - pose.tip;
    let z = from.dot(&pose.axis);
    let rho = (from - pose.axis.scale(z)).norm();
    if z > MINOR {
        return rho - MAJOR - MINOR;
    }
    (rho - MAJOR).max(0.0).hypot(z - MINOR) - MINOR
}

fn run(avoid: &str, links: &str) -> (Job, Outcome) {
    let text = include_str!("../../../../machines/bc-trunnion.toml");
    let machine = machine::parse(text).unwrap().machine;
    let file = job::parse(&JOB.replace("AVOID", avoid).replace("LINKS", links)).unwrap();
    let job = Job::new(file, &part(), &machine).unwrap();
    let outcome = pipeline::run(&job, &Silent).unwrap();
    (job, outcome)
}

/// How near the tool comes to the wall at any setpoint \[mm\].
fn nearest(job: &Job, outcome: &Outcome) -> f64 {
    let operation = &outcome.operations[0];
    let (path, schedule) = (&operation.followed.path, &operation.plan.schedule);
    let setpoints = setpoint::sample(path, schedule, job.file.motion.servo_period).unwrap();
    let wall = wall();
    let near = |pose: ToolPose| {
        wall.iter().map(|place| distance(&pose, place)).fold(f64::INFINITY, f64::min)
    };
    setpoints.map(|set| near(job.kinematics.forward(&set.position))).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_wall_that_is_not_cut_is_kept_off_on_every_way_between_passes() {
    for links in ["hop", "retract"] {
        let (job, outcome) = run("\"all\"", links);
        assert!(outcome.summary.passed, "{:?}", outcome.summary.failures);
        let faces: Vec<usize> =
            outcome.operations[0].covering.passes.iter().map(|pass| pass.face).collect();
        assert!(faces.contains(&1) && faces.contains(&2), "{faces:?}");
        let hops =
            outcome.operations[0].legs.iter().filter(|leg| leg.motion == Motion::Hop).count();
        assert_eq!(hops > 0, links == "hop", "{hops}");
        let least = nearest(&job, &outcome);
        assert!(least >= -job.budget.gouge, "{links}: {least}");
    }
}

#[test]
fn without_the_wall_the_tool_goes_through_where_it_stands() {
    let (job, outcome) = run("[]", "hop");
    let least = nearest(&job, &outcome);
    assert!(least < -MINOR, "{least}: the check above has nothing to find");
}
