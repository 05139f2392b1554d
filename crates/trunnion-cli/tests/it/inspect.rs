//! `trunnion inspect` of NC programs as a user meets it.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{stderr, trunnion};
use serde_json::Value;
use std::fs;

const LINUXCNC: &str = "%\nG21 G90 G94\nT3 M6\nS5000 M3\nG0 X0 Y0 Z10 A0 C0\nG1 Z0 F600\nX30 Y40 C90\nG2 X50 Y40 I10 J0\nG4 P2\nM2\n%\n";
const FANUC: &str = "O0001\n#1=0\nN10 #1=#1+10\nG1 X#1 Y0. Z0. F600.\nIF [#1 LT 30] GOTO 10\nM30\n";
const SIEMENS: &str = "FOR R1=1 TO 3\nG1 X=10*R1 Y0 Z0 F600\nENDFOR\nM30\n";
const HEIDENHAIN: &str = "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 F600\n2 LBL 1\n3 L IX+10\n4 CALL LBL 1 REP 2\n5 END PGM A MM\n";

fn inspect(name: &str, text: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), text).unwrap();
    let output = trunnion(folder.path(), &["inspect", name, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn close(found: &Value, wanted: f64) {
    assert!((found.as_f64().unwrap() - wanted).abs() < 1e-9, "{found} is not {wanted}");
}

#[test]
fn a_program_is_reported_in_blocks_lengths_times_and_ranges() {
    let reported = inspect("part.ngc", LINUXCNC);
    assert_eq!(reported["dialect"], "linuxcnc");
    assert_eq!([&reported["blocks"], &reported["rapids"], &reported["arcs"]], [4, 1, 1]);
    assert_eq!(reported["tools"], serde_json::json!([3]));
    // Down 10, across 50, half a circle of radius 10; at 10 mm/s, and two seconds of rest.
    let way = 10.0 + 50.0 + 10.0 * std::f64::consts::PI;
    close(&reported["length"][1], way);
    close(&reported["seconds"], way / 10.0 + 2.0);
    let ranges: Vec<(String, Vec<f64>)> = reported["axes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|axis| {
            let ends = axis["range"].as_array().unwrap().iter().map(|end| end.as_f64().unwrap());
            (axis["name"].as_str().unwrap().to_owned(), ends.collect())
        })
        .collect();
    let of = |name: &str| ranges.iter().find(|(axis, _)| axis == name).unwrap().1.clone();
    assert_eq!(of("Z"), [0.0, 10.0]);
    assert!((of("C")[1] - 90.0).abs() < 1e-9);
}

#[test]
fn loops_are_run_in_every_language() {
    for (name, text, dialect, blocks, way) in [
        ("a.nc", FANUC, "fanuc", 3, 20.0),
        ("a.mpf", SIEMENS, "siemens", 3, 20.0),
        ("a.h", HEIDENHAIN, "heidenhain", 4, 30.0),
    ] {
        let reported = inspect(name, text);
        assert_eq!(reported["dialect"], dialect);
        assert_eq!(reported["blocks"], blocks, "{reported}");
        close(&reported["length"][1], way);
    }
}

#[test]
fn what_is_wrong_is_reported_with_place_words_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text, needles) in [
        ("a.mpf", "G0 X1\nGOTOF NOWHERE\nM30\n", ["a.mpf:2:", "NOWHERE", "help:"]),
        ("b.ngc", "G0 X1\nG1 X[1/0] F5\nM2\n", ["b.ngc:2:", "no finite value", "help:"]),
        ("c.h", "0 BEGIN PGM A MM\n1 L X+1 RL FMAX\n", ["c.h:2:9:", "compensation", "help:"]),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
        let output = trunnion(folder.path(), &["inspect", name]);
        assert_eq!(output.status.code(), Some(2));
        for needle in needles {
            assert!(stderr(&output).contains(needle), "{}", stderr(&output));
        }
    }
}
