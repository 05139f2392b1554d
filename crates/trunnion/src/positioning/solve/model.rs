//! Quadratic model of one step of the search.

use crate::math;
use crate::positioning::solve::conditions::{ProblemState, StripCondition, StripProblem};
use crate::positioning::solve::initial_guesses::InitialGuess;
use crate::positioning::solve::placement::EndPointFrame;
use crate::positioning::solve::quadratic::{LinearConstraint, minimise};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// The local model of one step.
pub(crate) struct QuadraticModel<'a> {
    problem: &'a StripProblem,
    start: &'a InitialGuess,
    /// Curvature of the Lagrangian in scaled unknowns.
    hessian: Matrix3<f64>,
    /// Price of the slack \[mm width per mm\].
    price: f64,
}

pub(crate) struct TrustStep {
    pub(crate) x: [f64; 3],
    /// Expected fall of the merit function \[mm\].
    pub(crate) gain: f64,
    /// By how much the worst condition of the model stays broken \[mm\].
    pub(crate) slack: f64,
    pub(crate) multipliers: Vec<f64>,
}

impl<'a> QuadraticModel<'a> {
    pub(crate) fn new(problem: &'a StripProblem, start: &'a InitialGuess) -> Self {
        let width = start.scale[0];
        let band = problem.band.upper - problem.band.lower;
        QuadraticModel {
            problem,
            start,
            // Of w cos(alpha) only alpha has a curvature, -w; the rest keeps the model strict.
            hessian: Matrix3::from_diagonal(&Vector3::new(1e-3, 4e-2, 1e-3)) * width,
            // The width grows like a root of the band, so that its price is a few widths a band.
            price: 3.0 * width / band,
        }
    }

    pub(crate) fn merit(&self, state: &ProblemState) -> f64 {
        self.price * state.breach() - EndPointFrame::width(state.placement.x)
    }

    fn scaled(&self, gradient: [f64; 3]) -> Vector3<f64> {
        Vector3::from(gradient).component_mul(&Vector3::from(self.start.scale))
    }

    fn width_gradient(&self, [w, alpha, _]: [f64; 3]) -> Vector3<f64> {
        self.scaled([math::cos(alpha), -w * math::sin(alpha), 0.0])
    }

    /// Returns the best step of the model within the trust region; raises the price while a higher one
    /// removes slack. Where the trust region is what keeps the conditions out of reach no price
    /// helps, and a needless one would drown the width.
    pub(crate) fn step(&mut self, state: &ProblemState, trust: f64) -> Option<TrustStep> {
        const RAISES: u32 = 6;
        let values: Vec<f64> = state.conditions.iter().map(|c| c.value).collect();
        let mut step = self.step_to(state, trust, &values)?;
        for _ in 0..RAISES {
            let total: f64 = step.multipliers.iter().sum();
            if total < 0.99 * self.price {
                break;
            }
            let before = self.price;
            self.price *= 4.0;
            let dearer = self.step_to(state, trust, &values);
            match dearer {
                Some(dearer) if dearer.slack < 0.99 * step.slack => step = dearer,
                _ => {
                    self.price = before;
                    break;
                }
            }
        }
        Some(step)
    }

    /// Returns the best step of the model at the current price, the conditions worth `values`.
    pub(crate) fn step_to(
        &self,
        state: &ProblemState,
        trust: f64,
        values: &[f64],
    ) -> Option<TrustStep> {
        let x = state.placement.x;
        let band = self.problem.band.upper - self.problem.band.lower;
        let conditions = &state.conditions;
        let mut constraints: Vec<LinearConstraint> = conditions
            .iter()
            .zip(values)
            .map(|(condition, value)| {
                // c + grad c . d + slack >= 0, in units of the band.
                let g = self.scaled(condition.gradient) / band;
                let normal = Vector4::new(g.x, g.y, g.z, 1.0);
                LinearConstraint { normal, bound: -value / band }
            })
            .collect();
        constraints.push(LinearConstraint { normal: Vector4::w(), bound: 0.0 });
        constraints.extend(self.walls(x, trust));
        // The slack is counted in bands; its own curvature only makes the program strict.
        let price = self.price * band;
        let mut inverse = Matrix4::zeros();
        inverse.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.hessian.try_inverse()?);
        inverse[(3, 3)] = 100.0 / price;
        let g = self.width_gradient(x);
        let gain = Vector4::new(g.x, g.y, g.z, -price);
        let solution = minimise(&inverse, &gain, &constraints)?;
        let d = solution.x.fixed_rows::<3>(0).into_owned();
        let slack = solution.x.w.max(0.0) * band;
        // Increase of the width promised by the quadratic model.
        let rise = g.dot(&d) - 0.5 * d.dot(&(self.hessian * d));
        let [low, high] = self.start.offset_range.ends();
        let [flat, steep] = self.start.rotation_range.ends();
        let scale = self.start.scale;
        Some(TrustStep {
            x: [
                x[0] + d.x * scale[0],
                (x[1] + d.y * scale[1]).clamp(low, high),
                (x[2] + d.z * scale[2]).clamp(flat, steep),
            ],
            gain: rise + self.price * (state.breach() - slack),
            slack,
            multipliers: solution
                .multipliers
                .iter()
                .take(conditions.len())
                .map(|multiplier| multiplier / band)
                .collect(),
        })
    }

    /// Returns the trust region and ranges of the unknowns, as distances from `x` in scaled unknowns.
    fn walls(&self, x: [f64; 3], trust: f64) -> [LinearConstraint; 6] {
        let [low, high] = self.start.offset_range.ends();
        let [flat, steep] = self.start.rotation_range.ends();
        // Half of w is as far as a linear model of a chord reaches down.
        let least = [0.5 * x[0], low, flat];
        let most = [f64::INFINITY, high, steep];
        let mut walls = [LinearConstraint { normal: Vector4::zeros(), bound: 0.0 }; 6];
        for k in 0..3 {
            let scale = self.start.scale[k];
            walls[2 * k].normal[k] = 1.0;
            walls[2 * k].bound = ((least[k] - x[k]) / scale).max(-trust).min(0.0);
            walls[2 * k + 1].normal[k] = -1.0;
            walls[2 * k + 1].bound = -((most[k] - x[k]) / scale).min(trust).max(0.0);
        }
        walls
    }

    /// Makes a damped BFGS update of the Lagrangian's curvature between two states that share the
    /// conditions that bind.
    pub(crate) fn learn(&mut self, [from, to]: [&ProblemState; 2], multipliers: &[f64]) {
        // Change of the gradient of the Lagrangian -width - sum(multiplier * condition).
        let mut turned =
            self.width_gradient(from.placement.x) - self.width_gradient(to.placement.x);
        for (condition, multiplier) in from.conditions.iter().zip(multipliers) {
            if *multiplier > 0.0 {
                let Some(later) = twin(condition, to) else { return };
                let change = Vector3::from(later.gradient) - Vector3::from(condition.gradient);
                turned -= self.scaled(change.into()) * *multiplier;
            }
        }
        let step = Vector3::from(to.placement.x) - Vector3::from(from.placement.x);
        let s = step.component_div(&Vector3::from(self.start.scale));
        let y = turned;
        // BFGS: B + y y' / (s . y) - B s s' B / (s . B s).
        let bs = self.hessian * s;
        let sbs = s.dot(&bs);
        let size = s.norm_squared();
        if sbs <= 0.0 || size <= 0.0 {
            return;
        }
        // Powell's damping keeps the estimate positive.
        let share = if s.dot(&y) >= 0.2 * sbs { 1.0 } else { 0.8 * sbs / (sbs - s.dot(&y)) };
        let y = y * share + bs * (1.0 - share);
        let update = self.hessian - bs * bs.transpose() / sbs + y * y.transpose() / s.dot(&y);
        // Strictness: no direction may lose its curvature altogether.
        let floor = 1e-6 * self.start.scale[0];
        if update.iter().all(|entry| entry.is_finite()) {
            self.hessian = update + Matrix3::identity() * floor;
        }
    }
}

/// Returns the values that the conditions of `state` would need for the linear model to meet `trial`,
/// where the trial has the same condition.
pub(crate) fn curved_values(state: &ProblemState, trial: &ProblemState) -> Vec<f64> {
    let d = Vector3::from(trial.placement.x) - Vector3::from(state.placement.x);
    let value = |condition: &StripCondition| {
        twin(condition, trial).map_or(condition.value, |later| {
            later.value - Vector3::from(condition.gradient).dot(&d)
        })
    };
    state.conditions.iter().map(value).collect()
}

/// Finds the condition of `state` of the same kind, nearest on the circle.
fn twin<'a>(condition: &StripCondition, state: &'a ProblemState) -> Option<&'a StripCondition> {
    let alike = state.conditions.iter().filter(|other| other.kind == condition.kind);
    let apart = |other: &StripCondition| (other.psi - condition.psi).abs();
    alike.min_by(|a, b| apart(a).total_cmp(&apart(b)))
}
