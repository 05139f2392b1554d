//! Forward map, inverse, derivatives.

use super::angle_unit::AngleUnit;
use super::poses::{PoseArrays, Poses, Unreached, pose};
use crate::arrays::{Numbers, array, numbers};
use crate::progress::in_turn;
use numpy::PyArray1;
use pyo3::prelude::*;
use rayon::prelude::*;
use std::ops::Range;
use trunnion::inverse::{Inverse, InverseError, InverseSolutions};
use trunnion::machine::FIRST_ROTARY;
use trunnion::math::jet::by_arc_length;
use trunnion::nalgebra::{Unit, Vector3};
use trunnion::types::{AXES, AxisVector, PoseRates, ToolPose};

/// Rows from which a call works without the lock of the interpreter: below, the lock costs more than the work.
const LONG: usize = 64;

/// Returns the tool axes at which the first rotary is free, unit vectors in the workpiece frame, (k, 3).
pub(super) fn singular_directions<'py>(
    solver: &Inverse,
    py: Python<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let directions = solver.singular_directions();
    let values = directions.iter().flat_map(|axis| <[f64; 3]>::from(axis.into_inner()));
    array(py, values.collect(), &[directions.len(), 3])
}

/// Returns the angle between tool axes and the line of the first rotary, from 0 to a right angle.
pub(super) fn singular_angle<'py>(
    solver: &Inverse,
    axis: &Bound<'py, PyAny>,
    unit: AngleUnit,
) -> PyResult<Bound<'py, PyAny>> {
    let py = axis.py();
    let axes = Numbers::of("axis", axis)?;
    axes.shaped("axis", &[&[3], &[0, 3]])?;
    axes.unit("axis")?;
    let (inverse, rows) = (solver, axes.rows::<3>());
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
pub(super) fn forward<'py>(
    solver: &Inverse,
    q: &Bound<'py, PyAny>,
    unit: AngleUnit,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let py = q.py();
    let numbers = Numbers::of("q", q)?;
    numbers.shaped("q", &[&[AXES], &[0, AXES]])?;
    let kinematics = solver.kinematics();
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
pub(super) fn inverse<'py>(
    solver: &Inverse,
    tip: &Bound<'py, PyAny>,
    axis: &Bound<'py, PyAny>,
    near: Option<&Bound<'py, PyAny>>,
    unit: AngleUnit,
) -> PyResult<Bound<'py, PyAny>> {
    let py = tip.py();
    let arrays = PoseArrays::of(tip, axis)?;
    let poses = arrays.view();
    let mut unreached = Unreached::default();
    let count = poses.tips.len();
    let start = start(solver, near, unit)?;
    if poses.single {
        let (Some(tip), Some(axis)) = (poses.tips.first(), poses.axes.first()) else {
            return array(py, Vec::new(), &[0, AXES]);
        };
        let found = solver.continued(&pose(tip, axis), &start);
        let row = found.as_ref().map_or([f64::NAN; AXES], |found| unit.axes_outside(&found.q));
        if let Err(error) = found {
            unreached.add(0, &error);
            unreached.warn(py, count)?;
        }
        return Ok(PyArray1::from_slice(py, &row).into_any());
    }
    let mut rows = Vec::with_capacity(count);
    let mut near = start;
    let mut follow = |range: Range<usize>| {
        for index in range {
            match solver.continued(&pose(&poses.tips[index], &poses.axes[index]), &near) {
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
    };
    if count < LONG {
        follow(0..count);
    } else {
        in_turn(py, count, follow)?;
    }
    unreached.warn(py, count)?;
    array(py, rows.into_flattened(), &[count, AXES])
}

/// Returns both solutions of tool poses, travel ignored.
pub(super) fn solutions<'py>(
    solver: &Inverse,
    tip: &Bound<'py, PyAny>,
    axis: &Bound<'py, PyAny>,
    unit: AngleUnit,
) -> PyResult<Bound<'py, PyAny>> {
    let py = tip.py();
    let arrays = PoseArrays::of(tip, axis)?;
    let poses = arrays.view();
    let mut unreached = Unreached::default();
    let count = poses.tips.len();
    let rows = py.detach(|| branches(solver, &poses, unit, &mut unreached));
    unreached.warn(py, count)?;
    let shape = [count, 2, AXES];
    array(py, rows, if poses.single { &shape[1..] } else { &shape })
}

/// Parameter of derivatives along a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JetParameter {
    /// That of the derivatives given.
    Given,
    /// Arc length of the tip.
    ArcLength,
}

/// Returns axis positions and their first three derivatives along a path.
pub(super) fn jets<'py>(
    solver: &Inverse,
    tip: &Bound<'py, PyAny>,
    axis: &Bound<'py, PyAny>,
    near: Option<&Bound<'py, PyAny>>,
    parameter: JetParameter,
    unit: AngleUnit,
) -> PyResult<Bound<'py, PyAny>> {
    let py = tip.py();
    let (tips, axes) = (Numbers::of("tip", tip)?, Numbers::of("axis", axis)?);
    tips.shaped("tip", &[&[4, 3], &[0, 4, 3]])?;
    axes.shaped("axis", &[tips.shape()])?;
    let mut near = start(solver, near, unit)?;
    let mut unreached = Unreached::default();
    let (tips_of, axes_of) = (tips.rows::<12>(), axes.rows::<12>());
    let mut rows: Vec<[f64; AXES]> = Vec::with_capacity(4 * tips_of.len());
    let mut one = |index: usize| {
        let vectors = |row: &[f64; 12]| {
            [0, 3, 6, 9].map(|at| Vector3::new(row[at], row[at + 1], row[at + 2]))
        };
        // The contact is not used by the inverse; the tip stands in for it.
        let (tip, axis) = (vectors(&tips_of[index]), vectors(&axes_of[index]));
        let rates = PoseRates { tip, axis, contact: tip };
        let found = solver.jets_continued(&rates, &near);
        let found = found.map_err(|error| error.to_string()).and_then(|q| match parameter {
            JetParameter::Given => Ok(q),
            JetParameter::ArcLength => by_length(q, &rates),
        });
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
    };
    in_turn(py, tips_of.len(), |range| range.for_each(&mut one))?;
    unreached.warn(py, tips_of.len())?;
    let shape = [tips_of.len(), 4, AXES];
    let single = tips.shape().len() == 2;
    array(py, rows.into_flattened(), if single { &shape[1..] } else { &shape })
}

/// Returns the position before the first pose.
fn start(
    solver: &Inverse,
    near: Option<&Bound<'_, PyAny>>,
    unit: AngleUnit,
) -> PyResult<AxisVector> {
    match near {
        None => Ok(solver.kinematics().machine().home()),
        Some(near) => numbers::<AXES>("near", near).map(|row| unit.axes_inside(row)),
    }
}

/// Returns two rows for each pose, NaN where a pose has one solution or none.
fn branches(
    inverse: &Inverse,
    poses: &Poses<'_>,
    unit: AngleUnit,
    unreached: &mut Unreached,
) -> Vec<f64> {
    let solve = |(tip, axis): (&[f64; 3], &[f64; 3])| inverse.solutions(&pose(tip, axis));
    let (tips, axes) = (poses.tips, poses.axes);
    let found: Vec<Result<InverseSolutions, InverseError>> =
        tips.par_iter().zip(axes).map(solve).collect();
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
