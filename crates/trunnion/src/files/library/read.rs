//! Library files, read and checked.

use super::super::document::Document;
use super::super::job::JobTool;
use super::super::job::raw::RawTool;
use super::super::job::tool::tool;
use super::super::schema;
use super::raw::{LAYOUT, LibraryHolder, LibraryMachine};
use crate::types::{Diagnostic, Diagnostics};

const STANDARD: &str = include_str!("../../../../../library/standard.toml");

/// Library that was read and checked.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct LibraryFile {
    /// Name.
    pub name: String,
    /// Cutters in the order of the file; each name is there once.
    pub cutters: Vec<LibraryCutter>,
    /// Holders, likewise.
    pub holders: Vec<LibraryHolder>,
    /// Machines, likewise.
    pub machines: Vec<LibraryMachine>,
}

/// Cutter of a library.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LibraryCutter {
    /// Name.
    pub name: String,
    /// The cutter as the tool of a job.
    pub tool: JobTool,
    /// Keys of the tool with their values in TOML, as the file has them.
    pub keys: Vec<[String; 2]>,
}

/// Returns the library that comes with trunnion: `library/standard.toml`.
pub fn standard() -> LibraryFile {
    // A test reads it; a library of nothing is the only answer without a panic.
    parse(STANDARD).unwrap_or_default()
}

/// Reads a library.
///
/// # Errors
///
/// Every fault that was found, in order of lines.
///
/// # Example
///
/// ```
/// use trunnion::files::library::{parse, standard};
///
/// let own = "schema = \"trunnion-library/1\"\nname = \"shop\"\n
///     [[cutter]]\nname = \"finisher\"\nnumber = 7\nkind = \"ball\"\ndiameter = 6\nlength = 85\n";
/// let own = parse(own).map_err(|faults| faults.to_string())?;
/// assert_eq!(own.cutters[0].tool.minor, 3.0);
/// assert!(standard().cutters.len() > 20);
/// # Ok::<(), String>(())
/// ```
pub fn parse(text: &str) -> Result<LibraryFile, Diagnostics> {
    let mut doc = Document::open(text, LAYOUT, &schema::library_value())?;
    let name = doc.section("name");
    let cutters = cutters(&mut doc);
    let holders: Vec<LibraryHolder> = doc.list("holder").into_iter().flatten().collect();
    for (at, holder) in holders.iter().enumerate() {
        if holder.profile.windows(2).any(|pair| pair[1][0] < pair[0][0]) {
            let path = format!("holder.{at}.profile");
            doc.fault(&path, "the heights fall", "give them from below up, in mm");
        }
    }
    let machines: Vec<LibraryMachine> = doc.list("machine").into_iter().flatten().collect();
    refuse_twins("cutter", &cutters.iter().map(|one| &one.name).collect::<Vec<_>>(), &mut doc);
    refuse_twins("holder", &holders.iter().map(|one| &one.name).collect::<Vec<_>>(), &mut doc);
    refuse_twins("machine", &machines.iter().map(|one| &one.name).collect::<Vec<_>>(), &mut doc);
    doc.finish()?;
    let name = name.ok_or_else(|| Diagnostic::whole("the library has no name"))?;
    Ok(LibraryFile { name, cutters, holders, machines })
}

fn cutters(doc: &mut Document<'_>) -> Vec<LibraryCutter> {
    let mut all = Vec::new();
    for (at, raw) in doc.list::<RawTool>("cutter").into_iter().enumerate() {
        let path = format!("cutter.{at}");
        let Some(raw) = raw else { continue };
        let Some(name) = raw.name.clone() else {
            doc.fault(&path, "a cutter of a library needs a name", "add `name = \"...\"`");
            continue;
        };
        if raw.holder_file.is_some() {
            let message = "a cutter of a library has its holder as a profile, not in a file";
            doc.fault(
                &format!("{path}.holder_file"),
                message,
                "write it as `holder`, or name the file in the job",
            );
        }
        let keys = doc.written("cutter", at);
        all.extend(tool(raw, &path, doc).map(|tool| LibraryCutter { name, tool, keys }));
    }
    all
}

/// Reports names that are given twice: a choice by name would be one by chance.
fn refuse_twins(key: &str, names: &[&String], doc: &mut Document<'_>) {
    for (at, name) in names.iter().enumerate() {
        if names.iter().take(at).any(|other| other == name) {
            let message = format!("there are two {key}s with the name \"{name}\"");
            doc.fault(&format!("{key}.{at}.name"), message, "give each its own name");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::job::ToolKind;

    const HEAD: &str = "schema = \"trunnion-library/1\"\nname = \"shop\"\n";
    const BALL: &str = "[[cutter]]\nname = \"ball\"\nnumber = 3\nkind = \"ball\"\ndiameter = 6 # new\nlength = 85\n";

    fn faults(text: &str) -> String {
        let faults = parse(&format!("{HEAD}{text}")).unwrap_err();
        faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn the_standard_library_has_every_kind_that_proposals_need() {
        let file = parse(STANDARD).unwrap();
        for kind in [ToolKind::Flat, ToolKind::Bull, ToolKind::Ball] {
            assert!(file.cutters.iter().any(|one| one.tool.kind == kind));
        }
        assert_eq!(file, standard());
    }

    #[test]
    fn keys_are_those_of_the_file() {
        let file = parse(&format!("{HEAD}{BALL}")).unwrap();
        let keys: Vec<String> =
            file.cutters[0].keys.iter().map(|[key, value]| format!("{key} = {value}")).collect();
        assert_eq!(
            keys,
            ["name = \"ball\"", "number = 3", "kind = \"ball\"", "diameter = 6", "length = 85"]
        );
    }

    #[test]
    fn faults_are_at_their_lines() {
        assert!(faults(&format!("{BALL}{BALL}")).contains("two cutters with the name \"ball\""));
        assert!(faults(&BALL.replace("name = \"ball\"\n", "")).contains("needs a name"));
        assert!(faults(&BALL.replace("diameter", "diametre")).contains("diametre"));
        let drawn = faults(&format!("{BALL}holder_file = \"chuck.stl\"\n"));
        assert!(drawn.contains("not in a file"), "{drawn}");
        let falling = "[[holder]]\nname = \"chuck\"\nprofile = [[30, 10], [0, 8]]\n";
        assert!(faults(falling).contains("the heights fall"));
    }
}
