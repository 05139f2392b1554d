//! NC programs, dialect Siemens: no panic, no endless run.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;
use trunnion::files::machine::{built_in, parse};
use trunnion::nc::read::{AxisWords, Dialect, ReadOptions, read};

/// Letters of the axes, parsed once.
static AXES: LazyLock<AxisWords> = LazyLock::new(|| {
    let machine = parse(built_in("ac-trunnion").expect("built in")).expect("sound").machine;
    AxisWords::of(&machine).expect("letters")
});

fuzz_target!(|text: &str| {
    let mut options = ReadOptions::new(Dialect::Siemens, *AXES, 20);
    options.most_repeated = 10_000;
    let _ = read(text, &options);
});
