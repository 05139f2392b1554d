//! Evaluates a state by following every extremum from the state before.

use crate::positioning::active::ActiveConstraint;
use crate::positioning::distance::circle::{ErrorCircle, ErrorExtremum, ErrorSample};
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::error::PositioningError;
use crate::positioning::location::ExtremumMark;
use crate::positioning::solve::conditions::{ProblemState, StripEnd, StripProblem};
use crate::positioning::solve::placement::TorusPlacement;
use std::f64::consts::{PI, TAU};

/// Angle \[rad\] within which an extremum is followed: its value, corrected by the parabola, is then
/// right to `E''' STRAY^3 / 3`, some 1e-9 mm.
const STRAY: f64 = 2e-3;

/// Newton steps to an extremum before it counts as lost.
const STEPS: u32 = 5;

/// An extremum to be found.
struct SoughtExtremum {
    kind: ActiveConstraint,
    /// Angle near which it is expected \[rad\].
    psi: f64,
    /// Parameters near which its foot is expected.
    guess: [f64; 2],
}

impl StripProblem {
    /// Evaluates the state at `x` by a quarter of the readings that sampling takes.
    ///
    /// `None` where an extremum is lost on the way, or the cutter cannot be placed. New extrema go
    /// unnoticed.
    pub(crate) fn followed(
        &self,
        x: [f64; 3],
        probe: &mut FaceProbe,
        from: &ProblemState,
    ) -> Result<Option<ProblemState>, PositioningError> {
        let Some(placement) = self.placement(x, probe, Some(from))? else { return Ok(None) };
        // Extrema of the front keep their share of the arc, those of the rear their angle.
        let stretch = placement.half_arc / from.placement.half_arc;
        let extrema = from.conditions.iter().filter_map(|condition| {
            let before = condition.sample.as_ref()?;
            let rear = condition.kind == ActiveConstraint::Rear;
            let psi = if rear { before.psi } else { before.psi * stretch };
            // The foot moves with the circle's point to second order.
            let guess = before.reading.ahead(&(placement.ring.at(psi) - before.at));
            Some(SoughtExtremum { kind: condition.kind, psi, guess })
        });
        self.gathered(&placement, extrema, probe)
    }

    /// Evaluates the state at `x` from the extrema of a neighbouring location.
    pub(crate) fn recalled(
        &self,
        x: [f64; 3],
        marks: &[ExtremumMark],
        probe: &mut FaceProbe,
    ) -> Result<Option<ProblemState>, PositioningError> {
        let Some(placement) = self.placement(x, probe, None)? else { return Ok(None) };
        let at: [f64; 2] = self.frame.first.foot.uv.into();
        let extrema = marks.iter().map(|mark| {
            let rear = mark.kind == ActiveConstraint::Rear;
            let psi = if rear { mark.place } else { mark.place * placement.half_arc };
            let guess = [0, 1].map(|k| at[k] + mark.out[k]);
            SoughtExtremum { kind: mark.kind, psi, guess }
        });
        self.gathered(&placement, extrema, probe)
    }

    fn gathered(
        &self,
        placement: &TorusPlacement,
        extrema: impl Iterator<Item = SoughtExtremum>,
        probe: &mut FaceProbe,
    ) -> Result<Option<ProblemState>, PositioningError> {
        let circle = self.circle(placement);
        let mut conditions = Vec::with_capacity(10);
        conditions.push(self.chord(placement));
        let ends = [StripEnd::First, StripEnd::Second];
        for (sample, end) in self.ends(placement).iter().zip(ends) {
            conditions.extend(self.end_slope(placement, sample, end, probe)?);
        }
        for sought in extrema {
            let found = follow(&circle, placement.half_arc, &sought, probe)?;
            let Some(found) = found else { return Ok(None) };
            conditions.push(if sought.kind == ActiveConstraint::Rear {
                self.outside(placement, &found)
            } else {
                self.inside(placement, &found)
            });
        }
        self.disc(placement, &mut conditions, probe)?;
        self.axis(placement, &mut conditions);
        Ok(Some(ProblemState { placement: *placement, conditions, samples: Vec::new() }))
    }

    /// Returns the circle's points over the end points, where the error is given.
    fn ends(&self, placement: &TorusPlacement) -> [ErrorSample; 2] {
        let circle = self.circle(placement);
        let end = |sign: f64, reading: &DistanceReading| {
            circle.sample(sign * placement.half_arc, &reading.lifted(self.frame.lift))
        };
        [end(-1.0, &self.frame.first), end(1.0, &placement.second)]
    }

    /// Returns the samples read round the circle of a state that was followed, over `[-pi, pi]`.
    pub(crate) fn seen(&self, state: &ProblemState) -> Vec<ErrorSample> {
        let mut samples = Vec::with_capacity(8);
        samples.extend(self.ends(&state.placement));
        samples.extend(state.conditions.iter().filter_map(|condition| condition.sample));
        for sample in &mut samples {
            if sample.psi > PI {
                sample.psi -= TAU;
            }
        }
        samples
    }
}

/// Follows the extremum next to an angle, on an arc of half the angle `half`; `None` where it is lost.
fn follow(
    circle: &ErrorCircle,
    half: f64,
    sought: &SoughtExtremum,
    probe: &mut FaceProbe,
) -> Result<Option<ErrorExtremum>, PositioningError> {
    let SoughtExtremum { kind, psi, guess } = *sought;
    let (rear, maximum) = (kind == ActiveConstraint::Rear, kind == ActiveConstraint::Middle);
    let mut sample = circle.read(psi, guess, probe)?;
    for _ in 0..STEPS {
        // The bend has changed its sign: the extremum has merged with a neighbour.
        if (sample.bend < 0.0) != maximum || sample.bend.abs() <= 0.0 {
            return Ok(None);
        }
        let step = -sample.slope / sample.bend;
        if step.abs() <= STRAY {
            sample.followed = true;
            return Ok(Some(ErrorExtremum { sample, value: sample.vertex(), maximum }));
        }
        let next = sample.psi + step;
        // It has moved over an end point, from the strip to the rear or back.
        if rear != (next.abs() > half) {
            return Ok(None);
        }
        sample = circle.read_from(next, &sample, probe)?;
    }
    Ok(None)
}

/// Returns the extrema of a state as marks for neighbouring locations.
pub(crate) fn extremum_marks(state: &ProblemState, at: [f64; 2]) -> Vec<ExtremumMark> {
    let mark = |(kind, sample): (ActiveConstraint, &ErrorSample)| {
        let half = if kind == ActiveConstraint::Rear { 1.0 } else { state.placement.half_arc };
        let uv: [f64; 2] = sample.reading.foot.uv.into();
        ExtremumMark { kind, place: sample.psi / half, out: [0, 1].map(|k| uv[k] - at[k]) }
    };
    let seen = state.conditions.iter().filter_map(|c| Some((c.kind, c.sample.as_ref()?)));
    seen.map(mark).collect()
}
