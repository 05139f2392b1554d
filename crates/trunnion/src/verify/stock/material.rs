//! Stock: three families of parallel rays, each with the intervals of material that remain on it.

use super::build::solid::Solid;
use super::dexel;
use super::dexel::{DexelGrid, RayFamily};
use std::sync::Arc;

/// Stock as three families of dexels.
///
/// # Example
///
/// ```
/// use nalgebra::Point3;
/// use trunnion::verify::{Solid, Stock};
///
/// let [low, high] = [Point3::origin(), Point3::new(4.0, 2.0, 1.0)];
/// let stock = Stock::new(&Solid::Box { low, high }, 0.5, 1000)?;
/// assert_eq!(stock.cell(), [0.5; 3]);
/// assert_eq!(stock.rays(), 8 * 4 + 4 * 2 + 2 * 8);
/// assert!((stock.volume() - 8.0).abs() < 1e-12);
/// # Ok::<(), trunnion::verify::VerifyError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Stock {
    pub(super) lattice: DexelGrid,
    pub(super) families: [RayFamily; 3],
    /// Original solid; `None` once something has cut it.
    pub(super) uncut: Option<Arc<Solid>>,
}

/// Share of the part's tolerance that the clipping of rays may use.
const TOLERANCE_SHARE: f64 = 0.05;
/// Share of the ray spacing that the clipping of rays may use.
const CELL_SHARE: f64 = 0.01;

impl Stock {
    /// Returns the ray spacing along x, y and z \[mm\].
    pub fn cell(&self) -> [f64; 3] {
        self.lattice.cell
    }

    /// Returns the clipping tolerance for a part tolerance of `total` \[mm\].
    ///
    /// It is well within that tolerance, and within the uncertainty that the ray spacing leaves anyway.
    pub fn tolerance(&self, total: f64) -> f64 {
        let cell = self.cell().into_iter().fold(f64::INFINITY, f64::min);
        (TOLERANCE_SHARE * total).min(CELL_SHARE * cell)
    }

    /// Returns the solid that its rays were cast through; `None` once something has cut it.
    pub fn solid(&self) -> Option<&Solid> {
        self.uncut.as_deref()
    }

    /// Returns the number of rays.
    pub fn rays(&self) -> usize {
        self.families.iter().flat_map(|family| &family.tiles).map(|tile| tile.rays.len()).sum()
    }

    /// Returns the volume \[mm³\]: the mean of the three families, each ray standing for the rectangle around it.
    pub fn volume(&self) -> f64 {
        self.volumes().iter().sum::<f64>() / 3.0
    }

    /// Returns the volume by the rays along x, y and z alone \[mm³\]. Their difference shows if the rays are too far apart.
    pub fn volumes(&self) -> [f64; 3] {
        let cell = self.lattice.cell;
        let volume = |family: &RayFamily| {
            let [a, b] = dexel::across(family.along);
            // Each ray stands for the rectangle of one cell across it.
            family.length() * cell[a] * cell[b]
        };
        self.families.each_ref().map(volume)
    }
}
