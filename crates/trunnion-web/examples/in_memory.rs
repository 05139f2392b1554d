//! Runs jobs on files in memory, and compares every output with the one that `trunnion run` wrote beside the job.
//!
//! `cargo run --release -p trunnion-web --example in_memory -- examples/*/job.toml`, after the same runs of `trunnion`.

use std::error::Error;
use std::fs;
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};
use trunnion::files::job;
use trunnion::types::Silent;
use trunnion_web::{Engine, PageAnswer};

fn main() -> Result<(), Box<dyn Error>> {
    for job in std::env::args().skip(1) {
        let out = Path::new(&job).with_file_name("out");
        let (engine, answer) = in_memory(&job)?;
        let names = compare(&engine, &answer, &out)?;
        writeln!(stdout(), "{job}: {names} files are those of the command line, byte for byte")?;
    }
    Ok(())
}

/// Runs a job that has part and machine in files.
fn in_memory(path: &str) -> Result<(Engine, PageAnswer), Box<dyn Error>> {
    let text = fs::read_to_string(path)?;
    let file = job::parse(&text).map_err(|faults| format!("{faults:?}"))?;
    let mut engine = Engine::default();
    engine.insert(path, text.into_bytes());
    for name in [&file.part.file, &file.machine] {
        let place: PathBuf = Path::new(path).with_file_name(name);
        engine.insert(&place.to_string_lossy(), fs::read(&place)?);
    }
    let answer = engine.run(path, &Silent);
    if answer.code == 0 { Ok((engine, answer)) } else { Err(answer.messages.join("\n").into()) }
}

/// Compares every output; returns their number.
fn compare(engine: &Engine, answer: &PageAnswer, out: &Path) -> Result<usize, Box<dyn Error>> {
    let written = fs::read_dir(out)?.count();
    if written != answer.files.len() {
        return Err(format!("{}: {written} files, not {:?}", out.display(), answer.files).into());
    }
    for file in &answer.files {
        let name = Path::new(file).file_name().unwrap_or_default();
        if engine.file(file) != Some(&fs::read(out.join(name))?[..]) {
            return Err(format!("{}: {file} differs", out.display()).into());
        }
    }
    Ok(written)
}
