//! Axis path and limits to speed along the path; knows no machine.
