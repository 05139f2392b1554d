//! The language of the library: counts of what a reader stumbles over, which may only fall.
//!
//! Each count stands below as it is today. More fails; fewer fails too, until the smaller number is
//! written here, so that it stays.

use crate::sources::{Source, library};
use std::collections::BTreeMap;

/// Documentation that begins with What, How, Whether, Where, Which, Why, When or Who.
const QUESTION_DOCS: usize = 0;
/// Type names that stand for more than two types.
const CROWDED_NAMES: usize = 0;
/// Functions with a tuple among their parameters.
const TUPLE_PARAMETERS: usize = 0;
/// Functions with a `bool` among their parameters.
const BOOL_PARAMETERS: usize = 0;
/// Functions with more than five parameters besides `self`.
const LONG_PARAMETERS: usize = 0;
/// Percent of type names that are one word.
const ONE_WORD_TYPES: usize = 10;

/// Public functions and fields with ranges as `[[f64; 2]; 2]` instead of `Interval`; both are in the form that
/// summary.json has.
const BARE_RANGES: usize = 2;

/// Words that documentation must not begin with: it states a subject or an action.
const QUESTION_WORDS: &[&str] = &["What", "How", "Whether", "Where", "Which", "Why", "When", "Who"];

#[test]
fn docs_begin_with_a_noun_or_a_verb() {
    let mut found = Vec::new();
    for source in library() {
        let mut inside = false;
        for (index, line) in source.lines.iter().enumerate() {
            let text = doc_text(line);
            if let Some(text) = text.filter(|_| !inside) {
                let first = text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
                if QUESTION_WORDS.contains(&first) {
                    found.push(format!("{}: {text}", source.position(index)));
                }
            }
            inside = text.is_some();
        }
    }
    only_falls(&found, QUESTION_DOCS, "QUESTION_DOCS");
}

#[test]
fn a_type_name_stands_for_at_most_two_types() {
    let mut positions: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (name, position) in types() {
        positions.entry(name).or_default().push(position);
    }
    let crowded: Vec<String> = positions
        .iter()
        .filter(|(_, positions)| positions.len() > 2)
        .map(|(name, positions)| format!("{name}: {}", positions.join(", ")))
        .collect();
    only_falls(&crowded, CROWDED_NAMES, "CROWDED_NAMES");
}

#[test]
fn type_names_are_qualified() {
    let names: Vec<String> = types().into_iter().map(|(name, _)| name).collect();
    let short = names.iter().filter(|name| words(name) == 1).count();
    let percent = (100 * short).div_ceil(names.len());
    assert!(
        percent <= ONE_WORD_TYPES,
        "{short} of {} type names are one word: {percent} %",
        names.len()
    );
}

#[test]
fn parameters_have_names() {
    let mut tuples = Vec::new();
    let mut bools = Vec::new();
    let mut long = Vec::new();
    for source in library() {
        for function in functions(&source) {
            let types: Vec<&str> = function.parameters.iter().map(|p| parameter_type(p)).collect();
            if types.iter().any(|of| holds_tuple(of)) {
                tuples.push(function.position.clone());
            }
            if types.contains(&"bool") {
                bools.push(function.position.clone());
            }
            if types.len() > 5 {
                long.push(function.position);
            }
        }
    }
    only_falls(&tuples, TUPLE_PARAMETERS, "TUPLE_PARAMETERS");
    only_falls(&bools, BOOL_PARAMETERS, "BOOL_PARAMETERS");
    only_falls(&long, LONG_PARAMETERS, "LONG_PARAMETERS");
}

#[test]
fn public_ranges_are_intervals() {
    let mut found = Vec::new();
    for source in library() {
        for (index, line) in source.lines.iter().enumerate() {
            if line.trim_start().starts_with("pub ") && line.contains("[[f64; 2]; 2]") {
                found.push(source.position(index));
            }
        }
    }
    only_falls(&found, BARE_RANGES, "BARE_RANGES");
}

/// Fails unless there are exactly as many offenders as the constant states.
fn only_falls(found: &[String], stated: usize, constant: &str) {
    let count = found.len();
    assert!(count <= stated, "{constant}: {count}, at most {stated}:\n{}", found.join("\n"));
    assert!(count >= stated, "{constant} fell to {count}: write that into tests/it/names.rs");
}

/// Text of a line of documentation.
fn doc_text(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).map(str::trim_start)
}

/// Name and position of each struct, enum, trait and type alias outside functions and impls.
fn types() -> Vec<(String, String)> {
    let mut found = Vec::new();
    for source in library() {
        for (index, line) in source.lines.iter().enumerate() {
            if let Some(name) = type_name(line) {
                found.push((name, source.position(index)));
            }
        }
    }
    assert!(found.len() > 500, "the test no longer finds the types");
    found
}

fn type_name(line: &str) -> Option<String> {
    let mut words = line.split_whitespace().peekable();
    if words.peek().is_some_and(|word| word.starts_with("pub")) {
        words.next();
    }
    let kind = words.next()?;
    let alias = kind == "type" && !line.starts_with(' ');
    if !alias && !matches!(kind, "struct" | "enum" | "trait") {
        return None;
    }
    let name: String = words.next()?.chars().take_while(|c| c.is_alphanumeric()).collect();
    name.starts_with(char::is_uppercase).then_some(name)
}

/// Number of words in a type name: capitals that begin one; `NC` counts once, like `NcReader`'s `Nc`.
fn words(name: &str) -> usize {
    let letters: Vec<char> = name.chars().collect();
    (0..letters.len())
        .filter(|&at| {
            let before = at.checked_sub(1).map(|before| letters[before]);
            let next = letters.get(at + 1);
            letters[at].is_uppercase()
                && (before.is_none_or(|c| !c.is_uppercase())
                    || next.is_some_and(|c| c.is_lowercase()))
        })
        .count()
}

struct Function {
    position: String,
    /// `name: type`, without `self`.
    parameters: Vec<String>,
}

fn functions(source: &Source) -> Vec<Function> {
    let code = source.code();
    let mut found = Vec::new();
    for (at, _) in code.match_indices("fn ") {
        let starts = code[..at].chars().next_back().is_none_or(|c| c == ' ' || c == '\n');
        let named = code[at + 3..].starts_with(|c: char| c.is_lowercase() || c == '_');
        if !starts || !named {
            continue;
        }
        let line = code[..at].matches('\n').count();
        if let Some(list) = parameter_list(&code[at + 3..]) {
            let parameters = split_at_commas(list).into_iter().filter(|p| !is_receiver(p));
            found.push(Function {
                position: source.position(line),
                parameters: parameters.collect(),
            });
        }
    }
    found
}

/// Text between the parentheses behind a function's name and generics.
fn parameter_list(text: &str) -> Option<&str> {
    let mut angle = 0_i32;
    let mut previous = ' ';
    let mut open = None;
    let mut depth = 0_i32;
    for (at, c) in text.char_indices() {
        match c {
            '<' if open.is_none() => angle += 1,
            '>' if open.is_none() && previous != '-' => angle -= 1,
            '(' if open.is_none() && angle == 0 => open = Some(at + 1),
            '(' => depth += i32::from(open.is_some()),
            ')' if open.is_some() && depth == 0 => return Some(&text[open?..at]),
            ')' => depth -= i32::from(open.is_some()),
            _ => {}
        }
        previous = c;
    }
    None
}

fn split_at_commas(list: &str) -> Vec<String> {
    let mut depth = 0_i32;
    let mut previous = ' ';
    let mut part = String::new();
    let mut parts = Vec::new();
    for c in list.chars() {
        match c {
            '(' | '[' | '{' | '<' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            '>' if previous != '-' => depth -= 1,
            _ => {}
        }
        if c == ',' && depth == 0 {
            parts.push(std::mem::take(&mut part));
        } else {
            part.push(c);
        }
        previous = c;
    }
    parts.push(part);
    parts.iter().map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect()
}

fn is_receiver(parameter: &str) -> bool {
    let bare = parameter.trim_start_matches(['&', ' ']);
    let bare = bare.split_whitespace().last().unwrap_or_default();
    bare == "self" || parameter.starts_with("self:")
}

/// Type of `name: type`; patterns may hold a `:` of their own inside brackets.
fn parameter_type(parameter: &str) -> &str {
    let mut depth = 0_i32;
    for (at, c) in parameter.char_indices() {
        match c {
            '(' | '[' | '{' | '<' => depth += 1,
            ')' | ']' | '}' | '>' => depth -= 1,
            ':' if depth == 0 => return parameter[at + 1..].trim(),
            _ => {}
        }
    }
    ""
}

/// A tuple, a reference to one, or a list of them.
fn holds_tuple(of: &str) -> bool {
    let mut bare = of;
    while let Some(rest) = bare.strip_prefix('&') {
        let rest = rest.trim_start();
        let rest = rest.strip_prefix("mut ").unwrap_or(rest);
        bare = match rest.strip_prefix('\'') {
            Some(lifetime) => lifetime.split_once(' ').map_or("", |(_, rest)| rest),
            None => rest,
        };
    }
    bare.starts_with('(') || ["Option<(", "Vec<(", "[("].iter().any(|list| of.contains(list))
}

#[test]
fn the_counts_see_what_they_count() {
    let lines = [
        "fn one((a, b): (f64, f64), c: &[(usize, f64)]) {}",
        "fn two<T: Fn(f64) -> f64>(&mut self, f: T, open: bool) {}",
        "fn three(a: f64, b: f64, c: f64, d: f64, e: f64, f: f64) -> (f64, f64) {}",
    ];
    let source = Source {
        library: "trunnion",
        path: "x.rs".to_owned(),
        lines: lines.map(str::to_owned).to_vec(),
    };
    let functions = functions(&source);
    let types = |index: usize| -> Vec<&str> {
        functions[index].parameters.iter().map(|p| parameter_type(p)).collect()
    };
    assert!(types(0).into_iter().all(holds_tuple));
    assert_eq!(types(1), ["T", "bool"]);
    assert_eq!(types(2).len(), 6);
    assert_eq!(["Cell", "FeedCell", "NC", "NCReader"].map(words), [1, 2, 1, 2]);
    assert_eq!(type_name("pub(crate) struct CellTree<T> {").as_deref(), Some("CellTree"));
    assert_eq!(doc_text("    /// Whether"), Some("Whether"));
}
