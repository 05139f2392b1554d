//! The paper's own search: three loops inside one another, over the offset direction by a grid, over
//! the offset by bisection, over the rotation by steps until a sample touches.
//!
//! Source: `docs/sources.md#004`, sections 2.1 to 2.3, with the errata named there.

use crate::math;
use crate::positioning::active::ActiveConstraint;
use crate::positioning::check::acceptance::{accept_measured, accept_proposal};
use crate::positioning::check::proposal::{PoseProposal, gouge_depth, measure_proposal};
use crate::positioning::distance::circle::{ErrorCircle, ErrorSample};
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::location::CutterLocation;
use crate::positioning::request::{ContactSide, LocationRequest, ToleranceBand};
use crate::positioning::solve::conditions::{AT_END, CHORD, offset_curvature};
use crate::positioning::solve::placement::{EndPointFrame, MOST_ROTATION, TorusPlacement};
use crate::types::Interval;
use std::f64::consts::PI;

/// Resolution of the nested search. The paper leaves the numbers open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NestedGrid {
    /// Samples on the arc between the end points, these left out: `N`, odd in the paper.
    pub front: u32,
    /// Samples on the rest of the circle: `M`.
    pub rear: u32,
    /// Parts into which the interval of the offset direction is divided: `n`, 3 or more.
    pub directions: u32,
    /// Interval of the offset at which its bisection ends \[mm\]: `delta1`.
    pub offset: f64,
    /// Interval of the offset direction at which the search ends \[rad\]: `delta2`.
    pub direction: f64,
    /// Error at which a sample touches \[mm\]: `epsilon`.
    pub touch: f64,
}

impl NestedGrid {
    fn check(&self) -> Result<(), PositioningError> {
        let counts = [
            ("samples of the front", self.front, 1.0),
            ("samples of the rear", self.rear, 1.0),
            ("parts of the offset range", self.directions, 3.0),
        ];
        for (name, count, least) in counts {
            let (value, must) = (f64::from(count), "at least 1; parts, 3");
            if value < least {
                return Err(PositioningError::Parameter { name, value, must });
            }
        }
        let lengths = [
            ("last interval of the offset", self.offset),
            ("last interval of the offset direction", self.direction),
            ("error that touches", self.touch),
        ];
        for (name, value) in lengths {
            if !(value > 0.0 && value.is_finite()) {
                return Err(PositioningError::Parameter { name, value, must: "above 0" });
            }
        }
        Ok(())
    }
}

/// Steps of the rotation until a sample touches. Each leaves a share of the error that grows with
/// the surface's slope and curvature under the sample.
const ROTATIONS: u32 = 60;

/// Halvings of the offset until a first one fits.
const HALVINGS: u32 = 12;

/// Bisections of the offset, and narrowings of the direction: only intervals below the spacing of
/// numbers need more.
const BISECTIONS: u32 = 60;

/// Corrections of the band by what lies outside of it between the samples.
const CORRECTIONS: u32 = 6;

/// Part of what lies outside by which it is corrected: the next grid lies differently.
const SPARE: f64 = 1.5;

/// Finds the widest strip by the nested search.
pub(crate) fn nested_location(
    request: &LocationRequest,
    side: ContactSide,
    grid: &NestedGrid,
) -> Result<CutterLocation, PositioningError> {
    grid.check()?;
    let mut probe = FaceProbe::new(request.face);
    let frame = EndPointFrame::new(request, side, &mut probe)?;
    let concave = frame.first.curvatures()[1];
    if concave * frame.lift >= 1.0 {
        let (uv, minor) = (request.at, frame.minor);
        return Err(PositioningError::ConcaveRadius { uv, concave: 1.0 / concave, minor });
    }
    let mut search = NestedSearch { grid, frame, band: request.band.inner() };
    let Some(mut best) = search.direction(request.offset_range, &mut probe)? else {
        return Err(PositioningError::NoStrip {
            uv: request.at,
            smallest: request.narrowest_strip(),
            excess: f64::INFINITY,
            binding: ActiveConstraint::Touch,
        });
    };
    for _ in 0..CORRECTIONS {
        let proposal = PoseProposal::through(request, side, &frame, &best);
        let strip = measure_proposal(request, &frame, &proposal, &mut probe)?;
        let depth = gouge_depth(request.band, &strip);
        let over = search.overshoot(&best, request.band, &mut probe)?;
        if depth <= 0.0 && over <= 0.0 {
            return accept_measured(request, &frame, &proposal, &strip, &mut probe);
        }
        // Between the samples the error falls a little below what touches there, only a
        // pseudo-contact, and rises a little above the highest.
        search.band.lower += SPARE * depth;
        search.band.upper -= SPARE * over;
        let again = search.offset(best.x[1], best.x[0], &mut probe)?;
        let Some(again) = again else { break };
        best = again;
    }
    let proposal = PoseProposal::through(request, side, &frame, &best);
    accept_proposal(request, &frame, &proposal, &mut probe)
}

struct NestedSearch<'a> {
    grid: &'a NestedGrid,
    frame: EndPointFrame,
    band: ToleranceBand,
}

impl NestedSearch<'_> {
    /// Section 2.3: searches the best of the directions, then the interval between its neighbours. The printed
    /// test narrows the interval of the offset.
    fn direction(
        &self,
        range: Interval,
        probe: &mut FaceProbe,
    ) -> Result<Option<TorusPlacement>, PositioningError> {
        let [mut low, mut high] = range.ends();
        let mut best: Option<TorusPlacement> = None;
        let parts = self.grid.directions;
        for _ in 0..BISECTIONS {
            // One round of the grid: n + 1 directions, each started from the offset of its
            // neighbour.
            let step = (high - low) / f64::from(parts);
            let mut from = self.frame.major;
            let mut widest: Option<TorusPlacement> = None;
            for k in 0..=parts {
                let alpha = low + step * f64::from(k);
                let found = self.offset(alpha, from, probe)?;
                from = found.as_ref().map_or(self.frame.major, |found| found.x[0]);
                widen(&mut widest, found.as_ref());
            }
            widen(&mut best, widest.as_ref());
            let Some(found) = widest else { break };
            if high - low <= self.grid.direction {
                break;
            }
            let alpha = found.x[1];
            // The maximum lies within one step of the best grid point if the width has one maximum.
            [low, high] = [(alpha - step).max(low), (alpha + step).min(high)];
        }
        Ok(best)
    }

    /// Section 2.2: finds the largest offset that keeps the band, between one that does and one that does
    /// not. Below `sqrt(8 R e)` none does; the printed halving would never end.
    fn offset(
        &self,
        alpha: f64,
        from: f64,
        probe: &mut FaceProbe,
    ) -> Result<Option<TorusPlacement>, PositioningError> {
        let frame = &self.frame;
        let diameter = 2.0 * CHORD * frame.major;
        let bend = offset_curvature(&frame.first, &frame.direction(alpha), frame.lift);
        let Some(bend) = bend else { return Ok(None) };
        // A circle that leans all the way bends by 1 / R; the surface may bend away from it.
        let most = frame.major.recip() - bend.min(0.0);
        let least = (8.0 * (self.band.upper - self.band.lower) / most).sqrt();
        let mut low = from.min(diameter);
        let mut fitting = self.fitting([low, alpha], probe)?;
        let mut high = diameter;
        // Halve from an offset that does not fit to the first one that does.
        for _ in 0..HALVINGS {
            if fitting.is_some() || low < least {
                break;
            }
            high = low;
            low *= 0.5;
            fitting = self.fitting([low, alpha], probe)?;
        }
        let Some(mut best) = fitting else { return Ok(None) };
        for _ in 0..BISECTIONS {
            if high - low <= self.grid.offset {
                break;
            }
            let middle = 0.5 * (low + high);
            // Invariant of the bisection: `low` fits, `high` does not.
            match self.fitting([middle, alpha], probe)? {
                Some(found) => (low, best) = (middle, found),
                None => high = middle,
            }
        }
        Ok(Some(best))
    }

    /// Section 2.1 and the conditions: finds the placement whose lowest sample of the front touches, if
    /// no other one leaves the band and the rear stays above its lower end.
    fn fitting(
        &self,
        [w, alpha]: [f64; 2],
        probe: &mut FaceProbe,
    ) -> Result<Option<TorusPlacement>, PositioningError> {
        let count = self.grid.front;
        // The ends lie at the upper end of the band whatever the rotation, and have no lever.
        let share = |k: u32| 2.0 * f64::from(k) / f64::from(count + 1) - 1.0;
        let mut theta = 0.0;
        // Turn until the middle sample touches; others may then lie below.
        let middle = share(count.div_ceil(2));
        let Some(touching) = self.turn([w, alpha, theta], middle, probe)? else { return Ok(None) };
        theta = touching;
        let Some(mut placement) = self.frame.place([w, alpha, theta], probe, None)? else {
            return Ok(None);
        };
        let mut front = self.front(&placement, probe)?;
        let below: Vec<f64> = (1..=count)
            .zip(&front)
            .filter(|(_, sample)| sample.error < self.band.lower - self.grid.touch)
            .map(|(k, _)| share(k))
            .collect();
        if !below.is_empty() {
            // Each sample that lies too deep asks for less rotation; the least of them frees all.
            for share in below {
                let turned = self.turn([w, alpha, touching], share, probe)?;
                theta = theta.min(turned.unwrap_or(f64::NEG_INFINITY));
            }
            let placed = self.frame.place([w, alpha, theta.max(-MOST_ROTATION)], probe, None)?;
            let Some(placed) = placed.filter(|_| theta >= -MOST_ROTATION) else { return Ok(None) };
            placement = placed;
            front = self.front(&placement, probe)?;
        }
        let touch = self.grid.touch;
        let ToleranceBand { lower, upper } = self.band;
        let within = |s: &ErrorSample| s.error <= upper && s.error >= lower - touch;
        if !front.iter().all(within) {
            return Ok(None);
        }
        let circle = self.circle(&placement);
        let Some(last) = front.last() else { return Ok(None) };
        let half = placement.half_arc;
        let step = 2.0 * (PI - half) / f64::from(self.grid.rear + 1);
        let rear =
            circle.walk((1..=self.grid.rear).map(|k| half + step * f64::from(k)), last, probe)?;
        Ok(rear.iter().all(|sample| sample.error >= lower).then_some(placement))
    }

    /// Returns the height by which the error between the contacts exceeds the band \[mm\].
    fn overshoot(
        &self,
        placement: &TorusPlacement,
        band: ToleranceBand,
        probe: &mut FaceProbe,
    ) -> Result<f64, PositioningError> {
        let circle = self.circle(placement);
        let half = placement.half_arc;
        let samples = circle.front(half, self.grid.front, &self.frame.first, probe)?;
        let extrema = circle.extrema(&samples, probe)?;
        let inside = extrema.iter().filter(|e| e.maximum && e.sample.psi.abs() <= AT_END * half);
        Ok(inside.map(|extremum| extremum.value - band.upper).fold(0.0, f64::max))
    }

    fn circle(&self, placement: &TorusPlacement) -> ErrorCircle {
        ErrorCircle { ring: placement.ring, minor: self.frame.minor }
    }

    /// Reads samples of the front, ends left out.
    fn front(
        &self,
        placement: &TorusPlacement,
        probe: &mut FaceProbe,
    ) -> Result<Vec<ErrorSample>, PositioningError> {
        let circle = self.circle(placement);
        let half = placement.half_arc;
        let step = 2.0 * half / f64::from(self.grid.front + 1);
        let start = circle.read(step - half, self.frame.first.foot.uv.into(), probe)?;
        let angles = (2..=self.grid.front).map(|k| step * f64::from(k) - half);
        let mut samples = circle.walk(angles, &start, probe)?;
        samples.insert(0, start);
        Ok(samples)
    }

    /// Finds the rotation at which the sample at a share of half the arc touches: `theta += p / L`, `L` its
    /// distance from the chord, `R (cos(psi) - cos(half))`.
    fn turn(
        &self,
        [w, alpha, mut theta]: [f64; 3],
        share: f64,
        probe: &mut FaceProbe,
    ) -> Result<Option<f64>, PositioningError> {
        let mut guess = None;
        for _ in 0..ROTATIONS {
            let Some(placement) = self.frame.place([w, alpha, theta], probe, None)? else {
                return Ok(None);
            };
            let psi = share * placement.half_arc;
            let from = guess.unwrap_or(self.frame.first.foot.uv);
            let sample = self.circle(&placement).read(psi, from.into(), probe)?;
            guess = Some(sample.reading.foot.uv);
            let over = sample.error - self.band.lower;
            if over.abs() < self.grid.touch {
                return Ok(Some(theta));
            }
            // A rotation by d(theta) lowers the sample by its distance from the chord times
            // d(theta).
            let lever = self.frame.major * (math::cos(psi) - math::cos(placement.half_arc));
            theta += over / lever;
            if theta.abs() > MOST_ROTATION {
                return Ok(None);
            }
        }
        Ok(None)
    }
}

/// Keeps the wider placement.
fn widen(best: &mut Option<TorusPlacement>, found: Option<&TorusPlacement>) {
    let width = |placement: &TorusPlacement| EndPointFrame::width(placement.x);
    if let Some(found) = found
        && best.as_ref().is_none_or(|best| width(found) > width(best))
    {
        *best = Some(*found);
    }
}
