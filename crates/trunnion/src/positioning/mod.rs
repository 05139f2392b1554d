//! One cutter location: the widest strip, and what gouges.
