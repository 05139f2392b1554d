//! A TOML file with the positions of its keys, checked against the JSON schema of its layout.
//!
//! The schema is the only description of a layout: `trunnion schema` prints it, the walk in
//! [`super::walk`] checks it, and the raw types from which it is derived are read.

use super::path::join;
use super::places::{KeyPositions, TextPosition};
use super::walk;
use crate::types::{Diagnostic, Diagnostics};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// Conversion of byte offsets to lines and columns.
#[derive(Debug)]
struct LineIndex<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> LineIndex<'t> {
    fn new(text: &'t str) -> Self {
        let after =
            text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1);
        Self { text, starts: std::iter::once(0).chain(after).collect() }
    }

    fn place(&self, offset: usize) -> TextPosition {
        // A span may point past the end of the text.
        let offset = offset.min(self.text.len());
        let line = self.starts.partition_point(|&start| start <= offset).max(1);
        let start = self.starts.get(line - 1).copied().unwrap_or(0);
        let before = self.text.as_bytes().get(start..offset).unwrap_or_default();
        // Columns count characters, as editors do: a byte count would be off behind an umlaut.
        let column = String::from_utf8_lossy(before).chars().count() + 1;
        let narrow = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        TextPosition { line: narrow(line), column: narrow(column) }
    }
}

/// Diagnostic with the dotted path of the key that it is about.
#[derive(Debug)]
struct PathDiagnostic {
    path: String,
    diagnostic: Diagnostic,
}

/// Parsed file with the diagnostics found so far.
#[derive(Debug)]
pub(super) struct Document<'t> {
    lines: LineIndex<'t>,
    root: DeTable<'t>,
    places: KeyPositions,
    faults: Vec<PathDiagnostic>,
}

impl<'t> Document<'t> {
    /// Parses `text` of the layout `layout` (such as `trunnion-job/1`), and checks it against `schema`.
    ///
    /// # Errors
    ///
    /// Returns all syntax errors; or a single one if the file is of another kind altogether.
    pub(super) fn open(text: &'t str, layout: &str, schema: &Value) -> Result<Self, Diagnostics> {
        let lines = LineIndex::new(text);
        let (root, errors) = DeTable::parse_recoverable(text);
        let root = root.into_inner();
        let mut faults: Vec<PathDiagnostic> = errors
            .iter()
            .map(|error| {
                let place = lines.place(error.span().map_or(0, |span| span.start));
                PathDiagnostic { path: String::new(), diagnostic: syntax(place, error.message()) }
            })
            .collect();
        // After a syntax error the tree has holes: checking it would report keys that are there.
        if faults.iter().any(|fault| fault.diagnostic.message != DUPLICATE) {
            if let Some(fault) = something_else(text, layout) {
                return Err(fault.into());
            }
            return Err(sorted(faults));
        }
        if let Some(fault) = other_layout(&root, layout, &lines) {
            return Err(fault.into());
        }
        let mut places = KeyPositions::default();
        collect_places(&root, "", &lines, &mut places);
        let found = walk::check(schema, &root);
        faults.extend(found.into_iter().map(|finding| {
            let place =
                finding.offset.map_or(TextPosition { line: 1, column: 1 }, |at| lines.place(at));
            let TextPosition { line, column } = place;
            let walk::SchemaFinding { path, message, help, .. } = finding;
            PathDiagnostic { path, diagnostic: Diagnostic { line, column, message, help } }
        }));
        Ok(Self { lines, root, places, faults })
    }

    /// Reads the value of a top key; `None` if it is absent or faulty.
    pub(super) fn section<T: DeserializeOwned>(&mut self, key: &str) -> Option<T> {
        let value = self.root.get(key)?;
        // Serde would find the same fault again, in other words.
        if self.is_faulty(key) {
            return None;
        }
        match T::deserialize(ValueDeserializer::from(value.clone())) {
            Ok(section) => Some(section),
            Err(error) => {
                let offset = error.span().unwrap_or_else(|| value.span()).start;
                let TextPosition { line, column } = self.lines.place(offset);
                let message = error.message().to_owned();
                let diagnostic = Diagnostic { line, column, message, help: String::new() };
                self.faults.push(PathDiagnostic { path: key.to_owned(), diagnostic });
                None
            }
        }
    }

    /// Reads the tables of a top key one by one, even faulty ones that are readable, so that all their
    /// faults are reported at once. The second list names the unreadable ones.
    pub(super) fn tables<T: DeserializeOwned>(
        &mut self,
        key: &str,
    ) -> Option<(BTreeMap<String, T>, Vec<String>)> {
        let DeValue::Table(tables) = self.root.get(key)?.get_ref() else { return None };
        let mut read = BTreeMap::new();
        let mut unread = Vec::new();
        for (name, value) in tables {
            let name = name.get_ref().to_string();
            match T::deserialize(ValueDeserializer::from(value.clone())) {
                Ok(table) => {
                    read.insert(name, table);
                }
                Err(error) => {
                    let path = join(key, &name);
                    // The walk has usually explained it already, with a better position.
                    if !self.is_faulty(&path) {
                        let offset = error.span().unwrap_or_else(|| value.span()).start;
                        let TextPosition { line, column } = self.lines.place(offset);
                        let message = error.message().to_owned();
                        let diagnostic = Diagnostic { line, column, message, help: String::new() };
                        self.faults.push(PathDiagnostic { path, diagnostic });
                    }
                    unread.push(name);
                }
            }
        }
        Some((read, unread))
    }

    /// Reads the entries of a list one by one; a faulty one becomes `None`.
    pub(super) fn list<T: DeserializeOwned>(&mut self, key: &str) -> Vec<Option<T>> {
        let Some(DeValue::Array(items)) = self.root.get(key).map(Spanned::get_ref) else {
            return Vec::new();
        };
        let mut read = Vec::new();
        for (index, item) in items.iter().enumerate() {
            let path = join(key, &index.to_string());
            if self.is_faulty(&path) {
                read.push(None);
                continue;
            }
            let entry = T::deserialize(ValueDeserializer::from(item.clone()));
            if let Err(error) = &entry {
                let offset = error.span().unwrap_or_else(|| item.span()).start;
                let TextPosition { line, column } = self.lines.place(offset);
                let message = error.message().to_owned();
                let diagnostic = Diagnostic { line, column, message, help: String::new() };
                self.faults.push(PathDiagnostic { path, diagnostic });
            }
            read.push(entry.ok());
        }
        read
    }

    /// Returns the keys of entry `at` of a list of tables in order of the text, with their values as they are written.
    pub(super) fn written(&self, list: &str, at: usize) -> Vec<[String; 2]> {
        let Some(DeValue::Array(items)) = self.root.get(list).map(Spanned::get_ref) else {
            return Vec::new();
        };
        let Some(DeValue::Table(table)) = items.get(at).map(Spanned::get_ref) else {
            return Vec::new();
        };
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(_, value)| value.span().start);
        let text = |span| self.lines.text.get::<std::ops::Range<usize>>(span).unwrap_or_default();
        let entry = |(key, value): (&Spanned<std::borrow::Cow<'_, str>>, &Spanned<DeValue<'_>>)| {
            [key.get_ref().to_string(), text(value.span()).to_owned()]
        };
        entries.into_iter().map(entry).collect()
    }

    /// Reads the table `key` of entry `index` of a `list`, with the values of the table at the top for the keys that it
    /// leaves out.
    pub(super) fn merged<T: DeserializeOwned>(
        &mut self,
        key: &str,
        [list, index]: [&str; 2],
    ) -> Option<T> {
        let own_path = join(&join(list, index), key);
        if self.is_faulty(key) || self.is_faulty(&own_path) {
            return None;
        }
        let table = |value: &Spanned<DeValue<'t>>| match value.get_ref() {
            DeValue::Table(table) => Some(table.clone()),
            _ => None,
        };
        let entry = match self.root.get(list).map(Spanned::get_ref) {
            Some(DeValue::Array(items)) => index.parse().ok().and_then(|i: usize| items.get(i)),
            _ => None,
        };
        let own = entry.and_then(table).and_then(|entry| entry.get(key).and_then(table));
        let mut merged = self.root.get(key).and_then(table).unwrap_or_default();
        for (name, value) in own.into_iter().flatten() {
            // A key that is there already keeps its place in the job, so it is taken out first.
            merged.remove(name.get_ref().as_ref());
            merged.insert(name, value);
        }
        let value = Spanned::new(0..0, DeValue::Table(merged));
        match T::deserialize(ValueDeserializer::from(value)) {
            Ok(section) => Some(section),
            Err(error) => {
                self.fault(&own_path, error.message().to_owned(), "");
                None
            }
        }
    }

    /// Reads an optional table; an absent one is the default.
    pub(super) fn or_default<T: DeserializeOwned + Default>(&mut self, key: &str) -> Option<T> {
        if self.root.contains_key(key) { self.section(key) } else { Some(T::default()) }
    }

    /// Returns true if a fault was found at this key or inside it.
    pub(super) fn is_faulty(&self, key: &str) -> bool {
        // The dot keeps `axis.B` from matching `axis.B2`.
        let inside = |path: &str| {
            path.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        self.faults.iter().any(|fault| inside(&fault.path))
    }

    /// Returns true if the table itself is faulty: one of its keys was meant to be another.
    pub(super) fn is_misspelt(&self, table: &str) -> bool {
        self.faults.iter().any(|fault| fault.path == table)
    }

    /// Adds a fault at a key.
    pub(super) fn fault(
        &mut self,
        path: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let diagnostic = self.places.fault(path, message).with_help(help);
        self.faults.push(PathDiagnostic { path: path.to_owned(), diagnostic });
    }

    /// Returns the positions of the keys.
    ///
    /// # Errors
    ///
    /// Returns all faults in order of lines, if there are any.
    pub(super) fn finish(self) -> Result<KeyPositions, Diagnostics> {
        if self.faults.is_empty() { Ok(self.places) } else { Err(sorted(self.faults)) }
    }
}

/// Message of the parser for a key that is defined twice; the rest of such a file can be read.
const DUPLICATE: &str = "duplicate key";

fn syntax(place: TextPosition, message: &str) -> Diagnostic {
    let TextPosition { line, column } = place;
    let help = if message == DUPLICATE {
        "it is given above already; keep one of the two"
    } else {
        "a line is `key = value` or `[table]`; text goes in double quotes"
    };
    Diagnostic { line, column, message: message.to_owned(), help: help.to_owned() }
}

/// Sorts diagnostics by position, without duplicates.
fn sorted(faults: Vec<PathDiagnostic>) -> Diagnostics {
    let mut faults: Vec<Diagnostic> = faults.into_iter().map(|fault| fault.diagnostic).collect();
    faults.sort_by(|a, b| (a.line, a.column, &a.message).cmp(&(b.line, b.column, &b.message)));
    faults.dedup();
    faults.into()
}

/// Recognises a file that is no TOML by its first characters.
fn something_else(text: &str, layout: &str) -> Option<Diagnostic> {
    // A byte order mark is no content.
    let start = text.trim_start_matches('\u{feff}').trim_start();
    let starts = |words: &[&str]| words.iter().any(|word| start.starts_with(word));
    let what = if text.contains('\0') {
        "a binary file"
    } else if starts(&["ISO-10303-21"]) {
        "a STEP file"
    } else if starts(&["solid"]) && start.contains("facet") {
        "an STL file"
    } else if starts(&["{", "[{", "[\n{"]) {
        "a JSON file"
    } else if starts(&["<"]) {
        "an XML or HTML file"
    } else if starts(&["%", "N1", "G0", "G1", "G9", "BEGIN PGM", "(", "O0"]) {
        "an NC program"
    } else if starts(&["PARTNO", "PPRINT", "$$", "GOTO", "LOADTL", "MULTAX"]) {
        "a CL file"
    } else {
        return None;
    };
    let kind = kind(layout);
    let message = format!("this is {what}, not a {kind} file");
    let help = format!("a {kind} file is TOML and starts with `schema = \"{layout}\"`");
    Some(Diagnostic { line: 1, column: 1, message, help })
}

/// `trunnion-job/1` -> `job`.
fn kind(layout: &str) -> &str {
    layout.trim_start_matches("trunnion-").split('/').next().unwrap_or(layout)
}

/// Refuses a file of another layout: any further message about it would mislead.
fn other_layout(root: &DeTable<'_>, layout: &str, lines: &LineIndex<'_>) -> Option<Diagnostic> {
    let value = root.get("schema")?;
    let DeValue::String(found) = value.get_ref() else { return None };
    if found == layout {
        return None;
    }
    let TextPosition { line, column } = lines.place(value.span().start);
    let (message, help) = match found.split_once('/') {
        Some((name, version)) if layout.starts_with(&format!("{name}/")) => (
            format!("version {version} of the {} file is not supported", kind(layout)),
            format!("this program reads `{layout}`; a newer program may read this file"),
        ),
        Some((name, _)) if name.starts_with("trunnion-") => (
            format!("this is a {} file, not a {} file", kind(found), kind(layout)),
            format!("give a file with `schema = \"{layout}\"`"),
        ),
        _ => (format!("schema {found:?} is not known"), format!("write `schema = \"{layout}\"`")),
    };
    Some(Diagnostic { line, column, message, help })
}

fn collect_places(
    table: &DeTable<'_>,
    path: &str,
    lines: &LineIndex<'_>,
    places: &mut KeyPositions,
) {
    for (key, value) in table {
        let path = join(path, key.get_ref());
        match value.get_ref() {
            DeValue::Table(inner) => {
                collect_places(inner, &path, lines, places);
                // The span of a table may be its header or its whole body: its key is one word.
                places.insert(path, lines.place(key.span().start));
            }
            DeValue::Array(items) => {
                for (index, item) in items.iter().enumerate() {
                    let path = join(&path, &index.to_string());
                    if let DeValue::Table(inner) = item.get_ref() {
                        collect_places(inner, &path, lines, places);
                    }
                    places.insert(path, lines.place(item.span().start));
                }
                places.insert(path, lines.place(value.span().start));
            }
            _ => places.insert(path, lines.place(value.span().start)),
        }
    }
}
