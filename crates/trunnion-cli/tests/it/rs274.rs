//! Programs for `LinuxCNC`, read by its own interpreter and run in its simulator where those are installed.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{outcome, root, trunnion};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A program on the path.
pub(crate) fn installed(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// Kinematics are switched by remapped codes, which a machine's own configuration has.
fn configuration(folder: &Path) {
    let here = folder.display();
    let remaps = ["428", "429"].map(|code| {
        let text = format!("o<m{code}> sub\no<m{code}> endsub [0]\nM2\n");
        fs::write(folder.join(format!("m{code}.ngc")), text).unwrap();
        format!("REMAP = M{code} modalgroup=10 ngc=m{code}\n")
    });
    let text = format!(
        "[EMC]\nVERSION = 1.1\n[RS274NGC]\nPARAMETER_FILE = {here}/check.var\nSUBROUTINE_PATH = {here}\n{}\
         [TRAJ]\nCOORDINATES = X Y Z A B C\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree\n",
        remaps.concat()
    );
    fs::write(folder.join("check.ini"), text).unwrap();
    fs::write(folder.join("tool.tbl"), "T1 P1 Z50 D10 ;check\n").unwrap();
}

/// Lets the interpreter read a program; how many straight cuts it found.
fn read(interpreter: &Path, folder: &Path, program: &str) -> usize {
    let read = Command::new(interpreter)
        .args(["-g", "-i", "check.ini", "-t", "tool.tbl", program])
        .current_dir(folder)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&read.stderr).into_owned();
    assert!(read.status.success(), "{program}: {errors}");
    String::from_utf8_lossy(&read.stdout).matches("STRAIGHT_FEED").count()
}

/// Both examples, run with a tenth of the accuracy for a few seconds' work: the programs' names and texts.
pub(crate) fn examples(folder: &Path) -> Vec<(String, String)> {
    examples_with(folder, "")
}

/// As [`examples`], with more lines in the table `[output]` of both jobs.
pub(crate) fn examples_with(folder: &Path, output: &str) -> Vec<(String, String)> {
    let root = root();
    let of = |name: &str| {
        let example = root.join("examples").join(name);
        let mut job = fs::read_to_string(example.join("job.toml")).unwrap();
        let repository = format!("\"{}/", root.display());
        let part = format!("\"{}\"", example.join("part.step").display());
        for (from, to) in [
            ("\"../../", repository.as_str()),
            ("\"part.step\"", &part),
            ("\ntotal = 0.02 ", "\ntotal = 0.2 "),
            ("\ngouge = 0.002 ", "\ngouge = 0.02 "),
            ("\ngrid = 0.2 ", "\ngrid = 2.0 "),
            ("\n[output]\n", &format!("\n[output]\n{output}")),
        ] {
            job = job.replace(from, to);
        }
        assert!(job.contains("\ntotal = 0.2 ") && job.contains("\ngrid = 2.0 "), "{name}");
        let file = format!("{name}.toml");
        fs::write(folder.join(&file), job).unwrap();
        let (code, table, errors) = outcome(&trunnion(folder, &["run", &file, "-o", name]));
        assert_eq!(code, Some(0), "{table}{errors}");
        let program = format!("{name}/program.linuxcnc.ngc");
        let text = fs::read_to_string(folder.join(&program)).unwrap();
        (program, text)
    };
    ["bezier-patch", "step-face"].map(of).into()
}

/// Blocks of a program with feed: all of them say so.
fn feeds(text: &str) -> usize {
    text.lines().filter(|line| line.starts_with("G1 ")).count()
}

#[test]
fn linuxcnc_accepts_what_is_posted_for_it() {
    let Some(interpreter) = installed("rs274") else {
        eprintln!(
            "rs274 of LinuxCNC is not installed: its opinion of posted programs is not asked"
        );
        return;
    };
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    configuration(folder);
    let wave = root().join("examples/wave/wave.cls");
    for (dialect, more) in [("linuxcnc", "--reduce"), ("linuxcnc", "--smooth"), ("g93", "--smooth")]
    {
        let arguments = [
            "post",
            wave.to_str().unwrap(),
            "-m",
            "bc-trunnion",
            "--origin=-381,-254,-505",
            "--tool-length",
            "120",
            "-d",
            dialect,
            more,
            "-o",
            "program.ngc",
        ];
        assert!(trunnion(folder, &arguments).status.success());
        let moves = read(&interpreter, folder, "program.ngc");
        assert!(moves > 50, "{dialect} {more}: {moves} moves");
    }
}

#[test]
fn linuxcnc_accepts_the_programs_of_both_examples() {
    let Some(interpreter) = installed("rs274") else {
        eprintln!("rs274 of LinuxCNC is not installed: its opinion of the examples is not asked");
        return;
    };
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    configuration(folder);
    for (program, text) in examples(folder) {
        let (moves, wanted) = (read(&interpreter, folder, &program), feeds(&text));
        assert!(wanted > 100 && moves >= wanted, "{program}: {moves} moves of {wanted}");
    }
}

/// The simulator's kinematics have tool-centre-point control from the start: the codes that switch it are comments.
fn always_tcp(text: &str) -> String {
    let lines = text.lines().map(|line| match line.trim() {
        "M428" | "M429" => format!("({line})\n"),
        _ => format!("{line}\n"),
    });
    lines.collect()
}

/// With `TRUNNION_TORTURE`, as it takes minutes: `linuxcnc.rs` always runs the same programs with our own kinematics.
#[test]
fn linuxcnc_runs_the_programs_of_both_examples_with_its_kinematics() {
    if std::env::var_os("TRUNNION_TORTURE").is_none() {
        return;
    }
    let script = root().join("../shared/bench/linuxcnc/run_linuxcnc.sh");
    if installed("linuxcnc").is_none() || !script.is_file() {
        eprintln!(
            "LinuxCNC, or ../shared/bench/linuxcnc that runs it, is not there: the examples are not simulated"
        );
        return;
    }
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for (name, text) in examples(folder) {
        fs::write(folder.join("simulated.ngc"), always_tcp(&text)).unwrap();
        let ran = Command::new("bash")
            .arg(&script)
            .args(["simulated.ngc", "positions.csv", "xyzbc-trt"])
            .current_dir(folder)
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&ran.stderr).into_owned();
        let summary = String::from_utf8_lossy(&ran.stdout).into_owned();
        assert!(ran.status.success(), "{name}: {summary}{errors}");
        // A row each millisecond: the machine moved, and all five axes did.
        let rows = fs::read_to_string(folder.join("positions.csv")).unwrap();
        let column = |at: usize| {
            let value = move |line: &str| line.split(',').nth(at).unwrap().parse::<f64>().unwrap();
            let ends = rows
                .lines()
                .skip(1)
                .map(value)
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                    [low.min(value), high.max(value)]
                });
            ends[1] - ends[0]
        };
        assert!(rows.lines().count() > 5000, "{name}: {} rows", rows.lines().count());
        for axis in 1..=5 {
            assert!(column(axis) > 1.0, "{name}: joint {axis} moves by {}", column(axis));
        }
    }
}
