//! G-code as `LinuxCNC`, Fanuc and Haas write it.
//!
//! [`reader`] runs the lines, [`block`] and [`expression`] read one; [`flow`], [`owords`] and [`macros`]
//! decide which line comes next.

mod arc;
mod block;
mod codes;
mod compensation;
mod contour;
mod corner;
mod cycle;
mod expression;
mod flow;
mod further_codes;
mod label;
mod m_codes;
mod macro_flow;
mod macros;
mod map_codes;
mod modal;
mod motion;
mod numbered_line;
mod offsets;
mod owords;
mod parameters;
mod polar;
mod predefined;
mod probe;
mod reader;
mod remap;
mod saved;
mod saved_state;
mod spline;
mod spline_points;
mod sub_files;
mod swapped_axes;
mod thread;
mod tool_offsets;
mod words;

pub(super) use block::tenths;
pub(super) use motion::axis_of;
pub(super) use reader::GcodeReader;
pub use sub_files::subprogram_calls;
