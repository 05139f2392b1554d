//! Extrema and contacts of a proposed pose.

use crate::math;
use crate::positioning::active::ActiveConstraint;
use crate::positioning::check::cutting_zone::TOUCHING;
use crate::positioning::check::proposal::{PoseProposal, cutting_context, strip_query};
use crate::positioning::distance::circle::{ErrorCircle, ErrorExtremum};
use crate::positioning::distance::curve::circle_of_pose;
use crate::positioning::distance::disc::FlatDisc;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::distance::width::width_across;
use crate::positioning::error::PositioningError;
use crate::positioning::request::{LocationRequest, ToleranceBand};
use crate::positioning::solve::placement::EndPointFrame;
use crate::positioning::strip::MeasuredStrip;
use crate::positioning::surface_point::SurfacePoint;
use crate::types::{Interval, ToolPose};

/// Share of the band within which a condition counts as reached: searches on a grid stop short.
const REACHED: f64 = 0.02;

/// Half the number of samples round the circle between which extrema are sought.
const HALF: u32 = 60;

/// Extrema and contacts found on the circle and under the disc, whatever the method intended.
pub(crate) struct PoseFindings {
    /// Width in the plane of the end point or contact asked for \[mm\].
    pub(crate) width: f64,
    /// Angle between the ends of the strip \[rad\].
    pub(crate) arc: f64,
    /// Minima of the error inside the strip, as angles from the first end point, or from the strip's
    /// beginning where there is none \[rad\].
    pub(crate) contacts: Vec<f64>,
    pub(crate) active: Vec<ActiveConstraint>,
    /// Least error of the strip's minima, which a measurement may step over where two extrema lie
    /// close together \[mm\].
    pub(crate) least: f64,
    /// Contacts of the cutter.
    pub(crate) touching: Vec<SurfacePoint>,
}

impl PoseFindings {
    pub(crate) fn new(
        request: &LocationRequest,
        frame: &EndPointFrame,
        proposal: &PoseProposal,
        strip: &MeasuredStrip,
        probe: &mut FaceProbe,
    ) -> Result<Self, PositioningError> {
        let (setting, pose) = (cutting_context(request), &proposal.pose);
        let SurfacePoint { uv, point: contact } = proposal.middle;
        let middle = probe.read(&contact, uv.into())?;
        let (ring, _) =
            circle_of_pose(&setting, pose, &strip_query(request, frame, proposal), &middle)?;
        let minor = setting.cutter.minor();
        if ring.radius <= 0.0 {
            let half = math::asin(
                (0.5 * nalgebra::distance(&strip.near.point, &strip.far.point) / minor).min(1.0),
            );
            let (contacts, touching) = (vec![half], vec![strip.contact]);
            let (arc, active) = (2.0 * half, vec![ActiveConstraint::Touch]);
            let (width, least) = (strip.width, strip.front_min);
            return Ok(Self { width, arc, contacts, active, least, touching });
        }
        let circle = ErrorCircle { ring, minor };
        let extrema =
            circle.extrema(&circle.all_round(middle.foot.uv.into(), HALF, probe)?, probe)?;
        let lift = minor + request.band.upper;
        let ends = [strip.near, strip.far].map(|end| probe.foot(&end.point, end.uv.into()));
        let [near, far] = ends;
        let (near, far) = (near?, far?);
        let width = width_across(&frame.v, &near, &far).max(0.0);
        let [near, far, first] = [&near, &far, &frame.first].map(|end| ring.angle_over(end, lift));
        let origin = if proposal.ends.is_some() { first } else { near };
        let (contacts, active, touching) = (Vec::new(), Vec::new(), Vec::new());
        let (arc, least) = (far - near, f64::INFINITY);
        let mut found = Self { width, arc, contacts, active, least, touching };
        found.round(&extrema, request.band, Interval::new(near, far), origin);
        found.underside(request, pose, &[&frame.first, &middle], probe)?;
        Ok(found)
    }

    fn add(&mut self, active: ActiveConstraint) {
        if !self.active.contains(&active) {
            self.active.push(active);
        }
    }

    /// Adds the extrema round the circle; the angles of `strip` \[rad\] bound the strip, contacts are
    /// counted from `origin` \[rad\].
    fn round(
        &mut self,
        extrema: &[ErrorExtremum],
        band: ToleranceBand,
        strip: Interval,
        origin: f64,
    ) {
        let width = band.upper - band.lower;
        for ErrorExtremum { sample, value, maximum } in extrema {
            let inside = strip.contains(sample.psi);
            if *maximum {
                if inside && band.upper - value <= REACHED * width {
                    self.add(ActiveConstraint::Middle);
                }
                continue;
            }
            if inside {
                self.contacts.push(sample.psi - origin);
                self.least = self.least.min(*value);
            }
            if value - band.lower <= REACHED * width {
                self.add(if inside { ActiveConstraint::Touch } else { ActiveConstraint::Rear });
            }
            if value - band.lower <= TOUCHING * width {
                self.touching.push(SurfacePoint::from(&sample.reading.foot));
            }
        }
    }

    fn underside(
        &mut self,
        request: &LocationRequest,
        pose: &ToolPose,
        nearby: &[&DistanceReading],
        probe: &mut FaceProbe,
    ) -> Result<(), PositioningError> {
        let ToleranceBand { lower, upper } = request.band;
        let disc = FlatDisc { center: pose.tip, axis: pose.axis, radius: request.cutter.major() };
        let Some(near) = nearby.first() else { return Ok(()) };
        let centre = disc.middle(near, probe)?;
        if let Some((_, reading)) = disc.lowest(&centre, nearby, probe)? {
            let over = reading.distance - lower;
            if over <= REACHED * (upper - lower) {
                self.add(ActiveConstraint::Disc);
            }
            if over <= TOUCHING * (upper - lower) {
                self.touching.push(SurfacePoint::from(&reading.foot));
            }
        }
        Ok(())
    }
}
