//! From the places of a lane to the stretches that are cut: trimmed, run out, and fine enough.

use super::between::Between;
use super::clear::Clearing;
use super::lane::{Lane, Place, Placed};
use super::leans::Leant;
use super::options::Method;
use super::region::{Local, Region};
use super::runout::run_out;
use super::sweep::Sweep;
use crate::math::angle::angle_between;
use crate::positioning::{PositioningError, ToleranceBand};
use rayon::prelude::*;

/// First length of the stretches in which a span is looked at, as a share of the cutter's radius.
const SLAB: f64 = 1.0 / 8.0;

/// How often a stretch is cut and laid anew.
const CUTS: u32 = 4;

/// Locations at the end of a row from which a run-out is tried.
const BASES: usize = 4;

/// Stations of one uninterrupted pass, and what the curve between them leaves.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    pub(super) placed: Vec<Placed>,
    /// One per span.
    pub(super) checks: Vec<Check>,
    /// Whether it could not be run out in full at its start, at its end.
    pub(super) shortened: [bool; 2],
}

/// The middle of a span on the curve that will be laid through the stations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Check {
    /// How far the error is below the widened band \[mm\]; 0 or less is good.
    pub(super) gouge: f64,
    /// Whether gap to the pass before, width and gouge are as they should be.
    pub(super) good: bool,
}

/// A place of a lane.
struct Spot {
    way: f64,
    place: Place,
    /// Whether there is something to cut.
    touched: bool,
}

impl Spot {
    fn refused(&self) -> Option<Refused> {
        self.place.as_ref().err().map(|error| (self.way, error.clone()))
    }
}

/// Place where no cutter location was found, and why.
pub(super) type Refused = (f64, PositioningError);

/// A lane with the region it has to cover.
pub(super) struct Trimmer<'a, Inside> {
    pub(super) lane: &'a Lane<'a>,
    pub(super) region: &'a Region<Inside>,
    /// What the curve has to keep from the face between stations.
    pub(super) clearing: Clearing<'a>,
}

impl<Inside: Fn(Local) -> bool + Sync> Trimmer<'_, Inside> {
    /// The lane's stretches in order of the track, and a place in the region without a cutter location.
    ///
    /// A stretch ends where there is no location, where the curve would go too deep however fine its
    /// stations are, and where the tool would turn too fast: there the tool is lifted.
    pub(super) fn stretches(&self) -> (Vec<Stretch>, Option<Refused>) {
        let extension = self.lane.extension();
        let ways = self.ways(extension);
        let places = self.lane.settle(&ways, &|placed| self.reach(placed));
        let spots = self.spots(&ways, places.clone());
        let mut stretches = Vec::new();
        if self.lane.method == Method::Widest {
            self.laid(&spots, extension, &mut stretches);
        } else {
            let wanted: Vec<bool> = spots.iter().map(|spot| spot.touched).collect();
            for Leant { places } in self.lane.leant(&ways, places, &wanted) {
                self.laid(&self.spots(&ways, places), extension, &mut stretches);
            }
        }
        let refused = spots.iter().filter(|spot| spot.touched).find_map(Spot::refused);
        (stretches, refused)
    }

    /// Makes stretches of all places with locations that have something to cut.
    fn laid(&self, spots: &[Spot], extension: f64, stretches: &mut Vec<Stretch>) {
        for [first, last] in kept(spots, extension) {
            let spots = &spots[first..=last];
            for run in runs(spots) {
                if spots[run[0]..=run[1]].iter().any(|spot| spot.touched) {
                    self.run(spots, run, stretches);
                }
            }
        }
    }

    /// Makes stretches of a run of places with locations; at the ends of `spots` it is run out.
    fn run(&self, spots: &[Spot], run: [usize; 2], stretches: &mut Vec<Stretch>) {
        let [first, last] = self.without_surplus(spots, run);
        let mut placed: Vec<Placed> =
            spots[first..=last].iter().filter_map(|spot| spot.place.clone().ok()).collect();
        let mut shortened = [false; 2];
        let end = spots.len() - 1;
        if last == run[1] && last < end {
            let target = runs(spots).iter().all(|other| other[1] <= last).then(|| spots[end].way);
            shortened[1] = self.finish_end(&mut placed, spots[last + 1].way, target);
        }
        if first == run[0] && first > 0 {
            placed.reverse();
            let target = runs(spots).iter().all(|other| other[0] >= first).then(|| spots[0].way);
            shortened[0] = self.finish_end(&mut placed, spots[first - 1].way, target);
            placed.reverse();
        }
        self.keep(placed, shortened, CUTS, stretches);
    }

    /// A run without those places at its ends that lie farther out than one whose strip is off the region
    /// already.
    fn without_surplus(&self, spots: &[Spot], [first, last]: [usize; 2]) -> [usize; 2] {
        let [low, high] = self.region.bounds[1];
        let chart = self.lane.chart;
        let off = |index: usize, out: &dyn Fn(f64) -> bool| {
            spots[index].place.as_ref().is_ok_and(|placed| {
                let location = &placed.location;
                let strip = [location.near, location.far, placed.contact_uv];
                strip.iter().all(|uv| out(chart.local(*uv)[1]))
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

    /// Stretches of the stations between bad spans: these are cut out, and what remains is laid anew.
    fn keep(
        &self,
        placed: Vec<Placed>,
        shortened: [bool; 2],
        cuts: u32,
        stretches: &mut Vec<Stretch>,
    ) {
        if placed.len() < 2 {
            return;
        }
        let (placed, checks) = self.refine(placed);
        let bad: Vec<usize> = (0..checks.len())
            .filter(|&i| checks[i].gouge > 0.0 || self.too_fast(&placed[i], &placed[i + 1]))
            .collect();
        if bad.is_empty() {
            stretches.push(Stretch { placed, checks, shortened });
            return;
        }
        if cuts == 0 {
            return;
        }
        let mut start = 0;
        for &span in bad.iter().chain(&[placed.len() - 1]) {
            if span > start {
                self.keep(placed[start..=span].to_vec(), shortened, cuts - 1, stretches);
            }
            start = span + 1;
        }
    }

    /// Stretches with a further station in every span over the ranges along; `None` where all spans
    /// there are as short as they may be.
    pub(super) fn denser(
        &self,
        stretches: &[Stretch],
        ranges: &[[f64; 2]],
    ) -> Option<Vec<Stretch>> {
        let mut changed = false;
        let mut denser = Vec::new();
        for stretch in stretches {
            let served = |[a, b]: [&Placed; 2]| {
                let (low, high) = (a.along.min(b.along), a.along.max(b.along));
                ranges.iter().any(|range| low <= range[1] && high >= range[0])
            };
            let wanted = |i: usize| served([&stretch.placed[i], &stretch.placed[i + 1]]);
            let spans = (0..stretch.checks.len()).filter(|&i| wanted(i)).collect();
            match self.split(&stretch.placed, spans) {
                Some(placed) => {
                    changed = true;
                    self.keep(placed, stretch.shortened, CUTS, &mut denser);
                }
                None => denser.push(stretch.clone()),
            }
        }
        changed.then_some(denser)
    }

    fn too_fast(&self, a: &Placed, b: &Placed) -> bool {
        let turn = angle_between(&a.station.pose.axis, &b.station.pose.axis);
        turn > self.lane.turn(a.way, b.way)
    }

    /// How far across a location finishes the region on its own line.
    fn reach(&self, placed: &Placed) -> f64 {
        let [across, along] = placed.far(self.lane.chart);
        self.region.first_from(across, [along, along]).unwrap_or(f64::INFINITY)
    }

    /// Evenly spaced places along the track.
    fn ways(&self, extension: f64) -> Vec<f64> {
        let ([start, end], [first, last]) = (self.lane.track.range(), self.lane.track.face());
        let (start, end) = (start.max(first - extension), end.min(last + extension));
        let wanted = ((end - start) / self.lane.options.spacing[1]).ceil().max(3.0);
        // A track cannot need more stations than fit into memory by spacing; `as` saturates.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "is positive")]
        let count = wanted as u32;
        (0..=count).map(|i| start + (end - start) * f64::from(i) / f64::from(count)).collect()
    }

    /// Notes for each place whether its strip meets the region between its neighbours.
    fn spots(&self, ways: &[f64], places: Vec<Place>) -> Vec<Spot> {
        let (lane, chart) = (self.lane, self.lane.chart);
        let along = |index: usize| lane.track.at(ways[index]);
        let spot = |(i, place): (usize, Place)| {
            let mut slab = [along(i.saturating_sub(1)), along((i + 1).min(ways.len() - 1))];
            let mut across = [lane.across, lane.across];
            if let Ok(placed) = &place {
                let far = placed.far(chart);
                across[1] = across[1].max(far[0]);
                slab = [slab[0].min(far[1]), slab[1].max(far[1])];
            }
            Spot { way: ways[i], place, touched: self.region.touches(across, slab) }
        };
        places.into_iter().enumerate().map(spot).collect()
    }

    /// Carries a row on past its last location: as near as locations are found to `bad`, where there
    /// is none, then by a run-out to `target`. Whether it ends short of it.
    fn finish_end(&self, placed: &mut Vec<Placed>, bad: f64, target: Option<f64>) -> bool {
        let Some(last) = placed.last() else { return true };
        let end = self.towards(last, bad);
        if (end.way - last.way).abs() > 0.0 {
            placed.push(end);
        }
        target.is_some_and(|target| {
            let reached = self.run_out(placed, target);
            (target - reached).abs() > self.lane.options.spacing[0]
        })
    }

    /// The location nearest to `bad`, where there is none, to within the least spacing.
    fn towards(&self, good: &Placed, bad: f64) -> Placed {
        let (mut good, mut bad) = (good.clone(), bad);
        while (bad - good.way).abs() > self.lane.options.spacing[0] {
            let middle = 0.5 * (good.way + bad);
            match self.lane.beside(middle, &good) {
                Ok(placed) => good = placed,
                Err(_) => bad = middle,
            }
        }
        good
    }

    /// Carries a row on to `target` from its last location, or from one before it where the last, at
    /// the edge of what is possible, cannot be carried on as far. How far it came.
    fn run_out(&self, placed: &mut Vec<Placed>, target: f64) -> f64 {
        let between = self.checker();
        let to_go = |way: f64| (target - way).abs();
        let mut best: Option<(usize, Vec<Placed>)> = None;
        let mut nearest = f64::INFINITY;
        for (index, base) in placed.iter().enumerate().rev().take(BASES) {
            let added = run_out(self.lane, &between, base, target);
            let left = to_go(added.last().map_or(base.way, |p| p.way));
            if left < nearest {
                nearest = left;
                best = Some((index, added));
            }
            if left <= self.lane.options.spacing[0] {
                break;
            }
        }
        if let Some((index, added)) = best {
            placed.truncate(index + 1);
            placed.extend(added);
        }
        placed.last().map_or(f64::NEG_INFINITY, |p| p.way)
    }

    /// The band as the curve between stations has to keep it.
    fn checker(&self) -> Between<'_> {
        let lane = self.lane;
        let share = lane.options.path_share;
        let ToleranceBand { lower, upper } = lane.options.band;
        let band = ToleranceBand { lower: lower - share, upper: upper + share };
        Between { face: lane.face, cutter: lane.cutter, chart: lane.chart, band }
    }

    /// Halves spans until the curve through the stations keeps the widened band on each, or the spacing is the
    /// least allowed. Gouges, which cost more to find, are looked for once nothing else asks for stations.
    fn refine(&self, mut placed: Vec<Placed>) -> (Vec<Placed>, Vec<Check>) {
        loop {
            let sweep = Sweep::new(&placed, super::lever(self.lane.cutter));
            let pairs: Vec<&[Placed]> = placed.windows(2).collect();
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
            self.lane.work.spans(covers.len());
            let gouges: Vec<f64> =
                (0..covers.len()).into_par_iter().map(|span| self.gouge(&sweep, span)).collect();
            let deep = (0..gouges.len()).filter(|&i| gouges[i] > 0.0).collect();
            if let Some(finer) = self.split(&placed, deep) {
                placed = finer;
                continue;
            }
            let check =
                |(gouge, covers): (f64, bool)| Check { gouge, good: covers && gouge <= 0.0 };
            return (placed, gouges.into_iter().zip(covers).map(check).collect());
        }
    }

    /// Whether a span is long enough for a further station.
    fn divisible(&self, span: &[Placed]) -> bool {
        let length = span.last().map_or(0.0, |b| b.way) - span.first().map_or(0.0, |a| a.way);
        length >= 2.0 * self.lane.options.spacing[0]
    }

    /// Puts a station into each of the spans given that is long enough; `None` where none is.
    fn split(&self, placed: &[Placed], mut spans: Vec<usize>) -> Option<Vec<Placed>> {
        spans.retain(|&i| self.divisible(&placed[i..=i + 1]));
        let reach = |placed: &Placed| self.reach(placed);
        let between: Vec<Place> = spans
            .par_iter()
            .map(|&i| self.lane.between(&placed[i], &placed[i + 1], &reach))
            .collect();
        let new: Vec<(usize, Placed)> = spans
            .into_iter()
            .zip(between)
            .filter_map(|(i, place)| place.ok().map(|placed| (i + 1, placed)))
            .collect();
        if new.is_empty() {
            return None;
        }
        let mut finer = placed.to_vec();
        for (index, station) in new.into_iter().rev() {
            finer.insert(index, station);
        }
        Some(finer)
    }

    /// How far the curve goes below the widened band on a span \[mm\]; 0 or less if it does not.
    fn gouge(&self, sweep: &Sweep, span: usize) -> f64 {
        let length = sweep.curve.knots[span + 1] - sweep.curve.knots[span];
        // Small and positive.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
        let slabs = (length / (SLAB * self.lane.cutter.radius())).ceil().max(1.0) as u32;
        let target = self.clearing.target;
        let others = self.lane.around.kept(sweep, (span, slabs), target);
        let least = self.clearing.least(sweep, span, slabs).min(others);
        self.clearing.target - self.clearing.precision - least
    }

    /// Whether the pose between two stations cuts, to the widened band, what lies halfway between what they cut: the
    /// track, where the pass before ended, the contact, and the end of the strip.
    fn covers(&self, sweep: &Sweep, [a, b]: [&Placed; 2], span: usize) -> bool {
        let [low, high] = self.region.bounds[1];
        // Beyond the border there is nothing to cover.
        if a.along > high || b.along < low {
            return true;
        }
        let (lane, chart) = (self.lane, self.lane.chart);
        let upper = lane.options.band.upper + lane.options.path_share;
        let curve = &sweep.curve;
        let middle = 0.5 * (curve.knots[span] + curve.knots[span + 1]);
        let Some(pose) = sweep.instant(span, middle).map(|here| here.pose) else {
            return false;
        };
        let cut = |[u, v]: [f64; 2]| {
            self.clearing.tool.end.distance(&lane.face.face().point(u, v), &pose) <= upper
        };
        let halfway = |p: [f64; 2], q: [f64; 2]| [0, 1].map(|k| 0.5 * (p[k] + q[k]));
        cut(chart.uv([lane.across, lane.track.at(0.5 * (a.way + b.way))]))
            && cut(halfway(a.contact_uv, b.contact_uv))
            && cut(halfway(a.location.far, b.location.far))
    }
}

/// Ranges of neighbouring places that have locations, two at least.
fn runs(spots: &[Spot]) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for index in (0..spots.len()).filter(|&index| spots[index].place.is_ok()) {
        match runs.last_mut() {
            Some(run) if run[1] + 1 == index => run[1] = index,
            _ => runs.push([index, index]),
        }
    }
    runs.retain(|run| run[1] > run[0]);
    runs
}

/// Ranges of places whose strips have something to cut, run out by `distance` \[mm\] at both ends.
fn kept(spots: &[Spot], distance: f64) -> Vec<[usize; 2]> {
    let mut kept: Vec<[usize; 2]> = Vec::new();
    for spot in spots.iter().filter(|spot| spot.touched) {
        let before = spots.partition_point(|other| other.way <= spot.way - distance);
        let last = spots.partition_point(|other| other.way < spot.way + distance);
        let [first, last] = [before.saturating_sub(1), last.min(spots.len() - 1)];
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

    #[test]
    fn touched_places_are_run_out_and_joined() {
        let spots = |touched: &[usize]| -> Vec<Spot> {
            let range = [0.0, 0.0];
            let place = Err(PositioningError::OffsetRange { range });
            let spot = |i: usize| {
                let touched = touched.contains(&i);
                Spot { way: i as f64, place: place.clone(), touched }
            };
            (0..=20).map(spot).collect()
        };
        assert_eq!(kept(&spots(&[5, 14]), 2.0), [[3, 7], [12, 16]]);
        assert_eq!(kept(&spots(&[5, 14]), 2.5), [[2, 8], [11, 17]]);
        assert_eq!(kept(&spots(&[5, 14]), 4.0), [[1, 18]]);
        assert_eq!(kept(&spots(&[0, 5, 14]), 4.0), [[0, 18]]);
    }
}
