//! The class: setup, figures of the axes, files.

use super::angle_unit::AngleUnit;
use super::maps::{self, JetParameter};
use crate::arrays::{array, numbers};
use crate::errors::{WrongArgument, failure, input};
use crate::scalar::scalar;
use crate::toml_text::toml_text;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::inverse::Inverse;
use trunnion::machine::{Axis, Kinematics, Setup};
use trunnion::nalgebra::Vector3;
use trunnion::types::AXES;
use trunnion_cli::{Failure, calls};

/// Machine with the setup of a workpiece and a tool length.
///
/// Args:
///     source: name of a built-in machine, path of a machine file, or dict with its content.
///     origin: workpiece origin in machine coordinates with all axes at zero, (3,) [mm].
///     rotation: rotation of the workpiece about the fixed x, then y, then z, (3,) [rad, or degrees with deg].
///     tool_length: gauge point to tip [mm].
///
/// Raises:
///     InputError: the file has faults; `messages` has all of them with line and column.
///
/// Example:
///     >>> import trunnion
///     >>> " ".join(trunnion.Machine("bc-trunnion").axes)
///     'X Y Z C B'
#[pyclass(module = "trunnion", frozen, subclass, from_py_object)]
#[derive(Debug, Clone)]
pub(crate) struct Machine {
    source: String,
    text: String,
    inverse: Inverse,
}

#[pymethods]
impl Machine {
    #[new]
    #[pyo3(signature = (source, *, origin=None, rotation=None, tool_length=0.0, deg=false))]
    fn new(
        source: &Bound<'_, PyAny>,
        origin: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] tool_length: f64,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> PyResult<Self> {
        let py = source.py();
        let (name, text) = text_of(source)?;
        let file = parse(&text).map_err(|faults| {
            let messages = faults.iter().map(|fault| format!("{name}:{fault}")).collect();
            failure(py, Failure::Input(messages))
        })?;
        let set = |name: &str, value: Option<&Bound<'_, PyAny>>| {
            value.map_or(Ok([0.0; 3]), |value| numbers::<3>(name, value))
        };
        let angles = set("rotation", rotation)?.map(|angle| AngleUnit::of(deg).inside(angle));
        let setup = Setup::new(set("origin", origin)?.into(), angles, length(py, tool_length)?);
        let inverse = Inverse::new(&Kinematics::new(&file.machine, &setup));
        Ok(Self { source: name, text, inverse: inverse.map_err(|error| input(py, error))? })
    }

    /// Returns the machine with another setup; what is not given stays.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Machine("bc-trunnion").with_setup(tool_length=120).tool_length
    ///     120.0
    #[pyo3(signature = (*, origin=None, rotation=None, tool_length=None, deg=false))]
    fn with_setup(
        &self,
        py: Python<'_>,
        origin: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] tool_length: Option<f64>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> PyResult<Self> {
        let mut setup = *self.inverse.kinematics().setup();
        if let Some(origin) = origin {
            setup.origin = numbers::<3>("origin", origin)?.into();
        }
        if let Some(rotation) = rotation {
            let angles = numbers::<3>("rotation", rotation)?;
            let angles = angles.map(|angle| AngleUnit::of(deg).inside(angle));
            setup.rotation = Setup::new(Vector3::zeros(), angles, 0.0).rotation;
        }
        setup.tool_length = tool_length.map_or(Ok(setup.tool_length), |own| length(py, own))?;
        let inverse = Inverse::new(&Kinematics::new(self.machine(), &setup));
        Ok(Self { inverse: inverse.map_err(|error| input(py, error))?, ..self.clone() })
    }

    /// Name of the machine.
    #[getter]
    fn name(&self) -> &str {
        &self.machine().name
    }

    /// Name or path that the machine was read from.
    #[getter]
    fn source(&self) -> &str {
        &self.source
    }

    /// Names of the axes: X, Y, Z, then the rotaries in chain order. All arrays have this order.
    #[getter]
    fn axes(&self) -> [&str; AXES] {
        self.machine().axes.each_ref().map(|axis| axis.name.as_str())
    }

    /// Gauge point to tip [mm].
    #[getter]
    fn tool_length(&self) -> f64 {
        self.inverse.kinematics().setup().tool_length
    }

    /// Workpiece origin in machine coordinates with all axes at zero, (3,) [mm].
    #[getter]
    fn origin<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, self.inverse.kinematics().setup().origin.as_slice()).into_any()
    }

    /// Returns the rotation of the workpiece about the fixed x, then y, then z, (3,) [rad, or degrees with deg].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Machine("bc-trunnion", rotation=(0, 20, 0), deg=True).rotation(deg=True).round(9).tolist()
    ///     [0.0, 20.0, 0.0]
    #[pyo3(signature = (*, deg=false))]
    fn rotation<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> Bound<'py, PyAny> {
        let (x, y, z) = self.inverse.kinematics().setup().rotation.euler_angles();
        let angles = [x, y, z].map(|angle| AngleUnit::of(deg).outside(angle));
        PyArray1::from_slice(py, &angles).into_any()
    }

    /// Returns origin, rotation in radians and tool length as plain numbers, for which nobody needs numpy.
    #[pyo3(name = "_setup")]
    fn plain_setup(&self) -> ([f64; 3], [f64; 3], f64) {
        let setup = self.inverse.kinematics().setup();
        let (x, y, z) = setup.rotation.euler_angles();
        (setup.origin.into(), [x, y, z], setup.tool_length)
    }

    /// Returns the travel of the axes, low and high, (5, 2) [mm, rad or degrees]; infinite where there is no end.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Machine("bc-trunnion").travel(deg=True)[4].round(9).tolist()
    ///     [-35.0, 120.0]
    #[pyo3(signature = (*, deg=false))]
    fn travel<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let low = self.figures(deg, |axis| axis.limits.low);
        let high = self.figures(deg, |axis| axis.limits.high);
        let ends = low.into_iter().zip(high).flat_map(|(low, high)| [low, high]);
        array(py, ends.collect(), &[AXES, 2])
    }

    /// Returns the velocity limits, (5,) [per second].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion")
    ///     >>> bool((machine.velocity() > 0).all())
    ///     True
    #[pyo3(signature = (*, deg=false))]
    fn velocity<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, &self.figures(deg, |axis| axis.vel)).into_any()
    }

    /// Returns the acceleration limits, (5,) [per second squared].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion")
    ///     >>> machine.acceleration(deg=True).shape
    ///     (5,)
    #[pyo3(signature = (*, deg=false))]
    fn acceleration<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, &self.figures(deg, |axis| axis.acc)).into_any()
    }

    /// Returns the jerk limits, (5,) [per second cubed].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion")
    ///     >>> bool((machine.jerk() > 0).all())
    ///     True
    #[pyo3(signature = (*, deg=false))]
    fn jerk<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, &self.figures(deg, |axis| axis.jerk)).into_any()
    }

    /// Returns the home position, (5,) [mm, rad or degrees].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion")
    ///     >>> machine.home().shape
    ///     (5,)
    #[pyo3(signature = (*, deg=false))]
    fn home<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, &self.figures(deg, |axis| axis.home)).into_any()
    }

    /// Returns the tool axes at which the first rotary is free, unit vectors in the workpiece frame, (k, 3).
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion")
    ///     >>> abs(machine.singular_directions()).tolist()
    ///     [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]
    fn singular_directions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        maps::singular_directions(&self.inverse, py)
    }

    /// Returns the angle between tool axes and the line of the first rotary, from 0 to a right angle.
    ///
    /// Args:
    ///     axis: unit vectors, (3,) or (n, 3).
    ///
    /// Returns:
    ///     a number, or (n,) [rad, or degrees with deg].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Machine("bc-trunnion").singular_angle([0, 0, 1])
    ///     0.0
    #[pyo3(signature = (axis, *, deg=false))]
    fn singular_angle<'py>(
        &self,
        axis: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        maps::singular_angle(&self.inverse, axis, AngleUnit::of(deg))
    }

    /// Returns tips and tool axes for axis positions.
    ///
    /// Args:
    ///     q: axis positions in the order of `axes`, (5,) or (n, 5) [mm, rad or degrees].
    ///
    /// Returns:
    ///     tip [mm] and axis (unit vectors) in the workpiece frame, (3,) or (n, 3) each.
    ///
    /// Raises:
    ///     ArgumentError: wrong shape or type, or a number that is not finite, with argument, index and value.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> tip, axis = trunnion.Machine("bc-trunnion").forward([0, 0, 0, 0, 90], deg=True)
    ///     >>> axis.round(9).tolist()
    ///     [1.0, 0.0, 0.0]
    #[pyo3(signature = (q, *, deg=false))]
    fn forward<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        maps::forward(&self.inverse, q, AngleUnit::of(deg))
    }

    /// Returns axis positions for tool poses, inside travel, each continuing from the one before.
    ///
    /// Args:
    ///     tip: tips in the workpiece frame, (3,) or (n, 3) [mm].
    ///     axis: unit vectors from tip to holder, of the same shape.
    ///     near: position before the first pose, (5,); else the home position.
    ///     all: every branch instead, travel ignored, rotaries in (-pi, pi].
    ///     deg: rotaries in degrees.
    ///
    /// Returns:
    ///     (5,) or (n, 5); with all (2, 5) or (n, 2, 5), NaN where a pose has one solution. A pose out of reach has a row of
    ///     NaN, and an UnreachableWarning says why.
    ///
    /// Raises:
    ///     ArgumentError: wrong shape or type, a number that is not finite, an axis that is not a unit vector.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion", origin=(-381, -254, -505), tool_length=120)
    ///     >>> machine.inverse([0, 0, 0], [0.6, 0, 0.8], deg=True).round(4).tolist()[3:]
    ///     [0.0, 36.8699]
    #[pyo3(signature = (tip, axis, near=None, all=false, deg=false))]
    fn inverse<'py>(
        &self,
        tip: &Bound<'py, PyAny>,
        axis: &Bound<'py, PyAny>,
        near: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = scalar)] all: bool,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        match (all, near) {
            (true, Some(_)) => {
                let message = "near goes with one solution a pose, and all asks for every branch\n  help: leave one out";
                Err(input(tip.py(), message))
            }
            (true, None) => maps::solutions(&self.inverse, tip, axis, AngleUnit::of(deg)),
            (false, near) => maps::inverse(&self.inverse, tip, axis, near, AngleUnit::of(deg)),
        }
    }

    /// Returns axis positions and their first three derivatives along a path.
    ///
    /// Args:
    ///     tip: tip and its first three derivatives by a parameter u, (4, 3) or (n, 4, 3) [mm per u^k].
    ///     axis: axis vector, of any length, and its derivatives, of the same shape.
    ///     near: position before the first row, (5,); else the home position.
    ///     arc_length: derivatives by the arc length of the tip instead of u.
    ///
    /// Returns:
    ///     (4, 5) or (n, 4, 5) [mm, rad or degrees, per u^k or mm^k]; NaN where there are none, with an UnreachableWarning.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> tip = [[0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 0, 0]]
    ///     >>> axis = [[0.6, 0, 0.8], [0, 0, 0], [0, 0, 0], [0, 0, 0]]
    ///     >>> machine = trunnion.Machine("bc-trunnion", origin=(-381, -254, -505), tool_length=120)
    ///     >>> machine.jets(tip, axis).shape
    ///     (4, 5)
    #[pyo3(signature = (tip, axis, near=None, *, arc_length=false, deg=false))]
    fn jets<'py>(
        &self,
        tip: &Bound<'py, PyAny>,
        axis: &Bound<'py, PyAny>,
        near: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = scalar)] arc_length: bool,
        #[pyo3(from_py_with = scalar)] deg: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let parameter = if arc_length { JetParameter::ArcLength } else { JetParameter::Given };
        maps::jets(&self.inverse, tip, axis, near, parameter, AngleUnit::of(deg))
    }

    /// Returns a drawing of the chain as SVG.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion")
    ///     >>> machine.picture().startswith("<svg")
    ///     True
    fn picture(&self) -> String {
        trunnion::machine::picture(self.machine())
    }

    /// Returns the machine file.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion")
    ///     >>> "schema" in machine.to_toml()
    ///     True
    fn to_toml(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        format!("Machine({:?}, axes={})", self.name(), self.axes().join(" "))
    }

    fn _repr_html_(&self) -> String {
        self.picture()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (origin, rotation, tool_length) = self.plain_setup();
        let state = PyDict::new(py);
        state.set_item("source", &self.source)?;
        state.set_item("origin", origin)?;
        state.set_item("rotation", rotation)?;
        state.set_item("tool_length", tool_length)?;
        let rebuild = py.import("trunnion._rebuild")?.getattr("machine")?;
        (rebuild, (&self.text, state)).into_pyobject(py).map(Bound::into_any)
    }

    /// Returns the machine that the parameters of a control, or another program, describe.
    ///
    /// Args:
    ///     source: file of the description: INI of LinuxCNC, machine data of Siemens, kinematics of Heidenhain, parameters of
    ///         Fanuc, settings of Haas, .fcm of FreeCAD; or its content as bytes.
    ///     format: "linuxcnc", "siemens", "heidenhain", "fanuc", "haas" or "freecad"; else by its text.
    ///     given: values that the description does not state, by key: {"axis.C.limits": "endless", "linear.jerk": 50000}; mm,
    ///         degrees, s. They win over the description.
    ///
    /// Returns:
    ///     The machine; `trunnion.import_machine` also says which value became which.
    ///
    /// Raises:
    ///     InputError: the description cannot be read, or values are missing; `messages` has all of them with line and key.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Machine.from_control(b"[KINS]")  # doctest: +IGNORE_EXCEPTION_DETAIL
    ///     Traceback (most recent call last):
    ///     trunnion.InputError: ...
    #[staticmethod]
    #[pyo3(signature = (source, format=None, *, given=None))]
    fn from_control<'py>(
        source: &Bound<'py, PyAny>,
        format: Option<&Bound<'py, PyAny>>,
        given: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let module = source.py().import("trunnion._machine")?;
        module.call_method1("import_machine", (source, format, given))?.getattr("machine")
    }

    /// Finds the errors of the real machine from measured spheres.
    ///
    /// Args:
    ///     measurements: tables of readings: CSV files, dicts of columns or DataFrames, one or a list of them. Columns as in
    ///         `trunnion machine calibrate`: X_mm, .., C_deg for the axes, optionally length_mm, sphere, dx_mm, radius_mm.
    ///     tool_length: gauge point to the ball in the spindle [mm], for tables without `length_mm`.
    ///     noise: standard deviation of a reading [mm]; else from the residuals.
    ///
    /// Returns:
    ///     A Calibration with the calibrated machine, the deviations and their uncertainties.
    ///
    /// Raises:
    ///     InputError: tables that cannot be read, or readings of another machine.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion")
    ///     >>> machine.calibrate({"X_mm": [0]})  # doctest: +IGNORE_EXCEPTION_DETAIL
    ///     Traceback (most recent call last):
    ///     trunnion.InputError: ...
    #[pyo3(signature = (measurements, *, tool_length=None, noise=None))]
    fn calibrate<'py>(
        slf: &Bound<'py, Self>,
        measurements: &Bound<'py, PyAny>,
        tool_length: Option<&Bound<'py, PyAny>>,
        noise: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let module = slf.py().import("trunnion._machine")?;
        module.call_method1("calibrate", (slf, measurements, tool_length, noise))
    }

    /// Rebuilds a machine from the text of its file; `source` stands in messages.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> machine = trunnion.Machine("bc-trunnion")
    ///     >>> trunnion.Machine.from_toml(machine.to_toml(), "copy").name
    ///     'bc-trunnion'
    #[staticmethod]
    #[pyo3(signature = (text, source))]
    fn from_toml(
        py: Python<'_>,
        #[pyo3(from_py_with = scalar)] text: String,
        #[pyo3(from_py_with = scalar)] source: String,
    ) -> PyResult<Self> {
        let file = parse(&text).map_err(|faults| {
            let messages = faults.iter().map(|fault| format!("{source}:{fault}")).collect();
            failure(py, Failure::Input(messages))
        })?;
        let inverse = Inverse::new(&Kinematics::new(&file.machine, &Setup::default()));
        let inverse = inverse.map_err(|error| input(py, error))?;
        Ok(Self { source, text, inverse })
    }
}

impl Machine {
    pub(crate) fn machine(&self) -> &trunnion::machine::Machine {
        self.inverse.kinematics().machine()
    }

    fn figures(&self, deg: bool, figure: impl Fn(&Axis) -> f64) -> [f64; AXES] {
        AngleUnit::of(deg).axes_outside(&self.machine().vector(figure))
    }
}

fn length(py: Python<'_>, value: f64) -> PyResult<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    let defect = "is not a finite number";
    let wrong = WrongArgument {
        name: "tool_length",
        index: &[],
        value: value.to_string(),
        defect,
        remedy: "",
    };
    Err(wrong.error(py))
}

/// Returns name and text of a machine: built-in name, path, or dictionary.
fn text_of(source: &Bound<'_, PyAny>) -> PyResult<(String, String)> {
    let py = source.py();
    if source.is_instance_of::<PyDict>() {
        return Ok(("machine".to_owned(), toml_text(source)?));
    }
    let path =
        py.import("os")?.call_method1("fspath", (source,)).map_err(|_| no_machine(source))?;
    // A path of bytes is none of text.
    let name: String = path.extract().map_err(|_| no_machine(source))?;
    let text = calls::machine_text(&name).map_err(|error| failure(py, error))?;
    Ok((name, text))
}

fn no_machine(source: &Bound<'_, PyAny>) -> PyErr {
    let name = source.get_type().name();
    let value = name.map_or_else(|_| "?".to_owned(), |name| name.to_string());
    let defect = "is no machine";
    let remedy = "give the name of a built-in machine, a path, or a dict as a machine file has it";
    WrongArgument { name: "source", index: &[], value, defect, remedy }.error(source.py())
}

/// Names of the built-in machines.
///
/// Example:
///     >>> import trunnion
///     >>> "ac-trunnion" in trunnion.built_in()
///     True
#[pyfunction]
pub(crate) fn built_in() -> Vec<&'static str> {
    BUILT_IN.iter().map(|(name, _)| *name).collect()
}
