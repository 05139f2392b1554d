//! The binary in a folder of its own, and a job that works: what tests of its verbs share.

#![allow(dead_code, reason = "every test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test stops on surprise")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

const JOB: &str = include_str!("../../../../../fixtures/small-patch/job.toml");
const PATCH: &str = include_str!("../../../../../fixtures/small-patch/patch.json");
const MACHINE: &str = include_str!("../../../../../machines/bc-trunnion.toml");

pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A folder with a job that works: `job.toml`, `patch.json` and `machine.toml`.
pub(crate) fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("job.toml", JOB), ("patch.json", PATCH), ("machine.toml", MACHINE)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// Runs it in a folder: a verb and its arguments.
pub(crate) fn trunnion(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_trunnion"))
        .args(arguments)
        // Help texts wrap at this width wherever the tests run.
        .env("COLUMNS", "100")
        .current_dir(folder)
        .output()
        .unwrap()
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Exit code, stdout, stderr.
pub(crate) fn outcome(output: &Output) -> (Option<i32>, String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

pub(crate) fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Changes a file of the folder in one place, which must be there.
pub(crate) fn replace(folder: &Path, file: &str, from: &str, to: &str) {
    let path = folder.join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{file} has no {from:?}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}
