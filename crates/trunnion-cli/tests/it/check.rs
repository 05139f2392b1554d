//! `trunnion check` as a user meets it: an edited program is found out, a clean one is not.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{folder, json, outcome, root, trunnion};
use std::fs;
use std::path::{Path, PathBuf};

/// What stands for the job where the parts of it are named one by one.
const SAID: [&str; 16] = [
    "--machine",
    "machine.toml",
    "--part",
    "patch.json",
    "--cutter",
    "R=5,r=3",
    "--tool-length",
    "100",
    "--origin",
    "-381,-254,-505",
    "--rotation",
    "0,20,0",
    "--tolerance",
    "0.02,0.002",
    "--grid",
    "0.5",
];

/// A run's folder, and in it `edited.ngc`: one line in the middle goes 30 micrometres deeper.
fn planted() -> (tempfile::TempDir, PathBuf, usize) {
    let folder = folder();
    let (code, _, errors) = outcome(&trunnion(folder.path(), &["run", "job.toml", "-o", "out"]));
    assert_eq!(code, Some(0), "{errors}");
    let program = folder.path().join("out/program.linuxcnc.ngc");
    let text = fs::read_to_string(&program).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let cuts = |line: &String| line.starts_with("G1") && line.contains(" B") && line.contains(" Z");
    let at = (lines.len() / 2..lines.len()).find(|&at| cuts(&lines[at])).unwrap();
    let deeper = |word: &str| match word.strip_prefix('Z') {
        Some(z) => format!("Z{:.4}", z.parse::<f64>().unwrap() - 0.03),
        None => word.to_owned(),
    };
    lines[at] = lines[at].split(' ').map(deeper).collect::<Vec<_>>().join(" ");
    fs::write(folder.path().join("edited.ngc"), lines.join("\n")).unwrap();
    (folder, program, at + 1)
}

#[test]
fn an_edited_program_is_found_out_and_a_clean_one_is_not() {
    let (folder, _, number) = planted();
    let folder = folder.path();
    let clean = ["check", "out/program.linuxcnc.ngc", "--job", "job.toml", "-o", "clean"];
    let (code, table, errors) = outcome(&trunnion(folder, &clean));
    assert_eq!(code, Some(0), "{table}{errors}");
    assert!(table.contains("every tolerance and limit is kept"), "{table}");
    let mut files: Vec<String> = fs::read_dir(folder.join("clean"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, ["deviation.vtp", "report.html", "summary.json"]);

    let edited = ["--json", "check", "edited.ngc", "--job", "job.toml"];
    let output = trunnion(folder, &edited);
    let summary = json(&output);
    assert_eq!(output.status.code(), Some(1), "{summary:#}");
    let lowest = &summary["deviation"]["lowest"];
    let line = usize::try_from(lowest["line"].as_u64().unwrap()).unwrap();
    assert!(line == number || line == number + 1, "{lowest}, planted in {number}");
    assert!((-0.032..-0.02).contains(&lowest["height"].as_f64().unwrap()), "{lowest}");

    // The same said without the job, for the other dialect and for the locations.
    let mut whole = vec!["--json", "check", "edited.ngc"];
    whole.extend(SAID);
    let said = json(&trunnion(folder, &whole));
    assert_eq!(said["deviation"]["lowest"], *lowest);
    for program in ["out/program.g93.nc", "out/toolpath.cls"] {
        whole[2] = program;
        let output = trunnion(folder, &whole);
        let summary = json(&output);
        assert_eq!(output.status.code(), Some(0), "{program}: {summary:#}");
        assert_eq!(summary["axes"].as_array().unwrap().is_empty(), program.ends_with("cls"));
    }
    compare_vectors(folder, &mut whole);
}

/// The locations posted for controls that receive vectors leave what the locations do, and for one that receives angles
/// about that, as between two blocks it turns otherwise.
fn compare_vectors(folder: &Path, check: &mut [&str]) {
    let heights = |check: &[&str]| {
        let output = trunnion(folder, check);
        let summary = json(&output);
        assert_eq!(output.status.code(), Some(0), "{check:?}: {summary:#}");
        let of = |name: &str| summary["deviation"][name].as_f64().unwrap();
        ([of("gouge"), of("excess")], summary)
    };
    let (wanted, _) = heights(check);
    let posted = [
        ("siemens", "vectors.mpf", true),
        ("heidenhain", "vectors.h", true),
        ("fanuc-vector", "vectors.nc", true),
        ("siemens-axes", "angles.mpf", false),
    ];
    for (dialect, file, vectors) in posted {
        let post = ["post", "out/toolpath.cls", "-m", "machine.toml", "--tool-length", "100"];
        let place = ["--origin=-381,-254,-505", "--rotation=0,20,0", "-d", dialect, "-o", file];
        let (code, _, errors) = outcome(&trunnion(folder, &[&post[..], &place[..]].concat()));
        assert_eq!(code, Some(0), "{dialect}: {errors}");
        check[2] = file;
        let (found, summary) = if vectors {
            heights(check)
        } else {
            // Without times of its own, what F asks of the axes is broken here and there.
            let summary = json(&trunnion(folder, check));
            let of = |name: &str| summary["deviation"][name].as_f64().unwrap();
            ([of("gouge"), of("excess")], summary)
        };
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found - wanted).abs() < 5e-4, "{dialect}: {found} {wanted}");
        }
        assert_eq!(summary["axes"].as_array().unwrap().len(), 5, "{dialect}");
        assert_eq!(summary["choices"]["vectors"].as_u64().is_some(), vectors, "{dialect}");
        let warned =
            summary["warnings"].to_string().contains("the rotary axes are assumed to go to");
        assert_eq!(warned, vectors, "{dialect}");
    }
}

#[test]
fn tools_and_offsets_are_said_by_number() {
    let (folder, program, _) = planted();
    let folder = folder.path();
    let text = fs::read_to_string(program).unwrap();
    let clean = ["--json", "check", "out/program.linuxcnc.ngc", "--job", "job.toml"];
    let wanted = json(&trunnion(folder, &clean));
    assert!(text.contains("G54") && text.contains("\nM2"), "{text}");
    let other = text.replace("T1 M6", "T3 M6");
    fs::write(folder.join("other.ngc"), other.replace("G43 H1", "G43 H3")).unwrap();
    let renumbered = ["check", "other.ngc", "--job", "job.toml"];
    let (code, table, _) = outcome(&trunnion(folder, &renumbered));
    assert!(
        code == Some(0) && table.contains("the program calls tool 3, but the job describes tool"),
        "{table}"
    );
    assert!(table.contains("the check uses the tool of the job, diameter"), "{table}");
    // The control has another tool under that number: the check of this one says nothing of it.
    let with_table = [&renumbered[..], &["--tool-table", "tools.tbl"]].concat();
    for (row, expected) in [("T5 P5 Z77.7 D3\n", 0), ("T3 P3 Z77.7 D3\n", 1)] {
        fs::write(folder.join("tools.tbl"), row).unwrap();
        let (code, table, errors) = outcome(&trunnion(folder, &with_table));
        assert_eq!(code, Some(expected), "{row}{table}{errors}");
        let message = "tool 3 of the tool table has length 77.7 mm and diameter 3 mm";
        assert_eq!(table.contains(message), expected == 1, "{table}");
    }
    // The tool itself has another length in the table of the control.
    let row = "T1 P1 Z77.7 D20\n";
    fs::write(folder.join("tools.tbl"), row).unwrap();
    let table =
        ["check", "out/program.linuxcnc.ngc", "--job", "job.toml", "--tool-table", "tools.tbl"];
    let (code, table, errors) = outcome(&trunnion(folder, &table));
    assert!(
        code == Some(1) && table.contains("tool 1 of the tool table has length 77.7 mm"),
        "{table}{errors}"
    );
    // Only the call was renumbered: the length that counts is that of another tool.
    fs::write(folder.join("other.ngc"), other).unwrap();
    let (code, table, _) = outcome(&trunnion(folder, &renumbered));
    assert!(code == Some(1) && table.contains("with tool 3 and the length of H1"), "{table}");
    let two = text.replace("G54", "G55").replace("\nM2", "\nT2 M6\nG53 G0 Z0\nG0 G54 X0 Y0\nM2");
    fs::write(folder.join("two.ngc"), two).unwrap();
    let mut check = vec!["--json", "check", "two.ngc", "--job", "job.toml"];
    let refused = |check: &[&str]| {
        let (code, stdout, errors) = outcome(&trunnion(folder, check));
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{errors}");
        errors
    };
    assert!(refused(&check).contains("tool 2 after tool 1"), "{}", refused(&check));
    check.extend(["--cutter", "2=R=2,r=1", "--tool-length", "2=80"]);
    assert!(refused(&check).contains("--offset G55=X,Y,Z"), "{}", refused(&check));
    check.extend(["--offset", "G55=G54"]);
    let output = trunnion(folder, &check);
    let summary = json(&output);
    assert_eq!(output.status.code(), Some(0), "{summary:#}");
    let lowest = |of: &serde_json::Value| {
        let lowest = &of["deviation"]["lowest"];
        (lowest["line"].as_u64(), lowest["height"].as_f64().unwrap())
    };
    let ((line, height), (wanted_line, wanted)) = (lowest(&summary), lowest(&wanted));
    assert!(line == wanted_line && (height - wanted).abs() < 1e-8, "{height} {wanted}");
    // Before the first tool, behind it up to above the start, and behind the second.
    assert_eq!(summary["tool_changes"]["count"], 2);
    assert_eq!(summary["tool_changes"]["unmeasured"], 6, "{summary:#}");
    assert!(
        summary["warnings"]
            .to_string()
            .contains("is not known until the program commands all three"),
        "{summary:#}"
    );
    // The same by the job.
    let other = "[[verify.tool]]\nnumber = 2\nkind = \"bull\"\nmajor_radius = 2\nminor_radius = 1\nlength = 80\n";
    let job = fs::read_to_string(folder.join("job.toml")).unwrap();
    fs::write(folder.join("tools.toml"), job + other).unwrap();
    let by_job = ["--json", "check", "two.ngc", "--job", "tools.toml", "--offset", "G55=G54"];
    assert_eq!(json(&trunnion(folder, &by_job)), summary);
    check.extend(["--cutter", "R=5,r=3"]);
    assert!(
        refused(&check).contains("--job describes the tool already; a further one needs a number")
    );
}

#[test]
fn bad_input_writes_nothing_and_tells_all() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("arc.ngc"), "G21 G90 G94 G54\nG2 X1 I1 F100\nG1 Q\nM2\n").unwrap();
    let mut arguments = vec!["check", "arc.ngc", "-o", "out"];
    arguments.extend(SAID);
    let (code, stdout, errors) = outcome(&trunnion(folder, &arguments));
    assert_eq!((code, stdout.as_str()), (Some(2), ""), "{errors}");
    assert!(errors.contains("arc.ngc:2:") && errors.contains("arc.ngc:3:"), "{errors}");
    assert!(!folder.join("out").exists());
    fs::write(folder.join("skip.ngc"), "G21 G90 G94 G54\n/G0 X#500\nM2\n").unwrap();
    arguments[1] = "skip.ngc";
    let (code, _, errors) = outcome(&trunnion(folder, &arguments));
    assert_eq!(code, Some(2), "{errors}");
    assert!(errors.contains("skip.ngc:2:1: block delete"), "{errors}");
    assert!(errors.contains("--block-delete true, or false"), "{errors}");
    arguments.extend(["--block-delete", "true", "--set", "500=-381"]);
    let (code, _, errors) = outcome(&trunnion(folder, &arguments));
    assert_eq!(code, Some(1), "{errors}");
    let missing =
        ["check", "arc.ngc", "--part", "none.json", "--cutter", "R=5,r=-3", "--tolerance", "1,1"];
    let (code, _, errors) = outcome(&trunnion(folder, &missing));
    assert_eq!(code, Some(2), "{errors}");
    assert!(errors.contains("none.json") && errors.contains("minor radius"), "{errors}");
}

/// Faults of what a job or the command line names are reported where they are named.
#[test]
fn what_cannot_be_worked_with_is_reported_at_its_place() {
    let folder = folder();
    let folder = folder.path();
    let job = fs::read_to_string(folder.join("job.toml")).unwrap();
    let place = |text: &str, key: &str| {
        let line = text.lines().position(|line| line.starts_with(key)).unwrap();
        format!("job.toml:{}:", line + 1)
    };
    fs::write(folder.join("moves.cls"), MOVES).unwrap();
    let refused = |more: &[&str]| {
        let all = [&["check", "moves.cls", "--job", "job.toml"], more].concat();
        let (code, _, errors) = outcome(&trunnion(folder, &all));
        assert_eq!(code, Some(2), "{errors}");
        errors
    };
    let missing = job.replace("patch.json", "patsch.json").replace("machine.toml", "maschine.toml");
    fs::write(folder.join("job.toml"), &missing).unwrap();
    let errors = refused(&[]);
    for (name, at) in [("maschine.toml", "[machine]"), ("patsch.json", "[part]")] {
        let file = missing.lines().skip_while(|line| *line != at).position(|l| l.contains(name));
        let first = missing.lines().position(|line| line == at).unwrap();
        let wanted = format!("job.toml:{}:8: ", first + file.unwrap() + 1);
        assert!(errors.contains(&wanted) && errors.contains(name), "{wanted}\n{errors}");
    }
    let solid = "[stock]\nkind = \"box\"\nmin = [-20, -20, -20]\nmax = [20, 20, 5]\n";
    let fine = format!("{job}stock_cell = 0.001\n{solid}");
    let at = job.lines().position(|line| line == "[verify]");
    let fine = at.map_or_else(|| format!("{job}[verify]\nstock_cell = 0.001\n{solid}"), |_| fine);
    fs::write(folder.join("job.toml"), &fine).unwrap();
    let wanted = place(&fine, "stock_cell");
    assert!(refused(&[]).contains(&wanted), "{wanted}\n{}", refused(&[]));
    let errors = refused(&["--stock-cell", "0.002"]);
    assert!(errors.contains("--stock-cell 0.002: the solid would have"), "{errors}");
    let (code, _, errors) = outcome(&trunnion(folder, &["run", "job.toml", "--dry-run"]));
    assert!(code == Some(2) && errors.contains(&wanted), "{errors}");
    fs::write(folder.join("job.toml"), job).unwrap();
    for (text, wanted) in [
        ("T1 M6\nG0 X0\n  T2 M6\nM2\n", "p.ngc:3: tool 2 after tool 1"),
        ("G21 G90 G94\n N7 G55 G0 X0\nM2\n", "p.ngc:2:12: work offset G55"),
        ("G21 G90\nG0 X0\n   M98 P12\nM2\n", "p.ngc:3:"),
        ("G21 G90\nG0 X0\n o<a> call\nM2\n", "p.ngc:3:2: subprogram a is not in the file"),
    ] {
        fs::write(folder.join("p.ngc"), text).unwrap();
        let (code, _, errors) = outcome(&trunnion(
            folder,
            &["check", "p.ngc", "--job", "job.toml", "--dialect", "linuxcnc"],
        ));
        assert!(code == Some(2) && errors.contains(wanted), "{wanted}\n{errors}");
    }
}

/// A tool that touches the face, and one that is 0.3 um too deep.
#[test]
fn a_gouge_tolerance_of_nothing_allows_what_rounding_makes() {
    let folder = folder();
    let folder = folder.path();
    let flat = r#"{"degree":[1,1], "knots":[[0,0,1,1],[0,0,1,1]],
        "points":[[[-20,-5,-5],[-20,5,-5]],[[20,-5,-5],[20,5,-5]]]}"#;
    fs::write(folder.join("flat.json"), flat).unwrap();
    let check = |depth: &str, tolerance: &str| {
        fs::write(folder.join("moves.cls"), MOVES.replace(",-5,", depth)).unwrap();
        let all = ["check", "moves.cls", "--part", "flat.json", "--cutter", "R=5,r=3,L=60"];
        outcome(&trunnion(folder, &[&all[..], &["--tolerance", tolerance, "--grid", "1"]].concat()))
    };
    for (depth, kept) in [(",-5,", 0), (",-5.00005,", 0), (",-5.0003,", 1)] {
        let (code, table, errors) = check(depth, "0.2,0");
        assert_eq!(code, Some(kept), "{depth}: {table}{errors}");
        assert!(
            table.contains("only gouges deeper than 0.0001 mm are reported, instead of 0 mm"),
            "{table}"
        );
        assert!(table.contains("gouge 0.0001 mm"), "{table}");
    }
    let wrong = ["check", "moves.cls", "--part", "flat.json", "--cutter", "R=5,r=3,L=60", "--flip"];
    let (code, _, errors) =
        outcome(&trunnion(folder, &[&wrong[..], &["--tolerance", "0.2,0.01"]].concat()));
    assert!(code == Some(2) && errors.contains("from behind, at 25 of 25 points"), "{errors}");
    // A comment in another character set.
    let foreign = [b"$$ Gr\xf6\xdfe\n", MOVES.as_bytes()].concat();
    fs::write(folder.join("foreign.cls"), foreign).unwrap();
    let all = ["check", "foreign.cls", "--part", "flat.json", "--cutter", "R=5,r=3,L=60"];
    let more = ["--tolerance", "0.2,0.01", "--grid", "1"];
    let (code, table, errors) = outcome(&trunnion(folder, &[&all[..], &more[..]].concat()));
    assert_eq!(code, Some(0), "{table}{errors}");
    for wrong in ["0,0", "0.02,-0.001", "-0.02,0.001", "1e9,1", "0.02,1e9"] {
        let (code, _, errors) = check(",-5,", wrong);
        assert!(code == Some(2) && errors.contains("such as 0.02,0.002"), "{wrong}: {errors}");
    }
}

/// A flat part at the bottom of a pocket of one pass; line 6 runs through the stock at rapid speed, and it and all
/// after it into the clamp.
const MOVES: &str = "UNITS/MM
MULTAX/ON
RAPID
GOTO/-30,0,20,0,0,1
RAPID
GOTO/30,0,-4,0,0,1
FEDRAT/1000,MMPM
GOTO/30,0,-5,0,0,1
GOTO/-30,0,-5,0,0,1
FINI
";

#[test]
fn stock_is_cut_and_collisions_are_reported_with_their_lines() {
    let folder = folder();
    let folder = folder.path();
    let flat = r#"{"degree":[1,1], "knots":[[0,0,1,1],[0,0,1,1]],
        "points":[[[-20,-15,-5],[-20,15,-5]],[[20,-15,-5],[20,15,-5]]]}"#;
    fs::write(folder.join("flat.json"), flat).unwrap();
    fs::write(folder.join("moves.cls"), MOVES).unwrap();
    let check = |more: &[&str]| {
        let mut all = vec!["--json", "check", "moves.cls", "--part", "flat.json"];
        all.extend(["--cutter", "R=5,r=3,L=60", "--tolerance", "9,0.01", "--grid", "1"]);
        all.extend(more);
        trunnion(folder, &all)
    };
    let stock = "box:-20,-15,-10,20,15,0";
    let fixture = "box:25,-20,-10,35,-7,10";
    let output = check(&["--stock", stock, "--fixture", fixture, "-o", "out"]);
    let (code, _, errors) = outcome(&output);
    assert_eq!(code, Some(1), "{errors}");
    let stock = json(&output)["stock"].clone();
    // 40 mm of a slot 5 mm deep, 16 mm wide, with its rounding of 3 mm.
    let exact = 40.0 * (16.0 * 5.0 - (2.0 - 0.5 * std::f64::consts::PI) * 9.0);
    let removed = stock["removed"].as_f64().unwrap();
    assert!((removed / exact - 1.0).abs() < 1e-3, "{removed} {exact}");
    let hits = stock["collisions"].as_array().unwrap();
    let of = |kind: &str| hits.iter().filter(|hit| hit["kind"] == kind).collect::<Vec<_>>();
    assert_eq!(of("rapid").len(), 1, "{hits:?}");
    assert_eq!(of("rapid")[0]["line"], 6);
    let clamped: Vec<_> = of("fixture").iter().map(|hit| hit["line"].clone()).collect();
    assert_eq!(clamped, [6, 8, 9], "{hits:?}");
    assert!((of("fixture")[1]["depth"].as_f64().unwrap() - 1.0).abs() < 0.01, "{hits:?}");
    let left = trunnion::import::stl::read(&fs::read(folder.join("out/stock.stl")).unwrap());
    assert!(left.unwrap().triangles.len() > 1000);
    let (code, _, errors) = outcome(&check(&["--clearance", "1"]));
    assert!(code == Some(2) && errors.contains("--fixture"), "{errors}");
    let (code, _, errors) = outcome(&check(&["--stock", "box:1,2,3"]));
    assert!(code == Some(2) && errors.contains("box:-50,-30,-20,50,30,0"), "{errors}");
}

#[test]
fn fixtures_are_kept_clear_of_without_stock() {
    let folder = folder();
    let folder = folder.path();
    let flat = r#"{"degree":[1,1], "knots":[[0,0,1,1],[0,0,1,1]],
        "points":[[[-20,-5,-5],[-20,5,-5]],[[20,-5,-5],[20,5,-5]]]}"#;
    fs::write(folder.join("flat.json"), flat).unwrap();
    fs::write(folder.join("moves.cls"), MOVES).unwrap();
    let check = |more: &[&str]| {
        let mut all = vec!["--json", "check", "moves.cls", "--part", "flat.json"];
        all.extend(["--cutter", "R=5,r=3,L=60", "--tolerance", "0.1,0.01", "--grid", "1"]);
        all.extend(["--fixture", "cyl:0,58,-20,50,40"]);
        all.extend(more);
        trunnion(folder, &all)
    };
    // The tool's side at y = 8 touches a cylinder that begins there; 0.3 um less is within the tolerance.
    let near = |output| json(output)["fixtures"]["near"].as_array().unwrap().clone();
    let touched = check(&[]);
    assert_eq!(near(&touched), [] as [serde_json::Value; 0]);
    let least = json(&touched)["fixtures"]["least"].clone();
    assert!(least["distance"].as_f64().unwrap().abs() < 1e-3, "{least}");
    assert_eq!(least["fixture"], "cyl:0,58,-20,50,40");
    assert_eq!(outcome(&touched).0, Some(0));
    let clear = check(&["--fixture", "box:-5,-20,-9,5,-10,9", "--clearance", "3"]);
    assert_eq!(outcome(&clear).0, Some(1));
    let lines: Vec<_> = near(&clear).iter().map(|near| near["line"].clone()).collect();
    // The rapid move before it passes at an angle; the descent stays at x = 30.
    assert!(lines.contains(&9.into()), "{lines:?}");
    assert_eq!(outcome(&check(&["--clearance", "0"])).0, Some(0));
    let (code, _, errors) = outcome(&check(&["--clearance", "-1"]));
    assert!(code == Some(2) && errors.contains("0 or a number above 0 is expected"), "{errors}");
    assert!(json(&clear)["failures"].to_string().contains("nearer than 3 mm"));
}

/// A box of 20 mm with a closed hollow, as a STEP file.
#[test]
fn stock_and_fixtures_are_read_from_step_files() {
    let folder = folder();
    let folder = folder.path();
    let flat = r#"{"degree":[1,1], "knots":[[0,0,1,1],[0,0,1,1]],
        "points":[[[-20,-5,-5],[-20,5,-5]],[[20,-5,-5],[20,5,-5]]]}"#;
    fs::write(folder.join("flat.json"), flat).unwrap();
    fs::write(folder.join("moves.cls"), MOVES).unwrap();
    let step = root().join("fixtures/step/hollow.step");
    fs::copy(&step, folder.join("hollow.step")).unwrap();
    let check = |more: &[&str]| {
        let mut all = vec!["--json", "check", "moves.cls", "--part", "flat.json"];
        all.extend(["--cutter", "R=5,r=3,L=60", "--tolerance", "9,0.01", "--grid", "1"]);
        all.extend(more);
        json(&trunnion(folder, &all))
    };
    let whole = check(&["--stock", "hollow.step"]);
    let volume = |key: &str| whole["stock"][key].as_f64().unwrap();
    assert!((volume("removed") + volume("left") - 7760.0).abs() < 1e-6, "{}", whole["stock"]);
    assert_eq!(whole["chords"], serde_json::json!([{"solid": "stock", "chord": 0.01}]));
    // The tool runs through the middle of it; what triangles may be off is added.
    let hit = check(&["--fixture", "hollow.step", "--chord", "0.004"]);
    assert!(hit["fixtures"]["least"]["distance"].as_f64().unwrap() < -1.0, "{hit}");
    assert_eq!(hit["chords"], serde_json::json!([{"solid": "hollow.step", "chord": 0.004}]));
    let open = root().join("examples/step-face/part.step");
    let mut all = vec!["check", "moves.cls", "--part", "flat.json", "--cutter", "R=5,r=3,L=60"];
    all.extend(["--tolerance", "9,0.01", "--stock", open.to_str().unwrap()]);
    let (code, _, errors) = outcome(&trunnion(folder, &all));
    assert!(code == Some(2) && errors.contains("not closed"), "{errors}");
}

/// 100 mm at 50 mm/s, at rest behind a corner of 90 degrees that leaves 0.01 mm of room, and back to the start.
#[test]
fn the_time_with_the_planner_of_trunnion_is_predicted_on_request() {
    let folder = folder();
    let program = "G21 G90 G94 G40 G49 G17 G54\nG64 P0.01 Q0\nM3 S1000\nG53 G0 Z0\nG0 X-300 Y-200\nG1 X-200 F3000\n\
                   G1 Y-190\nM2\n";
    fs::write(folder.path().join("line.ngc"), program).unwrap();
    let check =
        ["check", "line.ngc", "--machine", "machine.toml", "--tool-length", "100", "--json"];
    let times = |more: &[&str]| {
        let output = trunnion(folder.path(), &[&check, more].concat());
        let (_, _, errors) = outcome(&output);
        assert!(errors.is_empty(), "{errors}");
        json(&output)["times"].clone()
    };
    assert!(times(&[]).get("linuxcnc_trunnion").is_none());
    let times = times(&["--control", "linuxcnc-trunnion"]);
    let [planned, predicted] =
        ["planned", "linuxcnc_trunnion"].map(|name| times[name].as_f64().unwrap());
    // The rapid move counts without ramps in the time of the program; three ramps and a slow corner add to it.
    assert!(predicted > planned + 0.1 && predicted < planned + 1.5, "{predicted} {planned}");
}

/// A block that the planner refuses is a warning with its line; verdict and exit code are those of everything else.
#[test]
fn a_program_without_a_predicted_time_is_checked_all_the_same() {
    let folder = folder();
    let folder = folder.path();
    let program = "G21 G90 G94 G40 G49 G17 G54\nG64 P0.01 Q0\nM3 S1000\nG53 G0 Z0\nG0 X-300 Y-200\nG1 X-200 F3000\n\
                   G1 X900\nG1 X-200\nM2\n";
    fs::write(folder.join("far.ngc"), program).unwrap();
    let check = |more: &[&str]| {
        let all = ["check", "far.ngc", "--machine", "machine.toml", "--tool-length", "100"];
        // The program has no G43.
        let all = [&all, &["--accept", "no-length"][..], more].concat();
        let (code, table, errors) = outcome(&trunnion(folder, &all));
        assert!(errors.is_empty(), "{errors}");
        let said = |line: &&str| line.contains("no time for --control linuxcnc-trunnion");
        (code, table.lines().find(said).map(str::to_owned), table)
    };
    let control = ["--control", "linuxcnc-trunnion"];
    let (code, warning, table) = check(&control);
    let warning = warning.unwrap();
    assert_eq!(code, Some(1), "{table}");
    assert!(warning.starts_with("warning: far.ngc:7: no time for"), "{warning}");
    let far = "X = 900.0000 mm is outside its travel [-762.0000, 0.0000] by 900.0000 mm";
    assert!(warning.contains(far) && warning.contains("--origin"), "{warning}");
    assert!(table.contains("broken: "), "{table}");
    assert!(!table.contains("stops, within every limit"), "{table}");
    let (code, warning, table) = check(&[&control[..], &["--accept", "travel"]].concat());
    assert!(code == Some(0) && warning.is_some(), "{table}");
    let (code, warning, _) = check(&[]);
    assert!(code == Some(1) && warning.is_none());

    fs::write(folder.join("moves.cls"), MOVES).unwrap();
    let mut all = vec!["check", "moves.cls", "--fixture", "box:50,50,50,60,60,60"];
    all.extend(["--cutter", "R=5,r=3,L=60", "--control", "linuxcnc-trunnion"]);
    let (code, table, errors) = outcome(&trunnion(folder, &all));
    assert_eq!(code, Some(0), "{table}{errors}");
    let said = "warning: moves.cls: no time for --control linuxcnc-trunnion: cutter locations";
    assert!(table.contains(said), "{table}");
    assert!(!outcome(&trunnion(folder, &all[..6])).1.contains("no time for"));

    fs::write(folder.join("motion.csv"), "t,X,Y,Z,B,C\n").unwrap();
    let mut all = vec!["check", "motion.csv", "--machine", "machine.toml", "--control"];
    for control in ["linuxcnc", "linuxcnc-trunnion"] {
        all.truncate(5);
        all.push(control);
        let (code, _, errors) = outcome(&trunnion(folder, &all));
        assert_eq!(code, Some(2), "{errors}");
        assert!(errors.contains("--control does not apply"), "{errors}");
    }
}

/// Two blocks in one direction and an arc behind a rapid move: `G61` goes on between the two, `G61.1` stops at every end, and
/// within the arc neither does.
#[test]
fn exact_stops_are_timed_as_the_planner_of_trunnion_makes_them() {
    let folder = folder();
    let times = |code: &str| {
        let program = format!(
            "G21 G90 G94 G40 G49 G17 G54\n{code}\nM3 S1000\nG53 G0 Z0\nG0 X-300 Y-200\nG1 X-250 F3000\nG1 X-200\nG3 X-180 Y-180 J20\nM2\n"
        );
        fs::write(folder.path().join("line.ngc"), program).unwrap();
        let mut all = vec!["check", "line.ngc", "--machine", "machine.toml", "--tool-length"];
        all.extend(["100", "--control", "linuxcnc-trunnion", "--json"]);
        let summary = json(&trunnion(folder.path(), &all));
        let time = &summary["planner_time"];
        (time["seconds"].as_f64().unwrap(), time["stops"].as_u64().unwrap())
    };
    let [(flowing, first), (stopping, second)] = ["G61", "G61.1"].map(times);
    // Ramps from 50 mm/s to rest and back.
    assert!(first == 3 && second == 4 && stopping > flowing + 0.05, "{flowing} {stopping}");
}
