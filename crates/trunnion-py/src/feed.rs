//! `trunnion.plan` and `trunnion.Stream`.

use crate::arrays::{Numbers, array, sampled_rows_fit};
use crate::errors::{WrongArgument, failure, input_with};
use crate::progress::watched;
use crate::verbs::json;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trunnion::feed::{AnyStream, FeedError, Limits, StreamKind, StreamOptions, StreamStep};
use trunnion::files::limits::{LimitsFile, parse};
use trunnion::nalgebra::SVector;
use trunnion::types::{AxisNode, Motion};
use trunnion_cli::Failure;
use trunnion_cli::calls::{self, AxisColumn, AxisTable, PlanAnswer, PlanFigures};

/// Rows of a stream between two looks at signals: a few tenths of a second with jerk limits and a long window.
const SLICE: usize = 64;

/// Axes that streams are compiled for; fewer get axes that stand still.
const STREAMED: usize = 6;

/// Plan of a table.
#[pyclass(module = "trunnion._trunnion", name = "NativePlan", frozen)]
#[derive(Debug)]
pub(crate) struct NativePlan(PlanAnswer);

/// Plans the speed along a table: `names` of its columns, `rows` side by side in an array.
#[pyfunction]
#[pyo3(signature = (names, rows, limits, options, progress=None))]
pub(crate) fn plan(
    names: Vec<String>,
    rows: &Bound<'_, PyAny>,
    limits: &str,
    options: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NativePlan> {
    let numbers = Numbers::of("table", rows)?;
    numbers.shaped("table", &[&[0, names.len()]])?;
    let values = |column| numbers.slice().get(column..).unwrap_or_default();
    let column = |at| AxisColumn { values: values(at), step: names.len() };
    let columns: Vec<AxisColumn<'_>> = (0..names.len()).map(column).collect();
    let table = AxisTable { names: &names, columns: &columns };
    PlanCall { table, limits, options, progress }.planned(rows.py())
}

/// Plans the speed along a table: an array for each of the columns.
#[pyfunction]
#[pyo3(signature = (names, columns, limits, options, progress=None))]
pub(crate) fn plan_columns(
    py: Python<'_>,
    names: Vec<String>,
    columns: Vec<Bound<'_, PyAny>>,
    limits: &str,
    options: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NativePlan> {
    let numbers = columns.iter().map(|column| Numbers::of("table", column));
    let numbers = numbers.collect::<PyResult<Vec<_>>>()?;
    let rows = numbers.first().map_or(0, |first| first.slice().len());
    numbers.iter().try_for_each(|column| column.shaped("table", &[&[rows]]))?;
    let column = |numbers| AxisColumn { values: Numbers::slice(numbers), step: 1 };
    let columns: Vec<AxisColumn<'_>> = numbers.iter().map(column).collect();
    let table = AxisTable { names: &names, columns: &columns };
    PlanCall { table, limits, options, progress }.planned(py)
}

/// Arguments of a plan.
struct PlanCall<'a> {
    table: AxisTable<'a>,
    limits: &'a str,
    options: Vec<String>,
    progress: Option<Py<PyAny>>,
}

impl PlanCall<'_> {
    fn planned(self, py: Python<'_>) -> PyResult<NativePlan> {
        let Self { table, limits, options, progress } = self;
        let limits = read_limits(py, limits)?;
        let planned =
            watched(py, progress.as_ref(), |watch| calls::plan(&options, table, &limits, watch))?;
        planned.map(NativePlan).map_err(|error| failure(py, error))
    }
}

fn read_limits(py: Python<'_>, text: &str) -> PyResult<LimitsFile> {
    parse(text).map_err(|faults| {
        let messages = faults.iter().map(|fault| format!("limits:{fault}")).collect();
        failure(py, Failure::Input(messages))
    })
}

impl NativePlan {
    fn figures(&self, py: Python<'_>) -> PyResult<&PlanFigures> {
        py.detach(|| self.0.motion.figures()).map_err(|error| failure(py, error))
    }
}

#[pymethods]
impl NativePlan {
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json(py, &self.figures(py)?.summary)
    }

    #[getter]
    fn axes(&self) -> Vec<String> {
        self.0.axes.clone()
    }

    #[getter]
    fn duration(&self) -> f64 {
        self.0.motion.schedule().duration()
    }

    #[getter]
    fn lower_bound(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.figures(py)?.lower_bound)
    }

    #[getter]
    fn within_limits(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.figures(py)?.within_limits)
    }

    /// Rows of the schedule: s, t, speed, acceleration.
    fn schedule<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut rows = Vec::new();
        for piece in &self.0.motion.schedule().pieces {
            let columns = piece.s.iter().zip(&piece.t).zip(&piece.speed).zip(&piece.acceleration);
            rows.extend(columns.flat_map(|(((s, t), v), a)| [*s, *t, *v, *a]));
        }
        let count = rows.len() / 4;
        array(py, rows, &[count, 4])
    }

    /// Time, position, velocity, acceleration and jerk of the axes at every period.
    fn sample<'py>(&self, py: Python<'py>, period: f64) -> PyResult<Bound<'py, PyAny>> {
        let axes = self.0.axes.len();
        sampled_rows_fit(py, period, self.0.motion.schedule().duration(), 1 + 4 * axes)?;
        let rows = watched(py, None, |watch| self.0.motion.sample(axes, period, watch))?;
        let rows = rows.map_err(|error| failure(py, error))?;
        let width = 1 + 4 * axes;
        let count = rows.len() / width;
        array(py, rows, &[count, width])
    }
}

/// Path that is planned as it arrives.
#[pyclass(module = "trunnion._trunnion", name = "NativeStream")]
#[derive(Debug)]
pub(crate) struct NativeStream {
    stream: AnyStream<STREAMED>,
    axes: usize,
}

#[pymethods]
impl NativeStream {
    #[new]
    fn new(
        axes: Vec<String>,
        limits: &Bound<'_, PyAny>,
        jerk: bool,
        window: usize,
        step: f64,
    ) -> PyResult<Self> {
        let py = limits.py();
        let table = Numbers::of("limits", limits)?;
        table.shaped("limits", &[&[axes.len(), 3]])?;
        if axes.is_empty() || axes.len() > STREAMED {
            let defect = format!("axes; a stream takes 1 to {STREAMED}");
            let value = axes.len().to_string();
            let (name, defect) = ("axes", defect.as_str());
            let wrong = WrongArgument { name, index: &[], value, defect, remedy: "" };
            return Err(wrong.error(py));
        }
        // Axes that stand still never bind, whatever their limits; 1 avoids divisions by zero.
        let column = |order: usize| {
            let rows = table.rows::<3>();
            SVector::from_fn(|axis, _| rows.get(axis).map_or(1.0, |row| row[order]))
        };
        let limits: Limits<STREAMED> = Limits::symmetric(column(0), column(1), column(2));
        let kind = if jerk { StreamKind::Jerk } else { StreamKind::Optimal };
        let stream = AnyStream::new(kind, limits, StreamOptions::fastest(window, step));
        let mut stream = stream.map_err(|error| refused(py, &error))?;
        stream.begin(Motion::Cut);
        Ok(Self { stream, axes: axes.len() })
    }

    /// Takes rows of the path: s, then value and derivatives of each axis.
    fn push<'py>(&mut self, rows: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let py = rows.py();
        let numbers = Numbers::of("rows", rows)?;
        let width = 1 + 3 * self.axes;
        numbers.shaped("rows", &[&[0, width]])?;
        let mut steps = Vec::new();
        for rows in numbers.slice().chunks(SLICE * width) {
            py.detach(|| self.taken(rows, width, &mut steps))
                .map_err(|error| refused(py, &error))?;
            py.check_signals()?;
        }
        table_of(py, &steps)
    }

    /// Ends the path, and returns the rest of its steps.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let steps: Vec<StreamStep> = py.detach(|| self.stream.by_ref().collect());
        table_of(py, &steps)
    }

    #[getter]
    fn time(&self) -> f64 {
        self.stream.time()
    }

    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(bounds) = self.stream.bounds() else { return Ok(None) };
        let answer = PyDict::new(py);
        answer.set_item("velocity", bounds.velocity)?;
        answer.set_item("acceleration", bounds.acceleration)?;
        answer.set_item("jerk", bounds.jerk)?;
        Ok(Some(answer))
    }
}

impl NativeStream {
    /// Takes rows of `width` numbers, and adds the steps that are decided by them.
    fn taken(
        &mut self,
        rows: &[f64],
        width: usize,
        steps: &mut Vec<StreamStep>,
    ) -> Result<(), FeedError> {
        for row in rows.chunks_exact(width) {
            let mut q = [SVector::<f64, STREAMED>::zeros(); 4];
            for (axis, values) in row[1..].chunks_exact(3).enumerate() {
                for (derivative, value) in q.iter_mut().zip(values) {
                    derivative[axis] = *value;
                }
            }
            let node = AxisNode { s: row[0], q, tip_rate: 0.0, feed_rate: 1.0 };
            self.stream.push(node)?;
            while !self.stream.wants() {
                let Some(step) = self.stream.next() else { break };
                steps.push(step);
            }
        }
        Ok(())
    }
}

fn refused(py: Python<'_>, error: &FeedError) -> PyErr {
    input_with(py, error, error.remedy().unwrap_or_default())
}

/// Rows of steps: s, s at the end, t, duration, both speeds, both accelerations.
fn table_of<'py>(py: Python<'py>, steps: &[StreamStep]) -> PyResult<Bound<'py, PyAny>> {
    let row = |of: &StreamStep| {
        let [low, high] = of.s.ends();
        let speeds = [of.speed.start, of.speed.end];
        let accelerations = [of.acceleration, of.end_acceleration];
        [low, high, of.t, of.duration, speeds[0], speeds[1], accelerations[0], accelerations[1]]
    };
    array(py, steps.iter().flat_map(row).collect(), &[steps.len(), 8])
}
