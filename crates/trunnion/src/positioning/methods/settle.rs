//! Proof that an optimum keeps the band everywhere, and its description.

use crate::positioning::active::ActiveConstraint;
use crate::positioning::check::body::check_body;
use crate::positioning::check::cutting_zone::{TOUCHING, cuts_there, within_cutting};
use crate::positioning::check::survey::{CircleSurvey, DEEP, GapRefinement};
use crate::positioning::distance::circle::ErrorCircle;
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::location::{CutterLocation, LocationParts};
use crate::positioning::request::{LocationRequest, ToleranceBand};
use crate::positioning::solve::climb::ARRIVED;
use crate::positioning::solve::conditions::{FINE, StripProblem};
use crate::positioning::solve::follow::extremum_marks;
use crate::positioning::solve::initial_guesses::{SearchRanges, restart_from};
use crate::positioning::solve::optimum::LocalOptimum;
use crate::positioning::solve::placement::EndPointFrame;
use crate::positioning::strip::{CuttingContext, MeasuredStrip};
use crate::types::{ToolPose, Uv};

/// Times the dense measurement may restart the search. The remaining breach falls with its square, so
/// if any number suffices, a few do.
const NARROWINGS: usize = 4;

/// Measures the optimum densely. Where that finds a breach between the samples, the search goes on
/// with more samples, and then with the band narrowed from below by the remaining breach.
pub(crate) fn settle(
    request: &LocationRequest,
    problem: &StripProblem,
    mut optimum: LocalOptimum,
    ranges: SearchRanges,
    probe: &mut FaceProbe,
) -> Result<CutterLocation, PositioningError> {
    let mut problem = StripProblem { ..*problem };
    let deep = DEEP * (request.band.upper - request.band.lower);
    let mut before = f64::INFINITY;
    for _ in 0..NARROWINGS {
        let strip =
            measure_optimum(request, GapRefinement::WhereBounded, &problem, &optimum, probe)?;
        if keeps(request.band, &strip, &optimum) {
            return finish(request, &problem, &optimum, &strip, probe);
        }
        // First more samples; if the gouge stays with the fine sampling, the band is narrowed by
        // twice of it.
        let missing = request.band.lower - strip.front_min.min(strip.rear_min);
        // A breach as deep as that has to fall to half with each restart.
        if missing > deep && missing > 0.5 * before {
            return Err(broken_by(request, &optimum, missing));
        }
        before = missing;
        if problem.intervals == FINE && missing > 0.0 {
            problem.band.lower += 2.0 * missing;
        }
        problem.intervals = FINE;
        match problem.climb(&restart_from(&optimum, ranges), ARRIVED, probe)? {
            Some(better) => optimum = better,
            None => break,
        }
    }
    let strip = measure_optimum(request, GapRefinement::WhereBounded, &problem, &optimum, probe)?;
    if is_clear(request.band, &strip) && strip.width > 0.0 {
        return finish(request, &problem, &optimum, &strip, probe);
    }
    Err(no_strip(request, Some(&optimum)))
}

/// Returns `true` if nothing comes closer than the lower end of the band.
fn is_clear(band: ToleranceBand, strip: &MeasuredStrip) -> bool {
    strip.front_min >= band.lower && strip.rear_min >= band.lower
}

/// Returns `true` if nothing comes closer than the lower end of the band and the strip reaches the
/// second end point: an error above the band on the way would have cut it short.
pub(crate) fn keeps(band: ToleranceBand, strip: &MeasuredStrip, optimum: &LocalOptimum) -> bool {
    /// Of the width: on a strongly curved surface the widths of strip and chord, seen from
    /// different tangent planes, differ a little.
    const WHOLE: f64 = 0.99;
    let whole = strip.width >= WHOLE * EndPointFrame::width(optimum.state.placement.x);
    whole && is_clear(band, strip)
}

/// Returns the error of an optimum that its dense measurement finds too low \[mm\].
fn broken_by(request: &LocationRequest, optimum: &LocalOptimum, excess: f64) -> PositioningError {
    let (uv, smallest) = (request.at, request.narrowest_strip());
    PositioningError::NoStrip { uv, smallest, excess, binding: optimum.state.tightest() }
}

pub(crate) fn no_strip(
    request: &LocationRequest,
    failed: Option<&LocalOptimum>,
) -> PositioningError {
    PositioningError::NoStrip {
        uv: request.at,
        smallest: request.narrowest_strip(),
        excess: failed.map_or(f64::INFINITY, |optimum| optimum.state.breach()),
        binding: failed.map_or(ActiveConstraint::Touch, |optimum| optimum.state.tightest()),
    }
}

/// Measures the strip of the optimum densely.
pub(crate) fn measure_optimum(
    request: &LocationRequest,
    refinement: GapRefinement,
    problem: &StripProblem,
    optimum: &LocalOptimum,
    probe: &mut FaceProbe,
) -> Result<MeasuredStrip, PositioningError> {
    let placement = &optimum.state.placement;
    let frame = &problem.frame;
    let circle = ErrorCircle { ring: placement.ring, minor: frame.minor };
    let setting = CuttingContext { face: request.face, cutter: request.cutter, band: request.band };
    let survey = CircleSurvey {
        setting: &setting,
        circle,
        axis: placement.axis,
        v: frame.v,
        half_arc: placement.half_arc,
        seen: &optimum.state.samples,
        refinement,
    };
    let Uv { u: u1, v: v1 } = frame.first.foot.uv;
    let Uv { u: u2, v: v2 } = placement.second.foot.uv;
    survey.strip([0.5 * (u1 + u2), 0.5 * (v1 + v2)], probe)
}

/// Describes the optimum as a location, after checking the rest of the tool.
pub(crate) fn finish(
    request: &LocationRequest,
    problem: &StripProblem,
    optimum: &LocalOptimum,
    strip: &MeasuredStrip,
    probe: &mut FaceProbe,
) -> Result<CutterLocation, PositioningError> {
    let placement = &optimum.state.placement;
    let frame = &problem.frame;
    let setting = CuttingContext { face: request.face, cutter: request.cutter, band: request.band };
    let pose = placement.pose(frame.minor);
    cuts_there(&setting, &pose, strip)?;
    touches_where_it_cuts(&setting, &pose, optimum)?;
    check_body(&setting, &pose, request.at, probe)?;
    let (contact_angles, active) = binding(request, optimum);
    let found = LocationParts {
        pose,
        side: frame.side,
        x: placement.x,
        widths: [strip.width, EndPointFrame::width(placement.x)],
        arc: 2.0 * placement.half_arc,
        contact_angles,
        active,
        end: placement.second.foot.uv,
        queries: probe.queries,
        marks: extremum_marks(&optimum.state, frame.first.foot.uv.into()),
    };
    Ok(CutterLocation::new(request, strip, found))
}

/// Checks that all other contacts lie where the cutter cuts: within the strip, under the rear, under
/// the disc.
fn touches_where_it_cuts(
    setting: &CuttingContext,
    pose: &ToolPose,
    optimum: &LocalOptimum,
) -> Result<(), PositioningError> {
    let slight = TOUCHING * (setting.band.upper - setting.band.lower);
    let touching = optimum.state.conditions.iter().filter(|c| c.value <= slight);
    within_cutting(setting, pose, touching.filter_map(|condition| condition.contact))
}

/// Returns the contacts, as angles from the first end point, and the constraints that bind.
fn binding(request: &LocationRequest, optimum: &LocalOptimum) -> (Vec<f64>, Vec<ActiveConstraint>) {
    let band = request.band.upper - request.band.lower;
    let half = optimum.state.placement.half_arc;
    let mut active = Vec::new();
    let mut angles = Vec::new();
    for (condition, multiplier) in optimum.state.conditions.iter().zip(&optimum.multipliers) {
        if condition.kind == ActiveConstraint::Touch {
            angles.push(condition.psi + half);
        }
        // Complementary slackness: a condition limits the width where it is met and its multiplier
        // is positive.
        if *multiplier > 0.0 && condition.value <= TOUCHING * band {
            active.push(condition.kind);
        }
    }
    if optimum.at_range_end {
        active.push(ActiveConstraint::OffsetRange);
    }
    (angles, active)
}
