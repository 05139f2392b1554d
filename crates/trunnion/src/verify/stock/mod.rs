//! Material: three families of parallel rays, each with the intervals that are left of it.
//!
//! Every ray is cut exactly: where it enters and leaves what a convex body sweeps (see `cut`). Tiles of
//! 16 x 16 rays are worked in parallel and each in the order of the program, so that the result does
//! not depend on the number of threads. Memory is that of the stock: moves come in batches.

mod build;
mod carve;
mod cut;
mod dexel;
mod mesh;

pub use build::Solid;
pub use carve::{Carving, Collision, CollisionKind, simulate, simulate_cl};

use super::VerifyError;
use dexel::{Family, Lattice};

/// Material.
#[derive(Debug, Clone, PartialEq)]
pub struct Stock {
    lattice: Lattice,
    families: [Family; 3],
}

impl Stock {
    /// Material of a solid, rays `cell` \[mm\] apart.
    ///
    /// # Errors
    ///
    /// [`VerifyError::Option`] for a cell that is no length, [`VerifyError::Stock`] for a solid without
    /// volume or with more than `most_rays` rays.
    pub fn new(solid: &Solid, cell: f64, most_rays: usize) -> Result<Self, VerifyError> {
        build::stock(solid, cell, most_rays)
    }

    /// Distance of the rays \[mm\].
    pub fn cell(&self) -> f64 {
        self.lattice.cell
    }

    /// Number of rays.
    pub fn rays(&self) -> usize {
        self.families.iter().flat_map(|family| &family.tiles).map(|tile| tile.rays.len()).sum()
    }

    /// Volume \[mm³\]: each ray stands for the square around it; the mean of the three families.
    pub fn volume(&self) -> f64 {
        let square = self.lattice.cell.powi(2);
        self.families.iter().map(|family| family.length() * square).sum::<f64>() / 3.0
    }
}
