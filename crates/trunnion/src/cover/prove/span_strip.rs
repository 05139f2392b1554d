//! Strip that an interpolated pose leaves, between two stations.

use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::ChartPoint;
use crate::cutter::Cutter;
use crate::math;
use crate::positioning::ToleranceBand;
use crate::surface::{ClosestError, FaceIndex};
use crate::types::ToolPose;
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use std::f64::consts::TAU;

/// Points of the centre circle that are evaluated; between them minima are taken from parabolas.
const POINTS: u32 = 96;

/// Steps of regula falsi for the end of the strip. Each gains about two digits on the smooth,
/// nearly straight error curve within one of [`POINTS`] intervals.
const STEPS: u32 = 3;

/// Rings and spokes at which the flat underside is evaluated, and steps of descent from the lowest
/// of them.
const RINGS: u32 = 2;
const SPOKES: u32 = 8;
const DESCENTS: u32 = 2;

/// Point of the flat underside, raised to the plane of the centre circle.
struct UndersidePoint {
    point: Point3<f64>,
    error: f64,
    /// Change of the error in the plane of the circle \[1\].
    slope: Vector3<f64>,
    uv: [f64; 2],
}

/// Strip of an interpolated pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpanStrip {
    /// Point farthest across that is finished; `None` where the error in the middle of the contact
    /// arc is above the band already.
    pub(crate) far: Option<ChartPoint>,
    /// Least error of the circle and of the flat underside inside it, over the face's own rectangle
    /// \[mm\]. Beside the rectangle the continued surface may rise, but there is nothing to cut.
    pub(crate) least: f64,
}

/// Face, cutter and band that poses are checked against.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpanCheck<'a> {
    pub(crate) face: &'a FaceIndex,
    pub(crate) cutter: &'a Cutter,
    pub(crate) chart: &'a Chart,
    /// The band at the stations, widened by what the curve may add.
    pub(crate) band: ToleranceBand,
}

/// Error at one point of the circle, and its foot.
#[derive(Debug, Clone, Copy)]
struct CircleSample {
    angle: f64,
    error: f64,
    uv: [f64; 2],
}

/// Centre circle of a pose, with angle 0 over the contact.
struct CentreCircle {
    centre: Point3<f64>,
    axes: [UnitVector3<f64>; 2],
    radius: f64,
}

impl CentreCircle {
    fn new(pose: &ToolPose, cutter: &Cutter, contact: &Point3<f64>) -> Self {
        let centre = pose.tip + pose.axis.scale(cutter.minor());
        let out = contact - centre;
        let flat = out - pose.axis.scale(out.dot(&pose.axis));
        // A contact right below the centre (a ball) has no direction: any one serves.
        let e = Unit::try_new(flat, f64::MIN_POSITIVE).unwrap_or_else(|| {
            Unit::new_normalize(pose.axis.cross(&Vector3::ith(pose.axis.iamin(), 1.0)))
        });
        let axes = [e, Unit::new_normalize(pose.axis.cross(&e))];
        Self { centre, axes, radius: cutter.major() }
    }

    fn point(&self, angle: f64) -> Point3<f64> {
        let (sin, cos) = math::sin_cos(angle);
        self.centre + self.axes[0].scale(self.radius * cos) + self.axes[1].scale(self.radius * sin)
    }
}

impl SpanCheck<'_> {
    /// Returns the strip of `pose`, whose contact is near `contact` with parameters near `guess`.
    ///
    /// # Errors
    ///
    /// [`ClosestError`] where the surface has no closest point or normal.
    pub(crate) fn strip(
        &self,
        pose: &ToolPose,
        contact: &Point3<f64>,
        guess: [f64; 2],
    ) -> Result<SpanStrip, ClosestError> {
        let circle = CentreCircle::new(pose, self.cutter, contact);
        let middle = self.sample(&circle, 0.0, guess)?;
        let mut strip = SpanStrip { far: None, least: f64::INFINITY };
        for sign in [1.0, -1.0] {
            let half = self.half(&circle, middle, sign)?;
            strip.least = strip.least.min(self.least(&circle, &half));
            let far = self.far(&circle, &half)?;
            strip.far = strip.far.into_iter().chain(far).max_by(|a, b| a[0].total_cmp(&b[0]));
        }
        strip.least = strip.least.min(self.disc(&circle, &pose.axis, middle.uv)?);
        Ok(strip)
    }

    /// Returns the least error of the flat underside inside the circle: the lowest point of a few
    /// rings, and from there down its slope. Where the surface bulges up inside the circle, this is
    /// lower than the circle.
    fn disc(
        &self,
        c: &CentreCircle,
        axis: &UnitVector3<f64>,
        guess: [f64; 2],
    ) -> Result<f64, ClosestError> {
        let mut lowest = self.under(c, axis, c.centre, guess)?;
        for ring in 1..=RINGS {
            let radius = c.radius * f64::from(ring) / f64::from(RINGS + 1);
            for spoke in 0..SPOKES {
                let (sin, cos) = math::sin_cos(TAU * f64::from(spoke) / f64::from(SPOKES));
                let out = c.axes[0].scale(radius * cos) + c.axes[1].scale(radius * sin);
                let under = self.under(c, axis, c.centre + out, lowest.uv)?;
                if under.error < lowest.error {
                    lowest = under;
                }
            }
        }
        for _ in 0..DESCENTS {
            let slope = lowest.slope.norm();
            let Some(down) = Unit::try_new(-lowest.slope, f64::MIN_POSITIVE) else { break };
            let step = c.radius / f64::from(RINGS + 1);
            let next = self.under(c, axis, lowest.point + down.scale(step), lowest.uv)?;
            // Root of the slope along the descent by the secant.
            // Change of the slope along the step; at its start it is -slope.
            let turned = next.slope.dot(&down) + slope;
            let way = if turned > 0.0 { step * slope / turned } else { step };
            // Stay inside the circle: a step beyond it ends on it.
            let flat = lowest.point + down.scale(way) - c.centre;
            let inside = flat * (c.radius / flat.norm().max(c.radius));
            let settled = self.under(c, axis, c.centre + inside, lowest.uv)?;
            if settled.error < lowest.error {
                lowest = settled;
            }
        }
        Ok(lowest.error)
    }

    /// Evaluates the underside at a point of the circle's plane; infinitely high where its foot is
    /// beside the face.
    fn under(
        &self,
        c: &CentreCircle,
        axis: &UnitVector3<f64>,
        point: Point3<f64>,
        guess: [f64; 2],
    ) -> Result<UndersidePoint, ClosestError> {
        let foot = self.face.closest_near(&point, guess.into())?;
        let domain = self.face.face().surface.domain();
        let uv: [f64; 2] = foot.uv.into();
        let over = uv.iter().zip(domain).all(|(at, range)| range.contains(*at));
        let inside = (point - c.centre).norm() <= c.radius;
        let error =
            if over && inside { foot.distance - self.cutter.minor() } else { f64::INFINITY };
        let normal = foot.normal.into_inner();
        Ok(UndersidePoint {
            point,
            error,
            slope: normal - axis.scale(normal.dot(axis)),
            uv: foot.uv.into(),
        })
    }

    fn sample(
        &self,
        c: &CentreCircle,
        angle: f64,
        guess: [f64; 2],
    ) -> Result<CircleSample, ClosestError> {
        let foot = self.face.closest_near(&c.point(angle), guess.into())?;
        Ok(CircleSample { angle, error: foot.distance - self.cutter.minor(), uv: foot.uv.into() })
    }

    /// Evaluates half the circle from the middle of the contact arc; each foot is the guess for the
    /// next.
    fn half(
        &self,
        c: &CentreCircle,
        middle: CircleSample,
        sign: f64,
    ) -> Result<Vec<CircleSample>, ClosestError> {
        let mut half = vec![middle];
        let mut guess = middle.uv;
        for i in 1..=POINTS / 2 {
            let sample = self.sample(c, sign * TAU * f64::from(i) / f64::from(POINTS), guess)?;
            guess = sample.uv;
            half.push(sample);
        }
        Ok(half)
    }

    /// Returns the least error over the rectangle of the face; at a dip, that of the parabola
    /// through three samples.
    fn least(&self, c: &CentreCircle, half: &[CircleSample]) -> f64 {
        let domain = self.face.face().surface.domain();
        let clamp = |uv: [f64; 2]| [0, 1].map(|k| domain[k].clamp(uv[k]));
        let over = |s: &CircleSample| (0..2).all(|k| domain[k].contains(s.uv[k]));
        // Above a foot beside the face, the face is as far as its border, seen from either side.
        let border = |s: &CircleSample| {
            let [u, v] = clamp(s.uv);
            (c.point(s.angle) - self.face.face().point(u, v)).norm() - self.cutter.minor()
        };
        let sampled = half.iter().map(|s| if over(s) { s.error } else { border(s) });
        let dips = half.windows(3).filter(|w| over(&w[1]));
        let dips = dips.filter_map(|w| dip(w[0].error, w[1].error, w[2].error));
        sampled.chain(dips).fold(f64::INFINITY, f64::min)
    }

    /// Returns the point farthest across on this half before the error exceeds the band; `None` if
    /// it does so at the start already. Where the arc curls back, the strip is widest before its
    /// end.
    fn far(
        &self,
        c: &CentreCircle,
        half: &[CircleSample],
    ) -> Result<Option<ChartPoint>, ClosestError> {
        let out = half.iter().position(|sample| sample.error > self.band.upper);
        let inside = &half[..out.unwrap_or(half.len())];
        let mut ends: Vec<CircleSample> = inside.to_vec();
        if let (Some(&last), Some(out)) = (inside.last(), out) {
            ends.push(self.end(c, last, half[out])?);
        }
        let places = ends.iter().map(|sample| self.chart.local(sample.uv));
        Ok(places.max_by(|a, b| a[0].total_cmp(&b[0])))
    }

    /// Returns the last point found before the error exceeds the band, between a point inside and
    /// one outside.
    fn end(
        &self,
        c: &CentreCircle,
        mut inside: CircleSample,
        mut outside: CircleSample,
    ) -> Result<CircleSample, ClosestError> {
        let upper = self.band.upper;
        for _ in 0..STEPS {
            // Secant between the last points on both sides of the band.
            let share = (upper - inside.error) / (outside.error - inside.error);
            let angle = inside.angle + share * (outside.angle - inside.angle);
            let sample = self.sample(c, angle, inside.uv)?;
            if sample.error > upper { outside = sample } else { inside = sample }
        }
        Ok(inside)
    }
}

/// Returns the least value of the parabola through three evenly spaced values with a dip in the
/// middle.
fn dip(a: f64, b: f64, c: f64) -> Option<f64> {
    // The parabola b + slope x + bend x² / 2 is least at x = -slope / bend.
    let (slope, bend) = (0.5 * (c - a), a - 2.0 * b + c);
    (b <= a && b <= c && bend > 0.0).then(|| b - 0.5 * slope * slope / bend)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dip_of_a_parabola_is_exact() {
        let f = |x: f64| 3.0 + 2.0 * (x - 0.2) * (x - 0.2);
        let found = dip(f(-1.0), f(0.0), f(1.0)).unwrap();
        assert!((found - 3.0).abs() < 1e-14);
        assert_eq!(dip(0.0, 1.0, 0.0), None);
    }
}
