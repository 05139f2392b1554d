//! How near to what the tool keeps off a lane's location may come.

use super::fit::Spot;
use super::guard::{Around, Look};
use super::lane::{Hold, Lane, Placed};
use super::region::Local;
use crate::cutter::solid::Solid;
use crate::positioning::{CutterLocation, PositioningError, ToolInclination};
use crate::types::ToolPose;

/// How far back a location is first tried where there is none, in widths of a narrow strip.
const PULL: f64 = 0.9;

/// Halvings of the way back.
const HALVINGS: u32 = 6;

impl Lane<'_> {
    /// The location before the lane, on what is finished already, that still cuts something beyond it: where the
    /// tool has to keep off something, as near to it as it may come, and no farther back than about `most` \[mm\].
    pub(super) fn pulled(
        &self,
        (way, most): (f64, f64),
        hold: &Hold,
        (warm, lean): (Option<&CutterLocation>, ToolInclination),
    ) -> Option<Placed> {
        let (rate, chart) = (self.rate_across(), self.chart);
        let at = |back: f64| {
            let across = self.across - back / rate;
            let found = self.search([across, way], hold, (warm, lean)).ok();
            self.work.location(found.is_some());
            found
        };
        let useful = |placed: &Placed| placed.far(chart)[0] > self.across;
        let (mut bad, mut good) = (0.0, PULL * self.costs().narrow);
        let mut best = loop {
            match at(good) {
                Some(placed) => break placed,
                None if good > most => return None,
                None => (bad, good) = (good, 2.0 * good),
            }
        };
        for _ in 0..HALVINGS {
            let middle = 0.5 * (bad + good);
            match at(middle) {
                Some(placed) => (good, best) = (middle, placed),
                None => bad = middle,
            }
        }
        Some(best).filter(useful)
    }

    /// Whether the corner of the cutter keeps off all faces where it touches at a place: if not, no lean helps.
    pub(super) fn corner_fits(&self, place: Local) -> Result<(), PositioningError> {
        let uv = self.chart.uv(place);
        let Some(spot) = Spot::new(self.face, uv) else { return Ok(()) };
        let minor = self.cutter.minor();
        let Around { guards, own, least, precision, .. } = self.around;
        let within = least - precision;
        let look = Look { within, precision, enough: within };
        let tip = spot.point + spot.normal.scale(minor + least);
        let pose = ToolPose { tip, axis: spot.normal };
        let near = guards.nearest((&Solid::ball(minor), &pose), None, look);
        near.map_or(Ok(()), |near| {
            if near.face == own {
                let way = near.point - spot.point;
                let concave =
                    way.norm_squared() / (2.0 * spot.normal.dot(&way)).max(f64::MIN_POSITIVE);
                return Err(PositioningError::ConcaveRadius { uv, concave, minor });
            }
            let (face, depth) = (guards.number(near.face), least - near.distance);
            Err(PositioningError::Neighbour { uv, face, depth })
        })
    }
}
