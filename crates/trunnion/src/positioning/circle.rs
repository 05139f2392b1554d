//! The error along the torus circle: samples, slopes, local extrema.

use super::PositioningError;
use super::placement::Ring;
use super::probe::Probe;
use super::probe::Reading;
use nalgebra::Point3;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Error of one circle point: signed distance to the surface minus the corner radius.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Angle from the middle of the arc, towards the second end point \[rad\].
    pub(super) psi: f64,
    /// The point of the circle.
    pub(super) at: Point3<f64>,
    /// Error \[mm\].
    pub(super) error: f64,
    /// Its derivative by the angle \[mm/rad\].
    pub(super) slope: f64,
    /// Its second derivative \[mm/rad^2\].
    pub(super) bend: f64,
    /// The part of it that the circle has on a plane \[mm/rad^2\].
    pub(super) plane_bend: f64,
    /// The part of its third derivative that does not come from a change of the surface's curvature
    /// \[mm/rad^3\].
    pub(super) twist: f64,
    /// Whether it stands for an extremum next to it that was followed.
    pub(super) followed: bool,
    pub(super) reading: Reading,
}

/// A circle in space whose points are read one after another, each from its neighbour's foot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circle {
    pub(super) ring: Ring,
    pub(super) minor: f64,
}

/// Local extremum of the error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extremum {
    pub(super) sample: Sample,
    /// Value at the extremum itself, by the parabola through the sample next to it \[mm\].
    pub(super) value: f64,
    pub(super) maximum: bool,
}

/// Newton steps from the root of the cubic to the extremum.
const REFINEMENTS: u32 = 3;
/// Angle \[rad\] within which an extremum is found: its value is then off by `E'' LEVEL^2 / 2`
/// before the correction by the parabola, some 1e-9 mm, and its derivatives by 1e-4 of themselves.
const LEVEL: f64 = 1e-4;

impl Sample {
    /// Whether it is an extremum already.
    fn level(&self) -> bool {
        self.followed || (self.bend.abs() > 0.0 && self.slope.abs() <= LEVEL * self.bend.abs())
    }

    /// Value of the parabola's extremum.
    pub(super) fn vertex(&self) -> f64 {
        let fall =
            if self.bend.abs() > 0.0 { 0.5 * self.slope * self.slope / self.bend } else { 0.0 };
        self.error - fall
    }

    /// The error, or that of the minimum next to it.
    pub(super) fn low(&self) -> f64 {
        if self.bend > 0.0 && self.level() { self.vertex() } else { self.error }
    }

    /// The error, or that of the maximum next to it.
    pub(super) fn high(&self) -> f64 {
        if self.bend < 0.0 && self.level() { self.vertex() } else { self.error }
    }

    /// Whether the error falls with the angle just beside the sample: where it is level, on the
    /// side `sign` of it.
    fn falls(&self, sign: f64) -> bool {
        if self.level() { sign * self.bend < 0.0 } else { self.slope < 0.0 }
    }
}

impl Circle {
    /// Error at `psi`, its foot sought near `guess`.
    pub(super) fn read(
        &self,
        psi: f64,
        guess: [f64; 2],
        probe: &mut Probe,
    ) -> Result<Sample, PositioningError> {
        let mark = self.ring.mark(psi);
        Ok(self.marked(psi, mark, &probe.read(&mark.0, guess)?))
    }

    /// The sample that a reading at `psi` makes.
    pub(super) fn sample(&self, psi: f64, reading: &Reading) -> Sample {
        self.marked(psi, self.ring.mark(psi), reading)
    }

    fn marked(
        &self,
        psi: f64,
        (at, tangent): (Point3<f64>, Vector3<f64>),
        reading: &Reading,
    ) -> Sample {
        let n = reading.normal();
        let inward = self.ring.center - at;
        let (plane_bend, slope) = (n.dot(&inward), n.dot(&tangent));
        let [along, across] = reading.hessians(&tangent, &inward);
        Sample {
            psi,
            at,
            error: reading.distance - self.minor,
            slope,
            bend: plane_bend + along,
            plane_bend,
            twist: 3.0 * across - slope,
            followed: false,
            reading: *reading,
        }
    }

    /// As [`Circle::read`], starting from a sample nearby.
    pub(super) fn read_from(
        &self,
        psi: f64,
        from: &Sample,
        probe: &mut Probe,
    ) -> Result<Sample, PositioningError> {
        let mark = self.ring.mark(psi);
        let reading = probe.read_from(&mark.0, &from.reading, &(mark.0 - from.at))?;
        Ok(self.marked(psi, mark, &reading))
    }

    /// Samples at the angles given, in order, from a first one nearby.
    pub(super) fn walk(
        &self,
        angles: impl Iterator<Item = f64>,
        start: &Sample,
        probe: &mut Probe,
    ) -> Result<Vec<Sample>, PositioningError> {
        let mut samples = Vec::with_capacity(angles.size_hint().0);
        let mut last = *start;
        for psi in angles {
            last = self.read_from(psi, &last, probe)?;
            samples.push(last);
        }
        Ok(samples)
    }

    /// Samples over the front, `[-half, half]`: `count` intervals, closer
    /// together towards the ends (Chebyshev's abscissas).
    pub(super) fn front(
        &self,
        (half, count): (f64, u32),
        first: &Reading,
        probe: &mut Probe,
    ) -> Result<Vec<Sample>, PositioningError> {
        let start = self.read(-half, first.foot.uv, probe)?;
        let angles = (1..=count).map(|k| -half * (PI * f64::from(k) / f64::from(count)).cos());
        let mut samples = self.walk(angles, &start, probe)?;
        samples.insert(0, start);
        Ok(samples)
    }

    /// Samples strictly between the second end point and, round the rear, the first:
    /// `count - 1` of them, closer together towards the ends, where a level end point hides a
    /// minimum next to it; `from` is the sample at the second end point.
    pub(super) fn rear(
        &self,
        (half, count): (f64, u32),
        from: &Sample,
        probe: &mut Probe,
    ) -> Result<Vec<Sample>, PositioningError> {
        let span = PI - half;
        let angles = (1..count).map(|k| PI - span * (PI * f64::from(k) / f64::from(count)).cos());
        self.walk(angles, from, probe)
    }

    /// Local extrema between neighbouring samples, refined by one reading each.
    pub(super) fn extrema(
        &self,
        samples: &[Sample],
        probe: &mut Probe,
    ) -> Result<Vec<Extremum>, PositioningError> {
        let mut found = Vec::new();
        for (place, pair) in samples.windows(2).enumerate() {
            let [a, b] = pair else { continue };
            let maximum = !a.falls(1.0);
            if a.falls(1.0) != b.falls(-1.0) {
                found.push(self.between([a, b], maximum, probe)?);
            }
            // A sample may lie at an extremum; those at the ends are none of the inside.
            if b.level() && place + 2 < samples.len() {
                found.push(Extremum { sample: *b, value: b.vertex(), maximum: b.bend < 0.0 });
            }
        }
        Ok(found)
    }

    /// The extremum between two samples that lie on different sides of it.
    fn between(
        &self,
        [a, b]: [&Sample; 2],
        maximum: bool,
        probe: &mut Probe,
    ) -> Result<Extremum, PositioningError> {
        let psi = level(a, b);
        let nearest = if psi - a.psi < b.psi - psi { a } else { b };
        let mut sample = self.read_from(psi, nearest, probe)?;
        for _ in 0..REFINEMENTS {
            let psi = sample.psi - sample.slope / sample.bend;
            if (psi - sample.psi).abs() <= LEVEL || !(psi > a.psi && psi < b.psi) {
                break;
            }
            sample = self.read_from(psi, &sample, probe)?;
        }
        // A bend of the wrong sign would carry the parabola's vertex away: keep the sample.
        let vertex = if (sample.bend < 0.0) == maximum { sample.vertex() } else { sample.error };
        let spread = (a.error - b.error).abs().max((a.error - sample.error).abs());
        let value = sample.error + (vertex - sample.error).clamp(-spread, spread);
        Ok(Extremum { sample, value, maximum })
    }
}

/// Angle between two samples at which the slope vanishes: root of the cubic through slopes and
/// bends, by bisection (the slopes differ in sign).
fn level(a: &Sample, b: &Sample) -> f64 {
    let h = b.psi - a.psi;
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
