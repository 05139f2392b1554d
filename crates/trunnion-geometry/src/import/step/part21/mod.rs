//! The text layer of a STEP file (ISO 10303-21, "Part 21"): bytes to numbered records.
//!
//! Reads in one pass, in linear time, without deep recursion and without trusting a reference: the
//! meaning of a record, and the existence of the entities it refers to, are decided one layer up.
//! Records keep the order and the line they have in the file.

mod data;
mod parse;
mod scan;

pub(super) use data::{StepExchange, StepInstance, StepValue};
