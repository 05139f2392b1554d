//! One pass before it is trimmed: cutter locations along an iso-parametric end-point track.

use super::chart::Chart;
use super::fit::{self, Spot};
use super::guard::Around;
use super::options::{CoverOptions, Method};
use super::region::Local;
use super::split::{self, Costs, Part};
use super::track::Track;
use super::work::Work;
use crate::cutter::Cutter;
use crate::math::angle::angle_between;
use crate::positioning::{
    Active, AxisNear, Band, ContactSide, Lean, Location, PositioningError, Request, StripSide,
    leaning, widest,
};
use crate::surface::FaceIndex;
use crate::types::{Station, ToolPose};
use nalgebra::{Unit, UnitVector3, Vector3};
use rayon::prelude::*;

/// Stations in a row that are solved one from the other; rows are independent, so that their
/// results do not depend on the number of threads.
const ROW: usize = 8;

/// Width of a neighbour's strip, over a station's own, from which on its location is worth trying.
const LEARN: f64 = 1.02;

/// Length of the run-outs of a pass, in radii: both together, half of what they may be at most.
const RUN_OUTS: f64 = 1.0;

/// How often the worst station is looked for again after neighbours were held to each other.
const ROUNDS: usize = 3;

/// A track with everything needed to place the tool along it.
pub(super) struct Lane<'a> {
    pub(super) face: &'a FaceIndex,
    pub(super) cutter: &'a Cutter,
    pub(super) options: &'a CoverOptions,
    pub(super) chart: &'a Chart,
    pub(super) across: f64,
    /// Range of the region across.
    pub(super) across_range: [f64; 2],
    pub(super) track: Track,
    /// Whether the feed is towards growing parameters.
    pub(super) forward: bool,
    /// How the tool is placed along this lane.
    pub(super) method: Method,
    /// The other faces.
    pub(super) around: Around<'a>,
    pub(super) work: Work,
}

/// A cutter location of a lane.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    /// Arc length along the track \[mm\].
    pub(super) way: f64,
    /// Parameters across and along: across before the lane where the tool had to keep off something.
    pub(super) across: f64,
    pub(super) along: f64,
    /// How it leans, where that is given.
    pub(super) lean: Lean,
    pub(super) location: Location,
    pub(super) station: Station,
    /// Parameters of the station's contact.
    pub(super) contact_uv: [f64; 2],
}

impl Placed {
    /// Where the strip ends, across and along.
    pub(super) fn far(&self, chart: &Chart) -> Local {
        chart.local(self.location.far)
    }
}

/// What keeps a location near its neighbours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    offset_range: [f64; 2],
    axis_near: Option<AxisNear>,
}

/// How far across a location finishes the region; infinite where nothing is left beyond it.
pub(super) type Reach<'a> = &'a (dyn Fn(&Placed) -> f64 + Sync);

/// What a location has to reach.
struct Goal<'a> {
    reach: Reach<'a>,
    least: f64,
}

/// Shares of the allowed turn that are tried: the less a location differs from its neighbours, the
/// better the curve between them fits.
const SHARES: [f64; 3] = [0.125, 0.5, 1.0];

/// Turn of the tool axis allowed, over that of the face's normal between the same places: a tool that keeps its lean
/// turns as the normal does, a little before it or after it.
const FOLLOW: f64 = 1.5;

/// Turn \[rad\] between neighbouring places from which on the face is not followed: there its continuation has turned
/// over, as it does beyond a collapsed edge.
const OVER: f64 = std::f64::consts::FRAC_PI_4;

/// How far inside the face, as a share of the track, a step across has a direction: at a collapsed edge it has none.
const INSIDE: f64 = 1.0 / 64.0;

/// A little more than half: of the difference of two neighbours, for what lies between them.
const HALF: f64 = 0.55;

/// A place of a lane: the location found, or why there is none.
pub(super) type Place = Result<Placed, PositioningError>;

impl Lane<'_> {
    /// Side of the feed on which the strip lies so that it is on the side of growing `across`.
    ///
    /// With `f` along and `c` across, `f x (S_u x S_v)` is on the side of `c` where `(c, f)` turn as `(S_u, S_v)` do.
    pub(super) fn strip(&self) -> StripSide {
        let right = self.forward == self.chart.right_handed();
        if right == self.face.face().flip { StripSide::Left } else { StripSide::Right }
    }

    fn request(&self, at: Local, hold: &Hold) -> Request<'_> {
        let [_, step] = self.chart.steps(at);
        Request {
            face: self.face,
            cutter: self.cutter,
            band: self.options.band,
            at: self.chart.uv(at),
            feed: step.map(|s| if self.forward { s } else { -s }),
            strip: self.strip(),
            side: self.options.side,
            offset_range: hold.offset_range,
            axis_near: hold.axis_near,
        }
    }

    fn free(&self) -> Hold {
        Hold { offset_range: self.options.offset_range, axis_near: None }
    }

    fn place(&self, way: f64, hold: &Hold, (warm, lean): (Option<&Location>, Lean)) -> Place {
        if self.turned_over(way) {
            return Err(self.apart(way));
        }
        let fixed = self.method == Method::Inclined;
        if fixed {
            // Where not even the corner fits a strip before the lane nothing does, and that is soon seen.
            let back = self.costs().narrow / self.rate_across();
            self.corner_fits([self.across - back, self.track.at(way)])?;
        }
        let place = self.search([self.across, way], hold, (warm, lean));
        // What the machine does not get to was found at once; it gets no farther a little way back.
        let far = matches!(place, Err(PositioningError::OutOfReach { .. }));
        self.work.location(place.is_ok() || far);
        let barred = matches!(place, Err(PositioningError::Neighbour { .. }));
        match place {
            Err(error) if (fixed && !far) || barred => {
                self.pulled(way, hold, (warm, lean)).ok_or(error)
            }
            place => place,
        }
    }

    pub(super) fn search(
        &self,
        [across, way]: [f64; 2],
        hold: &Hold,
        (warm, lean): (Option<&Location>, Lean),
    ) -> Place {
        let along = self.track.at(way);
        let request = self.request([across, along], hold);
        let location = match self.method {
            Method::Widest => widest(&request, warm)?,
            Method::Inclined => leaning(&request, lean, warm)?,
        };
        self.around.clear(&location.pose, request.at)?;
        let (station, contact_uv) = self.station(request.at, &location)?;
        Ok(Placed { way, across, along, lean, location, station, contact_uv })
    }

    /// Whether the continued surface has turned over, as it does beyond a pole: steps across then lead the other way,
    /// and there is nothing to be placed on.
    fn turned_over(&self, way: f64) -> bool {
        let [start, end] = self.track.face();
        if self.track.over_face(way) {
            return false;
        }
        let across = |way: f64| self.steps(way)[0];
        let margin = INSIDE * (end - start);
        across(way).dot(&across(way.clamp(start + margin, end - margin))) <= 0.0
    }

    /// The location as a station. Its contact is the foot of the middle of the contact arc: unlike
    /// the points of tangency, of which there may be two or one, it moves smoothly along the pass.
    fn station(
        &self,
        at: [f64; 2],
        location: &Location,
    ) -> Result<(Station, [f64; 2]), PositioningError> {
        let ToolPose { axis, .. } = location.pose;
        let point = |uv: [f64; 2]| self.face.face().point(uv[0], uv[1]);
        let [from, to] = [point(at), point(location.end)];
        let middle = nalgebra::center(&from, &to) - location.center;
        let flat = middle - axis.scale(middle.dot(&axis));
        let out = Unit::try_new(flat, f64::MIN_POSITIVE)
            .map_or_else(Vector3::zeros, |unit| unit.scale(self.cutter.major()));
        let guess = location.contact_uv;
        let foot = self
            .face
            .closest_near(&(location.center + out), guess)
            .map_err(|error| PositioningError::Closest { uv: guess, error })?;
        Ok((Station { pose: location.pose, contact: foot.point }, foot.uv))
    }

    /// Limit of turns between two places of the track \[rad\]: the one asked for, but what the face itself turns
    /// is allowed, or no tool could follow an edge that is rounded more sharply.
    pub(super) fn turn(&self, from: f64, to: f64) -> f64 {
        let normal = |way: f64| {
            let [u, v] = self.chart.uv([self.across, self.track.at(way)]);
            self.face.face().surface.jet1(u, v).normal()
        };
        let follow = match (normal(from), normal(to)) {
            (Some(a), Some(b)) => FOLLOW * angle_between(&a, &b),
            _ => 0.0,
        };
        let follow = if follow < OVER { follow } else { 0.0 };
        (self.options.max_axis_turn * (to - from).abs()).max(follow)
    }

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

    /// Length of a step across by the parameter, in the middle of the track \[mm\].
    pub(super) fn rate_across(&self) -> f64 {
        let [start, end] = self.track.face();
        self.steps(0.5 * (start + end))[0].norm().max(f64::MIN_POSITIVE)
    }

    /// Steps on the face by one across and one along, at a place of the track.
    fn steps(&self, way: f64) -> [Vector3<f64>; 2] {
        let at = [self.across, self.track.at(way)];
        let [u, v] = self.chart.uv(at);
        let jet = self.face.face().surface.jet1(u, v);
        self.chart.steps(at).map(|[du, dv]| jet.su * du + jet.sv * dv)
    }

    /// How far the pass has to be run out so that its strips leave the face \[mm\]: how far they reach ahead
    /// of or behind the track, tried at its ends and its middle; the cutter's radius where that fails.
    pub(super) fn extension(&self) -> f64 {
        const RESERVE: f64 = 1.5;
        let [start, end] = self.track.face();
        let hold = self.free();
        let of = |way: f64| {
            let placed = self.place(way, &hold, (None, self.options.lean)).ok()?;
            let [u, v] = self.chart.uv([self.across, placed.along]);
            let from = self.face.face().point(u, v);
            let [_, feed] = self.steps(way);
            let feed = Unit::try_new(feed, f64::MIN_POSITIVE)?;
            let Location { near, far, .. } = placed.location;
            let ends = [near, far, placed.contact_uv]
                .map(|[u, v]| feed.dot(&(self.face.face().point(u, v) - from)).abs());
            Some(ends.into_iter().fold(0.0, f64::max))
        };
        let ways = [start, 0.5 * (start + end), end];
        let tried: Vec<Option<f64>> = ways.into_par_iter().map(of).collect();
        let most = tried.into_iter().try_fold(0.0, |most: f64, one| Some(most.max(one?)));
        let radius = self.cutter.radius();
        most.map_or(radius, |most| (RESERVE * most + self.options.spacing[1]).min(radius))
    }

    pub(super) fn costs(&self) -> Costs {
        costs(self.cutter, self.options)
    }

    /// A location for itself.
    pub(super) fn free_place(&self, way: f64, lean: Lean) -> Place {
        self.place(way, &self.free(), (None, lean))
    }

    /// The same, on the lane itself.
    pub(super) fn here(&self, way: f64, lean: Lean) -> Place {
        if self.turned_over(way) {
            return Err(self.apart(way));
        }
        // Of many leans few are expected to serve: one that does not counts as one that does.
        self.work.location(true);
        self.search([self.across, way], &self.free(), (None, lean))
    }

    /// Whether a lean serves at a place of the lane.
    pub(super) fn serves(&self, way: f64, lean: Lean) -> bool {
        !self.barred(way, lean) && self.here(way, lean).is_ok()
    }

    /// Whether the machine does not get to a tool whose corner touches on the lane, or that tool goes into another face by
    /// more than the width of a narrow strip: then one that touches beside it does so as well.
    fn barred(&self, way: f64, lean: Lean) -> bool {
        let uv = self.chart.uv([self.across, self.track.at(way)]);
        let [_, feed] = self.steps(way);
        let Some(spot) = Spot::new(self.face, uv) else { return false };
        let normal = spot.normal;
        let along = feed - normal.scale(normal.dot(&feed));
        let Some(along) = Unit::try_new(along, f64::MIN_POSITIVE) else { return false };
        let forward = along.scale(if self.forward { 1.0 } else { -1.0 });
        let behind = self.options.side == ContactSide::Behind;
        let ahead = if behind { -forward } else { forward };
        let beside = forward.cross(&normal).scale(self.strip().sign());
        let (sin, cos) = lean.towards.unwrap_or(0.0).sin_cos();
        let towards = ahead.scale(cos) + beside.scale(sin);
        let corner = spot.point + normal.scale(self.cutter.minor());
        let pose = fit::pose((corner, &normal), &towards, lean.angle, self.cutter);
        if !self.around.clock.reaches(&pose) {
            return true;
        }
        let deep = Around { least: self.around.least - self.costs().narrow, ..self.around };
        deep.clear(&pose, uv).is_err()
    }

    /// Locations at `ways`, each for itself.
    pub(super) fn free_places(&self, ways: &[f64], lean: Lean) -> Vec<Place> {
        let hold = self.free();
        ways.par_chunks(ROW)
            .flat_map_iter(|row| {
                let mut warm: Option<Location> = None;
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

    /// No location lies near enough to its neighbours.
    fn apart(&self, way: f64) -> PositioningError {
        PositioningError::NoStrip {
            uv: self.chart.uv([self.across, self.track.at(way)]),
            smallest: self.costs().narrow,
            excess: 0.0,
            binding: Active::AxisTurn,
        }
    }

    /// A location at `way` with a neighbour on one side, as close to its optimum as that allows.
    pub(super) fn beside(&self, way: f64, neighbour: &Placed) -> Place {
        self.held(way, &self.hold(&[(neighbour, self.turn(neighbour.way, way))]), neighbour)
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
        let axis_near = axis.and_then(|axis| {
            let max_turn = spread(&axis);
            (max_turn > 0.0).then_some(AxisNear { axis, max_turn })
        });
        Hold { offset_range, axis_near }
    }
}

/// What passes cost besides their length.
pub(super) fn costs(cutter: &Cutter, options: &CoverOptions) -> Costs {
    Costs { pass: options.link + RUN_OUTS * cutter.radius(), narrow: narrow(cutter, options) }
}

/// Width of a strip of a ball as wide as the cutter, on a plane \[mm\].
pub(super) fn narrow(cutter: &Cutter, options: &CoverOptions) -> f64 {
    let Band { lower, upper } = options.band;
    (8.0 * cutter.radius() * (upper - lower)).sqrt()
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
