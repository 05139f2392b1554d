//! `trunnion.Machine`: forward map, inverse, derivatives.

use crate::arrays::{Numbers, array, numbers};
use crate::errors::{WrongArgument, failure, input};
use crate::toml_text::toml_text;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::inverse::{Inverse, InverseError, InverseSolutions};
use trunnion::machine::{Axis, FIRST_ROTARY, Kinematics, Setup};
use trunnion::math::jet::by_arc_length;
use trunnion::nalgebra::{Unit, Vector3};
use trunnion::types::{AXES, AxisVector, PoseRates, ToolPose};
use trunnion_cli::{Failure, calls};

/// Rows from which a call works without the lock of the interpreter: below, the lock costs more than the work.
const LONG: usize = 64;

/// Most poses without an answer that a warning names.
const LISTED: usize = 3;

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

/// Unit of angles in arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AngleUnit {
    Radians,
    Degrees,
}

impl AngleUnit {
    pub(crate) fn of(deg: bool) -> Self {
        if deg { Self::Degrees } else { Self::Radians }
    }

    /// Returns an angle in radians.
    fn inside(self, angle: f64) -> f64 {
        if self == Self::Degrees { angle.to_radians() } else { angle }
    }

    /// Returns an angle of the library in this unit.
    fn outside(self, angle: f64) -> f64 {
        if self == Self::Degrees { angle.to_degrees() } else { angle }
    }

    /// Converts a row of axis values to mm and rad.
    fn axes_inside(self, mut row: [f64; AXES]) -> AxisVector {
        row.iter_mut().skip(FIRST_ROTARY).for_each(|angle| *angle = self.inside(*angle));
        row.into()
    }

    /// Converts axis values, or their derivatives, to this unit.
    pub(crate) fn axes_outside(self, q: &AxisVector) -> [f64; AXES] {
        let mut row = <[f64; AXES]>::from(*q);
        row.iter_mut().skip(FIRST_ROTARY).for_each(|angle| *angle = self.outside(*angle));
        row
    }
}

/// Poses without an answer.
#[derive(Default)]
struct Unreached {
    count: usize,
    first: Vec<String>,
}

impl Unreached {
    fn add(&mut self, pose: usize, error: &dyn std::fmt::Display) {
        self.count += 1;
        if self.first.len() < LISTED {
            self.first.push(format!("pose {pose}: {error}"));
        }
    }

    /// Warns about poses whose rows are NaN.
    fn warn(&self, py: Python<'_>, poses: usize) -> PyResult<()> {
        if self.count == 0 {
            return Ok(());
        }
        let more = if self.count > LISTED { "\n  .." } else { "" };
        let message = format!(
            "{} of {poses} poses have no axis position, and rows of NaN:\n  {}{more}",
            self.count,
            self.first.join("\n  ")
        );
        let warning = py.import("trunnion._errors")?.getattr("UnreachableWarning")?;
        py.import("warnings")?.call_method1("warn", (message, warning)).map(drop)
    }
}

#[pymethods]
impl Machine {
    #[new]
    #[pyo3(signature = (source, *, origin=None, rotation=None, tool_length=0.0, deg=false))]
    fn new(
        source: &Bound<'_, PyAny>,
        origin: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
        tool_length: f64,
        deg: bool,
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
        tool_length: Option<f64>,
        deg: bool,
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
    #[pyo3(signature = (*, deg=false))]
    fn rotation<'py>(&self, py: Python<'py>, deg: bool) -> Bound<'py, PyAny> {
        let (x, y, z) = self.inverse.kinematics().setup().rotation.euler_angles();
        let angles = [x, y, z].map(|angle| AngleUnit::of(deg).outside(angle));
        PyArray1::from_slice(py, &angles).into_any()
    }

    /// Returns the travel of the axes, low and high, (5, 2) [mm, rad or degrees]; infinite where there is no end.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> trunnion.Machine("bc-trunnion").travel(deg=True)[4].round(9).tolist()
    ///     [-35.0, 120.0]
    #[pyo3(signature = (*, deg=false))]
    fn travel<'py>(&self, py: Python<'py>, deg: bool) -> PyResult<Bound<'py, PyAny>> {
        let low = self.figures(deg, |axis| axis.limits.low);
        let high = self.figures(deg, |axis| axis.limits.high);
        let ends = low.into_iter().zip(high).flat_map(|(low, high)| [low, high]);
        array(py, ends.collect(), &[AXES, 2])
    }

    /// Returns the velocity limits, (5,) [per second].
    #[pyo3(signature = (*, deg=false))]
    fn velocity<'py>(&self, py: Python<'py>, deg: bool) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, &self.figures(deg, |axis| axis.vel)).into_any()
    }

    /// Returns the acceleration limits, (5,) [per second squared].
    #[pyo3(signature = (*, deg=false))]
    fn acceleration<'py>(&self, py: Python<'py>, deg: bool) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, &self.figures(deg, |axis| axis.acc)).into_any()
    }

    /// Returns the jerk limits, (5,) [per second cubed].
    #[pyo3(signature = (*, deg=false))]
    fn jerk<'py>(&self, py: Python<'py>, deg: bool) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, &self.figures(deg, |axis| axis.jerk)).into_any()
    }

    /// Returns the home position, (5,) [mm, rad or degrees].
    #[pyo3(signature = (*, deg=false))]
    fn home<'py>(&self, py: Python<'py>, deg: bool) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, &self.figures(deg, |axis| axis.home)).into_any()
    }

    /// Returns the tool axes at which the first rotary is free, unit vectors in the workpiece frame, (k, 3).
    fn singular_directions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let directions = self.inverse.singular_directions();
        let values = directions.iter().flat_map(|axis| <[f64; 3]>::from(axis.into_inner()));
        array(py, values.collect(), &[directions.len(), 3])
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
        deg: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = axis.py();
        let axes = Numbers::of("axis", axis)?;
        axes.shaped("axis", &[&[3], &[0, 3]])?;
        axes.unit("axis")?;
        let (unit, inverse, rows) = (AngleUnit::of(deg), &self.inverse, axes.rows::<3>());
        let angle = |row: &[f64; 3]| {
            unit.outside(inverse.pole_distance(&Unit::new_normalize(Vector3::from(*row))))
        };
        let angles: Vec<f64> = py.detach(|| rows.par_iter().map(angle).collect());
        match axes.shape() {
            [3] => Ok(angles.first().copied().unwrap_or(f64::NAN).into_pyobject(py)?.into_any()),
            _ => array(py, angles, &[rows.len()]),
        }
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
        deg: bool,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let py = q.py();
        let numbers = Numbers::of("q", q)?;
        numbers.shaped("q", &[&[AXES], &[0, AXES]])?;
        let (unit, kinematics) = (AngleUnit::of(deg), self.inverse.kinematics());
        let rows = numbers.rows::<AXES>();
        let pose = |row: &[f64; AXES]| kinematics.forward(&unit.axes_inside(*row));
        let parts = |pose: &ToolPose| {
            (<[f64; 3]>::from(pose.tip.coords), <[f64; 3]>::from(pose.axis.into_inner()))
        };
        if let ([row], [_]) = (rows, numbers.shape()) {
            let (tip, axis) = parts(&pose(row));
            let one = |row: [f64; 3]| PyArray1::from_slice(py, &row).into_any();
            return Ok((one(tip), one(axis)));
        }
        let (tips, axes): (Vec<[f64; 3]>, Vec<[f64; 3]>) = if rows.len() < LONG {
            rows.iter().map(|row| parts(&pose(row))).unzip()
        } else {
            py.detach(|| rows.par_iter().map(|row| parts(&pose(row))).unzip())
        };
        let shape = [rows.len(), 3];
        Ok((array(py, tips.into_flattened(), &shape)?, array(py, axes.into_flattened(), &shape)?))
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
        all: bool,
        deg: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = tip.py();
        let arrays = PoseArrays::of(tip, axis)?;
        let poses = arrays.view();
        let unit = AngleUnit::of(deg);
        if all && near.is_some() {
            let message = "near goes with one solution a pose, and all asks for every branch\n  help: leave one out";
            return Err(input(py, message));
        }
        let mut unreached = Unreached::default();
        let count = poses.tips.len();
        if all {
            let rows = self.branches(py, &poses, unit, &mut unreached);
            unreached.warn(py, count)?;
            let shape = [count, 2, AXES];
            return array(py, rows, if poses.single { &shape[1..] } else { &shape });
        }
        let start = self.start(near, unit)?;
        if poses.single {
            let (Some(tip), Some(axis)) = (poses.tips.first(), poses.axes.first()) else {
                return array(py, Vec::new(), &[0, AXES]);
            };
            let found = self.inverse.continued(&pose(tip, axis), &start);
            let row = found.as_ref().map_or([f64::NAN; AXES], |found| unit.axes_outside(&found.q));
            if let Err(error) = found {
                unreached.add(0, &error);
                unreached.warn(py, count)?;
            }
            return Ok(PyArray1::from_slice(py, &row).into_any());
        }
        let rows = if count < LONG {
            self.follow(&poses, start, unit, &mut unreached)
        } else {
            py.detach(|| self.follow(&poses, start, unit, &mut unreached))
        };
        unreached.warn(py, count)?;
        array(py, rows.into_flattened(), &[count, AXES])
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
        arc_length: bool,
        deg: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = tip.py();
        let (tips, axes) = (Numbers::of("tip", tip)?, Numbers::of("axis", axis)?);
        tips.shaped("tip", &[&[4, 3], &[0, 4, 3]])?;
        axes.shaped("axis", &[tips.shape()])?;
        let unit = AngleUnit::of(deg);
        let mut near = self.start(near, unit)?;
        let mut unreached = Unreached::default();
        let (tips_of, axes_of) = (tips.rows::<12>(), axes.rows::<12>());
        let mut rows: Vec<[f64; AXES]> = Vec::with_capacity(4 * tips_of.len());
        for (index, (tip, axis)) in tips_of.iter().zip(axes_of).enumerate() {
            let vectors = |row: &[f64; 12]| {
                [0, 3, 6, 9].map(|at| Vector3::new(row[at], row[at + 1], row[at + 2]))
            };
            // The contact is not used by the inverse; the tip stands in for it.
            let (tip, axis) = (vectors(tip), vectors(axis));
            let rates = PoseRates { tip, axis, contact: tip };
            let found = self
                .inverse
                .jets_continued(&rates, &near)
                .map_err(|error| error.to_string())
                .and_then(|q| if arc_length { by_length(q, &rates) } else { Ok(q) });
            match found {
                Ok(q) => {
                    near = q[0];
                    rows.extend(q.iter().map(|q| unit.axes_outside(q)));
                }
                Err(error) => {
                    unreached.add(index, &error);
                    rows.extend([[f64::NAN; AXES]; 4]);
                }
            }
        }
        unreached.warn(py, tips_of.len())?;
        let shape = [tips_of.len(), 4, AXES];
        let single = tips.shape().len() == 2;
        array(py, rows.into_flattened(), if single { &shape[1..] } else { &shape })
    }

    /// Returns a drawing of the chain as SVG.
    fn picture(&self) -> String {
        trunnion::machine::picture(self.machine())
    }

    /// Returns the machine file.
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
        let setup = self.inverse.kinematics().setup();
        let (x, y, z) = setup.rotation.euler_angles();
        let state = PyDict::new(py);
        state.set_item("source", &self.source)?;
        state.set_item("origin", <[f64; 3]>::from(setup.origin))?;
        state.set_item("rotation", [x, y, z])?;
        state.set_item("tool_length", setup.tool_length)?;
        let rebuild = py.import("trunnion._rebuild")?.getattr("machine")?;
        (rebuild, (&self.text, state)).into_pyobject(py).map(Bound::into_any)
    }

    /// Rebuilds a machine from the text of its file; `source` stands in messages.
    #[staticmethod]
    #[pyo3(signature = (text, source))]
    fn from_toml(py: Python<'_>, text: &str, source: &str) -> PyResult<Self> {
        let file = parse(text).map_err(|faults| {
            let messages = faults.iter().map(|fault| format!("{source}:{fault}")).collect();
            failure(py, Failure::Input(messages))
        })?;
        let inverse = Inverse::new(&Kinematics::new(&file.machine, &Setup::default()));
        let inverse = inverse.map_err(|error| input(py, error))?;
        Ok(Self { source: source.to_owned(), text: text.to_owned(), inverse })
    }
}

impl Machine {
    pub(crate) fn machine(&self) -> &trunnion::machine::Machine {
        self.inverse.kinematics().machine()
    }

    fn figures(&self, deg: bool, figure: impl Fn(&Axis) -> f64) -> [f64; AXES] {
        AngleUnit::of(deg).axes_outside(&self.machine().vector(figure))
    }

    /// Returns the position before the first pose.
    fn start(&self, near: Option<&Bound<'_, PyAny>>, unit: AngleUnit) -> PyResult<AxisVector> {
        match near {
            None => Ok(self.machine().home()),
            Some(near) => numbers::<AXES>("near", near).map(|row| unit.axes_inside(row)),
        }
    }

    /// Returns a row for each pose, each continuing from the one before; NaN where there is none.
    fn follow(
        &self,
        poses: &Poses<'_>,
        mut near: AxisVector,
        unit: AngleUnit,
        unreached: &mut Unreached,
    ) -> Vec<[f64; AXES]> {
        let mut rows = Vec::with_capacity(poses.tips.len());
        for (index, (tip, axis)) in poses.tips.iter().zip(poses.axes).enumerate() {
            match self.inverse.continued(&pose(tip, axis), &near) {
                Ok(found) => {
                    near = found.q;
                    rows.push(unit.axes_outside(&found.q));
                }
                Err(error) => {
                    unreached.add(index, &error);
                    rows.push([f64::NAN; AXES]);
                }
            }
        }
        rows
    }

    /// Returns two rows for each pose, NaN where a pose has one solution or none.
    fn branches(
        &self,
        py: Python<'_>,
        poses: &Poses<'_>,
        unit: AngleUnit,
        unreached: &mut Unreached,
    ) -> Vec<f64> {
        let inverse = &self.inverse;
        let solve = |(tip, axis): (&[f64; 3], &[f64; 3])| inverse.solutions(&pose(tip, axis));
        let (tips, axes) = (poses.tips, poses.axes);
        let found: Vec<Result<InverseSolutions, InverseError>> =
            py.detach(|| tips.par_iter().zip(axes).map(solve).collect());
        let mut rows = Vec::with_capacity(2 * AXES * found.len());
        for (index, solutions) in found.into_iter().enumerate() {
            let both = match solutions {
                Ok(InverseSolutions::Regular(both)) => both.map(Some),
                Ok(InverseSolutions::Singular(q)) => [Some(q), None],
                Err(error) => {
                    unreached.add(index, &error);
                    [None; 2]
                }
            };
            for q in both {
                rows.extend(q.map_or([f64::NAN; AXES], |q| unit.axes_outside(&half_open(q))));
            }
        }
        rows
    }
}

/// Moves rotaries into (-pi, pi]: -pi becomes pi.
fn half_open(q: AxisVector) -> AxisVector {
    let fold = |angle: f64| if angle <= -std::f64::consts::PI { -angle } else { angle };
    AxisVector::from_fn(|row, _| if row < FIRST_ROTARY { q[row] } else { fold(q[row]) })
}

/// Returns derivatives by the arc length of the tip.
fn by_length(q: [AxisVector; 4], rates: &PoseRates) -> Result<[AxisVector; 4], String> {
    let ([q0, q1, q2, q3], [_, p1, p2, p3]) = (q, rates.tip);
    let found = by_arc_length([q1, q2, q3], [p1, p2, p3]);
    let [t, k, l] = found.ok_or(
        "the tip stands still (its first derivative is 0): there are no derivatives by its arc length; leave out arc_length",
    )?;
    Ok([q0, t, k, l])
}

fn pose(tip: &[f64; 3], axis: &[f64; 3]) -> ToolPose {
    ToolPose { tip: (*tip).into(), axis: Unit::new_normalize(Vector3::from(*axis)) }
}

/// Tool poses of an argument pair.
#[derive(Clone, Copy)]
pub(crate) struct Poses<'a> {
    pub(crate) tips: &'a [[f64; 3]],
    pub(crate) axes: &'a [[f64; 3]],
    /// True for one pose without a row index.
    single: bool,
}

/// Arrays behind [`Poses`].
pub(crate) struct PoseArrays<'py> {
    tips: Numbers<'py>,
    axes: Numbers<'py>,
}

impl<'py> PoseArrays<'py> {
    /// Takes tips of any finite value, and axes of length 1.
    pub(crate) fn of(tip: &Bound<'py, PyAny>, axis: &Bound<'py, PyAny>) -> PyResult<Self> {
        let (tips, axes) = (Numbers::of("tip", tip)?, Numbers::of("axis", axis)?);
        tips.shaped("tip", &[&[3], &[0, 3]])?;
        axes.shaped("axis", &[&[3], &[0, 3]])?;
        if tips.shape() != axes.shape() {
            let value = format!("shape {:?}", axes.shape());
            let defect = format!("does not match the shape {:?} of tip", tips.shape());
            let wrong =
                WrongArgument { name: "axis", index: &[], value, defect: &defect, remedy: "" };
            return Err(wrong.error(tip.py()));
        }
        axes.unit("axis")?;
        Ok(Self { tips, axes })
    }

    pub(crate) fn view(&self) -> Poses<'_> {
        let single = self.tips.shape().len() == 1;
        Poses { tips: self.tips.rows(), axes: self.axes.rows(), single }
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
    let path = py.import("os")?.call_method1("fspath", (source,)).map_err(|_| {
        let value =
            source.get_type().name().map_or_else(|_| "?".to_owned(), |name| name.to_string());
        let defect = "is no machine";
        let remedy =
            "give the name of a built-in machine, a path, or a dict as a machine file has it";
        WrongArgument { name: "source", index: &[], value, defect, remedy }.error(py)
    })?;
    let name: String = path.extract()?;
    let text = calls::machine_text(&name).map_err(|error| failure(py, error))?;
    Ok((name, text))
}

/// Names of the built-in machines.
#[pyfunction]
pub(crate) fn built_in() -> Vec<&'static str> {
    BUILT_IN.iter().map(|(name, _)| *name).collect()
}
