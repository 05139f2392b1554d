//! Native module of the Python package `trunnion`.

use pyo3::prelude::*;

/// Native half of the package `trunnion`.
#[pymodule]
fn _trunnion(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))
}
