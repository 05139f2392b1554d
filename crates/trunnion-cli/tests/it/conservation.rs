//! Random programs from dialect to dialect and back: nothing is lost, nothing invented, and the check finds no fault.
//!
//! 20 programs by default; `just torture` sets `TRUNNION_TORTURE=1` for 200. `TRUNNION_TORTURE_SEED` repeats a run.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "the seed repeats a run")]

use crate::binary::{outcome, trunnion};
use crate::drawn_program::{Draw, DrawnProgram};
use crate::post::DIALECTS;
use serde_json::Value;
use std::fs;
use std::path::Path;

const PLACE: [&str; 2] = ["ac-trunnion", "--origin=-25,-50,-430"];

/// Lengths of tools 1 to 3, as arguments.
const LENGTHS: [&str; 3] = ["1=100", "2=80", "3=130"];

/// Number of programs, and the seed of the first.
fn run() -> (u64, u64) {
    let of = |name| std::env::var(name).ok();
    let count = if of("TRUNNION_TORTURE").is_some() { 200 } else { 20 };
    let seed = of("TRUNNION_TORTURE_SEED").and_then(|seed| seed.parse().ok()).unwrap_or(1);
    (count, seed)
}

/// A program of either kind, by turns.
fn drawn(seed: u64, index: u64) -> DrawnProgram {
    let draw = &mut Draw(seed.wrapping_mul(1_000_003).wrapping_add(index));
    if index.is_multiple_of(2) {
        DrawnProgram::three_axis(draw)
    } else {
        DrawnProgram::five_axis(draw)
    }
}

/// Flags for the lengths of the tools of a program.
fn lengths(tools: usize) -> Vec<&'static str> {
    match LENGTHS.get(..tools) {
        Some([_, _, ..]) => {
            LENGTHS[..tools].iter().flat_map(|length| ["--tool-length", *length]).collect()
        }
        _ => vec!["--tool-length", "100"],
    }
}

/// Posts a file; returns the summary.
fn posted(folder: &Path, [input, dialect, out]: [&str; 3], tools: usize) -> Value {
    let to = ["post", input, "--json", "-d", dialect, "-o", out, "-m"];
    let output = trunnion(folder, &[&to[..], &PLACE[..], &lengths(tools)[..]].concat());
    let (code, text, reported) = outcome(&output);
    assert_eq!(code, Some(0), "{input} to {dialect}: {reported}{text}");
    serde_json::from_str(&text).unwrap()
}

/// Lengths of cuts and of rapid moves \[mm\], and the tools, as read or as written.
fn motion(summary: &Value, of: &str) -> ([f64; 2], usize) {
    let count = &summary["motion"][of];
    let length = |kind: usize| count["length"][kind].as_f64().unwrap();
    ([length(1), length(0)], usize::try_from(count["tools"].as_u64().unwrap()).unwrap())
}

/// Time of the moves with feed, of the input or of the output \[s\].
fn seconds(summary: &Value, output: usize) -> f64 {
    summary["seconds"][output].as_f64().unwrap()
}

#[test]
fn programs_keep_lengths_tools_and_times_from_dialect_to_dialect_and_back() {
    let (count, seed) = run();
    println!("seed {seed}");
    let folder = tempfile::tempdir().unwrap();
    for index in 0..count {
        let DrawnProgram { text, tools, lengths, seconds: programmed, .. } = drawn(seed, index);
        let dialect = DIALECTS[usize::try_from(index / 2).unwrap() % DIALECTS.len()];
        let case = format!("seed {seed}, program {index}, {dialect}:\n{text}");
        fs::write(folder.path().join("drawn.ngc"), &text).unwrap();
        let there_name = if dialect == "apt" { "there.cls" } else { "there.nc" };
        let there = posted(folder.path(), ["drawn.ngc", dialect, there_name], tools);
        let back = posted(folder.path(), [there_name, "linuxcnc", "back.ngc"], tools);
        let (read, _) = motion(&there, "read");
        let near = |a: f64, b: f64, share: f64| (a - b).abs() <= share * a.abs() + 0.01;
        if let Some(own) = lengths {
            // Arcs are read as chords.
            assert!(
                (0..2).all(|kind| near(own[kind], read[kind], 1e-3)),
                "{own:?} {read:?} {case}"
            );
            let found = seconds(&there, 0);
            assert!(near(programmed, found, 1e-3), "{programmed} {found} {case}");
        }
        for (summary, of) in
            [(&there, "read"), (&there, "written"), (&back, "read"), (&back, "written")]
        {
            let (found, called) = motion(summary, of);
            assert!(
                (0..2).all(|kind| near(read[kind], found[kind], 1e-3)),
                "{of}: {read:?} {found:?} {case}"
            );
            assert_eq!(called, tools, "{of}: {case}");
            assert_eq!(summary["motion"]["conserved"], true, "{case}");
        }
        // Feeds are slow enough for the axes, so each program lasts as long as the first.
        for found in [seconds(&there, 1), seconds(&back, 1)] {
            assert!(near(seconds(&there, 0), found, 0.01), "{found} s: {case}");
        }
    }
}

#[test]
fn clean_programs_and_their_posts_pass_the_check() {
    let (count, seed) = run();
    println!("seed {seed}");
    let folder = tempfile::tempdir().unwrap();
    for index in 0..count {
        let DrawnProgram { text, tools, .. } = drawn(seed, index);
        let dialect = DIALECTS[usize::try_from(index / 2).unwrap() % (DIALECTS.len() - 1)];
        fs::write(folder.path().join("drawn.ngc"), &text).unwrap();
        posted(folder.path(), ["drawn.ngc", dialect, "posted.nc"], tools);
        for name in ["drawn.ngc", "posted.nc"] {
            let audit = ["check", name, "--machine"];
            let output =
                trunnion(folder.path(), &[&audit[..], &PLACE[..], &lengths(tools)[..]].concat());
            let (code, table, reported) = outcome(&output);
            assert_eq!(
                code,
                Some(0),
                "seed {seed}, program {index}, {dialect}: {table}{reported}{text}"
            );
        }
    }
}
