//! The arrows between modules are a table, and this test reads it.

use crate::imports::{Import, imports};
use crate::sources::{LIBRARIES, Source, library, sources_of};
use std::collections::BTreeSet;

/// Module, and the modules it may use. Bottom to top: a target stands above its user. Most use `math`, if only for a sine.
const ARROWS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("types", &["math"]),
    ("surface", &["math", "types"]),
    ("cutter", &["math", "types"]),
    ("drop_cutter", &["cutter", "math", "types"]),
    ("machine", &["math", "types"]),
    ("inverse", &["machine", "math", "types"]),
    ("calibrate", &["machine", "math", "types"]),
    ("positioning", &["surface", "cutter", "math", "types"]),
    ("cover", &["positioning", "surface", "cutter", "math", "types"]),
    ("toolpath", &["math", "types"]),
    ("axes", &["inverse", "machine", "math", "types"]),
    ("feed", &["math", "types"]),
    ("program_motion", &["inverse", "machine", "feed", "math", "types"]),
    ("setpoint", &["types"]),
    ("blocks", &["machine", "math", "types"]),
    ("nc", &["machine", "math", "types"]),
    ("import", &["surface", "math", "types"]),
    ("files", &["calibrate", "machine", "nc", "math", "types"]),
    ("post", &["inverse", "machine", "feed", "toolpath", "blocks", "nc", "math", "types"]),
    ("verify", &["surface", "cutter", "machine", "nc", "math", "types"]),
];

/// The module on top, which may use every other.
const TOP: &str = "pipeline";

/// Checkers may use only these parts of a module they share with a maker.
const ONLY: &[(&str, &str, &[&str])] = &[("verify", "nc", &["control", "read"])];

/// Parts of the library that the crate for a servo cycle may use: nothing that plans, writes or checks.
const REAL_TIME: &[&str] =
    &["files", "inverse", "machine", "nalgebra", "nc", "program_motion", "types"];

/// Parts that its planning thread may use besides, in the files of `planner` but those that the servo thread runs.
const PLANNING: &[&str] = &["feed", "math"];
const SERVO_FILES: &[&str] = &["planner/servo.rs", "planner/shared.rs"];

/// What no module of the library imports: it does no I/O, reads no clock.
const ABSENT_PATHS: &[&str] = &["fs", "io", "env", "time", "process", "net", "thread"];

/// What no line of the library contains: it prints nothing and keeps no state.
const ABSENT_WORDS: &[&str] = &[
    "std::fs",
    "std::io",
    "std::env",
    "std::time",
    "std::process",
    "std::net",
    "println!",
    "eprintln!",
    "static mut",
    "thread_local!",
    "LazyLock",
    "todo!",
    "unimplemented!",
];

/// Types whose statics would be state. A field of such a type belongs to its value, as a tree that is made when it is first
/// asked for.
const CELLS: &[&str] = &["OnceLock", "OnceCell", "Mutex", "RwLock", "Atomic", "RefCell", "Cell<"];

/// Returns `true` for a line that declares a static with contents that change.
fn declares_state(line: &str) -> bool {
    let item = line.trim_start().trim_start_matches("pub(crate) ").trim_start_matches("pub ");
    item.starts_with("static ") && CELLS.iter().any(|cell| item.contains(cell))
}

#[test]
fn statics_that_change_are_state_and_fields_are_not() {
    for line in [
        "static N: AtomicU8 = AtomicU8::new(0);",
        "    pub static T: OnceLock<u8> = OnceLock::new();",
    ] {
        assert!(declares_state(line), "{line}");
    }
    for line in
        ["tree: Arc<OnceLock<u8>>,", "static NAME: &str = \"bc\";", "fn f(cell: &'static Cell) {}"]
    {
        assert!(!declares_state(line), "{line}");
    }
}

#[test]
fn modules_use_only_what_is_below_them() {
    let mut wrong = Vec::new();
    let mut used = BTreeSet::new();
    for source in library() {
        let Some(user) = module_of(&source) else { continue };
        for import in imports(&source) {
            let Some((target, part)) = target_of(&source, &import) else { continue };
            if target == user {
                continue;
            }
            let position = source.position(import.line);
            if user != TOP && !allowed(&user).contains(&target.as_str()) {
                wrong.push(format!("{position}: {user} must not use {target}"));
            }
            for (checker, shared, only) in ONLY {
                if *checker == user && *shared == target && !only.contains(&part.as_str()) {
                    wrong.push(format!("{position}: {user} may use only {only:?} of {target}"));
                }
            }
            used.insert((user.clone(), target));
        }
    }
    for (user, targets) in ARROWS {
        for target in *targets {
            if !used.contains(&((*user).to_owned(), (*target).to_owned())) {
                wrong.push(format!("{user} -> {target}: nothing uses this arrow, remove it"));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn the_real_time_crate_uses_only_kinematics() {
    let mut used = BTreeSet::new();
    for source in sources_of("trunnion-rt") {
        let path = source.path.replace('\\', "/");
        let plans = path.starts_with("planner/") && !SERVO_FILES.contains(&path.as_str());
        for import in imports(&source).iter().filter(|import| import.foreign) {
            let [root, part, ..] = import.parts.as_slice() else { continue };
            if root == "trunnion" {
                let position = source.position(import.line);
                let planning = plans && PLANNING.contains(&part.as_str());
                assert!(planning || REAL_TIME.contains(&part.as_str()), "{position}: {part}");
                used.insert(part.clone());
            }
        }
    }
    let all = REAL_TIME.iter().chain(PLANNING);
    let stated: BTreeSet<String> = all.map(|part| (*part).to_owned()).collect();
    assert_eq!(used, stated, "parts that nothing uses");
}

#[test]
fn the_table_runs_from_bottom_to_top() {
    for (row, (module, targets)) in ARROWS.iter().enumerate() {
        for target in *targets {
            let above = ARROWS[..row].iter().any(|(name, _)| name == target);
            assert!(above, "{module} -> {target}: list {target} above {module}");
        }
    }
}

#[test]
fn every_module_stands_in_the_table() {
    let mut modules: BTreeSet<String> = library().iter().filter_map(module_of).collect();
    assert!(modules.remove(TOP));
    let rows: BTreeSet<String> = ARROWS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(modules, rows);
}

#[test]
fn the_library_does_no_io_and_keeps_no_state() {
    let mut wrong = Vec::new();
    for source in library() {
        for (index, line) in source.code().lines().enumerate() {
            for word in ABSENT_WORDS.iter().filter(|word| line.contains(**word)) {
                wrong.push(format!("{}: {word}", source.position(index)));
            }
            if declares_state(line) {
                wrong.push(format!("{}: a static that changes", source.position(index)));
            }
        }
        for import in imports(&source).iter().filter(|import| import.foreign) {
            if let [root, part, ..] = import.parts.as_slice()
                && root == "std"
                && ABSENT_PATHS.contains(&part.as_str())
            {
                wrong.push(format!("{}: std::{part}", source.position(import.line)));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

fn allowed(module: &str) -> &'static [&'static str] {
    ARROWS.iter().find(|(name, _)| *name == module).map_or(&[], |(_, targets)| targets)
}

/// The module of the table that a file belongs to; `None` for the root of a crate.
fn module_of(source: &Source) -> Option<String> {
    if source.library == "trunnion-nc" {
        return Some("nc".to_owned());
    }
    source.module().first().filter(|_| !is_test_helper(source)).cloned()
}

/// Compiled for unit tests alone.
fn is_test_helper(source: &Source) -> bool {
    source.path == "sample_machine.rs"
}

/// The module of the table an import leads to, and the part of it.
fn target_of(source: &Source, import: &Import) -> Option<(String, String)> {
    let part = |index: usize| import.parts.get(index).cloned().unwrap_or_default();
    let first = part(0);
    if import.foreign || first.is_empty() {
        return None;
    }
    let is_row = first == TOP || ARROWS.iter().any(|(name, _)| *name == first);
    if is_row {
        return Some((first, part(1)));
    }
    (source.library == "trunnion-nc").then(|| ("nc".to_owned(), first))
}

#[test]
fn every_crate_is_read() {
    for name in LIBRARIES {
        assert!(library().iter().any(|source| source.library == *name), "{name}");
    }
}
