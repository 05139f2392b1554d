//! Passes and links are planned round fixtures.
//!
//! The oracle takes the setpoints through the machine's chain and measures, in closed form, how near the ball with its
//! straight shank, a capsule, comes to a box.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Vector3};
use trunnion::files::{job, machine};
use trunnion::pipeline::{self, Job, Outcome};
use trunnion::setpoint;
use trunnion::surface::{Face, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop};
use trunnion::types::{Mesh, Silent};

const JOB: &str = r#"schema = "trunnion-job/1"
name = "plate with a clamp"
[part]
file = "part.json"
[setup]
origin = [-381, -254, -505]
clearance = 3
[tool]
number = 1
kind = "ball"
diameter = 8
length = 60
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
dialects = ["linuxcnc"]
[verify]
grid = 1.0
fixture_clearance = 0.5
[[fixture]]
name = "clamp"
"#;

fn plate() -> Vec<Face> {
    plate_of([30.0, 20.0])
}

/// The face z = 0 from the origin to a corner \[mm\].
pub(crate) fn plate_of([x, y]: [f64; 2]) -> Vec<Face> {
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y], [0.0, 0.0]];
    let trim = TrimLoop::new(vec![TrimCurve::polyline(&corners).unwrap()], [None, None], 1e-9);
    let plane = Surface::Plane(PlaneSurface { frame });
    vec![Face::new(1, plane, vec![trim.unwrap()]).unwrap()]
}

fn job(fixture: &str) -> Job {
    let text = include_str!("../../../../machines/bc-trunnion.toml");
    let machine = machine::parse(text).unwrap().machine;
    let file = job::parse(&format!("{JOB}{fixture}")).unwrap();
    Job::new(file, &plate(), &machine).unwrap()
}

/// Least distance of the tool from a box \[mm\], along the axis in steps of a quarter of a millimetre.
fn least(job: &Job, outcome: &Outcome, [low, high]: [[f64; 3]; 2]) -> f64 {
    let operation = outcome.operations.first().unwrap();
    let (path, schedule) = (&operation.followed.path, &operation.plan.schedule);
    let (radius, length) = (job.cutter.radius(), job.cutter.length());
    let mut least = f64::INFINITY;
    for setpoint in setpoint::sample(path, schedule, 0.004).unwrap() {
        let pose = job.kinematics.forward(&setpoint.position);
        let mut up = radius;
        while up <= length {
            let p = pose.tip + pose.axis.scale(up);
            let off = |k: usize| (low[k] - p[k]).max(p[k] - high[k]).max(0.0);
            least = least.min(Vector3::new(off(0), off(1), off(2)).norm() - radius);
            up += 0.25;
        }
    }
    least
}

/// A clamp on the edge of the plate, higher than links travel.
const CLAMP: [[f64; 3]; 2] = [[22.0, 6.0, -5.0], [40.0, 14.0, 9.0]];

fn box_mesh([low, high]: [[f64; 3]; 2]) -> Mesh {
    let corner =
        |i: usize| Point3::from([0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] }));
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices: (0..8).map(corner).collect(), triangles }
}

#[test]
fn passes_and_links_keep_off_a_clamp() {
    let plain = "kind = \"box\"\nmin = [22, 6, -5]\nmax = [40, 14, 9]\n";
    let file = "kind = \"stl\"\nfile = \"clamp.stl\"\n";
    for job in [job(plain), job(file).with_fixture(0, box_mesh(CLAMP))] {
        let outcome = pipeline::run(&job, &Silent).unwrap();
        let least = least(&job, &outcome, CLAMP);
        assert!(least >= 0.5, "{least}");
        // The check of the program finds the same.
        let found = outcome.summary.programs[0].fixtures.as_ref().unwrap();
        assert!(found.lines.is_none() && found.hits.is_none(), "{found:?}");
        // Below the clamp and beside it the plate stays, and the clamp is named.
        let failures = &outcome.summary.failures;
        assert!(failures.iter().any(|text| text.contains("gouge fixture clamp")), "{failures:#?}");
        let left: f64 = outcome.summary.cover.rest.iter().map(|rest| rest.area).sum();
        assert!(left > 8.0 * 8.0 && left < 200.0, "{left}");
    }
}

#[test]
fn a_clamp_beside_the_plate_costs_nothing_of_it() {
    let beside = "kind = \"cylinder\"\nbase = [40, 10, -5]\nradius = 4\nheight = 40\n";
    let job = job(beside);
    let outcome = pipeline::run(&job, &Silent).unwrap();
    assert!(outcome.summary.passed, "{:#?}", outcome.summary.failures);
    assert_eq!(outcome.summary.cover.rest, []);
    assert!(least(&job, &outcome, [[37.2, 7.2, -5.0], [42.8, 12.8, 35.0]]) >= 0.5);
}
