//! The widest strip as a constrained maximum over `x = (w, alpha, theta)`.
//!
//! Sequential quadratic programming with a trust region: the conditions that matter (the local
//! extrema of the error along the circle and the slopes at the end points) are linearised with
//! exact derivatives, so that at a corner where three of them bind (two contacts and a middle) the
//! steps are Newton's on the active set; along a smooth optimum a BFGS estimate of the curvature
//! of the Lagrangian takes over. One slack, priced, keeps every program solvable, and starts
//! that break the band find back into it.

use super::PositioningError;
use super::check::SPACING;
use super::constraints::Condition;
use super::constraints::Problem;
use super::constraints::State;
use super::gaps::curvatures_under;
use super::location::Mark;
use super::placement::Frame;
use super::probe::Probe;
use super::quadratic;
use super::quadratic::Constraint;
use nalgebra::Matrix3;
use nalgebra::Matrix4;
use nalgebra::Vector3;
use nalgebra::Vector4;

/// Outer steps; warm starts take 3 to 6, cold ones 10 to 30.
const STEPS: u32 = 80;
/// A model that promises less than this share of the width has arrived.
pub(super) const ARRIVED: f64 = 1e-7;
/// The same for a first look at several starts.
pub(super) const ROUGHLY: f64 = 1e-3;
/// Share of the band by which conditions are badly broken: no climb ends this far off in what it
/// reaches.
pub(super) const BADLY: f64 = 1e-2;
/// Trust region in which a step may still hope to mend that, and the share of a breach that has to
/// stay for it to be without hope.
const BOLD: f64 = 0.02;
const MENDED: f64 = 0.98;
/// A trust region this small (share of the start's scales) has nothing left to try.
const SMALLEST: f64 = 1e-9;

/// Where to start, and in which box to stay.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    /// `(w, alpha, theta)`.
    pub(super) x: [f64; 3],
    /// Trust region at first, in units of `scale`.
    pub(super) trust: f64,
    /// Size of a bold step of each unknown.
    pub(super) scale: [f64; 3],
    /// Range of the offset direction \[rad\].
    pub(super) offset_range: [f64; 2],
    /// Range of the rotation \[rad\].
    pub(super) rotation_range: [f64; 2],
}

/// Where the search ended.
#[derive(Debug, Clone)]
pub(super) struct Optimum {
    pub(super) state: State,
    /// Multiplier of each condition, in the order of `state.conditions` \[mm width per mm\].
    pub(super) multipliers: Vec<f64>,
    pub(super) at_range_end: bool,
}

/// The local model of one step.
struct Model<'a> {
    problem: &'a Problem,
    start: &'a Start,
    /// Curvature of the Lagrangian in scaled unknowns.
    hessian: Matrix3<f64>,
    /// Price of the slack \[mm width per mm\].
    price: f64,
}

struct Step {
    x: [f64; 3],
    /// Expected fall of the merit function \[mm\].
    gain: f64,
    /// By how much the worst condition of the model stays broken \[mm\].
    slack: f64,
    multipliers: Vec<f64>,
}

impl Problem {
    /// As [`Problem::climb`] from a neighbour's optimum, whose extrema are followed: the `marks` it
    /// left, where they lead into the band, else those that sampling shows. What is new on the way goes
    /// unnoticed.
    pub(super) fn glide(
        &self,
        (start, marks): (&Start, &[Mark]),
        arrived: f64,
        probe: &mut Probe,
    ) -> Result<Option<Optimum>, PositioningError> {
        let swift = Self { swift: true, ..*self };
        if !marks.is_empty()
            && let Some(state) = swift.recalled(start.x, marks, probe)?
        {
            let optimum = swift.ascend(state, start, arrived, probe)?;
            if optimum.state.breach() <= self.margin() {
                return Ok(Some(optimum));
            }
        }
        swift.climb(start, arrived, probe)
    }

    /// The end of a glide where bounds can tell whether anything was overlooked, with what was read there.
    pub(super) fn known(&self, optimum: &Optimum, probe: &Probe) -> Option<Optimum> {
        let known = optimum.state.breach() <= self.margin() && self.is_known(&optimum.state, probe);
        known.then(|| {
            let state = State { samples: self.seen(&optimum.state), ..optimum.state.clone() };
            Optimum { state, ..optimum.clone() }
        })
    }

    /// The end of a glide sampled all round, and whether that shows nothing worse than what was followed;
    /// `None` where the cutter cannot be placed.
    pub(super) fn sampled(
        &self,
        Optimum { state, multipliers, at_range_end }: Optimum,
        probe: &mut Probe,
    ) -> Result<Option<(Optimum, bool)>, PositioningError> {
        let swift = Self { swift: true, ..*self };
        let Some(last) = swift.state(state.placement.x, probe, Some(&state))? else {
            return Ok(None);
        };
        let mut carried = vec![0.0; last.conditions.len()];
        for (condition, multiplier) in state.conditions.iter().zip(multipliers) {
            let alike = last.conditions.iter().zip(&mut carried);
            let alike = alike.filter(|(other, _)| other.kind == condition.kind);
            let apart = |other: &Condition| (other.psi - condition.psi).abs();
            let nearest = alike.min_by(|a, b| apart(a.0).total_cmp(&apart(b.0)));
            if let Some((_, carried)) = nearest {
                *carried += multiplier;
            }
        }
        // A tenth more may well be the same extremum, followed less closely.
        let foreseen = last.breach() <= 1.1 * state.breach();
        Ok(Some((Optimum { state: last, multipliers: carried, at_range_end }, foreseen)))
    }

    /// Climbs from `start` to a local optimum, until a step promises less than `arrived` of the
    /// width; `None` where the start has no placement.
    ///
    /// The result may break its conditions if the climb found no place that keeps them.
    pub(super) fn climb(
        &self,
        start: &Start,
        arrived: f64,
        probe: &mut Probe,
    ) -> Result<Option<Optimum>, PositioningError> {
        let Some(state) = self.state(start.x, probe, None)? else { return Ok(None) };
        self.ascend(state, start, arrived, probe).map(Some)
    }

    /// Climbs from a state.
    fn ascend(
        &self,
        mut state: State,
        start: &Start,
        arrived: f64,
        probe: &mut Probe,
    ) -> Result<Optimum, PositioningError> {
        let mut model = Model::new(self, start);
        let mut trust = start.trust;
        let mut multipliers = Vec::new();
        for _ in 0..STEPS {
            let Some(step) = model.step(&state, trust) else { break };
            multipliers.clone_from(&step.multipliers);
            if self.swift && self.is_stuck(&state, &step, trust) {
                break;
            }
            if step.gain <= arrived * start.scale[0] || trust < SMALLEST {
                break;
            }
            let Some((trial, gained)) = self.attempt(&mut model, &state, (&step, trust), probe)?
            else {
                trust *= 0.25;
                continue;
            };
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
        let [low, high] = start.offset_range;
        let alpha = state.placement.x[1];
        let at_range_end = alpha <= low || alpha >= high;
        multipliers.resize(state.conditions.len(), 0.0);
        Ok(Optimum { state, multipliers, at_range_end })
    }

    /// Whether the curvatures around a state change at a bounded rate, so that a few readings of the circle tell
    /// as much as sampling it.
    fn is_known(&self, state: &State, probe: &Probe) -> bool {
        let samples = state.conditions.iter().filter_map(|condition| condition.sample.as_ref());
        let ends = [&self.frame.first, &state.placement.second];
        let readings = ends.into_iter().chain(samples.map(|sample| &sample.reading));
        let way = 0.5 * SPACING * self.frame.major;
        curvatures_under(probe.face(), &readings, (way, self.frame.lift + way)).rate.is_finite()
    }

    /// Whether conditions stay broken as they are, however bold the step: to first order nothing
    /// in reach keeps them.
    fn is_stuck(&self, state: &State, step: &Step, trust: f64) -> bool {
        let broken = state.breach();
        let badly = broken > BADLY * (self.band.upper - self.band.lower);
        badly && trust >= BOLD && step.slack >= MENDED * broken
    }

    /// The state a step leads to.
    fn next(
        &self,
        x: [f64; 3],
        probe: &mut Probe,
        from: &State,
    ) -> Result<Option<State>, PositioningError> {
        if self.swift
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
        model: &mut Model,
        state: &State,
        (step, trust): (&Step, f64),
        probe: &mut Probe,
    ) -> Result<Option<(State, f64)>, PositioningError> {
        let Some(trial) = self.next(step.x, probe, state)? else { return Ok(None) };
        let gained = model.merit(state) - model.merit(&trial);
        if gained >= 0.2 * step.gain || trial.breach() <= 0.0 {
            return Ok(Some((trial, gained)));
        }
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

impl<'a> Model<'a> {
    fn new(problem: &'a Problem, start: &'a Start) -> Self {
        let width = start.scale[0];
        let band = problem.band.upper - problem.band.lower;
        Model {
            problem,
            start,
            // Of w cos(alpha) only alpha has a curvature, -w; the rest keeps the model strict.
            hessian: Matrix3::from_diagonal(&Vector3::new(1e-3, 4e-2, 1e-3)) * width,
            // The width grows like a root of the band, so that its price is a few widths a band.
            price: 3.0 * width / band,
        }
    }

    fn merit(&self, state: &State) -> f64 {
        self.price * state.breach() - Frame::width(state.placement.x)
    }

    fn scaled(&self, gradient: [f64; 3]) -> Vector3<f64> {
        Vector3::from(gradient).component_mul(&Vector3::from(self.start.scale))
    }

    fn width_gradient(&self, [w, alpha, _]: [f64; 3]) -> Vector3<f64> {
        self.scaled([alpha.cos(), -w * alpha.sin(), 0.0])
    }

    /// Best step of the model within the trust region; raises the price while a higher one
    /// removes slack. Where the trust region is what keeps the conditions out of reach no price
    /// helps, and a needless one would drown the width.
    fn step(&mut self, state: &State, trust: f64) -> Option<Step> {
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

    /// Best step of the model at the current price, the conditions worth `values`.
    fn step_to(&self, state: &State, trust: f64, values: &[f64]) -> Option<Step> {
        let x = state.placement.x;
        let band = self.problem.band.upper - self.problem.band.lower;
        let conditions = &state.conditions;
        let mut constraints: Vec<Constraint> = conditions
            .iter()
            .zip(values)
            .map(|(condition, value)| {
                let g = self.scaled(condition.gradient) / band;
                let normal = Vector4::new(g.x, g.y, g.z, 1.0);
                Constraint { normal, bound: -value / band }
            })
            .collect();
        constraints.push(Constraint { normal: Vector4::w(), bound: 0.0 });
        constraints.extend(self.walls(x, trust));
        // The slack is counted in bands; its own curvature only makes the program strict.
        let price = self.price * band;
        let mut inverse = Matrix4::zeros();
        inverse.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.hessian.try_inverse()?);
        inverse[(3, 3)] = 100.0 / price;
        let g = self.width_gradient(x);
        let gain = Vector4::new(g.x, g.y, g.z, -price);
        let solution = quadratic::minimise(&inverse, &gain, &constraints)?;
        let d = solution.x.fixed_rows::<3>(0).into_owned();
        let slack = solution.x.w.max(0.0) * band;
        let rise = g.dot(&d) - 0.5 * d.dot(&(self.hessian * d));
        let [low, high] = self.start.offset_range;
        let [flat, steep] = self.start.rotation_range;
        let scale = self.start.scale;
        Some(Step {
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

    /// Trust region and ranges of the unknowns, as distances from `x` in scaled unknowns.
    fn walls(&self, x: [f64; 3], trust: f64) -> [Constraint; 6] {
        let [low, high] = self.start.offset_range;
        let [flat, steep] = self.start.rotation_range;
        // Half of w is as far as a linear model of a chord reaches down.
        let least = [0.5 * x[0], low, flat];
        let most = [f64::INFINITY, high, steep];
        let mut walls = [Constraint { normal: Vector4::zeros(), bound: 0.0 }; 6];
        for k in 0..3 {
            let scale = self.start.scale[k];
            walls[2 * k].normal[k] = 1.0;
            walls[2 * k].bound = ((least[k] - x[k]) / scale).max(-trust).min(0.0);
            walls[2 * k + 1].normal[k] = -1.0;
            walls[2 * k + 1].bound = -((most[k] - x[k]) / scale).min(trust).max(0.0);
        }
        walls
    }

    /// Damped BFGS update of the Lagrangian's curvature between two states that share the
    /// conditions that bind.
    fn learn(&mut self, [from, to]: [&State; 2], multipliers: &[f64]) {
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

/// What the conditions of `state` would have to be worth there for the linear model to meet
/// `trial`, where the trial has the same condition.
fn curved_values(state: &State, trial: &State) -> Vec<f64> {
    let d = Vector3::from(trial.placement.x) - Vector3::from(state.placement.x);
    let value = |condition: &Condition| {
        twin(condition, trial).map_or(condition.value, |later| {
            later.value - Vector3::from(condition.gradient).dot(&d)
        })
    };
    state.conditions.iter().map(value).collect()
}

/// The condition of `state` of the same kind, nearest on the circle.
fn twin<'a>(condition: &Condition, state: &'a State) -> Option<&'a Condition> {
    let alike = state.conditions.iter().filter(|other| other.kind == condition.kind);
    let apart = |other: &Condition| (other.psi - condition.psi).abs();
    alike.min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

/// Largest rotation about the chord \[rad\]: a cutter that leans farther than about 35 degrees reaches
/// nothing more, but its flank and holder come down to the part.
pub(super) const MOST_ROTATION: f64 = 0.6;
