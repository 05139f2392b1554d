//! Time of the inverse over many poses, to compare the Python package with: rows of tip and tool axis in a binary file.
//!
//! `cargo run --release -p trunnion --example inverse_rate -- poses.f64 REPEATS` prints the least CPU time of all
//! repeats \[s\], on systems without `/proc` the wall clock.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::hint::black_box;
use std::time::Instant;
use trunnion::files::machine::{built_in, parse};
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nalgebra::Vector3;
use trunnion::types::ToolPose;

/// Returns the CPU time of this thread \[s\], or else the time since `since`.
fn cpu_seconds(since: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let on_cpu = text.split(' ').next().and_then(|word| word.parse::<f64>().ok());
    on_cpu.map_or_else(|| since.elapsed().as_secs_f64(), |nanoseconds| 1e-9 * nanoseconds)
}

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
    let (mut least, since) = (f64::INFINITY, Instant::now());
    for _ in 0..repeats {
        let start = cpu_seconds(since);
        let mut near = machine.home();
        let mut rows = Vec::with_capacity(poses.len());
        for pose in &poses {
            near = inverse.near_inside(pose, &near)?;
            rows.push(near);
        }
        black_box(rows);
        least = least.min(cpu_seconds(since) - start);
    }
    println!("{least}");
    Ok(())
}
