//! From the places of a lane to the stretches that are cut: trimmed, run out, and fine enough.

use super::between::{Between, Strip};
use super::lane::{Lane, Place, Placed};
use super::left::distance;
use super::region::{Local, Region};
use super::runout::run_out;
use crate::positioning::{Band, PositioningError};
use crate::types::{PoseCurve, ToolPose};
use rayon::prelude::*;

/// A span is split if its strip is narrower by this share than at both of its ends: the curve
/// between the stations would cost more width than further stations.
const WASTE: f64 = 0.02;

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

impl Stretch {
    /// Deepest that the curve leaves the widened band \[mm\]; 0 or less is good.
    pub(super) fn gouge(&self) -> f64 {
        self.checks.iter().map(|check| check.gouge).fold(f64::NEG_INFINITY, f64::max)
    }

    /// First and last station of the longest part without a gouging span; `None` if all gouge.
    fn longest_part(&self) -> Option<[usize; 2]> {
        let mut parts = vec![[0, 0]];
        for (span, check) in self.checks.iter().enumerate() {
            match parts.last_mut() {
                Some(part) if check.gouge <= 0.0 => part[1] = span + 1,
                _ => parts.push([span + 1, span + 1]),
            }
        }
        let length = |part: &[usize; 2]| match (self.placed.get(part[0]), self.placed.get(part[1]))
        {
            (Some(a), Some(b)) => b.way - a.way,
            _ => 0.0,
        };
        parts.into_iter().filter(|p| length(p) > 0.0).max_by(|a, b| length(a).total_cmp(&length(b)))
    }
}

/// The middle of a span on the curve that will be laid through the stations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Check {
    /// Where the strip ends, if all is as it should be.
    far: Option<Local>,
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

/// Stations without a gap.
struct Row {
    placed: Vec<Placed>,
    shortened: [bool; 2],
}

/// Place where no cutter location was found, and why.
pub(super) type Refused = (f64, PositioningError);

/// A lane with the region it has to cover.
pub(super) struct Trimmer<'a, Inside> {
    pub(super) lane: &'a Lane<'a>,
    pub(super) region: &'a Region<Inside>,
}

impl<Inside: Fn(Local) -> bool + Sync> Trimmer<'_, Inside> {
    /// The lane's stretches in order of the track.
    ///
    /// # Errors
    ///
    /// A place in the region that has no cutter location.
    pub(super) fn stretches(&self) -> Result<Vec<Stretch>, Refused> {
        let ways = self.ways();
        let spots = self.spots(&ways, self.lane.settle(&ways, &|placed| self.reach(placed)));
        let mut stretches = Vec::new();
        for [first, last] in kept(&spots, self.lane.cutter.radius()) {
            let Some(row) = self.whole(&spots[first..=last])? else { continue };
            let (placed, checks) = self.refine(row.placed);
            let stretch = Stretch { placed, checks, shortened: row.shortened };
            stretches.push(self.mend(stretch));
        }
        Ok(stretches)
    }

    /// Replaces what lies beyond a gouging span (a jump between two kinds of location) by a run-out
    /// from the longest good part, if that gouges less.
    fn mend(&self, stretch: Stretch) -> Stretch {
        if stretch.gouge() <= 0.0 {
            return stretch;
        }
        let Some([first, last]) = stretch.longest_part() else { return stretch };
        let targets = [stretch.placed.first(), stretch.placed.last()].map(|p| p.map(|p| p.way));
        let [Some(start), Some(end)] = targets else { return stretch };
        let mut placed = stretch.placed[first..=last].to_vec();
        let mut shortened = stretch.shortened;
        let short = self.lane.options.spacing[0];
        if last + 1 < stretch.placed.len() {
            shortened[1] = (self.run_out(&mut placed, end) - end).abs() > short;
        }
        if first > 0 {
            placed.reverse();
            shortened[0] = (self.run_out(&mut placed, start) - start).abs() > short;
            placed.reverse();
        }
        let (placed, checks) = self.refine(placed);
        let mended = Stretch { placed, checks, shortened };
        if mended.gouge() < stretch.gouge() { mended } else { stretch }
    }

    /// How far across a location finishes the region on its own line.
    fn reach(&self, placed: &Placed) -> f64 {
        let [across, along] = placed.far(self.lane.options.along);
        self.region.first_from(across, [along, along]).unwrap_or(f64::INFINITY)
    }

    /// Evenly spaced places along the track.
    fn ways(&self) -> Vec<f64> {
        let [start, end] = self.lane.track.range();
        let wanted = ((end - start) / self.lane.options.spacing[1]).ceil().max(3.0);
        // A track cannot need more stations than fit into memory by spacing; `as` saturates.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "is positive")]
        let count = wanted as u32;
        (0..=count).map(|i| start + (end - start) * f64::from(i) / f64::from(count)).collect()
    }

    /// Notes for each place whether its strip meets the region between its neighbours.
    fn spots(&self, ways: &[f64], places: Vec<Place>) -> Vec<Spot> {
        let (lane, chart) = (self.lane, self.lane.options.along);
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

    /// Stations without a gap; `None` where fewer than two are left. Places without a location are
    /// given up at either end, but not inside.
    fn whole(&self, spots: &[Spot]) -> Result<Option<Row>, Refused> {
        let good = |spot: &Spot| spot.place.is_ok();
        let [Some(first), Some(last)] = [spots.iter().position(good), spots.iter().rposition(good)]
        else {
            let refused = spots.iter().filter(|spot| spot.touched).find_map(Spot::refused);
            return refused.map_or(Ok(None), Err);
        };
        let mut placed = Vec::new();
        for spot in &spots[first..=last] {
            placed.push(spot.place.clone().map_err(|error| (spot.way, error))?);
        }
        let mut shortened = [first > 0, last + 1 < spots.len()];
        if first > 0 {
            placed.reverse();
            shortened[0] = self.finish_end(&mut placed, spots[first - 1].way, spots[0].way);
            placed.reverse();
        }
        if shortened[1] {
            let [bad, target] = [spots[last + 1].way, spots[spots.len() - 1].way];
            shortened[1] = self.finish_end(&mut placed, bad, target);
        }
        Ok((placed.len() > 1).then_some(Row { placed, shortened }))
    }

    /// Carries a row on past its last location: as near as locations are found to `bad`, where there
    /// is none, then by a run-out. Whether it ends short of `target`.
    fn finish_end(&self, placed: &mut Vec<Placed>, bad: f64, target: f64) -> bool {
        let Some(last) = placed.last() else { return true };
        let end = self.towards(last, bad);
        if (end.way - last.way).abs() > 0.0 {
            placed.push(end);
        }
        let reached = self.run_out(placed, target);
        (target - reached).abs() > self.lane.options.spacing[0]
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
        let Band { lower, upper } = lane.options.band;
        let band = Band { lower: lower - share, upper: upper + share };
        Between { face: lane.face, cutter: lane.cutter, chart: lane.options.along, band }
    }

    /// Halves spans until the curve through the stations keeps the widened band in the middle of
    /// each, or the spacing is the least allowed.
    fn refine(&self, mut placed: Vec<Placed>) -> (Vec<Placed>, Vec<Check>) {
        loop {
            let checks = self.checks(&placed);
            let least = 2.0 * self.lane.options.spacing[0];
            let split: Vec<usize> = (0..checks.len())
                .filter(|&i| !checks[i].good && placed[i + 1].way - placed[i].way >= least)
                .collect();
            let reach = |placed: &Placed| self.reach(placed);
            let between: Vec<Place> = split
                .par_iter()
                .map(|&i| self.lane.between(&placed[i], &placed[i + 1], &reach))
                .collect();
            let new: Vec<(usize, Placed)> = split
                .into_iter()
                .zip(between)
                .filter_map(|(i, place)| place.ok().map(|placed| (i + 1, placed)))
                .collect();
            if new.is_empty() {
                return (placed, checks);
            }
            for (index, station) in new.into_iter().rev() {
                placed.insert(index, station);
            }
        }
    }

    fn checks(&self, placed: &[Placed]) -> Vec<Check> {
        let stations: Vec<_> = placed.iter().map(|p| p.station).collect();
        let curve = PoseCurve::through(&stations, super::lever(self.lane.cutter));
        let between = self.checker();
        (0..curve.spans.len())
            .into_par_iter()
            .map(|span| self.check(&between, &curve, [&placed[span], &placed[span + 1]], span))
            .collect()
    }

    fn check(
        &self,
        between: &Between<'_>,
        curve: &PoseCurve,
        [a, b]: [&Placed; 2],
        span: usize,
    ) -> Check {
        let [start, end] = [curve.knots[span], curve.knots[span + 1]];
        let look = |share: f64| {
            let rates = curve.rates_in(span, start + share * (end - start));
            let guess =
                [0, 1].map(|k| a.contact_uv[k] + share * (b.contact_uv[k] - a.contact_uv[k]));
            let pose = rates.pose()?;
            let strip = between.strip(&pose, &rates.contact[0].into(), guess).ok()?;
            Some((pose, strip))
        };
        let [Some((pose, strip)), Some(before), Some(after)] = [0.5, 0.25, 0.75].map(look) else {
            return Check { far: None, gouge: 0.0, good: false };
        };
        let gouge = between.band.lower - strip.least.min(before.1.least).min(after.1.least);
        let [low, high] = self.region.bounds[1];
        // Beyond the border there is nothing to cover.
        let beyond = a.along > high || b.along < low;
        let covers = beyond
            || (self.meets(&pose, between.band.upper, [a, b]) && self.reaches(&strip, [a, b]));
        let good = gouge <= 0.0 && covers;
        Check { far: strip.far.filter(|_| good), gouge, good }
    }

    /// Whether the track between two stations, where the pass before ended, is cut to `upper` by the
    /// pose between them.
    fn meets(&self, pose: &ToolPose, upper: f64, [a, b]: [&Placed; 2]) -> bool {
        let lane = self.lane;
        let along = lane.track.at(0.5 * (a.way + b.way));
        let [u, v] = lane.options.along.uv([lane.across, along]);
        distance(&lane.face.face().point(u, v), pose, lane.cutter) <= upper
    }

    /// Whether a strip between two stations is about as wide as theirs.
    fn reaches(&self, strip: &Strip, ends: [&Placed; 2]) -> bool {
        let (across, chart) = (self.lane.across, self.lane.options.along);
        let least = ends.map(|p| p.far(chart)[0]).into_iter().fold(f64::INFINITY, f64::min);
        strip.far.is_some_and(|far| far[0] >= least - WASTE * (least - across))
    }

    /// The first place across, beyond the ends of the strips, where something is left to cut.
    pub(super) fn next(&self, stretches: &[Stretch]) -> Option<Local> {
        let mut left: Vec<Local> = Vec::new();
        for stretch in stretches {
            for pair in self.fars(stretch).windows(2) {
                left.extend(self.beyond([pair[0], pair[1]]));
            }
        }
        if stretches.is_empty() {
            let [along, end] = self.region.bounds[1];
            left.extend(self.region.first_from(self.lane.across, [along, end]).map(|t| [t, along]));
        }
        left.into_iter()
            .filter(|place| place[0] > self.lane.across)
            .min_by(|a, b| a[0].total_cmp(&b[0]))
    }

    /// Ends of the strips at stations and between them, in order.
    fn fars(&self, stretch: &Stretch) -> Vec<Local> {
        let chart = self.lane.options.along;
        let mut fars = Vec::new();
        for (i, placed) in stretch.placed.iter().enumerate() {
            fars.push(placed.far(chart));
            fars.extend(stretch.checks.get(i).and_then(|check| check.far));
        }
        fars
    }

    /// The first place left beyond the segment between two ends of strips.
    fn beyond(&self, [a, b]: [Local; 2]) -> Option<Local> {
        let [low, high] = self.region.bounds[1];
        let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        if b[1] < low || a[1] > high {
            return None;
        }
        let at = |along: f64| {
            let share = if b[1] > a[1] { (along - a[1]) / (b[1] - a[1]) } else { 0.0 };
            a[0] + share * (b[0] - a[0])
        };
        let slab = [a[1].max(low), b[1].min(high)];
        let reach = if b[1] > a[1] { at(slab[0]).min(at(slab[1])) } else { a[0].min(b[0]) };
        self.region.first_from(reach, slab).map(|across| [across, slab[0]])
    }
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
