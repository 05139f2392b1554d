//! Lowers a cutter along z until it touches triangles.
//!
//! ```text
//! end       the cutting end as a height over the distance from the axis
//! touch     heights at which the end touches a facet or an edge, in closed form or by a bracketed root
//! tree      boxes over the triangles
//! index     the search, for one place or many
//! ```
//!
//! # Example
//!
//! A ball of radius 5 mm over the edge of a step: its centre stands 3 mm beside the edge, so the tip is 1 mm below it.
//!
//! ```
//! use nalgebra::Point3;
//! use trunnion_geometry::drop_cutter::{CuttingEnd, DropIndex};
//! use trunnion_geometry::types::Mesh;
//!
//! let corners = [[0.0, -50.0], [0.0, 50.0], [-50.0, 50.0]];
//! let vertices = corners.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
//! let index = DropIndex::new(&Mesh { vertices, triangles: vec![[0, 1, 2]] })?;
//!
//! let ball = CuttingEnd::round(0.0, 5.0);
//! let contact = index.lowered(&ball, [3.0, 0.0]).ok_or("nothing below")?;
//! assert!((contact.tip.z + 1.0).abs() < 1e-12);
//! assert!((contact.point - Point3::origin()).norm() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod end;
mod error;
mod index;
mod touch;
mod tree;

pub use end::CuttingEnd;
pub use error::DropError;
pub use index::{DropContact, DropIndex};
