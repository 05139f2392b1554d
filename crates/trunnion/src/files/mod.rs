//! Job and machine files: text to data with line, column and suggestion; no I/O.
