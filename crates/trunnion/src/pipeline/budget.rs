//! Tolerance budget: the share of each stage, so that the part keeps the whole tolerance.

use crate::files::summary::ToleranceSummary;

/// Shares of the stages after the strips \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct BudgetShares {
    /// Curves between stations against the exact cutter locations.
    pub path: f64,
    /// Blocks against the curves.
    pub linearisation: f64,
    /// Words rounded to the decimals of the program.
    pub rounding: f64,
    /// The control's own smoothing of corners.
    pub control: f64,
    /// Moving the tool axis where a cut passes a singular direction.
    pub singular: f64,
    /// Smoothing of the cutter locations.
    pub smoothing: f64,
}

impl BudgetShares {
    /// Returns the usual shares of a total tolerance.
    ///
    /// Small shares cost blocks, whose number grows with the square root of 1/share. Large shares cost strip width,
    /// which falls with the square root of the remaining band.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::pipeline::BudgetShares;
    ///
    /// // A twentieth of 0.02 mm for curves, blocks and control each, half of that for rounding.
    /// let shares = BudgetShares::usual(0.02);
    /// assert_eq!((shares.path, shares.rounding), (0.001, 0.0005));
    /// ```
    pub fn usual(total: f64) -> Self {
        // Strips keep what is left of the total on both sides, so every share costs twice.
        let twentieth = 0.05 * total;
        let rounding = 0.5 * twentieth;
        Self {
            path: twentieth,
            linearisation: twentieth,
            rounding,
            control: twentieth,
            singular: 0.0,
            smoothing: 0.0,
        }
    }

    fn sum(&self) -> f64 {
        let own = self.path + self.linearisation + self.rounding + self.control;
        own + self.singular + self.smoothing
    }
}

/// A tolerance split over the stages \[mm\].
///
/// Errors are signed: excess positive, gouge negative. Every stage after `positioning` can move the
/// cutter to either side by its share, so the strips themselves must keep away from both ends:
/// `lower = d - gouge`, `upper = total - d` with `d` the sum of the other shares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Largest excess after everything.
    pub total: f64,
    /// Deepest gouge after everything.
    pub gouge: f64,
    /// Least error of a strip.
    pub lower: f64,
    /// Largest error of a strip.
    pub upper: f64,
    /// Shares of the other stages.
    pub shares: BudgetShares,
}

/// Reason for refusing a tolerance.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BudgetError {
    /// The parts exceed the whole.
    #[error(
        "tolerance total {total} mm and gouge {gouge} mm leave no band for the strips: path {:.5}, \
         linearisation {:.5}, rounding {:.5}, control {:.5}, singular {:.5} and smoothing {:.5} mm act on both sides; raise the \
         tolerance, the decimals of the machine's output, or lower a share",
        shares.path, shares.linearisation, shares.rounding, shares.control,
        shares.singular, shares.smoothing
    )]
    NothingLeft {
        /// Largest excess \[mm\].
        total: f64,
        /// Deepest gouge \[mm\].
        gouge: f64,
        /// Shares of the other stages.
        shares: BudgetShares,
    },
}

impl Budget {
    /// Splits `total` (excess) and `gouge` \[mm\]; `strip` caps the width of the strips' band.
    ///
    /// # Errors
    ///
    /// [`BudgetError::NothingLeft`] unless the strips keep at least half of `total`.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::pipeline::{Budget, BudgetShares};
    ///
    /// // The usual shares add up to 0.0035 mm, which the strips keep off both ends: 0.0035 - 0.002, 0.02 - 0.0035.
    /// let budget = Budget::split(0.02, 0.002, BudgetShares::usual(0.02), None)?;
    /// assert!((budget.lower - 0.0015).abs() < 1e-12);
    /// assert!((budget.upper - 0.0165).abs() < 1e-12);
    /// # Ok::<(), trunnion::pipeline::BudgetError>(())
    /// ```
    pub fn split(
        total: f64,
        gouge: f64,
        shares: BudgetShares,
        strip: Option<f64>,
    ) -> Result<Self, BudgetError> {
        let others = shares.sum();
        // Later stages move the cutter by up to `others` to either side: the strips' errors stay in
        // [others - gouge, total - others].
        let (lower, most) = (others - gouge, total - others);
        // A narrower band would multiply the passes: a share is too large.
        if most - lower >= 0.5 * total {
            let upper = strip.map_or(most, |strip| most.min(lower + strip));
            Ok(Self { total, gouge, lower, upper, shares })
        } else {
            Err(BudgetError::NothingLeft { total, gouge, shares })
        }
    }
}

impl Budget {
    /// Returns the excess that the passes may leave, with the errors of their curves: what is left of the total by the
    /// stages after them \[mm\].
    pub fn covered(&self) -> f64 {
        self.total - self.later()
    }

    /// Returns the depth to which leads and hops may go into a face: what is left of the gouge by the stages after them,
    /// negative where they have to keep a distance \[mm\].
    pub fn link_gouge(&self) -> f64 {
        self.gouge - self.later()
    }

    /// Returns the sum of the shares of the stages after the curves of the passes \[mm\].
    fn later(&self) -> f64 {
        self.shares.sum() - self.shares.path
    }

    /// Returns the budget as in `summary.json`.
    pub fn summary(&self) -> ToleranceSummary {
        ToleranceSummary {
            total: self.total,
            gouge: self.gouge,
            strip: [self.lower, self.upper],
            path: self.shares.path,
            linearisation: self.shares.linearisation,
            rounding: self.shares.rounding,
            control: self.shares.control,
            singular: self.shares.singular,
            smoothing: self.shares.smoothing,
        }
    }

    /// Returns every part by name \[mm\], the whole first.
    pub fn lines(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let Self { total, gouge, lower, upper, shares } = *self;
        [
            ("total", total),
            ("gouge", gouge),
            ("strip, least", lower),
            ("strip, most", upper),
            ("path", shares.path),
            ("linearisation", shares.linearisation),
            ("rounding", shares.rounding),
            ("control", shares.control),
            ("singular", shares.singular),
            ("smoothing", shares.smoothing),
        ]
        .into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_of_all_shares_stays_inside_the_whole() {
        let b = Budget::split(0.02, 0.002, BudgetShares::usual(0.02), None).unwrap();
        let others = b.shares.sum();
        assert!((b.upper + others - 0.02).abs() < 1e-15);
        assert!((b.lower - others + 0.002).abs() < 1e-15);
        assert!(b.lower > 0.0, "strips keep off the surface where gouges are dear: {}", b.lower);
    }

    #[test]
    fn a_strip_share_narrows_the_band_from_above() {
        let shares = BudgetShares::usual(0.02);
        let b = Budget::split(0.02, 0.002, shares, Some(0.004)).unwrap();
        assert!((b.upper - b.lower - 0.004).abs() < 1e-15);
    }

    #[test]
    fn shares_that_leave_no_band_are_refused() {
        let shares = BudgetShares { rounding: 0.0005, ..BudgetShares::usual(0.002) };
        let refused = Budget::split(0.002, 0.0, shares, None);
        assert!(matches!(refused, Err(BudgetError::NothingLeft { .. })), "{refused:?}");
    }

    /// What the curves of passes and links may be off, with everything after them, is the whole tolerance.
    #[test]
    fn passes_and_links_leave_room_for_what_follows() {
        let b = Budget::split(0.02, 0.002, BudgetShares::usual(0.02), None).unwrap();
        let later = b.shares.linearisation + b.shares.rounding + b.shares.control;
        assert!((b.covered() + later - b.total).abs() < 1e-15);
        assert!((b.covered() - (b.upper + b.shares.path)).abs() < 1e-15);
        assert!((b.link_gouge() + later - b.gouge).abs() < 1e-15);
        assert!((b.link_gouge() + (b.lower - b.shares.path)).abs() < 1e-15);
    }
}
