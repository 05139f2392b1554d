//! Blocks that are far faster than those beside them.

/// A feed block that is faster by far than the blocks beside it: a short way through the air, or a wrong F word.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FastBlock {
    /// Line of the program.
    pub line: u32,
    /// Mean speed of the tip \[mm/s\].
    pub speed: f64,
    /// Speed of the faster neighbour \[mm/s\].
    pub beside: f64,
}
