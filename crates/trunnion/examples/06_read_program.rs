//! The moves of an NC program, and everything that is wrong with one.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use trunnion::files::machine::{built_in, parse};
use trunnion::nc::read::{AxisWords, Dialect, ReadOptions, Step, read};

const PROGRAM: &str = "\
G21 G90 G94
T1 M6
G43 H1
G0 X0 Y0 Z50 B0 C0
#1 = 3
o100 while [#1 GT 0]
  G1 X[#1 * 10] B[#1 * 5] F1200
  #1 = [#1 - 1]
o100 endwhile
M2
";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = parse(built_in("bc-trunnion").map_err(|_| "no such machine")?)?.machine;
    let dialect = Dialect::guess(PROGRAM.lines());
    let options = ReadOptions::new(dialect, AxisWords::of(&machine)?, 20);
    let program = read(PROGRAM, &options)?;
    let mut moves = 0;
    for step in &program.steps {
        if let Step::Move(one) = step {
            println!("line {:2}: {:?} {:?}", one.line, one.pace, one.words);
            moves += 1;
        }
    }
    assert_eq!(moves, 4, "a rapid, and the loop three times");

    if let Err(errors) = read("G1 X1 F100\nG1 X[2 +\nG41 D1\n", &options) {
        println!("{errors}");
    }
    Ok(())
}
