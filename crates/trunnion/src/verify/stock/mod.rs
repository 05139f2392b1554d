//! Material: three families of parallel rays, each with the intervals that are left of it.
//!
//! Every ray is cut exactly: where it enters and leaves what a convex body sweeps (see `cut`). Tiles of
//! 16 x 16 rays are worked in parallel, each in an order that only the program and the stock decide, so that
//! the result does not depend on the number of threads. Memory is that of the stock: moves come in batches.

pub(crate) mod between_rays;
pub(crate) mod broad_phase;
pub(crate) mod build;
pub(crate) mod carve;
pub(crate) mod clip;
pub(crate) mod collision;
pub(crate) mod dexel;
pub(crate) mod material;
pub(crate) mod mesh;
pub(crate) mod moving_tools;

pub use build::solid::Solid;
pub use carve::{StockOptions, StockReport, UndecidedCollision, simulate};
pub use collision::{Collision, CollisionKind};
pub use material::Stock;
