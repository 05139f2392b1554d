//! The widest strip as a constrained maximum: constraints, model, climb, warm starts.

pub(crate) mod climb;
pub(crate) mod conditions;
pub(crate) mod follow;
pub(crate) mod initial_guesses;
pub(crate) mod model;
pub(crate) mod optimum;
pub(crate) mod placement;
pub(crate) mod quadratic;
pub(crate) mod warm;
