//! One pass before it is trimmed: cutter locations along an iso-parametric end-point track.

use super::options::{Along, CoverOptions, Method};
use super::region::Local;
use super::track::Track;
use crate::cutter::Cutter;
use crate::math::angle::angle_between;
use crate::positioning::{
    AxisNear, Location, PositioningError, Request, StripSide, inclined, widest,
};
use crate::surface::FaceIndex;
use crate::types::{Station, ToolPose};
use nalgebra::{Unit, UnitVector3};
use rayon::prelude::*;

/// Stations in a row that are solved one from the other; rows are independent, so that their
/// results do not depend on the number of threads.
const ROW: usize = 8;

/// How often the worst station is looked for again after neighbours were held to each other.
const ROUNDS: usize = 3;

/// A track with everything needed to place the tool along it.
pub(super) struct Lane<'a> {
    pub(super) face: &'a FaceIndex,
    pub(super) cutter: &'a Cutter,
    pub(super) options: &'a CoverOptions,
    pub(super) across: f64,
    pub(super) track: Track,
    /// Whether the feed is towards growing parameters.
    pub(super) forward: bool,
    /// How the tool is placed along this lane.
    pub(super) method: Method,
}

/// A cutter location of a lane.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    /// Arc length along the track \[mm\].
    pub(super) way: f64,
    /// Parameters across and along.
    pub(super) across: f64,
    pub(super) along: f64,
    pub(super) location: Location,
    pub(super) station: Station,
    /// Parameters of the station's contact.
    pub(super) contact_uv: [f64; 2],
}

impl Placed {
    /// Where the strip ends, across and along.
    pub(super) fn far(&self, chart: Along) -> Local {
        chart.local(self.location.far)
    }
}

/// What keeps a location near its neighbours.
#[derive(Debug, Clone, Copy)]
struct Hold {
    offset_range: [f64; 2],
    axis_near: Option<AxisNear>,
}

/// A place of a lane: the location found, or why there is none.
pub(super) type Place = Result<Placed, PositioningError>;

impl Lane<'_> {
    /// Side of the feed on which the strip lies so that it is on the side of growing `across`.
    ///
    /// Along V: `S_v x (S_u x S_v)` is on the +u side; along U, `S_u x (S_u x S_v)` on the -v side.
    pub(super) fn strip(&self) -> StripSide {
        let right = match self.options.along {
            Along::V => self.forward,
            Along::U => !self.forward,
        };
        if right == self.face.face().flip { StripSide::Left } else { StripSide::Right }
    }

    fn request(&self, along: f64, hold: &Hold) -> Request<'_> {
        let chart = self.options.along;
        Request {
            face: self.face,
            cutter: self.cutter,
            band: self.options.band,
            at: chart.uv([self.across, along]),
            feed: chart.uv([0.0, if self.forward { 1.0 } else { -1.0 }]),
            strip: self.strip(),
            side: self.options.side,
            offset_range: hold.offset_range,
            axis_near: hold.axis_near,
        }
    }

    fn free(&self) -> Hold {
        Hold { offset_range: self.options.offset_range, axis_near: None }
    }

    fn place(&self, way: f64, hold: &Hold, warm: Option<&Location>) -> Place {
        let along = self.track.at(way);
        let request = self.request(along, hold);
        let location = match self.method {
            Method::Widest => widest(&request, warm)?,
            Method::Inclined => inclined(&request, self.options.lead, warm)?,
        };
        let (station, contact_uv) = self.station(request.at, &location)?;
        Ok(Placed { way, across: self.across, along, location, station, contact_uv })
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
            .map_or_else(nalgebra::Vector3::zeros, |unit| unit.scale(self.cutter.major()));
        let guess = location.contact_uv;
        let foot = self
            .face
            .closest_near(&(location.center + out), guess)
            .map_err(|error| PositioningError::Closest { uv: guess, error })?;
        Ok((Station { pose: location.pose, contact: foot.point }, foot.uv))
    }

    /// Limit of turns over `distance` \[rad\].
    fn turn(&self, distance: f64) -> f64 {
        self.options.max_axis_turn * distance.abs()
    }

    /// Whether neighbours turn no faster than allowed, both the axis and the offset direction.
    pub(super) fn steady(&self, a: &Placed, b: &Placed) -> bool {
        let limit = self.turn(b.way - a.way);
        let offset = (a.location.offset_direction - b.location.offset_direction).abs();
        offset <= limit && angle_between(&a.station.pose.axis, &b.station.pose.axis) <= limit
    }

    /// Locations at `ways`, each as wide as it can be while neighbours are held to each other.
    ///
    /// The station where the strip reaches least far across decides where the next pass lies, so it
    /// keeps its optimum, and the others follow from it outwards on both sides.
    pub(super) fn settle(&self, ways: &[f64], reach: &dyn Fn(&Placed) -> f64) -> Vec<Place> {
        let free = self.free_places(ways);
        if self.method == Method::Inclined {
            return free;
        }
        let worst = |places: &[Place]| {
            let reaches = places.iter().map(|p| p.as_ref().map_or(f64::INFINITY, reach));
            reaches.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let free = self.teach(ways, &free);
        let Some((mut seed, _)) = worst(&free) else { return free };
        let mut best: Option<(f64, Vec<Place>)> = None;
        for _ in 0..ROUNDS {
            let held = self.grow(ways, &free, seed);
            let Some((next, least)) = worst(&held) else { break };
            if best.as_ref().is_none_or(|(before, _)| least > *before) {
                best = Some((least, held));
            }
            if next == seed {
                break;
            }
            seed = next;
        }
        best.map_or(free, |(_, held)| held)
    }

    fn free_places(&self, ways: &[f64]) -> Vec<Place> {
        let hold = self.free();
        ways.par_chunks(ROW)
            .flat_map_iter(|row| {
                let mut warm: Option<Location> = None;
                let places: Vec<Place> = row
                    .iter()
                    .map(|&way| {
                        let place = self.place(way, &hold, warm.as_ref());
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
                let taught = before.as_ref().and_then(|teacher| {
                    self.place(ways[index], &self.free(), Some(&teacher.location)).ok()
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
    fn grow(&self, ways: &[f64], free: &[Place], seed: usize) -> Vec<Place> {
        let Some(Ok(start)) = free.get(seed) else { return free.to_vec() };
        let outwards = |indices: &mut dyn Iterator<Item = usize>| {
            let mut before = start.clone();
            let mut places = Vec::new();
            for index in indices {
                let place = self.follow(ways[index], &free[index], &before);
                if let Ok(placed) = &place {
                    before = placed.clone();
                }
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

    /// The free location if it is near enough to the one `before`, or the widest that is.
    fn follow(&self, way: f64, free: &Place, before: &Placed) -> Place {
        if let Ok(placed) = free
            && self.steady(before, placed)
        {
            return free.clone();
        }
        let limit = self.turn(way - before.way);
        let hold = self.hold(&[(before, limit)]);
        self.held(way, &hold, before).or_else(|_| free.clone())
    }

    /// A location at `way` with a neighbour on one side, as close to its optimum as that allows.
    pub(super) fn beside(&self, way: f64, neighbour: &Placed) -> Place {
        let hold = self.hold(&[(neighbour, self.turn(way - neighbour.way))]);
        self.held(way, &hold, neighbour)
    }

    /// A location between two others, for a finer pass.
    pub(super) fn between(&self, a: &Placed, b: &Placed) -> Place {
        let way = 0.5 * (a.way + b.way);
        let limit = self.turn(0.5 * (b.way - a.way));
        let hold = self.hold(&[(a, limit), (b, limit)]);
        self.held(way, &hold, a).or_else(|_| self.place(way, &self.free(), Some(&a.location)))
    }

    fn held(&self, way: f64, hold: &Hold, warm: &Placed) -> Place {
        self.place(way, hold, Some(&warm.location)).or_else(|error| {
            let wider = Hold { axis_near: None, ..*hold };
            self.place(way, &wider, Some(&warm.location)).map_err(|_| error)
        })
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

/// The location with the wider strip; the first if they are equal.
fn wider(a: Option<Placed>, b: Option<Placed>) -> Option<Placed> {
    match (a, b) {
        (Some(a), Some(b)) if b.location.strip_width > a.location.strip_width => Some(b),
        (a, b) => a.or(b),
    }
}
