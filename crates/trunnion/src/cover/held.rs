//! Locations of a lane that keep near to each other, so that the curve through them fits.

use super::lane::{Hold, Lane, Place, Placed, Reach};
use super::options::Method;
use super::split::{self, Part};
use crate::math::angle::angle_between;
use crate::positioning::{AxisCone, CutterLocation, ToolInclination};
use nalgebra::{Unit, UnitVector3};
use rayon::prelude::*;

/// Stations in a row that are solved one from the other; rows are independent, so that their
/// results do not depend on the number of threads.
const ROW: usize = 8;

/// Width of a neighbour's strip, over a station's own, from which on its location is worth trying.
const LEARN: f64 = 1.02;

/// How often the worst station is looked for again after neighbours were held to each other.
const ROUNDS: usize = 3;

/// Shares of the allowed turn that are tried: the less a location differs from its neighbours, the
/// better the curve between them fits.
const SHARES: [f64; 3] = [0.125, 0.5, 1.0];

/// A little more than half: of the difference of two neighbours, for what lies between them.
const HALF: f64 = 0.55;

/// What a location has to reach.
struct Goal<'a> {
    reach: Reach<'a>,
    least: f64,
}

impl Lane<'_> {
    /// Locations at `ways`, held to each other.
    ///
    /// The pass is to reach as far across as is worth the passes that finish the rest
    /// ([`split::advance`]). The station that just reaches that keeps its optimum. The others follow from
    /// it outwards on both sides: width beyond that reach is of no use, so each stays as near to its
    /// neighbour as it can while it reaches as far.
    pub(super) fn settle(&self, ways: &[f64], reach: Reach<'_>) -> Vec<Place> {
        let free = self.free_places(ways, self.options.lean);
        if self.method == Method::Inclined {
            return free;
        }
        let free = self.teach(ways, &free);
        let wanted = self.wanted(ways, &free, reach);
        let counts: Vec<bool> =
            free.iter().map(|p| p.as_ref().is_ok_and(|p| reach(p) >= wanted)).collect();
        let worst = |places: &[Place]| {
            let reaches = places.iter().zip(&counts).map(|(place, counts)| match place {
                Ok(placed) if *counts => reach(placed),
                _ => f64::INFINITY,
            });
            reaches.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let Some((mut seed, mut goal)) = worst(&free) else { return free };
        if !counts.get(seed).is_some_and(|counts| *counts) {
            return free;
        }
        let mut best: Option<(f64, Vec<Place>)> = None;
        for _ in 0..ROUNDS {
            let held = self.grow(ways, &free, seed, &Goal { reach, least: goal });
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

    /// How far across the pass is to reach.
    fn wanted(&self, ways: &[f64], places: &[Place], reach: Reach<'_>) -> f64 {
        let per = self.rate_across();
        let [_, last] = self.across_range;
        let width = |place: &Place| match place {
            Ok(placed) => (reach(placed).min(last) - self.across).max(0.0) * per,
            Err(_) => 0.0,
        };
        let over: Vec<Part> = ways
            .iter()
            .zip(places)
            .filter(|(way, _)| self.track.over_face(**way))
            .map(|(_, place)| Part { length: self.options.spacing[1], width: width(place) })
            .collect();
        let wanted = split::advance(&over, &self.costs());
        // A little less, so that rounding does not exclude the place itself.
        self.across + wanted * (1.0 - 1e-9) / per
    }

    /// Locations at `ways`, each for itself.
    pub(super) fn free_places(&self, ways: &[f64], lean: ToolInclination) -> Vec<Place> {
        let hold = self.free();
        ways.par_chunks(ROW)
            .flat_map_iter(|row| {
                let mut warm: Option<CutterLocation> = None;
                let places: Vec<Place> = row
                    .iter()
                    .map(|&way| {
                        let place = self.place(way, &hold, (warm.as_ref(), lean));
                        warm = place.as_ref().ok().map(|p| p.location.clone());
                        place
                    })
                    .collect();
                places
            })
            .collect()
    }

    /// Offers every station the location of its neighbours as a start, once along the track and once
    /// back, and keeps the wider result: wide strips lie in small valleys that a search from
    /// scratch may miss.
    fn teach(&self, ways: &[f64], places: &[Place]) -> Vec<Place> {
        let learn = |indices: &mut dyn Iterator<Item = usize>| {
            let mut learnt = vec![None; ways.len()];
            let mut before: Option<Placed> = None;
            for index in indices {
                let own = places[index].as_ref().ok();
                let width = |placed: &Placed| placed.location.strip_width;
                let least = own.map_or(0.0, width) * LEARN;
                let taught =
                    before.as_ref().filter(|teacher| width(teacher) > least).and_then(|teacher| {
                        self.place(
                            ways[index],
                            &self.free(),
                            (Some(&teacher.location), teacher.lean),
                        )
                        .ok()
                    });
                before = wider(own.cloned(), taught);
                learnt[index].clone_from(&before);
            }
            learnt
        };
        let (ahead, back) =
            rayon::join(|| learn(&mut (0..ways.len())), || learn(&mut (0..ways.len()).rev()));
        let both = ahead.into_iter().zip(back).map(|(a, b)| wider(a, b));
        both.zip(places).map(|(found, place)| found.map_or_else(|| place.clone(), Ok)).collect()
    }

    /// Holds every station to its neighbour nearer to `seed`.
    fn grow(&self, ways: &[f64], free: &[Place], seed: usize, goal: &Goal<'_>) -> Vec<Place> {
        let Some(Ok(start)) = free.get(seed) else { return free.to_vec() };
        let outwards = |indices: &mut dyn Iterator<Item = usize>| {
            let mut before = Some(start.clone());
            let mut places = Vec::new();
            for index in indices {
                // Beyond a gap the tool is lifted: nothing there need be near what was before.
                let place = match &before {
                    Some(before) => {
                        let limit = self.turn(before.way, ways[index]);
                        self.near(ways[index], Some(&free[index]), &[(before, limit)], goal)
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
            || outwards(&mut (seed + 1..ways.len())),
        );
        back.reverse();
        back.push(Ok(start.clone()));
        back.extend(ahead);
        back
    }

    /// The location nearest to its neighbours that reaches the goal; if none does, the one that
    /// reaches farthest. If none is near at all there is no location: the pass then ends with a
    /// run-out, or is placed otherwise; a jump would gouge on its way. `free` is the place without
    /// neighbours, where it was tried: what has no location then has none near anything.
    fn near(
        &self,
        way: f64,
        free: Option<&Place>,
        neighbours: &[(&Placed, f64)],
        goal: &Goal<'_>,
    ) -> Place {
        let free = free.map(Result::as_ref).transpose().map_err(Clone::clone)?;
        let at = |share: f64| {
            let near: Vec<_> = neighbours.iter().map(|(p, limit)| (*p, limit * share)).collect();
            let own = free.filter(|f| near.iter().all(|(p, l)| steady(p, f, *l))).cloned();
            let held =
                || neighbours.iter().find_map(|n| self.held(way, &self.hold(&near), n.0).ok());
            own.or_else(held)
        };
        let mut best: Option<(f64, Placed)> = None;
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
        best.map(|(_, found)| found).ok_or_else(|| self.apart(way))
    }

    /// A location at `way` with a neighbour on one side, as close to its optimum as that allows.
    pub(super) fn beside(&self, way: f64, neighbour: &Placed) -> Place {
        let hold = self.hold(&[(neighbour, self.turn(neighbour.way, way))]);
        self.place(way, &hold, (Some(&neighbour.location), neighbour.lean))
    }

    /// A location between two others that reaches about as far, for a finer pass.
    pub(super) fn between(&self, a: &Placed, b: &Placed, reach: Reach<'_>) -> Place {
        let way = 0.5 * (a.way + b.way);
        let turn = angle_between(&a.station.pose.axis, &b.station.pose.axis);
        let offset = (a.location.offset_direction - b.location.offset_direction).abs();
        // Divided by the least share, so that even then the ranges of both neighbours meet.
        let limit = self
            .turn(a.way, way)
            .max(self.turn(way, b.way))
            .max(HALF / SHARES[0] * turn.max(offset));
        let least = reach(a).min(reach(b));
        let goal = Goal { reach, least };
        self.near(way, None, &[(a, limit), (b, limit)], &goal)
            .or_else(|_| self.place(way, &self.free(), (Some(&a.location), a.lean)))
    }

    fn held(&self, way: f64, hold: &Hold, warm: &Placed) -> Place {
        // At the fixed lean a location between two on the lane is on it as well, or else it is looked for without
        // neighbours.
        if self.method == Method::Inclined && warm.across >= self.across {
            return self.stay(way, hold, (Some(&warm.location), warm.lean));
        }
        self.place(way, hold, (Some(&warm.location), warm.lean))
    }

    /// Ranges within `limit` of each neighbour; where these do not meet, halfway.
    fn hold(&self, neighbours: &[(&Placed, f64)]) -> Hold {
        let [least, most] = self.options.offset_range;
        let offset = |p: &Placed| p.location.offset_direction;
        let low = neighbours.iter().map(|(p, limit)| offset(p) - limit).fold(least, f64::max);
        let high = neighbours.iter().map(|(p, limit)| offset(p) + limit).fold(most, f64::min);
        let offset_range = [low.min(high), high.max(low)];
        let sum = neighbours.iter().map(|(p, _)| p.station.pose.axis.into_inner()).sum();
        let axis: Option<UnitVector3<f64>> = Unit::try_new(sum, f64::MIN_POSITIVE);
        let spread = |axis: &UnitVector3<f64>| {
            neighbours
                .iter()
                .map(|(p, limit)| limit - angle_between(axis, &p.station.pose.axis))
                .fold(f64::INFINITY, f64::min)
        };
        let axis_cone = axis.and_then(|axis| {
            let max_turn = spread(&axis);
            (max_turn > 0.0).then_some(AxisCone { axis, max_turn })
        });
        Hold { offset_range, axis_cone }
    }
}

/// Whether neighbours differ by at most `limit` \[rad\], both in axis and in offset direction.
fn steady(a: &Placed, b: &Placed, limit: f64) -> bool {
    let offset = (a.location.offset_direction - b.location.offset_direction).abs();
    offset <= limit && angle_between(&a.station.pose.axis, &b.station.pose.axis) <= limit
}

fn reach_at(places: &[Place], index: usize, reach: Reach<'_>) -> f64 {
    places.get(index).and_then(|p| p.as_ref().ok()).map_or(f64::INFINITY, reach)
}

/// The location with the wider strip; the first if they are equal.
fn wider(a: Option<Placed>, b: Option<Placed>) -> Option<Placed> {
    match (a, b) {
        (Some(a), Some(b)) if b.location.strip_width > a.location.strip_width => Some(b),
        (a, b) => a.or(b),
    }
}
