//! Limits files: no panic.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = trunnion::files::limits::parse(text);
});
