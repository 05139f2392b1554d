//! Jobs and their runs.

use crate::arrays::{array, sampled_rows_fit, whole};
use crate::errors::failure;
use crate::locate::pass_of;
use crate::machine::AngleUnit;
use crate::progress::{Listeners, SLICE, heard};
use crate::scalar::scalar;
use crate::verbs::{json, maps_of};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::Arc;
use trunnion::setpoint;
use trunnion::types::{AXES, AxisVector, Leg, Setpoint, Silent};
use trunnion_cli::calls::{self, JobAnswer, LoadedJob};

/// Position of a setpoint, or one of its derivatives.
type SetpointPart = fn(&Setpoint) -> &AxisVector;

/// Job that was read with the files that it names.
#[pyclass(module = "trunnion._trunnion", name = "NativeJob", frozen)]
#[derive(Debug)]
pub(crate) struct NativeJob {
    path: PathBuf,
    loaded: Arc<LoadedJob>,
}

/// Result of a run.
#[pyclass(module = "trunnion._trunnion", name = "NativeRun", frozen)]
#[derive(Debug)]
pub(crate) struct NativeRun {
    loaded: Arc<LoadedJob>,
    answer: JobAnswer,
}

#[pymethods]
impl NativeJob {
    /// Reads a job; `text` is its content if it does not stand in the file `path`.
    #[new]
    #[pyo3(signature = (path, text=None))]
    fn new(py: Python<'_>, path: PathBuf, text: Option<String>) -> PyResult<Self> {
        let loaded = py.detach(|| match &text {
            Some(text) => calls::load_job_text(&path, text, &Silent),
            None => calls::load_job(&path, &Silent),
        });
        let loaded = loaded.map_err(|error| failure(py, error))?;
        Ok(Self { path, loaded: Arc::new(loaded) })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.loaded.job.file.name
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.loaded.warnings.clone()
    }

    #[getter]
    fn axes(&self) -> Vec<String> {
        let axes = &self.loaded.job.kinematics.machine().axes;
        axes.iter().map(|axis| axis.name.clone()).collect()
    }

    #[pyo3(signature = (folder=None, progress=None, passes=None))]
    fn run(
        &self,
        py: Python<'_>,
        folder: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
        passes: Option<Py<PyAny>>,
    ) -> PyResult<NativeRun> {
        let listeners = Listeners { progress: progress.as_ref(), passes: passes.as_ref() };
        let answer = heard(py, listeners, |watch| {
            calls::run_job(&self.path, &self.loaded, folder.as_deref(), watch)
        })?;
        let answer = answer.map_err(|error| failure(py, error))?;
        Ok(NativeRun { loaded: Arc::clone(&self.loaded), answer })
    }
}

#[pymethods]
impl NativeRun {
    #[getter]
    fn passed(&self) -> bool {
        self.answer.outcome.summary.passed
    }

    #[getter]
    fn table(&self) -> &str {
        &self.answer.table
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.answer.warnings.clone()
    }

    #[getter]
    fn files(&self) -> Vec<PathBuf> {
        self.answer.places.clone()
    }

    #[getter]
    fn cl(&self) -> &str {
        &self.answer.outcome.cl
    }

    #[getter]
    fn setup(&self) -> &str {
        &self.answer.outcome.setup
    }

    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json(py, &self.answer.outcome.summary)
    }

    /// Programs by file name.
    #[getter]
    fn programs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let programs = PyDict::new(py);
        for program in &self.answer.outcome.programs {
            programs.set_item(program.file, &program.text)?;
        }
        Ok(programs)
    }

    #[getter]
    fn passes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let operations = &self.answer.outcome.operations;
        let passes = operations.iter().flat_map(|one| &one.covering.passes);
        let made: PyResult<Vec<Bound<'py, PyDict>>> =
            passes.map(|pass| pass_of(py, pass)).collect();
        PyList::new(py, made?)
    }

    /// Tips, axes and kind of motion of all cutter locations.
    #[getter]
    fn locations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let operations = &self.answer.outcome.operations;
        let legs = || operations.iter().flat_map(|one| &one.legs);
        let stations = || legs().flat_map(|leg| &leg.stations);
        let count = stations().count();
        let tips = stations().flat_map(|of| <[f64; 3]>::from(of.pose.tip.coords)).collect();
        let axes = stations().flat_map(|of| <[f64; 3]>::from(of.pose.axis.into_inner())).collect();
        let cutting =
            |leg: &Leg| std::iter::repeat_n(i64::from(leg.motion.is_cut()), leg.stations.len());
        let answer = PyDict::new(py);
        answer.set_item("tip", array(py, tips, &[count, 3])?)?;
        answer.set_item("axis", array(py, axes, &[count, 3])?)?;
        answer.set_item("cutting", whole(py, legs().flat_map(cutting).collect()))?;
        Ok(answer)
    }

    /// Measured points of the first program that was checked.
    #[getter]
    fn maps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let check = self.answer.outcome.programs.iter().find_map(|program| program.check.as_ref());
        maps_of(py, check.map_or(&[][..], |check| &check.maps))
    }

    /// Motion of the axes at a period \[s\]: time, position, velocity, acceleration, jerk; operation after operation, as
    /// if changes of tool took no time.
    #[pyo3(signature = (period, deg))]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        period: f64,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let outcome = &self.answer.outcome;
        let unit = AngleUnit::of(deg);
        let duration = outcome.operations.iter().map(|one| one.plan.schedule.duration()).sum();
        sampled_rows_fit(py, period, duration, 1 + 4 * AXES)?;
        let (mut points, mut start): (Vec<Setpoint>, f64) = (Vec::new(), 0.0);
        for one in &outcome.operations {
            let (path, schedule) = (&one.followed.path, &one.plan.schedule);
            let sampled = setpoint::sample(path, schedule, period)
                .map_err(|error| crate::errors::input(py, error))?;
            let mut later = sampled.map(|point| Setpoint { t: start + point.t, ..point });
            let mut before = usize::MAX;
            while before != points.len() {
                before = points.len();
                py.detach(|| points.extend(later.by_ref().take(SLICE)));
                py.check_signals()?;
            }
            start += schedule.duration();
        }
        let answer = PyDict::new(py);
        let times = points.iter().map(|point| point.t).collect();
        answer.set_item("t", array(py, times, &[points.len()])?)?;
        let parts: [(&str, SetpointPart); 4] = [
            ("position", |point| &point.position),
            ("velocity", |point| &point.velocity),
            ("acceleration", |point| &point.acceleration),
            ("jerk", |point| &point.jerk),
        ];
        for (name, part) in parts {
            let rows = points.iter().flat_map(|point| unit.axes_outside(part(point))).collect();
            answer.set_item(name, array(py, rows, &[points.len(), AXES])?)?;
        }
        Ok(answer)
    }

    /// Names of the axes, and their limits of velocity, acceleration and jerk.
    #[pyo3(signature = (deg))]
    fn limits<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let machine = self.loaded.job.kinematics.machine();
        let unit = AngleUnit::of(deg);
        let answer = PyDict::new(py);
        let names: Vec<&str> = machine.axes.iter().map(|axis| axis.name.as_str()).collect();
        answer.set_item("axes", names)?;
        for (name, values) in [
            ("velocity", machine.vector(|axis| axis.vel)),
            ("acceleration", machine.vector(|axis| axis.acc)),
            ("jerk", machine.vector(|axis| axis.jerk)),
        ] {
            answer.set_item(name, array(py, unit.axes_outside(&values).to_vec(), &[AXES])?)?;
        }
        Ok(answer)
    }
}
