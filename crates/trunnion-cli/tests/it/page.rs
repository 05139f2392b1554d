//! Files in memory, as a page has them, give what the command line gives: byte for byte, word for word.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary::{folder, trunnion};
use std::fs;
use std::path::Path;
use std::process::Output;
use trunnion::types::Silent;
use trunnion_web::{Engine, PageAnswer};

/// An engine with files of a folder, under the same names.
fn engine(folder: &Path, names: &[&str]) -> Engine {
    let mut engine = Engine::default();
    for name in names {
        engine.insert(name, fs::read(folder.join(name)).unwrap());
    }
    engine
}

/// Asserts that both ended alike, and wrote the same files.
fn assert_same(engine: &Engine, answer: &PageAnswer, process: &Output, written: &Path) {
    let messages = String::from_utf8_lossy(&process.stderr);
    assert_eq!(Some(i32::from(answer.code)), process.status.code(), "{messages}");
    let mut names: Vec<String> = fs::read_dir(written)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let below = |file: &String| Path::new(file).file_name().unwrap().to_str().unwrap().to_owned();
    assert_eq!(answer.files.iter().map(below).collect::<Vec<_>>(), names);
    for (file, name) in answer.files.iter().zip(&names) {
        let expected = fs::read(written.join(name)).unwrap();
        let same = engine.file(file) == Some(&expected[..]);
        assert!(same, "{name} differs from that of the command line");
    }
}

/// Runs a job in a folder both ways.
fn same_run(folder: &Path, job: &str, names: &[&str]) {
    let out = tempfile::tempdir().unwrap();
    let process = trunnion(folder, &["run", job, "-o", out.path().to_str().unwrap()]);
    let mut engine = engine(folder, names);
    let answer = engine.run(job, &Silent);
    assert_same(&engine, &answer, &process, out.path());
}

#[test]
fn a_run_gives_the_same_files() {
    // The examples take minutes here: the gate compares them in an optimised build (`in_memory` of trunnion-web).
    let folder = folder();
    same_run(folder.path(), "job.toml", &["job.toml", "patch.json", "machine.toml"]);
}

#[test]
fn files_of_other_folders_are_found() {
    let folder = folder();
    let folder = folder.path();
    let job = fs::read_to_string(folder.join("job.toml")).unwrap();
    fs::create_dir_all(folder.join("jobs/one")).unwrap();
    let moved =
        job.replace("patch.json", "../../patch.json").replace("machine.toml", "bc-trunnion");
    fs::write(folder.join("jobs/one/job.toml"), moved).unwrap();
    same_run(folder, "jobs/one/job.toml", &["jobs/one/job.toml", "patch.json"]);
}

#[test]
fn a_check_gives_the_same_files_and_its_program_has_a_timeline() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(trunnion(folder, &["run", "job.toml"]).status.code(), Some(0));
    let program = fs::read_to_string(folder.join("out/program.linuxcnc.ngc")).unwrap();
    // One pass is cut a millimetre too deep.
    let deep = program.replace(" Z-", " Z-1");
    assert_ne!(deep, program);
    fs::write(folder.join("deep.ngc"), deep).unwrap();
    let process = trunnion(folder, &["check", "deep.ngc", "--job", "job.toml", "-o", "checked"]);
    let names = ["job.toml", "patch.json", "machine.toml", "deep.ngc"];
    let mut engine = engine(folder, &names);
    let options = ["deep.ngc", "--job", "job.toml"].map(str::to_owned);
    let answer = engine.check(&options, &Silent);
    assert_eq!(answer.code, 1, "{:?}", answer.messages);
    assert_same(&engine, &answer, &process, &folder.join("checked"));

    let timeline = engine.timeline(&options).unwrap();
    let count = timeline.times.len();
    assert!(count > 100 && timeline.lines.len() == count && timeline.kinds.len() == count);
    assert_eq!((timeline.axes.len(), timeline.poses.len()), (5 * count, 6 * count));
    assert!(timeline.times.is_sorted() && timeline.lines.is_sorted());
    let duration = json(&engine, "checked/summary.json")["duration"].as_f64();
    if let Some(duration) = duration {
        assert!((timeline.times.last().unwrap() - duration).abs() < 1e-6);
    }
}

fn json(engine: &Engine, name: &str) -> serde_json::Value {
    serde_json::from_slice(engine.file(name).unwrap()).unwrap()
}

#[test]
fn faults_have_the_words_of_the_command_line() {
    let folder = folder();
    let folder = folder.path();
    let job = fs::read_to_string(folder.join("job.toml")).unwrap();
    let wrong = [
        ("key.toml", job.replace("total = ", "totl = ")),
        ("part.toml", job.replace("patch.json", "gone.json")),
        ("machine.toml.toml", job.replace("machine.toml", "bc-trunion")),
        ("syntax.toml", job.replace("[tool]", "[tool")),
        ("empty.toml", String::new()),
        ("reach.toml", job.replace("[-381, -254, -505]", "[4000, 0, 0]")),
    ];
    for (name, text) in wrong {
        fs::write(folder.join(name), text).unwrap();
        let process = trunnion(folder, &["run", name]);
        let mut engine = engine(folder, &[name, "patch.json", "machine.toml"]);
        let answer = engine.run(name, &Silent);
        assert_eq!(process.status.code(), Some(i32::from(answer.code)), "{name}");
        let words: String = answer.messages.iter().map(|line| format!("error: {line}\n")).collect();
        let said = String::from_utf8_lossy(&process.stderr).replace("nothing was written\n", "");
        assert_eq!(words, said, "{name}");
    }
    let process = trunnion(folder, &["check", "gone.ngc", "--job", "job.toml"]);
    let mut engine = engine(folder, &["job.toml", "patch.json", "machine.toml"]);
    let answer = engine.check(&["gone.ngc", "--job", "job.toml"].map(str::to_owned), &Silent);
    let said = String::from_utf8_lossy(&process.stderr);
    assert_eq!(format!("error: {}\nnothing was written\n", answer.messages.join("\n")), said);
}
