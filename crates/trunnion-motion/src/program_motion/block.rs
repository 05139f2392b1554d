//! Blocks of a program, as the control hands them over.

/// Letters of a position in the order of `LinuxCNC`: X Y Z A B C U V W.
pub const LETTERS: usize = 9;
pub(super) const NAMES: [char; LETTERS] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];

/// Meaning of the words X Y Z of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockCoordinates {
    /// Words are joints.
    Axes,
    /// X, Y and Z are the tool tip in the table frame, with the tool length along Z added.
    Tip,
}

/// Curve of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BlockShape {
    /// Straight in all letters.
    Line,
    /// Circle or helix in X Y Z, the other letters in proportion.
    Arc {
        /// Centre in X Y Z \[mm\].
        center: [f64; 3],
        /// Axis, not necessarily of unit length: the arc turns counterclockwise about it.
        normal: [f64; 3],
        /// Full turns besides the arc itself; from -1 downwards the arc turns clockwise.
        turns: i32,
    },
}

/// Override that a block obeys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockKind {
    /// At the feed, which is not exceeded anywhere.
    Feed,
    /// Rapid move.
    Rapid,
    /// In the time that its speed makes of its length: faster in one part of the block than in another where the blocks
    /// beside it are.
    Timed,
}

/// Beginning of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockStart {
    /// On the move.
    Flow,
    /// On the move; the place is met exactly in time, for outputs.
    Marked,
    /// At rest.
    Rest,
}

/// End of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockEnding {
    /// At rest.
    Stop,
    /// On the programmed path: at rest unless the next block goes on in the same direction.
    Exact,
    /// Rounded within the tolerance.
    Blend,
}

/// A block of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionBlock {
    /// Number that the plan reports back.
    pub number: u32,
    /// Position of X Y Z A B C U V W at its start \[mm or rad\].
    pub start: [f64; LETTERS],
    /// Position at its end \[mm or rad\].
    pub end: [f64; LETTERS],
    /// Curve between both.
    pub shape: BlockShape,
    /// Override that it obeys.
    pub kind: BlockKind,
    /// Programmed speed \[mm/s\]: of X Y Z; of U V W if those rest; of A B C \[rad/s\] if nothing else moves.
    pub speed: f64,
    /// Beginning.
    pub begins: BlockStart,
    /// End.
    pub ending: BlockEnding,
    /// Largest deviation of the tip where the corner at the end is rounded \[mm\].
    pub tolerance: f64,
    /// Meaning of its words.
    pub coordinates: BlockCoordinates,
    /// Length of the tool \[mm\].
    pub tool_length: f64,
}
