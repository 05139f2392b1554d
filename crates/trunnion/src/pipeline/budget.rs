//! The tolerance budget: what each stage may spend, so that the part keeps the whole.

/// What share of the total tolerance the stages get that follow the strips. Small shares cost blocks
/// (their number grows with the square root of 1/share), large ones cost strip width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Curves between stations against the exact cutter locations.
    pub path: f64,
    /// Blocks against the curves.
    pub linearisation: f64,
    /// The control's own smoothing of corners.
    pub control: f64,
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
    /// Curves between stations.
    pub path: f64,
    /// Program blocks against the curves.
    pub linearisation: f64,
    /// Words rounded to the decimals of the program.
    pub rounding: f64,
    /// The control's own smoothing.
    pub control: f64,
}

/// Why a tolerance cannot be split.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BudgetError {
    /// The parts exceed the whole.
    #[error(
        "tolerance total {total} mm and gouge {gouge} mm leave no band for the strips: path {path:.5}, \
         linearisation {linearisation:.5}, rounding {rounding:.5} and control {control:.5} mm act on \
         both sides; raise the tolerance or the decimals of the machine's output"
    )]
    NothingLeft {
        /// Largest excess \[mm\].
        total: f64,
        /// Deepest gouge \[mm\].
        gouge: f64,
        /// Share of the curves \[mm\].
        path: f64,
        /// Share of the blocks \[mm\].
        linearisation: f64,
        /// Rounding of the words \[mm\].
        rounding: f64,
        /// Share of the control \[mm\].
        control: f64,
    },
}

impl Budget {
    /// Splits `total` (excess) and `gouge` \[mm\]; `rounding` \[mm\] is what the program's decimals cost.
    ///
    /// # Errors
    ///
    /// [`BudgetError::NothingLeft`] unless the strips keep at least half of `total`.
    pub fn split(
        total: f64,
        gouge: f64,
        rounding: f64,
        shares: Shares,
    ) -> Result<Self, BudgetError> {
        let [path, linearisation, control] =
            [shares.path, shares.linearisation, shares.control].map(|share| share * total);
        let others = path + linearisation + rounding + control;
        let (lower, upper) = (others - gouge, total - others);
        if upper - lower >= 0.5 * total {
            Ok(Self { total, gouge, lower, upper, path, linearisation, rounding, control })
        } else {
            Err(BudgetError::NothingLeft { total, gouge, path, linearisation, rounding, control })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHARES: Shares = Shares { path: 0.05, linearisation: 0.05, control: 0.05 };

    #[test]
    fn the_worst_of_all_shares_stays_inside_the_whole() {
        let b = Budget::split(0.02, 0.002, 0.0002, SHARES).unwrap();
        let others = b.path + b.linearisation + b.rounding + b.control;
        assert!((b.upper + others - 0.02).abs() < 1e-15);
        assert!((b.lower - others + 0.002).abs() < 1e-15);
        assert!(b.lower > 0.0, "strips keep off the surface where gouges are dear: {}", b.lower);
    }

    #[test]
    fn coarse_decimals_are_refused() {
        let refused = Budget::split(0.002, 0.0, 0.0005, SHARES);
        assert!(matches!(refused, Err(BudgetError::NothingLeft { .. })), "{refused:?}");
    }
}
