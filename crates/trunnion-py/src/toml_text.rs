//! Dictionaries as TOML text, and back.

use crate::errors::{failure, input};
use crate::verbs::json;
use pyo3::prelude::*;
use trunnion::types::Diagnostic;
use trunnion_cli::Failure;

/// Returns the TOML text of a dictionary of plain values and arrays.
#[pyfunction]
pub(crate) fn toml_text(source: &Bound<'_, PyAny>) -> PyResult<String> {
    let py = source.py();
    let text = py.import("trunnion._rebuild")?.call_method1("json_text", (source,));
    let text: String = text.map_err(|error| input(py, error.value(py)))?.extract()?;
    let value: serde_json::Value = serde_json::from_str(&text).map_err(|error| input(py, error))?;
    toml::to_string(&value).map_err(|error| input(py, error))
}

/// Returns the content of TOML text.
#[pyfunction]
pub(crate) fn toml_data<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let value: toml::Value = toml::from_str(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        let fault = Diagnostic::at(text, at, error.message()).to_string();
        failure(py, Failure::Input(vec![fault]))
    })?;
    json(py, &value)
}
