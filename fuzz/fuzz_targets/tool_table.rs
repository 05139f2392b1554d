//! Tool tables of LinuxCNC: no panic.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = trunnion::nc::read::tool_rows(text, 25.4);
});
