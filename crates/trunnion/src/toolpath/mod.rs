//! Curves through cutter locations; knows no surface and no machine.
