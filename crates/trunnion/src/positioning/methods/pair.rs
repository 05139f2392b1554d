//! Two contacts and the error between them at the upper end of the band: multi-point machining,
//! and the Hermite-Chebyshev rule.
//!
//! Along the arc between the end points the error is close to a polynomial of degree four whose
//! ends and middle lie at the upper end of the band and whose double zeros lie at its lower end.
//! Multi-point machining (MPM) finds the zeros where they are; Hermite-Chebyshev takes them to be at
//! `cos(pi/4)` of the arc, as those of Chebyshev's polynomial, which asks for three errors only.
//! Neither looks at the rest of the cutter: what gouges is refused.

use crate::math;
use crate::positioning::check::acceptance::accept_proposal;
use crate::positioning::check::proposal::PoseProposal;
use crate::positioning::distance::circle::{ErrorCircle, ErrorExtremum};
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::location::CutterLocation;
use crate::positioning::request::{ContactSide, LocationRequest, ToleranceBand};
use crate::positioning::solve::conditions::offset_curvature;
use crate::positioning::solve::placement::{EndPointFrame, MOST_ROTATION, TorusPlacement};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

/// Steps of Newton; from the quartic's own solution some four to eight arrive.
const STEPS: u32 = 30;

/// Halvings of a step that does not lead closer.
const SHORTENINGS: u32 = 6;

/// Share of the band to which the errors are met; below the margin of the band.
const MET: f64 = 2e-7;

/// Largest distance between two starts of the offset direction \[rad\].
const SPACING: f64 = 0.1;

/// Intervals of the arc between which the minima are looked for.
const INTERVALS: u32 = 24;

/// Solutions whose offset directions differ by less are one \[rad\].
const APART: f64 = 1e-4;

/// Corrections of the errors aimed at the nodes. What is left falls with its square.
const CORRECTIONS: u32 = 4;

/// Points of the arc whose errors are prescribed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PairRule {
    /// At the minima and the maximum between them.
    Extrema,
    /// At the nodes of Chebyshev's polynomial.
    Nodes,
}

/// Errors that the three points of the arc are to have: the lower end of the band, the upper end,
/// the lower end.
#[derive(Debug, Clone, Copy)]
struct PairTarget {
    /// Points of the arc that these are.
    rule: PairRule,
    band: ToleranceBand,
}

/// Finds the widest pair of contacts by the rule.
pub(crate) fn pair_location(
    request: &LocationRequest,
    side: ContactSide,
    rule: PairRule,
) -> Result<CutterLocation, PositioningError> {
    let mut probe = FaceProbe::new(request.face);
    let frame = EndPointFrame::new(request, side, &mut probe)?;
    let concave = frame.first.curvatures()[1];
    if concave * frame.lift >= 1.0 {
        let (uv, minor) = (request.at, frame.minor);
        return Err(PositioningError::ConcaveRadius { uv, concave: 1.0 / concave, minor });
    }
    let search = PairSearch { request, side, frame, band: request.band.inner() };
    let mut refused = None;
    for solution in search.solutions(rule, &mut probe)? {
        match search.settle(&solution, rule, &mut probe) {
            Ok(location) => return Ok(location),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    let range = request.offset_range;
    Err(refused.unwrap_or(PositioningError::NoPair { uv: request.at, range }))
}

struct PairSearch<'a> {
    request: &'a LocationRequest<'a>,
    side: ContactSide,
    frame: EndPointFrame,
    band: ToleranceBand,
}

/// A placement, the deviations of its errors from their targets, and their derivatives by `(w, alpha, theta)`.
#[derive(Debug, Clone, Copy)]
struct PairTrial {
    placement: TorusPlacement,
    off: Vector3<f64>,
    rates: Matrix3<f64>,
}

impl PairSearch<'_> {
    /// Returns all solutions within the offset range, widest first.
    fn solutions(
        &self,
        rule: PairRule,
        probe: &mut FaceProbe,
    ) -> Result<Vec<PairTrial>, PositioningError> {
        let [low, high] = self.request.offset_range.ends();
        let count = ((high - low) / SPACING).ceil().clamp(1.0, 100.0);
        let mut found: Vec<PairTrial> = Vec::new();
        // Starts in the middle of equal parts of the offset range.
        let shares = (0..100).map(f64::from).take_while(|k| *k < count).map(|k| (k + 0.5) / count);
        for share in shares {
            let Some(start) = self.start(low + (high - low) * share) else { continue };
            // The nodes need no shape of the curve; from there its extrema are near.
            let target = PairTarget { rule: PairRule::Nodes, band: self.band };
            let mut solution = self.newton(start, target, probe)?;
            if let (PairRule::Extrema, Some(nodes)) = (rule, &solution) {
                let target = PairTarget { rule, band: self.band };
                solution = self.newton(nodes.placement.x, target, probe)?;
            }
            let Some(solution) = solution else { continue };
            let [_, alpha, theta] = solution.placement.x;
            let inside = alpha >= low && alpha <= high && theta.abs() <= MOST_ROTATION;
            let known = found.iter().any(|other| (other.placement.x[1] - alpha).abs() < APART);
            if inside && !known {
                found.push(solution);
            }
        }
        let width = |trial: &PairTrial| EndPointFrame::width(trial.placement.x);
        found.sort_by(|a, b| width(b).total_cmp(&width(a)));
        Ok(found)
    }

    /// Solution for a surface of constant curvature: with `s = sin^2(psi/2)` the error is
    /// `b s + c s^2` above that of the arc's middle, `c = 2 R^2 (k_chord - k_feed)` of the offset
    /// surface; end points and middle are level, and a band deep, for `c s_end^2 = 4 band` and
    /// `b = -c s_end`.
    fn start(&self, alpha: f64) -> Option<[f64; 3]> {
        let frame = &self.frame;
        let bend =
            |turn: f64| offset_curvature(&frame.first, &frame.direction(alpha + turn), frame.lift);
        let (chord, feed) = (bend(0.0)?, bend(FRAC_PI_2)?);
        // Without c > 0 the error does not fall from the middle and rise again to the ends.
        let fourth = 2.0 * frame.major * frame.major * (chord - feed);
        let band = self.band.upper - self.band.lower;
        if fourth <= 0.0 {
            return None;
        }
        // The chord ends where the circle does.
        let end = (4.0 * band / fourth).sqrt().min(0.4);
        // Chord of the arc psi_end, 2 R sin(psi_end), with sin(psi_end) = 2 sqrt(s (1 - s)) for s =
        // sin^2(psi_end / 2).
        let w = 2.0 * frame.major * 2.0 * (end * (1.0 - end)).sqrt();
        // From b = -c s_end, where b = 2 R (sin(theta) - R k_chord).
        let lean = frame.major * (chord - (chord - feed) * end);
        // Measured from the normals at the end points, not from that below the arc's middle.
        let theta = math::asin(lean.clamp(-0.9, 0.9)) - 2.0 * frame.major * feed * end;
        Some([w, alpha, theta.clamp(-MOST_ROTATION, MOST_ROTATION)])
    }

    fn newton(
        &self,
        start: [f64; 3],
        target: PairTarget,
        probe: &mut FaceProbe,
    ) -> Result<Option<PairTrial>, PositioningError> {
        let Some(mut trial) = self.trial(start, target, None, probe)? else { return Ok(None) };
        let met = MET * (self.band.upper - self.band.lower);
        for _ in 0..STEPS {
            if trial.off.amax() <= met {
                return Ok(Some(trial));
            }
            // Singular: the three errors do not move independently of each other.
            let Some(inverse) = trial.rates.try_inverse() else { return Ok(None) };
            let step = -(inverse * trial.off);
            let [w, _, theta] = trial.placement.x;
            // No unknown moves by more than its bold step, as the linearisation holds only so far.
            let bold = Vector3::new(0.3 * w, 0.15, (0.3 * theta.abs()).max(0.02));
            let mut share = 1.0 / step.component_div(&bold).amax().max(1.0);
            let mut closer = None;
            for _ in 0..SHORTENINGS {
                let x = Vector3::from(trial.placement.x) + step * share;
                let next = self.trial(x.into(), target, Some(&trial), probe)?;
                // Plain backtracking on the residual keeps Newton's method from cycling.
                closer = next.filter(|next| next.off.norm() < trial.off.norm());
                if closer.is_some() {
                    break;
                }
                share *= 0.5;
            }
            let Some(closer) = closer else { return Ok(None) };
            trial = closer;
        }
        Ok(None)
    }

    fn trial(
        &self,
        x: [f64; 3],
        PairTarget { rule, band }: PairTarget,
        near: Option<&PairTrial>,
        probe: &mut FaceProbe,
    ) -> Result<Option<PairTrial>, PositioningError> {
        let guess = near.map(|near| near.placement.second.foot.uv.into());
        // The direction of the offset stays on the strip's side.
        if x[0] <= 0.0 || x[1].abs() >= FRAC_PI_2 {
            return Ok(None);
        }
        let Some(placement) = self.frame.place(x, probe, guess)? else { return Ok(None) };
        let circle = ErrorCircle { ring: placement.ring, minor: self.frame.minor };
        let points = match rule {
            PairRule::Extrema => self.extrema(&placement, &circle, probe)?,
            PairRule::Nodes => Some(self.nodes(&placement, &circle, probe)?),
        };
        let Some(points) = points else { return Ok(None) };
        // Contact, maximum, contact: three equations for (w, alpha, theta).
        let aims = [band.lower, band.upper, band.lower];
        let mut off = Vector3::zeros();
        let mut rates = Matrix3::zeros();
        for (row, (point, aim)) in points.iter().zip(aims).enumerate() {
            let share = point.sample.psi / placement.half_arc;
            let gradient = placement.arc_gradient(share, &point.sample);
            off[row] = point.value - aim;
            rates.set_row(row, &Vector3::from(gradient).transpose());
        }
        Ok(Some(PairTrial { placement, off, rates }))
    }

    /// Reads the errors at the nodes.
    fn nodes(
        &self,
        placement: &TorusPlacement,
        circle: &ErrorCircle,
        probe: &mut FaceProbe,
    ) -> Result<[ErrorExtremum; 3], PositioningError> {
        let node = FRAC_1_SQRT_2 * placement.half_arc;
        let first = circle.read(-node, self.frame.first.foot.uv.into(), probe)?;
        let middle = circle.read_from(0.0, &first, probe)?;
        let last = circle.read_from(node, &middle, probe)?;
        Ok([first, middle, last].map(|sample| {
            let value = sample.error;
            ErrorExtremum { sample, value, maximum: false }
        }))
    }

    /// Finds the highest maximum between two minima of the arc, and the lowest of those on either side.
    fn extrema(
        &self,
        placement: &TorusPlacement,
        circle: &ErrorCircle,
        probe: &mut FaceProbe,
    ) -> Result<Option<[ErrorExtremum; 3]>, PositioningError> {
        let samples = circle.front(placement.half_arc, INTERVALS, &self.frame.first, probe)?;
        let extrema = circle.extrema(&samples, probe)?;
        let lowest = |some: &[ErrorExtremum]| {
            let minima = some.iter().filter(|extremum| !extremum.maximum);
            minima.min_by(|a, b| a.value.total_cmp(&b.value)).copied()
        };
        let mut highest: Option<[ErrorExtremum; 3]> = None;
        for (place, middle) in extrema.iter().enumerate() {
            let (before, after) = extrema.split_at(place);
            let (Some(a), Some(b), true) = (lowest(before), lowest(after), middle.maximum) else {
                continue;
            };
            if highest.is_none_or(|[_, highest, _]| middle.value > highest.value) {
                highest = Some([a, *middle, b]);
            }
        }
        Ok(highest)
    }

    /// Accepts or refuses a solution. The extrema of Hermite-Chebyshev lie next to the nodes, and a little beyond
    /// the band: the errors aimed at are moved until they do not.
    fn settle(
        &self,
        solution: &PairTrial,
        rule: PairRule,
        probe: &mut FaceProbe,
    ) -> Result<CutterLocation, PositioningError> {
        let Self { request, side, frame, .. } = *self;
        let mut solution = *solution;
        let mut band = self.band;
        for _ in 0..CORRECTIONS {
            if rule == PairRule::Extrema {
                break;
            }
            let circle = ErrorCircle { ring: solution.placement.ring, minor: frame.minor };
            let extrema = self.extrema(&solution.placement, &circle, probe)?;
            let Some([a, middle, b]) = extrema else { break };
            // Amounts by which the extrema beside the nodes lie outside the band.
            let low = (self.band.lower - a.value.min(b.value)).max(0.0);
            let high = (middle.value - self.band.upper).max(0.0);
            if low <= 0.0 && high <= 0.0 {
                break;
            }
            let spare = MET * (band.upper - band.lower);
            band.lower += low + spare;
            band.upper -= high + spare;
            let target = PairTarget { rule, band };
            let corrected = self.newton(solution.placement.x, target, probe)?;
            let Some(corrected) = corrected else { break };
            solution = corrected;
        }
        let proposal = PoseProposal::through(request, side, &frame, &solution.placement);
        accept_proposal(request, &frame, &proposal, probe)
    }
}
