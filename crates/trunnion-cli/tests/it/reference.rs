//! The reference pages of the book are generated from the binary, and kept equal to it.
//!
//! `UPDATE_EXPECT=1 cargo test -p trunnion-cli reference` writes them again.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;
use binary::{root, trunnion};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Verbs in the order in which a newcomer meets them.
const VERBS: &[&[&str]] = &[
    &[],
    &["init"],
    &["run"],
    &["check"],
    &["batch"],
    &["post"],
    &["path"],
    &["feed"],
    &["setup"],
    &["inspect"],
    &["position"],
    &["pose"],
    &["machine"],
    &["machine", "list"],
    &["machine", "show"],
    &["machine", "check"],
    &["machine", "new"],
    &["machine", "import"],
    &["machine", "calibrate"],
    &["linuxcnc"],
    &["schema"],
    &["view"],
    &["studio"],
    &["completions"],
];

const FORMATS: &[&str] = &["job", "machine", "library", "limits", "surface", "summary", "setup"];

#[test]
fn the_command_line_page_is_the_help() {
    let mut page = String::from(
        "# Command line\n\nEvery verb has `--help` and `--json`. Exit codes: 0 done; 1 done, but something is broken or \
         out of reach; 2 wrong input, nothing written; 3 internal error. This page is generated from the help texts.\n",
    );
    for verb in VERBS {
        let arguments: Vec<&str> = verb.iter().copied().chain(["--help"]).collect();
        let help = help(&arguments);
        let title = [&["trunnion"], *verb].concat().join(" ");
        write!(page, "\n## `{title}`\n\n```text\n{}\n```\n", help.trim_end()).unwrap();
    }
    is_committed(&page, "command-line.md");
}

#[test]
fn every_verb_is_on_the_page() {
    let help = help(&["--help"]);
    let commands = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    for line in commands.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   ")) {
        let verb = line.split_whitespace().next().unwrap();
        assert!(verb == "help" || VERBS.contains(&[verb].as_slice()), "{verb} is not on the page");
    }
}

#[test]
fn the_schema_page_has_every_key() {
    let mut page = String::from(
        "# File schemas\n\nKeys of every file, generated from the JSON schemas: `trunnion schema job` prints one for an \
         editor. Unknown keys are refused with a suggestion.\n",
    );
    for format in FORMATS {
        let output = trunnion(&root(), &["schema", format]);
        let schema: Value = serde_json::from_slice(&output.stdout).unwrap();
        write!(page, "\n## {format}\n\n{}\n\n", one_line(&schema["description"])).unwrap();
        page.push_str("| key | type | default | meaning |\n|---|---|---|---|\n");
        describe_keys(&schema, &schema, "", &mut page);
    }
    is_committed(&page, "schemas.md");
}

fn help(arguments: &[&str]) -> String {
    let output = trunnion(&root(), arguments);
    assert!(output.status.success(), "{arguments:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// One row for each key below `node`, tables and lists with the keys inside them.
fn describe_keys(schema: &Value, node: &Value, prefix: &str, page: &mut String) {
    let Some(properties) = node["properties"].as_object() else { return };
    for (name, value) in properties {
        let inner = resolve(schema, value);
        let key = format!("{prefix}{name}");
        let of = kind(inner);
        let default = if value["default"].is_null() || value["default"].is_object() {
            String::new()
        } else {
            format!("`{}`", value["default"])
        };
        let own = one_line(&value["description"]);
        let meaning = if own.is_empty() { one_line(&inner["description"]) } else { own };
        writeln!(page, "| `{key}` | {of} | {default} | {} |", meaning.replace('|', "\\|")).unwrap();
        describe_keys(schema, inner, &format!("{key}."), page);
        describe_keys(schema, resolve(schema, &inner["items"]), &format!("{key}[]."), page);
        let named = resolve(schema, &inner["additionalProperties"]);
        describe_keys(schema, named, &format!("{key}.NAME."), page);
    }
}

/// The definition a reference leads to, or the first one of a choice with `null`.
fn resolve<'a>(schema: &'a Value, value: &'a Value) -> &'a Value {
    let chosen = value["anyOf"].as_array().map_or(value, |choices| {
        choices.iter().find(|choice| choice["type"] != "null").unwrap_or(value)
    });
    let Some(reference) = chosen["$ref"].as_str() else { return chosen };
    schema.pointer(reference.trim_start_matches('#')).unwrap_or(chosen)
}

fn kind(value: &Value) -> String {
    if let Some(words) = value["enum"].as_array() {
        return words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ");
    }
    let of = match &value["type"] {
        Value::Array(kinds) => kinds.iter().find(|kind| *kind != "null").unwrap_or(&Value::Null),
        kind => kind,
    };
    match of.as_str() {
        Some("array") => format!("list of {}", kind(&value["items"])),
        Some("object") => "table".to_owned(),
        Some(name) => name.to_owned(),
        None => String::new(),
    }
}

fn one_line(text: &Value) -> String {
    text.as_str().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Compares a page with the committed one, or writes it where `UPDATE_EXPECT` is set.
fn is_committed(page: &str, name: &str) {
    let path = root().join("docs/book/src/reference").join(name);
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&path, page).unwrap();
    }
    let committed = read(&path).replace('\r', "");
    assert!(
        committed == page,
        "{name} is stale: UPDATE_EXPECT=1 cargo test -p trunnion-cli reference"
    );
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_default()
}
