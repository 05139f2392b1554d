//! `trunnion path` as a user meets it.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{folder, replace, trunnion};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// `trunnion path` in a folder.
fn path(folder: &Path, arguments: &[&str]) -> Output {
    trunnion(folder, &[&["path"], arguments].concat())
}

/// Two passes of a wave with three decimals, a corner in the second, coolant between them.
fn file() -> String {
    let mut text = "PARTNO WAVE\nUNITS/MM\nCUTTER/10.0,5.0\nSPINDL/8000,RPM,CLW\n".to_owned();
    for pass in 0..2 {
        let y = 4.0 * f64::from(pass);
        writeln!(text, "RAPID\nGOTO/0,{y},50,0,0,1\nFEDRAT/800,MMPM").unwrap();
        for k in 0..400 {
            let x = 0.1 * f64::from(k);
            let corner = if pass == 1 { (x - 20.0).max(0.0) } else { 0.0 };
            let z = 0.5 * (0.3 * x).sin();
            let tilt = 0.2 * (0.1 * x).cos();
            let [i, k] = [tilt.sin(), tilt.cos()];
            writeln!(text, "GOTO/{x:.3},{:.3},{z:.3},{i:.6},0,{k:.6}", y + corner).unwrap();
        }
        if pass == 0 {
            text += "COOLNT/ON\n";
        }
    }
    text + "FINI\n"
}

fn places(text: &str) -> Vec<[f64; 6]> {
    let row = |line: &str| {
        let numbers = line.strip_prefix("GOTO/")?.split(',').map(|x| x.parse().unwrap());
        let mut numbers: Vec<f64> = numbers.collect();
        if numbers.len() == 3 {
            numbers.extend([0.0, 0.0, 1.0]);
        }
        numbers.try_into().ok()
    };
    text.lines().filter_map(row).collect()
}

/// Distance of a tip from a polyline.
fn away(tip: &[f64; 6], line: &[[f64; 6]]) -> f64 {
    let part = |pair: &[[f64; 6]]| {
        let way: [f64; 3] = std::array::from_fn(|i| pair[1][i] - pair[0][i]);
        let from: [f64; 3] = std::array::from_fn(|i| tip[i] - pair[0][i]);
        let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let square = dot(&way, &way).max(f64::MIN_POSITIVE);
        let share = (dot(&from, &way) / square).clamp(0.0, 1.0);
        let off: [f64; 3] = std::array::from_fn(|i| from[i] - share * way[i]);
        dot(&off, &off).sqrt()
    };
    line.windows(2).map(part).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_cl_file_is_smoothed_between_rapid_moves() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("in.cls"), file()).unwrap();
    let arguments = ["in.cls", "--smooth", "0.01,0.05", "-o", "out.cls", "--chart", "chart.svg"];
    let output = path(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let reported = String::from_utf8_lossy(&output.stdout);
    assert!(reported.contains("blended") && reported.contains(", 0.01 mm allowed"), "{reported}");
    let text = fs::read_to_string(folder.path().join("out.cls")).unwrap();
    for line in ["PARTNO WAVE", "CUTTER/10.0,5.0", "SPINDL/8000,RPM,CLW", "COOLNT/ON", "FINI"] {
        assert_eq!(text.lines().filter(|found| *found == line).count(), 1, "{line}");
    }
    assert_eq!(text.lines().filter(|line| *line == "RAPID").count(), 2);
    assert!(text.contains("FEDRAT/800.000,MMPM"));
    let [read, written] = [places(&file()), places(&text)];
    let worst = written.iter().map(|tip| away(tip, &read)).fold(0.0, f64::max);
    let missed = read.iter().map(|tip| away(tip, &written)).fold(0.0, f64::max);
    assert!(worst <= 0.01 + 2e-6 && missed <= 0.01 + 2e-6, "{worst} {missed}");
    assert!(written.starts_with(&read[..1]) && written.contains(&read[401]), "rapid places stay");
    assert!(written.len() < read.len(), "{} of {}", written.len(), read.len());
    let chart = fs::read_to_string(folder.path().join("chart.svg")).unwrap();
    assert!(chart.starts_with("<svg") && chart.contains("axis, deg"));
    let json = path(folder.path(), &[&arguments[..5], &["--json"]].concat());
    let json: Value = serde_json::from_slice(&json.stdout).unwrap();
    // Both plunges, and the corner of the second pass.
    assert_eq!(json["smoothing"]["corners_blended"], 3, "{json}");
    assert!(json["smoothing"]["tip_bound"].as_f64().unwrap() <= 0.01);
    assert!(json["smoothing"]["axis_bound"].as_f64().unwrap() <= 0.05);
}

/// Where nothing is bent nothing is said to be.
#[test]
fn rapid_moves_alone_stray_by_their_decimals() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("RAPID\nGOTO/0,0,0,0,0,1\nRAPID\nGOTO/5,0,0\nFINI\n", 1e-6),
        ("RAPID\nGOTO/0,0,0,0,0,1\nFEDRAT/100\nGOTO/0.00001,0,0\nFINI\n", 0.01 / 32.0 + 1e-6),
    ];
    for (text, most) in cases {
        fs::write(folder.path().join("in.cls"), text).unwrap();
        let output =
            path(folder.path(), &["in.cls", "--smooth", "0.01,0.05", "-o", "out.cls", "--json"]);
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(json["smoothing"]["spans"], 0, "{json}");
        assert!(json["smoothing"]["tip_bound"].as_f64().unwrap() <= most, "{json}");
    }
}

#[test]
fn what_is_wrong_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let flipped = "RAPID\nGOTO/0,0,0,0,0,1\nFEDRAT/100\nGOTO/1,0,0\nGOTO/2,0,0,0,0,-1\nFINI\n";
    fs::write(folder.path().join("flip.cls"), flipped).unwrap();
    let cases: [(&[&str], &str); 4] = [
        (&["flip.cls", "--smooth", "0.01,0.05"], "flip.cls:4: the tool axis is reversed"),
        (&["flip.cls", "--smooth", "0.01"], "two numbers above 0"),
        (&["flip.cls", "--json"], "name the CL file with -o"),
        (&["none.cls"], "none.cls"),
    ];
    for (arguments, message) in cases {
        let output = path(folder.path(), arguments);
        let reported = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{reported}");
        assert!(reported.contains(message), "{reported}");
    }
    let same = path(folder.path(), &["flip.cls"]);
    assert_eq!(String::from_utf8_lossy(&same.stdout), flipped);
}

#[test]
fn a_job_plans_its_smooth_path_and_writes_its_locations() {
    let folder = folder();
    let edits = [
        ("\"jerk\"", "\"optimal\""),
        ("gouge = 0.002", "gouge = 0.002\nsplit = { smoothing = 0.002 }"),
        ("\"widest\"", "\"fixed-tilt\"\nlead_angle = 5"),
    ];
    for (from, to) in edits {
        replace(folder.path(), "job.toml", from, to);
    }
    let output = trunnion(folder.path(), &["run", "job.toml", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!((summary["tolerance"]["smoothing"].as_f64().unwrap() - 0.002).abs() < 1e-12);
    let page = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("Smoothing along the path") && page.contains("deviation of the axis"));
    let output = path(folder.path(), &["job.toml", "--smooth", "0.002,0.01", "-o", "path.cls"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(folder.path().join("path.cls")).unwrap();
    assert!(text.starts_with("PARTNO small patch") && text.ends_with("FINI\n"));
    assert!(places(&text).len() > 100);
}

#[test]
fn a_tolerance_below_zero_is_reported_what_is_wanted() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("in.cls"), file()).unwrap();
    let output = path(folder.path(), &["in.cls", "--smooth", "-0.01,0.05", "-o", "out.cls"]);
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{reported}");
    assert!(reported.contains("two numbers above 0"), "{reported}");
    assert!(!folder.path().join("out.cls").exists());
}

/// As NX writes it, in inches: a pass with an arc, with colours between, then two holes.
const NX: &[u8] = b"TOOL PATH/FL\xdcGEL,TOOL,D10
TLDATA/MILL,0.4,0.2,3.0,0.0,0.0
UNITS/INCHES
MSYS/0,0,0,1,0,0,0,1,0
$$ centerline data
PAINT/PATH
RAPID
GOTO/0.0,0.0,2.0
FEDRAT/IPM,40.0
GOTO/0.0,0.0,0.0
PAINT/COLOR,31
GOTO/1.0,0.0,0.0
CIRCLE/1.0,1.0,0.0,0.0,0.0,1.0,1.0,0.002,0.5,0.4,0.2
GOTO/2.0,1.0,0.0
GOTO/2.0,2.0,0.0
CYCLE/DRILL,RAPTO,0.1,FEDTO,-0.5,IPM,10.
GOTO/3.0,2.0,0.0
GOTO/4.0,2.0,0.0
CYCLE/OFF
PAINT/SPEED,10
END-OF-PATH
";

#[test]
fn a_foreign_file_keeps_its_units_its_holes_and_every_byte_that_is_no_motion() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("nx.cls"), NX).unwrap();
    let output = path(folder.path(), &["nx.cls", "--smooth", "0.02,0.1", "-o", "out.cls"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let bytes = fs::read(folder.path().join("out.cls")).unwrap();
    assert!(bytes.starts_with(b"TOOL PATH/FL\xdcGEL,TOOL,D10\n"));
    let text = String::from_utf8_lossy(&bytes);
    let holes =
        "CYCLE/DRILL,RAPTO,0.1,FEDTO,-0.5,IPM,10.\nGOTO/3.0,2.0,0.0\nGOTO/4.0,2.0,0.0\nCYCLE/OFF\n";
    assert!(text.contains(holes) && text.contains("FEDRAT/40.0000,IPM") && !text.contains("MMPM"));
    assert_eq!(text.matches("PAINT").count(), 3);
    let inch = places(&text);
    let on_arc: Vec<f64> = inch
        .iter()
        .filter(|p| p[2].abs() < 1e-9 && p[0] > 1.1 && p[1] < 0.9)
        .map(|p| 25.4 * ((p[0] - 1.0).hypot(p[1] - 1.0) - 1.0))
        .collect();
    assert!(on_arc.len() > 4 && on_arc.iter().all(|off| off.abs() <= 0.02), "{on_arc:?}");
    let counts = |name: &str| {
        let reported = trunnion(folder.path(), &["inspect", name, "--json"]);
        assert_eq!(
            reported.status.code(),
            Some(0),
            "{}",
            String::from_utf8_lossy(&reported.stderr)
        );
        serde_json::from_slice::<Value>(&reported.stdout).unwrap()
    };
    let [read, written] = ["nx.cls", "out.cls"].map(counts);
    assert_eq!((&read["arcs"], &read["holes"]), (&Value::from(1), &Value::from(2)));
    assert_eq!((&written["arcs"], &written["holes"]), (&Value::from(0), &Value::from(2)));
    assert_eq!(read["cutter"], serde_json::json!([10.16, 5.08]));
    for (sum, slack) in [("length", 0.5), ("x", 0.02), ("z", 0.02)] {
        for end in 0..2 {
            let [a, b] = [&read, &written].map(|reported| reported[sum][end].as_f64().unwrap());
            assert!((a - b).abs() < slack, "{sum}: {a} {b}");
        }
    }
}

#[test]
fn a_cl_file_comes_from_a_pipe_and_goes_to_one() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("in.cls"), file()).unwrap();
    let from_file = path(folder.path(), &["in.cls", "--smooth", "0.01,0.05"]);
    let piped = Command::new(env!("CARGO_BIN_EXE_trunnion"))
        .args(["path", "-", "--smooth", "0.01,0.05"])
        .stdin(fs::File::open(folder.path().join("in.cls")).unwrap())
        .output()
        .unwrap();
    assert!(piped.status.success() && piped.stdout == from_file.stdout);
    assert!(piped.stdout.ends_with(b"FINI\n"));
    fs::write(folder.path().join("cut.cls"), file().replace("FINI\n", "")).unwrap();
    let cut = path(folder.path(), &["cut.cls", "--smooth", "0.01,0.05"]);
    assert_eq!((cut.status.code(), cut.stdout.len()), (Some(2), 0));
    fs::write(folder.path().join("bad.cls"), "RAPID\nGOTO/1,2,x\nNURBS/3\nFINI\n").unwrap();
    let bad = path(folder.path(), &["bad.cls"]);
    let reported = String::from_utf8_lossy(&bad.stderr).into_owned();
    assert!(
        reported.contains("bad.cls:2:10: \"x\"") && reported.contains("bad.cls:3:1: NURBS"),
        "{reported}"
    );
}
