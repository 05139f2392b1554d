//! The fit: Gauss and Newton with halved steps, in the directions that the readings fix.

use super::calibration_error::CalibrationError;
use super::combination::combinations;
use super::deviation::{CHAIN_DEVIATIONS, DeviationKind};
use super::equations::NormalEquations;
use super::model::{ChainModel, DeviatedChain, Deviations};
use super::reading::{ReadingKind, SphereReading};
use super::report::{CalibrationReport, DeviationEstimate};
use crate::machine::{FIRST_ROTARY, Machine};
use nalgebra::{DMatrix, DVector, Point3, Vector3};

/// Options of a calibration.
///
/// Begin with [`CalibrationOptions::standard`] and change the rest by struct update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationOptions {
    /// Standard deviation of one number that is read \[mm\]; `None`: from the residuals.
    pub noise: Option<f64>,
    /// Uncertainty \[mm, or mm at the lever of the machine\] from which a combination counts as not measured.
    pub weak: f64,
    /// Largest deviation that a machine may have \[mm\].
    pub largest_offset: f64,
    /// Largest tilt that a machine may have \[rad\].
    pub largest_tilt: f64,
}

impl CalibrationOptions {
    /// Returns the standard: noise from the residuals, 0.05 mm, 25 mm and 0.05 rad.
    pub fn standard() -> Self {
        Self { noise: None, weak: 0.05, largest_offset: 25.0, largest_tilt: 0.05 }
    }
}

/// Rounds of the fit: it converges quadratically, in four to six from errors of a millimetre.
const ROUNDS: usize = 40;

/// Step \[mm\] at which the fit stands: below the resolution of any machine by five orders.
const STANDING: f64 = 1e-9;

/// Halvings of a step that leads uphill.
const HALVINGS: usize = 12;

/// Least noise that is assumed \[mm\]: the resolution of good encoders.
const LEAST_NOISE: f64 = 1e-5;

/// Shortest lever for angles \[mm\].
const LEAST_LEVER: f64 = 100.0;

/// Eigenvalue as a share of the largest below which the first fit takes nothing: rounding.
const ROUNDING: f64 = 1e-11;

/// Multiple of the noise from which a reading contradicts the others.
const CONTRADICTION: f64 = 6.0;

/// State of a fit.
#[derive(Debug, Clone)]
pub(super) struct Fit<'a> {
    model: ChainModel,
    readings: &'a [SphereReading],
    scale: Deviations,
    by: Deviations,
    centers: Vec<Vector3<f64>>,
    /// Least eigenvalue of a direction that is fixed.
    least: f64,
    rms_before: f64,
    noise: f64,
    freedom: usize,
}

impl<'a> Fit<'a> {
    /// Fits all deviations that the readings fix.
    pub(super) fn run(
        machine: &Machine,
        readings: &'a [SphereReading],
        options: CalibrationOptions,
    ) -> Result<Self, CalibrationError> {
        let model = ChainModel::new(machine);
        let scale = scale(&model, readings);
        let centers = centers(&model.at(&Deviations::zeros()), readings);
        let mut fit = Self {
            model,
            readings,
            scale,
            by: Deviations::zeros(),
            centers,
            least: 0.0,
            rms_before: 0.0,
            noise: 0.0,
            freedom: 0,
        };
        let start = fit.clone();
        let equations = fit.equations();
        fit.rms_before = rms(&equations);
        fit.least = ROUNDING * equations.reduced().eigen.eigenvalues.amax().max(1.0);
        fit.descend();
        fit.judge_noise(options)?;
        // The directions whose uncertainty is above the limit with that noise are not taken.
        let least = fit.least.max((fit.noise / options.weak).powi(2));
        let weak = fit.equations().reduced().undetermined(least).len();
        if weak > fit.equations().reduced().undetermined(fit.least).len() {
            let (by, centers) = (start.by, start.centers);
            fit = Self { by, centers, least, ..fit };
            fit.descend();
            fit.judge_noise(options)?;
        }
        fit.least = least;
        Ok(fit)
    }

    pub(super) fn rms(&self) -> f64 {
        rms(&self.equations())
    }

    fn equations(&self) -> NormalEquations {
        self.equations_at(&self.by, &self.centers)
    }

    fn equations_at(&self, by: &Deviations, centers: &[Vector3<f64>]) -> NormalEquations {
        let chain = self.model.at(by);
        let mut equations = NormalEquations::new(self.scale, centers.len());
        for reading in self.readings {
            let center = centers.get(reading.sphere).copied().unwrap_or_default();
            equations.add(reading, &chain.tip(&reading.q, reading.tool_length), &center);
        }
        equations
    }

    /// Goes down to the least squares.
    fn descend(&mut self) {
        let mut equations = self.equations();
        for _ in 0..ROUNDS {
            let step = equations.reduced().step(self.least);
            let shifts = equations.center_steps(&step);
            let Some((by, centers, next)) = self.downhill(&step, &shifts, equations.squares) else {
                break;
            };
            (self.by, self.centers, equations) = (by, centers, next);
            if step.amax() < STANDING {
                break;
            }
        }
    }

    /// Returns the state after the longest of the halved steps that goes down.
    fn downhill(
        &self,
        step: &Deviations,
        shifts: &[Vector3<f64>],
        squares: f64,
    ) -> Option<(Deviations, Vec<Vector3<f64>>, NormalEquations)> {
        let halves = (0..HALVINGS).map(|halving| 0.5_f64.powi(i32::try_from(halving).unwrap_or(0)));
        halves.into_iter().find_map(|share| {
            let by = self.by + step.component_mul(&self.scale) * share;
            let moved =
                self.centers.iter().zip(shifts).map(|(center, shift)| center + shift * share);
            let centers: Vec<Vector3<f64>> = moved.collect();
            let next = self.equations_at(&by, &centers);
            (next.squares < squares).then_some((by, centers, next))
        })
    }

    /// Sets the noise and the freedom of the readings.
    fn judge_noise(&mut self, options: CalibrationOptions) -> Result<(), CalibrationError> {
        let equations = self.equations();
        let found = CHAIN_DEVIATIONS - equations.reduced().undetermined(self.least).len();
        let (numbers, unknowns) = (equations.numbers, found + equations.center_numbers());
        // As many numbers as unknowns always fit: they say nothing about their noise.
        if numbers <= unknowns {
            return Err(CalibrationError::TooFew { numbers, unknowns });
        }
        self.freedom = numbers - unknowns;
        let estimated = (equations.squares / self.freedom as f64).sqrt();
        self.noise = options.noise.unwrap_or(estimated).max(LEAST_NOISE);
        Ok(())
    }

    /// Returns the error if a deviation is larger than machines have.
    pub(super) fn implausible(&self, options: CalibrationOptions) -> Option<CalibrationError> {
        let too_large = |index: &usize| {
            let kind = self.model.deviations.get(*index).map(|one| one.kind);
            let most = match kind {
                Some(DeviationKind::Offset) => options.largest_offset,
                _ => options.largest_tilt,
            };
            self.by[*index].is_nan() || self.by[*index].abs() > most
        };
        let index = (0..CHAIN_DEVIATIONS).find(too_large)?;
        let deviation = self.model.deviations.get(index)?;
        Some(CalibrationError::Implausible {
            name: deviation.name(&self.model.nominal),
            value: self.by[index],
            unit: if deviation.kind == DeviationKind::Offset { "mm" } else { "rad" },
            rms: self.rms(),
        })
    }

    pub(super) fn report(&self, options: CalibrationOptions) -> CalibrationReport {
        let equations = self.equations();
        let reduced = equations.reduced();
        let variances = reduced.variances(self.least);
        let free = reduced.undetermined(self.least);
        let estimate = |(index, deviation): (usize, &_)| {
            // The share of the deviation that lies in directions without a reading.
            let share: f64 = free.iter().map(|vector| vector[index].powi(2)).sum();
            let deviation_sigma = self.noise * variances[index].sqrt() * self.scale[index];
            DeviationEstimate {
                deviation: *deviation,
                value: self.by[index],
                uncertainty: (share < UNNOTICED).then_some(deviation_sigma),
            }
        };
        let residuals = self.residuals();
        CalibrationReport {
            machine: self.model.machine(&self.by),
            estimates: self.model.deviations.iter().enumerate().map(estimate).collect(),
            confounded: combinations(&free, &self.scale, &self.model),
            spheres: self.centers.iter().copied().map(Point3::from).collect(),
            rms_before: self.rms_before,
            rms: rms(&equations),
            noise: self.noise,
            freedom: self.freedom,
            contradicting: contradicting(&residuals, options.noise),
            residuals,
        }
    }

    fn residuals(&self) -> Vec<f64> {
        let chain = self.model.at(&self.by);
        let mut equations = NormalEquations::new(self.scale, self.centers.len());
        let residual = |reading: &SphereReading| {
            let center = self.centers.get(reading.sphere).copied().unwrap_or_default();
            equations.add(reading, &chain.tip(&reading.q, reading.tool_length), &center)
        };
        self.readings.iter().map(residual).collect()
    }
}

/// Share of a deviation without a reading below which its uncertainty still describes it.
const UNNOTICED: f64 = 1e-3;

/// Returns the readings that lie far outside the others: by the stated noise, or by the median of all.
fn contradicting(residuals: &[f64], noise: Option<f64>) -> Vec<usize> {
    let mut sorted = residuals.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or_default();
    let most = CONTRADICTION * noise.unwrap_or(median).max(LEAST_NOISE);
    (0..residuals.len())
        .filter(|&index| residuals.get(index).is_some_and(|one| *one > most))
        .collect()
}

fn rms(equations: &NormalEquations) -> f64 {
    (equations.squares / equations.numbers.max(1) as f64).sqrt()
}

/// Returns the factors from scaled deviations to mm and rad: tilts count at the longest lever, so that all compare.
pub(super) fn scale(model: &ChainModel, readings: &[SphereReading]) -> Deviations {
    let machine = &model.nominal;
    let reach = |reading: &SphereReading| {
        let linear = machine.axes.iter().zip(reading.q.iter()).take(FIRST_ROTARY);
        let nose =
            linear.fold(machine.gauge, |nose, (axis, q)| nose + axis.dir.scale(axis.sense * q));
        let arms = machine.axes.iter().skip(FIRST_ROTARY).map(|axis| (nose - axis.point).norm());
        arms.fold(0.0, f64::max) + reading.tool_length.abs()
    };
    let lever = readings.iter().map(reach).fold(LEAST_LEVER, f64::max);
    Deviations::from_fn(|row, _| match model.deviations.get(row).map(|one| one.kind) {
        Some(DeviationKind::Tilt) => 1.0 / lever,
        _ => 1.0,
    })
}

/// Returns first centres of the spheres, from the chain of the file.
fn centers(chain: &DeviatedChain, readings: &[SphereReading]) -> Vec<Vector3<f64>> {
    let count = readings.iter().map(|reading| reading.sphere + 1).max().unwrap_or(0);
    let center = |sphere: usize| {
        let of: Vec<&SphereReading> = readings.iter().filter(|one| one.sphere == sphere).collect();
        first_center(chain, &of)
    };
    (0..count).map(center).collect()
}

/// Places give their mean, distances the linear fit of `|p|² - r² = 2 p c - |c|²` about their mean.
fn first_center(chain: &DeviatedChain, readings: &[&SphereReading]) -> Vector3<f64> {
    let tips = |reading: &&&SphereReading| chain.tip(&reading.q, reading.tool_length).tip;
    let mean =
        |places: &[Vector3<f64>]| places.iter().sum::<Vector3<f64>>() / places.len().max(1) as f64;
    let places: Vec<Vector3<f64>> = readings
        .iter()
        .filter_map(|reading| match reading.kind {
            ReadingKind::Center { deviation } => Some(tips(&reading) - deviation),
            ReadingKind::Radius { .. } => None,
        })
        .collect();
    if !places.is_empty() {
        return mean(&places);
    }
    let all: Vec<Vector3<f64>> = readings.iter().map(|reading| tips(&reading)).collect();
    let middle = mean(&all);
    let radius = |reading: &&SphereReading| match reading.kind {
        ReadingKind::Radius { radius } => radius,
        ReadingKind::Center { .. } => 0.0,
    };
    let left = DMatrix::from_fn(all.len(), 4, |row, column| {
        let from = all.get(row).map_or(Vector3::zeros(), |tip| tip - middle);
        if column < 3 { 2.0 * from[column] } else { -1.0 }
    });
    let squares = all
        .iter()
        .zip(readings)
        .map(|(tip, reading)| (tip - middle).norm_squared() - radius(reading).powi(2));
    let right = DVector::from_iterator(all.len(), squares);
    let small = 1e-6 * left.amax();
    // A circle leaves the centre free across its plane: the mean is as good as any.
    let solved = left.svd(true, true).solve(&right, small).ok();
    solved.map_or(middle, |of| middle + Vector3::new(of[0], of[1], of[2]))
}
