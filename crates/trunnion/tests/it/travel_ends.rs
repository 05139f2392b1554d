//! A face beyond the travel of a linear axis: the origin that brings it inside is said.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::clamps::plate_of;

use trunnion::files::{job, machine};
use trunnion::pipeline::{self, Job, Outcome, PipelineError};
use trunnion::types::Silent;

const JOB: &str = r#"schema = "trunnion-job/1"
name = "plate at the end of travel"
[part]
file = "part.json"
[setup]
origin = [X, -254, -505]
clearance = 3
[tool]
number = 1
kind = "ball"
diameter = 8
length = 60
[tolerance]
total = 0.1
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
"#;

/// Length of the plate along x \[mm\].
const LENGTH: f64 = 80.0;

fn run(origin: f64) -> Result<Outcome, PipelineError> {
    let machine = machine::parse(include_str!("../../../../machines/bc-trunnion.toml")).unwrap();
    let file = job::parse(&JOB.replace('X', &origin.to_string())).unwrap();
    pipeline::run(&Job::new(file, &plate_of([LENGTH, 10.0]), &machine.machine).unwrap(), &Silent)
}

#[test]
fn the_origin_that_fits_is_said() {
    let text = include_str!("../../../../machines/bc-trunnion.toml");
    let end = machine::parse(text).unwrap().machine.axes[0].limits.low;
    // Nearer ones are reached all the same: the table turns them into the corners of the travel.
    let Err(PipelineError::NothingCut { why }) = run(end - 300.0) else { panic!("nothing fits") };
    let advice = why.iter().find(|line| line.contains("ends of their travel"));
    let advice = advice.unwrap_or_else(|| panic!("{why:?}"));
    let after = advice.split("origin = [").nth(1).unwrap();
    let x: f64 = after.split(',').next().unwrap().parse().unwrap();
    let again = run(x).unwrap().summary;
    assert!(again.passed, "{advice}: {:?}", again.failures);
}
