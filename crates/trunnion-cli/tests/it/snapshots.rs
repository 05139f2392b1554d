//! Snapshots of what the command line prints and writes for the small fixture job.
//!
//! `UPDATE_EXPECT=1 cargo test -p trunnion-cli snapshots` writes them again; read the difference line by line.
//! Help texts have their snapshot in the reference page of the book.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;
use binary::{folder, stderr, trunnion};
use expect_test::{ExpectFile, expect_file};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Prints of a verb that must succeed with this exit code.
fn printed(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = trunnion(folder, arguments);
    assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// Keeps the first and last lines of a long text, and the number of those between.
fn ends(text: &str) -> String {
    const KEPT: usize = 30;
    let lines: Vec<&str> = text.lines().collect();
    let Some(between) = lines.len().checked_sub(2 * KEPT).filter(|&between| between > 0) else {
        return text.to_owned();
    };
    let head = lines[..KEPT].join("\n");
    let tail = lines[KEPT + between..].join("\n");
    format!("{head}\n[{between} lines]\n{tail}\n")
}

/// Replaces every number by `#`, except those that belong to a word: tables keep their layout and text.
fn masked(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(|c: char| c.is_ascii_digit()) {
        let in_word = rest[..at].chars().next_back().is_some_and(char::is_alphabetic);
        let length =
            rest[at..].find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len() - at);
        let (before, number) = (&rest[..at], &rest[at..at + length]);
        out.push_str(before);
        out.push_str(if in_word { number } else { "#" });
        rest = &rest[at + length..];
    }
    out.push_str(rest);
    // A number that needs another digit must not shift the snapshot.
    out.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ") + "\n").collect()
}

fn expect(file: &ExpectFile, text: &str) {
    file.assert_eq(text);
}

/// Masks the numbers that depend on the platform's rounding: keys stay, times and lengths become `"#"`.
fn mask_numbers(value: &mut Value) {
    match value {
        Value::Number(number) if number.is_f64() => *value = Value::from("#"),
        Value::Array(all) => all.iter_mut().for_each(mask_numbers),
        Value::Object(all) => all.values_mut().for_each(mask_numbers),
        _ => {}
    }
}

#[test]
fn a_run_prints_its_table_and_writes_programs_and_summary() {
    let folder = folder();
    let job = fs::read_to_string(folder.path().join("job.toml")).unwrap();
    let all = job.replace(
        "dialects = [\"linuxcnc\", \"g93\"]",
        "dialects = [\"linuxcnc\", \"fanuc-vector\", \"siemens\", \"heidenhain\"]",
    );
    assert_ne!(job, all);
    fs::write(folder.path().join("job.toml"), all).unwrap();
    let table = printed(folder.path(), &["run", "job.toml"], 0);
    expect(&expect_file!["snapshots/run.txt"], &masked(&table));
    let read = |name: &str| fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    let program = |name: &str| ends(&masked(&read(name)));
    expect(&expect_file!["snapshots/program.linuxcnc.txt"], &program("program.linuxcnc.ngc"));
    expect(
        &expect_file!["snapshots/program.fanuc-vector.txt"],
        &program("program.fanuc-vector.nc"),
    );
    expect(&expect_file!["snapshots/program.siemens.txt"], &program("program.siemens.mpf"));
    expect(&expect_file!["snapshots/program.heidenhain.txt"], &program("program.heidenhain.h"));
    let mut summary: Value = serde_json::from_str(&read("summary.json")).unwrap();
    mask_numbers(&mut summary);
    let text = serde_json::to_string_pretty(&summary).unwrap();
    expect(&expect_file!["snapshots/summary.json.txt"], &masked_files(&text));
    let check = ["check", "out/program.linuxcnc.ngc", "--job", "job.toml"];
    let table = printed(folder.path(), &check, 0);
    expect(&expect_file!["snapshots/check.txt"], &masked(&table));
}

/// Masks sizes and hashes of files, which follow every digit.
fn masked_files(text: &str) -> String {
    text.lines()
        .map(|line| match line.split_once(": ") {
            Some((key, _)) if key.contains("bytes") || key.contains("sha256") => {
                format!("{key}: \"#\"\n")
            }
            _ => format!("{line}\n"),
        })
        .collect()
}

#[test]
fn inspect_prints_the_faces() {
    let folder = folder();
    let table = printed(folder.path(), &["inspect", "patch.json"], 0);
    expect(&expect_file!["snapshots/inspect.txt"], &table);
}

#[test]
fn a_machine_is_described() {
    let folder = folder();
    let table = printed(folder.path(), &["machine", "show", "machine.toml"], 0);
    expect(&expect_file!["snapshots/machine-show.txt"], &table);
}
