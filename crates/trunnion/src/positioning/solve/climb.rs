//! The widest strip as a constrained maximum over `x = (w, alpha, theta)`.
//!
//! Sequential quadratic programming with a trust region: the conditions that matter (the local
//! extrema of the error along the circle and the slopes at the end points) are linearised with
//! exact derivatives, so that at a corner where three of them bind (two contacts and a middle) the
//! steps are Newton's on the active set; along a smooth optimum a BFGS estimate of the curvature
//! of the Lagrangian takes over. One slack, priced, keeps every program solvable, and starts
//! that break the band find back into it.

use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::solve::conditions::ExtremaSource;
use crate::positioning::solve::conditions::{ProblemState, StripProblem};
use crate::positioning::solve::initial_guesses::InitialGuess;
use crate::positioning::solve::model::{QuadraticModel, TrustStep, curved_values};
use crate::positioning::solve::optimum::LocalOptimum;

/// Outer steps; warm starts take 3 to 6, cold ones 10 to 30.
const STEPS: u32 = 80;

/// A climb whose model promises less than this share of the width has converged.
pub(crate) const ARRIVED: f64 = 1e-7;

/// The same for rough climbs from several guesses.
pub(crate) const ROUGHLY: f64 = 1e-3;

/// Share of the band by which conditions are badly broken: no climb that can reach the band ends this
/// far off.
pub(crate) const BADLY: f64 = 1e-2;

/// Trust region in which a step may still hope to mend that, and the share of a breach that has to
/// stay for it to be without hope.
const BOLD: f64 = 0.02;

const MENDED: f64 = 0.98;

/// A trust region this small (share of the start's scales) has nothing left to try.
const SMALLEST: f64 = 1e-9;

impl StripProblem {
    /// Climbs from `start` to a local optimum, until a step promises less than `arrived` of the
    /// width; `None` where the start has no placement.
    ///
    /// The result may break its conditions if the climb found no point that keeps them.
    pub(crate) fn climb(
        &self,
        start: &InitialGuess,
        arrived: f64,
        probe: &mut FaceProbe,
    ) -> Result<Option<LocalOptimum>, PositioningError> {
        let Some(state) = self.state(start.x, probe, None)? else { return Ok(None) };
        self.ascend(state, start, arrived, probe).map(Some)
    }

    /// Climbs from a state to a local optimum.
    pub(crate) fn ascend(
        &self,
        mut state: ProblemState,
        start: &InitialGuess,
        arrived: f64,
        probe: &mut FaceProbe,
    ) -> Result<LocalOptimum, PositioningError> {
        let mut model = QuadraticModel::new(self, start);
        let mut trust = start.trust;
        let mut multipliers = Vec::new();
        for _ in 0..STEPS {
            // Quadratic program of the local model within the trust region.
            let Some(step) = model.step(&state, trust) else { break };
            multipliers.clone_from(&step.multipliers);
            if self.extrema == ExtremaSource::Followed && self.is_stuck(&state, &step, trust) {
                break;
            }
            // Converged: the model promises next to nothing, or the region has collapsed.
            if step.gain <= arrived * start.scale[0] || trust < SMALLEST {
                break;
            }
            let Some((trial, gained)) = self.attempt(&model, &state, &step, trust, probe)? else {
                trust *= 0.25;
                continue;
            };
            // Ratio of actual to promised gain: a model that holds may reach farther, one that does
            // not less far.
            if gained > 0.7 * step.gain {
                trust = (2.0 * trust).min(4.0);
            } else if gained < 0.2 * step.gain {
                trust *= 0.4;
            }
            // Multipliers at the price belong to the way back into the band, not to the optimum.
            if step.slack <= 0.0 {
                model.learn([&state, &trial], &step.multipliers);
            }
            if gained > 0.0 {
                state = trial;
            }
        }
        let [low, high] = start.offset_range.ends();
        let alpha = state.placement.x[1];
        // The model clamps alpha to its range, so equality is exact there.
        let at_range_end = alpha <= low || alpha >= high;
        multipliers.resize(state.conditions.len(), 0.0);
        Ok(LocalOptimum { state, multipliers, at_range_end })
    }

    /// Returns `true` if conditions stay broken however bold the step: to first order nothing in reach
    /// keeps them.
    fn is_stuck(&self, state: &ProblemState, step: &TrustStep, trust: f64) -> bool {
        let broken = state.breach();
        let badly = broken > BADLY * (self.band.upper - self.band.lower);
        badly && trust >= BOLD && step.slack >= MENDED * broken
    }

    /// Evaluates the state that a step leads to.
    fn next(
        &self,
        x: [f64; 3],
        probe: &mut FaceProbe,
        from: &ProblemState,
    ) -> Result<Option<ProblemState>, PositioningError> {
        if self.extrema == ExtremaSource::Followed
            && let Some(state) = self.followed(x, probe, from)?
        {
            return Ok(Some(state));
        }
        self.state(x, probe, Some(from))
    }

    /// Evaluates a step; one that disappoints is corrected once for the curvature of the
    /// conditions (without it, steps along curved conditions are refused however close to the
    /// optimum: Maratos' effect). `None` where the cutter cannot be placed.
    fn attempt(
        &self,
        model: &QuadraticModel,
        state: &ProblemState,
        step: &TrustStep,
        trust: f64,
        probe: &mut FaceProbe,
    ) -> Result<Option<(ProblemState, f64)>, PositioningError> {
        let Some(trial) = self.next(step.x, probe, state)? else { return Ok(None) };
        let gained = model.merit(state) - model.merit(&trial);
        if gained >= 0.2 * step.gain || trial.breach() <= 0.0 {
            return Ok(Some((trial, gained)));
        }
        // Second-order correction: the same program with the conditions as the trial found them.
        let values = curved_values(state, &trial);
        let Some(corrected) = model.step_to(state, trust, &values) else {
            return Ok(Some((trial, gained)));
        };
        let Some(second) = self.next(corrected.x, probe, state)? else {
            return Ok(Some((trial, gained)));
        };
        let better = model.merit(state) - model.merit(&second);
        Ok(Some(if better > gained { (second, better) } else { (trial, gained) }))
    }
}
