//! An independent, dense look at the strip a pose leaves.

use super::PositioningError;
use super::StripSide;
use super::ToleranceBand;
use super::circle::Circle;
use super::circle::Sample;
use super::disc::Disc;
use super::gaps::Gaps;
use super::gaps::Known;
use super::gaps::Under;
use super::gaps::curvatures_under;
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
pub struct CuttingContext<'a> {
    /// The surface.
    pub face: &'a FaceIndex,
    /// The cutter.
    pub cutter: &'a Cutter,
    /// Where the error has to lie.
    pub band: ToleranceBand,
}

/// Where on the cutter the strip is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripQuery {
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
pub struct MeasuredStrip {
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

/// Largest angle between points that bounds start from \[rad\].
pub(super) const SPACING: f64 = 0.7;

/// Share of the band to which bounds between samples are refined.
const SHARE: f64 = 0.05;

/// Bisections of one gap: each quarters the distance of bound and value.
const DEPTH: u32 = 6;

/// Looks at the strip a pose leaves, without any of the assumptions it was made with.
///
/// The signed error (distance from the surface minus the corner radius) is sampled round the whole
/// circle, extrema and ends of the strip are refined; between samples it is bounded through a range
/// of its second derivative, from curvatures bounded over all the surface that feet can reach.
/// The bounds hold for the foot that is followed round the circle; of the continuation beyond the
/// face's domain they know the curvature at the samples only.
///
/// A pose that gouges is not an error: `front_min` and `rear_min` say so.
///
/// # Errors
///
/// [`PositioningError::NoDirection`] for a feed along the normal, [`PositioningError::Closest`].
pub fn strip_of_pose(
    setting: &CuttingContext,
    pose: &ToolPose,
    look: &StripQuery,
) -> Result<MeasuredStrip, PositioningError> {
    let mut probe = Probe::new(setting.face);
    let minor = setting.cutter.minor();
    let middle = probe.read(&look.contact, look.uv)?;
    let (ring, v) = super::curve::ring(setting, pose, look, &middle)?;
    if ring.radius <= 0.0 {
        return super::ball::strip(setting, ring.center, (&v, &middle), probe);
    }
    let circle = Circle { ring, minor };
    let (axis, v) = (pose.axis, v.into_inner());
    let survey = Survey { setting, circle, axis, v, half_arc: 0.0, seen: &[], thorough: true };
    survey.strip(middle.foot.uv, &mut probe)
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
    pub(super) setting: &'a CuttingContext<'a>,
    pub(super) circle: Circle,
    pub(super) axis: UnitVector3<f64>,
    /// Across the feed, to the strip's side.
    pub(super) v: Vector3<f64>,
    /// Half the arc between the end points it was made for \[rad\]; 0 where none are known.
    pub(super) half_arc: f64,
    /// What was read of the circle before, over `[-pi, pi]` in any order.
    pub(super) seen: &'a [Sample],
    /// Whether gaps are looked into until no extremum can hide there, even where bounds take many points.
    pub(super) thorough: bool,
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
    ) -> Result<MeasuredStrip, PositioningError> {
        let points = self.sample(guess, probe)?;
        let gaps = self.gaps(&points);
        let (points, lowest) = self.dense(points, &gaps, probe)?;
        let start = self.start(&points);
        let upper = self.setting.band.upper;
        let Some(seed) = points.get(start).copied() else {
            return Err(PositioningError::NoDirection { feed: [0.0; 2], uv: guess });
        };
        let (near, far) = if seed.error <= upper {
            let (before, after) = (points.iter().take(start).rev(), points.iter().skip(start + 1));
            (self.side(&seed, before, -1.0, probe)?, self.side(&seed, after, 1.0, probe)?)
        } else {
            let none = || Side { end: seed, max: seed.error, min: seed.error, inside: Vec::new() };
            (none(), none())
        };
        let [low, high] = [near.end.psi, far.end.psi];
        let outside = points.iter().filter(|point| point.psi < low || point.psi > high);
        let rear_min = outside.map(Sample::low).fold(f64::INFINITY, f64::min);
        let middle = self.circle.read_from(0.5 * (low + high), &seed, probe)?;
        let mut inside: Vec<Sample> = near.inside.iter().rev().copied().collect();
        inside.push(seed);
        inside.extend(&far.inside);
        let disc = self.disc(&seed, probe)?;
        let front_max = near.max.max(far.max);
        let highest = inside.windows(2).map(|pair| match pair {
            [a, b] => gaps.known(a, b).range[1],
            _ => f64::NEG_INFINITY,
        });
        let front_max_bound = highest.fold(front_max, f64::max);
        let foot = |sample: &Sample| (sample.reading.foot.uv, sample.reading.foot.point);
        Ok(MeasuredStrip {
            width: across(&self.v, &near.end.reading, &far.end.reading).max(0.0),
            near: foot(&near.end),
            far: foot(&far.end),
            front_max,
            front_max_bound,
            front_min: near.min.min(far.min),
            rear_min: rear_min.min(disc[0]),
            rear_min_bound: lowest.min(disc[1]),
            contact: foot(&middle),
            queries: probe.queries,
        })
    }

    /// Samples over `[-pi, pi]`, both ends included, in order.
    fn sample(&self, guess: [f64; 2], probe: &mut Probe) -> Result<Vec<Sample>, PositioningError> {
        let mut points = Vec::with_capacity(self.seen.len() + 24);
        points.extend_from_slice(self.seen);
        let sort = |points: &mut Vec<Sample>| points.sort_by(|a, b| a.psi.total_cmp(&b.psi));
        if points.is_empty() {
            let half = SAMPLES / 2;
            let step = PI / f64::from(half);
            let seed = self.circle.read(0.0, guess, probe)?;
            let angles = |sign: f64| (1..half).map(move |k| sign * step * f64::from(k));
            points = self.circle.walk(angles(-1.0), &seed, probe)?;
            points.push(seed);
            points.extend(self.circle.walk(angles(1.0), &seed, probe)?);
            if self.half_arc > 0.0 {
                for psi in [-self.half_arc, self.half_arc] {
                    points.push(self.circle.read_from(psi, &seed, probe)?);
                }
            }
        }
        sort(&mut points);
        // The opposite point ends both sides.
        if let Some(last) = points.last().copied() {
            let rear = self.circle.read_from(PI, &last, probe)?;
            points.push(rear);
            points.insert(0, Sample { psi: -PI, ..rear });
        }
        self.filled(points, probe)
    }

    /// The points with more of them, evenly spaced, where they are far apart.
    fn filled(
        &self,
        points: Vec<Sample>,
        probe: &mut Probe,
    ) -> Result<Vec<Sample>, PositioningError> {
        let wide = |pair: &[Sample]| pair[1].psi - pair[0].psi > SPACING;
        if !points.windows(2).any(wide) {
            return Ok(points);
        }
        let mut filled: Vec<Sample> = Vec::with_capacity(2 * points.len());
        for next in points {
            if let Some(last) = filled.last().copied() {
                let gap = next.psi - last.psi;
                let pieces = (gap / SPACING).ceil();
                let mut piece = 1.0;
                while piece < pieces {
                    let from = filled.last().unwrap_or(&last);
                    let psi = last.psi + gap * (piece / pieces);
                    filled.push(self.circle.read_from(psi, from, probe)?);
                    piece += 1.0;
                }
            }
            filled.push(next);
        }
        Ok(filled)
    }

    /// The points with the local extrema between them, and more of them where their gaps could
    /// hide anything: an error below the band by a share of it, or, on the strip, above. Also what
    /// no error is below.
    fn dense(
        &self,
        mut points: Vec<Sample>,
        gaps: &Gaps,
        probe: &mut Probe,
    ) -> Result<(Vec<Sample>, f64), PositioningError> {
        self.add_extrema(&mut points, probe)?;
        let least = points.iter().map(Sample::low).fold(self.setting.band.lower, f64::min);
        let thorough = self.thorough || gaps.under.rate.is_finite();
        let mut found = Vec::with_capacity(2 * points.len());
        let mut lowest = f64::INFINITY;
        let mut ahead: Vec<(Sample, u32)> = Vec::with_capacity(DEPTH as usize + 1);
        for point in &points {
            let Some(mut last) = found.last().copied() else {
                found.push(*point);
                continue;
            };
            ahead.push((*point, 0));
            while let Some((next, depth)) = ahead.last().copied() {
                let known = gaps.known(&last, &next);
                let hides = self.hides([&last, &next], &known, least)
                    || (thorough && self.may_gouge([&last, &next], &known));
                if depth < DEPTH && hides {
                    let middle =
                        self.circle.read_from(0.5 * (last.psi + next.psi), &last, probe)?;
                    if let Some((_, depth)) = ahead.last_mut() {
                        *depth += 1;
                    }
                    ahead.push((middle, depth + 1));
                } else {
                    lowest = lowest.min(known.range[0]);
                    found.push(next);
                    last = next;
                    ahead.pop();
                }
            }
        }
        if found.len() > points.len() {
            self.add_extrema(&mut found, probe)?;
        }
        Ok((found, lowest))
    }

    /// Whether errors between two points could matter: below the least one found, or above the band on
    /// the strip, by a share of the band.
    fn hides(&self, [a, b]: [&Sample; 2], known: &Known, least: f64) -> bool {
        let ToleranceBand { lower, upper } = self.setting.band;
        let ([low, high], slack) = (known.range, SHARE * (upper - lower));
        let strip = a.error <= upper && b.error <= upper;
        low < least - slack || (strip && high > upper + slack)
    }

    /// Whether an extremum that the ends' slopes say nothing of may lie outside the band.
    fn may_gouge(&self, [a, b]: [&Sample; 2], known: &Known) -> bool {
        let (ToleranceBand { lower, upper }, [low, high]) = (self.setting.band, known.range);
        let strip = a.error <= upper && b.error <= upper;
        !known.plain && (low < lower || (strip && high > upper))
    }

    /// Inserts the local extrema between the points.
    fn add_extrema(
        &self,
        points: &mut Vec<Sample>,
        probe: &mut Probe,
    ) -> Result<(), PositioningError> {
        let extrema = self.circle.extrema(points, probe)?;
        let known = |psi: f64| points.binary_search_by(|p| p.psi.total_cmp(&psi)).is_ok();
        let new = extrema.iter().map(|extremum| extremum.sample).filter(|s| !known(s.psi));
        let new: Vec<Sample> = new.collect();
        if !new.is_empty() {
            points.extend(new);
            points.sort_by(|a, b| a.psi.total_cmp(&b.psi));
        }
        Ok(())
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
    fn side<'a>(
        &self,
        seed: &Sample,
        points: impl Iterator<Item = &'a Sample>,
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
        Ok(Side {
            end: seen.last().copied().unwrap_or(*seed),
            max: seen.iter().map(Sample::high).fold(seed.error, f64::max),
            min: seen.iter().map(Sample::low).fold(seed.error, f64::min),
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
        let ToleranceBand { lower, upper } = self.setting.band;
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
    fn disc(&self, seed: &Sample, probe: &mut Probe) -> Result<[f64; 2], PositioningError> {
        let ToleranceBand { lower, upper } = self.setting.band;
        let disc = Disc {
            center: self.circle.ring.center - self.axis.scale(self.circle.minor),
            axis: self.axis,
            radius: self.circle.ring.radius,
        };
        let centre = disc.middle(&seed.reading, probe)?;
        let lowest = disc.lowest(&centre, &[&seed.reading], probe)?;
        let lowest = lowest.map_or(f64::INFINITY, |(_, reading)| reading.distance);
        let enough = lowest.min(lower) - SHARE * (upper - lower);
        let [least, bound] = disc.floor((enough, self.setting.face), &centre, probe)?;
        Ok([lowest.min(least), lowest.min(bound)])
    }

    /// What bounds the error between the points.
    fn gaps(&self, points: &[Sample]) -> Gaps {
        Gaps {
            radius: self.circle.ring.radius,
            minor: self.circle.minor,
            axis: self.axis,
            under: self.under(points),
        }
    }

    /// Bounds of the curvatures below the circle.
    fn under(&self, points: &[Sample]) -> Under {
        let steps = points.windows(2).map(|pair| match pair {
            [a, b] => b.psi - a.psi,
            _ => 0.0,
        });
        // No point of the circle is farther than this from one that was read.
        let way = 0.5 * self.circle.ring.radius * steps.fold(0.0, f64::max);
        let highest = points.iter().map(|point| point.reading.distance).fold(0.0, f64::max);
        let readings = points.iter().map(|point| &point.reading);
        curvatures_under(self.setting.face, &readings, (way, highest + way))
    }
}
