//! The fewest program blocks for a given kind of control within tolerance.
