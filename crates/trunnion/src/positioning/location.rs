//! How a location found is told.

use super::ActiveConstraint;
use super::ContactSide;
use super::CutterLocation;
use super::LocationRequest;
use super::check::MeasuredStrip;
use super::constraints::State;
use crate::types::ToolPose;

/// An extremum of the error round the circle, where a neighbour may look for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mark {
    pub(super) kind: ActiveConstraint,
    /// Share of half the arc between the end points; on the rear the angle itself \[rad\].
    pub(super) place: f64,
    /// Way of its foot from the first end point, in parameters.
    pub(super) out: [f64; 2],
}

/// The extrema of a state.
pub(super) fn marks(state: &State, at: [f64; 2]) -> Vec<Mark> {
    let mark = |(kind, sample): (ActiveConstraint, &super::circle::Sample)| {
        let half = if kind == ActiveConstraint::Rear { 1.0 } else { state.placement.half_arc };
        let uv = sample.reading.foot.uv;
        Mark { kind, place: sample.psi / half, out: [0, 1].map(|k| uv[k] - at[k]) }
    };
    let seen = state.conditions.iter().filter_map(|c| Some((c.kind, c.sample.as_ref()?)));
    seen.map(mark).collect()
}

/// What a method knows of its location besides the strip.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) pose: ToolPose,
    pub(super) side: ContactSide,
    /// Offset, its direction, and rotation.
    pub(super) x: [f64; 3],
    /// Width of the strip, and of the chord.
    pub(super) widths: [f64; 2],
    pub(super) arc: f64,
    pub(super) contact_angles: Vec<f64>,
    pub(super) active: Vec<ActiveConstraint>,
    /// Parameters of the second end point.
    pub(super) end: [f64; 2],
    pub(super) queries: u32,
    pub(super) marks: Vec<Mark>,
}

impl CutterLocation {
    pub(super) fn new(request: &LocationRequest, strip: &MeasuredStrip, found: Found) -> Self {
        let Found { pose, side, arc, contact_angles, active, end, queries, marks, .. } = found;
        let ([strip_width, chord_width], [offset, offset_direction, rotation]) =
            (found.widths, found.x);
        Self {
            strip_width,
            chord_width,
            offset,
            offset_direction,
            rotation,
            center: pose.tip + pose.axis.scale(request.cutter.minor()),
            pose,
            side,
            strip: request.strip,
            arc,
            contact_angles,
            active,
            front_max: strip.front_max,
            front_max_bound: strip.front_max_bound,
            front_min: strip.front_min,
            rear_min: strip.rear_min,
            rear_min_bound: strip.rear_min_bound,
            queries,
            contact: strip.contact.1,
            contact_uv: strip.contact.0,
            end,
            near: strip.near.0,
            far: strip.far.0,
            marks,
        }
    }
}
