//! Arrays of numbers: checked on the way in, moved on the way out.

use crate::errors::WrongArgument;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use numpy::{PyArrayDescrMethods, PyUntypedArray};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes, PyFloat, PyInt, PyList, PyString, PyTuple};
use std::fmt::Write;

/// Largest difference of the length of a tool axis from 1: vectors that were written with four decimals pass.
const UNIT_ROUNDING: f64 = 1e-4;

/// Numbers of an argument, in C order.
pub(crate) struct Numbers<'py>(PyReadonlyArrayDyn<'py, f64>);

impl<'py> Numbers<'py> {
    /// Takes an array of float64 without a copy, and lists and arrays of whole numbers with one. All entries are
    /// finite.
    pub(crate) fn of(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let numbers = Self::with_gaps(name, value)?;
        numbers.finite(name)?;
        Ok(numbers)
    }

    /// Takes numbers that need not be finite.
    pub(crate) fn with_gaps(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        if let Ok(array) = value.cast::<PyArrayDyn<f64>>() {
            return Self::borrowed(name, array);
        }
        let py = value.py();
        let wrong = |value: String, defect: &str, remedy: &str| {
            WrongArgument { name, index: &[], value, defect, remedy }.error(py)
        };
        let is_text = value.is_instance_of::<PyString>()
            || value.is_instance_of::<PyBytes>()
            || value.is_instance_of::<PyByteArray>();
        if is_text || value.is_none() {
            let kind = value.get_type().name()?.to_string();
            return Err(wrong(kind, "is no array of numbers", "give an array of float64"));
        }
        let numpy = py.import("numpy")?;
        let array = match value.cast::<PyUntypedArray>() {
            Ok(array) => array.clone().into_any(),
            Err(_) => numpy.call_method1("asarray", (value,)).map_err(|error| {
                wrong("value".to_owned(), &format!("is no array of numbers: {error}"), "")
            })?,
        };
        let dtype = array.cast::<PyUntypedArray>()?.dtype();
        let kind = char::from(dtype.kind());
        let is_array = value.is_instance_of::<PyUntypedArray>();
        // Whole numbers are exact as float64; float32 has lost digits that nobody sees.
        let taken = matches!(kind, 'i' | 'u') || (!is_array && kind == 'f');
        if !taken {
            let remedy = "convert it: array.astype(float)";
            return Err(wrong(format!("dtype {dtype}"), "is not float64", remedy));
        }
        let float = numpy.getattr("float64")?;
        let array = numpy.call_method1("ascontiguousarray", (array, float))?;
        Self::borrowed(name, array.cast::<PyArrayDyn<f64>>()?)
    }

    fn borrowed(name: &str, array: &Bound<'py, PyArrayDyn<f64>>) -> PyResult<Self> {
        let wrong = |value: String, defect: &str, remedy: &str| {
            WrongArgument { name, index: &[], value, defect, remedy }.error(array.py())
        };
        if !array.is_c_contiguous() {
            let strides = format!("array with strides {:?}", array.strides());
            let remedy = "copy it: numpy.ascontiguousarray(array)";
            return Err(wrong(strides, "is not contiguous in C order", remedy));
        }
        let read = array.try_readonly();
        let read = read.map_err(|_| wrong("array".to_owned(), "is being written", ""))?;
        // Fields of records and parts of buffers may begin between two numbers.
        if read.as_slice().is_err() {
            let remedy = "copy it: numpy.array(array)";
            return Err(wrong("array".to_owned(), "is not aligned in memory", remedy));
        }
        Ok(Self(read))
    }

    /// Returns the interpreter.
    pub(crate) fn python(&self) -> Python<'py> {
        self.0.py()
    }

    /// Returns the shape.
    pub(crate) fn shape(&self) -> &[usize] {
        self.0.shape()
    }

    /// Returns all numbers.
    pub(crate) fn slice(&self) -> &[f64] {
        self.0.as_slice().unwrap_or_default()
    }

    /// Returns rows of `N` numbers.
    pub(crate) fn rows<const N: usize>(&self) -> &[[f64; N]] {
        self.slice().as_chunks().0
    }

    /// Returns true if no number is NaN or infinite.
    fn are_finite(&self) -> bool {
        // A sum of products with 0 is NaN as soon as one of them is not finite, and needs no branch. Eight sums run
        // side by side, where one would wait for itself.
        let (blocks, rest) = self.slice().as_chunks::<8>();
        let mut sums = [0.0; 8];
        for block in blocks {
            for (sum, value) in sums.iter_mut().zip(block) {
                *sum += value * 0.0;
            }
        }
        let rest = rest.iter().map(|value| value * 0.0);
        rest.chain(sums).sum::<f64>() == 0.0
    }

    /// Refuses NaN and infinity.
    pub(crate) fn finite(&self, name: &str) -> PyResult<()> {
        if self.are_finite() {
            return Ok(());
        }
        let wrong = |(at, value): (usize, &f64)| {
            let index = index_of(at, self.shape());
            let (value, defect) = (value.to_string(), "is not a finite number");
            WrongArgument { name, index: &index, value, defect, remedy: "" }.error(self.0.py())
        };
        let found = self.slice().iter().enumerate().find(|(_, value)| !value.is_finite());
        found.map_or(Ok(()), |found| Err(wrong(found)))
    }

    /// Refuses a shape that is not one of `expected`, where 0 stands for any length.
    pub(crate) fn shaped(&self, name: &str, expected: &[&[usize]]) -> PyResult<()> {
        let shape = self.shape();
        let fits = |expected: &&[usize]| {
            let same = |(wanted, length): (&usize, &usize)| *wanted == 0 || wanted == length;
            expected.len() == shape.len() && expected.iter().zip(shape).all(same)
        };
        if expected.iter().any(fits) {
            return Ok(());
        }
        let words: Vec<String> = expected.iter().map(|shape| shape_words(shape)).collect();
        let defect = format!("is not {}", words.join(" or "));
        let value = format!("shape {}", shape_words(shape));
        Err(WrongArgument { name, index: &[], value, defect: &defect, remedy: "" }
            .error(self.0.py()))
    }

    /// Refuses vectors that are not of length 1.
    pub(crate) fn unit(&self, name: &str) -> PyResult<()> {
        let far = |[x, y, z]: &[f64; 3]| {
            let square = x * x + y * y + z * z;
            (square - 1.0).abs() > 2.0 * UNIT_ROUNDING
        };
        let Some(at) = self.rows::<3>().iter().position(far) else { return Ok(()) };
        let row = self.rows::<3>().get(at).copied().unwrap_or_default();
        let mut index = index_of(3 * at, self.shape());
        index.pop();
        let length = row.iter().map(|value| value * value).sum::<f64>().sqrt();
        let defect = format!("has length {length}, and a tool axis is a unit vector");
        let remedy = "divide it by its length; check that it is no point and no angle";
        let value = format!("{row:?}");
        Err(WrongArgument { name, index: &index, value, defect: &defect, remedy }
            .error(self.0.py()))
    }
}

/// Returns the index of an entry in an array of a shape.
fn index_of(mut at: usize, shape: &[usize]) -> Vec<usize> {
    let mut index: Vec<usize> = shape
        .iter()
        .rev()
        .map(|&length| {
            let here = at % length.max(1);
            at /= length.max(1);
            here
        })
        .collect();
    index.reverse();
    index
}

fn shape_words(shape: &[usize]) -> String {
    let mut words = String::from("(");
    for (place, length) in shape.iter().enumerate() {
        let comma = if place > 0 { ", " } else { "" };
        // Writing to a string cannot fail.
        let _ = match length {
            0 => write!(words, "{comma}n"),
            length => write!(words, "{comma}{length}"),
        };
    }
    words + if shape.len() == 1 { ",)" } else { ")" }
}

/// Takes `N` numbers.
pub(crate) fn numbers<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[f64; N]> {
    if let Some(plain) = plain_numbers(value) {
        return Ok(plain);
    }
    let numbers = Numbers::of(name, value)?;
    numbers.shaped(name, &[&[N]])?;
    Ok(numbers.slice().try_into().unwrap_or([0.0; N]))
}

/// Returns the numbers of a list or tuple of `N` finite ones; most calls have these, and they need no numpy, whose import
/// takes longer than all the rest of the package.
fn plain_numbers<const N: usize>(value: &Bound<'_, PyAny>) -> Option<[f64; N]> {
    if !value.is_instance_of::<PyList>() && !value.is_instance_of::<PyTuple>() {
        return None;
    }
    let is_plain = |one: &Bound<'_, PyAny>| {
        one.is_exact_instance_of::<PyFloat>() || one.is_exact_instance_of::<PyInt>()
    };
    let all = value.try_iter().ok()?.collect::<PyResult<Vec<_>>>().ok()?;
    let numbers = all.iter().map(|one| one.extract().ok().filter(|_| is_plain(one)));
    let numbers: [f64; N] = numbers.collect::<Option<Vec<f64>>>()?.try_into().ok()?;
    numbers.iter().all(|number| number.is_finite()).then_some(numbers)
}

/// Takes a number above 0, or at least 0.
pub(crate) fn positive(py: Python<'_>, name: &str, value: f64) -> PyResult<f64> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    let defect = "is not a number above 0";
    Err(WrongArgument { name, index: &[], value: value.to_string(), defect, remedy: "" }.error(py))
}

/// Most numbers of an array that a call makes \[8 bytes each\]: far beyond any use, and it fits in memory.
const MOST_NUMBERS: f64 = 1_073_741_824.0;

/// Refuses a period at which the rows of a motion would not fit in memory; an allocation that fails ends the interpreter.
pub(crate) fn sampled_rows_fit(
    py: Python<'_>,
    period: f64,
    duration: f64,
    width: usize,
) -> PyResult<()> {
    let rows = duration / period;
    // What is no period at all is refused where it is used.
    let is_period = period > 0.0;
    if rows * width as f64 <= MOST_NUMBERS || !is_period {
        return Ok(());
    }
    let longer = duration * width as f64 / MOST_NUMBERS;
    let defect = format!("s asks for {rows:.3e} rows, which do not fit in memory");
    let remedy = format!("give a period above {longer:.1e} s");
    let (name, value) = ("period", period.to_string());
    Err(WrongArgument { name, index: &[], value, defect: &defect, remedy: &remedy }.error(py))
}

/// Moves numbers into an array of a shape.
pub(crate) fn array<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let flat = PyArray1::from_vec(py, values);
    if shape.len() == 1 {
        return Ok(flat.into_any());
    }
    Ok(flat.reshape(shape.to_vec())?.into_any())
}

/// Moves whole numbers into an array.
pub(crate) fn whole(py: Python<'_>, values: Vec<i64>) -> Bound<'_, PyAny> {
    PyArray1::from_vec(py, values).into_any()
}
