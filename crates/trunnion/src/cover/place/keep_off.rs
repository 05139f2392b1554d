//! Stations of a candidate pass: on the track or, where the tool has to keep off something, before it.

use super::candidate::{
    CandidatePass, LocationLimits, LocationResult, LocationStart, PlacedStation, TrackPoint,
};
use super::tool_fit::ContactPoint;
use crate::cover::layout::region::ChartPoint;
use crate::cover::pattern::PlacementMethod;
use crate::cover::prove::part_faces::{KeepOff, NearestQuery};
use crate::cutter::ConvexSolid;
use crate::positioning::{CutterLocation, PositioningError, ToolInclination};
use crate::types::{ToolPose, Uv};
use nalgebra::Unit;
use rayon::prelude::*;

/// First step back from a track without location, in widths of a narrow strip.
const PULL: f64 = 0.9;

/// Halvings of the step back.
const HALVINGS: u32 = 6;

/// Largest step back where the body of the tool touches the face, in widths of a narrow strip.
const BACK: f64 = 2.0;

/// Run-out of a pass over what its strips need, as a factor.
const RESERVE: f64 = 1.5;

/// Side of a track on which the corner of the cutter fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TrackRoom {
    /// Over the strips before it.
    Before,
    /// Beyond it only.
    Beyond,
}

impl CandidatePass<'_> {
    /// Places a station on the track or, where the tool has to keep off something, before it.
    pub(crate) fn place(
        &self,
        arc: f64,
        limits: &LocationLimits,
        start: LocationStart<'_>,
    ) -> LocationResult {
        let room = self.room(arc)?;
        let fixed = self.method == PlacementMethod::Inclined;
        match self.found(arc, limits, start) {
            // An obstacle that lies behind is nearer a little way back.
            place if room == TrackRoom::Beyond => place,
            // A pose out of reach is found at once, and a little way back is out of reach as well.
            Err(PositioningError::OutOfReach { uv }) => Err(PositioningError::OutOfReach { uv }),
            Err(error) if fixed || matches!(error, PositioningError::Neighbour { .. }) => {
                // An obstacle above the corner of the cutter, far up, is not passed by a little way back.
                let body = matches!(error, PositioningError::Body { .. });
                let most = if body { BACK * self.costs().narrow } else { self.cutter.radius() };
                self.pulled_back(arc, most, limits, start).ok_or(error)
            }
            place => place,
        }
    }

    /// Places a station on the track only.
    pub(crate) fn place_on_track(
        &self,
        arc: f64,
        limits: &LocationLimits,
        start: LocationStart<'_>,
    ) -> LocationResult {
        self.room(arc)?;
        self.found(arc, limits, start)
    }

    /// Places a station without regard to its neighbours.
    pub(crate) fn place_alone(&self, arc: f64, lean: ToolInclination) -> LocationResult {
        self.place(arc, &self.free(), LocationStart::cold(lean))
    }

    /// Returns on which side of the track the corner of the cutter fits. If it fits neither a strip before the track, as where
    /// an obstacle lies ahead, nor a strip beyond it, there is no location, and that is soon found.
    fn room(&self, arc: f64) -> Result<TrackRoom, PositioningError> {
        if self.turned_over(arc) {
            return Err(self.apart(arc));
        }
        if self.method != PlacementMethod::Inclined {
            return Ok(TrackRoom::Before);
        }
        let step = self.costs().narrow / self.rate_across();
        let fits = |step: f64| self.corner_fits([self.across + step, self.track.at(arc)]);
        match fits(-step) {
            Ok(()) => Ok(TrackRoom::Before),
            Err(error) => fits(step).map(|()| TrackRoom::Beyond).map_err(|_| error),
        }
    }

    /// Places a station before the track, over finished material, that still cuts something beyond the track.
    ///
    /// It is as near as the tool may come to what it has to keep off, and at most about `most` \[mm\] back.
    fn pulled_back(
        &self,
        arc: f64,
        most: f64,
        limits: &LocationLimits,
        start: LocationStart<'_>,
    ) -> Option<PlacedStation> {
        let (rate, chart) = (self.rate_across(), self.chart);
        let at = |back: f64| {
            let across = self.across - back / rate;
            let (found, outcome) = self.search(TrackPoint { across, arc }, limits, start);
            self.work.location(outcome);
            found.ok()
        };
        let useful = |placed: &PlacedStation| placed.far(chart)[0] > self.across;
        // Step 1: doubling steps back until there is a location.
        let mut bad = 0.0;
        let mut good = PULL * self.costs().narrow;
        let mut best = loop {
            match at(good) {
                Some(placed) => break placed,
                None if good > most => return None,
                None => (bad, good) = (good, 2.0 * good),
            }
        };
        // Step 2: bisection between the last failure and the location.
        for _ in 0..HALVINGS {
            let middle = 0.5 * (bad + good);
            match at(middle) {
                Some(placed) => (good, best) = (middle, placed),
                None => bad = middle,
            }
        }
        Some(best).filter(useful)
    }

    /// Checks that the corner of the cutter keeps off all faces where it touches at `place`. If it does not, no
    /// inclination helps.
    pub(crate) fn corner_fits(&self, place: ChartPoint) -> Result<(), PositioningError> {
        let uv = self.chart.uv(place);
        let Some(contact) = ContactPoint::new(self.face, uv) else { return Ok(()) };
        let minor = self.cutter.minor();
        let KeepOff { part_faces, own, least, precision, .. } = self.keep_off.rough();
        let within = least - precision;
        let query = NearestQuery::any(within, precision);
        // Centre of the corner when it touches with the distance that the tool keeps.
        let tip = contact.point + contact.normal.scale(minor + least);
        let pose = ToolPose { tip, axis: contact.normal };
        let near = part_faces.nearest(&ConvexSolid::ball(minor), &pose, None, query);
        near.map_or(Ok(()), |near| {
            if near.face == own {
                // Radius of the ball through both points that touches at the first: |d|^2 / (2 n.d).
                let apart = near.point - contact.point;
                let concave = apart.norm_squared()
                    / (2.0 * contact.normal.dot(&apart)).max(f64::MIN_POSITIVE);
                return Err(PositioningError::ConcaveRadius { uv: uv.into(), concave, minor });
            }
            let (face, depth) = (part_faces.number(near.face), least - near.distance);
            Err(PositioningError::Neighbour { uv: uv.into(), face, depth })
        })
    }

    /// Returns the length by which the pass is run out so that its strips leave the face \[mm\].
    ///
    /// It is the distance by which strips reach ahead of or behind the track, tried at its ends and its middle; the
    /// cutter's radius where that fails.
    pub(crate) fn extension(&self) -> f64 {
        let [start, end] = self.track.face();
        let limits = self.free();
        let of = |arc: f64| {
            let placed = self.place(arc, &limits, LocationStart::cold(self.lean())).ok()?;
            let [u, v] = self.chart.uv([self.across, placed.along]);
            let from = self.face.face().point(u, v);
            let [_, feed] = self.steps(arc);
            let feed = Unit::try_new(feed, f64::MIN_POSITIVE)?;
            let CutterLocation { near, far, .. } = placed.location;
            let ends = [near, far, placed.contact_uv]
                .map(|Uv { u, v }| feed.dot(&(self.face.face().point(u, v) - from)).abs());
            Some(ends.into_iter().fold(0.0, f64::max))
        };
        let arcs = [start, 0.5 * (start + end), end];
        let tried: Vec<Option<f64>> = arcs.into_par_iter().map(of).collect();
        let most = tried.into_iter().try_fold(0.0, |most: f64, one| Some(most.max(one?)));
        let radius = self.cutter.radius();
        // A spacing more, as the last station lies up to a spacing before the end of the run-out.
        most.map_or(radius, |most| (RESERVE * most + self.options.spacing.high).min(radius))
    }
}
