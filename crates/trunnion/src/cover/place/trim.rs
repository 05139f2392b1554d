//! From the stations of a candidate pass to the segments that are cut: trimmed, run out, and fine
//! enough.

use crate::cover::layout::region::{ChartPoint, TrimmedRegion};
use crate::cover::options::lever;
use crate::cover::pattern::PlacementMethod;
use crate::cover::place::candidate::{CandidatePass, LocationResult, PlacedStation};
use crate::cover::place::run_out::run_out;
use crate::cover::prove::clearance::ClearanceProof;
use crate::cover::prove::span_strip::SpanCheck;
use crate::cover::prove::sweep::PassSweep;
use crate::cover::prove::time_slab::SpanTimes;
use crate::math::angle::angle_between;
use crate::positioning::{PositioningError, ToleranceBand};
use crate::types::{Station, Uv};
use rayon::prelude::*;

/// Largest number of times that a segment is cut and laid anew.
const CUTS: u32 = 4;

/// Stations at the end of a row from which a run-out is tried.
const BASES: usize = 4;

/// Stations of one uninterrupted pass, and the results for the curve between them.
#[derive(Debug, Clone)]
pub(crate) struct PassSegment {
    pub(crate) placed: Vec<PlacedStation>,
    /// One per span.
    pub(crate) checks: Vec<SpanResult>,
    /// `true` if it could not be run out in full at its start, at its end.
    pub(crate) shortened: [bool; 2],
}

/// Result for a span of the curve that will be laid through the stations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpanResult {
    /// Depth of the error below the widened band \[mm\]; 0 or less is good.
    pub(crate) gouge: f64,
    /// `true` if the gap to the pass before, the width and the gouge are within the band.
    pub(crate) good: bool,
}

/// Station of a candidate pass, or the reason why there is none.
struct TrackSample {
    arc: f64,
    place: LocationResult,
    /// `true` if the strip has something to cut.
    touched: bool,
}

impl TrackSample {
    fn refused(&self) -> Option<RefusedStation> {
        let error = self.place.as_ref().err()?.clone();
        Some(RefusedStation { arc: self.arc, error })
    }
}

/// Point where no cutter location was found, with the reason.
#[derive(Debug, Clone)]
pub(crate) struct RefusedStation {
    /// Arc length along the track \[mm\].
    pub(crate) arc: f64,
    pub(crate) error: PositioningError,
}

/// Extent to which the curve between stations is proven to keep off the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SpanProof {
    /// All of it.
    Throughout,
    /// Halfway between stations, which takes a fraction of the time: good enough to compare plans of which the best is
    /// planned once more.
    Middle,
}

/// Candidate pass with the region that it has to cover.
pub(crate) struct PassTrimmer<'a, Inside> {
    pub(crate) candidate: &'a CandidatePass<'a>,
    pub(crate) region: &'a TrimmedRegion<Inside>,
    /// Proof that the curve keeps off the face between stations.
    pub(crate) clearance: ClearanceProof<'a>,
    pub(crate) proof: SpanProof,
}

impl<Inside: Fn(ChartPoint) -> bool + Sync> PassTrimmer<'_, Inside> {
    /// Returns the segments of the pass in order of the track, and a point in the region without a
    /// cutter location.
    ///
    /// A segment ends where there is no location, where the curve would go too deep however fine
    /// its stations are, and where the tool would turn too fast: there the tool is lifted.
    pub(crate) fn segments(&self) -> (Vec<PassSegment>, Option<RefusedStation>) {
        let extension = self.candidate.extension();
        let arcs = self.arcs(extension);
        let places = self.candidate.held_stations(&arcs, &|placed| self.reach(placed));
        let samples = self.samples(&arcs, places.clone());
        let mut segments = Vec::new();
        if self.candidate.method == PlacementMethod::Widest {
            self.laid(&samples, extension, &mut segments);
        } else {
            let wanted: Vec<bool> = samples.iter().map(|sample| sample.touched).collect();
            for places in self.candidate.inclined_stations(&arcs, places, &wanted) {
                self.laid(&self.samples(&arcs, places), extension, &mut segments);
            }
        }
        // A refusal counts only where the strip has something to cut.
        let refused = samples.iter().filter(|sample| sample.touched).find_map(TrackSample::refused);
        (segments, refused)
    }

    /// Makes segments of all stations with locations that have something to cut.
    fn laid(&self, samples: &[TrackSample], extension: f64, segments: &mut Vec<PassSegment>) {
        // Ranges that are cut, with their run-outs; within each, runs without a gap.
        for [first, last] in kept(samples, extension) {
            let samples = &samples[first..=last];
            for run in runs(samples) {
                if samples[run[0]..=run[1]].iter().any(|sample| sample.touched) {
                    self.run(samples, run, segments);
                }
            }
        }
    }

    /// Makes segments of a run of stations with locations; at the ends of `samples` it is run out.
    fn run(&self, samples: &[TrackSample], run: [usize; 2], segments: &mut Vec<PassSegment>) {
        let [first, last] = self.without_surplus(samples, run);
        let mut placed: Vec<PlacedStation> =
            samples[first..=last].iter().filter_map(|sample| sample.place.clone().ok()).collect();
        let mut shortened = [false; 2];
        let end = samples.len() - 1;
        // Extend the end only if nothing was dropped there. Only the outermost run is run out as far as the
        // samples reach.
        if last == run[1] && last < end {
            let target =
                runs(samples).iter().all(|other| other[1] <= last).then(|| samples[end].arc);
            shortened[1] = self.finish_end(&mut placed, samples[last + 1].arc, target);
        }
        if first == run[0] && first > 0 {
            placed.reverse();
            let target =
                runs(samples).iter().all(|other| other[0] >= first).then(|| samples[0].arc);
            shortened[0] = self.finish_end(&mut placed, samples[first - 1].arc, target);
            placed.reverse();
        }
        self.keep(placed, shortened, CUTS, segments);
    }

    /// Drops the stations at the ends of a run beyond the first whose strip is off the region.
    fn without_surplus(&self, samples: &[TrackSample], [first, last]: [usize; 2]) -> [usize; 2] {
        let [low, high] = self.region.bounds[1];
        let chart = self.candidate.chart;
        let off = |index: usize, out: &dyn Fn(f64) -> bool| {
            samples[index].place.as_ref().is_ok_and(|placed| {
                let location = &placed.location;
                let strip = [location.near, location.far, placed.contact_uv];
                strip.iter().all(|uv| out(chart.local((*uv).into())[1]))
            })
        };
        let (mut first, mut last) = (first, last);
        while last > first + 2 && off(last - 1, &|along| along > high) {
            last -= 1;
        }
        while first + 2 < last && off(first + 1, &|along| along < low) {
            first += 1;
        }
        [first, last]
    }

    /// Makes segments from the stations between bad spans. These spans are removed, and the
    /// stations on both sides are refined again.
    fn keep(
        &self,
        placed: Vec<PlacedStation>,
        shortened: [bool; 2],
        cuts: u32,
        segments: &mut Vec<PassSegment>,
    ) {
        if placed.len() < 2 {
            return;
        }
        let (placed, checks) = self.refine(placed);
        let bad: Vec<usize> = (0..checks.len())
            .filter(|&i| checks[i].gouge > 0.0 || self.too_fast(&placed[i], &placed[i + 1]))
            .collect();
        if bad.is_empty() {
            segments.push(PassSegment { placed, checks, shortened });
            return;
        }
        if cuts == 0 {
            return;
        }
        // Each bad span separates the stations before it from those after it.
        let mut start = 0;
        for &span in bad.iter().chain(&[placed.len() - 1]) {
            if span > start {
                self.keep(placed[start..=span].to_vec(), shortened, cuts - 1, segments);
            }
            start = span + 1;
        }
    }

    /// Returns segments with a further station in every span over the ranges along; `None` where
    /// all spans there are as short as they may be.
    pub(crate) fn denser(
        &self,
        segments: &[PassSegment],
        ranges: &[[f64; 2]],
    ) -> Option<Vec<PassSegment>> {
        let mut changed = false;
        let mut denser = Vec::new();
        for segment in segments {
            let served = |[a, b]: [&PlacedStation; 2]| {
                let (low, high) = (a.along.min(b.along), a.along.max(b.along));
                ranges.iter().any(|range| low <= range[1] && high >= range[0])
            };
            let wanted = |i: usize| served([&segment.placed[i], &segment.placed[i + 1]]);
            let spans = (0..segment.checks.len()).filter(|&i| wanted(i)).collect();
            match self.split(&segment.placed, spans) {
                Some(placed) => {
                    changed = true;
                    self.keep(placed, segment.shortened, CUTS, &mut denser);
                }
                None => denser.push(segment.clone()),
            }
        }
        changed.then_some(denser)
    }

    fn too_fast(&self, a: &PlacedStation, b: &PlacedStation) -> bool {
        let turn = angle_between(&a.station.pose.axis, &b.station.pose.axis);
        turn > self.candidate.turn(a.arc, b.arc)
    }

    /// Returns the parameter across to which a location finishes the region on its own line.
    fn reach(&self, placed: &PlacedStation) -> f64 {
        let [across, along] = placed.far(self.candidate.chart);
        self.region.first_from(across, [along, along]).unwrap_or(f64::INFINITY)
    }

    /// Returns evenly spaced points along the track.
    fn arcs(&self, extension: f64) -> Vec<f64> {
        let ([start, end], [first, last]) =
            (self.candidate.track.range(), self.candidate.track.face());
        let (start, end) = (start.max(first - extension), end.min(last + extension));
        let wanted = ((end - start) / self.candidate.options.spacing.high).ceil().max(3.0);
        // A track cannot need more stations than fit into memory by spacing; `as` saturates.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "is positive")]
        let count = wanted as u32;
        (0..=count).map(|i| start + (end - start) * f64::from(i) / f64::from(count)).collect()
    }

    /// Tests for each station if its strip meets the region between its neighbours.
    fn samples(&self, arcs: &[f64], places: Vec<LocationResult>) -> Vec<TrackSample> {
        let (candidate, chart) = (self.candidate, self.candidate.chart);
        let along = |index: usize| candidate.track.at(arcs[index]);
        let sample = |(i, place): (usize, LocationResult)| {
            // The strip serves the slab between its neighbours, widened to its own far end.
            let mut slab = [along(i.saturating_sub(1)), along((i + 1).min(arcs.len() - 1))];
            let mut across = [candidate.across, candidate.across];
            if let Ok(placed) = &place {
                let far = placed.far(chart);
                across[1] = across[1].max(far[0]);
                slab = [slab[0].min(far[1]), slab[1].max(far[1])];
            }
            TrackSample { arc: arcs[i], place, touched: self.region.touches(across, slab) }
        };
        places.into_iter().enumerate().map(sample).collect()
    }

    /// Extends a run past its last location: first as close to `bad`, which has none, as locations
    /// are found, then by a run-out to `target`. Returns `true` if it ends short of the target.
    fn finish_end(&self, placed: &mut Vec<PlacedStation>, bad: f64, target: Option<f64>) -> bool {
        let Some(last) = placed.last() else { return true };
        let end = self.towards(last, bad);
        if (end.arc - last.arc).abs() > 0.0 {
            placed.push(end);
        }
        target.is_some_and(|target| {
            let reached = self.run_out(placed, target);
            (target - reached).abs() > self.candidate.options.spacing.low
        })
    }

    /// Finds the location nearest to `bad`, where there is none, to within the least spacing.
    fn towards(&self, good: &PlacedStation, bad: f64) -> PlacedStation {
        let (mut good, mut bad) = (good.clone(), bad);
        // Bisect between a point with a location and one without.
        while (bad - good.arc).abs() > self.candidate.options.spacing.low {
            let middle = 0.5 * (good.arc + bad);
            match self.candidate.beside(middle, &good) {
                Ok(placed) => good = placed,
                Err(_) => bad = middle,
            }
        }
        good
    }

    /// Extends a run to `target` from its last location, or from an earlier one if that gets
    /// closer: the last one is at the limit of what is possible. Returns the arc length reached.
    fn run_out(&self, placed: &mut Vec<PlacedStation>, target: f64) -> f64 {
        let between = self.checker();
        let to_go = |arc: f64| (target - arc).abs();
        let mut best: Option<(usize, Vec<PlacedStation>)> = None;
        let mut nearest = f64::INFINITY;
        for (index, base) in placed.iter().enumerate().rev().take(BASES) {
            let added = run_out(self.candidate, &between, base, target);
            let left = to_go(added.last().map_or(base.arc, |p| p.arc));
            if left < nearest {
                nearest = left;
                best = Some((index, added));
            }
            if left <= self.candidate.options.spacing.low {
                break;
            }
        }
        if let Some((index, added)) = best {
            placed.truncate(index + 1);
            placed.extend(added);
        }
        placed.last().map_or(f64::NEG_INFINITY, |p| p.arc)
    }

    /// Returns the check with the band that the curve between stations has to keep.
    fn checker(&self) -> SpanCheck<'_> {
        let candidate = self.candidate;
        let share = candidate.options.path_share;
        let ToleranceBand { lower, upper } = candidate.options.band;
        let band = ToleranceBand { lower: lower - share, upper: upper + share };
        SpanCheck { face: candidate.face, cutter: candidate.cutter, chart: candidate.chart, band }
    }

    /// Returns the curve through stations.
    fn sweep(&self, placed: &[PlacedStation]) -> PassSweep {
        let stations: Vec<Station> = placed.iter().map(|p| p.station).collect();
        PassSweep::through(&stations, lever(self.candidate.cutter))
    }

    /// Halves spans until the curve through the stations keeps the widened band on each, or the
    /// spacing is the least allowed. Gouges, which cost more to find, are searched once nothing
    /// else needs stations.
    fn refine(&self, mut placed: Vec<PlacedStation>) -> (Vec<PlacedStation>, Vec<SpanResult>) {
        loop {
            let sweep = self.sweep(&placed);
            let pairs: Vec<&[PlacedStation]> = placed.windows(2).collect();
            let covers: Vec<bool> = pairs
                .into_par_iter()
                .enumerate()
                .map(|(span, pair)| self.covers(&sweep, [&pair[0], &pair[1]], span))
                .collect();
            let open = (0..covers.len()).filter(|&i| !covers[i]).collect();
            if let Some(finer) = self.split(&placed, open) {
                placed = finer;
                continue;
            }
            self.candidate.work.spans(covers.len());
            let gouges: Vec<f64> =
                (0..covers.len()).into_par_iter().map(|span| self.gouge(&sweep, span)).collect();
            let deep = (0..gouges.len()).filter(|&i| gouges[i] > 0.0).collect();
            if let Some(finer) = self.split(&placed, deep) {
                placed = finer;
                continue;
            }
            let check =
                |(gouge, covers): (f64, bool)| SpanResult { gouge, good: covers && gouge <= 0.0 };
            return (placed, gouges.into_iter().zip(covers).map(check).collect());
        }
    }

    /// Returns `true` if a span is long enough for a further station.
    fn divisible(&self, span: &[PlacedStation]) -> bool {
        let length = span.last().map_or(0.0, |b| b.arc) - span.first().map_or(0.0, |a| a.arc);
        length >= 2.0 * self.candidate.options.spacing.low
    }

    /// Puts a station into each of the given spans that is long enough; `None` where none is.
    fn split(&self, placed: &[PlacedStation], mut spans: Vec<usize>) -> Option<Vec<PlacedStation>> {
        spans.retain(|&i| self.divisible(&placed[i..=i + 1]));
        let reach = |placed: &PlacedStation| self.reach(placed);
        let between: Vec<LocationResult> = spans
            .par_iter()
            .map(|&i| self.candidate.between(&placed[i], &placed[i + 1], &reach))
            .collect();
        let new: Vec<(usize, PlacedStation)> = spans
            .into_iter()
            .zip(between)
            .filter_map(|(i, place)| place.ok().map(|placed| (i + 1, placed)))
            .collect();
        if new.is_empty() {
            return None;
        }
        let mut finer = placed.to_vec();
        // From the last one back, so that the other indices stay valid.
        for (index, station) in new.into_iter().rev() {
            finer.insert(index, station);
        }
        Some(finer)
    }

    /// Returns the depth of the curve below the widened band on a span \[mm\]; 0 or less if it
    /// keeps the band.
    fn gouge(&self, sweep: &PassSweep, span: usize) -> f64 {
        let times = match self.proof {
            SpanProof::Throughout => SpanTimes::all(sweep, span, self.candidate.cutter.radius()),
            SpanProof::Middle => SpanTimes::Middle,
        };
        // The gouge is the depth of the least clearance, from this face and the others, below the target. The
        // precision of the proof is allowed for.
        let (keep_off, target) = (&self.candidate.keep_off, self.clearance.target);
        let others = keep_off.clearance(sweep, span, times, target);
        let own = keep_off.own_clearance(&self.clearance, sweep, span, times);
        target - self.clearance.precision - own.min(others)
    }

    /// Returns `true` if the pose between two stations cuts, to the widened band, the points
    /// halfway between those that the stations cut: on the track, where the pass before ended, at
    /// the contact, and at the end of the strip.
    fn covers(&self, sweep: &PassSweep, [a, b]: [&PlacedStation; 2], span: usize) -> bool {
        let [low, high] = self.region.bounds[1];
        // Beyond the border there is nothing to cover.
        if a.along > high || b.along < low {
            return true;
        }
        let (candidate, chart) = (self.candidate, self.candidate.chart);
        let upper = candidate.options.band.upper + candidate.options.path_share;
        let curve = &sweep.curve;
        let middle = 0.5 * (curve.knots[span] + curve.knots[span + 1]);
        let Some(pose) = sweep.instant(span, middle).map(|here| here.pose) else {
            return false;
        };
        let cut = |[u, v]: [f64; 2]| {
            self.clearance.tool.end.distance(&candidate.face.face().point(u, v), &pose) <= upper
        };
        let halfway = |p: Uv, q: Uv| [0.5 * (p.u + q.u), 0.5 * (p.v + q.v)];
        // Three points across the strip; the proof of coverage later leaves none out.
        cut(chart.uv([candidate.across, candidate.track.at(0.5 * (a.arc + b.arc))]))
            && cut(halfway(a.contact_uv, b.contact_uv))
            && cut(halfway(a.location.far, b.location.far))
    }
}

/// Returns the ranges of neighbouring stations that have locations, two at least.
fn runs(samples: &[TrackSample]) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for index in (0..samples.len()).filter(|&index| samples[index].place.is_ok()) {
        match runs.last_mut() {
            Some(run) if run[1] + 1 == index => run[1] = index,
            _ => runs.push([index, index]),
        }
    }
    runs.retain(|run| run[1] > run[0]);
    runs
}

/// Returns the ranges of stations whose strips have something to cut, run out by `distance` \[mm\]
/// at both ends.
fn kept(samples: &[TrackSample], distance: f64) -> Vec<[usize; 2]> {
    let mut kept: Vec<[usize; 2]> = Vec::new();
    for sample in samples.iter().filter(|sample| sample.touched) {
        // Include one sample at or beyond the distance on either side.
        let before = samples.partition_point(|other| other.arc <= sample.arc - distance);
        let last = samples.partition_point(|other| other.arc < sample.arc + distance);
        let [first, last] = [before.saturating_sub(1), last.min(samples.len() - 1)];
        match kept.last_mut() {
            Some(range) if range[1] + 1 >= first => range[1] = last,
            _ => kept.push([first, last]),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::Interval;

    #[test]
    fn touched_places_are_run_out_and_joined() {
        let samples = |touched: &[usize]| -> Vec<TrackSample> {
            let range = Interval::point(0.0);
            let place = Err(PositioningError::OffsetRange { range });
            let sample = |i: usize| {
                let touched = touched.contains(&i);
                TrackSample { arc: i as f64, place: place.clone(), touched }
            };
            (0..=20).map(sample).collect()
        };
        assert_eq!(kept(&samples(&[5, 14]), 2.0), [[3, 7], [12, 16]]);
        assert_eq!(kept(&samples(&[5, 14]), 2.5), [[2, 8], [11, 17]]);
        assert_eq!(kept(&samples(&[5, 14]), 4.0), [[1, 18]]);
        assert_eq!(kept(&samples(&[0, 5, 14]), 4.0), [[0, 18]]);
    }
}
