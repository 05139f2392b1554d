//! `trunnion.check`, `trunnion.post` and `trunnion.read`: the verbs of the command line.

use crate::arrays::{array, whole};
use crate::errors::failure;
use crate::progress::watched;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use trunnion::post::PostPace;
use trunnion::verify::{FaceMap, HeightSample};
use trunnion_cli::calls::{self, MovesAnswer};

/// Returns a summary as Python data.
pub(crate) fn json<'py>(
    py: Python<'py>,
    value: &impl serde::Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value)
        .map_err(|error| pyo3::exceptions::PyRuntimeError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Checks a program, CL file or table of setpoints.
#[pyfunction]
#[pyo3(signature = (options, progress=None))]
pub(crate) fn check(
    py: Python<'_>,
    options: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'_, PyDict>> {
    let found = watched(py, progress.as_ref(), |watch| calls::check(&options, watch))?
        .map_err(|error| failure(py, error))?;
    let answer = PyDict::new(py);
    answer.set_item("summary", json(py, &found.summary)?)?;
    answer.set_item("table", &found.table)?;
    answer.set_item("passed", found.passed)?;
    let maps = found.found.as_ref().map_or(&[][..], |found| &found.report.maps);
    answer.set_item("maps", maps_of(py, maps)?)?;
    Ok(answer)
}

/// Returns name and text of each subprogram that a program runs.
#[pyfunction]
pub(crate) fn subprograms(py: Python<'_>, options: Vec<String>) -> PyResult<Vec<(String, String)>> {
    let found = py.detach(|| calls::subprograms(&options)).map_err(|error| failure(py, error))?;
    Ok(found.into_iter().map(|file| (file.name, file.text)).collect())
}

/// Returns the measured points of faces: point, height, line.
pub(crate) fn maps_of<'py>(py: Python<'py>, maps: &[FaceMap]) -> PyResult<Bound<'py, PyList>> {
    let map_of = |map: &FaceMap| {
        let samples: Vec<&HeightSample> = map.samples.iter().flatten().collect();
        let answer = PyDict::new(py);
        let points = samples.iter().flat_map(|of| <[f64; 3]>::from(of.point.coords)).collect();
        let heights = samples.iter().map(|of| of.height.unwrap_or(f64::NAN)).collect();
        let lines = samples.iter().map(|of| i64::from(of.line.unwrap_or(0))).collect();
        answer.set_item("face", map.face)?;
        answer.set_item("point", array(py, points, &[samples.len(), 3])?)?;
        answer.set_item("height", array(py, heights, &[samples.len()])?)?;
        answer.set_item("line", whole(py, lines))?;
        Ok(answer)
    };
    let made: PyResult<Vec<Bound<'py, PyDict>>> = maps.iter().map(map_of).collect();
    PyList::new(py, made?)
}

/// Posts a CL file or program.
#[pyfunction]
#[pyo3(signature = (options, progress=None))]
pub(crate) fn post(
    py: Python<'_>,
    options: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'_, PyDict>> {
    let found = watched(py, progress.as_ref(), |watch| calls::post(&options, watch))?
        .map_err(|error| failure(py, error))?;
    let answer = PyDict::new(py);
    answer.set_item("summary", json(py, &found.summary)?)?;
    answer.set_item("table", &found.table)?;
    answer.set_item("kept", found.kept)?;
    answer.set_item("warnings", found.warnings)?;
    Ok(answer)
}

/// Returns the text of a proposed job, and remarks about the part.
#[pyfunction]
#[pyo3(signature = (options, progress=None))]
pub(crate) fn propose(
    py: Python<'_>,
    options: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Vec<String>)> {
    let found = watched(py, progress.as_ref(), |watch| calls::propose(&options, watch))?
        .map_err(|error| failure(py, error))?;
    Ok((found.job, found.warnings))
}

/// Searches setups of a job.
#[pyfunction]
#[pyo3(signature = (options, progress=None))]
pub(crate) fn setup(
    py: Python<'_>,
    options: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'_, PyAny>, String)> {
    let found = watched(py, progress.as_ref(), |watch| calls::setup(&options, watch))?
        .map_err(|error| failure(py, error))?;
    Ok((json(py, &found.summary)?, found.table))
}

/// Reads the moves of a CL file or program.
#[pyfunction]
#[pyo3(signature = (options, progress=None))]
pub(crate) fn moves(
    py: Python<'_>,
    options: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'_, PyDict>> {
    let found = watched(py, progress.as_ref(), |watch| calls::moves(&options, watch))?
        .map_err(|error| failure(py, error))?;
    let MovesAnswer { moves: found, warnings, .. } = found;
    let count = found.len();
    let answer = PyDict::new(py);
    let tips = found.iter().flat_map(|one| <[f64; 3]>::from(one.pose.tip.coords)).collect();
    let axes = found.iter().flat_map(|one| <[f64; 3]>::from(one.pose.axis.into_inner())).collect();
    let positions = found.iter().flat_map(|one| one.q.map_or([f64::NAN; 5], Into::into)).collect();
    let lines = found.iter().map(|one| i64::from(one.line)).collect();
    // Rapid moves have no feed, moves with a time have that.
    let feeds = found.iter().map(|one| match one.pace {
        PostPace::Feed(feed) => feed,
        _ => f64::NAN,
    });
    let seconds = found.iter().map(|one| match one.pace {
        PostPace::Seconds(seconds) => seconds,
        _ => f64::NAN,
    });
    answer.set_item("warnings", warnings)?;
    answer.set_item("tip", array(py, tips, &[count, 3])?)?;
    answer.set_item("axis", array(py, axes, &[count, 3])?)?;
    answer.set_item("q", array(py, positions, &[count, 5])?)?;
    answer.set_item("line", whole(py, lines))?;
    answer.set_item("feed", array(py, feeds.collect(), &[count])?)?;
    answer.set_item("seconds", array(py, seconds.collect(), &[count])?)?;
    Ok(answer)
}
