//! `trunnion init` for parts that do not lie as they are cut.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{stderr, trunnion};
use serde_json::Value;
use std::fs;
use std::path::Path;

const GATE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/corpus/gate");

/// Turns a STEP text by a quarter turn about x, backwards: y becomes -z, and z becomes y.
fn lying(step: &str) -> String {
    let turned = |line: &str| {
        let is_vector = line.contains("CARTESIAN_POINT(") || line.contains("DIRECTION(");
        let (head, rest) = line.rsplit_once('(').filter(|_| is_vector)?;
        let (numbers, tail) = rest.split_once("))")?;
        let [x, y, z] = numbers.split(',').collect::<Vec<_>>().try_into().ok()?;
        let minus = y.strip_prefix('-').map_or_else(|| format!("-{y}"), str::to_owned);
        Some(format!("{head}({x},{z},{minus})){tail}"))
    };
    step.lines().map(|line| turned(line).unwrap_or_else(|| line.to_owned()) + "\n").collect()
}

/// Writes a part of the corpus as it is drawn, and lying.
fn both(folder: &Path, name: &str) {
    let step = fs::read_to_string(format!("{GATE}/{name}.step")).unwrap();
    fs::write(folder.join("drawn.step"), &step).unwrap();
    fs::write(folder.join("lying.step"), lying(&step)).unwrap();
}

fn init(folder: &Path, part: &str, options: &[&str]) -> Value {
    let (file, job) = (format!("{part}.step"), format!("{part}.toml"));
    let words = [&["init", &file, "-o", &job, "--json"], options].concat();
    let output = trunnion(folder, &words);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_part_that_is_drawn_lying_comes_up() {
    let folder = tempfile::tempdir().unwrap();
    both(folder.path(), "slanted_pocket");
    let [drawn, lying] = ["drawn", "lying"].map(|part| init(folder.path(), part, &[]));
    assert_eq!(drawn["rotation"], serde_json::json!([0.0, 0.0, 0.0]));
    assert_eq!(lying["rotation"], serde_json::json!([90.0, 0.0, 0.0]));
    for key in ["faces", "left_out", "operations", "origin"] {
        assert_eq!(drawn[key], lying[key], "{key}");
    }
    let job = fs::read_to_string(folder.path().join("lying.toml")).unwrap();
    assert!(job.contains("\nrotation = [90, 0, 0]  # of the part"), "{job}");
    assert!(job.contains("face 5 looks down to the table; turn the part over in a second setup (`--rotation -90,0,0`)"), "{job}");
}

/// A part turned back is the same to the last bit, and so is everything that is made from it.
#[test]
fn a_part_that_is_turned_gives_the_program_of_the_drawn_one() {
    let folder = tempfile::tempdir().unwrap();
    both(folder.path(), "plate");
    init(folder.path(), "drawn", &[]);
    init(folder.path(), "lying", &["--rotation", "90,0,0"]);
    let programs = ["drawn", "lying"].map(|part| {
        let output = trunnion(folder.path(), &["run", &format!("{part}.toml"), "-o", part]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let program = fs::read_to_string(folder.path().join(part).join("program.linuxcnc.ngc"));
        program.unwrap().replace(part, "part")
    });
    assert_eq!(programs[0], programs[1]);
    // Its check without the job needs the rotation, too.
    let check = |rotation: &[&str]| {
        let words = [
            "check",
            "lying/program.linuxcnc.ngc",
            "--machine",
            "bc-trunnion",
            "--part",
            "lying.step",
            "--faces",
            "6",
            "--cutter",
            "R=10,r=0",
            "--tool-length",
            "100",
            "--tolerance",
            "0.02,0.002",
            "--origin=-381,-254,-510",
        ];
        trunnion(folder.path(), &[&words[..], rotation].concat()).status.code()
    };
    assert_eq!(check(&["--part-rotation", "90,0,0"]), Some(0));
    assert_eq!(check(&[]), Some(1));
}
