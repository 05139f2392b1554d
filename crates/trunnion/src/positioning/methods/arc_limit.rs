//! Strips that end where the arc of the cutter ends.

use crate::cutter::Cutter;
use crate::positioning::active::ActiveConstraint;
use crate::positioning::check::ball_strip::{inclination, limit};
use crate::positioning::error::PositioningError;
use crate::positioning::methods::touching_ball::TouchingBall;
use crate::positioning::request::{ToleranceBand, ToolInclination};
use crate::types::Interval;

/// Trials of a lower band or another contact on the arc. The width of a strip goes with the root of the band, so the
/// first two nearly fit; where the face bends less beside the contact it goes with the fourth root, and each trial halves
/// what is too much.
const TRIALS: u32 = 24;

/// Share of the arc that a strip takes at most.
const SHARE: f64 = 0.98;

/// Places a cutter so that its strip lies on its arc.
///
/// Beyond the arc of a lens or a barrel the tool turns inwards and leaves the ball that stands for it. The contact of a
/// barrel slides along the arc, and the inclination with it, until both ends of the strip lie on the arc. A strip too
/// wide for that, and one of a lens, whose inclination stays, is made narrower by a lower band.
///
/// Returns the inclination with the placement.
///
/// # Errors
///
/// Those of `place`, and [`PositioningError::NoStrip`] where the contact itself is off the arc.
pub(crate) fn on_arc(
    cutter: &Cutter,
    band: ToleranceBand,
    lean: ToolInclination,
    mut place: impl FnMut(ToleranceBand, ToolInclination) -> Result<TouchingBall, PositioningError>,
) -> Result<(TouchingBall, ToolInclination), PositioningError> {
    let (mut band, mut lean) = (band, lean);
    let Some(limit) = limit(cutter) else { return Ok((place(band, lean)?, lean)) };
    for _ in 0..TRIALS {
        let touching = place(band, lean)?;
        let arc = StripArc::new(&touching);
        if limit.encloses(arc.range) {
            return Ok((touching, lean));
        }
        let slack = SHARE * limit.width() - arc.range.width();
        if cutter.is_barrel() && slack >= 0.0 {
            lean.angle += arc.shift_into(limit);
            continue;
        }
        let share = if cutter.is_barrel() {
            SHARE * limit.width() / arc.range.width()
        } else {
            SHARE * (limit.high - arc.contact) / (arc.range.high - arc.contact)
        };
        if share <= 0.0 {
            return Err(off_arc(&touching, band));
        }
        band.upper = band.lower + share * share * (band.upper - band.lower);
    }
    place(band, lean).and_then(|touching| Err(off_arc(&touching, band)))
}

/// Angles between the tool axis and the normals of the ball under a strip \[rad\].
struct StripArc {
    range: Interval,
    contact: f64,
}

impl StripArc {
    fn new(TouchingBall { pose, center, strip }: &TouchingBall) -> Self {
        let [near, contact, far] =
            [strip.near, strip.contact, strip.far].map(|at| inclination(center, pose, &at.point));
        Self { range: Interval::new(near.min(far), near.max(far)), contact }
    }

    /// Returns the turn that brings a strip narrower than its arc onto that, with the same room at its end as the arc
    /// is wide at most \[rad\].
    fn shift_into(&self, limit: Interval) -> f64 {
        let room = 0.5 * (1.0 - SHARE) * limit.width();
        let below = limit.low + room - self.range.low;
        if below > 0.0 { below } else { (limit.high - room - self.range.high).min(0.0) }
    }
}

fn off_arc(TouchingBall { strip, .. }: &TouchingBall, band: ToleranceBand) -> PositioningError {
    PositioningError::NoStrip {
        uv: strip.contact.uv,
        smallest: strip.width,
        excess: band.upper,
        binding: ActiveConstraint::GivenLead,
    }
}
