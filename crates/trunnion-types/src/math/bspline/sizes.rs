//! Sizes of the arrays on the stack.

/// Highest degree supported: the highest that the CAD kernel Open CASCADE writes.
pub const MAX_DEGREE: usize = 25;

/// Number of control points of one piece that an array of the small size holds: degrees up to 9.
pub const SMALL: usize = 10;

/// Number of control points of one piece of the highest degree: size of the large arrays.
pub const LARGE: usize = MAX_DEGREE + 1;

/// Highest derivative computed.
pub const MAX_ORDER: usize = 3;

/// `basis[k][i]`: `k`-th derivative of the `i`-th function that is not zero on a span.
pub type BasisTable<const N: usize = LARGE> = [[f64; N]; MAX_ORDER + 1];
