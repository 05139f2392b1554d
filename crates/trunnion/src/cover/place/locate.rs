//! Cutter locations at one point of a candidate pass.

use super::candidate::{
    CandidatePass, LocationLimits, LocationResult, LocationStart, PlacedStation, TrackPoint,
};
use super::tool_fit::ContactPoint;
use crate::cover::layout::effort::SearchOutcome;
use crate::cover::layout::region::ChartPoint;
use crate::cover::pattern::PlacementMethod;
use crate::cover::prove::part_faces::KeepOff;
use crate::math;
use crate::positioning::{
    ContactSide, CutterLocation, PositioningError, ToleranceBand, ToolInclination,
    widest_strip_counted, with_inclination_counted,
};
use crate::types::{Station, ToolPose, Uv};
use nalgebra::{Unit, Vector3};

/// Share of the band by which the tool is raised at most where it would go into another face. The remaining band
/// still holds a strip.
const RAISED: f64 = 0.5;

/// A location, and the reason why the tool cannot take it, if there is one.
struct CheckedLocation {
    location: CutterLocation,
    barred: Option<PositioningError>,
}

impl CandidatePass<'_> {
    /// Finds a location on the track itself, and counts the work.
    pub(crate) fn found(
        &self,
        arc: f64,
        limits: &LocationLimits,
        start: LocationStart<'_>,
    ) -> LocationResult {
        let at = TrackPoint { across: self.across, arc };
        let (place, outcome) = self.search(at, limits, start);
        let far = matches!(place, Err(PositioningError::OutOfReach { .. }));
        self.work.location(if far { SearchOutcome::Found } else { outcome });
        place
    }

    /// Finds a location on the track at another inclination.
    pub(crate) fn here(&self, arc: f64, lean: ToolInclination) -> LocationResult {
        if self.turned_over(arc) {
            return Err(self.apart(arc));
        }
        // Of many inclinations few are expected to serve: one that does not counts as one that does.
        self.work.location(SearchOutcome::Found);
        let at = TrackPoint { across: self.across, arc };
        self.search(at, &self.free(), LocationStart::cold(lean)).0
    }

    /// Returns `true` if an inclination gives a location on the track.
    pub(crate) fn serves(&self, arc: f64, lean: ToolInclination) -> bool {
        !self.barred(arc, lean) && self.here(arc, lean).is_ok()
    }

    /// Finds a location at one point.
    ///
    /// If the tool would go a little into another face that continues this one smoothly, it is raised by as much
    /// within the band.
    pub(crate) fn search(
        &self,
        at: TrackPoint,
        limits: &LocationLimits,
        start: LocationStart<'_>,
    ) -> (LocationResult, SearchOutcome) {
        let mut queries = 0;
        let place = self.search_counted(at, limits, start, &mut queries);
        let found = place.is_ok();
        (place, if found { SearchOutcome::Found } else { SearchOutcome::Missed { queries } })
    }

    fn search_counted(
        &self,
        at: TrackPoint,
        limits: &LocationLimits,
        start: LocationStart<'_>,
        queries: &mut u64,
    ) -> LocationResult {
        let mut band = self.options.band;
        let highest = band.lower + RAISED * (band.upper - band.lower);
        loop {
            let CheckedLocation { location, barred } =
                self.location(band, at, limits, start, queries)?;
            let uv = self.chart.uv([at.across, self.track.at(at.arc)]);
            match barred {
                None => return self.placed(at, start.lean, location),
                Some(PositioningError::Neighbour { depth, .. })
                    if band.lower + depth < highest && self.goes_on(&location.pose, uv) =>
                {
                    band.lower += depth + self.keep_off.precision;
                }
                Some(error) => return Err(error),
            }
        }
    }

    /// Finds a location within `band`, and checks it against reach and the other faces.
    fn location(
        &self,
        band: ToleranceBand,
        at: TrackPoint,
        limits: &LocationLimits,
        start: LocationStart<'_>,
        queries: &mut u64,
    ) -> Result<CheckedLocation, PositioningError> {
        let request = crate::positioning::LocationRequest {
            band,
            ..self.request([at.across, self.track.at(at.arc)], limits)
        };
        // The axis of a ball is known beforehand. The machine first: it costs least to find.
        if self.method == PlacementMethod::Inclined
            && self.cutter.touches_in_one_point()
            && let Some(pose) = self.touching([at.across, self.track.at(at.arc)], start.lean)
            && !self.keep_off.cost.reaches(&pose)
        {
            return Err(PositioningError::OutOfReach { uv: request.at });
        }
        let location = match self.method {
            PlacementMethod::Widest => widest_strip_counted(&request, start.warm, queries)?,
            PlacementMethod::Inclined => {
                with_inclination_counted(&request, start.lean, start.warm, queries)?
            }
        };
        let mut barred = self.keep_off.check(&location.pose, request.at).err();
        if self.cutter.is_barrel() {
            barred = barred.or_else(|| self.keep_off.check_own(&location.pose, request.at).err());
        }
        Ok(CheckedLocation { location, barred })
    }

    /// Returns `true` if the obstacle of a pose lies right below it, seen along the normal of this face.
    fn goes_on(&self, pose: &ToolPose, uv: [f64; 2]) -> bool {
        ContactPoint::new(self.face, uv)
            .is_some_and(|contact| self.keep_off.is_right_below(pose, &contact.normal))
    }

    fn placed(
        &self,
        at: TrackPoint,
        lean: ToolInclination,
        location: CutterLocation,
    ) -> LocationResult {
        let TrackPoint { across, arc } = at;
        let along = self.track.at(arc);
        let (station, contact_uv) =
            self.station(self.chart.uv([across, along]).into(), &location)?;
        Ok(PlacedStation { arc, across, along, lean, location, station, contact_uv })
    }

    /// Makes a station of a location.
    ///
    /// Its contact is the foot of the middle of the contact arc. Unlike the points of tangency, of which there may
    /// be two or one, it moves smoothly along the pass.
    fn station(
        &self,
        at: Uv,
        location: &CutterLocation,
    ) -> Result<(Station, Uv), PositioningError> {
        // A barrel has one contact. From the centre of its arc, far above, the face may be nearer elsewhere.
        if self.cutter.is_barrel() {
            let CutterLocation { pose, contact, contact_uv, .. } = *location;
            return Ok((Station { pose, contact }, contact_uv));
        }
        let ToolPose { axis, .. } = location.pose;
        let point = |uv: Uv| self.face.face().point(uv.u, uv.v);
        // The middle of the two end points, projected into the plane of the centre circle.
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

    /// Returns `true` if no location at this inclination can serve.
    ///
    /// Then the machine does not reach a tool whose corner touches on the track, or that tool goes into some face by
    /// more than the width of a narrow strip: one that touches beside the track does so as well.
    fn barred(&self, arc: f64, lean: ToolInclination) -> bool {
        let Some(pose) = self.touching([self.across, self.track.at(arc)], lean) else {
            return false;
        };
        let narrow = self.costs().narrow;
        let deep = KeepOff {
            least: self.keep_off.least - narrow,
            precision: 0.5 * narrow,
            ..self.keep_off
        };
        !self.keep_off.cost.reaches(&pose) || deep.hits_any(&pose)
    }

    /// Returns the pose at an inclination whose corner touches the face at a point.
    fn touching(&self, place: ChartPoint, lean: ToolInclination) -> Option<ToolPose> {
        let contact = ContactPoint::new(self.face, self.chart.uv(place))?;
        let normal = contact.normal;
        let [_, feed] = self.steps_at(place);
        // The inclination is measured from the contact side of the feed towards the strip.
        let along = Unit::try_new(feed - normal.scale(normal.dot(&feed)), f64::MIN_POSITIVE)?;
        let forward = along.scale(if self.forward { 1.0 } else { -1.0 });
        let behind = self.options.side == ContactSide::Behind;
        let ahead = if behind { -forward } else { forward };
        let beside = forward.cross(&normal).scale(self.strip().sign());
        let (sin, cos) = math::sin_cos(lean.towards.unwrap_or(0.0));
        let towards = ahead.scale(cos) + beside.scale(sin);
        let arc = self.cutter.contact_arc();
        let corner = contact.point + normal.scale(arc.radius);
        Some(arc.pose(corner, &normal, &towards, lean.angle))
    }
}
