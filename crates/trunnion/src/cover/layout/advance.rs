//! Advance from one pass to the next: not always as far as the narrowest part of the strip.
//!
//! A pass finishes strips of different widths along its length. A wide advance needs fewer passes,
//! but narrow parts then take passes of their own. The advance with the least cost per width is
//! taken.

use crate::cover::options::CoverOptions;
use crate::cutter::Cutter;
use crate::positioning::ToleranceBand;

/// Length of the run-outs of a pass, in radii: both together, half of what they may be at most.
const RUN_OUTS: f64 = 1.0;

/// Costs of passes besides their length over the face, all as lengths \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AdvanceCosts {
    /// Leads and link of one pass, with its run-outs.
    pub(crate) pass: f64,
    /// Width of a strip at the fixed lead, for parts where wide strips fail.
    pub(crate) narrow: f64,
}

impl AdvanceCosts {
    /// Returns the costs of passes with `cutter`.
    pub(crate) fn new(cutter: &Cutter, options: &CoverOptions) -> Self {
        Self {
            pass: options.link + RUN_OUTS * cutter.radius(),
            narrow: ball_strip_width(cutter, options),
        }
    }
}

/// Returns the width of a strip of a ball as wide as the cutter, on a plane \[mm\].
///
/// A ball of radius `R` rises by `w^2 / 8R` over half a strip of width `w`.
pub(crate) fn ball_strip_width(cutter: &Cutter, options: &CoverOptions) -> f64 {
    let ToleranceBand { lower, upper } = options.band;
    (8.0 * cutter.radius() * (upper - lower)).sqrt()
}

/// Part of a pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PassPart {
    /// Length along \[mm\].
    pub(crate) length: f64,
    /// Width finished across \[mm\].
    pub(crate) width: f64,
}

/// Largest number of passes over a narrow part that are estimated beforehand.
const PASSES: u32 = 4;

/// Number of advances that are tried in full.
const CHOICES: usize = 3;

/// Least difference of two advances worth trying both, as a share.
const APART: f64 = 0.1;

/// Returns the advance with the least cost per width \[mm\], where runs of narrower parts are
/// finished by passes of their own; 0 where no part has any width.
///
/// Candidates are the widths of the parts, and those of a few passes over one of them.
pub(crate) fn advance(parts: &[PassPart], costs: &AdvanceCosts) -> f64 {
    let rate = |width: f64| rate(parts, width, costs);
    // Of equal rates the wider advance.
    let better = |a: &f64, b: &f64| rate(*a).total_cmp(&rate(*b)).then(b.total_cmp(a));
    widths(parts).min_by(better).unwrap_or(0.0)
}

/// Returns the most promising advances, the best first; the width of the narrowest part is among
/// them.
pub(crate) fn advances(parts: &[PassPart], costs: &AdvanceCosts) -> Vec<f64> {
    let mut choices = vec![advance(parts, costs)];
    let narrowest = parts.iter().map(|part| part.width).fold(f64::INFINITY, f64::min);
    // Advances nearly alike lead to the same passes.
    let apart = |a: f64, choices: &[f64]| choices.iter().all(|b| (a - b).abs() > APART * a.max(*b));
    if narrowest > 0.0 && apart(narrowest, &choices) {
        choices.push(narrowest);
    }
    let mut others: Vec<f64> = widths(parts).collect();
    others.sort_by(|a, b| rate(parts, *a, costs).total_cmp(&rate(parts, *b, costs)));
    for width in others {
        if choices.len() < CHOICES && apart(width, &choices) {
            choices.push(width);
        }
    }
    choices
}

/// Returns the widths of the parts, and of a few passes over them, up to the widest.
fn widths(parts: &[PassPart]) -> impl Iterator<Item = f64> {
    let most = parts.iter().map(|part| part.width).fold(0.0, f64::max);
    let several = |part: &PassPart| {
        let width = part.width;
        (1..=PASSES).map(move |n| width * f64::from(n))
    };
    parts.iter().flat_map(several).filter(move |width| *width > 0.0 && *width <= most)
}

/// Returns the length that is cut per width gained \[mm/mm\].
fn rate(parts: &[PassPart], width: f64, costs: &AdvanceCosts) -> f64 {
    price(parts, width, costs) / width
}

/// Returns the length that is cut to go on by a width \[mm\].
pub(crate) fn price(parts: &[PassPart], width: f64, costs: &AdvanceCosts) -> f64 {
    let length: f64 = parts.iter().map(|part| part.length).sum();
    // One pass over everything, and the passes of their own over runs that it leaves narrower.
    length + costs.pass + again(parts, width, costs)
}

/// Returns the index ranges of neighbouring parts narrower than `width`.
pub(crate) fn narrower(parts: &[PassPart], width: f64) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (index, _) in parts.iter().enumerate().filter(|(_, part)| part.width < width) {
        match runs.last_mut() {
            Some(run) if run[1] + 1 == index => run[1] = index,
            _ => runs.push([index, index]),
        }
    }
    runs
}

/// Returns the cost of the passes over the narrower runs.
fn again(parts: &[PassPart], width: f64, costs: &AdvanceCosts) -> f64 {
    let of = |[first, last]: [usize; 2]| {
        let run = || parts.iter().take(last + 1).skip(first);
        let least = run().map(|part| part.width).fold(f64::INFINITY, f64::min);
        // The narrowest part of a run decides how many passes the run takes.
        let passes = ((width - least) / least.max(costs.narrow)).ceil();
        passes * (run().map(|part| part.length).sum::<f64>() + costs.pass)
    };
    narrower(parts, width).into_iter().map(of).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_narrow_rim_gets_passes_of_its_own() {
        let costs = AdvanceCosts { pass: 20.0, narrow: 1.0 };
        let parts = |rim: f64| {
            [(10.0, rim), (80.0, 12.0), (10.0, 11.0)]
                .map(|(length, width)| PassPart { length, width })
        };
        // An advance of 12 costs 120, five times 30, and once 30 more; of 11 it saves the last; of
        // 2 it costs 120.
        assert!((advance(&parts(2.0), &costs) - 11.0).abs() < 1e-12);
        // A rim nearly as wide is not worth a pass.
        assert!((advance(&parts(10.5), &costs) - 10.5).abs() < 1e-12);
        assert_eq!(narrower(&parts(2.0), 11.5), [[0, 0], [2, 2]]);
    }

    #[test]
    fn a_pass_that_finishes_nothing_goes_nowhere() {
        let costs = AdvanceCosts { pass: 20.0, narrow: 1.0 };
        assert!(advance(&[PassPart { length: 5.0, width: 0.0 }], &costs).abs() < 1e-12);
    }
}
