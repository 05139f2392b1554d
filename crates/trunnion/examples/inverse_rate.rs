//! Time of the inverse over many poses, to compare the Python package with: rows of tip and tool axis in a binary file.
//!
//! `cargo run --release -p trunnion --example inverse_rate -- poses.f64 REPEATS` prints the least time of all repeats \[s\].
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::hint::black_box;
use std::time::Instant;
use trunnion::files::machine::{built_in, parse};
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nalgebra::Vector3;
use trunnion::types::ToolPose;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let Some(file) = words.next() else {
        println!("give a file of poses: six float64 each, tip and tool axis");
        return Ok(());
    };
    let repeats: u32 = words.next().map_or(Ok(3), |word| word.parse())?;
    let bytes = std::fs::read(file)?;
    let numbers: Vec<f64> =
        bytes.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let pose = |[x, y, z, i, j, k]: &[f64; 6]| ToolPose::new([*x, *y, *z], [*i, *j, *k]);
    let poses: Vec<ToolPose> = numbers.as_chunks().0.iter().filter_map(pose).collect();

    let machine = parse(built_in("bc-trunnion").map_err(|_| "no such machine")?)?.machine;
    let setup = Setup::new(Vector3::new(-381.0, -254.0, -505.0), [0.0; 3], 120.0);
    let inverse = Inverse::new(&Kinematics::new(&machine, &setup))?;
    let mut least = f64::INFINITY;
    for _ in 0..repeats {
        let start = Instant::now();
        let mut near = machine.home();
        let mut rows = Vec::with_capacity(poses.len());
        for pose in &poses {
            near = inverse.near_inside(pose, &near)?;
            rows.push(near);
        }
        black_box(rows);
        least = least.min(start.elapsed().as_secs_f64());
    }
    println!("{least}");
    Ok(())
}
