//! STEP files: no panic, no endless run.
#![no_main]

use libfuzzer_sys::fuzz_target;
use trunnion::import::{Reader, step::StepReader};
use trunnion::types::Silent;

fuzz_target!(|bytes: &[u8]| {
    let _ = StepReader { chord: 0.1, same: 0.01 }.read(bytes, &Silent);
});
