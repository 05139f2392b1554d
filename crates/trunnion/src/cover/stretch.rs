//! From the places of a lane to the stretches that are cut: trimmed, run out, and fine enough.

use super::between::{Between, Strip};
use super::lane::{Lane, Place, Placed};
use super::region::{Local, Region};
use crate::cutter::Cutter;
use crate::positioning::{Band, PositioningError};
use crate::types::{PoseCurve, ToolPose};
use nalgebra::Point3;
use rayon::prelude::*;

/// A span is split if its strip is narrower by this share than at both of its ends: the curve
/// between the stations would cost more width than further stations.
const WASTE: f64 = 0.02;

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
            stretches.push(Stretch { placed, checks, shortened: row.shortened });
        }
        Ok(stretches)
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
    /// given up at either end, but not inside, and not where there is something to cut.
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
        let shortened = [first > 0, last + 1 < spots.len()];
        if first > 0 {
            let end = self.towards(&placed[0], spots[first - 1].way);
            self.lost(&end, &spots[..first])?;
            if end.way < placed[0].way {
                placed.insert(0, end);
            }
        }
        if let (true, Some(before)) = (shortened[1], placed.last()) {
            let end = self.towards(before, spots[last + 1].way);
            self.lost(&end, &spots[last + 1..])?;
            if end.way > before.way {
                placed.push(end);
            }
        }
        Ok((placed.len() > 1).then_some(Row { placed, shortened }))
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

    /// An error if a place over the face is given up, farther from `end` than twice the least
    /// spacing, with something to cut. Beyond the border only the run-out is lost.
    fn lost(&self, end: &Placed, spots: &[Spot]) -> Result<(), Refused> {
        let least = 2.0 * self.lane.options.spacing[0];
        let missed = |spot: &&Spot| {
            spot.touched
                && self.lane.track.over_face(spot.way)
                && (spot.way - end.way).abs() > least
        };
        spots.iter().filter(missed).find_map(Spot::refused).map_or(Ok(()), Err)
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
        let lane = self.lane;
        let curve = PoseCurve::through(&stations, super::lever(lane.cutter));
        let share = lane.options.path_share;
        let Band { lower, upper } = lane.options.band;
        let band = Band { lower: lower - share, upper: upper + share };
        let chart = lane.options.along;
        let between = Between { face: lane.face, cutter: lane.cutter, chart, band };
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
        let unknown = Check { far: None, gouge: 0.0, good: false };
        let rates = curve.rates_in(span, 0.5 * (curve.knots[span] + curve.knots[span + 1]));
        let Some(pose) = rates.pose() else { return unknown };
        let guess = [0, 1].map(|k| 0.5 * (a.contact_uv[k] + b.contact_uv[k]));
        let Ok(strip) = between.strip(&pose, &rates.contact[0].into(), guess) else {
            return unknown;
        };
        let gouge = between.band.lower - strip.least;
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

    /// The first place across, beyond what the stretches cover, where something is left to cut.
    pub(super) fn next(&self, stretches: &[Stretch]) -> Option<Local> {
        let mut left: Vec<Local> = Vec::new();
        let [low, high] = self.region.bounds[1];
        let across = self.lane.across;
        let mut covered = low;
        for stretch in stretches {
            let fars = self.fars(stretch);
            let [start, end] = self.covered(stretch, &fars);
            left.extend(self.first(across, [covered, start]));
            covered = covered.max(end);
            for pair in fars.windows(2) {
                left.extend(self.beyond([pair[0], pair[1]]));
            }
        }
        if covered < high {
            left.extend(self.first(across, [covered, high]));
        }
        left.into_iter().min_by(|a, b| a[0].total_cmp(&b[0]))
    }

    /// Range along over which the ends of a stretch's strips lie. Where it had to stop short, the
    /// places within twice the least spacing count too: its foot points lie ahead of its track.
    fn covered(&self, stretch: &Stretch, fars: &[Local]) -> [f64; 2] {
        let alongs = || fars.iter().map(|far| far[1]);
        let mut range =
            [alongs().fold(f64::INFINITY, f64::min), alongs().fold(f64::NEG_INFINITY, f64::max)];
        let allowed = 2.0 * self.lane.options.spacing[0];
        if let (Some(first), Some(last)) = (stretch.placed.first(), stretch.placed.last()) {
            if stretch.shortened[0] {
                range[0] = range[0].min(self.lane.track.at(first.way - allowed));
            }
            if stretch.shortened[1] {
                range[1] = range[1].max(self.lane.track.at(last.way + allowed));
            }
        }
        range
    }

    fn first(&self, from: f64, slab: [f64; 2]) -> Option<Local> {
        (slab[0] < slab[1])
            .then(|| self.region.first_from(from, slab))
            .flatten()
            .map(|across| [across, slab[0]])
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

/// Signed distance of a point from the cutting end: what is higher than `r` above the tip and not
/// farther than `R` from the axis, grown by `r`.
fn distance(point: &Point3<f64>, pose: &ToolPose, cutter: &Cutter) -> f64 {
    let from_tip = point - pose.tip;
    let height = from_tip.dot(&pose.axis);
    let below = cutter.minor() - height;
    let out = (from_tip - pose.axis.scale(height)).norm() - cutter.major();
    let outside = out.max(0.0).hypot(below.max(0.0));
    outside + out.max(below).min(0.0) - cutter.minor()
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
