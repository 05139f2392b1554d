//! Passes over faces: where strips lie, lead-in, lead-out, links.
