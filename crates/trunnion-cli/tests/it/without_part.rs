//! `trunnion check` without a part, with accepted findings, and under assumed errors.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{json, outcome, trunnion};
use std::fs;
use std::path::Path;

const PROGRAM: &str = "G21 G90 G94 G17 G54 G49\nT1 M6\nS5000 M3\nG0 X-16. Y0. B0. C0.\nG43 H1 Z40.\nZ1.\nG1 F600. X16.\nM30\n";
const PLACE: [&str; 4] = ["--machine", "bc-trunnion", "--origin", "-381,-254,-505"];

fn check(folder: &Path, program: &str, more: &[&str]) -> std::process::Output {
    let name = if program.starts_with("FEDRAT") { "part.cls" } else { "part.ngc" };
    fs::write(folder.join(name), program).unwrap();
    trunnion(folder, &[&["check", name], more].concat())
}

fn refused(folder: &Path, more: &[&str], part: &str) {
    let (code, _, errors) = outcome(&check(folder, PROGRAM, more));
    assert!(code == Some(2) && errors.contains(part), "{more:?}: {errors}");
}

#[test]
fn axes_state_and_stock_need_no_part() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let axes = [&PLACE[..], &["--tool-length", "100"]].concat();
    let output = check(folder, PROGRAM, &[&axes[..], &["-o", "checked", "--json"]].concat());
    let summary = json(&output);
    assert_eq!(output.status.code(), Some(0), "{summary:#}");
    assert!(summary["part"].is_null() && summary["deviation"].is_null(), "{summary:#}");
    assert_eq!(summary["axes"].as_array().unwrap().len(), 5);
    assert!(folder.join("checked/report.html").is_file());

    // The tip passes 1 mm above the origin: a block of stock up to 2 mm is cut, one that is held is hit.
    let cutter = ["--cutter", "R=4,r=1", "--stock", "box:-10,-10,-5,10,10,2"];
    let output = check(folder, PROGRAM, &[&axes[..], &cutter[..], &["--json"]].concat());
    let removed = json(&output)["stock"]["removed"].as_f64().unwrap();
    assert_eq!(output.status.code(), Some(0));
    // 1 mm deep, 20 mm long, 10 mm wide at the top, less the corner radius on both sides: 2 (1 - pi / 4) mm2.
    let by_hand = 20.0 * (10.0 - 2.0 * (1.0 - std::f64::consts::FRAC_PI_4));
    assert!((removed / by_hand - 1.0).abs() < 0.01, "{removed}, by hand {by_hand}");
    let vise = ["--cutter", "R=4,r=1", "--fixture", "box:-10,-10,-5,10,10,2"];
    let (code, table, _) = outcome(&check(folder, PROGRAM, &[&axes[..], &vise[..]].concat()));
    assert!(code == Some(1) && table.contains("NOT KEPT"), "{table}");
}

#[test]
fn what_is_missing_or_has_no_effect_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    refused(folder, &[], "nothing to check against");
    refused(folder, &PLACE, "--tool-length is missing");
    let axes = [&PLACE[..], &["--tool-length", "100"]].concat();
    refused(folder, &[&axes[..], &["--stock", "box:0,0,0,1,1,1"]].concat(), "--cutter is missing");
    refused(folder, &[&axes[..], &["--faces", "1"]].concat(), "--faces needs a part");
    refused(folder, &[&axes[..], &["--what-if", "length=0.1"]].concat(), "--what-if needs a part");
    refused(folder, &[&axes[..], &["--what-if", "size=0.1"]].concat(), "pivot.B.z");
    refused(folder, &[&axes[..], &["--accept", "everything"]].concat(), "spindle-stopped");
    let locations = "FEDRAT/600,MMPM\nGOTO/-1,0,0,0,0,1\nGOTO/10,0,0,0,0,1\nFINI\n";
    let (code, _, errors) = outcome(&check(folder, locations, &axes));
    assert!(code == Some(2) && errors.contains("cutter locations have no axes"), "{errors}");
}

#[test]
fn an_accepted_finding_is_shown_and_does_not_fail() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let axes = [&PLACE[..], &["--tool-length", "100"]].concat();
    let stopped = PROGRAM.replace("S5000 M3\n", "");
    let (code, table, _) = outcome(&check(folder, &stopped, &axes));
    let found = "line 6: a feed move runs while the spindle stands still";
    assert!(code == Some(1) && table.contains(&format!("broken: {found}")), "{table}");
    let accepted = [&axes[..], &["--accept", "spindle-stopped"]].concat();
    let (code, table, _) = outcome(&check(folder, &stopped, &accepted));
    assert!(code == Some(0) && table.contains(&format!("accepted: {found}")), "{table}");
}
