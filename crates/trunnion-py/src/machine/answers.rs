//! Imports and calibrations: verbs that answer with a machine.

use crate::errors::failure;
use crate::verbs::json;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trunnion_cli::calls;

/// Turns the description of a machine into a machine file.
#[pyfunction]
pub(crate) fn import_machine(py: Python<'_>, options: Vec<String>) -> PyResult<Bound<'_, PyDict>> {
    let found = py.detach(|| calls::import(&options)).map_err(|error| failure(py, error))?;
    let answer = PyDict::new(py);
    answer.set_item("summary", json(py, &found.summary)?)?;
    answer.set_item("table", found.table)?;
    answer.set_item("text", found.text)?;
    Ok(answer)
}

/// Finds the errors of a machine from measured spheres.
#[pyfunction]
pub(crate) fn calibrate_machine(
    py: Python<'_>,
    options: Vec<String>,
) -> PyResult<Bound<'_, PyDict>> {
    let found = py.detach(|| calls::calibrate(&options)).map_err(|error| failure(py, error))?;
    let answer = PyDict::new(py);
    answer.set_item("summary", json(py, &found.summary)?)?;
    answer.set_item("table", found.table)?;
    answer.set_item("text", found.text)?;
    answer.set_item("complete", found.complete)?;
    Ok(answer)
}
