//! Paths that the library's files import, with groups expanded and `super` resolved.

use crate::sources::Source;

/// One path that a file names.
pub(crate) struct Import {
    /// Index of the line on which the path begins.
    pub(crate) line: usize,
    /// Parts from the root of the crate (`["feed", "plan", "Plan"]`), or with the crate in front
    /// (`["std", "fs"]`) where `foreign`.
    pub(crate) parts: Vec<String>,
    /// True for a path into another crate.
    pub(crate) foreign: bool,
}

/// Every path of a file: its `use` items, and `crate::` and `super::` paths in its code.
pub(crate) fn imports(source: &Source) -> Vec<Import> {
    let code = source.code();
    let mut found = Vec::new();
    let mut rest = String::with_capacity(code.len());
    let mut copied = 0;
    for (start, path_start) in use_items(&code) {
        let Some(length) = code[path_start..].find(';') else { continue };
        let line = line_of(&code, start);
        for path in expand(&code[path_start..path_start + length]) {
            found.extend(resolve(source, &path, line));
        }
        rest.push_str(&code[copied..start]);
        let skipped = &code[start..path_start + length];
        rest.extend(skipped.chars().filter(|c| *c == '\n'));
        copied = path_start + length;
    }
    rest.push_str(&code[copied..]);
    for (index, line) in rest.lines().enumerate() {
        for path in inline_paths(line) {
            found.extend(resolve(source, &path, index));
        }
    }
    found
}

/// Start of each `use` item, and of the path behind the word.
fn use_items(code: &str) -> impl Iterator<Item = (usize, usize)> {
    code.match_indices("use ").filter_map(|(at, word)| {
        let before = code[..at].chars().next_back();
        before.is_none_or(|c| c == '\n' || c == ' ').then_some((at, at + word.len()))
    })
}

fn line_of(code: &str, at: usize) -> usize {
    code[..at].matches('\n').count()
}

/// `a::{b, c::{d, e}}` as `a::b`, `a::c::d`, `a::c::e`.
fn expand(path: &str) -> Vec<String> {
    let path = path.trim();
    let Some((prefix, group)) = path.split_once('{') else {
        return vec![path.split(" as ").next().unwrap_or_default().trim().to_owned()];
    };
    let group = group.strip_suffix('}').unwrap_or(group);
    let mut depth = 0;
    let mut start = 0;
    let mut all = Vec::new();
    for (at, c) in group.char_indices().chain([(group.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let part = group[start..at].trim();
                if !part.is_empty() {
                    all.extend(expand(&format!("{prefix}{part}")));
                }
                start = at + 1;
            }
            _ => {}
        }
    }
    all
}

/// Paths in a line of code that begin with `crate::` or `super::`.
fn inline_paths(line: &str) -> Vec<String> {
    let part_of_path = |c: char| c.is_alphanumeric() || matches!(c, '_' | ':');
    // `pub(in path)` states who may look in; it imports nothing.
    if line.trim_start().starts_with("pub(in ") {
        return Vec::new();
    }
    line.split(|c: char| !part_of_path(c))
        .filter(|word| word.starts_with("crate::") || word.starts_with("super::"))
        .map(str::to_owned)
        .collect()
}

/// The path from the root of the crate; `None` for a name that the file itself has.
fn resolve(source: &Source, path: &str, line: usize) -> Option<Import> {
    let mut parts: Vec<String> = path.split("::").map(|part| part.trim().to_owned()).collect();
    let mut base = source.module();
    let first = parts.first()?.clone();
    match first.as_str() {
        "crate" => base.clear(),
        "self" => {}
        "super" => base.truncate(base.len().saturating_sub(1)),
        _ if first.starts_with("trunnion_") && parts.len() > 1 => {
            return Some(Import { line, parts: parts.split_off(1), foreign: false });
        }
        _ => return Some(Import { line, parts, foreign: true }),
    }
    parts.remove(0);
    while parts.first().is_some_and(|part| part == "super") {
        base.truncate(base.len().saturating_sub(1));
        parts.remove(0);
    }
    base.extend(parts);
    Some(Import { line, parts: base, foreign: false })
}

#[test]
fn groups_and_parents_are_resolved() {
    let source = Source {
        library: "trunnion",
        path: "cover/place/step.rs".to_owned(),
        lines: ["use super::super::{layout::Layout, error::{self, CoverError}};", "super::near();"]
            .map(str::to_owned)
            .to_vec(),
    };
    let paths: Vec<String> =
        imports(&source).iter().map(|import| import.parts.join("::")).collect();
    let expected = [
        "cover::layout::Layout",
        "cover::error::self",
        "cover::error::CoverError",
        "cover::place::near",
    ];
    assert_eq!(paths, expected);
}
