//! APT/CL files: no panic, no endless run.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = trunnion::nc::read::cl(text, 20);
});
