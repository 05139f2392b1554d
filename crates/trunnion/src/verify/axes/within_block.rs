//! The axes inside a move whose axes are not all linear in time: where they come, and how fast they are.
//!
//! Through three places, evenly spaced in time, goes a parabola for each axis; its velocity is linear and so largest at an
//! end. With the half of a turn `w h` between two of them it is off by `h²/3 |q'''|`, and what turns with `w` about a lever
//! while the tip moves has `|q'''| <= w² (w lever + 3 v)`: with half of [`TURN`] a ten-thousandth of `w lever + v`. A move
//! that turns by less than [`LITTLE`] keeps its mean to a thousandth of that (`h/2 |q''|`).

use crate::types::AxisVector;
use crate::verify::error::VerifyError;
use crate::verify::replay::control::Control;
use crate::verify::replay::segment::{Course, Segment};

/// Turn from the first to the last of three places at most \[rad\].
const TURN: f64 = 0.02;
/// Turn of linear rotaries up to which a move has no place in between \[rad\].
const LITTLE: f64 = 1e-3;
/// Places inside one move at most.
const MOST: usize = 512;
/// Shortest of three places, over the time of the move: where the rotaries jump to another solution nothing is short enough.
const SHORTEST: f64 = 1.0 / 4096.0;
/// Along a great circle the rotaries are not linear in time, least so past the direction of one of them: what the halves of
/// three places say of their speeds differs from what the whole does by this share at most. The error of the halves is
/// a third of the difference.
const CLOSE: f64 = 1e-3;

/// Time in 0..=1, and the axes then.
type Place = (f64, AxisVector);

/// The places of a move that are looked at.
#[derive(Default)]
pub(crate) struct Inner {
    /// Every second one is the middle of three.
    places: Vec<Place>,
}

impl Inner {
    /// Looks at a move.
    pub(crate) fn look(&mut self, control: &Control, segment: &Segment) -> Result<(), VerifyError> {
        let [from, to] = segment.joints;
        self.places.clear();
        self.places.push((0.0, from));
        let pieces = match segment.course {
            Course::Tip { .. } if turn(&from, &to) <= LITTLE => 0.0,
            Course::Tip { .. } | Course::Circle { .. } => {
                (turn(&from, &to) / TURN).ceil().clamp(1.0, 0.5 * MOST as f64)
            }
            _ => 0.0,
        };
        let mut before = (0.0, from);
        let mut index = 1.0;
        while index <= pieces {
            let t = index / pieces;
            let end = (t, if index < pieces { control.joints(segment, t)? } else { to });
            let middle = between((control, segment), &before, &end)?;
            match segment.course {
                Course::Circle { .. } => {
                    self.bent((control, segment), [&before, &middle, &end])?;
                }
                _ => self.places.extend([middle, end]),
            }
            before = end;
            index += 1.0;
        }
        if pieces < 1.0 {
            self.places.push((1.0, to));
        }
        Ok(())
    }

    /// Three places, or as many more as the rotaries ask for.
    fn bent(
        &mut self,
        of: (&Control, &Segment),
        [from, middle, to]: [&Place; 3],
    ) -> Result<(), VerifyError> {
        let quarters = [between(of, from, middle)?, between(of, middle, to)?];
        let whole = rates([from, middle, to]);
        let halves = [rates([from, &quarters[0], middle]), rates([middle, &quarters[1], to])];
        let off =
            turn(&whole[0], &(2.0 * halves[0][0])).max(turn(&whole[1], &(2.0 * halves[1][1])));
        let turned = turn(&from.1, &middle.1) + turn(&middle.1, &to.1);
        let divides = to.0 - from.0 > SHORTEST && self.places.len() < MOST;
        if divides && (off > CLOSE * turned || turned > TURN) {
            self.bent(of, [from, &quarters[0], middle])?;
            return self.bent(of, [middle, &quarters[1], to]);
        }
        self.places.extend([quarters[0], *middle, quarters[1], *to]);
        Ok(())
    }

    /// Where the axes come.
    pub(crate) fn joints(&self) -> impl Iterator<Item = &AxisVector> {
        self.places.iter().map(|(_, q)| q)
    }

    /// Largest velocities, if the move takes so long \[s\].
    pub(crate) fn fastest(&self, seconds: f64) -> AxisVector {
        if let [(_, from), (_, to)] = self.places.as_slice() {
            return (to - from).abs() / seconds;
        }
        let mut fastest = AxisVector::zeros();
        let mut rest = self.places.as_slice();
        while let [from, middle, tail @ ..] = rest
            && let Some(to) = tail.first()
        {
            let per = 2.0 / ((to.0 - from.0) * seconds);
            fastest = rates([from, middle, to])
                .iter()
                .fold(fastest, |most, rate| most.sup(&(rate.abs() * per)));
            rest = tail;
        }
        fastest
    }
}

/// The place at half of the time.
fn between(
    (control, segment): (&Control, &Segment),
    from: &Place,
    to: &Place,
) -> Result<Place, VerifyError> {
    let t = 0.5 * (from.0 + to.0);
    Ok((t, control.joints(segment, t)?))
}

/// Velocities at both ends of the parabola through three places, by the time from one to the next.
fn rates([from, middle, to]: [&Place; 3]) -> [AxisVector; 2] {
    let [first, second] = [middle.1 - from.1, to.1 - middle.1];
    [1.5 * first - 0.5 * second, 1.5 * second - 0.5 * first]
}

/// Turn of both rotaries together \[rad\].
fn turn(from: &AxisVector, to: &AxisVector) -> f64 {
    (to[3] - from[3]).abs() + (to[4] - from[4]).abs()
}
