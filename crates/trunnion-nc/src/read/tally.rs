//! Totals of a program: blocks, lengths, time as programmed, ranges.

use super::step::{Frame, Move, Offset, OffsetKind, Pace, Step, Way};
use crate::types::{AXES, Interval};

/// Counts steps as they come.
///
/// Lengths are of the X Y Z words, tip or axes as the program has them; where words begin to count from
/// something else (`G53`, another offset, a tilted plane) no length is made up.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// Moves.
    pub blocks: usize,
    /// Moves at rapid speed.
    pub rapids: usize,
    /// Moves on arcs.
    pub arcs: usize,
    /// Length of the X Y Z words in rapid moves \[mm\].
    pub rapid_length: f64,
    /// The same in moves with feed \[mm\].
    pub cut_length: f64,
    /// Feed moves at their feed, and dwells \[s\]; rapid moves are left out.
    pub seconds: f64,
    /// Least and largest word of each axis, in the order of the axes and then the sixth \[mm, rad\]; G53 left
    /// out. `None`: the program does not move it.
    pub ranges: [Option<Interval>; AXES + 1],
    place: [Option<f64>; AXES + 1],
    rotary: [bool; AXES],
    of: (Option<u8>, u16),
}

impl Tally {
    /// Starts a tally; `rotary` marks the axes that turn.
    pub fn new(rotary: [bool; AXES]) -> Self {
        Self {
            blocks: 0,
            rapids: 0,
            arcs: 0,
            rapid_length: 0.0,
            cut_length: 0.0,
            seconds: 0.0,
            ranges: [None; AXES + 1],
            place: [None; AXES + 1],
            rotary,
            of: (None, 0),
        }
    }

    /// Takes the words to be at these before the first step \[mm, rad\].
    #[must_use]
    pub fn starting_at(mut self, words: [f64; AXES]) -> Self {
        for (place, word) in self.place.iter_mut().zip(words) {
            *place = Some(word);
        }
        self.of = (Some(0), 0);
        self
    }

    /// Counts a step.
    pub fn push(&mut self, step: &Step) {
        match step {
            Step::Move(step) => self.take(step),
            Step::Dwell { seconds, .. } => self.seconds += seconds,
            Step::Offset(offset) => self.stand(offset),
            _ => {}
        }
    }

    /// Takes the words that the present position is taken to read as.
    fn stand(&mut self, offset: &Offset) {
        if offset.kind != OffsetKind::Standing {
            return;
        }
        self.of = (Some(offset.offset), self.of.1);
        for (place, word) in self.place.iter_mut().zip(offset.words) {
            *place = word.or(*place);
        }
    }

    fn take(&mut self, step: &Move) {
        // Words that count from another origin cannot be subtracted from those before.
        let offset = match step.frame {
            Frame::Machine => None,
            Frame::Work { offset, .. } => Some(offset),
        };
        if self.of != (offset, step.plane) {
            self.of = (offset, step.plane);
            self.place = [None; AXES + 1];
        }
        let ([linear, turned], sixth) = self.follow(step);
        let length = match step.way {
            Way::Line => linear.iter().map(|change| change * change).sum::<f64>().sqrt(),
            Way::Arc(arc) => {
                // A helix: its length is the root of (r sweep)^2 plus the square of the travel
                // along the axis of the arc.
                let along = |(slot, change): (usize, &f64)| {
                    if arc.plane.contains(&slot) { 0.0 } else { change * change }
                };
                let along: f64 = linear.iter().enumerate().map(along).sum();
                ((arc.radius() * arc.sweep).powi(2) + along).sqrt()
            }
        };
        let rapid = step.pace == Pace::Rapid;
        self.blocks += 1;
        self.rapids += usize::from(rapid);
        self.arcs += usize::from(matches!(step.way, Way::Arc(_)));
        *(if rapid { &mut self.rapid_length } else { &mut self.cut_length }) += length;
        self.seconds += match step.pace {
            Pace::Rapid => 0.0,
            Pace::Inverse { seconds } => seconds,
            Pace::PerMinute { speed } if length > 0.0 => length / speed,
            // The feed of a linear axis that moves alone is its own.
            Pace::PerMinute { speed } if sixth > 0.0 => sixth / speed,
            // Where only rotaries move, F is in degrees per minute of the root of the sum of
            // squares.
            Pace::PerMinute { speed } => {
                turned.iter().map(|turn| turn * turn).sum::<f64>().sqrt().to_degrees() / speed
            }
        };
    }

    /// Moves to the end of a step. Returns the changes of the linear and of the rotary axes, and
    /// the travel of a linear sixth axis, as far as known.
    fn follow(&mut self, step: &Move) -> ([[f64; AXES]; 2], f64) {
        let mut changes = [[0.0; AXES]; 2];
        let mut sixth = 0.0;
        // By ISO 841 a further axis turns if its letter is A, B or C.
        let turns = step.sixth.is_some_and(|(letter, _)| "ABC".contains(letter));
        let [w0, w1, w2, w3, w4] = step.words;
        let words = [w0, w1, w2, w3, w4, step.sixth.map(|(_, word)| word)];
        for (slot, (word, place)) in words.into_iter().zip(&mut self.place).enumerate() {
            let Some(word) = word else { continue };
            let stood = *place;
            // The change of an axis whose position is unknown is unknown; it counts as no travel.
            let change =
                if step.incremental { Some(word) } else { stood.map(|stood| word - stood) };
            *place = if step.incremental { stood.map(|stood| stood + word) } else { Some(word) };
            let rotary = self.rotary.get(slot).copied().unwrap_or(false);
            if let (Some(to), Some(change)) = (changes[usize::from(rotary)].get_mut(slot), change) {
                *to = change;
            }
            if let (AXES, Some(change), false) = (slot, change, turns) {
                sixth = change.abs();
            }
            // G53 positions are of another frame and stay out of the ranges.
            if let (Some(at), Frame::Work { .. }, Some(range)) =
                (*place, step.frame, self.ranges.get_mut(slot))
            {
                let here = Interval::point(at);
                *range = Some(range.map_or(here, |range| range.hull(here)));
            }
        }
        (changes, sixth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::samples::options;
    use crate::read::{Dialect, steps};
    use std::f64::consts::PI;

    #[test]
    fn a_sixth_axis_takes_its_time() {
        let mut tally = Tally::new([false, false, false, true, true]);
        let options = crate::read::ReadOptions { sixth: true, ..options(Dialect::LinuxCnc) };
        for step in steps("G0 X0 W0\nG1 W-5 F60\nX1 W0\nM2\n".lines(), &options) {
            tally.push(&step.unwrap());
        }
        assert!((tally.seconds - 6.0).abs() < 1e-12 && (tally.cut_length - 1.0).abs() < 1e-12);
        assert_eq!(tally.ranges[5], Some(Interval::new(-5.0, 0.0)));
    }

    #[test]
    fn lengths_are_of_words() {
        let text = "G0 X0 Y0 Z0 A0\nX3 Y4\nG1 F60 Z1\nG3 X-3 Y-4 I-3 J-4\nG1 A90\nG4 P2\nG53 G0 Z99\nG0 Z5\nM2\n";
        let mut tally = Tally::new([false, false, false, true, true]);
        for step in steps(text.lines(), &options(Dialect::LinuxCnc)) {
            tally.push(&step.unwrap());
        }
        assert_eq!((tally.blocks, tally.rapids, tally.arcs), (7, 4, 1));
        let expected = 1.0 + 5.0 * PI;
        assert!(
            (tally.rapid_length - 5.0).abs() < 1e-12 && (tally.cut_length - expected).abs() < 1e-12
        );
        assert!((tally.seconds - expected - 90.0 - 2.0).abs() < 1e-12);
        assert_eq!(tally.ranges[2], Some(Interval::new(0.0, 5.0)));
        assert_eq!(tally.ranges[4], None);
    }
}
