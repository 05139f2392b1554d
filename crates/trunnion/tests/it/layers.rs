//! The arrows between modules are a table, and this test reads it.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
use std::fs;
use std::path::{Path, PathBuf};

/// Module, and the modules it may use. Bottom to top: a target stands above its user.
const ARROWS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("types", &["math"]),
    ("surface", &["math", "types"]),
    ("cutter", &["math", "types"]),
    ("machine", &["math", "types"]),
    ("inverse", &["machine", "math", "types"]),
    ("positioning", &["surface", "cutter", "math", "types"]),
    ("cover", &["positioning", "surface", "cutter", "math", "types"]),
    ("toolpath", &["math", "types"]),
    ("axes", &["inverse", "machine", "math", "types"]),
    ("feed", &["math", "types"]),
    ("setpoint", &["math", "types"]),
    ("blocks", &["inverse", "machine", "math", "types"]),
    ("nc", &["machine", "math", "types"]),
    ("import", &["surface", "math", "types"]),
    ("files", &["surface", "cutter", "machine", "math", "types"]),
    ("verify", &["surface", "cutter", "machine", "nc", "math", "types"]),
];

/// The crates that make up the library, bottom to top.
const LIBRARIES: &[&str] =
    &["trunnion-types", "trunnion-motion", "trunnion-geometry", "trunnion-nc", "trunnion"];

/// The modules of `trunnion-nc`, which is one module of the table and a crate of its own.
const NC_PARTS: &[&str] = &["read", "words", "write"];

/// Checkers may use only these parts of a module they share with a maker.
const ONLY: &[(&str, &str, &[&str])] = &[("verify", "nc", &["read"])];

/// What no module of the library contains: it does no I/O, reads no clock, keeps no state.
const ABSENT: &[&str] = &[
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
    "OnceLock",
    "LazyLock",
    "todo!",
    "unimplemented!",
];

#[test]
fn modules_use_only_what_is_below_them() {
    let mut wrong = Vec::new();
    for (row, (module, allowed)) in ARROWS.iter().enumerate() {
        for target in *allowed {
            let above = ARROWS[..row].iter().any(|(name, _)| name == target);
            assert!(above, "{module} -> {target}: list {target} above {module}");
        }
        for (place, path) in uses(module) {
            let mut parts = path.split("::");
            let used = parts.next().unwrap_or_default();
            let own = used == *module || *module == "nc" && NC_PARTS.contains(&used);
            if !own && !allowed.contains(&used) {
                wrong.push(format!("{place}: {module} must not use {used}"));
            }
            let second = parts.next().unwrap_or_default();
            for (user, target, only) in ONLY {
                if user == module && *target == used && !only.contains(&second) {
                    wrong.push(format!("{place}: {module} may use only {only:?} of {used}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_module_stands_in_the_table() {
    let mut modules = vec!["nc".to_owned()];
    for library in LIBRARIES.iter().filter(|library| **library != "trunnion-nc") {
        let lib = fs::read_to_string(crates().join(library).join("src/lib.rs")).unwrap();
        let names = lib.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
        modules.extend(names.map(str::to_owned));
    }
    assert!(modules.len() > ARROWS.len());
    for module in modules {
        let known = module == "pipeline" || ARROWS.iter().any(|(name, _)| *name == module);
        assert!(known, "{module} is not in the table of arrows");
    }
}

#[test]
fn the_library_does_no_io_and_keeps_no_state() {
    let mut wrong = Vec::new();
    for (file, text) in LIBRARIES.iter().flat_map(|name| sources(&crates().join(name).join("src")))
    {
        for (number, line) in code_lines(&text) {
            for word in ABSENT.iter().filter(|word| line.contains(**word)) {
                wrong.push(format!("{file}:{number}: {word}"));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// The folder of all crates.
fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The folder of a module: a folder of its crate, or a whole crate.
fn folder(module: &str) -> PathBuf {
    let whole = crates().join(format!("trunnion-{module}/src"));
    if module == "nc" {
        return whole;
    }
    let homes = LIBRARIES.iter().map(|name| crates().join(name).join("src").join(module));
    homes.into_iter().find(|home| home.is_dir()).unwrap_or(whole)
}

/// `(file:line, path)` of every `crate::path` a module names outside comments and unit tests.
fn uses(module: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let files = sources(&folder(module));
    assert!(!files.is_empty(), "{module} has no files");
    for (file, text) in files {
        for (number, line) in code_lines(&text) {
            for (at, _) in line.match_indices("crate::") {
                let path: String = line[at + "crate::".len()..]
                    .chars()
                    .take_while(|c| c.is_alphanumeric() || matches!(c, '_' | ':'))
                    .collect();
                assert!(
                    !path.is_empty(),
                    "{file}:{number}: write one `use crate::module::...` a module"
                );
                found.push((format!("{file}:{number}"), path));
            }
        }
    }
    found
}

/// Numbered lines of a file, up to its unit tests, without comments.
fn code_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines()
        .enumerate()
        .take_while(|(_, line)| !line.starts_with("#[cfg(test)]"))
        .map(|(index, line)| (index + 1, line.split("//").next().unwrap_or_default()))
}

/// All Rust files below a folder with their text.
fn sources(folder: &Path) -> Vec<(String, String)> {
    let mut files = Vec::new();
    let Ok(entries) = fs::read_dir(folder) else { return files };
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push((path.display().to_string(), fs::read_to_string(&path).unwrap()));
        }
    }
    files
}
