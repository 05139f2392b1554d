//! A step of the speed schedule becomes pieces of motion: every letter a polynomial of time.

use super::piece::{LETTERS, MotionPiece};
use trunnion::feed::StreamStep;
use trunnion::math::quintic::Quintic;
use trunnion::program_motion::{LetterVector, PathNode};
use trunnion::types::PathState;

/// Longest piece \[s\]. The schedule is no polynomial of time: a quintic over so short a time differs from it by less than
/// a servo resolves.
const LONGEST: f64 = 0.004;

/// Most pieces of a step: one that takes longer is slow, and nearly a polynomial.
const MOST: u32 = 8;

/// Appends the pieces of a step between two nodes, at most `most` of them.
pub(super) fn append(
    step: &StreamStep,
    nodes: [&PathNode; 2],
    most: usize,
    out: &mut Vec<MotionPiece>,
) {
    let [from, to] = nodes;
    let jet = |node: &PathNode| [node.letters[0], node.letters[1], node.letters[2]];
    let path = Quintic::new(to.s - from.s, jet(from), jet(to));
    let most = u32::try_from(most).map_or(MOST, |most| most.clamp(1, MOST));
    let count = (1..most).find(|&n| step.duration <= LONGEST * f64::from(n)).unwrap_or(most);
    let duration = step.duration / f64::from(count);
    let mut start = motion(&path, from.s, &start_of(step));
    for k in 1..=count {
        let state = if k == count { end_of(step) } else { step.at(duration * f64::from(k)) };
        let end = motion(&path, from.s, &state);
        out.push(piece(start, end, duration, from.block));
        start = end;
    }
}

fn start_of(step: &StreamStep) -> PathState {
    PathState { s: step.s.low, speed: step.speed.start, acceleration: step.acceleration, jerk: 0.0 }
}

fn end_of(step: &StreamStep) -> PathState {
    let acceleration = step.end_acceleration;
    PathState { s: step.s.high, speed: step.speed.end, acceleration, jerk: 0.0 }
}

/// Position, velocity and acceleration of the letters.
fn motion(path: &Quintic<LETTERS>, origin: f64, state: &PathState) -> [LetterVector; 3] {
    let [position, tangent, bend, _] = path.at(state.s - origin);
    let PathState { speed, acceleration, .. } = *state;
    [position, tangent * speed, tangent * acceleration + bend * (speed * speed)]
}

/// The quintic through position, velocity and acceleration at both ends.
fn piece(
    start: [LetterVector; 3],
    end: [LetterVector; 3],
    duration: f64,
    block: u32,
) -> MotionPiece {
    let powers = *Quintic::new(duration, start, end).powers();
    let letters = std::array::from_fn(|letter| {
        let mut scale = 1.0;
        powers.map(|power| {
            let coefficient = power[letter] * scale;
            scale /= duration;
            coefficient
        })
    });
    MotionPiece { duration, letters, block }
}
