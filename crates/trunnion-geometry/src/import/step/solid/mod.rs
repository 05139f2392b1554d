//! The solids of a file as one closed mesh.
//!
//! Every edge is cut into chords once, whichever face asks (`ring`), so that faces meet in the same
//! points. A face is unrolled into polygons of its parameters (`unroll`), these are cut into
//! triangles at their corners (`ears`), and triangles are parted inside the face until they are
//! close to the surface (`refine`).

mod closed_mesh;
mod corner;
mod ears;
mod refine;
mod ring;
mod unroll;
