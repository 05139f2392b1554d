//! Axis positions for a tool pose on a machine described by its chain alone.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use trunnion::inverse::Inverse;
use trunnion::machine::{KinematicChain, Kinematics, Setup};
use trunnion::nalgebra::{Point3, Unit, Vector3};
use trunnion::types::{AxisVector, ToolPose};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A rotary table C on a trunnion A; the spindle moves in X, Y, Z. Signs are ISO 841.
    let chain = KinematicChain::new()
        .rotary("C", [0.0, 0.0, 1.0], [0.0, 0.0, -600.0])
        .rotary("A", [1.0, 0.0, 0.0], [0.0, 0.0, -560.0])
        .bed()
        .linear("X", [1.0, 0.0, 0.0])
        .linear("Y", [0.0, 1.0, 0.0])
        .linear("Z", [0.0, 0.0, 1.0]);
    let setup = Setup::new(Vector3::new(0.0, 0.0, -600.0), [0.0; 3], 120.0);
    let inverse = Inverse::new(&Kinematics::from_chain(&chain, &setup)?)?;

    // The tool leans by 30 degrees towards +x of the workpiece.
    let axis = Unit::new_normalize(Vector3::new(0.5, 0.0, 0.75_f64.sqrt()));
    let pose = ToolPose { tip: Point3::new(40.0, 10.0, 5.0), axis };
    let q = inverse.near(&pose, &AxisVector::zeros())?;
    let [x, y, z, c, a] = q.into();
    println!("X {x:.4} Y {y:.4} Z {z:.4} C {:.4} A {:.4}", c.to_degrees(), a.to_degrees());

    // There and back.
    let again = inverse.kinematics().forward(&q);
    assert!((again.tip - pose.tip).norm() < 1e-9 && (again.axis.dot(&axis) - 1.0).abs() < 1e-12);
    Ok(())
}
