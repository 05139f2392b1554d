//! Both rotary solutions of a tool axis, and the singular directions of a built-in machine.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use trunnion::files::machine::{built_in, parse};
use trunnion::inverse::{Inverse, InverseSolutions};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nalgebra::{Point3, Unit, Vector3};
use trunnion::types::ToolPose;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = built_in("bc-trunnion").map_err(|_| "no such machine")?;
    let machine = parse(text)?.machine;
    let setup = Setup::new(Vector3::new(-381.0, -254.0, -505.0), [0.0; 3], 120.0);
    let inverse = Inverse::new(&Kinematics::new(&machine, &setup))?;
    for direction in inverse.singular_directions() {
        println!("singular along {:.3?}", direction.as_slice());
    }

    let axis = Unit::new_normalize(Vector3::new(0.3, -0.2, 0.9));
    match inverse.solutions(&ToolPose { tip: Point3::origin(), axis })? {
        InverseSolutions::Regular(both) => {
            for q in both {
                println!("C {:9.4} B {:9.4}", q[3].to_degrees(), q[4].to_degrees());
            }
        }
        InverseSolutions::Singular(q) => println!("B {:9.4}, C is free", q[4].to_degrees()),
    }
    Ok(())
}
