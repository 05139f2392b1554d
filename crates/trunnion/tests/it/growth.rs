//! Room to grow: a new field or variant breaks no caller. Both counts may only fall.
//!
//! Callers build options, requests and specs by struct update from a constructor, so `#[non_exhaustive]` would be in
//! their way. They only read reports, summaries and errors, which are `#[non_exhaustive]`.

use crate::sources::{Source, library};

/// Options, requests and specs without a constructor, or without a word on struct update.
const BARE_OPTIONS: usize = 0;
/// Reports, summaries and errors without `#[non_exhaustive]`: three summaries that the command line fills in, and
/// `AssumedError`, an error of a machine that callers state.
const CLOSED_RESULTS: usize = 4;

/// Ends of the names of types that callers build.
const BUILT: &[&str] = &["Options", "Request", "Spec"];
/// Ends of the names of types that callers read.
const READ: &[&str] = &["Report", "Summary", "Error", "Finding", "FindingKind", "Remedy"];

/// A public type with what stands in front of it.
struct Declaration {
    position: String,
    name: String,
    /// Public fields, or variants, that a caller could list in full.
    is_open: bool,
    docs: String,
    attributes: String,
}

#[test]
fn options_are_built_from_presets() {
    let sources = library();
    let code: Vec<String> = sources.iter().map(Source::code).collect();
    let bare: Vec<String> = declarations(&sources)
        .into_iter()
        .filter(|one| one.is_open && ends(&one.name, BUILT))
        .filter(|one| {
            // With `#[non_exhaustive]` the caller has no choice but to begin with a constructor.
            let says = one.docs.contains("struct update") || is_non_exhaustive(one);
            let built = one.attributes.contains("Default")
                || code.iter().any(|text| has_constructor(text, &one.name));
            !(says && built)
        })
        .map(|one| format!("{}: {}", one.position, one.name))
        .collect();
    only_falls(&bare, BARE_OPTIONS, "BARE_OPTIONS");
}

#[test]
fn results_can_grow() {
    let closed: Vec<String> = declarations(&library())
        .into_iter()
        .filter(|one| one.is_open && ends(&one.name, READ) && !is_non_exhaustive(one))
        .map(|one| format!("{}: {}", one.position, one.name))
        .collect();
    only_falls(&closed, CLOSED_RESULTS, "CLOSED_RESULTS");
}

fn only_falls(found: &[String], stated: usize, constant: &str) {
    let count = found.len();
    assert!(count <= stated, "{constant}: {count}, at most {stated}:\n{}", found.join("\n"));
    assert!(count >= stated, "{constant} fell to {count}: write that into tests/it/growth.rs");
}

fn ends(name: &str, with: &[&str]) -> bool {
    with.iter().any(|end| name.ends_with(end))
}

fn is_non_exhaustive(one: &Declaration) -> bool {
    one.attributes.contains("non_exhaustive")
}

fn declarations(sources: &[Source]) -> Vec<Declaration> {
    let found: Vec<Declaration> = sources
        .iter()
        .flat_map(|source| (0..source.lines.len()).filter_map(|at| declaration(source, at)))
        .collect();
    assert!(found.len() > 300, "the test no longer finds the types");
    found
}

/// Type that is declared in a line, outside functions and impls.
fn declaration(source: &Source, at: usize) -> Option<Declaration> {
    let line = &source.lines[at];
    let of_struct = line.strip_prefix("pub struct ");
    let name: String = of_struct
        .or_else(|| line.strip_prefix("pub enum "))?
        .chars()
        .take_while(|c| c.is_alphanumeric())
        .collect();
    let body: Vec<&String> =
        source.lines[at + 1..].iter().take_while(|line| !line.starts_with('}')).collect();
    let private = |line: &&&String| {
        line.starts_with("    ") && line.contains(": ") && !line.trim_start().starts_with("pub ")
    };
    let code = |line: &&String| !line.trim_start().starts_with(['/', '#']);
    // A struct with a private field, or without braces, cannot be built outside anyway.
    let is_open = line.ends_with('{')
        && !(of_struct.is_some()
            && body.iter().filter(|line| code(line)).any(|line| private(&line)));
    let before = source.lines[..at].iter().rev().take_while(|line| !line.is_empty());
    let (docs, attributes): (Vec<&String>, Vec<&String>) =
        before.partition(|line| line.starts_with("///"));
    let join = |lines: Vec<&String>| {
        let words: Vec<&str> =
            lines.into_iter().rev().map(|line| line.trim_start_matches('/').trim()).collect();
        words.join(" ")
    };
    Some(Declaration {
        position: source.position(at),
        name,
        is_open,
        docs: join(docs),
        attributes: join(attributes),
    })
}

/// Returns `true` if the text has a public function or constant of the type that yields it.
fn has_constructor(code: &str, name: &str) -> bool {
    let heads = ["impl", "impl<'a>"].map(|word| format!("\n{word} {name}"));
    let blocks = heads.iter().flat_map(|head| code.match_indices(head.as_str()));
    let in_blocks = blocks.map(|(at, _)| code[at + 1..].split("\n}").next().unwrap_or_default());
    let yields = |block: &str| {
        block.split("\n    pub ").skip(1).any(|item| {
            let head = item.split('{').next().unwrap_or_default();
            let takes_self = head.contains("self");
            (head.contains("-> Self") || head.contains(": Self")) && !takes_self
        })
    };
    in_blocks.into_iter().any(yields) || code.contains(&format!("impl Default for {name}"))
}
