//! Rooms inside the modules: `mod.rs` arranges its folder and nothing else, and no two files
//! import each other, directly or round about.

use crate::imports::imports;
use crate::sources::{LIBRARIES, Source, sources_of};
use std::collections::{BTreeMap, BTreeSet};

/// Files that lie in a circle of imports. The number may only fall.
const FILES_IN_CIRCLES: usize = 0;

/// `mod.rs` files that define more than they arrange. The number may only fall.
const CROWDED_FACADES: usize = 0;

/// Beginnings of lines in column 0 that define something.
const DEFINITIONS: &[&str] =
    &["fn ", "struct ", "enum ", "trait ", "impl", "const ", "static ", "type ", "macro_rules!"];

#[test]
fn files_of_a_crate_form_no_circle() {
    let mut circles: Vec<String> = Vec::new();
    for &name in LIBRARIES {
        let sources = sources_of(name);
        circles.extend(files_in_circles(&sources).into_iter().map(|path| format!("{name}/{path}")));
    }
    assert_eq!(circles.len(), FILES_IN_CIRCLES, "in a circle:\n{}", circles.join("\n"));
}

#[test]
fn facades_only_arrange() {
    let crowded: Vec<String> = LIBRARIES
        .iter()
        .flat_map(|&name| sources_of(name))
        .filter(|source| source.is_facade() && source.lines.iter().any(|line| defines(line)))
        .map(|source| source.position(0))
        .collect();
    assert_eq!(crowded.len(), CROWDED_FACADES, "more than facades:\n{}", crowded.join("\n"));
}

fn defines(line: &str) -> bool {
    let mut line = line;
    if let Some(rest) = line.strip_prefix("pub") {
        let rest = rest.trim_start_matches(|c| c != ' ');
        line = rest.trim_start();
    }
    DEFINITIONS.iter().any(|word| line.starts_with(word))
}

/// Paths of the files that can be reached from themselves along imports.
fn files_in_circles(sources: &[Source]) -> Vec<String> {
    let files: BTreeMap<Vec<String>, usize> =
        sources.iter().enumerate().map(|(index, source)| (source.module(), index)).collect();
    let targets: Vec<BTreeSet<usize>> =
        sources.iter().map(|source| imported_files(source, &files)).collect();
    (0..sources.len())
        .filter(|&start| reaches(start, &targets))
        .map(|index| sources[index].path.clone())
        .collect()
}

/// The files that the paths of a file lead to: the longest part of a path that is a module.
fn imported_files(source: &Source, files: &BTreeMap<Vec<String>, usize>) -> BTreeSet<usize> {
    let own = source.module();
    let local = |parts: &[String]| {
        let mut path = own.clone();
        path.extend_from_slice(&parts[..1]);
        files.contains_key(&path).then(|| [own.as_slice(), parts].concat())
    };
    imports(source)
        .iter()
        .filter_map(
            |import| {
                if import.foreign { local(&import.parts) } else { Some(import.parts.clone()) }
            },
        )
        .filter_map(|parts| (1..=parts.len()).rev().find_map(|n| files.get(&parts[..n])))
        .copied()
        .filter(|&index| files.get(&own) != Some(&index))
        .collect()
}

fn reaches(start: usize, targets: &[BTreeSet<usize>]) -> bool {
    let mut seen = BTreeSet::new();
    let mut open: Vec<usize> = targets[start].iter().copied().collect();
    while let Some(file) = open.pop() {
        if file == start {
            return true;
        }
        if seen.insert(file) {
            open.extend(&targets[file]);
        }
    }
    false
}
