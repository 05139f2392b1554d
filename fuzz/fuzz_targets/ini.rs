//! Configurations of LinuxCNC: no panic.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = trunnion::nc::read::ini_file(text);
});
