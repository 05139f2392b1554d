//! Single values of a call: numbers, truth values, texts.

use crate::errors::WrongArgument;
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt};

/// Longest number that stands in a message as it is.
const SHOWN: usize = 40;

/// Value that an argument may be as a whole.
pub(crate) trait Scalar: Sized {
    /// Description of the defect of everything else, following the value.
    const DEFECT: &'static str;

    /// Takes a value; the exception is not shown.
    fn of(value: &Bound<'_, PyAny>) -> PyResult<Self>;
}

/// Takes an argument, by `#[pyo3(from_py_with = scalar)]`.
///
/// An `ArgumentError` gets its name from the note that `PyO3` adds to every exception of an argument.
pub(crate) fn scalar<T: Scalar>(value: &Bound<'_, PyAny>) -> PyResult<T> {
    T::of(value).map_err(|_| {
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

    fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        value.extract()
    }
}

impl Scalar for bool {
    const DEFECT: &'static str = "is neither True nor False";

    fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        value.extract()
    }
}

impl Scalar for u16 {
    const DEFECT: &'static str = "is not a whole number from 0 to 65535";

    fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        value.extract()
    }
}

impl Scalar for String {
    const DEFECT: &'static str = "is not a text";

    fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        value.extract()
    }
}

/// Degrees by u and v.
impl Scalar for [usize; 2] {
    const DEFECT: &'static str = "is not two whole numbers from 0";

    fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        value.extract()
    }
}

/// Knots by u and v.
impl Scalar for [Vec<f64>; 2] {
    const DEFECT: &'static str = "is not two lists of numbers";

    fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        value.extract()
    }
}

impl<T: Scalar> Scalar for Option<T> {
    const DEFECT: &'static str = T::DEFECT;

    fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        if value.is_none() { Ok(None) } else { T::of(value).map(Some) }
    }
}
