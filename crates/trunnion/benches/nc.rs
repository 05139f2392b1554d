//! Reading programs: blocks per second on one core. The budget is 10^6; `LinuxCNC`'s interpreter reads 26 000 lines.
//!
//! Beside it, in the same run, what any reader has to do at least: find the ends of the lines.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use std::fmt::Write;
use trunnion::nc::read::{AxisWord, AxisWords, Dialect, ReadOptions, steps};

const BLOCKS: u32 = 200_000;

fn main() {
    divan::main();
}

/// Blocks on a wave: five words and a feed as inverse-time programs have them; or three words.
fn text(kind: &str) -> String {
    let mut text = "G21 G90 G54 G0 X0 Y0 Z50 A0 C0\nG1 F800\n".to_owned();
    if kind == "inverse time" {
        text.push_str("G93\n");
    }
    for k in 0..BLOCKS {
        let t = 1e-4 * f64::from(k);
        let [x, y, z] = [100.0 * t.sin(), 90.0 * t.cos(), 3.0 * (17.0 * t).sin()];
        let [a, c] = [20.0 * (3.0 * t).sin(), 50.0 * t];
        // Writing to a string does not fail.
        let _ = match kind {
            "three axes" => writeln!(text, "X{x:.3} Y{y:.3} Z{z:.3}"),
            "five axes" => writeln!(text, "X{x:.4} Y{y:.4} Z{z:.4} A{a:.4} C{c:.4}"),
            _ => writeln!(text, "G1 X{x:.4} Y{y:.4} Z{z:.4} A{a:.4} C{c:.4} F{:.3}", 900.0 + a),
        };
    }
    text + "M2\n"
}

fn options() -> ReadOptions {
    let word = |letter: char| AxisWord {
        letter,
        rotary: "ABC".contains(letter),
        decimals: 4,
        reversed: false,
    };
    ReadOptions::new(Dialect::LinuxCnc, AxisWords(['X', 'Y', 'Z', 'A', 'C'].map(word)), 5)
}

#[divan::bench(args = ["inverse time", "five axes", "three axes"])]
fn blocks(bencher: Bencher, kind: &str) {
    let (text, options) = (text(kind), options());
    let bench = bencher.counter(ItemsCount::new(BLOCKS));
    bench.bench(|| {
        let count = steps(black_box(&text).lines(), &options).map_while(Result::ok).count();
        assert!(count >= BLOCKS as usize);
    });
}

#[divan::bench(args = ["inverse time", "three axes"])]
fn lines(bencher: Bencher, kind: &str) {
    let text = text(kind);
    let bench = bencher.counter(ItemsCount::new(BLOCKS));
    bench.bench(|| black_box(&text).lines().map(str::len).sum::<usize>());
}
