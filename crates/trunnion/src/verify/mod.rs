//! Replay a program as the control would, measure it against the surface, audit the axes.
//!
//! Shares only surface, cutter, machine and `nc::read` with the makers and never calls an inverse,
//! so that a maker's mistake cannot hide in the checker.
