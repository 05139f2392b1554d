//! A whole path smoothed at once.

use super::error::SmoothError;
use super::options::{SmoothOptions, SmoothReference};
use super::report::{PathDeviation, SmoothReport};
use super::smoother::PathSmoother;
use crate::math::angle::angle_between;
use crate::toolpath::interpolation::LARGEST_TURN;
use crate::types::{PoseCurve, Progress, Stage, Station};

/// Smoothed path.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SmoothedCurves {
    /// C3 curves; the tool rests where two meet.
    pub curves: Vec<PoseCurve>,
    /// Deviation of every span, curve by curve.
    pub deviated: Vec<Vec<PathDeviation>>,
    /// Counts and largest deviations.
    pub report: SmoothReport,
}

/// Lays a C3 path within tolerance of `stations`: quintic B-splines between corners, corners rounded
/// within the same tolerance, or kept as stops.
///
/// Knots are halved where the deviation, bounded by control points, exceeds a tolerance, and where
/// the stations can be met better; noise is not followed. In memory at a time is a window of
/// [`SmoothOptions::window`] stations ([`PathSmoother`] hands out spans as they are ready).
///
/// # Errors
///
/// [`SmoothError`] with the station concerned; [`SmoothError::Cancelled`] on request.
///
/// # Example
///
/// ```
/// use trunnion::toolpath::{SmoothOptions, smooth};
/// use trunnion::types::{PoseTolerance, Silent, Station, ToolPose};
///
/// let at = |k: u32| {
///     let t = 0.02 * f64::from(k);
///     let pose = ToolPose::new([20.0 * t.cos(), 20.0 * t.sin(), 0.0], [0.2 * t.sin(), 0.0, 1.0]);
///     pose.map(|pose| Station { pose, contact: pose.tip })
/// };
/// let stations: Vec<Station> = (0..=100).filter_map(at).collect();
/// let options = SmoothOptions::within(PoseTolerance { tip: 0.005, axis: 1e-4 });
/// let smoothed = smooth(&stations, &options, &Silent)?;
/// assert_eq!((smoothed.curves.len(), smoothed.report.stops), (1, 0));
/// assert!(smoothed.report.deviated.tip_bound <= 0.005);
/// # Ok::<(), trunnion::toolpath::SmoothError>(())
/// ```
pub fn smooth(
    stations: &[Station],
    options: &SmoothOptions,
    progress: &dyn Progress,
) -> Result<SmoothedCurves, SmoothError> {
    let mut smoother = PathSmoother::new(options)?;
    match options.reference {
        SmoothReference::Chords => {
            for (index, station) in stations.iter().enumerate() {
                reported(progress, index, stations.len())?;
                smoother.push(station)?;
            }
        }
        SmoothReference::Curve => along(stations, &mut smoother, progress)?,
    }
    let (spans, mut report) = smoother.finish()?;
    progress.step(Stage::ToolPath, stations.len() as u64, stations.len() as u64)?;
    report.stations = stations.len();
    let (mut curves, mut deviated) = (Vec::<PoseCurve>::new(), Vec::<Vec<PathDeviation>>::new());
    for of in spans {
        if of.after_stop || curves.is_empty() {
            curves.push(PoseCurve { knots: vec![of.range.low], spans: Vec::new() });
            deviated.push(Vec::new());
        }
        if let (Some(curve), Some(deviated)) = (curves.last_mut(), deviated.last_mut()) {
            curve.knots.push(of.range.high);
            curve.spans.push(of.span);
            deviated.push(of.deviated);
        }
    }
    Ok(SmoothedCurves { curves, deviated, report })
}

/// Stations between two reports: a few milliseconds of work.
const REPORTED: usize = 64;

/// Reports that the stations before `index` are taken in, at every one of [`REPORTED`].
fn reported(progress: &dyn Progress, index: usize, stations: usize) -> Result<(), SmoothError> {
    if index.is_multiple_of(REPORTED) {
        progress.step(Stage::ToolPath, index as u64, stations as u64)?;
    }
    Ok(())
}

/// Samples of the pass for each of its stations: at its knots the third derivative of the cubic spline
/// jumps, which a C3 path can follow only with shorter spans.
const SAMPLES: usize = 4;

/// Takes in the C2 cubic through the stations.
fn along(
    stations: &[Station],
    smoother: &mut PathSmoother,
    progress: &dyn Progress,
) -> Result<(), SmoothError> {
    let finite = |station: &Station| station.coordinates().iter().all(|x| x.is_finite());
    if let Some(station) = stations.iter().position(|station| !finite(station)) {
        return Err(SmoothError::NotFinite(station));
    }
    if stations.len() < 2 {
        return Err(SmoothError::Stations(stations.len()));
    }
    for (station, pair) in stations.windows(2).enumerate() {
        let angle = angle_between(&pair[0].pose.axis, &pair[1].pose.axis);
        if angle > LARGEST_TURN {
            let limit = LARGEST_TURN;
            return Err(SmoothError::AxisReversal { station, angle, limit });
        }
        // No cubic passes through one point twice without leaving it.
        if pair[0].advance(&pair[1], smoother.lever()) <= 0.0 {
            return Err(SmoothError::Repeated(station));
        }
    }
    let curve = PoseCurve::through(stations, smoother.lever());
    let last = curve.spans.len() - 1;
    for (index, (span, ends)) in curve.spans.iter().zip(curve.knots.windows(2)).enumerate() {
        reported(progress, index, stations.len())?;
        for sample in 0..SAMPLES + usize::from(index == last) {
            // The last span also gives its end; all others leave it to the next one.
            let x = (ends[1] - ends[0]) * sample as f64 / SAMPLES as f64;
            let [value, rate, ..] = span.derivatives(x);
            smoother.push_along(ends[0] + x, &value, &rate).map_err(|error| error.at(index))?;
        }
    }
    Ok(())
}
