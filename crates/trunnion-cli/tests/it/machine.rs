//! `trunnion pose` and `trunnion machine` as a user meets them.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use proptest::prelude::*;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Runs the program with `input` on stdin.
fn trunnion(folder: &Path, arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_trunnion"))
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that refuses its arguments closes stdin before it is read: not our concern.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    child.wait_with_output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Exit code, stdout, stderr of `trunnion pose` in a folder of its own.
fn pose(arguments: &[&str], input: &str) -> (i32, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let arguments: Vec<&str> = ["pose"].iter().chain(arguments).copied().collect();
    let output = trunnion(folder.path(), &arguments, input);
    (output.status.code().unwrap(), stdout(&output), stderr(&output))
}

/// Rows of a table as numbers; empty fields are NaN.
fn rows(table: &str) -> Vec<Vec<f64>> {
    let number = |field: &str| if field.is_empty() { f64::NAN } else { field.parse().unwrap() };
    table.lines().skip(1).map(|row| row.split(',').map(number).collect()).collect()
}

fn close(a: &[f64], b: &[f64], by: f64) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= by)
}

const SETUP: [&str; 4] = ["--tool-length", "120", "--origin", "-381,-254,-505"];

fn with_setup<'a>(words: &[&'a str]) -> Vec<&'a str> {
    words.iter().copied().chain(SETUP).collect()
}

/// B leans the tool by 30 deg to +x; C = 0, and the trunnion's lever is 30 mm above its B axis.
#[test]
fn a_pose_by_pencil() {
    let table = "x,y,z,i,j,k\n0,0,0,0,0,1\n0,0,0,0.5,0,0.8660254037844386\n";
    let (code, out, _) = pose(&with_setup(&["bc-trunnion", "inverse"]), table);
    assert_eq!(code, 0);
    assert!(out.starts_with("pose,solution,X,Y,Z,C,B\n1,1,-381,-254,-385,0,0\n"), "{out}");
    // Seen from the part, the nose is 120 mm from the tip; the slides see it turned back by 30 deg
    // about the B axis, 30 mm below the origin.
    let row = &rows(&out)[1];
    assert!(
        close(
            row,
            &[
                2.0,
                2.0,
                -381.0 - 15.0,
                -254.0,
                -505.0 - 30.0 + 30.0 * 0.75_f64.sqrt() + 120.0,
                0.0,
                30.0
            ],
            1e-9
        ),
        "{out}"
    );
}

#[test]
fn every_branch_and_a_free_axis_at_home() {
    let table = "i,j,k,x,y,z,remark\n0,0,2,1,2,3,up\n0.3,0.2,0.9,1,2,3,lean\n0,0,-1,0,0,0,down\n";
    let arguments = with_setup(&["bc-trunnion", "inverse", "--all", "--rotation", "0,0,0"]);
    let (code, out, _) = pose(&arguments, table);
    assert_eq!(code, 0);
    let rows = rows(&out);
    let numbers: Vec<[f64; 2]> = rows.iter().map(|row| [row[0], row[1]]).collect();
    assert_eq!(numbers, [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [3.0, 1.0]]);
    assert!(close(&rows[0][5..], &[0.0, 0.0], 0.0));
    assert!(close(&rows[1][5..], &[rows[2][5] - 180.0, -rows[2][6]], 1e-12), "{out}");
    assert!(close(&rows[3][5..], &[0.0, 180.0], 0.0), "{out}");
}

#[test]
fn there_and_back_through_the_tables() {
    let mut table = String::from("x,y,z,i,j,k\n");
    for index in 0..200 {
        let t = 0.1 * f64::from(index);
        let [x, y, z] = [20.0 * t.cos(), 20.0 * t.sin(), t];
        let [i, j] = [0.4 * (1.3 * t).cos(), 0.4 * (1.3 * t).sin()];
        let k = (1.0 - i * i - j * j).sqrt();
        let _ = writeln!(table, "{x},{y},{z},{i},{j},{k}");
    }
    let (code, axes, _) = pose(&with_setup(&["bc-trunnion", "inverse"]), &table);
    assert_eq!(code, 0);
    // C follows the leaning tool turn after turn instead of jumping back.
    let turns: Vec<f64> = rows(&axes).iter().map(|row| row[5]).collect();
    assert!(turns.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 10.0));
    assert!(turns.last().unwrap() - turns[0] > 1400.0, "{turns:?}");
    let (code, poses, _) = pose(&with_setup(&["bc-trunnion", "forward"]), &axes);
    assert_eq!(code, 0);
    assert!(poses.starts_with("x,y,z,i,j,k\n"));
    for (again, row) in rows(&poses).iter().zip(rows(&table)) {
        assert!(close(&again[..3], &row[..3], 1e-9) && close(&again[3..], &row[3..], 1e-12));
    }
}

#[test]
fn the_first_row_continues_from_near() {
    let table = "x,y,z,i,j,k\n0,0,0,0,0,1\n";
    let arguments = with_setup(&["bc-trunnion", "inverse", "--near", "C=720"]);
    let (_, out, _) = pose(&arguments, table);
    assert_eq!(out.lines().nth(1), Some("1,1,-381,-254,-385,720,0"));
    let (code, out, message) = pose(&["bc-trunnion", "inverse", "--near", "A=3"], table);
    assert_eq!((code, out.as_str()), (2, ""));
    assert!(message.contains("has no axis A; it has X, Y, Z, C, B"), "{message}");
}

#[test]
fn what_cannot_be_reached_is_reported_and_the_run_goes_on() {
    let table = "x,y,z,i,j,k\n0,0,0,0,0,-1\n0,0,900,0,0,1\n0,0,0,0,0,1\n";
    let (code, out, message) = pose(&with_setup(&["bc-trunnion", "inverse"]), table);
    assert_eq!(code, 1);
    assert_eq!(
        out.lines().skip(1).collect::<Vec<_>>(),
        ["1,0,,,,,", "2,0,,,,,", "3,1,-381,-254,-385,0,0"]
    );
    assert!(message.contains("pose 1 (line 2): B = 180.0000 deg is outside its travel [-35.0000, 120.0000] by 60.0000 deg"), "{message}");
    assert!(message.contains("pose 2 (line 3): Z = 515.0000 mm is outside its travel [-508.0000, 0.0000] by 515.0000 mm"), "{message}");
    // A 45 deg nutating head reaches up to the horizon.
    let (code, _, message) =
        pose(&["dmu-nutating45", "inverse", "--all"], "x,y,z,i,j,k\n0,0,0,1,0,-1\n");
    assert_eq!(code, 1);
    assert!(
        message.contains(
            "rotary axes C and B reach by 45.0000 deg; nearest: (1.000000, 0.000000, 0.000000)"
        ),
        "{message}"
    );
}

#[test]
fn a_malformed_row_ends_it_without_output() {
    let folder = tempfile::tempdir().unwrap();
    for (table, place) in [
        ("x,y,z,i,j,k\n0,0,0,0,0,1\n0,0,0,0,1\n", "stdin:3:10: the row has 5 fields"),
        ("x,y,z,i,j,k\n0,0,0,0,0,1\n0,zero,0,0,0,1\n", "stdin:3:3: y = \"zero\" is not a number"),
        ("x,y,z,i,j,k\n0,0,0,0,0,nan\n", "stdin:2:11: k = nan is not a finite number"),
        ("x,y,z,i,j,k\n0,0,0,,,\n", "stdin:2:7: i is empty"),
        (
            "x,y,z,i,j,k\n# none\n\n0,0,0,0,0,0\n",
            "stdin:4:1: the tool axis i,j,k is the zero vector",
        ),
        ("x,y,z,i,j\n0,0,0,0,0\n", "stdin:1:1: column k is missing"),
        ("0,0,0,0,0,1\n", "stdin:1:1: the first line must name the columns"),
        ("", "the table is empty"),
    ] {
        for output in ["-", "out.csv"] {
            let arguments = ["pose", "bc-trunnion", "inverse", "--all", "-o", output];
            let output = trunnion(folder.path(), &arguments, table);
            let message = stderr(&output);
            assert_eq!((output.status.code(), stdout(&output).as_str()), (Some(2), ""), "{table}");
            assert!(message.contains(place), "{place:?} is not in {message}");
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "left-overs");
}

#[test]
fn a_summary_for_scripts_and_the_table_in_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let table = "x,y,z,i,j,k\n0,0,0,0,0,1\n0,0,0,0,0,-1\n";
    fs::write(folder.path().join("poses.csv"), table).unwrap();
    let arguments = with_setup(&["pose", "bc-trunnion", "inverse", "poses.csv", "--json"]);
    let output = trunnion(folder.path(), &arguments, "");
    assert_eq!((output.status.code(), stdout(&output).as_str()), (Some(2), ""));
    assert!(stderr(&output).contains("with -o"));
    let arguments: Vec<&str> = arguments.into_iter().chain(["-o", "axes.csv"]).collect();
    let output = trunnion(folder.path(), &arguments, "");
    assert_eq!(output.status.code(), Some(1));
    let summary: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!((&summary["rows"], &summary["unsolved"]), (&2.into(), &1.into()));
    let axes = fs::read_to_string(folder.path().join("axes.csv")).unwrap();
    assert_eq!(axes.lines().count(), 3);
}

/// A circle of 40 mm about z at 2 rad per unit of the parameter, the tool leaning inwards.
fn circle(u: f64) -> [f64; 24] {
    let (s, c) = (2.0 * u).sin_cos();
    let lean = |k: f64, s: f64, c: f64| [40.0 * k * c, 40.0 * k * s, 0.0, -k * c, -k * s, 0.0];
    let mut row = [0.0; 24];
    row[..6].copy_from_slice(&[40.0 * c, 40.0 * s, 5.0, -c, -s, 2.0]);
    row[6..12].copy_from_slice(&lean(2.0, c, -s));
    row[12..18].copy_from_slice(&lean(-4.0, s, c));
    row[18..].copy_from_slice(&lean(-8.0, c, -s));
    row
}

fn jets_table(rows: &[[f64; 24]]) -> String {
    let names = ["x", "y", "z", "i", "j", "k"];
    let header =
        ["", "1", "2", "3"].map(|order| names.map(|name| name.to_owned() + order).join(","));
    let lines = rows.iter().map(|row| row.map(|number| number.to_string()).join(",") + "\n");
    header.join(",") + "\n" + &lines.collect::<String>()
}

/// The same path by its parameter and by arc length: the circle has 80 mm per unit.
#[test]
fn jets_of_a_circle() {
    let table = jets_table(&[circle(0.3), circle(0.31)]);
    let (code, by_u, message) = pose(&with_setup(&["bc-trunnion", "jets"]), &table);
    assert_eq!(code, 0, "{message}");
    let names = ["", "1", "2", "3"]
        .map(|order| ["X", "Y", "Z", "C", "B"].map(|name| name.to_owned() + order).join(","));
    assert_eq!(by_u.lines().next(), Some(names.join(",").as_str()));
    let by_u = rows(&by_u);
    // Seen from the part, the tool leans inwards all the way round: only C turns.
    let [c, b] = [by_u[0][3], by_u[0][4]];
    assert!((b + 0.5_f64.atan().to_degrees()).abs() < 1e-12, "{b}");
    assert!((c - 0.6_f64.to_degrees()).abs() < 1e-9, "{c}");
    let still = [&by_u[0][5..8], &by_u[0][9..]].concat();
    assert!(
        close(&by_u[0][8..9], &[2.0_f64.to_degrees()], 1e-9)
            && close(&still, &[0.0; 14][..still.len()], 1e-9),
        "{still:?}"
    );
    let (_, by_s, _) = pose(&with_setup(&["bc-trunnion", "jets", "--arc-length"]), &table);
    for (u, s) in by_u.iter().zip(rows(&by_s)) {
        for order in 0..4_usize {
            let scale = 80.0_f64.powi(i32::try_from(order).unwrap());
            for axis in 0..5 {
                let [u, s] = [u[5 * order + axis], s[5 * order + axis]];
                assert!((u / scale - s).abs() < 1e-10, "{u} {s}");
            }
        }
    }
}

#[test]
fn a_tip_that_stands_still_has_no_arc_length() {
    let mut turning = circle(0.3);
    for order in 1..4 {
        turning[6 * order..6 * order + 3].fill(0.0);
    }
    let table = jets_table(&[turning, circle(0.3)]);
    let (code, out, _) = pose(&with_setup(&["bc-trunnion", "jets"]), &table);
    assert_eq!(code, 0);
    assert!((rows(&out)[0][8] - 2.0_f64.to_degrees()).abs() < 1e-9);
    let (code, out, message) = pose(&with_setup(&["bc-trunnion", "jets", "--arc-length"]), &table);
    assert_eq!(code, 1);
    assert!(message.contains("pose 1 (line 2): the tip stands still"), "{message}");
    assert!(rows(&out)[0].iter().all(|field| field.is_nan()) && rows(&out)[1].len() == 20);
    let mut up = circle(0.3);
    up[3] = 0.0;
    up[4] = 0.0;
    let (code, _, message) = pose(&with_setup(&["bc-trunnion", "jets"]), &jets_table(&[up]));
    assert!(code == 1 && message.contains("tool parallel to rotary axis C"), "{message}");
}

#[test]
fn a_machine_is_a_file_or_a_name() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(root().join("machines/ac-trunnion.toml")).unwrap();
    fs::write(folder.path().join("bc-trunnion"), text).unwrap();
    let table = "x,y,z,i,j,k\n0,0,-300,0,0,1\n";
    // A file wins over a built-in machine of the same name.
    let output = trunnion(folder.path(), &["pose", "bc-trunnion", "inverse"], table);
    assert!(stdout(&output).starts_with("pose,solution,X,Y,Z,C,A\n"));
    let (code, _, message) = pose(&["bc-trunion", "inverse"], table);
    assert_eq!(code, 2);
    assert!(message.contains("did you mean the built-in machine `bc-trunnion`?"), "{message}");
}

/// Exit code, stdout, stderr in a folder.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = trunnion(folder, arguments, "");
    (output.status.code().unwrap(), stdout(&output), stderr(&output))
}

#[test]
fn the_list_has_all_machines_of_the_repository_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let mut own = fs::read_to_string(root().join("machines/dmu-nutating45.toml")).unwrap();
    own = own.replace("[-30.0, 180.0]", "[-5.0, 175.5]");
    fs::write(folder.path().join("own.toml"), own).unwrap();
    let (code, text, _) = run(folder.path(), &["machine", "list", "own.toml"]);
    assert_eq!(code, 0);
    let row = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
    assert!(
        row("own.toml").contains("table-head        -")
            && row("own.toml").contains("B -5 .. 175.5")
    );
    let mut count = 0;
    for entry in fs::read_dir(root().join("machines")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|end| end == "toml") {
            let name = path.file_stem().unwrap().to_str().unwrap();
            if let Some(code) = name.strip_prefix("layout-") {
                assert!(row(name).contains(&format!("  {}  ", &code[..2])), "{}", row(name));
            }
            // Embedded is what stands in the folder.
            let (_, shown, _) = run(folder.path(), &["machine", "show", name, "--file"]);
            assert_eq!(shown, fs::read_to_string(&path).unwrap(), "{name}");
            count += 1;
        }
    }
    let (_, list, _) = run(folder.path(), &["machine", "list", "--json"]);
    let list: serde_json::Value = serde_json::from_str(&list).unwrap();
    assert_eq!(list.as_array().unwrap().len(), count, "a machine is not built in");
}

#[test]
fn a_machine_is_shown_in_words_as_data_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text, _) =
        run(folder.path(), &["machine", "show", "bc-trunnion", "-o", "chain.svg"]);
    assert_eq!(code, 0);
    for line in [
        "bc-trunnion: table-table, layout 24 of the twelve",
        "workpiece - C - B - bed - X - Y - Z - tool",
        "inclined to C's direction by 0 .. 180 deg; with the travel of B by 0 .. 120 deg",
        "tool along (0, 0, 1) of the part: B = 0 deg, C is free there",
        "B = 180 deg, outside its travel",
        "B +30    deg  the table's +x side goes to +z; seen from the part the spindle end tilts to +x, the nose to -x",
    ] {
        assert!(text.contains(line), "{line:?} is not in\n{text}");
    }
    let svg = fs::read_to_string(folder.path().join("chain.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    let (_, json, _) = run(folder.path(), &["machine", "show", "bc-trunnion", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["layout"], 24);
    assert_eq!(json["axes"][4]["travel"], serde_json::json!([-35.0, 120.0]));
    assert_eq!(json["reach_in_travel"], serde_json::json!([0.0, 120.0]));
    let (code, _, message) = run(folder.path(), &["machine", "show", "gantry-fork"]);
    assert!(code == 2 && message.contains("gantry-fork: neither a machine file"), "{message}");
}

#[test]
fn check_tells_everything_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let good = fs::read_to_string(root().join("machines/bc-trunnion.toml")).unwrap();
    let bad = good
        .replacen("dir    = [1, 0, 0]", "dir    = [0, 0, 0]", 1)
        .replacen("limits = [-508.0, 0.0]", "limits = [0.0, -508.0]", 1)
        .replacen("acc    = 600.0", "acc    = nan", 1)
        .replacen("prefer = ", "preferr = ", 1)
        .replacen("cone ", "cono ", 1);
    fs::write(folder.path().join("good.toml"), good).unwrap();
    fs::write(folder.path().join("bad.toml"), bad).unwrap();
    let (code, text, message) =
        run(folder.path(), &["machine", "check", "good.toml", "bad.toml", "none.toml"]);
    assert_eq!(code, 2, "{message}");
    assert!(
        text.starts_with("good.toml: in order\nbad.toml: 5 faults\nnone.toml: 1 fault\n"),
        "{text}"
    );
    for start in [
        "bad.toml:12:10: axis.X.dir is the zero vector",
        "bad.toml:21:10: travel of axis Y is empty: [0, -508]",
        "bad.toml:40:10: `axis.C.acc` = nan",
        "bad.toml:54:1: unknown key `preferr` in [axis.B]\n  help: did you mean `prefer`?",
        "bad.toml:65:1: unknown key `cono` in [singular]\n  help: did you mean `cone`?",
        "none.toml: neither a machine file",
    ] {
        assert!(message.contains(start), "{start:?} is not in\n{message}");
    }
    let (code, json, _) =
        run(folder.path(), &["machine", "check", "good.toml", "bad.toml", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((code, &json[0]["ok"], &json[1]["ok"]), (2, &true.into(), &false.into()));
    assert_eq!(json[1]["faults"][1]["line"], 21);
    let (code, _, _) = run(folder.path(), &["machine", "check", "good.toml", "ac-trunnion"]);
    assert_eq!(code, 0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the table holds, the program ends with a message, and writes all or nothing.
    #[test]
    fn mutated_tables_never_panic(
        jets in any::<bool>(),
        at in any::<prop::sample::Index>(),
        cut in 0..9usize,
        insert in proptest::collection::vec(any::<u8>(), 0..4),
    ) {
        let (verb, table) = if jets {
            ("jets", jets_table(&[circle(0.3), circle(0.31)]))
        } else {
            ("inverse", "x,y,z,i,j,k\n0,0,0,0,0,1\n-1e3,2.5,0,0.1,.2,3\n0,0,0,0,1,-1\n".to_owned())
        };
        let mut bytes = table.into_bytes();
        let start = at.index(bytes.len());
        let end = (start + cut).min(bytes.len());
        bytes.splice(start..end, insert);
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("in.csv"), bytes).unwrap();
        let arguments = with_setup(&["pose", "bc-trunnion", verb, "in.csv", "-o", "out.csv"]);
        let output = trunnion(folder.path(), &arguments, "");
        let message = stderr(&output);
        prop_assert!(!message.contains("panicked"), "{message}");
        let written = folder.path().join("out.csv").exists();
        match output.status.code() {
            Some(0 | 1) => prop_assert!(written),
            Some(2) => prop_assert!(!written && message.contains("in.csv:"), "{message}"),
            code => prop_assert!(false, "{code:?}: {message}"),
        }
    }
}
