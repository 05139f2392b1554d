//! Bytes to surfaces: STEP (feature `step`), surface JSON.
