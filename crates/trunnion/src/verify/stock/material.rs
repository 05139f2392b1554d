//! Stock: three families of parallel rays, each with the intervals of material that remain on it.

use super::build::solid::Solid;
use super::dexel;
use super::dexel::{DexelGrid, RayFamily};
use std::sync::Arc;

/// Material.
#[derive(Debug, Clone, PartialEq)]
pub struct Stock {
    pub(super) lattice: DexelGrid,
    pub(super) families: [RayFamily; 3],
    /// What it was before anything cut it; `None` since.
    pub(super) uncut: Option<Arc<Solid>>,
}

/// Shares of a tolerance and of the cell by which rays are cut inexactly at most.
const TOLERANCE_SHARE: f64 = 0.05;
const CELL_SHARE: f64 = 0.01;

impl Stock {
    /// Distance of the rays by x, y and z \[mm\].
    pub fn cell(&self) -> [f64; 3] {
        self.lattice.cell
    }

    /// How exactly to cut it where the finished part has a tolerance of `total` \[mm\]: well within that, and within
    /// what the distance of the rays leaves open anyway.
    pub fn tolerance(&self, total: f64) -> f64 {
        let cell = self.cell().into_iter().fold(f64::INFINITY, f64::min);
        (TOLERANCE_SHARE * total).min(CELL_SHARE * cell)
    }

    /// Number of rays.
    pub fn rays(&self) -> usize {
        self.families.iter().flat_map(|family| &family.tiles).map(|tile| tile.rays.len()).sum()
    }

    /// Volume \[mm³\]: each ray stands for the rectangle around it; the mean of the three families.
    pub fn volume(&self) -> f64 {
        self.volumes().iter().sum::<f64>() / 3.0
    }

    /// Volume \[mm³\] by the rays along x, y and z alone: how far they differ tells how far rays lie apart.
    pub fn volumes(&self) -> [f64; 3] {
        let cell = self.lattice.cell;
        let volume = |family: &RayFamily| {
            let [a, b] = dexel::across(family.along);
            family.length() * cell[a] * cell[b]
        };
        self.families.each_ref().map(volume)
    }
}
