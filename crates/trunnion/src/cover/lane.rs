//! One pass before it is trimmed: cutter locations along an iso-parametric end-point track.

use super::chart::Chart;
use super::fit::{self, Spot};
use super::guard::Around;
use super::options::{CoverOptions, Method};
use super::region::Local;
use super::split::Costs;
use super::track::Track;
use super::work::Work;
use crate::cutter::Cutter;
use crate::math::angle::angle_between;
use crate::positioning::{
    ActiveConstraint, AxisCone, ContactSide, CutterLocation, LocationRequest, PositioningError,
    StripSide, ToleranceBand, ToolInclination, widest_strip, with_inclination,
};
use crate::surface::FaceIndex;
use crate::types::{Station, ToolPose};
use nalgebra::{Unit, Vector3};
use rayon::prelude::*;

/// Length of the run-outs of a pass, in radii: both together, half of what they may be at most.
const RUN_OUTS: f64 = 1.0;

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
    pub(super) lean: ToolInclination,
    pub(super) location: CutterLocation,
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
    pub(super) offset_range: [f64; 2],
    pub(super) axis_cone: Option<AxisCone>,
}

/// How far across a location finishes the region; infinite where nothing is left beyond it.
pub(super) type Reach<'a> = &'a (dyn Fn(&Placed) -> f64 + Sync);

/// Turn of the tool axis allowed, over that of the face's normal between the same places: a tool that keeps its lean
/// turns as the normal does, a little before it or after it.
const FOLLOW: f64 = 1.5;

/// Turn \[rad\] between neighbouring places from which on the face is not followed: there its continuation has turned
/// over, as it does beyond a collapsed edge.
const OVER: f64 = std::f64::consts::FRAC_PI_4;

/// How far inside the face, as a share of the track, a step across has a direction: at a collapsed edge it has none.
const INSIDE: f64 = 1.0 / 64.0;

/// By how much of the band the tool is raised at most where it would go into another face: what is left of it still holds
/// a strip.
const RAISED: f64 = 0.5;

/// How far back the tool is tried where its body touches the face, in widths of a narrow strip.
const BACK: f64 = 2.0;

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

    fn request(&self, at: Local, hold: &Hold) -> LocationRequest<'_> {
        let [_, step] = self.chart.steps(at);
        LocationRequest {
            face: self.face,
            cutter: self.cutter,
            band: self.options.band,
            at: self.chart.uv(at),
            feed: step.map(|s| if self.forward { s } else { -s }),
            strip: self.strip(),
            side: self.options.side,
            offset_range: hold.offset_range,
            axis_cone: hold.axis_cone,
        }
    }

    pub(super) fn free(&self) -> Hold {
        Hold { offset_range: self.options.offset_range, axis_cone: None }
    }

    /// A location on the lane or, where the tool has to keep off something, before it.
    pub(super) fn place(
        &self,
        way: f64,
        hold: &Hold,
        (warm, lean): (Option<&CutterLocation>, ToolInclination),
    ) -> Place {
        self.room(way)?;
        let fixed = self.method == Method::Inclined;
        match self.found(way, hold, (warm, lean)) {
            // What the machine does not get to was found at once; it gets no farther a little way back.
            Err(PositioningError::OutOfReach { uv }) => Err(PositioningError::OutOfReach { uv }),
            Err(error) if fixed || matches!(error, PositioningError::Neighbour { .. }) => {
                // What stands above the corner of the cutter, far up, is not passed by a little way back.
                let body = matches!(error, PositioningError::Body { .. });
                let most = if body { BACK * self.costs().narrow } else { self.cutter.radius() };
                self.pulled((way, most), hold, (warm, lean)).ok_or(error)
            }
            place => place,
        }
    }

    /// A location on the lane.
    pub(super) fn stay(
        &self,
        way: f64,
        hold: &Hold,
        (warm, lean): (Option<&CutterLocation>, ToolInclination),
    ) -> Place {
        self.room(way)?;
        self.found(way, hold, (warm, lean))
    }

    /// Whether there may be a location on the lane or before it. Where not even the corner fits a strip before the lane
    /// nothing does, and that is soon seen.
    fn room(&self, way: f64) -> Result<(), PositioningError> {
        if self.turned_over(way) {
            return Err(self.apart(way));
        }
        if self.method != Method::Inclined {
            return Ok(());
        }
        let back = self.costs().narrow / self.rate_across();
        self.corner_fits([self.across - back, self.track.at(way)])
    }

    fn found(
        &self,
        way: f64,
        hold: &Hold,
        (warm, lean): (Option<&CutterLocation>, ToolInclination),
    ) -> Place {
        let place = self.search([self.across, way], hold, (warm, lean));
        let far = matches!(place, Err(PositioningError::OutOfReach { .. }));
        self.work.location(place.is_ok() || far);
        place
    }

    /// A location at one place. Where the tool would go a little into another face that goes on smoothly from this one, it
    /// is raised by as much within the band.
    pub(super) fn search(
        &self,
        at: Local,
        hold: &Hold,
        (warm, lean): (Option<&CutterLocation>, ToolInclination),
    ) -> Place {
        let mut band = self.options.band;
        let highest = band.lower + RAISED * (band.upper - band.lower);
        loop {
            let (location, barred) = self.location(band, at, hold, (warm, lean))?;
            let uv = self.chart.uv([at[0], self.track.at(at[1])]);
            match barred {
                None => return self.placed(at, lean, location),
                Some(PositioningError::Neighbour { depth, .. })
                    if band.lower + depth < highest && self.goes_on(&location.pose, uv) =>
                {
                    band.lower += depth + self.around.precision;
                }
                Some(error) => return Err(error),
            }
        }
    }

    /// A location within `band`, and what keeps the tool from it.
    fn location(
        &self,
        band: ToleranceBand,
        [across, way]: Local,
        hold: &Hold,
        (warm, lean): (Option<&CutterLocation>, ToolInclination),
    ) -> Result<(CutterLocation, Option<PositioningError>), PositioningError> {
        let request = LocationRequest { band, ..self.request([across, self.track.at(way)], hold) };
        let location = match self.method {
            Method::Widest => widest_strip(&request, warm)?,
            Method::Inclined => with_inclination(&request, lean, warm)?,
        };
        let barred = self.around.clear(&location.pose, request.at).err();
        Ok((location, barred))
    }

    /// Whether what bars a pose lies right below it, seen along the normal of this face.
    fn goes_on(&self, pose: &ToolPose, uv: [f64; 2]) -> bool {
        Spot::new(self.face, uv).is_some_and(|spot| self.around.below(pose, &spot.normal))
    }

    fn placed(
        &self,
        [across, way]: Local,
        lean: ToolInclination,
        location: CutterLocation,
    ) -> Place {
        let along = self.track.at(way);
        let (station, contact_uv) = self.station(self.chart.uv([across, along]), &location)?;
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
        location: &CutterLocation,
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
            let CutterLocation { near, far, .. } = placed.location;
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
    pub(super) fn free_place(&self, way: f64, lean: ToolInclination) -> Place {
        self.place(way, &self.free(), (None, lean))
    }

    /// The same, on the lane itself.
    pub(super) fn here(&self, way: f64, lean: ToolInclination) -> Place {
        if self.turned_over(way) {
            return Err(self.apart(way));
        }
        // Of many leans few are expected to serve: one that does not counts as one that does.
        self.work.location(true);
        self.search([self.across, way], &self.free(), (None, lean))
    }

    /// Whether a lean serves at a place of the lane.
    pub(super) fn serves(&self, way: f64, lean: ToolInclination) -> bool {
        !self.barred(way, lean) && self.here(way, lean).is_ok()
    }

    /// Whether the machine does not get to a tool whose corner touches on the lane, or that tool goes into any face by
    /// more than the width of a narrow strip: then one that touches beside it does so as well.
    fn barred(&self, way: f64, lean: ToolInclination) -> bool {
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
        let narrow = self.costs().narrow;
        let deep =
            Around { least: self.around.least - narrow, precision: 0.5 * narrow, ..self.around };
        !self.around.clock.reaches(&pose) || deep.hits(&pose)
    }

    /// No location lies near enough to its neighbours.
    pub(super) fn apart(&self, way: f64) -> PositioningError {
        PositioningError::NoStrip {
            uv: self.chart.uv([self.across, self.track.at(way)]),
            smallest: self.costs().narrow,
            excess: 0.0,
            binding: ActiveConstraint::AxisTurn,
        }
    }
}

/// What passes cost besides their length.
pub(super) fn costs(cutter: &Cutter, options: &CoverOptions) -> Costs {
    Costs { pass: options.link + RUN_OUTS * cutter.radius(), narrow: narrow(cutter, options) }
}

/// Width of a strip of a ball as wide as the cutter, on a plane \[mm\].
pub(super) fn narrow(cutter: &Cutter, options: &CoverOptions) -> f64 {
    let ToleranceBand { lower, upper } = options.band;
    (8.0 * cutter.radius() * (upper - lower)).sqrt()
}
