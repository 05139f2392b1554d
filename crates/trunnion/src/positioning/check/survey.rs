//! Dense sampling of the cutting circle.

use crate::positioning::distance::circle::{ErrorCircle, ErrorSample};
use crate::positioning::distance::disc::FlatDisc;
use crate::positioning::distance::gaps::SPACING;
use crate::positioning::distance::gaps::{CurvatureRange, GapBounds, GapRange, curvatures_under};
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::distance::width::width_across;
use crate::positioning::error::PositioningError;
use crate::positioning::request::ToleranceBand;
use crate::positioning::strip::{CuttingContext, MeasuredStrip};
use crate::positioning::surface_point::SurfacePoint;
use nalgebra::{UnitVector3, Vector3};
use std::f64::consts::PI;

/// Samples round the circle. 5 degrees apart on a cutter of 10 mm they are 0.9 mm apart.
const SAMPLES: u32 = 72;

/// Share of the band to which bounds between samples are refined.
const SHARE: f64 = 0.05;

/// Bands by which a location is so far too low that what hides between its samples changes nothing.
pub(crate) const DEEP: f64 = 10.0;

/// Bisections of one gap: each quarters the distance of bound and value.
const DEPTH: u32 = 6;

/// Refinement of the gaps between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GapRefinement {
    /// Until no extremum can hide in a gap, even where bounds take many points.
    Thorough,
    /// As far, but only where curvature has a bounded rate.
    WhereBounded,
}

/// A circle, sampled all round.
pub(crate) struct CircleSurvey<'a> {
    pub(crate) setting: &'a CuttingContext<'a>,
    pub(crate) circle: ErrorCircle,
    pub(crate) axis: UnitVector3<f64>,
    /// Across the feed, to the strip's side.
    pub(crate) v: Vector3<f64>,
    /// Half the arc between the end points it was made for \[rad\]; 0 where none are known.
    pub(crate) half_arc: f64,
    /// Samples read before, over `[-pi, pi]` in any order.
    pub(crate) seen: &'a [ErrorSample],
    /// Refinement of the gaps between samples.
    pub(crate) refinement: GapRefinement,
}

/// One side of the strip: its end, and the samples up to it.
struct StripSideEnd {
    end: ErrorSample,
    max: f64,
    min: f64,
    inside: Vec<ErrorSample>,
}

impl CircleSurvey<'_> {
    /// Measures the strip around the circle angle 0, whose foot is near `guess`.
    pub(crate) fn strip(
        &self,
        guess: [f64; 2],
        probe: &mut FaceProbe,
    ) -> Result<MeasuredStrip, PositioningError> {
        // Samples round the circle, refined until the gaps can hide nothing.
        let points = self.sample(guess, probe)?;
        let gaps = self.gaps(&points);
        let (points, lowest) = self.dense(points, &gaps, probe)?;
        let start = self.start(&points);
        // From the seed both ways to the ends of the strip.
        let upper = self.setting.band.upper;
        let Some(seed) = points.get(start).copied() else {
            return Err(PositioningError::NoDirection { feed: [0.0; 2], uv: guess.into() });
        };
        let (near, far) = if seed.error <= upper {
            let (before, after) = (points.iter().take(start).rev(), points.iter().skip(start + 1));
            (self.side(&seed, before, -1.0, probe)?, self.side(&seed, after, 1.0, probe)?)
        } else {
            let none =
                || StripSideEnd { end: seed, max: seed.error, min: seed.error, inside: Vec::new() };
            (none(), none())
        };
        // Everything outside the strip is the rear.
        let [low, high] = [near.end.psi, far.end.psi];
        let outside = points.iter().filter(|point| point.psi < low || point.psi > high);
        let rear_min = outside.map(ErrorSample::low).fold(f64::INFINITY, f64::min);
        let middle = self.circle.read_from(0.5 * (low + high), &seed, probe)?;
        let mut inside: Vec<ErrorSample> = near.inside.iter().rev().copied().collect();
        inside.push(seed);
        inside.extend(&far.inside);
        // The disc inside the circle, and bounds between the samples of the strip.
        let disc = self.disc(&seed, probe)?;
        let front_max = near.max.max(far.max);
        let highest = inside.windows(2).map(|pair| match pair {
            [a, b] => gaps.range_between(a, b).range[1],
            _ => f64::NEG_INFINITY,
        });
        let front_max_bound = highest.fold(front_max, f64::max);
        let foot = |sample: &ErrorSample| SurfacePoint::from(&sample.reading.foot);
        Ok(MeasuredStrip {
            width: width_across(&self.v, &near.end.reading, &far.end.reading).max(0.0),
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

    /// Returns samples over `[-pi, pi]`, both ends included, in order.
    fn sample(
        &self,
        guess: [f64; 2],
        probe: &mut FaceProbe,
    ) -> Result<Vec<ErrorSample>, PositioningError> {
        let mut points = Vec::with_capacity(self.seen.len() + 24);
        points.extend_from_slice(self.seen);
        let sort = |points: &mut Vec<ErrorSample>| points.sort_by(|a, b| a.psi.total_cmp(&b.psi));
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
            points.insert(0, ErrorSample { psi: -PI, ..rear });
        }
        self.filled(points, probe)
    }

    /// Adds evenly spaced samples where the points are far apart.
    fn filled(
        &self,
        points: Vec<ErrorSample>,
        probe: &mut FaceProbe,
    ) -> Result<Vec<ErrorSample>, PositioningError> {
        let wide = |pair: &[ErrorSample]| pair[1].psi - pair[0].psi > SPACING;
        if !points.windows(2).any(wide) {
            return Ok(points);
        }
        let mut filled: Vec<ErrorSample> = Vec::with_capacity(2 * points.len());
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

    /// Adds the local extrema between the points, and more samples where gaps could hide anything: an
    /// error below the band by a share of it, or, on the strip, above. Also returns a lower bound on
    /// the error.
    fn dense(
        &self,
        mut points: Vec<ErrorSample>,
        gaps: &GapBounds,
        probe: &mut FaceProbe,
    ) -> Result<(Vec<ErrorSample>, f64), PositioningError> {
        self.add_extrema(&mut points, probe)?;
        let least = points.iter().map(ErrorSample::low).fold(self.setting.band.lower, f64::min);
        let ToleranceBand { lower, upper } = self.setting.band;
        let deep = least < lower - DEEP * (upper - lower);
        let bounded = self.refinement == GapRefinement::Thorough || gaps.under.rate.is_finite();
        let thorough = bounded && !deep;
        let mut found = Vec::with_capacity(2 * points.len());
        let mut lowest = f64::INFINITY;
        let mut ahead: Vec<(ErrorSample, u32)> = Vec::with_capacity(DEPTH as usize + 1);
        for point in &points {
            let Some(mut last) = found.last().copied() else {
                found.push(*point);
                continue;
            };
            ahead.push((*point, 0));
            while let Some((next, depth)) = ahead.last().copied() {
                let known = gaps.range_between(&last, &next);
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

    /// Returns `true` if errors between two points could matter: below the least one found, or above the
    /// band on the strip, by a share of the band.
    fn hides(&self, [a, b]: [&ErrorSample; 2], known: &GapRange, least: f64) -> bool {
        let ToleranceBand { lower, upper } = self.setting.band;
        let ([low, high], slack) = (known.range, SHARE * (upper - lower));
        let strip = a.error <= upper && b.error <= upper;
        low < least - slack || (strip && high > upper + slack)
    }

    /// Returns `true` if an extremum that the slopes of the ends do not reveal may lie outside the band.
    fn may_gouge(&self, [a, b]: [&ErrorSample; 2], known: &GapRange) -> bool {
        let (ToleranceBand { lower, upper }, [low, high]) = (self.setting.band, known.range);
        let strip = a.error <= upper && b.error <= upper;
        !known.plain && (low < lower || (strip && high > upper))
    }

    /// Inserts the local extrema between the points.
    fn add_extrema(
        &self,
        points: &mut Vec<ErrorSample>,
        probe: &mut FaceProbe,
    ) -> Result<(), PositioningError> {
        let extrema = self.circle.extrema(points, probe)?;
        let known = |psi: f64| points.binary_search_by(|p| p.psi.total_cmp(&psi)).is_ok();
        let new = extrema.iter().map(|extremum| extremum.sample).filter(|s| !known(s.psi));
        let new: Vec<ErrorSample> = new.collect();
        if !new.is_empty() {
            points.extend(new);
            points.sort_by(|a, b| a.psi.total_cmp(&b.psi));
        }
        Ok(())
    }

    /// Returns the point within the band nearest to the angle 0, on the half of the circle around it; the
    /// lowest there if none is.
    fn start(&self, points: &[ErrorSample]) -> usize {
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
        seed: &ErrorSample,
        points: impl Iterator<Item = &'a ErrorSample>,
        sign: f64,
        probe: &mut FaceProbe,
    ) -> Result<StripSideEnd, PositioningError> {
        let mut seen = vec![*seed];
        for point in points {
            if point.error > self.setting.band.upper {
                let last = seen.last().copied().unwrap_or(*seed);
                seen.push(self.crossing(last, *point, probe)?);
                break;
            }
            seen.push(*point);
        }
        let reach = |s: &ErrorSample| sign * width_across(&self.v, &seed.reading, &s.reading);
        let farthest =
            seen.iter().enumerate().max_by(|(_, a), (_, b)| reach(a).total_cmp(&reach(b)));
        let count = farthest.map_or(1, |(index, _)| index + 1);
        // On a strongly curved surface "farthest" depends on the plane it is seen in: what lies
        // between the end points counts in any case.
        // Samples ascend from the seed, so those inside the arc come first.
        let between = seen.iter().take_while(|sample| sample.psi.abs() <= self.half_arc).count();
        let count = count.max(between);
        seen.truncate(count);
        Ok(StripSideEnd {
            end: seen.last().copied().unwrap_or(*seed),
            max: seen.iter().map(ErrorSample::high).fold(seed.error, f64::max),
            min: seen.iter().map(ErrorSample::low).fold(seed.error, f64::min),
            inside: seen.get(1..).unwrap_or_default().to_vec(),
        })
    }

    /// Finds the point between two samples at which the error passes the upper end of the band.
    fn crossing(
        &self,
        mut inside: ErrorSample,
        mut outside: ErrorSample,
        probe: &mut FaceProbe,
    ) -> Result<ErrorSample, PositioningError> {
        // Newton's steps from the end nearer to the root, kept in the bracket: five or six reach
        // rounding; bisection takes over where a slope vanishes.
        const STEPS: u32 = 40;
        let ToleranceBand { lower, upper } = self.setting.band;
        let off = |sample: &ErrorSample| (sample.error - upper).abs();
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
        Ok(ErrorSample { error: end.error.min(upper), ..end })
    }

    /// Returns the least distance of the disc found, and a lower bound on it.
    fn disc(
        &self,
        seed: &ErrorSample,
        probe: &mut FaceProbe,
    ) -> Result<[f64; 2], PositioningError> {
        let ToleranceBand { lower, upper } = self.setting.band;
        let disc = FlatDisc {
            center: self.circle.ring.center - self.axis.scale(self.circle.minor),
            axis: self.axis,
            radius: self.circle.ring.radius,
        };
        let centre = disc.middle(&seed.reading, probe)?;
        let lowest = disc.lowest(&centre, &[&seed.reading], probe)?;
        let lowest = lowest.map_or(f64::INFINITY, |(_, reading)| reading.distance);
        let enough = lowest.min(lower) - SHARE * (upper - lower);
        let [least, bound] = disc.floor(enough, self.setting.face, &centre, probe)?;
        Ok([lowest.min(least), lowest.min(bound)])
    }

    /// Returns the bounds of the error between the points.
    fn gaps(&self, points: &[ErrorSample]) -> GapBounds {
        GapBounds {
            radius: self.circle.ring.radius,
            minor: self.circle.minor,
            axis: self.axis,
            under: self.under(points),
        }
    }

    /// Bounds the curvatures below the circle.
    fn under(&self, points: &[ErrorSample]) -> CurvatureRange {
        let steps = points.windows(2).map(|pair| match pair {
            [a, b] => b.psi - a.psi,
            _ => 0.0,
        });
        // No point of the circle is farther than this from one that was read.
        let way = 0.5 * self.circle.ring.radius * steps.fold(0.0, f64::max);
        let highest = points.iter().map(|point| point.reading.distance).fold(0.0, f64::max);
        let readings = points.iter().map(|point| &point.reading);
        curvatures_under(self.setting.face, &readings, way, highest + way)
    }
}
