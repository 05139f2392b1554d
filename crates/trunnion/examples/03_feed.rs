//! The fastest jerk-limited schedule through waypoints, at the servo period.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use trunnion::feed::{self, FeedOptions, Limits};
use trunnion::nalgebra::Vector3;
use trunnion::setpoint;
use trunnion::types::{AxisPath, Silent};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Three axes; any number works.
    let waypoints = [
        [0.0, 0.0, 0.0],
        [20.0, 5.0, 0.1],
        [40.0, 30.0, 0.4],
        [60.0, 20.0, 0.2],
        [100.0, 0.0, 0.0],
    ];
    let path = AxisPath::through(&waypoints.map(Vector3::from))?;
    let limits = Limits::symmetric(
        Vector3::new(200.0, 200.0, 2.0), // per second
        Vector3::new(1e3, 1e3, 10.0),
        Vector3::new(2e4, 2e4, 200.0),
    );

    let plan = feed::jerk(&path, &limits, &FeedOptions::fastest(), &Silent)?;
    let gap = plan.schedule.duration() / plan.lower_bound - 1.0;
    println!("{:.4} s, at most {:.1} % above the best", plan.schedule.duration(), 100.0 * gap);

    for (count, point) in setpoint::sample(&path, &plan.schedule, 0.001)?.enumerate() {
        if count % 100 == 0 {
            println!("{:.3} s  {:8.3?}", point.t, point.position.as_slice());
        }
    }
    assert!(plan.bounds.velocity <= 1.0 && plan.bounds.acceleration <= 1.0);
    Ok(())
}
