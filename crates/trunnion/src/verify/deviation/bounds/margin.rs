//! Margin of a bound: its distance from the worst height known, and the state of the search for it.

use crate::verify::report::ExtremeHeight;

/// Least share of the margin that is used if the tolerance leaves less room.
const LEAST_MARGIN: f64 = 0.05;
/// Least margin as a multiple of the accuracy of measured heights.
///
/// A point deeper than the bound must measure deeper than the worst known point, which takes 1.2 accuracies.
const LEAST_TOLERANCES: f64 = 2.0;
/// Margin of the bound as a share of the excess over a broken tolerance.
const BROKEN_SHARE: f64 = 0.1;

/// Rule for the allowed distance of a bound from the worst height known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MarginRule {
    /// Largest margin while the tolerance is kept \[mm\].
    pub(crate) margin: f64,
    /// Tolerance of the worst height \[mm\].
    pub(crate) tolerance: f64,
    /// Accuracy of measured heights \[mm\].
    pub(crate) exact: f64,
}

impl MarginRule {
    /// Returns the margin for a worst height.
    ///
    /// If the tolerance is kept, the bound should keep it as well; if it is broken, the first digits suffice. With this
    /// margin the bound never rises by less than the worst height does.
    pub(super) fn margin(&self, worst: f64) -> f64 {
        let (Self { margin, .. }, room) = (*self, self.tolerance - worst.max(0.0));
        // Half of the room up to the tolerance, but neither more than the largest margin nor less than the
        // least.
        let least = (LEAST_MARGIN * margin).max(LEAST_TOLERANCES * self.exact).min(margin);
        let share = margin.min(0.5 * room).max(least);
        // Broken by -room: a margin of a tenth of that keeps the first digits.
        if room > 0.0 { share } else { margin.max(-BROKEN_SHARE * room) }
    }
}

/// State of a bound: the worst height known, and what is proven so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileBound {
    /// Worst height known \[mm\], counted positive away from the face.
    pub(super) worst: f64,
    /// Rule for the margin.
    pub(super) room: MarginRule,
    /// Least bound that is tried \[mm\].
    least: f64,
    /// Larger bound, where the margin was not enough.
    pub(super) beyond: f64,
    /// Worst point, if the search found it.
    pub(super) extreme: Option<ExtremeHeight>,
    /// Area without a proof \[mm²\].
    pub(super) open: f64,
    /// The limit of pieces was met.
    pub(super) ended: bool,
    /// Moves may count that keep farther off than those inspected.
    pub(super) short: bool,
}

impl TileBound {
    pub(super) fn new(worst: f64, room: MarginRule) -> Self {
        Self {
            worst,
            room,
            least: 0.0,
            beyond: 0.0,
            extreme: None,
            open: 0.0,
            ended: false,
            short: false,
        }
    }

    /// Abandons a piece of the face.
    pub(super) fn end(&mut self, area: f64) {
        self.open += area;
        self.ended = true;
    }

    /// Gives up to find what is worse in this tile than its own worst point, and goes on with the worst of all; returns
    /// `false` if that is what is searched already.
    pub(super) fn relax(&mut self, all: &Self) -> bool {
        let is_relaxed = all.worst > self.worst;
        if is_relaxed {
            (self.worst, self.ended) = (all.worst, true);
        }
        is_relaxed
    }

    /// Tests if a height of the tile breaks the tolerance.
    pub(super) fn is_broken(&self) -> bool {
        self.worst > self.room.tolerance
    }

    /// Returns the worst point found if it breaks the tolerance.
    pub(super) fn breach(&self) -> Option<ExtremeHeight> {
        self.extreme.filter(|extreme| extreme.height.abs() > self.room.tolerance)
    }

    /// Returns the margin above the worst height \[mm\].
    pub(super) fn margin(&self) -> f64 {
        self.room.margin(self.worst)
    }

    /// Returns the bound that is tried next.
    pub(super) fn aim(&self) -> f64 {
        (self.worst + self.margin()).max(self.least)
    }

    /// Gives up to prove that nothing touches the face: tries a bound that a touch is below, as if the worst height were 0.
    ///
    /// No piece that is touched at depth 0 is ever proven to stay clear, however small it is.
    pub(super) fn allow_touch(&mut self) {
        self.least = self.least.max(self.room.margin(0.0));
    }

    /// Takes a larger bound that holds where the aim could not be proven.
    ///
    /// If it keeps the tolerance, it is what is tried from here on: less for the rest of the tile gains nothing.
    pub(super) fn accept(&mut self, bound: f64) {
        self.beyond = self.beyond.max(bound);
        if bound <= self.room.tolerance {
            self.least = self.least.max(bound);
        }
    }

    /// Returns the proven bound.
    pub(super) fn bound(&self) -> f64 {
        self.aim().max(self.beyond)
    }

    pub(super) fn join(mut self, other: &Self) -> Self {
        if other.worst > self.worst {
            (self.worst, self.extreme) = (other.worst, other.extreme);
        }
        self.least = self.least.max(other.least);
        self.beyond = self.beyond.max(other.beyond);
        self.open += other.open;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::{MarginRule, TileBound};

    const RULE: MarginRule = MarginRule { margin: 0.0025, tolerance: 0.01, exact: 1e-5 };

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12
    }

    #[test]
    fn a_touch_is_below_the_bound_that_is_tried_after_it() {
        let mut known = TileBound::new(-0.0027, RULE);
        assert!(near(known.aim(), 0.0));
        known.allow_touch();
        assert!(near(known.aim(), 0.0025));
        // What is known to be worse counts as before.
        let mut known = TileBound::new(0.004, RULE);
        known.allow_touch();
        assert!(near(known.aim(), 0.0065));
    }

    #[test]
    fn a_larger_bound_is_tried_from_then_on_where_it_keeps_the_tolerance() {
        let mut known = TileBound::new(0.0, RULE);
        known.accept(0.008);
        known.allow_touch();
        assert!(near(known.aim(), 0.008) && near(known.bound(), 0.008));
        known.accept(0.02);
        assert!(near(known.aim(), 0.008) && near(known.bound(), 0.02));
    }
}
