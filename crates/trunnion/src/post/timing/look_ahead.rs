//! Times of points on a classical control: straight blocks, speed changing at a constant rate, with look-ahead.

use super::timed_point::TimedPoint;
use crate::feed::{Limits, LookAhead, LookAheadOptions, PlannedBlock, StraightMoves, look_ahead};
use crate::machine::Machine;
use crate::math;
use crate::post::axis_point::AxisPoint;
use crate::post::constants::{LEVER, SMALLEST_LENGTH};
use crate::post::error::PostError;
use crate::post::options::PostOptions;
use crate::types::{AXES, AxisVector};
use nalgebra::SVector;

/// Number of coordinates: the axes, and the programmed time, which passes no faster than a second per second.
const COORDINATES: usize = AXES + 1;

/// Weight of the programmed time in the length of a block \[mm/s\]: as good as nothing.
const TIME_WEIGHT: f64 = 1e-12;

/// Acceleration of the programmed time, which may start and stop at once, and largest block speed \[mm/s\].
const UNLIMITED: f64 = 1e12;

/// Servo period if the machine file gives none \[s\].
const PERIOD: f64 = 1e-3;

/// Timer that runs block after block.
#[derive(Debug)]
pub(crate) struct LookAheadTimer {
    /// Limits of cuts, and of rapid moves.
    limits: [Limits<COORDINATES>; 2],
    tip: Option<f64>,
    options: LookAheadOptions,
    window: usize,
    at: AxisVector,
    /// Blocks of one kind whose times depend on those behind them.
    waiting: Vec<AxisPoint>,
    /// Coordinates of these blocks.
    moves: Vec<SVector<f64, COORDINATES>>,
    /// Speed before the first of these blocks \[mm/s\].
    speed: f64,
}

impl LookAheadTimer {
    /// Creates a timer for axes that rest at `at`.
    pub(crate) fn new(machine: &Machine, options: &PostOptions, at: AxisVector) -> Self {
        let with = |of: AxisVector, last: f64| of.push(last);
        let limits = |velocity: AxisVector| Limits {
            velocity: with(velocity, 1.0),
            rapid: with(velocity, 1.0),
            acceleration: with(machine.vector(|axis| axis.acc), UNLIMITED),
            jerk: None,
            minus: None,
        };
        Self {
            limits: [
                limits(machine.vector(|axis| axis.vel)),
                limits(machine.vector(|axis| axis.rapid)),
            ],
            tip: machine.cycle.tip_speed_max,
            options: LookAheadOptions {
                period: machine.cycle.servo_period.unwrap_or(PERIOD),
                ahead: LookAhead::Whole,
                tiny: None,
            },
            window: options.window,
            at,
            waiting: Vec::new(),
            moves: Vec::new(),
            speed: 0.0,
        }
    }

    /// Takes in a point, and appends the points whose time is known.
    pub(crate) fn push(
        &mut self,
        point: &AxisPoint,
        out: &mut Vec<TimedPoint>,
    ) -> Result<(), PostError> {
        let travel = point.q - self.at;
        let turn = LEVER * travel.fixed_rows::<2>(3).norm();
        let rapid = point.least.is_none();
        // The axes stop between rapid moves and moves with feed.
        if self.waiting.last().is_some_and(|last| last.least.is_none() != rapid) {
            self.rest(out)?;
        }
        if math::hypot(point.tip, turn) <= SMALLEST_LENGTH {
            return Ok(());
        }
        self.at = point.q;
        // A largest tip speed of the control is a least time of the block.
        let slowest = self.tip.map_or(0.0, |most| point.tip / most);
        self.waiting.push(*point);
        // The programmed time is one more coordinate, whose speed limit is one second a second.
        self.moves.push(travel.push(point.least.unwrap_or(0.0).max(slowest)));
        if self.waiting.len() >= 2 * self.window {
            // Behind the first half there is room for a stop inside the second half.
            self.plan(self.window, out)?;
        }
        Ok(())
    }

    /// Plans all waiting blocks, up to a stop.
    pub(crate) fn rest(&mut self, out: &mut Vec<TimedPoint>) -> Result<(), PostError> {
        self.plan(self.waiting.len(), out)?;
        self.speed = 0.0;
        Ok(())
    }

    /// Plans the waiting blocks, and appends the first `count` of them.
    fn plan(&mut self, count: usize, out: &mut Vec<TimedPoint>) -> Result<(), PostError> {
        let rapid = self.waiting.first().is_some_and(|first| first.least.is_none());
        let limits = &self.limits[usize::from(rapid)];
        let weights = SVector::<f64, COORDINATES>::from([1.0, 1.0, 1.0, LEVER, LEVER, TIME_WEIGHT]);
        let ends = [self.speed, 0.0];
        let moves = StraightMoves { travels: &self.moves, weights: &weights };
        let planned = look_ahead(&moves, limits, UNLIMITED, ends.into(), &self.options)?;
        let least = |point: &AxisPoint| point.least.unwrap_or(0.0);
        let timed = |(point, block): (AxisPoint, &PlannedBlock)| TimedPoint {
            point,
            seconds: block.ramp.duration().max(least(&point)),
        };
        out.extend(self.waiting.drain(..count).zip(&planned).map(timed));
        self.moves.drain(..count);
        if let Some(last) = count.checked_sub(1).and_then(|last| planned.get(last)) {
            self.speed = last.ramp.speeds[2];
        }
        Ok(())
    }
}
