//! Servo setpoints of the axis points of a program.

use super::axis_point::AxisPoint;
use super::error::PostError;
use super::options::{PostMethod, PostOptions};
use super::timing::{PathSampler, SmoothPathTimer, TimedPoint};
use crate::machine::Kinematics;
use crate::types::{AxisVector, Setpoint};

/// Motion along the points within jerk limits, corners rounded within the tolerance, sampled at the servo period.
#[derive(Debug)]
pub(super) struct MotionStream {
    kinematics: Kinematics,
    options: PostOptions,
    timer: Option<SmoothPathTimer>,
    /// Sampler between two paths.
    sampler: Option<PathSampler>,
    /// Times of the points, which nobody asks for.
    timed: Vec<TimedPoint>,
    setpoints: Vec<Setpoint>,
}

impl MotionStream {
    pub(super) fn new(kinematics: &Kinematics, options: &PostOptions, period: f64) -> Self {
        // The corners at both ends of a short block may bend all of it: their deviations add up.
        let tolerance = options.tolerance.scaled(0.5);
        Self {
            kinematics: kinematics.clone(),
            options: PostOptions { method: PostMethod::Jerk, tolerance, ..*options },
            timer: None,
            sampler: Some(PathSampler::new(period)),
            timed: Vec::new(),
            setpoints: Vec::new(),
        }
    }

    /// Takes in a point, to which the axes move from `at`.
    pub(super) fn push(&mut self, at: AxisVector, point: &AxisPoint) -> Result<(), PostError> {
        if let Some(sampler) = self.sampler.take() {
            let timer = SmoothPathTimer::new(&self.kinematics, &self.options, at)?;
            self.timer = Some(timer.with_sampler(sampler));
        }
        if let Some(timer) = &mut self.timer {
            timer.push(point, &mut self.timed)?;
            self.timed.clear();
            self.setpoints.append(&mut timer.take_setpoints());
        }
        Ok(())
    }

    /// Brings the axes to rest.
    pub(super) fn rest(&mut self) -> Result<(), PostError> {
        let Some(timer) = self.timer.take() else { return Ok(()) };
        self.sampler = timer.finish(&mut self.timed)?;
        self.timed.clear();
        if let Some(sampler) = &mut self.sampler {
            self.setpoints.append(&mut sampler.take());
            sampler.restart();
        }
        Ok(())
    }

    /// Returns the setpoints since the last call.
    pub(super) fn take(&mut self) -> Vec<Setpoint> {
        std::mem::take(&mut self.setpoints)
    }

    /// Returns the remaining setpoints; the axes rest.
    pub(super) fn finish(mut self) -> Vec<Setpoint> {
        self.setpoints.extend(self.sampler.map(PathSampler::finish).unwrap_or_default());
        self.setpoints
    }
}
