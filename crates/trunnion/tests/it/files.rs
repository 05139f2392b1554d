//! Job and machine files: every shared machine parses, and no mutation of a good file panics or
//! blames a line that the file does not have.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "a test says what it could not test")]

use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use trunnion::files::{job, machine, schema};
use trunnion::types::Diagnostics;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn example() -> String {
    fs::read_to_string(root().join("examples/bezier-patch/job.toml")).unwrap()
}

/// Nearly every key of the machine layout.
const MACHINE: &str = r#"schema = "trunnion-machine/1"
name = "everything"
units = { length = "mm", angle = "deg", time = "s" }
chain = ["w", "C", "B", "b", "X", "Y", "Z", "t"]
tool_axis = [0, 0, 1]
gauge = [0, 0, 0]
[axis.C]
kind = "rotary"
dir = [0, 0, 1]
point = [-381.0, -254.0, -560.0]
cyclic = 360.0
vel = 300.0
acc = 600.0
jerk = 12000.0
home = 0.0
output = { letter = "C", modulo = "unwound", decimals = 4 }
[axis.B]
kind = "rotary"
dir = [0, 1, 0]
point = [-381.0, -254.0, -535.0]
limits = [-35.0, 120.0]
vel = 150.0
rapid = 160.0
acc = 300.0
jerk = 6000.0
sense = -1
prefer = "positive"
[axis.X]
kind = "linear"
dir = [1, 0, 0]
limits = [-762.0, 0.0]
vel = 500.0
acc = 2500.0
jerk = 40000.0
[axis.Y]
kind = "linear"
dir = [0, 1, 0]
limits = [-508.0, 0.0]
vel = 500.0
acc = 2500.0
jerk = 40000.0
[axis.Z]
kind = "linear"
dir = [0, 0, 1]
limits = [-508.0, 0.0]
vel = 500.0
acc = 2500.0
jerk = 40000.0
[cycle]
servo_period = 0.001
tip_speed_max = 200.0
contour_tolerance = 0.01
[singular]
cone = 3.0
[retract]
frame = "machine"
axis = "Z"
to = 0.0
first = true
[dialect]
name = "haas-ngc"
tcp_on = "G234 H{h}"
interpolation = "rotary-linear"
feed = "tip"
"#;

#[test]
fn the_machine_with_everything_parses() {
    assert_eq!(machine::parse(MACHINE).err(), None);
}

/// Deep nesting must end in a fault, not in an overflow of the stack.
#[test]
fn deep_nesting_is_a_fault() {
    for text in [
        format!("a = {}", "[".repeat(200_000)),
        format!("a = {}", "{a = ".repeat(200_000)),
        format!("{}a = 1", "a.".repeat(200_000)),
        format!("[{}a]", "a.".repeat(200_000)),
    ] {
        for faults in faults(&text) {
            assert!(!faults.is_empty());
        }
    }
}

#[test]
fn the_four_shared_machines_parse() {
    let folder = root().join("../shared/machines");
    let Ok(entries) = fs::read_dir(&folder) else {
        println!("{} is absent: its machines are not tested", folder.display());
        return;
    };
    let mut count = 0;
    for path in entries.map(|entry| entry.unwrap().path()) {
        let text = fs::read_to_string(&path).unwrap();
        let faults = machine::parse(&text).err();
        assert_eq!(faults, None, "{}", path.display());
        count += 1;
    }
    assert!(count >= 4, "only {count} machines");
}

#[test]
fn every_machine_and_example_of_the_repository_parses() {
    let mut files = Vec::new();
    for folder in ["machines", "examples/bezier-patch", "examples/step-face"] {
        let Ok(entries) = fs::read_dir(root().join(folder)) else { continue };
        files.extend(entries.map(|entry| entry.unwrap().path()));
    }
    for path in files.iter().filter(|path| path.extension().is_some_and(|end| end == "toml")) {
        let text = fs::read_to_string(path).unwrap();
        let faults = if text.contains("trunnion-machine/1") {
            machine::parse(&text).err()
        } else {
            job::parse(&text).err()
        };
        assert_eq!(faults, None, "{}", path.display());
    }
    assert!(!files.is_empty());
}

/// What is not built, or cannot be, is refused at its line instead of being passed over.
#[test]
fn nothing_in_a_job_is_passed_over() {
    let refused = |old: &str, new: &str| {
        let text = example();
        assert!(text.contains(old), "{old}");
        job::parse(&text.replacen(old, new, 1)).expect_err(new)[0].clone()
    };
    let number = refused("faces = \"all\"", "faces = [-1]");
    assert_eq!(number.message, "`part.faces.0` = -1 must be at least 0");
    let number = refused("faces = \"all\"", "faces = [1.5]");
    assert!(number.message.contains("must be a whole number"), "{number:?}");
    let stock = refused("[tool]", "[stock]\nkind = \"stl\"\n[tool]");
    assert!(stock.message.contains("needs file"), "{stock:?}");
    let profile = "shank = [[40, 8]]\nholder = [[30, 25], [60, 30]]\nlength";
    let holder = refused("length", profile);
    assert!(holder.message.contains("below the shank's end at 40 mm"), "{holder:?}");
    let total = refused("total = 0.02", "total = 1e300");
    assert!(total.message.contains("at most 100"), "{total:?}");
}

#[test]
fn the_schemas_describe_every_key_with_a_sentence() {
    let all =
        [schema::job(), schema::machine(), schema::surface(), schema::summary(), schema::setup()];
    for text in all {
        let schema: serde_json::Value = serde_json::from_str(&text).unwrap();
        described(&schema, "");
    }
}

fn described(schema: &serde_json::Value, path: &str) {
    let Some(properties) = schema.get("properties") else { return };
    for (key, inner) in properties.as_object().unwrap() {
        let path = format!("{path}.{key}");
        assert!(inner.get("description").is_some(), "{path} has no description");
        described(inner, &path);
    }
}

/// Faults of a text that may be any file.
fn faults(text: &str) -> [Diagnostics; 2] {
    [job::parse(text).err().unwrap_or_default(), machine::parse(text).err().unwrap_or_default()]
}

/// Every fault stands in the file, and says something.
fn check(text: &str) -> Result<(), TestCaseError> {
    let lines: Vec<&str> = text.split('\n').collect();
    for fault in faults(text).iter().flatten() {
        let [line, column] = [fault.line, fault.column].map(|n| usize::try_from(n).unwrap());
        prop_assert!((1..=lines.len()).contains(&line), "{fault} of {} lines", lines.len());
        let width = lines[line - 1].chars().count();
        prop_assert!((1..=width + 1).contains(&column), "{fault} of {width} columns");
        prop_assert!(!fault.message.is_empty());
    }
    Ok(())
}

/// What users and editors put into files.
const SPLINTERS: &[&str] = &[
    "=",
    "[",
    "]",
    "[[",
    "\"",
    "'''",
    "\"\"\"",
    "{",
    "}",
    ",",
    ".",
    "#",
    "\n",
    "\r\n",
    "\0",
    "-",
    "nan",
    "inf",
    "-1",
    "1e999",
    "99999999999999999999",
    "0x",
    "true",
    "\u{feff}",
    "\u{e4}",
    "\u{1f980}",
    "1979-05-27",
    "[axis.X]",
    "[tool]",
    "name",
    "schema = \"trunnion-job/1\"\n",
    "\\u12",
    "_",
    "\t",
];

fn mutated(text: &str, steps: &[(usize, usize, usize)]) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for &(at, cut, splinter) in steps {
        let at = at % (chars.len() + 1);
        let end = (at + cut).min(chars.len());
        let new = SPLINTERS.get(splinter).copied().unwrap_or_default();
        chars.splice(at..end, new.chars());
    }
    chars.into_iter().collect()
}

fn steps() -> impl Strategy<Value = Vec<(usize, usize, usize)>> {
    proptest::collection::vec((0..100_000_usize, 0..12_usize, 0..SPLINTERS.len() + 8), 1..6)
}

proptest! {
    #[test]
    fn a_mutated_job_never_panics_and_blames_its_own_lines(steps in steps()) {
        check(&mutated(&example(), &steps))?;
    }

    #[test]
    fn a_mutated_machine_never_panics_and_blames_its_own_lines(steps in steps()) {
        check(&mutated(MACHINE, &steps))?;
    }

    #[test]
    fn any_text_at_all_is_answered(text in "\\PC{0,200}") {
        check(&text)?;
        prop_assert!(faults(&text).iter().all(|faults| !faults.is_empty()));
    }

    /// Whatever single number is spoilt, the fault stands on its line.
    #[test]
    fn a_spoilt_number_is_found_on_its_line(pick in 0..1000_usize) {
        let text = example();
        let is_number = |line: &str| {
            line.split_once(" = ").is_some_and(|(_, v)| v.starts_with(|c: char| c.is_ascii_digit()))
        };
        let numbers: Vec<(usize, &str)> =
            text.lines().enumerate().filter(|(_, line)| is_number(line)).collect();
        let (index, line) = numbers[pick % numbers.len()];
        let (key, _) = line.split_once(" = ").unwrap();
        let spoilt = text.replacen(line, &format!("{key} = nan"), 1);
        let found = job::parse(&spoilt).err().unwrap_or_default();
        prop_assert!(found.iter().any(|fault| fault.line as usize == index + 1), "{key}: {found:?}");
    }
}
