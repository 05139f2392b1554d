//! `trunnion post` as a user meets it.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{folder, trunnion};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Every dialect, and how a file of it ends.
pub(crate) const DIALECTS: [&str; 10] = [
    "linuxcnc",
    "g93",
    "fanuc",
    "fanuc-vector",
    "haas",
    "siemens",
    "siemens-axes",
    "heidenhain",
    "heidenhain-axes",
    "apt",
];

const SETUP: [&str; 4] =
    ["--origin=-381,-254,-505", "--tool-length", "120", "--tolerance=0.01,0.05"];

fn post(folder: &Path, arguments: &[&str]) -> Output {
    trunnion(folder, &[&["post"], arguments].concat())
}

fn wave() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/wave/wave.cls")
}

fn posted(folder: &Path, input: &Path, more: &[&str]) -> Value {
    let input = input.to_str().unwrap();
    let mut arguments = vec![input, "--json"];
    arguments.extend(more);
    let output = post(folder, &arguments);
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(
        output.status.code(),
        Some(0),
        "{reported}{}",
        String::from_utf8_lossy(&output.stdout)
    );
    serde_json::from_slice(&output.stdout).unwrap()
}

fn on_bc<'a>(dialect: &'a str, out: &'a str) -> Vec<&'a str> {
    let mut arguments = vec!["-m", "bc-trunnion", "-d", dialect, "-o", out];
    arguments.extend(SETUP);
    arguments
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn every_dialect_keeps_limits_and_tolerance_and_has_its_setup_sheet() {
    let folder = tempfile::tempdir().unwrap();
    for dialect in DIALECTS {
        let reported = posted(folder.path(), &wave(), &on_bc(dialect, "part.nc"));
        assert_eq!(reported["kept"], true, "{dialect}: {reported}");
        assert_eq!(reported["dialect"], *dialect);
        assert!(
            number(&reported["tip_bound"]) <= 0.01 && number(&reported["axis_bound"]) <= 0.05,
            "{reported}"
        );
        assert!(number(&reported["seconds"][1]) >= number(&reported["seconds"][0]));
        assert!(
            number(&reported["ratios_before"][1]) > 1.0,
            "the example asks for too much: {reported}"
        );
        let text = fs::read_to_string(folder.path().join("part.nc")).unwrap();
        assert!(text.lines().count() > 360, "{dialect}");
        let sheet = fs::read_to_string(folder.path().join("part.setup.txt")).unwrap();
        assert!(sheet.contains("tool length H1") && sheet.contains("120.0000"), "{sheet}");
    }
}

/// Posted again for the same machine and dialect, a program keeps its blocks and times; so does the third.
#[test]
fn a_program_that_is_posted_again_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    for method in ["optimal", "jerk"] {
        for dialect in DIALECTS.into_iter().filter(|dialect| *dialect != "apt") {
            let mut input = wave();
            let mut reported = Vec::new();
            for name in ["first.nc", "second.nc", "third.nc"] {
                let mut arguments = on_bc(dialect, name);
                arguments.extend(["--feed", method]);
                reported.push(posted(folder.path(), &input, &arguments));
                input = folder.path().join(name);
            }
            for again in &reported[1..] {
                let at = |of: &Value, key: &str| number(&of[key][1]);
                assert_eq!(again["blocks"][1], reported[0]["blocks"][1], "{dialect} {method}");
                for key in ["seconds", "model_seconds"] {
                    let ratio = at(again, key) / at(&reported[0], key);
                    assert!((ratio - 1.0).abs() < 1e-3, "{dialect} {method} {key}: {ratio}");
                }
                assert_eq!(again["slowed"]["moves"], 0, "{dialect} {method}: {again}");
                assert_eq!(again["kept"], true, "{dialect} {method}: {again}");
            }
        }
    }
}

/// What smoothing made of a cut is left as it is at the second posting.
#[test]
fn a_smoothed_program_that_is_posted_again_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut changed = Vec::new();
    for dialect in DIALECTS.into_iter().filter(|dialect| *dialect != "apt") {
        let mut input = wave();
        let mut reported = Vec::new();
        for name in ["first.nc", "second.nc"] {
            let mut arguments = on_bc(dialect, name);
            arguments.push("--smooth");
            reported.push(posted(folder.path(), &input, &arguments));
            input = folder.path().join(name);
        }
        let ratio = |key: &str| {
            let [first, second] = [0, 1].map(|at: usize| number(&reported[at][key][1]));
            second / first
        };
        let ratios = ["blocks", "seconds", "model_seconds"].map(ratio);
        // On LinuxCNC fewer blocks are quicker, and the second posting finds some more to leave out.
        let [blocks, _, model] = ratios;
        let quicker = dialect == "linuxcnc" && (0.9..=1.0).contains(&blocks) && model <= 1.0;
        if !quicker && ratios.iter().any(|ratio| (ratio - 1.0).abs() > 1e-3) {
            changed.push((dialect, ratios));
        }
    }
    assert!(changed.is_empty(), "{changed:?}");
}

/// Feeds that the axes can follow stay as they are; those that they cannot are named.
#[test]
fn lines_that_are_slower_than_programmed_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let slow = fs::read_to_string(wave()).unwrap().replace("FEDRAT/3000.0", "FEDRAT/60.0");
    fs::write(folder.path().join("slow.cls"), slow).unwrap();
    let reported = posted(folder.path(), Path::new("slow.cls"), &on_bc("linuxcnc", "slow.nc"));
    let ratio = number(&reported["seconds"][1]) / number(&reported["seconds"][0]);
    assert!(ratio < 1.001, "{reported}");
    let reported = posted(folder.path(), &wave(), &on_bc("linuxcnc", "wave.nc"));
    assert!(
        number(&reported["slowed"]["moves"]) > 0.0
            && reported["slowed"]["worst"][1].as_f64() > Some(1.0)
    );
}

/// A and C cross at machine zero, limits so high that blocks run at their feed: the machine of the worked cut.
fn pencil_machine(folder: &Path) {
    let show = Command::new(env!("CARGO_BIN_EXE_trunnion"))
        .args(["machine", "show", "ac-trunnion", "--file"])
        .output()
        .unwrap();
    let replaced = |line: &str| {
        let key = line.split('=').next().unwrap_or_default().trim();
        match key {
            "point" => "point = [0.0, 0.0, 0.0]".to_owned(),
            "acc" | "jerk" => format!("{key} = 1e12"),
            "limits" => "limits = [-900.0, 900.0]".to_owned(),
            _ => line.to_owned(),
        }
    };
    let shown = String::from_utf8(show.stdout).unwrap();
    let text = shown.lines().map(replaced).collect::<Vec<_>>().join("\n");
    fs::write(folder.join("pencil.toml"), text).unwrap();
}

/// The cut of `fixtures/dialects`, computed by hand: blocks of every dialect.
#[test]
fn the_worked_cut_is_written_as_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    pencil_machine(folder.path());
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/dialects");
    let cut = fixtures.join("cut.cls");
    let wanted: Value =
        serde_json::from_str(&fs::read_to_string(fixtures.join("blocks.json")).unwrap()).unwrap();
    for dialect in DIALECTS {
        let arguments = [
            "-m",
            "pencil.toml",
            "-d",
            dialect,
            "-o",
            "cut.nc",
            "--origin=0,0,80",
            "--tool-length=150",
            "--tolerance=1,1",
        ];
        posted(folder.path(), &cut, &arguments);
        let text = fs::read_to_string(folder.path().join("cut.nc")).unwrap();
        for line in wanted[dialect].as_array().unwrap() {
            let line = line.as_str().unwrap();
            assert!(
                text.lines().any(|found| says(found, line)),
                "{dialect}: no {line:?} in\n{text}"
            );
        }
    }
}

/// Time on `LinuxCNC` of the wave at a feed \[s\]: what `post` states, and what `check` finds in the text.
fn times_on_linuxcnc(feed: &str) -> [f64; 2] {
    let folder = folder();
    let text = fs::read_to_string(wave()).unwrap().replace("FEDRAT/3000.0", feed);
    fs::write(folder.path().join("wave.cls"), text).unwrap();
    let reported = posted(folder.path(), Path::new("wave.cls"), &on_bc("linuxcnc", "wave.ngc"));
    // From right above, the way down runs straight on into the first cut, and blends with it by an amount that depends
    // on the feed. From elsewhere there is a corner.
    let written = fs::read_to_string(folder.path().join("wave.ngc")).unwrap();
    let above = |line: &&str| line.starts_with("G53 G0 X");
    assert_eq!(written.lines().filter(above).count(), 1);
    let from_elsewhere: Vec<&str> = written.lines().filter(|line| !above(line)).collect();
    fs::write(folder.path().join("wave.ngc"), from_elsewhere.join("\n")).unwrap();
    let mut arguments = vec!["check", "wave.ngc", "--json", "--machine", "bc-trunnion"];
    arguments.extend(["--part", "patch.json", "--cutter", "R=0,r=5"]);
    arguments.extend(["--tolerance", "5,5", "--grid", "5"]);
    arguments.extend(SETUP.iter().take(3));
    let output = trunnion(folder.path(), &arguments);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    [number(&reported["linuxcnc_duration"][1]), number(&found["control_model"]["seconds"])]
}

/// `post` counts from the first position on, `check` from machine zero: the ways there and back are the same at both
/// feeds, but for the corner from the way to the first cut. `LinuxCNC` passes its arc, here 0.1 mm long, at the slower
/// of both velocities: 0.1 mm at 5 mm/s are 20 ms, of which the test sees 16.
#[test]
fn check_finds_the_time_on_the_control_that_post_reported() {
    let [fast, slow] = ["FEDRAT/3000.0", "FEDRAT/300.0"].map(times_on_linuxcnc);
    let [reported, found] = [slow[0] - fast[0], slow[1] - fast[1]];
    assert!(reported > 10.0, "{reported} s");
    assert!((found - reported).abs() < 0.02, "{found} s, reported {reported} s");
    let way = fast[1] - fast[0];
    assert!(way > 0.0 && way < 4.0, "{way} s");
}

/// The table passes the check of setpoints against the machine; a second tool, a stream and a name that is an input are
/// refused.
#[test]
fn setpoints_of_a_cl_file_pass_the_check() {
    let folder = tempfile::tempdir().unwrap();
    let mut arguments = on_bc("linuxcnc", "wave.ngc");
    arguments.extend(["--motion", "motion.csv", "--period", "0.002"]);
    let reported = posted(folder.path(), &wave(), &arguments);
    let rows = reported["setpoints"]["rows"].as_u64().unwrap();
    let duration = number(&reported["setpoints"]["duration"]);
    let text = fs::read_to_string(folder.path().join("motion.csv")).unwrap();
    assert_eq!(text.lines().count() as u64, rows + 3);
    assert!((rows as f64 - 2.0 - duration / 0.002).abs() <= 1.0, "{rows} rows, {duration} s");
    // Within jerk limits and around corners of 5 um it takes longer than block by block.
    let planned = number(&reported["seconds"][1]) + number(&reported["rapid_seconds"]);
    assert!(duration > planned && duration < 6.0 * planned, "{duration} s, {planned} s");
    let output = trunnion(
        folder.path(),
        &["check", "motion.csv", "--machine", "bc-trunnion", "--period", "0.002"],
    );
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stdout));
    let refused = |input: &str, more: &[&str], part: &str| {
        let mut arguments = vec![input];
        arguments.extend(on_bc("linuxcnc", "other.ngc"));
        arguments.extend(more);
        let output = post(folder.path(), &arguments);
        let reported = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && reported.contains(part), "{reported}");
        assert!(!folder.path().join("other.ngc").exists());
    };
    refused("wave.ngc", &["--motion", "wave.ngc"], "overwritten");
    refused("-", &["--motion", "m.csv"], "twice");
    refused("wave.ngc", &["--motion", "m.csv", "--tool-length", "1=120"], "--tool");
}

#[test]
fn programmed_axes_beyond_travel_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let program = "G21 G90 G54 G0 X0 Y0 Z0 B0 C0\nG1 X10 B20 F100\nX20 B175\nM2\n";
    fs::write(folder.path().join("far.ngc"), program).unwrap();
    let arguments = ["far.ngc", "-m", "bc-trunnion", "-o", "out.nc", "--origin=-381,-254,-405"];
    let output = post(folder.path(), &arguments);
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{reported}");
    assert!(reported.contains("far.ngc:3: B = 175.0000 deg is outside its travel"), "{reported}");
    assert!(!folder.path().join("out.nc").exists());
}

/// A missing length moves all of Z: where that is refused, the length is named first, also before the first cut.
#[test]
fn a_missing_tool_length_is_named_before_what_it_leads_to() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |program: &str| {
        fs::write(folder.path().join("bare.ngc"), program).unwrap();
        let mut arguments = vec!["bare.ngc"];
        arguments.extend(on_bc("linuxcnc", "out.nc"));
        let output = post(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let before = |reported: &str, line: u32, at: u32| {
        let named = reported.find(&format!("bare.ngc:{line}: no tool length is in force"));
        let travel = reported.find(&format!("bare.ngc:{at}: Z = "));
        assert!(named.zip(travel).is_some_and(|(named, travel)| named < travel), "{reported}");
    };
    // In a cut, and already on the way to the first one, where the length would have brought it into travel.
    let head = "G21 G90 G54 G94\nT1 M6\nG0 X0 Y0 Z20 B0 C0\n";
    before(&refused(&format!("{head}G1 Z-60 F100\nM2\n")), 4, 4);
    before(&refused(&format!("{head}G0 Z-60\nG1 X10 F100\nM2\n")), 3, 4);
    // With a length in force it is no reason, even if a later line ends the length.
    let with =
        "G21 G90 G54 G94\nT1 M6\nG43 H1\nG0 X0 Y0 Z20 B0 C0\nG1 Z-900 F100\nG49\nG1 X3\nM2\n";
    let with = refused(with);
    assert!(with.contains("bare.ngc:5: Z = ") && !with.contains("no tool length"), "{with}");
}

/// M428 of `LinuxCNC` switches kinematics: without G43 no length counts, and the tip would be a tool's length too low.
#[test]
fn tcp_without_a_tool_length_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let warned = |length: &str| {
        let program = format!(
            "G21 G90 G54 G94\nT1 M6\n{length}S600 M3\nM428\nG0 X0 Y0 Z60 B0 C0\nG1 Z50 F600\nX9 B5\nG0 Z60\nM2\n"
        );
        fs::write(folder.path().join("bare.ngc"), program).unwrap();
        let mut arguments = vec!["bare.ngc"];
        arguments.extend(on_bc("linuxcnc", "out.ngc"));
        let output = post(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let bare = warned("");
    assert!(bare.contains("bare.ngc:6: no tool length is in force"), "{bare}");
    let with = warned("G43 H1\n");
    assert!(!with.contains("no tool length"), "{with}");
    // Setpoints read the input a second time, and have nothing to add.
    let mut arguments = vec!["bare.ngc", "--motion", "motion.csv"];
    fs::write(
        folder.path().join("bare.ngc"),
        "G21 G90 G54 G94\nT1 M6\nS600 M3\nG0 X0 Y0 Z60\nG1 Z50 F600\nM2\n",
    )
    .unwrap();
    arguments.extend(on_bc("linuxcnc", "out.ngc"));
    let output = post(folder.path(), &arguments);
    let reported = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{reported}");
    assert_eq!(reported.matches("no tool length is in force").count(), 1, "{reported}");
}

/// The same words; F, where both have it, up to a hundredth below: the machine starts from rest.
fn says(found: &str, wanted: &str) -> bool {
    let parts = |line: &str| -> (String, Option<f64>) {
        match line.rsplit_once(" F") {
            Some((rest, feed)) => (rest.to_owned(), feed.parse().ok()),
            None => (line.to_owned(), None),
        }
    };
    let (found, wanted) = (parts(found), parts(wanted));
    let feeds = match (found.1, wanted.1) {
        (Some(found), Some(wanted)) => found <= wanted * (1.0 + 1e-6) && found >= 0.99 * wanted,
        (None, Some(_)) => false,
        (_, None) => true,
    };
    found.0 == wanted.0 && feeds
}

#[test]
fn a_shop_changes_one_block_of_a_template() {
    let folder = tempfile::tempdir().unwrap();
    let printed = post(folder.path(), &["--print-template", "fanuc"]);
    let text = String::from_utf8(printed.stdout).unwrap();
    assert!(text.contains("{% block start %}") && text.contains("G43.4"), "{text}");
    let own = "{% extends \"fanuc\" %}{% block end %}G49\nM99\n{% endblock %}";
    fs::write(folder.path().join("shop.j2"), own).unwrap();
    let mut arguments = on_bc("fanuc", "part.nc");
    arguments.extend(["--template", "shop.j2"]);
    posted(folder.path(), &wave(), &arguments);
    let text = fs::read_to_string(folder.path().join("part.nc")).unwrap();
    assert!(text.ends_with("G49\nM99\n") && text.contains("G43.4 H1"), "{text}");
    fs::write(folder.path().join("shop.j2"), "{% block start %}\n{{ x").unwrap();
    let mut arguments = vec![wave().to_str().unwrap().to_owned()];
    arguments.extend(on_bc("fanuc", "other.nc").iter().map(|&one| one.to_owned()));
    arguments.extend(["--template".to_owned(), "shop.j2".to_owned()]);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let output = post(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(2));
    let reported = String::from_utf8(output.stderr).unwrap();
    assert!(reported.contains("shop.j2") && reported.contains("line 2"), "{reported}");
}

#[test]
fn a_pose_out_of_reach_is_reported_with_line_and_remedy_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let text = "UNITS/MM\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/100,MMPM\nGOTO/0,0,0,0,0,1\n\
                GOTO/2000,0,0,0,0,1\nFINI\n";
    fs::write(folder.path().join("far.cls"), text).unwrap();
    let mut arguments = vec!["far.cls"];
    arguments.extend(on_bc("fanuc", "far.nc"));
    let output = post(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(2));
    let reported = String::from_utf8(output.stderr).unwrap();
    assert!(reported.contains("far.cls:6: X = ") && reported.contains("--origin"), "{reported}");
    assert!(
        !folder.path().join("far.nc").exists() && !folder.path().join("far.setup.txt").exists()
    );
}

/// Axis positions for one tool length, posted for another machine and length: the same tip again.
#[test]
fn a_program_for_one_machine_becomes_one_for_another() {
    let folder = tempfile::tempdir().unwrap();
    posted(folder.path(), &wave(), &on_bc("g93", "old.nc"));
    let old = folder.path().join("old.nc");
    let reported = posted(
        folder.path(),
        &old,
        &[
            "-m",
            "ac-trunnion",
            "-d",
            "linuxcnc",
            "-o",
            "new.ngc",
            "--origin=0,0,-450",
            "--tool-length=80",
            "--from-machine=bc-trunnion",
            "--from-origin=-381,-254,-505",
            "--from-tool-length=120",
        ],
    );
    assert_eq!(reported["kept"], true, "{reported}");
    let text = fs::read_to_string(folder.path().join("new.ngc")).unwrap();
    // The last location of the example, as a tip of the other machine's program.
    let words = |text: &str| {
        let mut at = [f64::NAN; 3];
        for line in text.lines().filter(|line| line.starts_with('G') && !line.contains("G53")) {
            for word in line.split(' ') {
                for (slot, letter) in at.iter_mut().zip(["X", "Y", "Z"]) {
                    if let Some(value) = word.strip_prefix(letter) {
                        *slot = value.parse().unwrap();
                    }
                }
            }
        }
        at
    };
    let cl = fs::read_to_string(wave()).unwrap();
    let last = cl.lines().rfind(|line| line.starts_with("GOTO/")).unwrap();
    let last: Vec<f64> = last[5..].split(',').map(|word| word.parse().unwrap()).collect();
    let found = words(&text);
    for (found, wanted) in found.iter().zip(&last) {
        assert!((found - wanted).abs() < 1e-3, "{found:?} {last:?}");
    }
}

#[test]
fn smoothing_takes_less_time_and_reducing_fewer_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let loose = |out| {
        let mut arguments = on_bc("linuxcnc", out);
        arguments.pop();
        arguments.push("--tolerance=0.1,1");
        arguments
    };
    let plain = posted(folder.path(), &wave(), &loose("plain.ngc"));
    let fine = posted(folder.path(), &wave(), &on_bc("linuxcnc", "plain.ngc"));
    let cases = [
        ("--smooth", "model_seconds", on_bc("linuxcnc", "other.ngc"), &fine),
        ("--reduce", "blocks", loose("other.ngc"), &plain),
    ];
    for (option, better, mut arguments, plain) in cases {
        arguments.push(option);
        let reported = posted(folder.path(), &wave(), &arguments);
        assert_eq!(reported["kept"], true, "{option}: {reported}");
        let within = |bound: &str, most: &str| number(&reported[bound]) <= number(&reported[most]);
        assert!(within("tip_bound", "tip_tolerance") && within("axis_bound", "axis_tolerance"));
        assert!(number(&reported[better][1]) < number(&plain[better][1]), "{reported}\n{plain}");
    }
}

#[test]
fn a_program_with_two_tools_is_posted_tool_by_tool() {
    let folder = tempfile::tempdir().unwrap();
    let text = "G21 G90 G94 G54\nT1 M6\nG43 H1\nG0 X0 Y0 Z60 B0 C0\nG1 Z50 F600\nX10\nG0 Z90\n\
                T2 M6\nG43 H2\nG0 X0 Y20 Z60\nG1 Z55 F300\nX#<_hal[wide]>\n/ Y30\nG0 Z90\nM2\n";
    fs::write(folder.path().join("two.ngc"), text).unwrap();
    let input = folder.path().join("two.ngc");
    let output = post(
        folder.path(),
        &[
            &["two.ngc", "--set", "_hal[wide]=25", "--block-delete=false"],
            &on_bc("g93", "one.nc")[..],
        ]
        .concat(),
    );
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.code() == Some(2)
            && reported.contains("two.ngc:8:")
            && reported.contains("--tool"),
        "{reported}"
    );
    whole_program_of_two_tools(folder.path(), &input);
    for (tool, way, last) in [("1", 10.0 + 10.0, "X10"), ("2", 5.0 + 25.0, "X25")] {
        let mut arguments = on_bc("g93", "one.nc");
        arguments.extend(["--tool", tool, "--set", "_hal[wide]=25", "--block-delete=false"]);
        let reported = posted(folder.path(), &input, &arguments);
        assert!((number(&reported["length"]) - way).abs() < 1e-9, "{reported}");
        let text = fs::read_to_string(folder.path().join("one.nc")).unwrap();
        assert!(text.contains(&format!("T{tool} M6")) && text.contains(last), "{text}");
    }
    let mut none = vec![input.to_str().unwrap()];
    none.extend(on_bc("g93", "none.nc"));
    none.extend(["--tool", "9", "--set", "_hal[wide]=25", "--block-delete=false"]);
    let output = post(folder.path(), &none);
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.code() == Some(2) && reported.contains("which tools it calls"),
        "{reported}"
    );
    assert!(!folder.path().join("none.nc").exists());
    let reported = trunnion(
        folder.path(),
        &["inspect", "two.ngc", "--json", "--set", "_hal[wide]=25", "--block-delete=false"],
    );
    let reported: Value = serde_json::from_slice(&reported.stdout).unwrap();
    let seconds: Vec<f64> =
        reported["by_tool"].as_array().unwrap().iter().map(|own| number(&own["seconds"])).collect();
    // 10 mm down at 10 mm/s, 10 across; the second 5 down and 25 across at 5 mm/s.
    assert!((seconds[0] - 2.0).abs() < 1e-9 && (seconds[1] - 6.0).abs() < 1e-9, "{seconds:?}");
}

/// Both tools in one program, in every dialect: each with its own length, the change between, and read back; the
/// blocks are those of the tools posted alone.
fn whole_program_of_two_tools(folder: &Path, input: &Path) {
    let set = ["--set", "_hal[wide]=25", "--block-delete=false"];
    for dialect in DIALECTS {
        let mut whole = on_bc(dialect, "both.nc");
        whole.retain(|word| !word.starts_with("--tool-length"));
        let without_length = whole.iter().position(|word| *word == "120");
        if let Some(at) = without_length {
            whole.remove(at);
        }
        whole.extend(set);
        whole.extend(["--tool-length", "1=120", "--tool-length", "2=95"]);
        let reported = posted(folder, input, &whole);
        assert_eq!(reported["tools"], serde_json::json!([1, 2]), "{dialect}: {reported}");
        assert_eq!(reported["read_back"], true, "{dialect}: {reported}");
        let sheet = fs::read_to_string(folder.join("both.setup.txt")).unwrap();
        assert!(sheet.contains("H1") && sheet.contains("120.0000"), "{sheet}");
        assert!(sheet.contains("H2") && sheet.contains("95.0000"), "{sheet}");
        let both = fs::read_to_string(folder.join("both.nc")).unwrap();
        let mut lines = both.lines().map(bare);
        let mut last = String::new();
        for (tool, length) in [("1", "1=120"), ("2", "2=95")] {
            let mut alone = on_bc(dialect, "alone.nc");
            alone.retain(|word| !word.starts_with("--tool-length"));
            if let Some(at) = alone.iter().position(|word| *word == "120") {
                alone.remove(at);
            }
            alone.extend(set);
            alone.extend(["--tool-length", length, "--tool", tool]);
            posted(folder, input, &alone);
            let alone = fs::read_to_string(folder.join("alone.nc")).unwrap();
            let cuts = alone
                .lines()
                .map(bare)
                .filter(|line| line.contains('F') && line.contains(char::is_numeric));
            for line in cuts.filter(|line| {
                ["G1", "X", "L ", "LN", "GOTO"].iter().any(|of| line.starts_with(of))
            }) {
                // The retract behind the tool before is the one in front of this.
                if last == line {
                    continue;
                }
                assert!(lines.any(|other| other == line), "{dialect}, tool {tool}: {line}\n{both}");
                line.clone_into(&mut last);
            }
        }
    }
}

/// A line without its number.
fn bare(line: &str) -> &str {
    line.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start()
}

/// A tool that the control's table has otherwise is in the summary, and the exit code is that of a broken limit.
#[test]
fn a_tool_table_with_another_length_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    posted(folder.path(), &wave(), &on_bc("linuxcnc", "wave.ngc"));
    let arguments =
        [&["wave.ngc", "--json", "--tool-table", "tools.tbl"], &on_bc("linuxcnc", "again.ngc")[..]];
    for (length, code) in [("120", 0), ("130", 1)] {
        fs::write(folder.path().join("tools.tbl"), format!("T1 P1 Z{length} D20\n")).unwrap();
        let output = post(folder.path(), &arguments.concat());
        assert_eq!(output.status.code(), Some(code), "{}", String::from_utf8_lossy(&output.stderr));
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
        let found = summary["contradictions"].as_array().map_or(0, Vec::len);
        assert_eq!(
            (found, summary["kept"].as_bool()),
            (usize::from(code == 1), Some(code == 0)),
            "{summary}"
        );
        assert!(folder.path().join("again.ngc").is_file());
    }
}
