//! Pass layout: the chart of a face, the choice of the feed direction, and the advance from pass to pass.

pub(super) mod advance;
pub(super) mod border_line;
pub(super) mod cell_grid;
pub(super) mod chart;
pub(super) mod choose;
pub(super) mod contour;
mod edge_index;
pub(super) mod effort;
pub(super) mod outline;
pub(super) mod region;
pub(super) mod track;
pub(super) mod trims;
pub(super) mod widths;
