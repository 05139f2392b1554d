//! Axis smoothing: locations of a candidate pass that stay near to each other, so that the curve
//! through them fits.

use crate::cover::layout::advance::{self, PassPart};
use crate::cover::pattern::PlacementMethod;
use crate::cover::place::candidate::{
    CandidatePass, LocationLimits, LocationResult, LocationStart, PlacedStation, ReachFn,
};
use crate::math::angle::angle_between;
use crate::positioning::{AxisCone, CutterLocation, ToolInclination};
use crate::types::Interval;
use nalgebra::{Unit, UnitVector3};
use rayon::prelude::*;

/// Stations in a row that are solved one from the other. Rows are independent, so results do not
/// depend on the number of threads.
const ROW: usize = 8;

/// Least width of a neighbour's strip, over a station's own, at which its location is worth trying.
const LEARN: f64 = 1.02;

/// Rounds of choosing the worst station after neighbours were held to each other.
const ROUNDS: usize = 3;

/// Shares of the allowed turn that are tried. The less a location differs from its neighbours, the
/// better the curve between them fits.
const SHARES: [f64; 3] = [0.125, 0.5, 1.0];

/// Share of the difference of two neighbours that a location between them may use: a little more
/// than half.
const HALF: f64 = 0.55;

/// Station beside a location, and the largest turn from it \[rad\].
#[derive(Clone, Copy)]
struct Neighbour<'a> {
    station: &'a PlacedStation,
    limit: f64,
}

/// Parameter across that a location has to reach.
struct ReachGoal<'a> {
    reach: ReachFn<'a>,
    least: f64,
}

impl CandidatePass<'_> {
    /// Places stations at `arcs`, held to each other.
    ///
    /// The pass is to reach as far across as is worth the passes that finish the remainder
    /// ([`advance::advance`]). The station that just reaches that keeps its optimum. The others
    /// follow from it outwards on both sides: width beyond that reach is of no use, so each stays
    /// as near to its neighbour as it can while it reaches as far.
    pub(crate) fn held_stations(&self, arcs: &[f64], reach: ReachFn<'_>) -> Vec<LocationResult> {
        let free = self.free_places(arcs, self.lean());
        if self.method == PlacementMethod::Inclined {
            return free;
        }
        let free = self.teach(arcs, &free);
        let wanted = self.wanted(arcs, &free, reach);
        let counts: Vec<bool> =
            free.iter().map(|p| p.as_ref().is_ok_and(|p| reach(p) >= wanted)).collect();
        let worst = |places: &[LocationResult]| {
            // Only stations that reach far enough alone can set the goal; the others get passes of
            // their own.
            let reaches = places.iter().zip(&counts).map(|(place, counts)| match place {
                Ok(placed) if *counts => reach(placed),
                _ => f64::INFINITY,
            });
            reaches.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
        };
        // Grow from the worst station outwards; if another one is worse then, start again from
        // that.
        let Some((mut seed, mut goal)) = worst(&free) else { return free };
        if !counts.get(seed).is_some_and(|counts| *counts) {
            return free;
        }
        let mut best: Option<(f64, Vec<LocationResult>)> = None;
        for _ in 0..ROUNDS {
            let held = self.grow(arcs, &free, seed, &ReachGoal { reach, least: goal });
            let Some((next, least)) = worst(&held) else { break };
            if best.as_ref().is_none_or(|(before, _)| least > *before) {
                best = Some((least, held));
            }
            if next == seed {
                break;
            }
            (seed, goal) = (next, goal.min(reach_at(&free, next, reach)));
        }
        best.map_or(free, |(_, held)| held)
    }

    /// Returns the parameter across that the pass is to reach.
    fn wanted(&self, arcs: &[f64], places: &[LocationResult], reach: ReachFn<'_>) -> f64 {
        let per = self.rate_across();
        let [_, last] = self.across_range;
        let width = |place: &LocationResult| match place {
            Ok(placed) => (reach(placed).min(last) - self.across).max(0.0) * per,
            Err(_) => 0.0,
        };
        let over: Vec<PassPart> = arcs
            .iter()
            .zip(places)
            .filter(|(arc, _)| self.track.over_face(**arc))
            .map(|(_, place)| PassPart { length: self.options.spacing.high, width: width(place) })
            .collect();
        // Width with the least cost per millimetre gained, over the stations that lie on the face.
        let wanted = advance::advance(&over, &self.costs());
        // A little less, so that rounding does not exclude the station itself.
        self.across + wanted * (1.0 - 1e-9) / per
    }

    /// Places stations at `arcs`, each without regard to the others.
    pub(crate) fn free_places(&self, arcs: &[f64], lean: ToolInclination) -> Vec<LocationResult> {
        let limits = self.free();
        arcs.par_chunks(ROW)
            .flat_map_iter(|row| {
                let mut warm: Option<CutterLocation> = None;
                let places: Vec<LocationResult> = row
                    .iter()
                    .map(|&arc| {
                        let place =
                            self.place(arc, &limits, LocationStart { warm: warm.as_ref(), lean });
                        warm = place.as_ref().ok().map(|p| p.location.clone());
                        place
                    })
                    .collect();
                places
            })
            .collect()
    }

    /// Offers every station the location of its neighbours as initial guess, once along the track
    /// and once back, and keeps the wider result. Wide strips lie in small valleys that a search
    /// from scratch may miss.
    fn teach(&self, arcs: &[f64], places: &[LocationResult]) -> Vec<LocationResult> {
        let learn = |indices: &mut dyn Iterator<Item = usize>| {
            let mut learnt = vec![None; arcs.len()];
            let mut before: Option<PlacedStation> = None;
            for index in indices {
                let own = places[index].as_ref().ok();
                let width = |placed: &PlacedStation| placed.location.strip_width;
                // A search is worth its work only if the neighbour is clearly wider.
                let least = own.map_or(0.0, width) * LEARN;
                let taught =
                    before.as_ref().filter(|teacher| width(teacher) > least).and_then(|teacher| {
                        self.place(arcs[index], &self.free(), LocationStart::from(teacher)).ok()
                    });
                before = wider(own.cloned(), taught);
                learnt[index].clone_from(&before);
            }
            learnt
        };
        let (ahead, back) =
            rayon::join(|| learn(&mut (0..arcs.len())), || learn(&mut (0..arcs.len()).rev()));
        let both = ahead.into_iter().zip(back).map(|(a, b)| wider(a, b));
        both.zip(places).map(|(found, place)| found.map_or_else(|| place.clone(), Ok)).collect()
    }

    /// Holds every station to its neighbour nearer to `seed`.
    fn grow(
        &self,
        arcs: &[f64],
        free: &[LocationResult],
        seed: usize,
        goal: &ReachGoal<'_>,
    ) -> Vec<LocationResult> {
        let Some(Ok(start)) = free.get(seed) else { return free.to_vec() };
        let outwards = |indices: &mut dyn Iterator<Item = usize>| {
            let mut before = Some(start.clone());
            let mut places = Vec::new();
            for index in indices {
                // Beyond a gap the tool is lifted, so nothing there need be near the stations
                // before.
                let place = match &before {
                    Some(before) => {
                        let limit = self.turn(before.arc, arcs[index]);
                        self.near(
                            arcs[index],
                            Some(&free[index]),
                            &[Neighbour { station: before, limit }],
                            goal,
                        )
                    }
                    None => free[index].clone(),
                };
                before = place.as_ref().ok().cloned();
                places.push(place);
            }
            places
        };
        let (mut back, ahead) = rayon::join(
            || outwards(&mut (0..seed).rev()),
            || outwards(&mut (seed + 1..arcs.len())),
        );
        back.reverse();
        back.push(Ok(start.clone()));
        back.extend(ahead);
        back
    }

    /// Returns the location nearest to its neighbours that reaches the goal; if none does, the one
    /// that reaches farthest.
    ///
    /// If none is near at all, there is no location: the pass then ends with a run-out, or is
    /// placed otherwise, since the tool would gouge while it jumps. `free` is the location without
    /// neighbours, if it was tried; a station without any has none near its neighbours either.
    fn near(
        &self,
        arc: f64,
        free: Option<&LocationResult>,
        neighbours: &[Neighbour<'_>],
        goal: &ReachGoal<'_>,
    ) -> LocationResult {
        let free = free.map(Result::as_ref).transpose().map_err(Clone::clone)?;
        let at = |share: f64| {
            let near: Vec<_> = neighbours
                .iter()
                .map(|one| Neighbour { limit: one.limit * share, ..*one })
                .collect();
            let own = free.filter(|f| near.iter().all(|one| steady(one.station, f, one.limit)));
            let held = || {
                let limits = self.limits(&near);
                neighbours.iter().find_map(|one| self.held(arc, &limits, one.station).ok())
            };
            own.cloned().or_else(held)
        };
        let mut best: Option<(f64, PlacedStation)> = None;
        for share in SHARES {
            let Some(found) = at(share) else { continue };
            let reach = (goal.reach)(&found);
            if reach >= goal.least {
                return Ok(found);
            }
            if best.as_ref().is_none_or(|(before, _)| reach > *before) {
                best = Some((reach, found));
            }
        }
        best.map(|(_, found)| found).ok_or_else(|| self.apart(arc))
    }

    /// Places a station at `arc` beside one neighbour, as close to its optimum as the neighbour
    /// allows.
    pub(crate) fn beside(&self, arc: f64, neighbour: &PlacedStation) -> LocationResult {
        let limits =
            self.limits(&[Neighbour { station: neighbour, limit: self.turn(neighbour.arc, arc) }]);
        self.place(arc, &limits, LocationStart::from(neighbour))
    }

    /// Places a station between two others that reaches about as far, for a finer pass.
    pub(crate) fn between(
        &self,
        a: &PlacedStation,
        b: &PlacedStation,
        reach: ReachFn<'_>,
    ) -> LocationResult {
        let arc = 0.5 * (a.arc + b.arc);
        let turn = angle_between(&a.station.pose.axis, &b.station.pose.axis);
        let offset = (a.location.offset_direction - b.location.offset_direction).abs();
        // Divided by the least share, so that the ranges of both neighbours meet even then.
        let limit = self
            .turn(a.arc, arc)
            .max(self.turn(arc, b.arc))
            .max(HALF / SHARES[0] * turn.max(offset));
        let least = reach(a).min(reach(b));
        let goal = ReachGoal { reach, least };
        self.near(arc, None, &[a, b].map(|station| Neighbour { station, limit }), &goal)
            .or_else(|_| self.place(arc, &self.free(), LocationStart::from(a)))
    }

    fn held(&self, arc: f64, limits: &LocationLimits, warm: &PlacedStation) -> LocationResult {
        // At the fixed inclination a location between two on the track is on it as well; otherwise
        // it is searched without neighbours.
        if self.method == PlacementMethod::Inclined && warm.across >= self.across {
            return self.place_on_track(arc, limits, LocationStart::from(warm));
        }
        self.place(arc, limits, LocationStart::from(warm))
    }

    /// Returns the limits within the reach of each neighbour; where their ranges do not meet, halfway.
    fn limits(&self, neighbours: &[Neighbour<'_>]) -> LocationLimits {
        let [least, most] = self.options.offset_range.ends();
        let offset = |one: &Neighbour<'_>| one.station.location.offset_direction;
        let low = neighbours.iter().map(|one| offset(one) - one.limit).fold(least, f64::max);
        let high = neighbours.iter().map(|one| offset(one) + one.limit).fold(most, f64::min);
        // Ranges that do not meet: the gap between them, which lies halfway.
        let offset_range = Interval::new(low.min(high), high.max(low));
        // The cone about the mean axis that lies in the cones of all neighbours.
        let pose_axis = |one: &Neighbour<'_>| one.station.station.pose.axis;
        let sum = neighbours.iter().map(|one| pose_axis(one).into_inner()).sum();
        let axis: Option<UnitVector3<f64>> = Unit::try_new(sum, f64::MIN_POSITIVE);
        // A cone about another axis that lies in a given cone is narrower by the angle between both
        // axes.
        let spread = |axis: &UnitVector3<f64>| {
            neighbours
                .iter()
                .map(|one| one.limit - angle_between(axis, &pose_axis(one)))
                .fold(f64::INFINITY, f64::min)
        };
        let axis_cone = axis.and_then(|axis| {
            let max_turn = spread(&axis);
            (max_turn > 0.0).then_some(AxisCone { axis, max_turn })
        });
        LocationLimits { offset_range, axis_cone }
    }
}

/// Returns `true` if neighbours differ by at most `limit` \[rad\], both in axis and in offset
/// direction.
fn steady(a: &PlacedStation, b: &PlacedStation, limit: f64) -> bool {
    let offset = (a.location.offset_direction - b.location.offset_direction).abs();
    offset <= limit && angle_between(&a.station.pose.axis, &b.station.pose.axis) <= limit
}

fn reach_at(places: &[LocationResult], index: usize, reach: ReachFn<'_>) -> f64 {
    places.get(index).and_then(|p| p.as_ref().ok()).map_or(f64::INFINITY, reach)
}

/// Returns the location with the wider strip; the first if they are equal.
fn wider(a: Option<PlacedStation>, b: Option<PlacedStation>) -> Option<PlacedStation> {
    match (a, b) {
        (Some(a), Some(b)) if b.location.strip_width > a.location.strip_width => Some(b),
        (a, b) => a.or(b),
    }
}
