//! A C3 path within tolerance of a polyline of cutter locations, in one pass over it.

mod band;
mod bezier;
mod bound;
mod chunk;
mod error;
mod fit;
mod knots;
mod run;

pub use error::SmoothError;
pub use run::{SAME, Smoother};

use crate::math::angle::angle_between;
use crate::types::{PoseCoordinates, PoseCurve, PoseSpan, Station, ToolPose};

/// What a smoothed path stands for, and is compared with, between stations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reference {
    /// Straight moves of tip and contact, great circles of the tool axis at the same share: a file
    /// of cutter locations, taken by its word.
    Chords,
    /// The curve through the stations that is the pass: the C2 cubic of [`super::through`]. A [`Smoother`] is told
    /// it by [`Smoother::push_along`]; it takes the local cubic ([`super::local_cubic`]) if it is not.
    Curve,
}

/// How a path is smoothed. No `Default`: the caller knows the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmoothOptions {
    /// Largest distance of tip and contact \[mm\].
    pub tip: f64,
    /// Largest angle of the tool axis \[rad\].
    pub axis: f64,
    /// What the path is compared with.
    pub reference: Reference,
    /// Distance from the tip at which a turn of the tool axis counts as movement \[mm per rad\];
    /// only used where tip and contact (nearly) stand still.
    pub lever: f64,
    /// Turn of the direction of the tip from which a station is a corner, if it stands out by more
    /// than the tolerance \[rad\].
    pub corner: f64,
    /// Ratio of neighbouring steps from which the station between them is a corner.
    pub step_ratio: f64,
    /// Largest turn of the direction of the tip that is blended; at others the tool stops \[rad\].
    pub largest_blend: f64,
    /// Stations in memory at a time; at least 64.
    pub window: usize,
}

/// How far a path strays, at equal parameters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviated {
    /// Distance of the tip, the largest seen at the ends and in the middle of steps \[mm\].
    pub tip: f64,
    /// Distance of the tip, bounded everywhere \[mm\].
    pub tip_bound: f64,
    /// Angle of the tool axis, the largest seen \[rad\].
    pub axis: f64,
    /// Angle of the tool axis, bounded everywhere \[rad\].
    pub axis_bound: f64,
    /// Distance of the contact point, bounded everywhere \[mm\].
    pub contact_bound: f64,
}

/// One polynomial of a smoothed path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmoothSpan {
    /// Where it starts and ends; spans follow one another without gaps.
    pub range: [f64; 2],
    /// The polynomial, over the distance from its start.
    pub span: PoseSpan,
    /// How far it strays.
    pub deviated: Deviated,
    /// Index of the last station before it, or at its start.
    pub station: usize,
    /// Whether the tool rests where the span starts: a corner that was not blended.
    pub after_stop: bool,
}

impl SmoothSpan {
    /// Into how many equal parts of the parameter the span has to be divided for straight moves and
    /// great circles between their ends to keep within `tip` \[mm\] and `axis` \[rad\] of it: an eighth of
    /// the largest second derivative, which lies in the convex hull of its Bernstein coefficients.
    pub fn chords(&self, tip: f64, axis: f64) -> u32 {
        let width = self.range[1] - self.range[0];
        let [place, turn] = bound::bend(&self.span.coefficients, width);
        // Axis vectors are unit to within the tolerance of the axis; chords of up to a right angle
        // come no closer than cos 45 degrees to the centre.
        let parts = (0.125 * (place / tip).max(std::f64::consts::SQRT_2 * turn / axis)).sqrt();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let parts = parts.ceil().clamp(1.0, f64::from(u16::MAX)) as u32;
        parts
    }

    /// Tool pose at a share of the span; `None` where the axis vector vanishes.
    pub fn pose(&self, share: f64) -> Option<ToolPose> {
        let x = self.span.value(share * (self.range[1] - self.range[0]));
        ToolPose::new(bound::tip(&x).into(), bound::axis(&x).into())
    }
}

/// What smoothing did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SmoothReport {
    /// Stations taken in.
    pub stations: usize,
    /// Stations left out because they are within 1/64 of the tolerances of the one before.
    pub merged: usize,
    /// Polynomials.
    pub spans: usize,
    /// Corners rounded within tolerance.
    pub blended: usize,
    /// Corners at which the tool stops.
    pub stops: usize,
    /// Largest deviations and their bounds.
    pub deviated: Deviated,
}

impl SmoothReport {
    /// Takes in what was done on another path.
    pub fn add(&mut self, other: &Self) {
        self.stations += other.stations;
        self.merged += other.merged;
        self.spans += other.spans;
        self.blended += other.blended;
        self.stops += other.stops;
        self.deviated = self.deviated.worst(&other.deviated);
    }
}

/// A smoothed path.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// C3 curves; the tool rests where two meet.
    pub curves: Vec<PoseCurve>,
    /// Deviation of every span, curve by curve.
    pub deviated: Vec<Vec<Deviated>>,
    /// The numbers.
    pub report: SmoothReport,
}

/// Tolerances and what they refer to.
#[derive(Debug, Clone, Copy)]
struct Limits {
    tip: f64,
    axis: f64,
    reference: Reference,
}

impl Limits {
    /// Square of a difference in tip and axis, in tolerances.
    fn square(&self, difference: &PoseCoordinates) -> f64 {
        let tip = bound::tip(difference).norm_squared() / (self.tip * self.tip);
        tip + bound::axis(difference).norm_squared() / (self.axis * self.axis)
    }
}

impl Deviated {
    /// The larger of both, part by part.
    #[must_use]
    pub fn worst(&self, other: &Self) -> Self {
        Self {
            tip: self.tip.max(other.tip),
            tip_bound: self.tip_bound.max(other.tip_bound),
            axis: self.axis.max(other.axis),
            axis_bound: self.axis_bound.max(other.axis_bound),
            contact_bound: self.contact_bound.max(other.contact_bound),
        }
    }

    fn with_slack(mut self, [place, turn]: [f64; 2]) -> Self {
        self.tip_bound += place;
        self.contact_bound += place;
        self.axis_bound += turn;
        self
    }

    fn within(&self, limits: &Limits, share: f64) -> bool {
        self.tip_bound.max(self.contact_bound) <= share * limits.tip
            && self.axis_bound <= share * limits.axis
    }
}

/// Lays a C3 path within tolerance of `stations`: quintic B-splines between corners, corners rounded
/// within the same tolerance, or kept as stops.
///
/// Knots are halved where the deviation, bounded by control points, exceeds a tolerance, and where
/// the stations can be met better; noise is not followed. In memory at a time is a window of
/// [`SmoothOptions::window`] stations ([`Smoother`] hands out spans as they are ready).
///
/// # Errors
///
/// [`SmoothError`] with the station concerned.
///
/// # Example
///
/// ```
/// use trunnion::toolpath::{Reference, SmoothOptions, smooth};
/// use trunnion::types::{Station, ToolPose};
///
/// let at = |k: u32| {
///     let t = 0.02 * f64::from(k);
///     let pose = ToolPose::new([20.0 * t.cos(), 20.0 * t.sin(), 0.0], [0.2 * t.sin(), 0.0, 1.0]);
///     pose.map(|pose| Station { pose, contact: pose.tip })
/// };
/// let stations: Vec<Station> = (0..=100).filter_map(at).collect();
/// let options = SmoothOptions {
///     tip: 0.005,
///     axis: 1e-4,
///     reference: Reference::Chords,
///     lever: 10.0,
///     corner: 0.35,
///     step_ratio: 8.0,
///     largest_blend: 2.0,
///     window: 1024,
/// };
/// let smoothed = smooth(&stations, &options)?;
/// assert_eq!((smoothed.curves.len(), smoothed.report.stops), (1, 0));
/// assert!(smoothed.report.deviated.tip_bound <= 0.005);
/// # Ok::<(), trunnion::toolpath::SmoothError>(())
/// ```
pub fn smooth(stations: &[Station], options: &SmoothOptions) -> Result<Smoothed, SmoothError> {
    let mut smoother = Smoother::new(options)?;
    match options.reference {
        Reference::Chords => stations.iter().try_for_each(|station| smoother.push(station))?,
        Reference::Curve => along(stations, &mut smoother)?,
    }
    let (spans, mut report) = smoother.finish()?;
    report.stations = stations.len();
    let (mut curves, mut deviated) = (Vec::<PoseCurve>::new(), Vec::<Vec<Deviated>>::new());
    for of in spans {
        if of.after_stop || curves.is_empty() {
            curves.push(PoseCurve { knots: vec![of.range[0]], spans: Vec::new() });
            deviated.push(Vec::new());
        }
        if let (Some(curve), Some(deviated)) = (curves.last_mut(), deviated.last_mut()) {
            curve.knots.push(of.range[1]);
            curve.spans.push(of.span);
            deviated.push(of.deviated);
        }
    }
    Ok(Smoothed { curves, deviated, report })
}

/// Places on the pass for each of its stations: the spline meets its own knots with jumps of the third
/// derivative, which a C3 path can only follow with spans that are shorter.
const PLACES: usize = 4;

/// Takes in the C2 cubic through the stations.
fn along(stations: &[Station], smoother: &mut Smoother) -> Result<(), SmoothError> {
    let finite = |station: &Station| station.coordinates().iter().all(|x| x.is_finite());
    if let Some(station) = stations.iter().position(|station| !finite(station)) {
        return Err(SmoothError::NotFinite(station));
    }
    if stations.len() < 2 {
        return Err(SmoothError::Stations(stations.len()));
    }
    for (station, pair) in stations.windows(2).enumerate() {
        let angle = angle_between(&pair[0].pose.axis, &pair[1].pose.axis);
        if angle > run::LARGEST_TURN {
            let limit = run::LARGEST_TURN;
            return Err(SmoothError::AxisReversal { station, angle, limit });
        }
        // No cubic passes through one place twice without leaving it.
        if pair[0].advance(&pair[1], smoother.lever()) <= 0.0 {
            return Err(SmoothError::Repeated(station));
        }
    }
    let curve = PoseCurve::through(stations, smoother.lever());
    let last = curve.spans.len() - 1;
    for (index, (span, ends)) in curve.spans.iter().zip(curve.knots.windows(2)).enumerate() {
        for place in 0..PLACES + usize::from(index == last) {
            let x = (ends[1] - ends[0]) * place as f64 / PLACES as f64;
            let [value, rate, ..] = span.derivatives(x);
            smoother.push_along(ends[0] + x, &value, &rate).map_err(|error| error.at(index))?;
        }
    }
    Ok(())
}
