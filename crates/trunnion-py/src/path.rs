//! Paths of cutter locations: interpolation, smoothing, straight moves.

use crate::arrays::{Numbers, array, positive};
use crate::errors::{WrongArgument, input};
use crate::machine::{PoseArrays, Poses};
use crate::progress::watched;
use pyo3::prelude::*;
use trunnion::nalgebra::{Unit, Vector3};
use trunnion::toolpath::{PathResolution, SmoothOptions, densify, smooth as smoothed};
use trunnion::types::{
    Cancelled, PoseCoordinates, PoseSpan, PoseTolerance, Progress, Stage, Station, ToolPose,
};

/// Tips and tool axes.
type PosePair<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Inserts cutter locations so that steps and turns stay below both limits.
#[pyfunction]
#[pyo3(signature = (tip, axis, max_step, max_turn, progress=None))]
pub(crate) fn interpolate<'py>(
    tip: &Bound<'py, PyAny>,
    axis: &Bound<'py, PyAny>,
    max_step: f64,
    max_turn: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<PosePair<'py>> {
    let py = tip.py();
    let arrays = PoseArrays::of(tip, axis)?;
    let poses = poses(&arrays.view());
    let resolution = PathResolution {
        max_step: positive(py, "max_step", max_step)?,
        max_turn: positive(py, "max_turn", max_turn)?,
    };
    locations_fit(py, &poses, resolution)?;
    let fine = watched(py, progress.as_ref(), |watch| densify(&poses, resolution, watch))?
        .map_err(|error| input(py, error))?;
    pair(py, fine.iter().map(|pose| (pose.tip.coords, pose.axis.into_inner())))
}

/// Most cutter locations of a path: far beyond any use, and they fit in memory.
const MOST_LOCATIONS: f64 = 2e7;

/// Refuses a resolution whose locations would not fit in memory; an allocation that fails ends the interpreter.
fn locations_fit(py: Python<'_>, poses: &[ToolPose], resolution: PathResolution) -> PyResult<()> {
    let over = |of: fn(&ToolPose, &ToolPose) -> f64| {
        poses.iter().zip(poses.iter().skip(1)).map(|(from, to)| of(from, to)).sum::<f64>()
    };
    let limits = [
        ("max_step", resolution.max_step, over(|from, to| (to.tip - from.tip).norm())),
        ("max_turn", resolution.max_turn, over(|from, to| from.axis.angle(&to.axis))),
    ];
    let wrong = |(name, value, whole): (&str, f64, f64)| {
        let defect =
            format!("asks for {:.1e} cutter locations, which do not fit in memory", whole / value);
        let remedy = format!("give a number above {:.1e}", whole / MOST_LOCATIONS);
        let (defect, remedy, value) = (defect.as_str(), remedy.as_str(), value.to_string());
        WrongArgument { name, index: &[], value, defect, remedy }.error(py)
    };
    let far = limits.into_iter().find(|(_, value, whole)| whole / value > MOST_LOCATIONS);
    far.map_or(Ok(()), |far| Err(wrong(far)))
}

/// Curves within tolerance of cutter locations: knots, coefficients, starts of curves, deviations.
type Curves<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Vec<usize>, [f64; 2]);

/// Lays smooth curves through cutter locations.
#[pyfunction]
#[pyo3(signature = (tip, axis, tip_tolerance, axis_tolerance, progress=None))]
pub(crate) fn smooth<'py>(
    tip: &Bound<'py, PyAny>,
    axis: &Bound<'py, PyAny>,
    tip_tolerance: f64,
    axis_tolerance: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Curves<'py>> {
    let py = tip.py();
    let arrays = PoseArrays::of(tip, axis)?;
    let stations: Vec<Station> =
        poses(&arrays.view()).into_iter().map(|pose| Station { pose, contact: pose.tip }).collect();
    let tolerance = PoseTolerance::new(
        positive(py, "tip_tolerance", tip_tolerance)?,
        positive(py, "axis_tolerance", axis_tolerance)?,
    );
    let options = SmoothOptions::within(tolerance);
    let found = watched(py, progress.as_ref(), |watch| smoothed(&stations, &options, watch))?
        .map_err(|error| input(py, error))?;
    let (mut ranges, mut coefficients, mut starts) = (Vec::new(), Vec::new(), Vec::new());
    for curve in &found.curves {
        starts.push(coefficients.len() / (6 * 9));
        for (span, ends) in curve.spans.iter().zip(curve.knots.windows(2)) {
            ranges.extend_from_slice(ends);
            coefficients.extend(span.coefficients.iter().flat_map(PoseCoordinates::iter).copied());
        }
    }
    let count = ranges.len() / 2;
    Ok((
        array(py, ranges, &[count, 2])?,
        array(py, coefficients, &[count, 6, 9])?,
        starts,
        [found.report.deviated.tip_bound, found.report.deviated.axis_bound],
    ))
}

/// Divides curves into straight moves of the tip within tolerance.
#[pyfunction]
#[pyo3(signature = (ranges, coefficients, tip_tolerance, axis_tolerance, progress=None))]
pub(crate) fn linearise<'py>(
    ranges: &Bound<'py, PyAny>,
    coefficients: &Bound<'py, PyAny>,
    tip_tolerance: f64,
    axis_tolerance: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<PosePair<'py>> {
    let py = ranges.py();
    let ranges = Numbers::of("ranges", ranges)?;
    ranges.shaped("ranges", &[&[0, 2]])?;
    let numbers = Numbers::of("coefficients", coefficients)?;
    numbers.shaped("coefficients", &[&[ranges.shape()[0], 6, 9]])?;
    let tolerance = [
        positive(py, "tip_tolerance", tip_tolerance)?,
        positive(py, "axis_tolerance", axis_tolerance)?,
    ];
    let (ranges, rows) = (ranges.rows::<2>(), numbers.rows::<54>());
    let poses = watched(py, progress.as_ref(), |watch| divided(ranges, rows, tolerance, watch))?;
    let poses = poses.map_err(|error| match error {
        DivisionError::Cancelled(cancelled) => input(py, cancelled),
        DivisionError::TooMany(parts) => {
            let (value, defect) = (tip_tolerance.to_string(), "asks for more moves than fit");
            let remedy = format!("allow more: {parts:.0} moves would be needed");
            let (name, remedy) = ("tip_tolerance", remedy.as_str());
            WrongArgument { name, index: &[], value, defect, remedy }.error(py)
        }
    })?;
    pair(py, poses.into_iter())
}

/// Reasons why curves were not divided.
enum DivisionError {
    /// Moves that would be needed.
    TooMany(f64),
    Cancelled(Cancelled),
}

/// Tips and axes of straight moves.
type Ends = Vec<(Vector3<f64>, Vector3<f64>)>;

/// Spans between two reports: well below a millisecond of work.
const REPORTED: usize = 256;

/// Returns the ends of straight moves within tolerance of spans.
fn divided(
    ranges: &[[f64; 2]],
    rows: &[[f64; 54]],
    tolerance: [f64; 2],
    progress: &dyn Progress,
) -> Result<Ends, DivisionError> {
    let mut poses = Vec::new();
    for (index, ([low, high], row)) in ranges.iter().zip(rows).enumerate() {
        if index.is_multiple_of(REPORTED) {
            let step = progress.step(Stage::ToolPath, index as u64, rows.len() as u64);
            step.map_err(DivisionError::Cancelled)?;
        }
        let span = span_of(row);
        let parts = parts(&span, high - low, tolerance).map_err(DivisionError::TooMany)?;
        let all = poses.len() as f64 + f64::from(parts);
        if all > MOST_LOCATIONS {
            return Err(DivisionError::TooMany(all));
        }
        if poses.is_empty() {
            poses.push(at(&span, 0.0));
        }
        let step = (high - low) / f64::from(parts);
        poses.extend((1..=parts).map(|part| at(&span, step * f64::from(part))));
    }
    Ok(poses)
}

/// Most straight moves of one span: far beyond any control, and it fits in memory.
const MOST_PARTS: f64 = 1e6;

/// Returns the number of equal parts whose chords stay within tolerance; the number that would be needed if there
/// are too many.
fn parts(span: &PoseSpan, length: f64, [tip, axis]: [f64; 2]) -> Result<u32, f64> {
    let [of_tip, of_axis, shortest] = bends(span, length);
    // A chord of length h leaves its curve by at most h² max|c''| / 8.
    let needed = |bend: f64, tolerance: f64| length * (bend / (8.0 * tolerance)).sqrt();
    // Half of the angle for the chord, half for the difference of equal shares from the great circle.
    let parts = needed(of_tip, tip).max(needed(of_axis / shortest, 0.5 * axis)).ceil().max(1.0);
    if parts <= MOST_PARTS {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let parts = parts as u32;
        return Ok(parts);
    }
    Err(parts)
}

/// Returns upper bounds of the second derivatives of tip and axis vector, and a lower bound of its length.
fn bends(span: &PoseSpan, h: f64) -> [f64; 3] {
    let [_, _, c2, c3, c4, c5] = span.coefficients;
    // The second derivative is a cubic, and lies in the hull of its Bernstein points.
    let (a, b, c, d) = (2.0 * c2, 6.0 * h * c3, 12.0 * h * h * c4, 20.0 * h.powi(3) * c5);
    let points = [a, a + b / 3.0, a + 2.0 * b / 3.0 + c / 3.0, a + b + c + d];
    let tip = |point: &PoseCoordinates| Vector3::new(point[0], point[1], point[2]).norm();
    let axis = |point: &PoseCoordinates| Vector3::new(point[3], point[4], point[5]).norm();
    let most = |part: &dyn Fn(&PoseCoordinates) -> f64| points.iter().map(part).fold(0.0, f64::max);
    let shortest = axis(&span.coefficients[0]).min(at(span, h).1.norm());
    // Between the ends the vector is shorter than at them by no more than a chord of the bend.
    let sag = h * h * most(&axis) / 8.0;
    [most(&tip), most(&axis), (shortest - sag).max(0.5 * shortest).max(f64::MIN_POSITIVE)]
}

/// Returns tip and tool axis at a parameter from the start of a span.
fn at(span: &PoseSpan, x: f64) -> (Vector3<f64>, Vector3<f64>) {
    let value = span.coefficients.iter().rev().fold(PoseCoordinates::zeros(), |sum, c| sum * x + c);
    let axis = Vector3::new(value[3], value[4], value[5]);
    (Vector3::new(value[0], value[1], value[2]), axis.normalize())
}

fn span_of(row: &[f64; 54]) -> PoseSpan {
    let of = |k: usize| PoseCoordinates::from_fn(|axis, _| row[9 * k + axis]);
    PoseSpan { coefficients: [0, 1, 2, 3, 4, 5].map(of) }
}

fn poses(view: &Poses<'_>) -> Vec<ToolPose> {
    let pose = |(tip, axis): (&[f64; 3], &[f64; 3])| ToolPose {
        tip: (*tip).into(),
        axis: Unit::new_normalize(Vector3::from(*axis)),
    };
    view.tips.iter().zip(view.axes).map(pose).collect()
}

/// Returns arrays of tips and axes.
fn pair(
    py: Python<'_>,
    poses: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)>,
) -> PyResult<PosePair<'_>> {
    let (mut tips, mut axes) = (Vec::new(), Vec::new());
    for (tip, axis) in poses {
        tips.extend(<[f64; 3]>::from(tip));
        axes.extend(<[f64; 3]>::from(axis));
    }
    let shape = [tips.len() / 3, 3];
    Ok((array(py, tips, &shape)?, array(py, axes, &shape)?))
}
