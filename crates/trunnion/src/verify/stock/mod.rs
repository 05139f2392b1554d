//! Stock simulation on dexels: three families of parallel rays, each with the intervals of material that remain.
//!
//! Each ray is clipped exactly at the points where it enters and leaves the swept volume of a convex body (see `clip`).
//! Tiles of 16 x 16 rays are processed in parallel. The order within a tile depends on program and stock only, so the result
//! does not depend on the number of threads. Moves come in batches, so memory is that of the stock.

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
pub(crate) mod partly_cut;
pub(crate) mod timed;

pub use build::solid::Solid;
pub use carve::{StockOptions, StockReport, UndecidedCollision, simulate};
pub use collision::{Collision, CollisionKind};
pub use material::Stock;
pub use timed::{StockBrick, StockChanges, TimedStock, TimedStockOptions};
