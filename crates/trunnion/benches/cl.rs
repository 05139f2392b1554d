//! Reading CL files: records per second on one core. The budget is 10^6.
//!
//! Beside it, in the same run, what any reader has to do at least: find the ends of the lines.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use std::fmt::Write;
use trunnion::nc::read::cl_records;

const RECORDS: u32 = 200_000;

fn main() {
    divan::main();
}

/// Locations on a wave: in five axes as NX writes them, the axis in every other one; or in three.
fn text(kind: &str) -> String {
    let mut text = "UNITS/MM\nMULTAX/ON\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/MMPM,800.\n".to_owned();
    for k in 0..RECORDS {
        let t = 1e-4 * f64::from(k);
        let [x, y, z] = [100.0 * t.sin(), 90.0 * t.cos(), 3.0 * (17.0 * t).sin()];
        let tilt = 0.3 * (3.0 * t).sin();
        let axis = match kind {
            "five axes" => format!(",{:.7},{:.7},{:.7}", tilt.sin(), 0.0, tilt.cos()),
            _ => String::new(),
        };
        // Writing to a string does not fail.
        let _ = writeln!(text, "GOTO/{x:.4},{y:.4},{z:.4}{axis}");
    }
    text + "FINI\n"
}

#[divan::bench(args = ["five axes", "three axes"])]
fn records(bencher: Bencher, kind: &str) {
    let text = text(kind);
    let bench = bencher.counter(ItemsCount::new(RECORDS));
    bench.bench(|| cl_records(black_box(&text).lines(), 1).map_while(Result::ok).count());
}

#[divan::bench(args = ["five axes", "three axes"])]
fn lines(bencher: Bencher, kind: &str) {
    let text = text(kind);
    let bench = bencher.counter(ItemsCount::new(RECORDS));
    bench.bench(|| black_box(&text).lines().map(str::len).sum::<usize>());
}
