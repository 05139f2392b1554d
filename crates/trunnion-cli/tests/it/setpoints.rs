//! `trunnion check motion.csv` as a user meets it: what a run wrote is kept, with all columns or few; a row
//! that was altered and a limit that was lowered are found.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{folder, json, outcome, replace, trunnion};
use std::fs;
use std::path::Path;

/// The columns of one kind: `t` and so many behind it.
fn first_columns(text: &str, count: usize) -> String {
    let cut = |line: &str| {
        let fields = line.split(',').take(count + 1).collect::<Vec<_>>();
        if line.starts_with('#') { line.to_owned() } else { fields.join(",") }
    };
    text.lines().map(cut).collect::<Vec<_>>().join("\n") + "\n"
}

/// Changes a field of a line of the motion table.
fn alter(folder: &Path, line: usize, field: usize, by: f64) {
    let text = fs::read_to_string(folder.join("out/motion.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut fields: Vec<String> = lines[line - 1].split(',').map(str::to_owned).collect();
    fields[field] = format!("{:.10}", fields[field].parse::<f64>().unwrap() + by);
    lines[line - 1] = fields.join(",");
    fs::write(folder.join("altered.csv"), lines.join("\n")).unwrap();
}

#[test]
fn setpoints_of_a_run_are_kept_and_faults_in_them_are_found() {
    let folder = folder();
    let folder = folder.path();
    let (code, _, errors) = outcome(&trunnion(folder, &["run", "job.toml", "-o", "out"]));
    assert_eq!(code, Some(0), "{errors}");

    let job = ["--json", "check", "out/motion.csv", "--job", "job.toml", "-o", "checked"];
    let output = trunnion(folder, &job);
    let clean = json(&output);
    assert_eq!(output.status.code(), Some(0), "{clean:#}");
    assert_eq!(clean["derivatives"], 3);
    assert_eq!(clean["period"], 0.002);
    assert!(folder.join("checked/report.html").is_file());

    // Fewer columns, and the period found from the rows or said.
    replace(folder, "machine.toml", "servo_period", "# servo_period");
    let text = fs::read_to_string(folder.join("out/motion.csv")).unwrap();
    for count in [5, 10, 15] {
        fs::write(folder.join("few.csv"), first_columns(&text, count)).unwrap();
        let few = ["--json", "check", "few.csv", "--machine", "machine.toml"];
        let output = trunnion(folder, &few);
        let found = json(&output);
        assert_eq!(output.status.code(), Some(0), "{found:#}");
        assert_eq!((&found["period"], &found["rows"]), (&clean["period"], &clean["rows"]));
    }
    let wrong = ["check", "out/motion.csv", "--machine", "machine.toml", "--period", "0.001"];
    let (code, table, _) = outcome(&trunnion(folder, &wrong));
    assert_eq!(code, Some(1), "{table}");
    assert!(table.contains("line 5: 2.000000 ms after the row before"), "{table}");

    // A micrometre in one row.
    alter(folder, 1234, 2, 0.001);
    let altered = ["check", "altered.csv", "--machine", "machine.toml"];
    let (code, table, _) = outcome(&trunnion(folder, &altered));
    assert_eq!(code, Some(1), "{table}");
    assert!(table.contains("broken: Y jerk is ") && table.contains("at line 1234,"), "{table}");
    assert!(!table.contains("broken: X") && !table.contains("broken: Z"), "{table}");

    // A limit exceeded by two per mille.
    let axis = &clean["axes"][2];
    let ratio = axis["velocity"]["ratio"].as_f64().unwrap();
    let machine = fs::read_to_string(folder.join("machine.toml")).unwrap();
    let section = machine.find("[axis.Z]").unwrap();
    let at = section + machine[section..].find("vel ").unwrap();
    let end = at + machine[at..].find('\n').unwrap();
    let given: f64 = machine[at..end].split_whitespace().nth(2).unwrap().parse().unwrap();
    let lowered = format!("vel = {}\nrapid = {}", given * ratio / 1.002, given * ratio / 1.002);
    let machine = machine[..at].to_owned() + &lowered + &machine[end..];
    fs::write(folder.join("slower.toml"), machine).unwrap();
    let slower = ["check", "out/motion.csv", "--machine", "slower.toml"];
    let (code, table, errors) = outcome(&trunnion(folder, &slower));
    assert_eq!(code, Some(1), "{table}{errors}");
    let line = axis["velocity"]["line"].as_u64().unwrap();
    let found = format!("broken: Z velocity is 1.0020 times its limit at line {line}");
    assert!(table.contains(&found), "{table}");
}

#[test]
fn setpoints_need_a_machine_and_no_part() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("m.csv"), "t,X,Y,Z,C\n0,0,0,0,0\n").unwrap();
    for (arguments, start) in [
        (&["check", "m.csv"][..], "error: m.csv: setpoints need a machine"),
        (&["check", "m.csv", "--machine", "machine.toml"], "error: m.csv:1:1: column B is missing"),
        (
            &["check", "m.csv", "--machine", "machine.toml", "--part", "patch.json"],
            "error: m.csv: setpoints are checked against the machine alone",
        ),
        (
            &["check", "a.ngc", "--machine", "machine.toml", "--no-jerk"],
            "error: --period and --no-jerk go with a table of setpoints",
        ),
        (&["check", "a.ngc", "--machine", "machine.toml"], "error: --tool-length is missing"),
    ] {
        let (code, _, errors) = outcome(&trunnion(folder, arguments));
        assert_eq!(code, Some(2), "{errors}");
        assert!(errors.starts_with(start), "{errors}");
    }
    fs::write(folder.join("m.csv"), "t,X,Y,Z,C,B\n0,0,0,0,0,0\n0,1,0,0,0,0\n").unwrap();
    let arguments = ["check", "m.csv", "--machine", "machine.toml"];
    let (code, _, errors) = outcome(&trunnion(folder, &arguments));
    assert_eq!(code, Some(2), "{errors}");
    assert!(errors.starts_with("error: m.csv:3:1: t = 0 s comes after 0 s"), "{errors}");
}
