//! `trunnion.Cutter`.

use crate::arrays::{Numbers, array};
use crate::errors::{WrongArgument, input};
use crate::machine::AngleUnit;
use crate::scalar::scalar;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trunnion::cutter::{
    Cutter as LibraryCutter, CutterConstruction, CutterKind, CutterSide, CutterSpec,
};

/// Milling cutter with shank.
///
/// Example:
///     >>> import trunnion
///     >>> cutter = trunnion.Cutter.bull(10, 6, length=120, shank=[[30, 12]])
///     >>> cutter.kind, cutter.radius, cutter.length
///     ('bull', 16.0, 120.0)
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
        #[pyo3(from_py_with = scalar)] d: f64,
        #[pyo3(from_py_with = scalar)] length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] inner: Option<f64>,
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
        #[pyo3(from_py_with = scalar)] R: f64,
        #[pyo3(from_py_with = scalar)] r: f64,
        #[pyo3(from_py_with = scalar)] length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] inner: Option<f64>,
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
        #[pyo3(from_py_with = scalar)] d: f64,
        #[pyo3(from_py_with = scalar)] length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] inner: Option<f64>,
    ) -> PyResult<Self> {
        finite(py, "d", d)?;
        Parts { spec: CutterSpec::flat(d), length, shank, inner }.cutter(py)
    }

    /// Tapered ball end mill: an arc at the tip, and a cone tangent to it.
    ///
    /// Args:
    ///     tip_radius: radius of the arc at the tip [mm].
    ///     taper_angle: angle between the cone and the axis, half of the cone's own [rad, or degrees with deg].
    ///     d: diameter at which the cone ends and the straight flank begins [mm].
    ///     length, shank, inner: as for `ball`.
    ///
    /// Raises:
    ///     InputError: no such cone joins the tip arc to the diameter.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Cutter.taper(1, 5, 8, deg=True).radius
    ///     4.0
    #[staticmethod]
    #[pyo3(signature = (tip_radius, taper_angle, d, *, deg=false, length=None, shank=None, inner=None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of a Python call")]
    fn taper(
        py: Python<'_>,
        #[pyo3(from_py_with = scalar)] tip_radius: f64,
        #[pyo3(from_py_with = scalar)] taper_angle: f64,
        #[pyo3(from_py_with = scalar)] d: f64,
        #[pyo3(from_py_with = scalar)] deg: bool,
        #[pyo3(from_py_with = scalar)] length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] inner: Option<f64>,
    ) -> PyResult<Self> {
        let taper_angle = acute(py, taper_angle, AngleUnit::of(deg))?;
        all_finite(py, &[("tip_radius", tip_radius), ("d", d)])?;
        Parts { spec: CutterSpec::taper(tip_radius, taper_angle, d), length, shank, inner }
            .cutter(py)
    }

    /// Tangential barrel cutter: an arc at the tip, and a large arc tangent to it and to the flank.
    ///
    /// Args:
    ///     tip_radius: radius of the arc at the tip [mm].
    ///     barrel_radius: radius of the large arc [mm].
    ///     d: diameter of the flank [mm].
    ///     length, shank, inner: as for `ball`.
    ///
    /// Raises:
    ///     InputError: no such arc joins the tip arc to the flank.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Cutter.barrel(2, 85, 12).barrel_radius
    ///     85.0
    #[staticmethod]
    #[pyo3(signature = (tip_radius, barrel_radius, d, *, length=None, shank=None, inner=None))]
    fn barrel(
        py: Python<'_>,
        #[pyo3(from_py_with = scalar)] tip_radius: f64,
        #[pyo3(from_py_with = scalar)] barrel_radius: f64,
        #[pyo3(from_py_with = scalar)] d: f64,
        #[pyo3(from_py_with = scalar)] length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] inner: Option<f64>,
    ) -> PyResult<Self> {
        all_finite(py, &[("tip_radius", tip_radius), ("barrel_radius", barrel_radius), ("d", d)])?;
        Parts { spec: CutterSpec::barrel(tip_radius, barrel_radius, d), length, shank, inner }
            .cutter(py)
    }

    /// Conical barrel cutter: an arc at the tip, and a large arc tangent to it that ends inclined to the axis.
    ///
    /// Args:
    ///     tip_radius: radius of the arc at the tip [mm].
    ///     barrel_radius: radius of the large arc [mm].
    ///     taper_angle: angle between the large arc and the axis at its upper end [rad, or degrees with deg].
    ///     d: diameter at that end, where the straight flank begins [mm].
    ///     length, shank, inner: as for `ball`.
    ///
    /// Raises:
    ///     InputError: no such arc joins the tip arc to the diameter.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Cutter.conical_barrel(3, 250, 20, 12, deg=True).kind
    ///     'conical-barrel'
    #[staticmethod]
    #[pyo3(signature = (tip_radius, barrel_radius, taper_angle, d, *, deg=false, length=None, shank=None, inner=None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of a Python call")]
    fn conical_barrel(
        py: Python<'_>,
        #[pyo3(from_py_with = scalar)] tip_radius: f64,
        #[pyo3(from_py_with = scalar)] barrel_radius: f64,
        #[pyo3(from_py_with = scalar)] taper_angle: f64,
        #[pyo3(from_py_with = scalar)] d: f64,
        #[pyo3(from_py_with = scalar)] deg: bool,
        #[pyo3(from_py_with = scalar)] length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] inner: Option<f64>,
    ) -> PyResult<Self> {
        let taper_angle = acute(py, taper_angle, AngleUnit::of(deg))?;
        all_finite(py, &[("tip_radius", tip_radius), ("barrel_radius", barrel_radius), ("d", d)])?;
        let spec = CutterSpec::conical_barrel(tip_radius, barrel_radius, taper_angle, d);
        Parts { spec, length, shank, inner }.cutter(py)
    }

    /// Lens cutter: a large arc across the tip, and a small corner arc tangent to it and to the flank.
    ///
    /// Args:
    ///     tip_radius: radius of the large arc [mm].
    ///     corner_radius: radius of the corner [mm].
    ///     d: diameter of the flank [mm].
    ///     length, shank, inner: as for `ball`.
    ///
    /// Raises:
    ///     InputError: no such corner joins the large arc to the flank.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Cutter.lens(40, 1, 12).corner_radius
    ///     1.0
    #[staticmethod]
    #[pyo3(signature = (tip_radius, corner_radius, d, *, length=None, shank=None, inner=None))]
    fn lens(
        py: Python<'_>,
        #[pyo3(from_py_with = scalar)] tip_radius: f64,
        #[pyo3(from_py_with = scalar)] corner_radius: f64,
        #[pyo3(from_py_with = scalar)] d: f64,
        #[pyo3(from_py_with = scalar)] length: Option<f64>,
        shank: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] inner: Option<f64>,
    ) -> PyResult<Self> {
        all_finite(py, &[("tip_radius", tip_radius), ("corner_radius", corner_radius), ("d", d)])?;
        Parts { spec: CutterSpec::lens(tip_radius, corner_radius, d), length, shank, inner }
            .cutter(py)
    }

    /// "flat", "ball", "bull", "taper", "barrel", "conical-barrel" or "lens".
    #[getter]
    fn kind(&self) -> &str {
        self.0.kind().name()
    }

    /// Radius R of the centre circle [mm].
    #[getter]
    fn major_radius(&self) -> f64 {
        self.0.major()
    }

    /// Radius r of the rounding, which is the arc at the tip [mm].
    #[getter]
    fn minor_radius(&self) -> f64 {
        self.0.minor()
    }

    /// Radius of the large arc beside the tip [mm]; None for a cutter without one.
    #[getter]
    fn barrel_radius(&self) -> Option<f64> {
        let is_barrel = matches!(self.0.kind(), CutterKind::Barrel | CutterKind::ConicalBarrel);
        self.side_radius().filter(|_| is_barrel)
    }

    /// Radius of the corner beside the large arc of a lens [mm]; None for other cutters.
    #[getter]
    fn corner_radius(&self) -> Option<f64> {
        self.side_radius().filter(|_| self.0.kind() == CutterKind::Lens)
    }

    /// Returns the angle between the upper end of the side and the axis, 0 for a straight flank [rad, or degrees with deg].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> round(trunnion.Cutter.taper(1, 5, 8, deg=True).taper_angle(deg=True), 9)
    ///     5.0
    #[pyo3(signature = (*, deg=false))]
    fn taper_angle(&self, #[pyo3(from_py_with = scalar)] deg: bool) -> f64 {
        AngleUnit::of(deg).outside(self.0.spec().side.taper_angle())
    }

    /// Outer radius [mm].
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

    /// Returns the outline from the tip outwards and up, arcs divided into `steps` lines, (n, 2) [distance from the axis,
    /// height above the tip, mm].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Cutter.flat(4, length=9).outline().tolist()
    ///     [[0.0, 0.0], [2.0, 0.0], [2.0, 9.0]]
    #[pyo3(signature = (steps=32))]
    fn outline<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] steps: u16,
    ) -> PyResult<Bound<'py, PyAny>> {
        let steps = u32::from(steps).max(1);
        let mut rows: Vec<[f64; 2]> = vec![[0.0; 2]];
        for piece in self.0.profile() {
            rows.extend(piece.points(steps).into_iter().skip(1));
        }
        let count = rows.len();
        array(py, rows.into_flattened(), &[count, 2])
    }

    /// Returns the table `[tool]` of a job file without its number: mm, and degrees.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Cutter.taper(1, 5, 8, deg=True, length=60).to_dict().get("taper_angle")
    ///     5.0
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = PyDict::new(py);
        table.set_item("kind", self.kind())?;
        for (name, value) in self.numbers() {
            table.set_item(name, value)?;
        }
        if let Some(inner) = self.inner() {
            table.set_item("construction", "insert")?;
            table.set_item("inner_cutting_radius", inner)?;
        }
        let shank = &self.0.spec().shank;
        if !shank.is_empty() {
            table.set_item("shank", shank.clone())?;
        }
        Ok(table)
    }

    fn __repr__(&self) -> String {
        let numbers: Vec<String> =
            self.numbers().iter().map(|(name, value)| format!("{name}={value}")).collect();
        format!("Cutter({}, {})", self.kind(), numbers.join(", "))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rebuild = py.import("trunnion._rebuild")?.getattr("cutter")?;
        let side = (self.side_radius(), self.0.spec().side.taper_angle(), 2.0 * self.0.radius());
        let radii = (self.0.major(), self.0.minor());
        let state = (self.kind(), radii, side, self.0.length(), self.shank(py)?, self.inner());
        (rebuild, state).into_pyobject(py).map(Bound::into_any)
    }
}

impl Cutter {
    /// Returns the radius of the arc beside the tip arc.
    fn side_radius(&self) -> Option<f64> {
        match self.0.spec().side {
            CutterSide::Arc { radius, .. } => Some(radius),
            CutterSide::Straight | CutterSide::Cone { .. } => None,
        }
    }

    /// Returns what describes the cutter with the keys of a job file: mm, and degrees.
    fn numbers(&self) -> Vec<(&'static str, f64)> {
        let mut numbers = match self.0.spec().side {
            CutterSide::Straight => {
                vec![("major_radius", self.0.major()), ("minor_radius", self.0.minor())]
            }
            CutterSide::Cone { diameter, .. } | CutterSide::Arc { diameter, .. } => {
                vec![("tip_radius", self.0.minor()), ("diameter", diameter)]
            }
        };
        numbers.extend(self.barrel_radius().map(|radius| ("barrel_radius", radius)));
        numbers.extend(self.corner_radius().map(|radius| ("corner_radius", radius)));
        let angle = self.taper_angle(true);
        numbers.extend((angle > 0.0).then_some(("taper_angle", angle)));
        numbers.push(("length", self.0.length()));
        numbers
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

/// Takes an angle between a side and the axis, in radians.
fn acute(py: Python<'_>, value: f64, unit: AngleUnit) -> PyResult<f64> {
    let angle = unit.inside(value);
    if angle > 0.0 && angle < std::f64::consts::FRAC_PI_2 {
        return Ok(angle);
    }
    let name = "taper_angle";
    let defect = "is not an angle between 0 and a right angle";
    let remedy = match unit {
        AngleUnit::Degrees => "",
        AngleUnit::Radians => "give it in radians, or in degrees with deg=True",
    };
    Err(WrongArgument { name, index: &[], value: value.to_string(), defect, remedy }.error(py))
}

fn all_finite(py: Python<'_>, values: &[(&str, f64)]) -> PyResult<()> {
    values.iter().try_for_each(|(name, value)| finite(py, name, *value))
}

fn finite(py: Python<'_>, name: &str, value: f64) -> PyResult<()> {
    if value.is_finite() {
        return Ok(());
    }
    let defect = "is not a finite number";
    Err(WrongArgument { name, index: &[], value: value.to_string(), defect, remedy: "" }.error(py))
}
