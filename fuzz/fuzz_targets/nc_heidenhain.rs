//! NC programs, dialect Heidenhain: no panic, no endless run.
#![no_main]

use libfuzzer_sys::fuzz_target;
use trunnion::files::machine::{built_in, parse};
use trunnion::nc::read::{AxisWords, Dialect, ReadOptions, read};

fuzz_target!(|text: &str| {
    let machine = parse(built_in("ac-trunnion").expect("built in")).expect("sound").machine;
    let axes = AxisWords::of(&machine).expect("letters");
    let mut options = ReadOptions::new(Dialect::Heidenhain, axes, 20);
    options.most_repeated = 10_000;
    let _ = read(text, &options);
});
