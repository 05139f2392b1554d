//! All passes over one face.

use super::lane::{Lane, Placed};
use super::left::{Left, left, poses};
use super::options::{Along, CoverError, CoverOptions, Covering, Direction};
use super::options::{Fallback, FallbackReason, Method};
use super::region::{Local, Region};
use super::stretch::{Refused, Stretch, Trimmer};
use super::track::Track;
use crate::cutter::Cutter;
use crate::math::angle::angle_between;
use crate::surface::FaceIndex;
use crate::types::{Cancelled, Pass, ToolPose};

/// Trim loops are followed to this share of the face's extent in u and in v. Passes run on the cutter's
/// radius beyond, and their strips begin at a border and end beyond it.
const LOOP_SHARE: f64 = 1e-4;

/// Tells how much of the face is covered, 0 to 1.
type Report<'a> = &'a (dyn Fn(f64) -> Result<(), Cancelled> + Sync);

pub(super) fn cover(
    face: &FaceIndex,
    cutter: &Cutter,
    options: &CoverOptions,
    report: Report<'_>,
) -> Result<Covering, CoverError> {
    let region = region(face, options.along);
    let mut job = Job {
        face,
        cutter,
        options,
        region,
        done: Covering::default(),
        forward: true,
        swept: Vec::new(),
    };
    let [first, last] = job.region.bounds[0];
    let mut across = first;
    report(0.0)?;
    while let Some(next) = job.lane(across)? {
        across = next[0];
        report((across - first) / (last - first))?;
    }
    report(1.0)?;
    Ok(job.done)
}

/// The trimmed region in local parameters; loops on periodic surfaces also a period further on
/// either side, so that every line across the face meets them.
fn region(face: &FaceIndex, along: Along) -> Region<impl Fn(Local) -> bool + Sync> {
    let face = face.face();
    let [u, v] = face.bounds();
    let tolerance = [u, v].map(|range| LOOP_SHARE * (range[1] - range[0]));
    let shifts = |period: Option<f64>| match period {
        Some(period) => vec![-period, 0.0, period],
        None => vec![0.0],
    };
    let [pu, pv] = face.surface.periods();
    let mut loops = Vec::new();
    for points in face.loops.iter().map(|trim| trim.polyline(tolerance)) {
        for du in shifts(pu) {
            for dv in shifts(pv) {
                loops.push(points.iter().map(|p| along.local([p[0] + du, p[1] + dv])).collect());
            }
        }
    }
    let bounds = match along {
        Along::U => [v, u],
        Along::V => [u, v],
    };
    Region::new(bounds, loops, move |local| {
        let [u, v] = along.uv(local);
        face.contains(u, v)
    })
}

/// What is cut on one track, and what it leaves.
struct Lot {
    stretches: Vec<Stretch>,
    left: Left,
}

/// Of a pass of wide strips that has faults and an inclined one, that which has less,
/// and whether it is the inclined one.
fn lesser(
    widest: Option<Lot>,
    inclined: Result<Lot, CoverError>,
) -> Result<(bool, Lot), CoverError> {
    match (widest, inclined) {
        (Some(widest), Ok(inclined)) if faults(&inclined) < faults(&widest) => Ok((true, inclined)),
        (Some(widest), _) => Ok((false, widest)),
        (None, inclined) => inclined.map(|lot| (true, lot)),
    }
}

/// Deepest gouge beyond the band \[mm\], and lines that are missed: what counts first, first.
fn faults(lot: &Lot) -> (f64, usize) {
    let gouge = lot.stretches.iter().map(Stretch::gouge).fold(0.0, f64::max);
    (gouge, lot.left.missed)
}

/// Why a pass of wide strips should not be taken, and it all the same if it can be.
type Refusal = (Fallback, Option<Lot>);

/// A face while its passes are placed.
struct Job<'a, Inside> {
    face: &'a FaceIndex,
    cutter: &'a Cutter,
    options: &'a CoverOptions,
    region: Region<Inside>,
    done: Covering,
    forward: bool,
    /// Poses of the pass before.
    swept: Vec<ToolPose>,
}

impl<Inside: Fn(Local) -> bool + Sync> Job<'_, Inside> {
    /// Adds the pass at `across`; the first place that is still left further on.
    fn lane(&mut self, across: f64) -> Result<Option<Local>, CoverError> {
        let track = self.track(across)?;
        let Lot { stretches, left } = match self.options.method {
            Method::Inclined => self.inclined(&track, across)?,
            Method::Widest => match self.widest(&track, across) {
                Ok(lot) => lot,
                Err(refusal) => {
                    let (fallback, widest) = *refusal;
                    let (fallen, lot) = lesser(widest, self.inclined(&track, across))?;
                    self.done.report.fallbacks.extend(fallen.then_some(fallback));
                    lot
                }
            },
        };
        self.done.report.missed += left.missed;
        self.swept = stretches.iter().flat_map(|stretch| poses(stretch, self.cutter)).collect();
        self.add(stretches);
        Ok(left.next)
    }

    fn inclined(&self, track: &Track, across: f64) -> Result<Lot, CoverError> {
        let lot = self
            .place(track, across, Method::Inclined)
            .map_err(|refused| self.no_pose(track, across, refused))?;
        lot.left.next.map_or(Ok(()), |next| self.advances(across, next))?;
        Ok(lot)
    }

    /// The pass with the widest strips, or why it should not be taken, and it all the same if it can be.
    fn widest(&self, track: &Track, across: f64) -> Result<Lot, Box<Refusal>> {
        let chart = self.options.along;
        let face = self.face.face().number;
        let fallback = |at: Local, reason| Fallback { face, at: chart.uv(at), reason };
        let lot = self.place(track, across, Method::Widest).map_err(|(way, error)| {
            let at = [across, track.at(way)];
            Box::new((fallback(at, FallbackReason::NoStrip(error)), None))
        })?;
        if let Some(at) = lot.left.next
            && let Err(CoverError::TooNarrow { advance, .. }) = self.advances(across, at)
        {
            return Err(Box::new((fallback(at, FallbackReason::NoAdvance(advance)), None)));
        }
        if lot.left.missed > 0 {
            let at = [across, track.at(0.0)];
            let why = fallback(at, FallbackReason::Missed(lot.left.missed));
            return Err(Box::new((why, Some(lot))));
        }
        let spans = lot.stretches.iter().flat_map(|s| s.placed.iter().zip(&s.checks));
        let deepest = spans.max_by(|a, b| a.1.gouge.total_cmp(&b.1.gouge));
        if let Some((place, check)) = deepest
            && check.gouge > 0.0
        {
            let at = [across, place.along];
            let why = fallback(at, FallbackReason::Gouge(check.gouge));
            return Err(Box::new((why, Some(lot))));
        }
        Ok(lot)
    }

    fn place(&self, track: &Track, across: f64, method: Method) -> Result<Lot, Refused> {
        let lane = Lane {
            face: self.face,
            cutter: self.cutter,
            options: self.options,
            across,
            track: track.clone(),
            forward: self.forward,
            method,
        };
        let trimmer = Trimmer { lane: &lane, region: &self.region };
        let stretches = trimmer.stretches()?;
        let mut swept = self.swept.clone();
        swept.extend(stretches.iter().flat_map(|stretch| poses(stretch, self.cutter)));
        let left = left(&lane, &self.region, &swept, trimmer.next(&stretches));
        Ok(Lot { stretches, left })
    }

    fn no_pose(&self, track: &Track, across: f64, (way, error): Refused) -> CoverError {
        let at = self.options.along.uv([across, track.at(way)]);
        CoverError::NoPose { face: self.face.face().number, at, error }
    }

    fn track(&self, across: f64) -> Result<Track, CoverError> {
        let chart = self.options.along;
        let extension = self.cutter.radius();
        let track = Track::new(self.face, chart, across, self.region.bounds[1], extension);
        let [start, end] = track.range();
        if end - start > self.options.spacing[0] {
            Ok(track)
        } else {
            Err(CoverError::NoTrack { face: self.face.face().number, along: chart, across })
        }
    }

    /// An error unless the next pass lies at least the least spacing further on.
    fn advances(&self, across: f64, next: Local) -> Result<(), CoverError> {
        let chart = self.options.along;
        let point = |local: Local| {
            let [u, v] = chart.uv(local);
            self.face.face().point(u, v)
        };
        let advance = (point(next) - point([across, next[1]])).norm();
        let least = self.options.spacing[0];
        if next[0] > across && advance >= least {
            return Ok(());
        }
        let at = chart.uv(next);
        Err(CoverError::TooNarrow { face: self.face.face().number, at, advance, least })
    }

    fn add(&mut self, mut stretches: Vec<Stretch>) {
        if stretches.is_empty() {
            return;
        }
        if !self.forward {
            stretches.reverse();
        }
        for stretch in stretches {
            self.note(&stretch);
            let pass = self.pass(stretch.placed);
            self.done.report.length +=
                pass.stations.windows(2).map(|s| (s[1].contact - s[0].contact).norm()).sum::<f64>();
            self.done.report.stations += pass.stations.len();
            self.done.passes.push(pass);
        }
        if self.options.direction == Direction::ZigZag {
            self.forward = !self.forward;
        }
    }

    fn note(&mut self, stretch: &Stretch) {
        let report = &mut self.done.report;
        report.shortened += usize::from(stretch.shortened.contains(&true));
        for check in stretch.checks.iter().filter(|check| !check.good) {
            report.coarse_spans += 1;
            report.worst_gouge = report.worst_gouge.max(check.gouge);
        }
        for pair in stretch.placed.windows(2) {
            let turn = angle_between(&pair[0].station.pose.axis, &pair[1].station.pose.axis);
            let rate = turn / (pair[1].way - pair[0].way);
            report.axis_turn = report.axis_turn.max(rate);
            report.fast_turns += usize::from(rate > self.options.max_axis_turn);
        }
    }

    /// Stations in cutting order.
    fn pass(&self, mut placed: Vec<Placed>) -> Pass {
        if !self.forward {
            placed.reverse();
        }
        let chart = self.options.along;
        let track = placed.iter().map(|p| chart.uv([p.across, p.along])).collect();
        let widths = placed.iter().map(|p| p.location.strip_width).collect();
        let stations = placed.into_iter().map(|p| p.station).collect();
        Pass { face: self.face.face().number, stations, widths, track }
    }
}
