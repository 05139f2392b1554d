//! The error along the torus circle: samples, slopes, local extrema.

use crate::math;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::distance::ring::{CenterCircle, CirclePoint};
use crate::positioning::error::PositioningError;
use nalgebra::Point3;
use std::f64::consts::PI;

/// Error of one circle point: signed distance to the surface minus the corner radius.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ErrorSample {
    /// Angle from the middle of the arc, towards the second end point \[rad\].
    pub(crate) psi: f64,
    /// The point of the circle.
    pub(crate) at: Point3<f64>,
    /// Error \[mm\].
    pub(crate) error: f64,
    /// Its derivative by the angle \[mm/rad\].
    pub(crate) slope: f64,
    /// Its second derivative \[mm/rad^2\].
    pub(crate) bend: f64,
    /// The part of it that the circle has on a plane \[mm/rad^2\].
    pub(crate) plane_bend: f64,
    /// The part of its third derivative that does not come from a change of the surface's curvature
    /// \[mm/rad^3\].
    pub(crate) twist: f64,
    /// `true` if the sample stands for an extremum next to it that was followed.
    pub(crate) followed: bool,
    pub(crate) reading: DistanceReading,
}

/// A circle in space whose points are read one after another, each from its neighbour's foot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ErrorCircle {
    pub(crate) ring: CenterCircle,
    pub(crate) minor: f64,
}

/// Local extremum of the error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ErrorExtremum {
    pub(crate) sample: ErrorSample,
    /// Value at the extremum itself, by the parabola through the sample next to it \[mm\].
    pub(crate) value: f64,
    pub(crate) maximum: bool,
}

/// Newton steps from the root of the cubic to the extremum.
const REFINEMENTS: u32 = 3;

/// Angle \[rad\] within which an extremum is found: its value is then off by `E'' LEVEL^2 / 2`
/// before the correction by the parabola, some 1e-9 mm, and its derivatives by 1e-4 of themselves.
const LEVEL: f64 = 1e-4;

impl ErrorSample {
    /// Returns `true` if the sample is an extremum already.
    fn level(&self) -> bool {
        self.followed || (self.bend.abs() > 0.0 && self.slope.abs() <= LEVEL * self.bend.abs())
    }

    /// Returns the value at the extremum of the parabola through the sample.
    pub(crate) fn vertex(&self) -> f64 {
        // The parabola E + E' x + E'' x^2 / 2 has its vertex E'^2 / 2 E'' lower (higher where E'' <
        // 0).
        let fall =
            if self.bend.abs() > 0.0 { 0.5 * self.slope * self.slope / self.bend } else { 0.0 };
        self.error - fall
    }

    /// Returns the error, or that of the minimum next to the sample.
    pub(crate) fn low(&self) -> f64 {
        if self.bend > 0.0 && self.level() { self.vertex() } else { self.error }
    }

    /// Returns the error, or that of the maximum next to the sample.
    pub(crate) fn high(&self) -> f64 {
        if self.bend < 0.0 && self.level() { self.vertex() } else { self.error }
    }

    /// Returns `true` if the error falls with the angle just beside the sample: where it is level, on
    /// the side `sign` of it.
    fn falls(&self, sign: f64) -> bool {
        if self.level() { sign * self.bend < 0.0 } else { self.slope < 0.0 }
    }
}

impl ErrorCircle {
    /// Reads the error at `psi`, its foot sought near `guess`.
    pub(crate) fn read(
        &self,
        psi: f64,
        guess: [f64; 2],
        probe: &mut FaceProbe,
    ) -> Result<ErrorSample, PositioningError> {
        let point = self.ring.point(psi);
        Ok(self.sample_at(&point, &probe.read(&point.at, guess)?))
    }

    /// Makes a sample of a reading at `psi`.
    pub(crate) fn sample(&self, psi: f64, reading: &DistanceReading) -> ErrorSample {
        self.sample_at(&self.ring.point(psi), reading)
    }

    fn sample_at(&self, point: &CirclePoint, reading: &DistanceReading) -> ErrorSample {
        let CirclePoint { psi, at, tangent } = *point;
        // The gradient of the distance is the normal n, so by the chain rule E' = n . t and E'' = n
        // . a + H(t, t), with t the tangent, a the way to the centre, and H the second derivative
        // of the distance.
        let n = reading.normal();
        let inward = self.ring.center - at;
        let (plane_bend, slope) = (n.dot(&inward), n.dot(&tangent));
        let [along, across] = reading.hessians(&tangent, &inward);
        ErrorSample {
            psi,
            at,
            error: reading.distance - self.minor,
            slope,
            bend: plane_bend + along,
            plane_bend,
            // E''' without the change of curvature: n . a' = -n . t, and H(t, a) enters three
            // times.
            twist: 3.0 * across - slope,
            followed: false,
            reading: *reading,
        }
    }

    /// Reads the error as [`ErrorCircle::read`] does, starting from a sample nearby.
    pub(crate) fn read_from(
        &self,
        psi: f64,
        from: &ErrorSample,
        probe: &mut FaceProbe,
    ) -> Result<ErrorSample, PositioningError> {
        let point = self.ring.point(psi);
        let reading = probe.read_from(&point.at, &from.reading, &(point.at - from.at))?;
        Ok(self.sample_at(&point, &reading))
    }

    /// Reads samples at the given angles, in order, from a first one nearby.
    pub(crate) fn walk(
        &self,
        angles: impl Iterator<Item = f64>,
        start: &ErrorSample,
        probe: &mut FaceProbe,
    ) -> Result<Vec<ErrorSample>, PositioningError> {
        let mut samples = Vec::with_capacity(angles.size_hint().0);
        let mut last = *start;
        for psi in angles {
            last = self.read_from(psi, &last, probe)?;
            samples.push(last);
        }
        Ok(samples)
    }

    /// Reads samples over the front, `[-half, half]`: `count` intervals, closer
    /// together towards the ends (Chebyshev's abscissas).
    pub(crate) fn front(
        &self,
        half: f64,
        count: u32,
        first: &DistanceReading,
        probe: &mut FaceProbe,
    ) -> Result<Vec<ErrorSample>, PositioningError> {
        let start = self.read(-half, first.foot.uv.into(), probe)?;
        let angles = (1..=count).map(|k| -half * math::cos(PI * f64::from(k) / f64::from(count)));
        // Each foot is the guess for the next one, so that Newton's method stays on one branch.
        let mut samples = self.walk(angles, &start, probe)?;
        samples.insert(0, start);
        Ok(samples)
    }

    /// Reads samples strictly between the second end point and, round the rear, the first:
    /// `count - 1` of them, closer together towards the ends, where a level end point hides a
    /// minimum next to it; `from` is the sample at the second end point.
    pub(crate) fn rear(
        &self,
        half: f64,
        count: u32,
        from: &ErrorSample,
        probe: &mut FaceProbe,
    ) -> Result<Vec<ErrorSample>, PositioningError> {
        // Chebyshev's abscissas of the rear, which is centred at the angle pi.
        let span = PI - half;
        let angles =
            (1..count).map(|k| PI - span * math::cos(PI * f64::from(k) / f64::from(count)));
        self.walk(angles, from, probe)
    }

    /// Finds the local extrema between neighbouring samples, refined by one reading each.
    pub(crate) fn extrema(
        &self,
        samples: &[ErrorSample],
        probe: &mut FaceProbe,
    ) -> Result<Vec<ErrorExtremum>, PositioningError> {
        let mut found = Vec::new();
        for (place, pair) in samples.windows(2).enumerate() {
            let [a, b] = pair else { continue };
            // An extremum lies between two samples where the error falls behind one and rises
            // before the other, or the reverse.
            if a.falls(1.0) != b.falls(-1.0) {
                found.push(self.between([a, b], probe)?);
            }
            // A sample may lie at an extremum; those at the ends are none of the inside.
            if b.level() && place + 2 < samples.len() {
                found.push(ErrorExtremum { sample: *b, value: b.vertex(), maximum: b.bend < 0.0 });
            }
        }
        Ok(found)
    }

    /// Finds the extremum between two samples that lie on different sides of it.
    fn between(
        &self,
        [a, b]: [&ErrorSample; 2],
        probe: &mut FaceProbe,
    ) -> Result<ErrorExtremum, PositioningError> {
        // The slope changes its sign between the samples: it rises first at a maximum.
        let maximum = !a.falls(1.0);
        let psi = level(a, b);
        // The nearer sample gives the better first-order guess for the foot.
        let nearest = if psi - a.psi < b.psi - psi { a } else { b };
        let mut sample = self.read_from(psi, nearest, probe)?;
        // Newton's steps on the slope, kept in the bracket.
        for _ in 0..REFINEMENTS {
            let psi = sample.psi - sample.slope / sample.bend;
            if (psi - sample.psi).abs() <= LEVEL || !(psi > a.psi && psi < b.psi) {
                break;
            }
            sample = self.read_from(psi, &sample, probe)?;
        }
        // A bend of the wrong sign would carry the parabola's vertex away: keep the sample.
        let vertex = if (sample.bend < 0.0) == maximum { sample.vertex() } else { sample.error };
        // The parabola may not move the value by more than the samples differ.
        let spread = (a.error - b.error).abs().max((a.error - sample.error).abs());
        let value = sample.error + (vertex - sample.error).clamp(-spread, spread);
        Ok(ErrorExtremum { sample, value, maximum })
    }

    /// Reads samples over `[-pi, pi]`, evenly spaced, `2 half + 1` of them; the foot at the angle 0 is
    /// sought near `guess`.
    pub(crate) fn all_round(
        &self,
        guess: [f64; 2],
        half: u32,
        probe: &mut FaceProbe,
    ) -> Result<Vec<ErrorSample>, PositioningError> {
        let seed = self.read(0.0, guess, probe)?;
        let step = PI / f64::from(half.max(1));
        let angles = |sign: f64| (1..=half).map(move |k| sign * step * f64::from(k));
        let mut samples = self.walk(angles(-1.0), &seed, probe)?;
        // Backward half first, so that the angles ascend from -pi to pi.
        samples.reverse();
        samples.push(seed);
        samples.extend(self.walk(angles(1.0), &seed, probe)?);
        Ok(samples)
    }
}

/// Returns the angle between two samples at which the slope vanishes: the root of the cubic through slopes and
/// bends, by bisection (the slopes differ in sign).
fn level(a: &ErrorSample, b: &ErrorSample) -> f64 {
    let h = b.psi - a.psi;
    // Cubic Hermite interpolation of the slope: the slopes themselves as values, the bends as
    // derivatives.
    let slope = |t: f64| {
        let u = 1.0 - t;
        a.slope * u * u * (1.0 + 2.0 * t)
            + b.slope * t * t * (3.0 - 2.0 * t)
            + h * (a.bend * t * u * u - b.bend * t * t * u)
    };
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    // 2^-24 of the interval: below what the cubic is true to.
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if (slope(middle) < 0.0) == a.falls(1.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    a.psi + h * 0.5 * (low + high)
}
