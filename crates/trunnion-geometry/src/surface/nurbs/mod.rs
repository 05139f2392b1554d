//! Tensor-product NURBS surfaces, evaluated from their Bezier patches.

mod evaluate;
mod net;
mod surface;

pub(crate) use evaluate::curve_quotient;
pub use surface::{BezierPatch, NurbsSurface};
