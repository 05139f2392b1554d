//! Inputs that once failed, or that a reader must survive: a result or a refusal, no panic, in bounded work.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]

use std::fs;
use std::path::Path;
use trunnion::files::machine::{built_in, parse};
use trunnion::nc::read::{AxisWords, Dialect, ReadOptions, cl, ini_file, read, tool_rows};

/// Reads a file with the reader of its kind; true if it was read without a complaint.
fn is_accepted(name: &str, bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    match name.rsplit('.').next().unwrap() {
        "ngc" => {
            let machine = parse(built_in("ac-trunnion").unwrap()).unwrap().machine;
            let axes = AxisWords::of(&machine).unwrap();
            read(&text, &ReadOptions::new(Dialect::LinuxCnc, axes, 20)).is_ok()
        }
        "tbl" => tool_rows(&text, 25.4).is_ok(),
        // What is no unit leaves millimetres, the value of an empty file.
        "ini" => ini_file(&text).unit.to_bits() != ini_file("").unit.to_bits(),
        "cls" => cl(&text, 20).is_ok(),
        "stl" => trunnion::import::stl::read(bytes).is_ok(),
        "json" => trunnion::import::surface_json::read(bytes).is_ok(),
        #[cfg(feature = "step")]
        "step" => {
            use trunnion::import::{Reader, step::StepReader};
            use trunnion::types::Silent;
            let part = StepReader { chord: 0.1, same: 0.01 }.read(bytes, &Silent);
            part.is_ok_and(|part| part.warnings.is_empty() && !part.faces.is_empty())
        }
        other => panic!("no reader for .{other}"),
    }
}

#[test]
fn every_failure_is_refused_and_listed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/failures");
    let list = fs::read_to_string(folder.join("README.md")).unwrap();
    let mut count = 0;
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        // Inputs of commands are run by the tests of the command line.
        if name == "README.md" || path.is_dir() {
            continue;
        }
        assert!(list.contains(&format!("| `{name}` |")), "{name} has no reason in the list");
        assert!(!is_accepted(&name, &fs::read(&path).unwrap()), "{name} was read without a word");
        count += 1;
    }
    assert!(count >= 6);
}
