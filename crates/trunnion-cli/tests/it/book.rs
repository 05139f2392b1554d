//! Links and pictures of the book and of the pages beside it lead somewhere.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary::root;
use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn every_link_leads_to_a_file() {
    let mut pages: Vec<PathBuf> = Vec::new();
    collect(&root().join("docs"), &mut pages);
    for name in ["README.md", "README.zh.md", "ARCHITECTURE.md", "CONTRIBUTING.md"] {
        pages.push(root().join(name));
    }
    assert!(pages.len() > 30, "only {} pages found", pages.len());
    let mut lost = Vec::new();
    for page in pages {
        let text = fs::read_to_string(&page).unwrap();
        let folder = page.parent().unwrap();
        for target in links(&text) {
            if !leads_somewhere(folder, &target) {
                lost.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(lost.is_empty(), "\n{}", lost.join("\n"));
}

#[test]
fn every_page_stands_in_the_summary() {
    let source = root().join("docs/book/src");
    let summary = fs::read_to_string(source.join("SUMMARY.md")).unwrap();
    let mut pages = Vec::new();
    collect(&source, &mut pages);
    for page in pages {
        let below = page.strip_prefix(&source).unwrap();
        let name: Vec<_> = below.iter().map(|part| part.to_string_lossy()).collect();
        let name = name.join("/");
        assert!(name == "SUMMARY.md" || summary.contains(&format!("({name})")), "{name}");
    }
}

fn collect(folder: &Path, pages: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, pages);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            pages.push(path);
        }
    }
}

/// Targets of `[..](target)` and of `{{#include target}}`, outside code.
fn links(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut in_code = false;
    for line in text.lines() {
        in_code ^= line.trim_start().starts_with("```");
        if in_code || line.starts_with("    ") {
            continue;
        }
        for part in line.split("](").skip(1) {
            found.extend(part.split(')').next().map(str::to_owned));
        }
        for part in line.split("{{#include ").skip(1) {
            found.extend(part.split(['}', ':']).next().map(str::to_owned));
        }
    }
    found
}

fn leads_somewhere(folder: &Path, target: &str) -> bool {
    let file = target.split('#').next().unwrap_or_default();
    file.is_empty() || file.contains("://") || folder.join(file).exists()
}
