//! Tensor-product NURBS surfaces, evaluated from their Bezier patches.

mod evaluate;
mod net;
mod surface;

pub(crate) use evaluate::curve_quotient;
pub(super) use net::turn_net;
pub use surface::{BezierPatch, NurbsSurface};
