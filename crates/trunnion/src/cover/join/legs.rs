//! Joins passes to a whole program of motions.

use super::hop::{HopOptions, HopPath};
use super::leads::{ClearLevel, LinkPlanner, PRECISION, PassEnd, moved};
use super::request::LinkRequest;
use super::step::continues;
use crate::cover::error::CoverError;
use crate::cover::join::axis_reach::AxisReach;
use crate::cover::prove::sweep::PassSweep;
use crate::types::{Leg, Motion, Pass, Progress, Stage, Station};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

/// Least cosine between tool axis and plane normal for links over the plane \[60 deg\]. At larger angles, leads along
/// the tool axis are longer than twice the height that they gain, and flank and holder come close to the plane.
const UPRIGHT: f64 = 0.5;

/// Joins passes: down to the first, along it, over to the next, and up from the last. Passes are run in
/// the order and direction given.
///
/// From pass to pass the tool steps along the face or hops if [`LinkRequest::hops`] allows it and that is quicker.
/// Otherwise it goes up by a lead, over at a height where it may turn, and down again. Each step, hop and lead is proven to keep off all faces,
/// with the whole tool up to the gauge point. If a lead along the tool axis gouges, one inclined towards
/// [`LinkOptions::up`](super::request::LinkOptions::up) is taken.
///
/// If no lead reaches the plane over the part, or the tool would be nearly parallel to it, as on the sides of a
/// shaft, leads end above the part as seen along the tool axis. A curve around the part links them. The tool axis turns
/// along it, and its clearance is proven likewise.
///
/// # Errors
///
/// [`CoverError::LeadGouges`] if every lead gouges or gains no height, [`CoverError::NoWayRound`] if no link around
/// the part is free, [`CoverError::Cancelled`] on request.
///
/// # Example
///
/// A pass of 10 mm on a plane: one lead down, the cut, one lead up.
///
/// ```
/// use nalgebra::{Point3, Vector3};
/// use trunnion::cover::{LinkOptions, LinkRequest, legs};
/// use trunnion::cutter::{Cutter, CutterSpec};
/// use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
/// use trunnion::types::{Motion, Pass, Silent, Station, ToolPose, Uv};
///
/// let points = [0.0, 20.0].map(|x| [0.0, 20.0].map(|y| Point3::new(x, y, 0.0)).to_vec()).to_vec();
/// let knots = [vec![0.0, 0.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
/// let plane = Surface::Nurbs(NurbsSurface::new([1, 1], knots, points, None)?);
/// let faces = [FaceIndex::new(Face::new(1, plane, Vec::new())?)?];
///
/// let spec = CutterSpec { length: 60.0, ..CutterSpec::ball(10.0) };
/// let cutter = Cutter::new(spec).expect("a ball of radius 5 mm");
/// let station = |x: f64| {
///     let tip = Point3::new(x, 10.0, 0.0);
///     Station { pose: ToolPose { tip, axis: Vector3::z_axis() }, contact: tip }
/// };
/// let stations = vec![station(5.0), station(15.0)];
/// let track = vec![Uv::new(0.25, 0.5), Uv::new(0.75, 0.5)];
/// let passes = [Pass { face: 1, stations, widths: vec![2.0; 2], track }];
/// let boxes = vec![[Point3::origin(), Point3::new(20.0, 20.0, 0.0)]];
/// let options = LinkOptions { gouge: 0.01, ..LinkOptions::above(Vector3::z_axis(), boxes, 30.0) };
///
/// let legs = legs(&LinkRequest::new(&passes, &faces, &cutter, &options), &Silent)?;
/// let motions: Vec<Motion> = legs.iter().map(|leg| leg.motion).collect();
/// assert_eq!(motions, [Motion::LeadIn, Motion::Cut, Motion::LeadOut]);
/// // The lead starts at the clearance of 30 mm and a radius above it.
/// assert_eq!(legs[0].stations[0].pose.tip.z, 35.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn legs(request: &LinkRequest<'_>, progress: &dyn Progress) -> Result<Vec<Leg>, CoverError> {
    let JoinedPasses { legs, left_out } = join(request, progress)?;
    left_out.into_iter().next().map_or(Ok(legs), |one| Err(one.why))
}

/// Legs of all passes that can be joined, and the passes that cannot.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JoinedPasses {
    /// Legs, as of [`legs`].
    pub legs: Vec<Leg>,
    /// Passes that are left out, by their indices.
    pub left_out: Vec<PassLeftOut>,
}

/// Pass that no lead or link connects with the others.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PassLeftOut {
    /// Index of the pass.
    pub index: usize,
    /// Reason: [`CoverError::LeadGouges`] or [`CoverError::NoWayRound`].
    pub why: CoverError,
}

/// Joins passes as [`legs`] does, but leaves out those that have no leads, or no link from the pass before.
///
/// [`without`](super::super::without) measures what they leave.
///
/// # Errors
///
/// [`CoverError::Cancelled`] on request.
pub fn join(
    request: &LinkRequest<'_>,
    progress: &dyn Progress,
) -> Result<JoinedPasses, CoverError> {
    let planner = LinkPlanner::new(request);
    let passes = request.passes;
    let done = AtomicU64::new(0);
    let total = passes.len() as u64;
    let mut left_out: BTreeMap<usize, CoverError> = BTreeMap::new();
    let mut joins: BTreeMap<PassPair, Vec<Leg>> = BTreeMap::new();
    let pairs = loop {
        // One join before each pass, and one after the last; where a pass was left out, its neighbours are joined.
        let pairs = pairs((0..passes.len()).filter(|index| !left_out.contains_key(index)));
        let open: Vec<PassPair> =
            pairs.iter().filter(|pair| !joins.contains_key(*pair)).copied().collect();
        if open.is_empty() {
            break pairs;
        }
        let found = open.into_par_iter().map(|pair| {
            progress.step(Stage::Cover, done.fetch_add(1, Ordering::Relaxed).min(total), total)?;
            let numbered = |index: usize| Some(NumberedPass { index, pass: passes.get(index)? });
            let [before, next] = pair.map(|index| index.and_then(numbered));
            let legs = planner.between(before, next, request.hops.as_ref(), request.reach.as_ref());
            Ok((pair, legs))
        });
        for (pair, legs) in found.collect::<Result<Vec<_>, CoverError>>()? {
            match legs {
                Ok(legs) => _ = joins.insert(pair, legs),
                Err(PassLeftOut { index, why }) => _ = left_out.entry(index).or_insert(why),
            }
        }
    };
    let legs = assembled(passes, &pairs, joins);
    let left_out = left_out.into_iter().map(|(index, why)| PassLeftOut { index, why }).collect();
    Ok(JoinedPasses { legs, left_out })
}

/// Indices of two passes, one after the other; none before the first and after the last.
type PassPair = [Option<usize>; 2];

/// Returns each pass with the next.
fn pairs(kept: impl Iterator<Item = usize> + Clone) -> Vec<PassPair> {
    let before = std::iter::once(None).chain(kept.clone().map(Some));
    let next = kept.map(Some).chain(std::iter::once(None));
    before.zip(next).map(|(before, next)| [before, next]).collect()
}

/// Returns the legs of passes and the joins between them in the order they are run.
fn assembled(
    passes: &[Pass],
    pairs: &[PassPair],
    mut joins: BTreeMap<PassPair, Vec<Leg>>,
) -> Vec<Leg> {
    let mut legs: Vec<Leg> = Vec::new();
    for pair in pairs {
        let join = joins.remove(pair).unwrap_or_default();
        // A pass that continues the one before begins exactly where that ended.
        let end = legs.last().filter(|_| join.is_empty()).and_then(|leg| leg.stations.last());
        let end = end.copied();
        legs.extend(join);
        let pass = pair[1].and_then(|index| passes.get(index));
        let mut cut = pass.map(|pass| Leg { motion: Motion::Cut, stations: pass.stations.clone() });
        if let (Some(end), Some(first)) =
            (end, cut.as_mut().and_then(|cut| cut.stations.first_mut()))
        {
            *first = end;
        }
        legs.extend(cut);
    }
    legs
}

/// Leads of two passes, and the link between their ends.
#[derive(Default)]
struct PassJoin {
    up: Vec<Station>,
    link: Vec<Station>,
    down: Vec<Station>,
}

/// Pass with its index.
#[derive(Clone, Copy)]
struct NumberedPass<'a> {
    index: usize,
    pass: &'a Pass,
}

impl NumberedPass<'_> {
    /// Leaves out the pass, all of whose leads gouge, by `depth` \[mm\] or more.
    fn without_lead(self, depth: f64) -> PassLeftOut {
        let Self { index, pass } = self;
        PassLeftOut { index, why: CoverError::LeadGouges { pass: index, face: pass.face, depth } }
    }

    /// Leaves out the pass, to which no link leads from the pass before.
    fn without_link(self) -> PassLeftOut {
        let Self { index, pass } = self;
        PassLeftOut { index, why: CoverError::NoWayRound { pass: index, face: pass.face } }
    }
}

/// Lead that is divided into its upper part, if there is any, and its lower part.
struct SplitLead {
    high: Option<Vec<Station>>,
    low: Vec<Station>,
}

impl LinkPlanner<'_> {
    /// Plans the legs from one pass to the next; without one of them, from or to the height of the links.
    fn between(
        &self,
        before: Option<NumberedPass<'_>>,
        next: Option<NumberedPass<'_>>,
        hops: Option<&HopOptions<'_>>,
        reach: Option<&AxisReach<'_>>,
    ) -> Result<Vec<Leg>, PassLeftOut> {
        if let (Some(before), Some(next), Some(hops)) = (before, next, hops) {
            let passes = [before.pass, next.pass];
            if continues(passes) {
                return Ok(Vec::new());
            }
            if let Some(leg) = self.short_link(passes, hops, reach) {
                return Ok(vec![leg]);
            }
        }
        let PassJoin { up, link, down } = match (before, next) {
            (Some(before), Some(next)) => self.join(before, next, reach)?,
            (Some(before), None) => {
                PassJoin { up: self.lead_alone(before, PassEnd::Last)?, ..PassJoin::default() }
            }
            (None, Some(next)) => {
                PassJoin { down: self.lead_alone(next, PassEnd::First)?, ..PassJoin::default() }
            }
            (None, None) => PassJoin::default(),
        };
        let mut legs = Vec::new();
        if before.is_some() {
            let SplitLead { high, low } = split(up, self.options.approach);
            legs.push(Leg { motion: Motion::LeadOut, stations: low });
            legs.extend(high.map(|stations| Leg { motion: Motion::Link, stations }));
        }
        if link.len() > 1 {
            legs.push(Leg { motion: Motion::Link, stations: link });
        }
        if next.is_some() {
            let SplitLead { high, low } = split(down, self.options.approach);
            let link = high.map(|high| Leg { motion: Motion::Link, stations: reversed(high) });
            legs.extend(link);
            legs.push(Leg { motion: Motion::LeadIn, stations: reversed(low) });
        }
        Ok(legs)
    }

    /// Plans a link close to the faces, if it is quicker than one over the part: the quicker of a step and a hop.
    fn short_link(
        &self,
        passes: [&Pass; 2],
        hops: &HopOptions<'_>,
        reach: Option<&AxisReach<'_>>,
    ) -> Option<Leg> {
        let from = passes[0].stations.last()?;
        let to = passes[1].stations.first()?;
        if !reach.is_none_or(|reach| reach.holds(&[from.pose.axis, to.pose.axis])) {
            return None;
        }
        let over = [self.shortest(from), self.shortest(to)].map(|end| end.map(|s| s.pose));
        let leads = hops.feed.map_or(0.0, |feed| 2.0 * self.options.approach / feed);
        let hop = HopPath { from, to, over, lever: self.lever, leads };
        let step = self.step(passes, hops, hop.link_time(hops));
        // A step that is quicker than the lowest hop spares the proof of hops.
        let step = match step {
            Some((time, stations)) if time < hop.least_time(hops) => {
                return Some(Leg { motion: Motion::Step, stations });
            }
            step => step,
        };
        // The proof is short of its target by the precision at most: ask for that much more.
        let margin = PRECISION * self.options.gouge.abs();
        let free = |sweep: &PassSweep, span, least: f64| {
            self.depth_in(sweep, span, least + margin) <= -least
        };
        let hop = hop.find(hops, free, self.options.gouge);
        match (step, hop) {
            (Some((time, stations)), hop)
                if hop.as_ref().is_none_or(|hop| time < hops.time(hop)) =>
            {
                Some(Leg { motion: Motion::Step, stations })
            }
            (_, hop) => hop.map(|stations| Leg { motion: Motion::Hop, stations }),
        }
    }

    /// Plans the lead at an end of the program.
    fn lead_alone(&self, of: NumberedPass<'_>, end: PassEnd) -> Result<Vec<Station>, PassLeftOut> {
        let [first, second] =
            self.order(&[station_at(of.pass, end)]).map(|level| self.lead(of.pass, end, level));
        first.or_else(|depth| second.map_err(|other| of.without_lead(depth.max(other))))
    }

    /// Joins two passes over the plane if both have leads to it, otherwise around the part.
    ///
    /// The order is reversed if the tool would be nearly parallel to the plane.
    fn join(
        &self,
        one: NumberedPass<'_>,
        next: NumberedPass<'_>,
        reach: Option<&AxisReach<'_>>,
    ) -> Result<PassJoin, PassLeftOut> {
        let ends = [station_at(one.pass, PassEnd::Last), station_at(next.pass, PassEnd::First)];
        let [first, second] = self.order(&ends);
        let by = |level| self.join_at(level, one, next, reach);
        by(first).or_else(|error| by(second).map_err(|_| error))
    }

    /// Returns the order in which levels are tried: the plane first if the tool is upright at all ends.
    fn order(&self, ends: &[Option<&Station>]) -> [ClearLevel; 2] {
        let mut climbs =
            ends.iter().flatten().map(|station| station.pose.axis.dot(&self.options.up));
        if climbs.all(|climb| climb >= UPRIGHT) {
            [ClearLevel::Plane, ClearLevel::Axis]
        } else {
            [ClearLevel::Axis, ClearLevel::Plane]
        }
    }

    /// Joins two passes at one level.
    fn join_at(
        &self,
        level: ClearLevel,
        one: NumberedPass<'_>,
        next: NumberedPass<'_>,
        reach: Option<&AxisReach<'_>>,
    ) -> Result<PassJoin, PassLeftOut> {
        let lead = |of: NumberedPass<'_>, end| {
            self.lead(of.pass, end, level).map_err(|depth| of.without_lead(depth))
        };
        let up = lead(one, PassEnd::Last)?;
        let down = lead(next, PassEnd::First)?;
        let link = match (up.last(), down.last()) {
            (Some(from), Some(to)) if level == ClearLevel::Plane => vec![*from, *to],
            (Some(from), Some(to)) if from.pose != to.pose => {
                self.around(from, to, reach).ok_or_else(|| next.without_link())?
            }
            _ => Vec::new(),
        };
        Ok(PassJoin { up, link, down })
    }
}

/// Divides a lead where its last straight part, the climb, is `approach` long.
fn split(mut up: Vec<Station>, approach: f64) -> SplitLead {
    let Some(&[foot, top]) = up.last_chunk::<2>() else {
        return SplitLead { high: None, low: up };
    };
    let climb = top.pose.tip - foot.pose.tip;
    if climb.norm() <= approach {
        return SplitLead { high: None, low: up };
    }
    let near = moved(&foot, &climb.scale(approach / climb.norm()));
    up.pop();
    up.push(near);
    SplitLead { high: Some(followed(&near, &top)), low: up }
}

/// Returns the stations of a straight way that the axes have to follow. Two stations alone are left to the machine, which
/// may then turn a rotary by whole turns: beside the part the tool would swing into it.
fn followed(from: &Station, to: &Station) -> Vec<Station> {
    let way = to.pose.tip - from.pose.tip;
    vec![*from, moved(from, &way.scale(0.5)), *to]
}

/// Returns the station at an end of a pass.
fn station_at(pass: &Pass, end: PassEnd) -> Option<&Station> {
    match end {
        PassEnd::First => pass.stations.first(),
        PassEnd::Last => pass.stations.last(),
    }
}

fn reversed(mut stations: Vec<Station>) -> Vec<Station> {
    stations.reverse();
    stations
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::ToolPose;
    use nalgebra::{Point3, Unit, Vector3};

    #[test]
    fn only_the_end_of_a_climb_is_run_at_the_feed() {
        let axis = Unit::new_normalize(Vector3::new(0.0, 0.6, 0.8));
        let at = |z: f64| {
            let tip = Point3::from(axis.scale(z));
            Station { pose: ToolPose { tip, axis }, contact: tip }
        };
        let SplitLead { high, low } = split(vec![at(0.0), at(50.0)], 8.0);
        let high = high.unwrap();
        let tip = |station: &Station| station.pose.tip.coords.norm();
        assert!((tip(&low[1]) - 8.0).abs() < 1e-12 && low.len() == 2);
        assert!((high[0].pose.tip - low[1].pose.tip).norm() < 1e-15);
        assert!((tip(&high[1]) - 29.0).abs() < 1e-12 && (tip(&high[2]) - 50.0).abs() < 1e-12);
        assert!(split(vec![at(0.0), at(5.0)], 8.0).high.is_none());
    }
}
