//! The binary as a user meets it: exit codes, messages, files whole or not at all.

use crate::binary;

use binary::{folder, replace, root, stderr, trunnion};
use proptest::prelude::*;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Exit 2, a message with `needle`, nothing written.
fn refused(folder: &Path, needle: &str) -> String {
    let output = trunnion(folder, &["run", "job.toml"]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains(needle), "{needle:?} is not in:\n{message}");
    assert!(!folder.join("out").exists(), "something was written");
    message
}

#[test]
fn the_classical_planner_says_which_limits_it_breaks() {
    let folder = folder();
    replace(folder.path(), "job.toml", "method = \"jerk\"", "method = \"blocks\"");
    let output = trunnion(folder.path(), &["run", "job.toml", "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(summary["motion"]["method"].as_str().unwrap().starts_with("blocks:"));
    let failures = summary["failures"].as_array().unwrap();
    let reported = failures.iter().any(|one| one.as_str().unwrap().starts_with("motion.csv: "));
    assert_eq!(output.status.code(), Some(i32::from(!failures.is_empty())));
    let most = |name: &str| {
        let axes = summary["motion"]["axes"].as_array().unwrap().iter();
        axes.map(|axis| axis[name].as_f64().unwrap()).fold(0.0, f64::max)
    };
    // What the setpoints show is reported; the dense check may see more.
    assert!(reported || most("velocity_ratio").max(most("acceleration_ratio")) <= 1.0 + 1e-9);
}

/// One dialect whose text means something else costs that program alone.
#[test]
fn a_program_that_reads_back_otherwise_is_left_out_and_the_rest_is_written() {
    let folder = folder();
    let path = folder.path();
    replace(path, "job.toml", r#"["linuxcnc", "g93"]"#, r#"["haas", "linuxcnc"]"#);
    replace(path, "job.toml", "grid = 0.5", "grid = 4.0");
    // The machine's own text shifts the part.
    replace(path, "machine.toml", r#""G234 H{h}""#, r#""G234 H{h}\nG52 X1.""#);
    let output = trunnion(path, &["run", "job.toml", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let failures = summary["failures"].as_array().unwrap();
    let reason = failures[0].as_str().unwrap();
    assert!(
        failures.len() == 1 && reason.starts_with("program.haas.nc was not written: "),
        "{failures:?}"
    );
    let programs = summary["programs"].as_array().unwrap();
    assert!(programs.len() == 1 && programs[0]["dialect"] == "linuxcnc", "{programs:?}");
    assert!(programs[0]["check"]["gouge"].as_f64().unwrap() <= 0.002);
    let out = |name: &str| path.join("out").join(name);
    for name in ["program.linuxcnc.ngc", "toolpath.cls", "motion.csv", "report.html"] {
        assert!(out(name).exists(), "{name} is not written");
    }
    assert!(!out("program.haas.nc").exists());
    let setup = fs::read_to_string(out("setup.txt")).unwrap();
    assert!(setup.contains("program.linuxcnc.ngc") && !setup.contains("haas"), "{setup}");
}

/// What the limit of the axis's turn is said to cost is the difference of two runs.
#[test]
fn the_cost_of_the_turn_limit_is_that_of_another_run() {
    let summary = |turn: &str| {
        let folder = folder();
        replace(folder.path(), "job.toml", "max_axis_turn = 3", turn);
        let output = trunnion(folder.path(), &["run", "job.toml", "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        summary["cover"].clone()
    };
    let number = |of: &serde_json::Value, name: &str| of[name].as_f64().unwrap();
    let limited = summary("max_axis_turn = 0.3\nturn_cost = true");
    // 10 rad/mm: no axis turns as fast.
    let free = summary("max_axis_turn = 572.9\nturn_cost = false");
    let reported = &limited["turn_limit"];
    assert_eq!(reported["free_passes"], free["passes"]);
    let [long, short] = [&limited, &free].map(|cover| number(cover, "cutting_length"));
    assert!((number(reported, "free_length") - short).abs() <= 1e-9 * short, "{reported} {short}");
    assert!((number(reported, "length") - (long / short - 1.0)).abs() <= 1e-9, "{reported} {long}");
    // To either side: passes of a free axis do not always meet as well.
    assert!((long - short).abs() > 0.01 * short, "the limit changes nothing: {long} {short}");
    assert!(free["turn_limit"].is_null(), "{free}");
}

#[test]
fn a_job_writes_all_its_files_and_keeps_its_tolerance() {
    let folder = folder();
    let output = trunnion(folder.path(), &["run", "job.toml", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["schema"], "trunnion-summary/1");
    assert_eq!(summary["passed"], true);
    assert_eq!(summary["programs"].as_array().unwrap().len(), 2);
    for program in summary["programs"].as_array().unwrap() {
        assert!(program["check"]["excess"].as_f64().unwrap() <= 0.02);
        assert!(program["check"]["gouge"].as_f64().unwrap() <= 0.002);
        assert_eq!(program["check"]["uncut"], 0);
    }
    let duration = summary["motion"]["duration"].as_f64().unwrap();
    assert!(summary["motion"]["lower_bound"].as_f64().unwrap() <= duration);
    for name in [
        "toolpath.cls",
        "program.linuxcnc.ngc",
        "program.g93.nc",
        "setup.txt",
        "motion.csv",
        "report.html",
        "summary.json",
    ] {
        let size = fs::metadata(folder.path().join("out").join(name)).unwrap().len();
        assert!(size > 100, "{name} has {size} bytes");
    }
    let motion = fs::read_to_string(folder.path().join("out/motion.csv")).unwrap();
    assert!(motion.starts_with("# jerk-limited"));
    assert!(summary["motion"]["jerk_ratio"].as_f64().unwrap() <= 1.0);
    assert_eq!(fs::read_dir(folder.path().join("out")).unwrap().count(), 7, "left-overs");
}

#[test]
fn the_same_job_gives_the_same_bytes_on_any_number_of_threads() {
    let run = |threads: &str| {
        let folder = folder();
        let status = Command::new(env!("CARGO_BIN_EXE_trunnion"))
            .args(["run", "job.toml"])
            .env("RAYON_NUM_THREADS", threads)
            .current_dir(folder.path())
            .output()
            .unwrap()
            .status;
        assert!(status.success());
        ["toolpath.cls", "program.g93.nc", "motion.csv", "report.html", "summary.json"]
            .map(|name| fs::read(folder.path().join("out").join(name)).unwrap())
    };
    assert!(run("1") == run("3"), "outputs differ");
}

#[test]
fn a_dry_run_writes_nothing() {
    let folder = folder();
    let output = trunnion(folder.path(), &["run", "job.toml", "--dry-run"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(!folder.path().join("out").exists());
    let output = trunnion(folder.path(), &["run", "job.toml", "--dry-run", "--json"]);
    let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(said["faces"], 1);
    assert_eq!(said["tolerance"]["total"], 0.02);
}

#[test]
fn a_place_that_cannot_hold_outputs_is_refused_before_the_work() {
    let folder = folder();
    fs::write(folder.path().join("taken"), "mine").unwrap();
    for place in ["taken", "taken/deeper"] {
        // A dry run does no work: the refusal comes before it.
        let output = trunnion(folder.path(), &["run", "job.toml", "-o", place, "--dry-run"]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains("taken is a file"), "{}", stderr(&output));
    }
    assert_eq!(fs::read(folder.path().join("taken")).unwrap(), b"mine");
    let output = trunnion(folder.path(), &["run", "job.toml", "-o", "a/b", "--dry-run"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(!folder.path().join("a").exists());
}

#[test]
fn an_unknown_key_is_answered_with_the_one_that_was_meant() {
    let folder = folder();
    replace(folder.path(), "job.toml", "clearance", "clearence");
    let message = refused(folder.path(), "clearence");
    assert!(message.contains("job.toml:8:"), "{message}");
    assert!(message.contains("clearance"), "{message}");
}

#[test]
fn faults_of_several_files_are_reported_together() {
    let folder = folder();
    fs::write(folder.path().join("patch.json"), "{\"degree\": [3, 3]").unwrap();
    replace(folder.path(), "machine.toml", "kind   = \"linear\"", "kind   = \"liner\"");
    let message = refused(folder.path(), "patch.json:1:");
    assert!(message.contains("machine.toml:"), "{message}");
}

#[test]
fn a_missing_file_is_named() {
    let folder = folder();
    fs::remove_file(folder.path().join("patch.json")).unwrap();
    refused(folder.path(), "patch.json");
}

#[test]
fn a_job_may_name_a_built_in_machine() {
    let folder = folder();
    replace(folder.path(), "job.toml", "machine.toml", "bc-trunnion");
    let output = trunnion(folder.path(), &["run", "job.toml", "--dry-run"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    replace(folder.path(), "job.toml", "bc-trunnion", "bc-trunion");
    refused(folder.path(), "bc-trunion: neither a machine file");
}

#[test]
fn a_file_that_is_not_what_its_name_says_is_reported_as_such() {
    let folder = folder();
    fs::write(folder.path().join("patch.json"), "solid cube\nfacet normal 0 0 1\n").unwrap();
    refused(folder.path(), "patch.json");
    fs::write(folder.path().join("part.step"), "solid cube\nfacet normal 0 0 1\n").unwrap();
    replace(folder.path(), "job.toml", "patch.json", "part.step");
    refused(folder.path(), "STL");
}

#[test]
fn a_pose_out_of_travel_says_which_axis_and_by_how_much_and_keeps_the_passes() {
    let folder = folder();
    // A little higher than the travel allows with an upright tool: other inclinations stay inside.
    replace(folder.path(), "job.toml", "[-381, -254, -505]", "[0, 0, -297]");
    let output = trunnion(folder.path(), &["run", "job.toml", "-o", "higher"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    // Some points are beyond the travel at any inclination, others not: that is known when the axes are solved, and the
    // passes are kept.
    replace(folder.path(), "job.toml", "[0, 0, -297]", "[0, 0, -291]");
    let output = trunnion(folder.path(), &["run", "job.toml"]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("end of travel") && message.contains("origin = ["), "{message}");
    let files = fs::read_dir(folder.path().join("out")).unwrap();
    let names: Vec<String> =
        files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    assert_eq!(names, ["toolpath.cls"]);
    let origin = ["--machine", "machine.toml", "--origin", "-381,-254,-505"];
    let post = ["post", "out/toolpath.cls", "--tool-length", "100", "-d", "fanuc", "-o", "p.nc"];
    let posted = trunnion(folder.path(), &[&post[..], &origin[..]].concat());
    assert_eq!(posted.status.code(), Some(0), "{}", stderr(&posted));
}

#[test]
fn a_face_that_looks_away_from_the_spindle_is_refused_before_the_work() {
    let folder = folder();
    replace(folder.path(), "job.toml", "[0, 20, 0]", "[0, 190, 0]");
    let message = refused(folder.path(), "out of reach");
    assert!(message.contains("100.0 % of it") && message.contains("axis B"), "{message}");
    let output = trunnion(folder.path(), &["run", "job.toml", "--dry-run"]);
    assert_eq!(output.status.code(), Some(2));
}

/// A ball of the parabola's radius of curvature, 2 mm, fits at its bottom; the cutter's corner, 3 mm, only near the rims.
#[test]
fn a_hollow_too_narrow_for_the_cutter_is_reported_as_rest_with_the_ball_that_fits() {
    let folder = folder();
    let trough = r#"{"degree":[2,2],"knots":[[0,0,0,1,1,1],[0,0,0,1,1,1]],
        "points":[[[-6,-3,9],[-6,0,9],[-6,3,9]],[[0,-3,-9],[0,0,-9],[0,3,-9]],
        [[6,-3,9],[6,0,9],[6,3,9]]]}"#;
    fs::write(folder.path().join("patch.json"), trough).unwrap();
    let output = trunnion(folder.path(), &["run", "job.toml"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let text = fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let rest = summary["cover"]["rest"].as_array().unwrap();
    let hollow = rest.iter().find(|part| part["why"].as_str().unwrap().contains("too concave"));
    let ball = hollow.unwrap()["least_ball"].as_f64().unwrap();
    assert!((2.0..2.2).contains(&ball), "{ball}");
}

#[test]
fn a_face_that_is_not_there_is_refused_at_its_line() {
    let folder = folder();
    replace(
        folder.path(),
        "job.toml",
        "file = \"patch.json\"",
        "file = \"patch.json\"\nfaces = [7]",
    );
    refused(folder.path(), "job.toml:5:");
}

#[test]
fn inspect_lists_the_faces() {
    let folder = folder();
    let output = trunnion(folder.path(), &["inspect", "patch.json", "-o", "faces.svg"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("B-spline"));
    assert!(fs::read_to_string(folder.path().join("faces.svg")).unwrap().starts_with("<svg"));
}

/// The setup found runs as it is printed, keeps everything, and is faster than the flat one.
#[test]
fn a_setup_is_found_that_runs_faster() {
    let folder = folder();
    let path = folder.path();
    replace(path, "job.toml", "rotation = [0, 20, 0]", "rotation = [0, 0, 0]");
    replace(path, "job.toml", "dialects = [\"linuxcnc\", \"g93\"]", "dialects = [\"g93\"]");
    replace(path, "job.toml", "grid = 0.5", "grid = 2.0");
    let said = |arguments: &[&str]| -> serde_json::Value {
        let output = trunnion(path, arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let setup = said(&["setup", "job.toml", "--json", "--tilt", "0..30"]);
    assert_eq!(setup["found"], true);
    assert_eq!(setup["assurance"]["shown"], true, "{setup}");
    let least = |entry: &str| setup[entry]["least_angle"].as_f64().unwrap();
    assert!(least("before") < 2.0 && least("after") > 20.0, "{setup}");
    assert!(setup["after"]["tilt"].as_f64().unwrap() <= 30.01);
    let seconds = |summary: &serde_json::Value| summary["motion"]["duration"].as_f64().unwrap();
    let before = said(&["run", "job.toml", "--json"]);
    assert!((seconds(&before) - setup["before"]["seconds"].as_f64().unwrap()).abs() < 1e-6);
    let rotation = format!("rotation = {}", setup["after"]["rotation"]);
    replace(path, "job.toml", "rotation = [0, 0, 0]", &rotation);
    let after = said(&["run", "job.toml", "--json"]);
    assert_eq!(after["passed"], true);
    assert!(seconds(&after) < 0.9 * seconds(&before), "{} {}", seconds(&after), seconds(&before));
}

/// Links higher than the machine is: exit 1, and what is missing.
#[test]
fn a_setup_that_cannot_be_found_says_what_is_missing() {
    let folder = folder();
    replace(folder.path(), "job.toml", "clearance = 20", "clearance = 700");
    let output = trunnion(folder.path(), &["setup", "job.toml", "--tilt", "0..10"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        said.contains("NO SETUP FITS") && said.contains("Z is ") && said.contains("mm short"),
        "{said}"
    );
}

#[test]
fn bounds_of_a_setup_are_refused_by_their_name() {
    let folder = folder();
    for (arguments, needle) in [
        (["--tilt", "30..10"], "write 10..30"),
        (["--turn", "round"], "such as 0..30"),
        (["--tilt", "-10..10"], "--tilt from -10.000"),
        (["--towards", "0..400"], "--towards from 0.000"),
    ] {
        let output = trunnion(folder.path(), &["setup", "job.toml", arguments[0], arguments[1]]);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(needle), "{}", stderr(&output));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the files hold, the program ends with a message and writes nothing it does not finish.
    #[test]
    fn mutated_files_never_panic(
        which in 0..3usize,
        at in any::<prop::sample::Index>(),
        cut in 0..12usize,
        insert in proptest::collection::vec(any::<u8>(), 0..4),
    ) {
        let folder = folder();
        let path = folder.path().join(["job.toml", "patch.json", "machine.toml"][which]);
        let mut bytes = fs::read(&path).unwrap();
        let start = at.index(bytes.len());
        let end = (start + cut).min(bytes.len());
        bytes.splice(start..end, insert);
        fs::write(&path, bytes).unwrap();
        let output = trunnion(folder.path(), &["run", "job.toml", "--dry-run"]);
        let message = stderr(&output);
        prop_assert!(matches!(output.status.code(), Some(0 | 2)), "{:?}: {message}", output.status);
        prop_assert!(!message.contains("panicked"), "{message}");
    }
}

#[test]
fn one_location_is_found_explained_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let patch = root().join("fixtures/bezier-patch/patch.json");
    let patch = patch.to_str().unwrap();
    let call = |more: &[&str]| {
        let start = ["position", "--surface", patch, "--tolerance", "0.01", "--at", "0.4,0.5"];
        trunnion(folder.path(), &[&start[..], more].concat())
    };
    let found = call(&["--cutter", "R=10,r=6", "--feed", "0,1", "--json", "-o", "error.svg"]);
    assert_eq!(found.status.code(), Some(0), "{}", stderr(&found));
    let answer: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
    assert!((answer["chord_width"].as_f64().unwrap() - 17.1725).abs() < 0.01, "{answer}");
    assert!(answer["rear_min"].as_f64().unwrap() >= 0.0);
    assert!(fs::read_to_string(folder.path().join("error.svg")).unwrap().contains("<polyline"));
    let others =
        ["nested", "mpm", "hermite", "lead-swivel", "curvature", "sturz", "three-axis", "ball"];
    for method in others {
        let other = call(&["--cutter", "R=10,r=6", "--feed", "0,-1", "--method", method]);
        assert_eq!(other.status.code(), Some(0), "{method}: {}", stderr(&other));
        let text = String::from_utf8_lossy(&other.stdout).into_owned();
        assert!(text.contains("strip width") && text.contains("limited by"), "{text}");
    }
    let all = call(&["--cutter", "R=10,r=6", "--feed", "1,0", "--compare", "-o", "strips.svg"]);
    assert_eq!(all.status.code(), Some(0), "{}", stderr(&all));
    let text = String::from_utf8_lossy(&all.stdout).into_owned();
    assert!(others.iter().all(|method| text.contains(method)), "{text}");
    assert!(text.contains("none") && text.contains("touches twice"), "{text}");
    let drawn = fs::read_to_string(folder.path().join("strips.svg")).unwrap();
    assert!(drawn.contains("end-point: 4.18 mm"), "{drawn}");
    let all = call(&["--cutter", "R=10,r=6", "--feed", "1,0", "--compare", "--json"]);
    let answer: serde_json::Value = serde_json::from_slice(&all.stdout).unwrap();
    let methods = answer["methods"].as_array().unwrap();
    assert_eq!(methods.len(), 9);
    assert!(
        methods
            .iter()
            .any(|m| m["method"] == "mpm" && m["refused"].is_string() && m["remedy"].is_string()),
        "{answer}"
    );
    let gouging = ["--cutter", "R=10,r=6", "--feed", "1,0", "--method", "sturz", "--lead", "0.876"];
    let refused = call(&gouging);
    assert_eq!(refused.status.code(), Some(1), "{}", stderr(&refused));
    let text = String::from_utf8_lossy(&refused.stdout).into_owned();
    assert!(text.contains("too close with the rear of the cutting circle"), "{text}");
    let lead =
        call(&["--cutter", "R=10,r=6", "--feed", "1,0", "--method", "sturz", "--lead", "95"]);
    assert_eq!(lead.status.code(), Some(2));
    assert!(stderr(&lead).contains("between -90 and 90 deg"), "{}", stderr(&lead));
    let off = ["position", "--surface", patch, "--tolerance", "0.01", "--at", "0.4,1.5"];
    let off =
        trunnion(folder.path(), &[&off[..], &["--cutter", "R=10,r=6", "--feed", "0,1"]].concat());
    assert_eq!(off.status.code(), Some(2));
    assert!(stderr(&off).contains("v = 1.5 is off the surface, where v goes from 0 to 1"));
    let large = call(&["--cutter", "R=10,r=600", "--feed", "0,1", "--json"]);
    assert_eq!(large.status.code(), Some(1), "{}", stderr(&large));
    let text = String::from_utf8_lossy(&large.stdout).into_owned();
    assert!(text.contains("cutter too large for the concave radius here"), "{text}");
    let wrong = call(&["--cutter", "R=10,q=6", "--feed", "0,1"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(stderr(&wrong).contains("q is not one of R, r, L, inner"), "{}", stderr(&wrong));
}
