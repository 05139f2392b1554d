//! A schedule sampled at the servo period.
