//! The state of a step followed from the one before: every extremum from where it was.

use super::Active;
use super::PositioningError;
use super::circle::Circle;
use super::circle::Extremum;
use super::circle::Sample;
use super::constraints::Condition;
use super::constraints::Problem;
use super::constraints::State;
use super::placement::Placement;
use super::probe::Probe;

/// Angle \[rad\] within which an extremum is followed: its value, corrected by the parabola, is then
/// right to `E''' STRAY^3 / 3`, some 1e-9 mm.
const STRAY: f64 = 2e-3;

/// Newton steps to an extremum before it counts as lost.
const STEPS: u32 = 5;

impl Problem {
    /// The state at `x` by a quarter of the readings that sampling takes; `None` where an extremum
    /// is lost on the way, or the cutter cannot be placed. New extrema go unnoticed.
    pub(super) fn followed(
        &self,
        x: [f64; 3],
        probe: &mut Probe,
        from: &State,
    ) -> Result<Option<State>, PositioningError> {
        let Some(placement) = self.placement(x, probe, Some(from))? else { return Ok(None) };
        let circle = Circle { ring: placement.ring, minor: self.frame.minor };
        let at = (&placement, &circle);
        let mut conditions = vec![self.chord(&placement)];
        let lifted = [&self.frame.first, &placement.second].map(|r| r.lifted(self.frame.lift));
        let ends = [(-1.0, Active::FirstSlope), (1.0, Active::SecondSlope)];
        for ((share, kind), reading) in ends.into_iter().zip(lifted) {
            let end = circle.sample(share * placement.half_arc, &reading);
            conditions.extend(self.end_slope(at, (&end, share, kind), probe)?);
        }
        for condition in &from.conditions {
            let Some(before) = &condition.sample else { continue };
            let Some(found) = follow(at, (condition, before, from), probe)? else {
                return Ok(None);
            };
            conditions.push(if condition.kind == Active::Rear {
                self.outside(&placement, &found)
            } else {
                self.inside(&placement, &found)
            });
        }
        self.disc(&placement, &mut conditions, probe)?;
        self.axis(&placement, &mut conditions);
        Ok(Some(State { placement, conditions, samples: Vec::new() }))
    }
}

/// The extremum of one condition.
fn follow(
    (placement, circle): (&Placement, &Circle),
    (condition, before, from): (&Condition, &Sample, &State),
    probe: &mut Probe,
) -> Result<Option<Extremum>, PositioningError> {
    let half = placement.half_arc;
    let rear = condition.kind == Active::Rear;
    let maximum = condition.kind == Active::Middle;
    let mut psi = if rear { before.psi } else { before.psi * (half / from.placement.half_arc) };
    let mut guess = before.reading.ahead(&(circle.ring.at(psi) - before.at));
    for _ in 0..STEPS {
        let sample = circle.read(psi, guess, probe)?;
        if (sample.bend < 0.0) != maximum || sample.bend.abs() <= 0.0 {
            return Ok(None);
        }
        let step = -sample.slope / sample.bend;
        if step.abs() <= STRAY {
            return Ok(Some(Extremum { sample, value: sample.vertex(), maximum }));
        }
        let next = psi + step;
        if rear != (next.abs() > half) {
            return Ok(None);
        }
        guess = sample.reading.ahead(&(circle.ring.at(next) - sample.at));
        psi = next;
    }
    Ok(None)
}
