//! Single values of a call: numbers, truth values, texts.

use crate::errors::WrongArgument;
use pyo3::conversion::FromPyObjectOwned;
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt};

/// Longest number that stands in a message as it is.
const SHOWN: usize = 40;

/// Value that an argument may be as a whole.
pub(crate) trait Scalar {
    /// Description of the defect of everything else, following the value.
    const DEFECT: &'static str;
}

/// Takes an argument, by `#[pyo3(from_py_with = scalar)]`; the exception of the extraction is not shown.
///
/// An `ArgumentError` gets its name from the note that `PyO3` adds to every exception of an argument.
pub(crate) fn scalar<'py, T: Scalar + FromPyObjectOwned<'py>>(
    value: &Bound<'py, PyAny>,
) -> PyResult<T> {
    value.extract().map_err(|_| {
        let (py, value, defect) = (value.py(), words(value), T::DEFECT);
        WrongArgument { name: "", index: &[], value, defect, remedy: "" }.error(py)
    })
}

/// Returns a number as it is, and the type of everything else.
fn words(value: &Bound<'_, PyAny>) -> String {
    let is_number = value.is_instance_of::<PyFloat>() || value.is_instance_of::<PyInt>();
    let number = is_number.then(|| value.to_string()).filter(|text| text.len() <= SHOWN);
    number.unwrap_or_else(|| {
        value.get_type().name().map_or_else(|_| "?".to_owned(), |name| name.to_string())
    })
}

impl Scalar for f64 {
    const DEFECT: &'static str = "is not a number";
}

impl Scalar for bool {
    const DEFECT: &'static str = "is neither True nor False";
}

impl Scalar for u16 {
    const DEFECT: &'static str = "is not a whole number from 0 to 65535";
}

impl Scalar for String {
    const DEFECT: &'static str = "is not a text";
}

/// Degrees by u and v.
impl Scalar for [usize; 2] {
    const DEFECT: &'static str = "is not two whole numbers from 0";
}

/// Knots by u and v.
impl Scalar for [Vec<f64>; 2] {
    const DEFECT: &'static str = "is not two lists of numbers";
}

impl<T: Scalar> Scalar for Option<T> {
    const DEFECT: &'static str = T::DEFECT;
}
