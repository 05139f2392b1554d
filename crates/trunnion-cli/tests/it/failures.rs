//! Commands that once panicked or printed numbers that are none: each ends with an exit code and a message.

use crate::binary;

use binary::{stderr, trunnion};
use std::fs;
use std::path::{Path, PathBuf};

const ON_BC: &str = "-m bc-trunnion --origin=-381,-254,-505 --tool-length 100 -o out";

/// File, command, and exit code.
const COMMANDS: [(&str, &str, i32); 16] = [
    ("one-place.cls", "post one-place.cls -d heidenhain --feed blocks", 0),
    ("one-place.cls", "post one-place.cls -d g93 --feed blocks", 0),
    ("one-place.cls", "post one-place.cls -d linuxcnc", 0),
    (
        "one-place.nc",
        "post one-place.nc --from-machine ac-trunnion --from-origin=0,0,-300 -d haas --feed blocks",
        0,
    ),
    (
        "slow-feed.nc",
        "post slow-feed.nc --from-machine ac-trunnion --from-origin=0,0,-430 -d linuxcnc",
        2,
    ),
    ("unresolved-length.nc", "post unresolved-length.nc -m gantry-ca-fork -d linuxcnc", 0),
    ("short-and-far.csv", "feed short-and-far.csv --limits short-and-far.toml", 2),
    ("short-and-far.csv", "feed short-and-far.csv --limits short-and-far.toml --window 64", 2),
    (
        "short-and-far.csv",
        "feed short-and-far.csv --limits short-and-far.toml --window 64 --stream",
        2,
    ),
    ("beyond-numbers.csv", "feed beyond-numbers.csv --limits beyond-numbers.toml", 2),
    (
        "beyond-numbers.csv",
        "feed beyond-numbers.csv --limits beyond-numbers.toml --method optimal",
        2,
    ),
    (
        "beyond-numbers.csv",
        "feed beyond-numbers.csv --limits beyond-numbers.toml --method blocks",
        2,
    ),
    (
        "beyond-numbers.csv",
        "feed beyond-numbers.csv --limits beyond-numbers.toml --window 64 --stream",
        2,
    ),
    ("nothing-allowed.csv", "feed nothing-allowed.csv --limits nothing-allowed.toml", 2),
    (
        "nothing-allowed.csv",
        "feed nothing-allowed.csv --limits nothing-allowed.toml --method optimal",
        2,
    ),
    (
        "nothing-allowed.csv",
        "feed nothing-allowed.csv --limits nothing-allowed.toml --window 64 --stream",
        2,
    ),
];

fn inputs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/failures/commands")
}

#[test]
fn every_command_ends_with_a_message() {
    let list = fs::read_to_string(inputs().join("README.md")).unwrap();
    for entry in fs::read_dir(inputs()).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        let is_limits = Path::new(&name).extension().is_some_and(|end| end == "toml");
        if name == "README.md" || is_limits {
            continue;
        }
        assert!(list.contains(&format!("| `{name}` |")), "{name} has no reason in the list");
        assert!(COMMANDS.iter().any(|(file, ..)| *file == name), "{name} has no command");
    }
    for (file, command, code) in COMMANDS {
        let folder = tempfile::tempdir().unwrap();
        for name in [file.to_owned(), file.replace(".csv", ".toml")] {
            fs::copy(inputs().join(&name), folder.path().join(&name)).unwrap();
        }
        let is_for_bc = command.starts_with("post") && !command.contains(" -m ");
        let rest = if is_for_bc { ON_BC } else { "-o out" };
        let arguments: Vec<&str> = command.split(' ').chain(rest.split(' ')).collect();
        let output = trunnion(folder.path(), &arguments);
        let reported = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{command}: {reported}");
        let said = format!("{reported}{}", String::from_utf8_lossy(&output.stdout));
        let numbers = ["NaN", "nan", "inf "];
        assert!(!numbers.iter().any(|none| said.contains(none)), "{command}: {said}");
        assert_eq!(folder.path().join("out").exists(), code == 0, "{command}");
    }
}
