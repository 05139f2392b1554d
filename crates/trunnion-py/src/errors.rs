//! Failures as Python exceptions.

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::fmt::Display;
use trunnion_cli::Failure;

/// Makes an exception of a class of `trunnion._errors`.
fn exception<'py>(py: Python<'py>, class: &str, messages: Bound<'py, PyTuple>) -> PyErr {
    let made = py
        .import("trunnion._errors")
        .and_then(|module| module.getattr(class))
        .and_then(|class| class.call1(messages));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Returns an `InputError` with the message of a library error.
pub(crate) fn input(py: Python<'_>, message: impl Display) -> PyErr {
    failure(py, Failure::Input(vec![message.to_string()]))
}

/// Returns an `InputError` with the message of a library error and its remedy, which may be empty.
pub(crate) fn input_with(py: Python<'_>, message: impl Display, remedy: &str) -> PyErr {
    let help = if remedy.is_empty() { String::new() } else { format!("\n  help: {remedy}") };
    input(py, format!("{message}{help}"))
}

/// Remedies that name the command line, which a wheel does not bring, and what Python has for them.
const IN_PYTHON: [(&str, &str); 3] = [
    ("`trunnion machine list` names", "`trunnion.built_in()` has"),
    ("numbers from `trunnion inspect`", "numbers of `trunnion.Part.read(..).faces`"),
    ("`trunnion setup` searches", "`Job.setups` searches"),
];

fn in_python(message: &str) -> String {
    IN_PYTHON.iter().fold(message.to_owned(), |text, (shell, here)| text.replace(shell, here))
}

/// Returns the exception for a failure of a verb.
pub(crate) fn failure(py: Python<'_>, failure: Failure) -> PyErr {
    let (class, messages) = match failure {
        Failure::Input(messages) => ("InputError", messages),
        Failure::Unfinished { mut messages, kept } => {
            messages.extend(kept.iter().map(|file| format!("wrote {}", file.display())));
            ("UnfinishedError", messages)
        }
        Failure::Stopped => ("StoppedError", vec!["stopped on request".to_owned()]),
        Failure::Internal(error) => ("InternalError", vec![format!("{error:#}")]),
    };
    match PyTuple::new(py, messages.iter().map(|message| in_python(message))) {
        Ok(messages) => exception(py, class, messages),
        Err(error) => error,
    }
}

/// Argument of a call that cannot be used.
pub(crate) struct WrongArgument<'a> {
    pub(crate) name: &'a str,
    /// Index of the wrong entry; empty if the argument as a whole is wrong.
    pub(crate) index: &'a [usize],
    /// Value of the entry, or shape or type of the argument.
    pub(crate) value: String,
    /// Description of the defect, following the value.
    pub(crate) defect: &'a str,
    pub(crate) remedy: &'a str,
}

impl WrongArgument<'_> {
    /// Returns an `ArgumentError`.
    pub(crate) fn error(&self, py: Python<'_>) -> PyErr {
        let Self { name, index, value, defect, remedy } = self;
        let place = if index.is_empty() { String::new() } else { format!("{index:?}") };
        let help = if remedy.is_empty() { String::new() } else { format!("\n  help: {remedy}") };
        let message = format!("{name}{place} = {value} {defect}{help}");
        let build = || {
            let index = if index.is_empty() {
                py.None().into_bound(py)
            } else {
                PyTuple::new(py, *index)?.into_any()
            };
            // Numbers come back as numbers, everything else as text.
            let value = match value.parse::<f64>() {
                Ok(number) => number.into_pyobject(py)?.into_any(),
                Err(_) => value.into_pyobject(py)?.into_any(),
            };
            let name = name.into_pyobject(py)?.into_any();
            let message = message.into_pyobject(py)?.into_any();
            PyTuple::new(py, [message, name, index, value])
        };
        build().map_or_else(|error| error, |all| exception(py, "ArgumentError", all))
    }
}
