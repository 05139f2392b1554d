//! An independent, dense look at the strip a pose leaves.

use super::Band;
use super::PositioningError;
use super::StripSide;
use super::circle::Circle;
use super::circle::Sample;
use super::disc::Disc;
use super::probe::Probe;
use super::probe::Reading;
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::ToolPose;
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// What a pose is checked against.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    /// The surface.
    pub face: &'a FaceIndex,
    /// The cutter.
    pub cutter: &'a Cutter,
    /// Where the error has to lie.
    pub band: Band,
}

/// Where on the cutter the strip is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Feed direction \[any length\].
    pub feed: Vector3<f64>,
    /// Side of the feed on which the strip lies: tells the near end from the far one.
    pub strip: StripSide,
    /// About where the strip's middle lies \[mm\].
    pub contact: Point3<f64>,
    /// About its parameters.
    pub uv: [f64; 2],
}

/// The strip a pose leaves: the connected part of the circle around the contact whose error does
/// not exceed the band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    /// Projection on the direction across the feed \[mm\]; 0 where the error is above the band
    /// everywhere.
    pub width: f64,
    /// Parameters and point of the end on the side the strip begins.
    pub near: ([f64; 2], Point3<f64>),
    /// Parameters and point of the end on the strip's side.
    pub far: ([f64; 2], Point3<f64>),
    /// Largest error found between the ends \[mm\].
    pub front_max: f64,
    /// What no error between the ends exceeds \[mm\].
    pub front_max_bound: f64,
    /// Least error found between the ends \[mm\]; below the band it is a gouge.
    pub front_min: f64,
    /// Least distance found from the rest of the circle and the disc to the surface \[mm\].
    pub rear_min: f64,
    /// What the distance of circle and disc is at least, strip included \[mm\].
    pub rear_min_bound: f64,
    /// Foot under the middle of the strip: parameters and point.
    pub contact: ([f64; 2], Point3<f64>),
    /// Closest-point queries spent.
    pub queries: u32,
}

/// Samples round the circle. 5 degrees apart on a cutter of 10 mm they are 0.9 mm apart.
const SAMPLES: u32 = 72;

/// Share of the band to which bounds between samples are refined.
const SHARE: f64 = 0.05;

/// Bisections of one gap: each quarters the distance of bound and value.
const DEPTH: u32 = 6;

/// Looks at the strip a pose leaves, without any of the assumptions it was made with.
///
/// The signed error (distance from the surface minus the corner radius) is sampled round the whole
/// circle, extrema and ends of the strip are refined; between samples it is bounded through
/// `|E''| <= R (sin beta + R k / (1 - k (r + E)))`, see `docs/sources.md#004`.
///
/// A pose that gouges is not an error: `front_min` and `rear_min` say so.
///
/// # Errors
///
/// [`PositioningError::NoDirection`] for a feed along the normal, [`PositioningError::Closest`].
pub fn strip_of_pose(
    setting: &Setting,
    pose: &ToolPose,
    look: &Look,
) -> Result<Strip, PositioningError> {
    let mut probe = Probe::new(setting.face);
    let minor = setting.cutter.minor();
    let middle = probe.read(&look.contact, look.uv)?;
    let (ring, v) = super::curve::ring(setting, pose, look, &middle)?;
    if ring.radius <= 0.0 {
        return super::ball::strip(setting, ring.center, (&v, &middle), probe);
    }
    let circle = Circle { ring, minor };
    Survey { setting, circle, axis: pose.axis, v: v.into_inner(), half_arc: 0.0 }
        .strip(middle.foot.uv, &mut probe)
}

/// Distance across the feed between two ends of a strip, in the tangent plane of the first: the
/// second counts where its normal passes through that plane, as `P3` does over `P2`.
pub(super) fn across(v: &Vector3<f64>, near: &Reading, far: &Reading) -> f64 {
    let up = near.normal();
    let out = far.foot.point - near.foot.point;
    let lean = far.normal().dot(&up);
    // Normals at right angles pass through no such plane: the feet themselves count.
    let lift = if lean > 0.0 { -out.dot(&up) / lean } else { 0.0 };
    v.dot(&(out + far.normal().scale(lift)))
}

/// A circle, sampled all round.
pub(super) struct Survey<'a> {
    pub(super) setting: &'a Setting<'a>,
    pub(super) circle: Circle,
    pub(super) axis: UnitVector3<f64>,
    /// Across the feed, to the strip's side.
    pub(super) v: Vector3<f64>,
    /// Half the arc between the end points it was made for \[rad\]; 0 where none are known.
    pub(super) half_arc: f64,
}

/// One side of the strip: its end, and what was seen on the way.
struct Side {
    end: Sample,
    max: f64,
    min: f64,
    inside: Vec<Sample>,
}

impl Survey<'_> {
    /// The strip around the circle angle 0, whose foot is near `guess`.
    pub(super) fn strip(
        &self,
        guess: [f64; 2],
        probe: &mut Probe,
    ) -> Result<Strip, PositioningError> {
        let points = self.sample(guess, probe)?;
        let start = self.start(&points);
        let upper = self.setting.band.upper;
        let Some(seed) = points.get(start).copied() else {
            return Err(PositioningError::NoDirection { feed: [0.0; 2], uv: guess });
        };
        let (near, far) = if seed.error <= upper {
            let after = points.iter().skip(start + 1).copied().collect::<Vec<_>>();
            let before = points.iter().take(start).rev().copied().collect::<Vec<_>>();
            (self.side(&seed, &before, -1.0, probe)?, self.side(&seed, &after, 1.0, probe)?)
        } else {
            let none = || Side { end: seed, max: seed.error, min: seed.error, inside: Vec::new() };
            (none(), none())
        };
        let [low, high] = [near.end.psi, far.end.psi];
        let outside = points.iter().filter(|point| point.psi < low || point.psi > high);
        let rear_min = outside.map(|point| point.error).fold(f64::INFINITY, f64::min);
        let middle = self.circle.read_from(0.5 * (low + high), &seed, probe)?;
        let mut inside: Vec<Sample> = near.inside.iter().rev().copied().collect();
        inside.push(seed);
        inside.extend(&far.inside);
        let range = curvature_below(self.setting.face, &points);
        let curvature = range[1].max(-range[0]);
        let disc = self.disc(range, &seed, probe)?;
        let front_max_bound = self.bound(&inside, (1.0, curvature), probe)?;
        let rear_min_bound = -self.bound(&points, (-1.0, curvature), probe)?;
        let foot = |sample: &Sample| (sample.reading.foot.uv, sample.reading.foot.point);
        Ok(Strip {
            width: across(&self.v, &near.end.reading, &far.end.reading).max(0.0),
            near: foot(&near.end),
            far: foot(&far.end),
            front_max: near.max.max(far.max),
            front_max_bound,
            front_min: near.min.min(far.min),
            rear_min: rear_min.min(disc[0]),
            rear_min_bound: rear_min_bound.min(disc[1]),
            contact: foot(&middle),
            queries: probe.queries,
        })
    }

    /// Samples over `[-pi, pi]` with the local extrema between them, in order.
    fn sample(&self, guess: [f64; 2], probe: &mut Probe) -> Result<Vec<Sample>, PositioningError> {
        let half = SAMPLES / 2;
        let step = PI / f64::from(half);
        let seed = self.circle.read(0.0, guess, probe)?;
        let angles = |sign: f64| (1..=half).map(move |k| sign * step * f64::from(k));
        let mut points = self.circle.walk(angles(-1.0), &seed, probe)?;
        points.reverse();
        points.push(seed);
        points.extend(self.circle.walk(angles(1.0), &seed, probe)?);
        let extrema = self.circle.extrema(&points, probe)?;
        if self.half_arc > 0.0 {
            for psi in [-self.half_arc, self.half_arc] {
                points.push(self.circle.read_from(psi, &seed, probe)?);
            }
        }
        points.extend(extrema.iter().map(|e| Sample { error: e.value, ..e.sample }));
        points.sort_by(|a, b| a.psi.total_cmp(&b.psi));
        Ok(points)
    }

    /// The point within the band nearest to the angle 0, on the half of the circle around it; the
    /// lowest there if none is.
    fn start(&self, points: &[Sample]) -> usize {
        let upper = self.setting.band.upper;
        let front = points.iter().enumerate().filter(|(_, point)| point.psi.abs() <= 0.5 * PI);
        let within = front.clone().filter(|(_, point)| point.error <= upper);
        within
            .min_by(|(_, a), (_, b)| a.psi.abs().total_cmp(&b.psi.abs()))
            .or_else(|| front.min_by(|(_, a), (_, b)| a.error.total_cmp(&b.error)))
            .map_or(0, |(index, _)| index)
    }

    /// Follows the points from `seed` until the error leaves the band, at most to the opposite
    /// point of the circle; the end is where it reaches farthest across the feed.
    fn side(
        &self,
        seed: &Sample,
        points: &[Sample],
        sign: f64,
        probe: &mut Probe,
    ) -> Result<Side, PositioningError> {
        let mut seen = vec![*seed];
        for point in points {
            if point.error > self.setting.band.upper {
                let last = seen.last().copied().unwrap_or(*seed);
                seen.push(self.crossing(last, *point, probe)?);
                break;
            }
            seen.push(*point);
        }
        let reach = |s: &Sample| sign * across(&self.v, &seed.reading, &s.reading);
        let farthest =
            seen.iter().enumerate().max_by(|(_, a), (_, b)| reach(a).total_cmp(&reach(b)));
        let count = farthest.map_or(1, |(index, _)| index + 1);
        // On a strongly curved surface "farthest" depends on the plane it is seen in: what lies
        // between the end points counts in any case.
        let between = seen.iter().take_while(|sample| sample.psi.abs() <= self.half_arc).count();
        let count = count.max(between);
        seen.truncate(count);
        let errors = || seen.iter().map(|sample| sample.error);
        Ok(Side {
            end: seen.last().copied().unwrap_or(*seed),
            max: errors().fold(seed.error, f64::max),
            min: errors().fold(seed.error, f64::min),
            inside: seen.get(1..).unwrap_or_default().to_vec(),
        })
    }

    /// Where the error passes the upper end of the band between two samples.
    fn crossing(
        &self,
        mut inside: Sample,
        mut outside: Sample,
        probe: &mut Probe,
    ) -> Result<Sample, PositioningError> {
        // Newton's steps from the end nearer to the root, kept in the bracket: five or six reach
        // rounding; bisection takes over where a slope vanishes.
        const STEPS: u32 = 40;
        let Band { lower, upper } = self.setting.band;
        let off = |sample: &Sample| (sample.error - upper).abs();
        for _ in 0..STEPS {
            let nearer = if off(&inside) < off(&outside) { &inside } else { &outside };
            if off(nearer) <= 1e-9 * (upper - lower) {
                break;
            }
            let newton = nearer.psi + (upper - nearer.error) / nearer.slope;
            let [low, high] = [inside.psi.min(outside.psi), inside.psi.max(outside.psi)];
            let within = newton > low && newton < high;
            let psi = if within { newton } else { 0.5 * (low + high) };
            let sample = self.circle.read_from(psi, nearer, probe)?;
            if sample.error <= upper {
                inside = sample;
            } else {
                outside = sample;
            }
        }
        let end = if off(&inside) < off(&outside) { inside } else { outside };
        Ok(Sample { error: end.error.min(upper), ..end })
    }

    /// Least distance of the disc found, and what it is at least.
    fn disc(
        &self,
        curvatures: [f64; 2],
        seed: &Sample,
        probe: &mut Probe,
    ) -> Result<[f64; 2], PositioningError> {
        let Band { lower, upper } = self.setting.band;
        let disc = Disc {
            center: self.circle.ring.center - self.axis.scale(self.circle.minor),
            axis: self.axis,
            radius: self.circle.ring.radius,
        };
        let lowest = disc.lowest(&[&seed.reading], probe)?;
        let lowest = lowest.map_or(f64::INFINITY, |(_, reading)| reading.distance);
        let enough = lowest.min(lower) - SHARE * (upper - lower);
        let [least, bound] = disc.floor(enough, curvatures, &seed.reading, probe)?;
        Ok([lowest.min(least), lowest.min(bound)])
    }

    /// Bound of `sign * error` over the gaps between the points, refined where it is critical.
    fn bound(
        &self,
        points: &[Sample],
        (sign, curvature): (f64, f64),
        probe: &mut Probe,
    ) -> Result<f64, PositioningError> {
        let band = self.setting.band;
        let known = points.iter().map(|p| sign * p.error).fold(f64::NEG_INFINITY, f64::max);
        let target = known + SHARE * (band.upper - band.lower);
        let limits = Limits { curvature, target };
        let depth = if curvature.is_finite() { DEPTH } else { 0 };
        let mut worst = known;
        for pair in points.windows(2) {
            if let [a, b] = pair {
                worst = worst.max(self.gap_bound([a, b], sign, (&limits, depth), probe)?);
            }
        }
        Ok(worst)
    }

    fn gap_bound(
        &self,
        [a, b]: [&Sample; 2],
        sign: f64,
        (limits, depth): (&Limits, u32),
        probe: &mut Probe,
    ) -> Result<f64, PositioningError> {
        let bound = self.peak([a, b], sign, limits.curvature);
        if bound <= limits.target || depth == 0 {
            return Ok(bound);
        }
        let middle = self.circle.read_from(0.5 * (a.psi + b.psi), a, probe)?;
        let left = self.gap_bound([a, &middle], sign, (limits, depth - 1), probe)?;
        let right = self.gap_bound([&middle, b], sign, (limits, depth - 1), probe)?;
        Ok(left.max(right))
    }

    /// What `sign * error` cannot exceed between two samples: under both parabolas that start
    /// with value and slope of a sample and bend upward as much as `|E''|` allows.
    fn peak(&self, [a, b]: [&Sample; 2], sign: f64, curvature: f64) -> f64 {
        let h = b.psi - a.psi;
        let bend = self.bend_bound([a, b], h, curvature);
        let [ea, eb] = [sign * a.error, sign * b.error];
        let [sa, sb] = [sign * a.slope, sign * b.slope];
        let ends = ea.max(eb);
        let closing = sa - sb + bend * h;
        if closing <= 0.0 {
            return ends;
        }
        let s = ((eb - ea - sb * h + 0.5 * bend * h * h) / closing).clamp(0.0, h);
        let left = ea + s * (sa + 0.5 * bend * s);
        let t = h - s;
        let right = eb - t * (sb - 0.5 * bend * t);
        ends.max(left.min(right))
    }

    /// `|E''| <= R (sin beta + R k / (1 - k d))` over a gap of `h` \[rad\]; `beta`, the angle
    /// between tool axis and foot normal, grows by at most the normal's turn to the middle.
    fn bend_bound(&self, [a, b]: [&Sample; 2], h: f64, curvature: f64) -> f64 {
        let radius = self.circle.ring.radius;
        let highest = self.circle.minor + a.error.max(b.error).max(0.0) + 0.5 * radius * h;
        let left = 1.0 - curvature * highest;
        if left <= 0.0 {
            return f64::INFINITY;
        }
        let turning = radius * curvature / left;
        let sine = |s: &Sample| self.axis.cross(&s.reading.normal()).norm();
        radius * (sine(a).max(sine(b)) + 0.5 * h * turning + turning)
    }
}

/// What bounds between samples go by.
struct Limits {
    /// No curvature of the surface below the samples is larger, either sign \[1/mm\].
    curvature: f64,
    /// Bounds up to here need no refinement \[mm\].
    target: f64,
}

/// Bounds of the curvatures over the rectangle of the samples' feet, wider by the
/// longest step between two of them. Beyond the domain, where the surface goes on with the
/// border's second derivatives, the curvature at the feet stands for it.
fn curvature_below(face: &FaceIndex, points: &[Sample]) -> [f64; 2] {
    let at = |k: usize| points.iter().map(move |point| point.reading.foot.uv[k]);
    let cell = [0, 1].map(|k| {
        let steps = at(k).zip(at(k).skip(1)).map(|(a, b)| (a - b).abs());
        let margin = steps.fold(0.0, f64::max);
        let low = at(k).fold(f64::INFINITY, f64::min);
        let high = at(k).fold(f64::NEG_INFINITY, f64::max);
        [low - margin, high + margin]
    });
    let feet = points.iter().map(|point| point.reading.curvatures());
    feet.fold(face.curvature_range(cell), |[low, high], [least, most]| {
        [low.min(least), high.max(most)]
    })
}
