//! APT/CL files as CAM systems write them: statements to cutter locations, line by line.

mod cycle;
mod file;
mod known;
mod motion;
mod path;
mod reader;
mod records;
mod setting;
mod state;
mod statement;
mod straight;
mod tally;

pub use file::{ClFile, ClItem, ClMotion, ClRecord, ClTool};
pub use path::{ClArc, ClHole, ClPath};
pub use reader::ClReader;
pub use records::{ClRecords, cl, cl_records};
pub use tally::ClTally;
