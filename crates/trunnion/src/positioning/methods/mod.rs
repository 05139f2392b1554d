//! Methods that place a cutter, and the choice between the sides of the cutter.

pub(crate) mod arc_fit;
pub(crate) mod arc_limit;
pub(crate) mod ball;
pub(crate) mod contact;
pub(crate) mod method;
pub(crate) mod nested;
pub(crate) mod pair;
pub(crate) mod settle;
pub(crate) mod sides;
pub(crate) mod touching_ball;
pub(crate) mod widest;
pub(crate) mod widest_search;
