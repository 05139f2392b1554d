//! Counts of what a program holds beside moves.

/// Parts of a program that were read and do not show in its moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct LeftOut {
    /// Moves before the starting position, and in machine coordinates at the end.
    pub moves: usize,
    /// Dwells.
    pub dwells: usize,
    /// Lines of words without motion: stops, smoothing, messages.
    pub words: usize,
}
