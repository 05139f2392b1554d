//! The import: detects the format, reads it, completes the machine.

use super::control_format::ControlFormat;
use super::draft::MachineDraft;
use super::given::{complete, give};
use super::source_values::SourceValues;
use super::value_origin::ValueOrigin;
use super::{fanuc, freecad, haas, heidenhain, linuxcnc, siemens};
use crate::machine::{Machine, MachineSpec};
use crate::types::{Diagnostic, Diagnostics};
use std::collections::BTreeMap;

/// A file beside the imported one that it names: HAL files and machine files of `LinuxCNC`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CompanionFile {
    /// Name as the imported file writes it.
    pub name: String,
    /// Content.
    pub text: String,
}

/// A machine description to import.
///
/// Begin with [`ImportRequest::new`] and change the rest by struct update.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportRequest<'a> {
    /// Content of the file.
    pub text: &'a str,
    /// Its format; `None`: by its marks.
    pub format: Option<ControlFormat>,
    /// Files that it names.
    pub companions: Vec<CompanionFile>,
    /// Values by key, such as `axis.C.limits`, for what the file does not state; they win over those of the file.
    pub given: BTreeMap<String, String>,
}

impl<'a> ImportRequest<'a> {
    /// Creates the request for a text alone.
    pub fn new(text: &'a str) -> Self {
        Self { text, format: None, companions: Vec::new(), given: BTreeMap::new() }
    }
}

/// A machine that was imported.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ImportedMachine {
    /// Format that was read.
    pub format: ControlFormat,
    /// The machine; [`Machine::new`] accepts it.
    pub spec: MachineSpec,
    /// Values of the file with the keys that they became.
    pub origins: Vec<ValueOrigin>,
    /// Statements that the format or its manual leaves open.
    pub notes: Vec<String>,
}

/// Imports a machine.
///
/// # Errors
///
/// Every value that cannot be used, with its line, and every value that is missing, with its key.
pub fn import_machine(request: &ImportRequest<'_>) -> Result<ImportedMachine, Diagnostics> {
    let format =
        request.format.or_else(|| ControlFormat::detect(request.text)).ok_or_else(|| {
            let names: Vec<&str> = ControlFormat::ALL.iter().map(|(name, _)| *name).collect();
            Diagnostics::from(
                Diagnostic::whole("the file has the marks of no format that is read")
                    .with_help(format!("state its format if it is one of {}", names.join(", "))),
            )
        })?;
    let mut values = SourceValues::default();
    let draft = read(format, request, &mut values);
    let SourceValues { mut faults, mut origins, .. } = values;
    let Some(mut draft) = draft else {
        if faults.is_empty() {
            faults.push(Diagnostic::whole(format!(
                "the file states no machine of {}",
                format.name()
            )));
        }
        return Err(faults.into());
    };
    give(&mut draft, &request.given, &mut faults);
    origins.extend(request.given.iter().map(|(key, value)| ValueOrigin {
        line: 0,
        key: "given".to_owned(),
        value: value.clone(),
        target: key.clone(),
    }));
    let notes = draft.notes.clone();
    let spec = complete(draft, &mut faults);
    if faults.is_empty()
        && let Err(errors) = Machine::new(spec.clone())
    {
        let fault = |error: &crate::machine::MachineError| {
            let help = format!("{}; give {} if the file is right", error.remedy(), error.key());
            Diagnostic::whole(error.to_string()).with_help(help)
        };
        faults.extend(errors.iter().map(fault));
    }
    if faults.is_empty() {
        Ok(ImportedMachine { format, spec, origins, notes })
    } else {
        Err(faults.into())
    }
}

fn read(
    format: ControlFormat,
    request: &ImportRequest<'_>,
    values: &mut SourceValues,
) -> Option<MachineDraft> {
    match format {
        ControlFormat::LinuxCnc => {
            linuxcnc::read(request.text, &request.companions_by_name(), values)
        }
        ControlFormat::Siemens => siemens::read(request.text, values),
        ControlFormat::Heidenhain => heidenhain::read(request.text, values),
        ControlFormat::Fanuc => fanuc::read(request.text, values),
        ControlFormat::Haas => haas::read(request.text, values),
        ControlFormat::FreeCad => freecad::read(request.text, values),
    }
}

impl ImportRequest<'_> {
    fn companions_by_name(&self) -> BTreeMap<&str, &str> {
        self.companions.iter().map(|one| (one.name.as_str(), one.text.as_str())).collect()
    }
}
