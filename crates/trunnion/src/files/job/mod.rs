//! The job file (`trunnion-job/1`): what to machine, with what, how well and on which machine.

mod data;

pub use data::{
    Along, Construction, Cutting, Dialect, Direction, Faces, JobFile, LeadKind, Method, Motion,
    MotionMethod, Part, Reference, Setup, Side, Split, Stock, Strategy, Tolerance, Tool, ToolKind,
};
