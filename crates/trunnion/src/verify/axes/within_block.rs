//! Axes inside a move whose axes are not all linear in time: their extreme positions and largest velocities.
//!
//! Through three samples, evenly spaced in time, goes a parabola for each axis; its velocity is linear and so largest at an
//! end. With the half of a turn `w h` between two of them it is off by `h²/3 |q'''|`, and what turns with `w` about a lever
//! while the tip moves has `|q'''| <= w² (w lever + 3 v)`: with half of [`TURN`] a ten-thousandth of `w lever + v`. A move
//! that turns by less than [`LITTLE`] keeps its mean to a thousandth of that (`h/2 |q''|`).

use crate::types::AxisVector;
use crate::verify::error::VerifyError;
use crate::verify::replay::control::Control;
use crate::verify::replay::segment::{Course, Segment};

/// Largest turn from the first to the last of three samples \[rad\].
const TURN: f64 = 0.02;
/// Turn of linear rotaries up to which a move needs no sample in between \[rad\].
const LITTLE: f64 = 1e-3;
/// Most samples inside one move.
const MOST: usize = 512;
/// Shortest interval of three samples, over the time of the move: where the rotaries jump to another solution nothing is
/// short enough.
const SHORTEST: f64 = 1.0 / 4096.0;
/// Largest difference between the velocities by both halves of three samples and by the whole, as a share of the turn.
/// Along a great circle the rotaries are not linear in time, least so past the direction of one of them. The error of the
/// halves is a third of the difference.
const CLOSE: f64 = 1e-3;

/// Axis positions at a time in 0..=1 of the move.
#[derive(Debug, Clone, Copy)]
struct TimedJoints {
    t: f64,
    q: AxisVector,
}

/// Move on its control, from which samples are taken.
#[derive(Clone, Copy)]
struct SampledMove<'a> {
    control: &'a Control,
    segment: &'a Segment,
}

impl SampledMove<'_> {
    /// Returns the sample at half of the time between two.
    fn between(&self, from: &TimedJoints, to: &TimedJoints) -> Result<TimedJoints, VerifyError> {
        let t = 0.5 * (from.t + to.t);
        Ok(TimedJoints { t, q: self.control.joints(self.segment, t)? })
    }
}

/// Samples of the axes inside one move.
#[derive(Default)]
pub(crate) struct WithinBlock {
    /// Every second one is the middle of three.
    samples: Vec<TimedJoints>,
}

impl WithinBlock {
    /// Samples a move.
    pub(crate) fn sample(
        &mut self,
        control: &Control,
        segment: &Segment,
    ) -> Result<(), VerifyError> {
        let [from, to] = segment.joints;
        self.samples.clear();
        self.samples.push(TimedJoints { t: 0.0, q: from });
        // Joints that are linear in time need their ends only, as does a tip move that hardly turns.
        let pieces = match segment.course {
            Course::Tip { .. } if turn(&from, &to) <= LITTLE => 0.0,
            Course::Tip { .. } | Course::Circle { .. } => {
                (turn(&from, &to) / TURN).ceil().clamp(1.0, 0.5 * MOST as f64)
            }
            _ => 0.0,
        };
        let whole = SampledMove { control, segment };
        let mut before = TimedJoints { t: 0.0, q: from };
        let mut index = 1.0;
        while index <= pieces {
            let t = index / pieces;
            let q = if index < pieces { control.joints(segment, t)? } else { to };
            let end = TimedJoints { t, q };
            let middle = whole.between(&before, &end)?;
            match segment.course {
                // On a great circle the rotaries themselves are not linear: subdivide by their velocities.
                Course::Circle { .. } => self.refine(&whole, [&before, &middle, &end])?,
                _ => self.samples.extend([middle, end]),
            }
            before = end;
            index += 1.0;
        }
        if pieces < 1.0 {
            self.samples.push(TimedJoints { t: 1.0, q: to });
        }
        Ok(())
    }

    /// Adds three samples, or as many more as the velocities of the rotaries need.
    fn refine(
        &mut self,
        whole: &SampledMove<'_>,
        [from, middle, to]: [&TimedJoints; 3],
    ) -> Result<(), VerifyError> {
        let quarters = [whole.between(from, middle)?, whole.between(middle, to)?];
        // Velocities at both ends, by the parabola over the whole and by those over both halves. A half takes half of the
        // time, so its velocities per sample count twice.
        let by_whole = rates([from, middle, to]);
        let by_halves = [rates([from, &quarters[0], middle]), rates([middle, &quarters[1], to])];
        let off = turn(&by_whole[0], &(2.0 * by_halves[0][0]))
            .max(turn(&by_whole[1], &(2.0 * by_halves[1][1])));
        let turned = turn(&from.q, &middle.q) + turn(&middle.q, &to.q);
        let divides = to.t - from.t > SHORTEST && self.samples.len() < MOST;
        if divides && (off > CLOSE * turned || turned > TURN) {
            self.refine(whole, [from, &quarters[0], middle])?;
            return self.refine(whole, [middle, &quarters[1], to]);
        }
        self.samples.extend([quarters[0], *middle, quarters[1], *to]);
        Ok(())
    }

    /// Returns the axis positions of all samples.
    pub(crate) fn joints(&self) -> impl Iterator<Item = &AxisVector> {
        self.samples.iter().map(|sample| &sample.q)
    }

    /// Returns the largest velocities of a move that takes `seconds`.
    pub(crate) fn fastest(&self, seconds: f64) -> AxisVector {
        // Two samples alone: the axes are linear in time.
        if let [from, to] = self.samples.as_slice() {
            return (to.q - from.q).abs() / seconds;
        }
        let mut fastest = AxisVector::zeros();
        let mut rest = self.samples.as_slice();
        while let [from, middle, tail @ ..] = rest
            && let Some(to) = tail.first()
        {
            // From one sample to the next is half the time of the three.
            let per = 2.0 / ((to.t - from.t) * seconds);
            fastest = rates([from, middle, to])
                .iter()
                .fold(fastest, |most, rate| most.sup(&(rate.abs() * per)));
            rest = tail;
        }
        fastest
    }
}

/// Returns the velocities at both ends of the parabola through three samples, by the time from one to the next.
///
/// With first differences `a` and `b` the parabola has the slope `(a + b)/2 - (b - a)` at the first sample and
/// `(a + b)/2 + (b - a)` at the last.
fn rates([from, middle, to]: [&TimedJoints; 3]) -> [AxisVector; 2] {
    let [first, second] = [middle.q - from.q, to.q - middle.q];
    [1.5 * first - 0.5 * second, 1.5 * second - 0.5 * first]
}

/// Returns the turn of both rotaries together \[rad\].
fn turn(from: &AxisVector, to: &AxisVector) -> f64 {
    (to[3] - from[3]).abs() + (to[4] - from[4]).abs()
}
