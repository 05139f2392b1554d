//! The library's own source text, for tests of its structure and language.

#![expect(clippy::expect_used, reason = "a test stops on surprise")]

use std::fs;
use std::path::{Path, PathBuf};

/// The crates that make up the library, bottom to top.
pub(crate) const LIBRARIES: &[&str] =
    &["trunnion-types", "trunnion-motion", "trunnion-geometry", "trunnion-nc", "trunnion"];

/// One file of the library.
pub(crate) struct Source {
    /// Name of the crate.
    pub(crate) library: &'static str,
    /// Path below the crate's `src`, with `/` between folders.
    pub(crate) path: String,
    /// Lines without the bodies of unit tests, which are left as empty lines.
    pub(crate) lines: Vec<String>,
}

impl Source {
    /// Position of a line as `crate/path:line`.
    pub(crate) fn position(&self, index: usize) -> String {
        format!("{}/{}:{}", self.library, self.path, index + 1)
    }

    /// Module path below the crate: `["read", "cl"]` of `read/cl/mod.rs`.
    pub(crate) fn module(&self) -> Vec<String> {
        let mut parts: Vec<String> =
            self.path.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
        if matches!(parts.last().map(String::as_str), Some("mod" | "lib")) {
            parts.pop();
        }
        parts
    }

    /// True for `mod.rs`, whose only work is to arrange its folder.
    pub(crate) fn is_facade(&self) -> bool {
        self.path.ends_with("/mod.rs")
    }

    /// Text of the code alone: comments are cut off, line ends kept.
    pub(crate) fn code(&self) -> String {
        let bare = |line: &String| line.split("//").next().unwrap_or_default().to_owned();
        self.lines.iter().map(bare).collect::<Vec<_>>().join("\n")
    }
}

/// The folder that holds all crates.
pub(crate) fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every file of the library, crate by crate, in order of paths.
pub(crate) fn library() -> Vec<Source> {
    LIBRARIES.iter().flat_map(|&library| sources_of(library)).collect()
}

/// Every file of one crate, in order of paths.
pub(crate) fn sources_of(library: &'static str) -> Vec<Source> {
    let root = crates().join(library).join("src");
    let mut paths = Vec::new();
    collect(&root, &mut paths);
    paths.sort();
    assert!(!paths.is_empty(), "{library} has no files");
    let read = |path: PathBuf| {
        let below = path.strip_prefix(&root).unwrap_or(&path);
        let parts: Vec<_> = below.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        let text = fs::read_to_string(&path).expect("a source file that was just listed");
        Source { library, path: parts.join("/"), lines: without_unit_tests(&text) }
    };
    paths.into_iter().map(read).collect()
}

fn collect(folder: &Path, paths: &mut Vec<PathBuf>) {
    let entries = fs::read_dir(folder).expect("a folder of the library");
    for path in entries.map(|entry| entry.expect("an entry of a readable folder").path()) {
        if path.is_dir() {
            collect(&path, paths);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            paths.push(path);
        }
    }
}

/// Lines of a file; an item behind `#[cfg(test)]` becomes empty lines up to its end in column 0.
fn without_unit_tests(text: &str) -> Vec<String> {
    let mut inside = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        inside |= line.starts_with("#[cfg(test)]");
        lines.push(if inside { String::new() } else { line.to_owned() });
        let one_line = line.ends_with(';') && !line.starts_with([' ', '#']);
        inside &= !(line == "}" || one_line);
    }
    lines
}
