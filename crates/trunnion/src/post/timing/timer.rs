//! Timing methods behind one interface.

use super::kept_times::KeptTimes;
use super::look_ahead::LookAheadTimer;
use super::smooth_path::SmoothPathTimer;
use super::timed_point::TimedPoint;
use crate::machine::{Kinematics, Machine};
use crate::nc::write::AxisWords;
use crate::post::axis_point::AxisPoint;
use crate::post::error::PostError;
use crate::post::options::{PostMethod, PostOptions};
use crate::types::AxisVector;

/// Timer of axis points, by the method of the options.
#[derive(Debug)]
pub(crate) enum PointTimer {
    /// Times along a smooth path, and those of the program where they can be kept.
    Path(Box<(SmoothPathTimer, KeptTimes)>, Vec<TimedPoint>),
    /// Times of a control that runs block after block.
    Blocks(Box<LookAheadTimer>),
    /// Times as programmed.
    Programmed(ProgrammedTimer),
}

impl PointTimer {
    /// Creates a timer for axes that rest at `at`.
    pub(crate) fn new(
        kinematics: &Kinematics,
        words: &AxisWords,
        options: &PostOptions,
        at: AxisVector,
    ) -> Result<Self, PostError> {
        let machine = kinematics.machine();
        Ok(match options.method {
            PostMethod::Optimal | PostMethod::Jerk => {
                let planner = SmoothPathTimer::new(kinematics, options, at)?;
                let kept = KeptTimes::new(machine, words, options, at);
                Self::Path(Box::new((planner, kept)), Vec::new())
            }
            PostMethod::Blocks => Self::Blocks(Box::new(LookAheadTimer::new(machine, options, at))),
            PostMethod::Programmed => Self::Programmed(ProgrammedTimer::new(machine, at)),
        })
    }

    /// Takes in a point, and appends the points whose time is known.
    pub(crate) fn push(
        &mut self,
        point: &AxisPoint,
        out: &mut Vec<TimedPoint>,
    ) -> Result<(), PostError> {
        match self {
            Self::Path(path, planned) => {
                path.0.push(point, planned)?;
                path.1.take(planned, out);
                Ok(())
            }
            Self::Blocks(blocks) => blocks.push(point, out),
            Self::Programmed(programmed) => {
                out.push(programmed.timed(point));
                Ok(())
            }
        }
    }

    /// Ends the path, and appends all remaining points.
    pub(crate) fn finish(self, out: &mut Vec<TimedPoint>) -> Result<(), PostError> {
        match self {
            Self::Path(path, mut planned) => {
                let (planner, mut kept) = *path;
                planner.finish(&mut planned)?;
                kept.take(&mut planned, out);
                kept.rest(out);
                Ok(())
            }
            Self::Blocks(mut blocks) => blocks.rest(out),
            Self::Programmed(_) => Ok(()),
        }
    }
}

/// Timer by the feeds of the input, whatever the axes can do; without a feed, by the velocities of the axes.
#[derive(Debug)]
pub(crate) struct ProgrammedTimer {
    velocity: AxisVector,
    rapid: AxisVector,
    at: AxisVector,
}

impl ProgrammedTimer {
    fn new(machine: &Machine, at: AxisVector) -> Self {
        Self {
            velocity: machine.vector(|axis| axis.vel),
            rapid: machine.vector(|axis| axis.rapid),
            at,
        }
    }

    fn timed(&mut self, point: &AxisPoint) -> TimedPoint {
        let travel = point.q - std::mem::replace(&mut self.at, point.q);
        let by = |limits: &AxisVector| travel.component_div(limits).amax();
        // A move without a feed runs as fast as its slowest axis.
        let seconds = match point.least {
            None => by(&self.rapid),
            Some(least) if least > 0.0 => least,
            Some(_) => by(&self.velocity),
        };
        TimedPoint { point: *point, seconds }
    }
}
