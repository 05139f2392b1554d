//! Knot vectors, B-spline and Bernstein basis functions, and the Bezier form of a B-spline.
//!
//! Everything that runs per evaluation works on the stack, in arrays of two sizes: [`SMALL`] for the degrees
//! that nearly all models have, [`LARGE`] for the rest. The degree is bounded by [`MAX_DEGREE`].

mod bernstein;
mod binomial;
mod knot_error;
mod knot_vector;
mod sizes;

pub use bernstein::{bernstein, bernstein_values, bernstein2, fill_bernstein_values};
pub use binomial::{MAX_BINOMIAL, binomial};
pub use knot_error::{KnotError, KnotErrors};
pub use knot_vector::{KnotVector, piece_of};
pub use sizes::{BasisTable, LARGE, MAX_DEGREE, MAX_ORDER, SMALL};
