//! Surface JSON: no panic.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = trunnion::import::surface_json::read(bytes);
});
