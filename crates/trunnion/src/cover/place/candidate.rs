//! Candidate pass: an end-point track with everything that is needed to place the tool along it.

use crate::cover::layout::advance::AdvanceCosts;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::effort::WorkCounter;
use crate::cover::layout::region::ChartPoint;
use crate::cover::layout::track::EndPointTrack;
use crate::cover::options::CoverOptions;
use crate::cover::pattern::{CutPattern, PlacementMethod};
use crate::cover::prove::part_faces::KeepOff;
use crate::cutter::Cutter;
use crate::math::angle::angle_between;
use crate::positioning::{
    ActiveConstraint, AxisCone, CutterLocation, LocationRequest, PositioningError, StripSide,
    ToolInclination,
};
use crate::surface::FaceIndex;
use crate::types::{Interval, Station, Uv};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Turn of the tool axis allowed, over that of the face's normal between the same points. A tool that keeps its
/// inclination turns as the normal does, a little before it or after it.
const FOLLOW: f64 = 1.5;

/// Turn \[rad\] between neighbouring points from which on the face is not followed: there its continuation has turned
/// over, as it does beyond a collapsed edge.
const OVER: f64 = std::f64::consts::FRAC_PI_4;

/// Distance from the ends of the face, as a share of the track, at which a step across has a direction. At a
/// collapsed edge it has none.
const INSIDE: f64 = 1.0 / 64.0;

/// A track with everything needed to place the tool along it.
pub(crate) struct CandidatePass<'a> {
    pub(crate) face: &'a FaceIndex,
    pub(crate) cutter: &'a Cutter,
    pub(crate) options: &'a CoverOptions,
    pub(crate) chart: &'a Chart,
    /// Parameter across at which the track lies.
    pub(crate) across: f64,
    /// Range of the region across.
    pub(crate) across_range: [f64; 2],
    pub(crate) track: EndPointTrack,
    /// `true` if the feed is towards growing parameters.
    pub(crate) forward: bool,
    /// Placement of the tool along this pass.
    pub(crate) method: PlacementMethod,
    /// The other faces, which the tool keeps off.
    pub(crate) keep_off: KeepOff<'a>,
    pub(crate) work: WorkCounter,
}

/// Cutter location of a candidate pass, as a station.
#[derive(Debug, Clone)]
pub(crate) struct PlacedStation {
    /// Arc length along the track \[mm\].
    pub(crate) arc: f64,
    /// Parameter across; less than that of the pass where the tool had to keep off something.
    pub(crate) across: f64,
    /// Parameter along.
    pub(crate) along: f64,
    /// Inclination of the tool, where that is given.
    pub(crate) lean: ToolInclination,
    pub(crate) location: CutterLocation,
    pub(crate) station: Station,
    /// Parameters of the station's contact.
    pub(crate) contact_uv: Uv,
}

impl PlacedStation {
    /// Returns the far end of the strip, across and along.
    pub(crate) fn far(&self, chart: &Chart) -> ChartPoint {
        chart.local(self.location.far.into())
    }
}

/// Bounds that keep a location near its neighbours.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocationLimits {
    /// Offset directions \[rad\].
    pub(crate) offset_range: Interval,
    /// Cone for the tool axis, if any.
    pub(crate) axis_cone: Option<AxisCone>,
}

/// Initial guess and inclination for the search of a location.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocationStart<'a> {
    /// Location of a neighbour that the search starts from.
    pub(crate) warm: Option<&'a CutterLocation>,
    /// Inclination, for [`PlacementMethod::Inclined`].
    pub(crate) lean: ToolInclination,
}

impl<'a> LocationStart<'a> {
    /// Starts from scratch.
    pub(crate) fn cold(lean: ToolInclination) -> Self {
        Self { warm: None, lean }
    }

    /// Starts from a station nearby, with its inclination.
    pub(crate) fn from(station: &'a PlacedStation) -> Self {
        Self { warm: Some(&station.location), lean: station.lean }
    }
}

/// A point across the passes, at an arc length along the track.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrackPoint {
    /// Parameter across.
    pub(crate) across: f64,
    /// Arc length along the track \[mm\].
    pub(crate) arc: f64,
}

/// Returns the parameter across to which a station finishes the region; infinite where nothing is left beyond it.
pub(crate) type ReachFn<'a> = &'a (dyn Fn(&PlacedStation) -> f64 + Sync);

/// The station found, or the reason why there is none.
pub(crate) type LocationResult = Result<PlacedStation, PositioningError>;

impl CandidatePass<'_> {
    /// Returns the inclination asked for.
    ///
    /// A ball that only has to lean somewhere leans along the feed. Where passes run to and fro it leans the same way on
    /// the return, as the strip is the same and no rotary axis has to turn round between passes.
    pub(crate) fn lean(&self) -> ToolInclination {
        let CoverOptions { lean, pattern, .. } = *self.options;
        if self.cutter.has_ball_tip()
            && pattern == CutPattern::ZigZag
            && lean.towards.is_none()
            && !self.forward
        {
            return ToolInclination { towards: Some(PI), ..lean };
        }
        lean
    }

    /// Returns the side of the feed on which the strip lies, so that it is on the side of growing `across`.
    ///
    /// With `f` along and `c` across, `f x (S_u x S_v)` is on the side of `c` where `(c, f)` turn as `(S_u, S_v)` do.
    pub(crate) fn strip(&self) -> StripSide {
        let right = self.forward == self.chart.right_handed();
        if right == self.face.face().flip { StripSide::Left } else { StripSide::Right }
    }

    /// Requests a cutter location with its first end point at `at`.
    pub(crate) fn request(&self, at: ChartPoint, limits: &LocationLimits) -> LocationRequest<'_> {
        let [_, step] = self.chart.steps(at);
        LocationRequest {
            face: self.face,
            cutter: self.cutter,
            band: self.options.band,
            at: self.chart.uv(at).into(),
            feed: step.map(|s| if self.forward { s } else { -s }),
            strip: self.strip(),
            side: self.options.side,
            offset_range: limits.offset_range,
            axis_cone: limits.axis_cone,
        }
    }

    /// Returns the limits of a location without neighbours.
    pub(crate) fn free(&self) -> LocationLimits {
        LocationLimits { offset_range: self.options.offset_range, axis_cone: None }
    }

    /// Returns `true` where the continued surface has turned over, as it does beyond a pole. Steps across then
    /// lead the other way, and no tool can be placed.
    pub(crate) fn turned_over(&self, arc: f64) -> bool {
        let [start, end] = self.track.face();
        if self.track.over_face(arc) {
            return false;
        }
        // A step across against that just inside the face shows that the surface has turned over.
        let across = |arc: f64| self.steps(arc)[0];
        let margin = INSIDE * (end - start);
        across(arc).dot(&across(arc.clamp(start + margin, end - margin))) <= 0.0
    }

    /// Returns the limit of turns between two points of the track \[rad\].
    ///
    /// It is the limit of the options, or the turn of the face itself if that is larger: otherwise no tool could
    /// follow an edge that is rounded more sharply.
    pub(crate) fn turn(&self, from: f64, to: f64) -> f64 {
        let normal = |arc: f64| {
            let [u, v] = self.chart.uv([self.across, self.track.at(arc)]);
            self.face.face().surface.jet1(u, v).normal()
        };
        let follow = match (normal(from), normal(to)) {
            (Some(a), Some(b)) => FOLLOW * angle_between(&a, &b),
            _ => 0.0,
        };
        // A normal that turns so far between neighbours belongs to a continuation that has turned
        // over.
        let follow = if follow < OVER { follow } else { 0.0 };
        (self.options.max_axis_turn * (to - from).abs()).max(follow)
    }

    /// Returns the length of a unit step across, in the middle of the track \[mm\].
    pub(crate) fn rate_across(&self) -> f64 {
        let [start, end] = self.track.face();
        self.steps(0.5 * (start + end))[0].norm().max(f64::MIN_POSITIVE)
    }

    /// Returns the steps on the face by one across and by one along, at arc length `arc`.
    pub(crate) fn steps(&self, arc: f64) -> [Vector3<f64>; 2] {
        self.steps_at([self.across, self.track.at(arc)])
    }

    /// Returns the steps on the face by one across and by one along, at a point.
    pub(crate) fn steps_at(&self, at: ChartPoint) -> [Vector3<f64>; 2] {
        let [u, v] = self.chart.uv(at);
        let jet = self.face.face().surface.jet1(u, v);
        self.chart.steps(at).map(|[du, dv]| jet.su * du + jet.sv * dv)
    }

    /// Returns the costs of passes besides their length.
    pub(crate) fn costs(&self) -> AdvanceCosts {
        AdvanceCosts::new(self.cutter, self.options)
    }

    /// Returns the error of a station that has no location near enough to its neighbours.
    pub(crate) fn apart(&self, arc: f64) -> PositioningError {
        PositioningError::NoStrip {
            uv: self.chart.uv([self.across, self.track.at(arc)]).into(),
            smallest: self.costs().narrow,
            excess: 0.0,
            binding: ActiveConstraint::AxisTurn,
        }
    }
}
