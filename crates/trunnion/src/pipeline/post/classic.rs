//! Times of places as a classical control runs them: straight block after straight block, speed changing at a constant
//! rate, with look-ahead.

use super::leg::Place;
use super::pace::{LEAST, LEVER, Timed};
use super::{PostError, PostOptions};
use crate::feed::{Limits, LookAhead, LookAheadOptions, PlannedBlock, StraightMoves, look_ahead};
use crate::machine::Machine;
use crate::types::{AXES, AxisVector};
use nalgebra::SVector;

/// The axes, and the programmed time, which passes no faster than a second a second.
const WAYS: usize = AXES + 1;

/// What the programmed time counts in the length of a block \[mm/s\]: nothing.
const TIME: f64 = 1e-12;

/// The programmed time may start and stop at once, and no block is faster than this \[mm/s\].
const FREE: f64 = 1e12;

/// Servo period where the machine has none \[s\].
const PERIOD: f64 = 1e-3;

/// Takes in places, hands out their times.
#[derive(Debug)]
pub(super) struct Classic {
    /// Of cuts, and of rapid moves.
    limits: [Limits<WAYS>; 2],
    tip: Option<f64>,
    options: LookAheadOptions,
    window: usize,
    at: AxisVector,
    /// Blocks of one kind that wait for those behind them, and the speed before the first.
    waiting: Vec<Place>,
    moves: Vec<SVector<f64, WAYS>>,
    speed: f64,
}

impl Classic {
    pub(super) fn new(machine: &Machine, options: &PostOptions, at: AxisVector) -> Self {
        let with = |of: AxisVector, last: f64| of.push(last);
        let limits = |velocity: AxisVector| Limits {
            velocity: with(velocity, 1.0),
            rapid: with(velocity, 1.0),
            acceleration: with(machine.vector(|axis| axis.acc), FREE),
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

    /// Takes in a place; those whose time is known are appended.
    pub(super) fn push(&mut self, place: &Place, out: &mut Vec<Timed>) -> Result<(), PostError> {
        let travel = place.q - self.at;
        let turn = LEVER * travel.fixed_rows::<2>(3).norm();
        let rapid = place.least.is_none();
        if self.waiting.last().is_some_and(|last| last.least.is_none() != rapid) {
            self.rest(out)?;
        }
        if place.tip.hypot(turn) <= LEAST {
            return Ok(());
        }
        self.at = place.q;
        let slowest = self.tip.map_or(0.0, |most| place.tip / most);
        self.waiting.push(*place);
        self.moves.push(travel.push(place.least.unwrap_or(0.0).max(slowest)));
        if self.waiting.len() >= 2 * self.window {
            // Half of them can be followed by a stop inside the other half.
            self.plan(self.window, out)?;
        }
        Ok(())
    }

    /// Plans all that waits, up to a stop.
    pub(super) fn rest(&mut self, out: &mut Vec<Timed>) -> Result<(), PostError> {
        self.plan(self.waiting.len(), out)?;
        self.speed = 0.0;
        Ok(())
    }

    /// Hands out the first blocks of what waits.
    fn plan(&mut self, count: usize, out: &mut Vec<Timed>) -> Result<(), PostError> {
        let rapid = self.waiting.first().is_some_and(|first| first.least.is_none());
        let limits = &self.limits[usize::from(rapid)];
        let weights = SVector::<f64, WAYS>::from([1.0, 1.0, 1.0, LEVER, LEVER, TIME]);
        let ends = [self.speed, 0.0];
        let moves = StraightMoves { travels: &self.moves, weights: &weights };
        let planned = look_ahead(&moves, limits, FREE, ends, &self.options)?;
        let least = |place: &Place| place.least.unwrap_or(0.0);
        let timed = |(place, block): (Place, &PlannedBlock)| Timed {
            place,
            seconds: block.ramp.duration().max(least(&place)),
        };
        out.extend(self.waiting.drain(..count).zip(&planned).map(timed));
        self.moves.drain(..count);
        if let Some(last) = count.checked_sub(1).and_then(|last| planned.get(last)) {
            self.speed = last.ramp.speeds[2];
        }
        Ok(())
    }
}
