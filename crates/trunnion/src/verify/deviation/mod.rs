//! Height maps: signed distance of the machined surface from the faces, with bounds between the measured points.

pub(crate) mod bounds;
pub(crate) mod chunks;
pub(crate) mod grid;
pub(crate) mod map;
pub(crate) mod measure;
pub(crate) mod ray;
pub(crate) mod side;
pub(crate) mod tool_length;
