//! Stock that is cut by a program only as far as asked for.

use super::carve::{StockCutter, StockOptions};
use super::material::Stock;
use crate::cutter::Cutter;
use crate::math;
use crate::types::Mesh;
use crate::verify::error::VerifyError;
use crate::verify::replay::segments::{Run, Segments};

/// Stock after the first moves of a program.
pub(crate) struct PartlyCutStock<'a> {
    stock: Stock,
    options: StockOptions,
    cutters: &'a [&'a Cutter],
    run: &'a Run<'a>,
    segments: Segments<'a>,
    /// Number of moves that have cut.
    done: usize,
}

impl<'a> PartlyCutStock<'a> {
    pub(crate) fn new(
        stock: &Stock,
        options: StockOptions,
        cutters: &'a [&'a Cutter],
        run: &'a Run<'a>,
    ) -> Self {
        // Collisions of the tool between rays are the business of the simulation.
        let stock = Stock { uncut: None, ..stock.clone() };
        Self { stock, options, cutters, run, segments: run.segments(), done: 0 }
    }

    /// Returns the number of moves that have cut.
    pub(crate) fn done(&self) -> usize {
        self.done
    }

    /// Cuts with the moves up to a number of them.
    pub(crate) fn cut_up_to(&mut self, count: usize) -> Result<(), VerifyError> {
        let more = self.segments.by_ref().take(count.saturating_sub(self.done));
        let more = more.collect::<Result<Vec<_>, _>>()?;
        StockCutter::new(&mut self.stock, self.cutters, &self.options)?
            .cut_moves(self.run, &more)?;
        self.done += more.len();
        Ok(())
    }

    /// Returns the surface of the material, and the distance by which material that the rays show may be beyond it \[mm\].
    ///
    /// Each vertex is in the lattice cube of the material that it stands for.
    pub(crate) fn surface(&self) -> Surrounded {
        let tolerance = self.options.tolerance;
        let [x, y, z] = self.stock.cell();
        let allowance = math::hypot(math::hypot(x, y), z) + tolerance;
        Surrounded { mesh: self.stock.mesh(tolerance), allowance }
    }
}

/// Surface near material.
pub(crate) struct Surrounded {
    pub(crate) mesh: Mesh,
    /// Distance by which material may be beyond it \[mm\].
    pub(crate) allowance: f64,
}
