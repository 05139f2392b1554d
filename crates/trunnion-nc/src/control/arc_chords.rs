//! Arcs as chords.

use crate::read::{Arc, Move, Way};
use crate::types::AxisVector;

/// An arc or helix of a program, divided into straight blocks of equal angle.
#[derive(Debug, Clone)]
pub struct ArcChords {
    block: Move,
    arc: Arc,
    /// Words at both ends \[mm, rad\].
    ends: [AxisVector; 2],
    count: u32,
    done: u32,
}

impl ArcChords {
    /// Divides an arc between the words of its ends into `count` chords, at least one.
    pub fn new(block: &Move, arc: Arc, ends: [AxisVector; 2], count: u32) -> Self {
        Self { block: *block, arc, ends, count: count.max(1), done: 0 }
    }

    /// Number of all chords.
    pub fn total(&self) -> u32 {
        self.count
    }

    /// Returns true if the next chord is the first.
    pub fn is_at_start(&self) -> bool {
        self.done == 0
    }

    /// Returns true if no chord is left.
    pub fn is_over(&self) -> bool {
        self.done == self.count
    }
}

impl Iterator for ArcChords {
    /// A straight block with all five words, absolute, in the frame of the arc.
    type Item = Move;

    fn next(&mut self) -> Option<Move> {
        if self.is_over() {
            return None;
        }
        self.done += 1;
        let [from, to] = self.ends;
        let share = f64::from(self.done) / f64::from(self.count);
        let mut words = to;
        if self.done < self.count {
            // Linear in the angle across the plane, on the circle within it.
            words = from + (to - from) * share;
            for (axis, by) in self.arc.plane.into_iter().zip(self.arc.at(share)) {
                words[axis] = from[axis] + by;
            }
        }
        Some(Move {
            words: [0, 1, 2, 3, 4].map(|axis| Some(words[axis])),
            incremental: false,
            way: Way::Line,
            ..self.block
        })
    }
}
