//! `trunnion.Cutter`.

use crate::arrays::{Numbers, array};
use crate::errors::{WrongArgument, input};
use pyo3::prelude::*;
use trunnion::cutter::{Cutter as LibraryCutter, CutterConstruction, CutterSpec};

/// Milling cutter with shank.
#[pyclass(module = "trunnion", frozen, from_py_object)]
#[derive(Debug, Clone)]
pub(crate) struct Cutter(pub(crate) LibraryCutter);

#[pymethods]
impl Cutter {
    /// Ball end mill.
    ///
    /// Args:
    ///     d: diameter [mm].
    ///     length: tip to gauge point [mm]; else five diameters.
    ///     shank: profile above the cutting part, rows of height above the tip and radius, (n, 2) [mm].
    ///     inner: radius within which an insert cutter does not cut [mm].
    ///
    /// Raises:
    ///     InputError: the dimensions contradict each other.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Cutter.ball(10).minor_radius
    ///     5.0
    #[staticmethod]
    #[pyo3(signature = (d, *, length=None, shank=None, inner=None))]
    fn ball(
        py: Python<'_>,
        d: f64,
        length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        inner: Option<f64>,
    ) -> PyResult<Self> {
        finite(py, "d", d)?;
        Parts { spec: CutterSpec::ball(d), length, shank, inner }.cutter(py)
    }

    /// Bull-nose cutter: radius R of the centre circle and r of the rounding [mm]; further arguments as for `ball`.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Cutter.bull(10, 6).radius
    ///     16.0
    #[staticmethod]
    #[pyo3(name = "bull", signature = (R, r, *, length=None, shank=None, inner=None))]
    #[expect(non_snake_case, reason = "R and r are the names of both radii, as in job files")]
    fn bull(
        py: Python<'_>,
        R: f64,
        r: f64,
        length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        inner: Option<f64>,
    ) -> PyResult<Self> {
        finite(py, "R", R)?;
        finite(py, "r", r)?;
        Parts { spec: CutterSpec::of_radii(R, r), length, shank, inner }.cutter(py)
    }

    /// Flat end mill of diameter d [mm]; further arguments as for `ball`.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Cutter.flat(12).major_radius
    ///     6.0
    #[staticmethod]
    #[pyo3(signature = (d, *, length=None, shank=None, inner=None))]
    fn flat(
        py: Python<'_>,
        d: f64,
        length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        inner: Option<f64>,
    ) -> PyResult<Self> {
        finite(py, "d", d)?;
        Parts { spec: CutterSpec::flat(d), length, shank, inner }.cutter(py)
    }

    /// "flat", "ball" or "bull".
    #[getter]
    fn kind(&self) -> String {
        format!("{:?}", self.0.kind()).to_lowercase()
    }

    /// Radius R of the centre circle [mm].
    #[getter]
    fn major_radius(&self) -> f64 {
        self.0.major()
    }

    /// Radius r of the rounding [mm].
    #[getter]
    fn minor_radius(&self) -> f64 {
        self.0.minor()
    }

    /// Outer radius R + r [mm].
    #[getter]
    fn radius(&self) -> f64 {
        self.0.radius()
    }

    /// Tip to gauge point [mm].
    #[getter]
    fn length(&self) -> f64 {
        self.0.length()
    }

    /// Radius within which an insert cutter does not cut [mm]; None for a solid one.
    #[getter]
    fn inner(&self) -> Option<f64> {
        match self.0.spec().construction {
            CutterConstruction::Insert { inner_cutting_radius } => Some(inner_cutting_radius),
            CutterConstruction::Solid => None,
        }
    }

    /// Profile above the cutting part: height above the tip and radius, (n, 2) [mm].
    #[getter]
    fn shank<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let shank = &self.0.spec().shank;
        array(py, shank.iter().flatten().copied().collect(), &[shank.len(), 2])
    }

    fn __repr__(&self) -> String {
        format!(
            "Cutter.bull(R={}, r={}, length={})",
            self.0.major(),
            self.0.minor(),
            self.0.length()
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rebuild = py.import("trunnion._rebuild")?.getattr("cutter")?;
        let state =
            (self.0.major(), self.0.minor(), self.0.length(), self.shank(py)?, self.inner());
        (rebuild, state).into_pyobject(py).map(Bound::into_any)
    }
}

/// Arguments of a cutter.
struct Parts<'a, 'py> {
    spec: CutterSpec,
    length: Option<f64>,
    shank: Option<&'a Bound<'py, PyAny>>,
    inner: Option<f64>,
}

impl Parts<'_, '_> {
    fn cutter(self, py: Python<'_>) -> PyResult<Cutter> {
        let Self { mut spec, length, shank, inner } = self;
        if let Some(shank) = shank {
            let rows = Numbers::of("shank", shank)?;
            rows.shaped("shank", &[&[0, 2]])?;
            spec.shank = rows.rows::<2>().to_vec();
        }
        if let Some(inner_cutting_radius) = inner {
            spec.construction = CutterConstruction::Insert { inner_cutting_radius };
        }
        spec.length = length.unwrap_or(spec.length);
        let refused = |faults: trunnion::cutter::CutterErrors| input(py, faults);
        LibraryCutter::new(spec).map(Cutter).map_err(refused)
    }
}

fn finite(py: Python<'_>, name: &str, value: f64) -> PyResult<()> {
    if value.is_finite() {
        return Ok(());
    }
    let defect = "is not a finite number";
    Err(WrongArgument { name, index: &[], value: value.to_string(), defect, remedy: "" }.error(py))
}
