//! From passes to a whole program of motions: leads and links.

use super::CoverError;
use super::chart::Chart;
use super::clear::Clearing;
use super::hop::{Hop, Hops};
use super::options::Along;
use super::sheet::Sheet;
use super::sweep::Sweep;
use super::turns::Turns;
use crate::cutter::Cutter;
use crate::cutter::solid::Tool;
use crate::surface::FaceIndex;
use crate::types::{Leg, Motion, Pass, PoseCurve, Progress, Stage, Station, ToolPose};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// How the tool comes down to a pass and leaves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeadKind {
    /// Straight along the tool axis.
    Axis,
    /// First along the pass, carried on straight by `length` \[mm\], then along the tool axis.
    Tangent {
        /// How far the pass is carried on \[mm\].
        length: f64,
    },
}

/// How passes are joined. No `Default`: the caller knows part, stock and tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkOptions {
    /// Way out of the part: square to the plane of the links.
    pub up: UnitVector3<f64>,
    /// Boxes, by low and high corner, that hold part and stock \[mm\].
    pub boxes: Vec<[Point3<f64>; 2]>,
    /// What links keep from part and stock \[mm\]. No part of the cutting end goes below the plane square to
    /// `up` that lies this much above the boxes, nor, on links round the part, below such a plane square to the
    /// tool axis.
    pub clearance: f64,
    /// Kind of lead.
    pub lead: LeadKind,
    /// Last stretch of a lead that is run at the cutting feed \[mm\]; what lies above counts as a link.
    /// Longer than the lead: all of it.
    pub approach: f64,
    /// Depth to which the cutter may go into a face during a lead \[mm\]: the gouge tolerance.
    pub gouge: f64,
}

/// What the machine makes of the ways between passes; by default nothing is known of it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ways<'a> {
    /// Hops from pass to pass; none: always up to the plane of the links.
    pub hops: Option<Hops<'a>>,
    /// What the tool may turn over on links round the part; none: anything.
    pub turns: Option<Turns<'a>>,
}

/// A lead climbs at least this much per mm of its length: a flatter one would run over the part
/// for more than ten times the height it has to gain.
const LEAST_CLIMB: f64 = 0.1;

/// Climb from which on the tool stands rather than lies on the plane \[60 deg from its normal\]: farther over, leads
/// along the tool axis get longer than twice the height they gain, and it is the flank and the holder that
/// come next to the plane.
const UPRIGHT: f64 = 0.5;

/// Share of the gouge tolerance that a lead may use up without it being told from none.
const PRECISION: f64 = 0.1;

/// Joins passes: down to the first, along it, over to the next, and up from the last. Passes are run in
/// the order and direction given.
///
/// From pass to pass the tool hops, where [`Hops`] say how and that is quicker; otherwise it goes up by a lead,
/// over at a height where it may turn, and down again. Each hop and each lead is proven to keep off all
/// `faces`, with the whole tool up to the gauge point; where the way of a lead along the tool axis is barred, one
/// leaning towards `up` is taken. Where no lead leads up to the plane over the part, or the tool would lie on
/// it, as on the sides of a shaft, leads end over the part as seen along the tool axis, and the link
/// between them leads round the part: a curve, the axis turning on the way, that is proven likewise.
///
/// # Errors
///
/// [`CoverError::LeadGouges`] where every way gouges or does not lead up; [`CoverError::Cancelled`].
pub fn legs(
    passes: &[Pass],
    faces: &[FaceIndex],
    cutter: &Cutter,
    (options, ways): (&LinkOptions, &Ways<'_>),
    progress: &dyn Progress,
) -> Result<Vec<Leg>, CoverError> {
    let (tool, lever) = (Tool::new(cutter), super::lever(cutter));
    let chart = Chart::straight(Along::V);
    let sheets = faces.iter().map(|face| sheet(face, &chart, cutter)).collect();
    let leads = Leads { faces, sheets, chart, tool, lever, cutter, options, turns: ways.turns };
    let done = AtomicU64::new(0);
    let total = passes.len() as u64;
    let ways: Vec<Vec<Leg>> = (0..=passes.len())
        .into_par_iter()
        .map(|next| {
            progress.step(Stage::Cover, done.fetch_add(1, Ordering::Relaxed), total)?;
            let before = next.checked_sub(1).and_then(|before| Some((before, passes.get(before)?)));
            leads.between(before, passes.get(next).map(|pass| (next, pass)), ways.hops.as_ref())
        })
        .collect::<Result<_, CoverError>>()?;
    let mut legs: Vec<Leg> = Vec::new();
    let cuts =
        passes.iter().map(|pass| Leg { motion: Motion::Cut, stations: pass.stations.clone() });
    let mut cuts = cuts.fuse();
    for way in ways {
        legs.extend(way);
        legs.extend(cuts.next());
    }
    Ok(legs)
}

/// Splits a way up where its last straight part, the climb, is `approach` long: what lies above, if
/// anything does, and what lies below.
fn split(mut up: Vec<Station>, approach: f64) -> (Option<Vec<Station>>, Vec<Station>) {
    let Some(&[foot, top]) = up.last_chunk::<2>() else { return (None, up) };
    let climb = top.pose.tip - foot.pose.tip;
    if climb.norm() <= approach {
        return (None, up);
    }
    let near = moved(&foot, &climb.scale(approach / climb.norm()));
    up.pop();
    up.push(near);
    (Some(vec![near, top]), up)
}

fn reversed(mut stations: Vec<Station>) -> Vec<Station> {
    stations.reverse();
    stations
}

pub(super) struct Leads<'a> {
    pub(super) faces: &'a [FaceIndex],
    pub(super) sheets: Vec<Sheet>,
    pub(super) chart: Chart,
    pub(super) tool: Tool,
    pub(super) lever: f64,
    cutter: &'a Cutter,
    pub(super) options: &'a LinkOptions,
    turns: Option<Turns<'a>>,
}

/// An end of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    First,
    Last,
}

/// Where a lead ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Over {
    /// Over the plane square to `up`.
    Plane,
    /// Over the part as seen along the tool axis.
    Axis,
}

/// From one pass to the next: both ways up, and the link between their ends.
#[derive(Default)]
struct Join {
    up: Vec<Station>,
    link: Vec<Station>,
    down: Vec<Station>,
}

/// A pass with its index.
type Numbered<'a> = (usize, &'a Pass);

impl Leads<'_> {
    /// The way from one pass to the next; without one of them, from or to the height of the links.
    fn between(
        &self,
        before: Option<Numbered<'_>>,
        next: Option<Numbered<'_>>,
        hops: Option<&Hops<'_>>,
    ) -> Result<Vec<Leg>, CoverError> {
        if let (Some((_, before)), Some((_, next)), Some(hops)) = (before, next, hops)
            && let (Some(from), Some(to)) = (before.stations.last(), next.stations.first())
            && self.turns.is_none_or(|turns| turns.reach(&[from.pose.axis, to.pose.axis]))
        {
            let over = [self.least(from), self.least(to)].map(|way| way.map(|s| s.pose));
            let hop = Hop { from, to, over, lever: self.lever };
            let margin = PRECISION * self.options.gouge;
            let free = |sweep: &Sweep, span, least: f64| {
                self.depth_in(sweep, span, least + margin) <= -least
            };
            if let Some(stations) = hop.find(hops, free, self.options.gouge) {
                return Ok(vec![Leg { motion: Motion::Hop, stations }]);
            }
        }
        let Join { up, link, down } = match (before, next) {
            (Some(before), Some(next)) => self.join(before, next)?,
            (Some(before), None) => Join { up: self.alone(before, End::Last)?, ..Join::default() },
            (None, Some(next)) => Join { down: self.alone(next, End::First)?, ..Join::default() },
            (None, None) => Join::default(),
        };
        let mut legs = Vec::new();
        if before.is_some() {
            let (high, low) = split(up, self.options.approach);
            legs.push(Leg { motion: Motion::LeadOut, stations: low });
            legs.extend(high.map(|stations| Leg { motion: Motion::Link, stations }));
        }
        if link.len() > 1 {
            legs.push(Leg { motion: Motion::Link, stations: link });
        }
        if next.is_some() {
            let (high, low) = split(down, self.options.approach);
            let link = high.map(|high| Leg { motion: Motion::Link, stations: reversed(high) });
            legs.extend(link);
            legs.push(Leg { motion: Motion::LeadIn, stations: reversed(low) });
        }
        Ok(legs)
    }

    /// The shortest way up there may be.
    fn least(&self, end: &Station) -> Option<Station> {
        let (direction, length) = self.ups(end, Over::Plane).next()?;
        Some(moved(end, &direction.scale(length)))
    }

    /// The way up from an end that nothing comes before or after.
    fn alone(&self, (pass, of): Numbered<'_>, end: End) -> Result<Vec<Station>, CoverError> {
        let ways = self.order(&[(of, end)]).map(|over| self.away(of, end, over));
        let gouges = |depth| CoverError::LeadGouges { pass, face: of.face, depth };
        let [first, second] = ways;
        first.or_else(|depth| second.map_err(|other| gouges(depth.max(other))))
    }

    /// By the plane if both passes have leads to it, round the part if not; the other way about where the
    /// tool would come to lie flat on the plane.
    fn join(&self, one: Numbered<'_>, next: Numbered<'_>) -> Result<Join, CoverError> {
        let [first, second] = self.order(&[(one.1, End::Last), (next.1, End::First)]);
        let by = |over| self.join_over(over, one, next);
        by(first).or_else(|error| by(second).map_err(|_| error))
    }

    /// What to try first.
    fn order(&self, ends: &[(&Pass, End)]) -> [Over; 2] {
        let stations = ends.iter().filter_map(|(pass, end)| match end {
            End::First => pass.stations.first(),
            End::Last => pass.stations.last(),
        });
        let mut climbs = stations.map(|station| station.pose.axis.dot(&self.options.up));
        if climbs.all(|climb| climb >= UPRIGHT) {
            [Over::Plane, Over::Axis]
        } else {
            [Over::Axis, Over::Plane]
        }
    }

    fn join_over(
        &self,
        over: Over,
        (before, one): Numbered<'_>,
        (number, next): Numbered<'_>,
    ) -> Result<Join, CoverError> {
        let gouges = |pass, face| move |depth| CoverError::LeadGouges { pass, face, depth };
        let up = self.away(one, End::Last, over).map_err(gouges(before, one.face))?;
        let down = self.away(next, End::First, over).map_err(gouges(number, next.face))?;
        let link = match (up.last(), down.last()) {
            (Some(from), Some(to)) if over == Over::Plane => vec![*from, *to],
            (Some(from), Some(to)) if from.pose != to.pose => {
                let blocked = CoverError::NoWayRound { pass: number, face: next.face };
                self.around(from, to, self.turns.as_ref()).ok_or(blocked)?
            }
            _ => Vec::new(),
        };
        Ok(Join { up, link, down })
    }

    /// Stations from an end of a pass up to where links run; the greatest depth of a gouge where there is
    /// no way.
    fn away(&self, pass: &Pass, end: End, over: Over) -> Result<Vec<Station>, f64> {
        let pair = match (end, pass.stations.as_slice()) {
            (End::First, [end, before, ..]) | (End::Last, [.., before, end]) => [*end, *before],
            _ => return Ok(Vec::new()),
        };
        let [end, before] = pair;
        let mut ways = Vec::new();
        if let LeadKind::Tangent { length } = self.options.lead
            && let Some(tangent) = Unit::try_new(end.pose.tip - before.pose.tip, 0.0)
        {
            ways.extend(self.ups(&end, over).map(|up| vec![(tangent, length), up]));
        }
        ways.extend(self.ups(&end, over).map(|up| vec![up]));
        let mut deepest = 0.0;
        for way in ways {
            match self.follow(end, &way) {
                Ok(stations) => return Ok(stations),
                Err(depth) => deepest = f64::max(deepest, depth),
            }
        }
        Err(deepest)
    }

    /// Directions up to the height of the links with the way to go: the tool axis, and more and more of straight up;
    /// of straight away from the part where the axis counts as up.
    fn ups(&self, end: &Station, over: Over) -> impl Iterator<Item = (UnitVector3<f64>, f64)> {
        let (axis, tip) = (end.pose.axis, end.pose.tip);
        let radius = self.cutter.radius();
        let (up, aside, above) = match over {
            // With its tip a radius above the plane, the cutting end is above it however it is turned.
            Over::Plane => {
                let up = self.options.up;
                (up, up.into_inner(), self.height(&up) + radius)
            }
            Over::Axis => (axis, self.outwards(&tip), self.height(&axis)),
        };
        let height = above - tip.coords.dot(&up);
        [0.0, 0.5, 1.0].into_iter().filter_map(move |share| {
            let direction = Unit::try_new(axis.lerp(&aside, share), 0.0)?;
            let climb = direction.dot(&up);
            (climb >= LEAST_CLIMB).then(|| (direction, (height / climb).max(radius)))
        })
    }

    /// Unit vector away from the middle of part and stock.
    fn outwards(&self, tip: &Point3<f64>) -> Vector3<f64> {
        let corners = || self.options.boxes.iter().flatten().map(|corner| corner.coords);
        let low = corners().fold(Vector3::repeat(f64::INFINITY), |a, b| a.inf(&b));
        let high = corners().fold(Vector3::repeat(f64::NEG_INFINITY), |a, b| a.sup(&b));
        let out = tip.coords - (low + high) * 0.5;
        out.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector3::zeros)
    }

    /// Stations at the corners of a way, or how deep it gouges.
    fn follow(&self, from: Station, way: &[(UnitVector3<f64>, f64)]) -> Result<Vec<Station>, f64> {
        let mut stations = vec![from];
        let mut here = from;
        for (direction, length) in way {
            let depth = self.depth(&here.pose, direction, *length);
            if depth > self.options.gouge {
                return Err(depth);
            }
            here = moved(&here, &(direction.scale(*length)));
            stations.push(here);
        }
        Ok(stations)
    }

    /// How deep the tool goes into a face on a straight way; at least so deep, where that is more than the
    /// gouge tolerance.
    fn depth(&self, from: &ToolPose, direction: &UnitVector3<f64>, length: f64) -> f64 {
        let start = Station { pose: *from, contact: from.tip };
        let end = moved(&start, &direction.scale(length));
        let sweep = Sweep::of(PoseCurve::through(&[start, end], self.lever), self.lever);
        let precision = PRECISION * self.options.gouge;
        self.depth_in(&sweep, 0, precision - self.options.gouge)
    }

    /// How deep the tool goes into a face during a span; at least so deep, where it does not keep `target`.
    fn depth_in(&self, sweep: &Sweep, span: usize, target: f64) -> f64 {
        let precision = PRECISION * self.options.gouge;
        let of = |(face, sheet): (&FaceIndex, &Sheet)| {
            let tool = &self.tool;
            let chart = &self.chart;
            let clearing = Clearing { face, chart, sheet, tool, target, precision };
            -clearing.least(sweep, span, 1)
        };
        self.faces.iter().zip(&self.sheets).map(of).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A face as cells for looking at leads.
fn sheet(face: &FaceIndex, chart: &Chart, cutter: &Cutter) -> Sheet {
    let region = super::face::guarded(face, chart);
    let sizes = super::guard::SIZES.map(|share| share * cutter.radius());
    Sheet::adaptive(face, chart, &region, sizes)
}

/// A station moved, attitude and all.
fn moved(station: &Station, by: &Vector3<f64>) -> Station {
    let pose = ToolPose { tip: station.pose.tip + by, axis: station.pose.axis };
    Station { pose, contact: station.contact + by }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_stretch_of_a_climb_is_run_at_the_feed() {
        let axis = Unit::new_normalize(Vector3::new(0.0, 0.6, 0.8));
        let at = |z: f64| {
            let tip = Point3::from(axis.scale(z));
            Station { pose: ToolPose { tip, axis }, contact: tip }
        };
        let (high, low) = split(vec![at(0.0), at(50.0)], 8.0);
        let (high, tip) = (high.unwrap(), |station: &Station| station.pose.tip.coords.norm());
        assert!((tip(&low[1]) - 8.0).abs() < 1e-12 && low.len() == 2);
        assert!((high[0].pose.tip - low[1].pose.tip).norm() < 1e-15);
        assert!((tip(&high[1]) - 50.0).abs() < 1e-12);
        assert!(split(vec![at(0.0), at(5.0)], 8.0).0.is_none());
    }
}
