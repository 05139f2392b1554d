//! Batches: what is finished is not run again, and failures stop nothing.

use crate::binary::{folder, trunnion};
use std::fs;
use std::path::Path;

const PROGRAM: &str = "G21 G90 G94\nT1 M6\nM3 S1000\nG43 H1\nG0 X0 Y0 Z50 B0 C0\nG1 X10 F600\nM2\n";

const CHECK: [&str; 7] =
    ["--", "--machine", "bc-trunnion", "--tool-length", "120", "--origin", "-381,-254,-505"];

fn batch(folder: &Path, input: &str) -> (Option<i32>, serde_json::Value) {
    let mut words = vec!["batch", input, "-o", "results", "--json"];
    words.extend(CHECK);
    let done = trunnion(folder, &words);
    (done.status.code(), serde_json::from_slice(&done.stdout).unwrap_or_default())
}

#[test]
fn items_are_resumed_and_failures_stand_beside_them() {
    let home = tempfile::tempdir().unwrap();
    let programs = home.path().join("programs");
    fs::create_dir(&programs).unwrap();
    for name in ["a.ngc", "b.ngc"] {
        fs::write(programs.join(name), PROGRAM).unwrap();
    }
    fs::write(programs.join("c.ngc"), "G1 X[2 +\n").unwrap();
    fs::write(programs.join("notes.txt"), "no program").unwrap();
    let (code, summary) = batch(home.path(), "programs");
    assert_eq!((code, &summary["kept"], &summary["failed"]), (Some(1), &2.into(), &1.into()));
    assert_eq!(summary["items"].as_array().unwrap().len(), 3);
    let message = summary["items"][2]["messages"][0].as_str().unwrap();
    assert!(message.contains("c.ngc:1"), "{message}");

    // An edited program is another item, the others are there.
    fs::write(programs.join("b.ngc"), PROGRAM.replace("X10", "X11")).unwrap();
    let (_, again) = batch(home.path(), "programs");
    assert_eq!((&again["resumed"], &again["kept"]), (&2.into(), &2.into()));
    assert_eq!(fs::read_dir(home.path().join("results")).unwrap().count(), 4 + 3);
}

#[test]
fn lists_name_jobs_and_programs() {
    let home = folder();
    fs::write(home.path().join("part.ngc"), PROGRAM).unwrap();
    fs::write(home.path().join("list.txt"), "# two\njob.toml\n\npart.ngc\n").unwrap();
    let (code, summary) = batch(home.path(), "list.txt");
    assert_eq!((code, &summary["kept"]), (Some(0), &2.into()), "{summary}");
    let result = summary["items"][0]["result"].as_str().unwrap();
    assert!(home.path().join("results").join(result).join("report.html").is_file());
}

#[test]
fn an_empty_batch_is_refused() {
    let home = tempfile::tempdir().unwrap();
    fs::write(home.path().join("list.txt"), "# nothing\n").unwrap();
    assert_eq!(batch(home.path(), "list.txt").0, Some(2));
    assert!(!home.path().join("results").exists());
}
