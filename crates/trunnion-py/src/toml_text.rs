//! Dictionaries as TOML text, and back: every number keeps its last digit.

use crate::errors::{failure, input};
use crate::scalar::scalar;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};
use toml::Value;
use trunnion::types::Diagnostic;
use trunnion_cli::Failure;

/// Returns the TOML text of a dictionary of plain values and arrays.
#[pyfunction]
pub(crate) fn toml_text(source: &Bound<'_, PyAny>) -> PyResult<String> {
    let py = source.py();
    let plain = py.import("trunnion._rebuild")?.call_method1("plain", (source,));
    let plain = plain.map_err(|error| input(py, error.value(py)))?;
    let table = value_of(&plain).map_err(|error| input(py, error.value(py)))?;
    toml::to_string(&table).map_err(|error| input(py, error))
}

/// Returns the content of TOML text.
#[pyfunction]
pub(crate) fn toml_data(
    py: Python<'_>,
    #[pyo3(from_py_with = scalar)] text: String,
) -> PyResult<Bound<'_, PyAny>> {
    let table: toml::Table = toml::from_str(&text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        let fault = Diagnostic::at(&text, at, error.message()).to_string();
        failure(py, Failure::Input(vec![fault]))
    })?;
    python_of(py, &Value::Table(table))
}

/// Takes nested dicts and lists of truth values, numbers and texts.
fn value_of(source: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(table) = source.cast::<PyDict>() {
        let entry = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            Ok((key.extract::<String>()?, value_of(&value)?))
        };
        return table.iter().map(entry).collect::<PyResult<_>>().map(Value::Table);
    }
    if let Ok(list) = source.cast::<PyList>() {
        return list.iter().map(|one| value_of(&one)).collect::<PyResult<_>>().map(Value::Array);
    }
    // A truth value is a whole number as well, in Python.
    if source.is_instance_of::<PyBool>() {
        return source.extract().map(Value::Boolean);
    }
    if source.is_instance_of::<PyInt>() {
        return source.extract().map(Value::Integer);
    }
    if source.is_instance_of::<PyFloat>() {
        return source.extract().map(Value::Float);
    }
    source.extract().map(Value::String)
}

fn python_of<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Table(table) => {
            let made = PyDict::new(py);
            for (key, value) in table {
                made.set_item(key, python_of(py, value)?)?;
            }
            made.into_any()
        }
        Value::Array(list) => {
            let made: PyResult<Vec<_>> = list.iter().map(|one| python_of(py, one)).collect();
            PyList::new(py, made?)?.into_any()
        }
        Value::Boolean(value) => PyBool::new(py, *value).to_owned().into_any(),
        Value::Integer(value) => value.into_pyobject(py)?.into_any(),
        Value::Float(value) => PyFloat::new(py, *value).into_any(),
        Value::String(text) => PyString::new(py, text).into_any(),
        Value::Datetime(time) => PyString::new(py, &time.to_string()).into_any(),
    })
}
