//! Native module of the Python package `trunnion`: arrays in, library calls, arrays out.
//!
//! Options, documentation for users and pictures are in `python/trunnion`.

#![expect(clippy::doc_markdown, reason = "documentation of classes is read in Python")]
#![expect(clippy::needless_pass_by_value, reason = "arguments of a Python call become values")]

mod arrays;
mod cutter;
mod drop;
mod errors;
mod feed;
mod job;
mod locate;
mod machine;
mod part;
mod path;
mod progress;
mod scalar;
mod toml_text;
mod verbs;

use pyo3::prelude::*;

/// Native half of the package `trunnion`.
#[pymodule]
fn _trunnion(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<machine::Machine>()?;
    module.add_class::<part::Part>()?;
    module.add_class::<part::Face>()?;
    module.add_class::<cutter::Cutter>()?;
    module.add_class::<job::NativeJob>()?;
    module.add_class::<job::NativeRun>()?;
    module.add_class::<feed::NativePlan>()?;
    module.add_class::<feed::NativeStream>()?;
    let functions = [
        wrap_pyfunction!(machine::built_in, module)?,
        wrap_pyfunction!(machine::import_machine, module)?,
        wrap_pyfunction!(machine::calibrate_machine, module)?,
        wrap_pyfunction!(toml_text::toml_text, module)?,
        wrap_pyfunction!(toml_text::toml_data, module)?,
        wrap_pyfunction!(drop::drop_cutter, module)?,
        wrap_pyfunction!(drop::read_mesh, module)?,
        wrap_pyfunction!(locate::position, module)?,
        wrap_pyfunction!(locate::cover, module)?,
        wrap_pyfunction!(path::interpolate, module)?,
        wrap_pyfunction!(path::smooth, module)?,
        wrap_pyfunction!(path::linearise, module)?,
        wrap_pyfunction!(feed::plan, module)?,
        wrap_pyfunction!(feed::plan_columns, module)?,
        wrap_pyfunction!(verbs::check, module)?,
        wrap_pyfunction!(verbs::subprograms, module)?,
        wrap_pyfunction!(verbs::post, module)?,
        wrap_pyfunction!(verbs::moves, module)?,
        wrap_pyfunction!(verbs::propose, module)?,
        wrap_pyfunction!(verbs::setup, module)?,
    ];
    functions.into_iter().try_for_each(|function| module.add_function(function))
}
