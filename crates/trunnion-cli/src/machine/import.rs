//! `trunnion machine import`: a machine file from the description of a control or of `FreeCAD`.

use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::{disk, output, text};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trunnion::files::foreign::{
    CompanionFile, ControlFormat, ImportRequest, ImportedMachine, ValueOrigin, import_machine,
};
use trunnion::files::machine::write;
use trunnion::types::Diagnostic;

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ImportArgs {
    /// Description to import.
    file: PathBuf,
    /// Machine file to write; without it, the result is only printed.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Format of the description [default: by its text].
    #[arg(long, value_parser = format)]
    from: Option<ControlFormat>,
    /// Value that the description does not state, such as axis.C.limits=endless or linear.jerk=50000. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value, allow_hyphen_values = true)]
    given: Vec<(String, String)>,
}

const EXAMPLES: &str = "\
Formats (--from):
  linuxcnc    INI file; HAL files and the machine file that it names are read beside it; kinematics xyzac-trt-kins,
              xyzbc-trt-kins, xyzab_tdr_kins, 5axiskins and trunnionkins
  siemens     machine data as text: $MC_TRAFO_TYPE_1 24, 40 or 56, $MC_TRAFO5_... with angle offsets and senses of
              the rotary axes, $MC_AXCONF_..., $MA_...
  heidenhain  description table of the kinematics, with KEY, AXIS, COORD
  fanuc       parameters as punched out: 19680 to 19714 (tilted axes too), 1020, 1320, 1321, 1430, 1660
  haas        list of settings: 9, and 255 to 257 or 300 to 305 (MRZP)
  freecad     .fcm file
Everything that a description does not state is asked for by key; --set gives it, and wins over the file. Keys:
  name, chain=w,C,B,b,X,Y,Z,t, gauge=X,Y,Z, tool_axis=X,Y,Z,
  axis.NAME.FIELD, or linear.FIELD and rotary.FIELD for all, with FIELD
  dir=X,Y,Z  point=X,Y,Z  limits=LOW,HIGH|endless  sense=1|-1  vel  acc  jerk   (mm, deg, s)

  trunnion machine import xyzac-trt.ini --set linear.jerk=5000 --set rotary.jerk=3000 -o my.toml
  trunnion machine show my.toml";

fn format(name: &str) -> Result<ControlFormat, String> {
    let names = ControlFormat::ALL.map(|(name, _)| name);
    ControlFormat::from_name(name).ok_or_else(|| format!("write one of {}", names.join(", ")))
}

pub(super) fn key_value(word: &str) -> Result<(String, String), String> {
    let (key, value) = word.split_once('=').ok_or("write KEY=VALUE")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

pub(crate) fn run(args: &ImportArgs, form: OutputForm) -> Result<Done, Failure> {
    if let Some(path) = &args.output {
        output::refuse_existing(path)?;
    }
    let found = answer(args)?;
    if let Some(path) = &args.output {
        output::file(path, |out| out.write_all(found.text.as_bytes()))?;
    }
    form.print(&found.summary, ImportSummary::describe)
}

/// Machine that was imported, for callers in other languages.
#[derive(Debug)]
#[non_exhaustive]
pub struct ImportAnswer {
    /// Summary as `--json` prints it.
    pub summary: ImportSummary,
    /// The same for people.
    pub table: String,
    /// The machine file.
    pub text: String,
}

/// Imports a description, and writes nothing.
pub(crate) fn answer(args: &ImportArgs) -> Result<ImportAnswer, Failure> {
    let content = text::read(&args.file)?;
    let given: BTreeMap<String, String> = args.given.iter().cloned().collect();
    let request = ImportRequest {
        format: args.from,
        companions: companions(&args.file, &content),
        given,
        ..ImportRequest::new(&content)
    };
    let imported = import_machine(&request).map_err(|faults| {
        let with_flag: Vec<Diagnostic> = faults.iter().map(with_flag).collect();
        Failure::faults(&args.file, &with_flag)
    })?;
    let summary = ImportSummary::new(args, &imported);
    let text = write(&imported.spec, &summary.comments());
    Ok(ImportAnswer { table: summary.describe(), summary, text })
}

/// Words the remedy for a missing value with the flag of this command line.
fn with_flag(fault: &Diagnostic) -> Diagnostic {
    match fault.help.strip_prefix("give ") {
        Some(rest) => fault.clone().with_help(format!("--set KEY=VALUE: give {rest}")),
        None if fault.help.starts_with("state its format") => {
            fault.clone().with_help(format!("--from FORMAT: {}", fault.help))
        }
        None => fault.clone(),
    }
}

/// Reads the files beside an INI file that it may name.
fn companions(file: &Path, content: &str) -> Vec<CompanionFile> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let named = |line: &str| -> Option<String> {
        let (key, value) = line.split_once('=')?;
        match key.trim() {
            "HALFILE" => Some(value.trim().to_owned()),
            "KINEMATICS" => {
                let machine =
                    value.split_whitespace().find_map(|word| word.strip_prefix("machine="));
                machine.map(str::to_owned)
            }
            _ => None,
        }
    };
    let names = content.lines().filter_map(named);
    names
        .filter(|name| disk::is_file(&folder.join(name)))
        .filter_map(|name| {
            Some(CompanionFile { text: text::read(&folder.join(&name)).ok()?, name })
        })
        .collect()
}

/// Result for scripts.
#[derive(Debug, serde::Serialize)]
pub struct ImportSummary {
    file: String,
    format: &'static str,
    name: String,
    chain: Vec<String>,
    values: Vec<OriginJson>,
    /// Statements that the description or its manual leaves open.
    open: Vec<String>,
    output: Option<String>,
}

#[derive(Debug, serde::Serialize)]
struct OriginJson {
    line: u64,
    key: String,
    value: String,
    became: String,
}

impl ImportSummary {
    fn new(args: &ImportArgs, imported: &ImportedMachine) -> Self {
        let origin = |ValueOrigin { line, key, value, target, .. }: &ValueOrigin| OriginJson {
            line: *line,
            key: key.clone(),
            value: value.clone(),
            became: target.clone(),
        };
        Self {
            file: args.file.display().to_string(),
            format: imported.format.name(),
            name: imported.spec.name.clone(),
            chain: imported.spec.chain.clone(),
            values: imported.origins.iter().map(origin).collect(),
            open: imported.notes.clone(),
            output: args.output.as_ref().map(|path| path.display().to_string()),
        }
    }

    fn describe(&self) -> String {
        let mut text = format!("{}: {}, read as {}\n", self.file, self.name, self.format);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "chain {}\n\n{}", self.chain.join(" - "), self.table().join("\n"));
        for note in &self.open {
            let _ = writeln!(text, "\nopen: {note}");
        }
        if let Some(output) = &self.output {
            let _ = writeln!(
                text,
                "\nwrote {output}; compare its signs with the machine: trunnion machine show {output}"
            );
        }
        text
    }

    fn table(&self) -> Vec<String> {
        let wide = self.values.iter().map(|one| one.key.chars().count()).max().unwrap_or(0).max(5);
        let row = |line: &str, key: &str, value: &str, became: &str| {
            format!("{line:>5}  {key:<wide$}  {value:>12}  {became}")
        };
        let rows = self.values.iter().map(|one| {
            let line = if one.line == 0 { String::new() } else { one.line.to_string() };
            row(&line, &one.key, &one.value, &one.became)
        });
        std::iter::once(row("line", "value", "", "became")).chain(rows).collect()
    }

    /// Returns the comments of the machine file.
    fn comments(&self) -> Vec<String> {
        let mut notes = vec![format!("Imported by trunnion from {} ({}).", self.file, self.format)];
        notes.extend(self.open.iter().map(|note| format!("Open: {note}")));
        notes.extend(self.table());
        notes
    }
}
