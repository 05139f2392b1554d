//! Pieces of a flank pass: where along a wall the tool gets how deep.
//!
//! Another face beside the wall may bar the tool over a part of it, and the foot of the wall may rise in steps. The wall is
//! then cut in pieces, each with the tip at one height. Heights are chosen greedily: each is the one at which the pieces finish
//! most of what those before have left.

use crate::types::Interval;
use rayon::prelude::*;

/// Places along a wall at which the lowest tip is sought.
const PLACES: usize = 96;

/// Heights at most at which the tip runs along one wall.
const HEIGHTS: usize = 4;

/// Height that a piece has to finish anew, as a share of the wall's.
const WORTH: f64 = 0.02;

/// Halvings between two places, of which the tool is clear at one.
const HALVINGS: u32 = 20;

/// Heights of the tip above the lower end of a wall \[mm\].
#[derive(Debug, Clone, Copy)]
pub(super) struct TipHeights {
    /// From the lowest tip that is of use to the highest.
    pub(super) range: Interval,
    /// Height above the tip at which the straight side begins.
    pub(super) corner: f64,
    /// Height of the wall.
    pub(super) wall: f64,
}

impl TipHeights {
    /// Returns the height that a tip finishes \[mm\].
    fn finished(&self, tip: f64) -> f64 {
        self.wall - (tip + self.corner).max(0.0)
    }

    /// Returns the lowest tip that is clear, within the range after some halvings; `None` where the highest is not.
    pub(super) fn lowest(&self, halvings: u32, clear: impl Fn(f64) -> bool) -> Option<f64> {
        let [mut below, mut above] = self.range.ends();
        if clear(below) {
            return Some(below);
        }
        if !clear(above) {
            return None;
        }
        for _ in 0..halvings {
            let middle = 0.5 * (below + above);
            if clear(middle) {
                above = middle;
            } else {
                below = middle;
            }
        }
        Some(above)
    }
}

/// Range along a wall on which the tool is clear with its tip at a height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FlankPiece {
    pub(super) range: Interval,
    /// Height above the lower end of the wall \[mm\].
    pub(super) tip: f64,
}

/// A wall by places along it.
#[derive(Debug, Clone, Copy)]
pub(super) struct WallRun {
    /// Range of a pass over all of it.
    pub(super) whole: Interval,
    /// Once round, of a closed wall.
    pub(super) round: Option<Interval>,
}

impl WallRun {
    /// Returns the place with an index; of a closed wall, indices go on beyond its end.
    fn place(&self, index: usize) -> f64 {
        self.round.unwrap_or(self.whole).at(index as f64 / PLACES as f64)
    }

    /// Returns the count of places that differ.
    fn count(&self) -> usize {
        if self.round.is_some() { PLACES } else { PLACES + 1 }
    }

    /// Returns the pieces in which a wall is cut: `lowest` gives the lowest tip at a place, `clear` tells whether the tool is
    /// clear at a place with its tip at a height.
    pub(super) fn pieces(
        &self,
        heights: TipHeights,
        lowest: impl Fn(f64) -> Option<f64> + Sync,
        clear: impl Fn(f64, f64) -> bool,
    ) -> Vec<FlankPiece> {
        let tips: Vec<Option<f64>> =
            (0..self.count()).into_par_iter().map(|i| lowest(self.place(i))).collect();
        let mut finished = vec![0.0; tips.len()];
        let mut pieces = Vec::new();
        for _ in 0..HEIGHTS {
            let Some(tip) = best_tip(heights, &tips, &finished) else { break };
            let is_free = |i: usize| tips[i % tips.len()].is_some_and(|lowest| lowest <= tip);
            let gain = |i: usize| heights.finished(tip) - finished[i % tips.len()];
            let is_cut = |i: usize| is_free(i) && gain(i) > WORTH * heights.wall;
            for run in self.runs(is_cut) {
                let Some([first, last]) = run else {
                    pieces.push(FlankPiece { range: self.whole, tip });
                    continue;
                };
                // Where the tool is clear beyond the piece, pieces overlap.
                let end = |at: usize, beyond: usize| {
                    if is_free(beyond) {
                        return self.place(beyond);
                    }
                    last_clear([self.place(at), self.place(beyond)], |place| clear(place, tip))
                };
                let opens = self.round.is_some() || first > 0;
                let closes = self.round.is_some() || last < PLACES;
                let low = if opens { end(first, first - 1) } else { self.whole.low };
                let high = if closes { end(last, last + 1) } else { self.whole.high };
                pieces.push(FlankPiece { range: Interval::new(low, high), tip });
            }
            let is_low = |lowest: &Option<f64>| lowest.is_some_and(|lowest| lowest <= tip);
            for (height, _) in finished.iter_mut().zip(&tips).filter(|(_, low)| is_low(low)) {
                *height = heights.finished(tip).max(*height);
            }
        }
        pieces
    }

    /// Returns the first and the last of consecutive places that are cut; `None` for all of a wall.
    fn runs(&self, is_cut: impl Fn(usize) -> bool) -> Vec<Option<[usize; 2]>> {
        let count = self.count();
        let Some(barred) = (0..count).find(|i| !is_cut(*i)) else { return vec![None] };
        // Round a closed wall from a place that is not cut; along an open one from its beginning.
        let start = if self.round.is_some() { barred } else { 0 };
        let places: Vec<usize> = (start..start + count).filter(|i| is_cut(*i)).collect();
        let runs = places.chunk_by(|a, b| a + 1 == *b);
        runs.map(|run| Some([run[0], run[run.len() - 1]])).collect()
    }
}

/// Returns the height of the tip at which most is finished of what is left; `None` where nothing is worth a piece.
fn best_tip(heights: TipHeights, tips: &[Option<f64>], finished: &[f64]) -> Option<f64> {
    let gain = |tip: f64| -> f64 {
        let free = tips.iter().zip(finished).filter(|(low, _)| low.is_some_and(|low| low <= tip));
        let gains = free.map(|(_, finished)| heights.finished(tip) - finished);
        gains.filter(|gain| *gain > WORTH * heights.wall).sum()
    };
    let mut levels: Vec<f64> = tips.iter().flatten().copied().collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let best = levels.into_iter().rev().map(|tip| (gain(tip), tip));
    let best = best.max_by(|(a, _), (b, _)| a.total_cmp(b));
    best.filter(|(gain, _)| *gain > 0.0).map(|(_, tip)| tip)
}

/// Returns the last place from the first on that is clear, on the way to a place that is not.
fn last_clear([mut good, mut bad]: [f64; 2], clear: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (good + bad);
        if clear(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: TipHeights =
        TipHeights { range: Interval { low: -2.0, high: 18.0 }, corner: 0.0, wall: 20.0 };

    /// Cuts a wall above a foot whose height is given, `None` where a tool is barred.
    fn cut(run: WallRun, foot: impl Fn(f64) -> Option<f64> + Sync) -> Vec<FlankPiece> {
        let clear = |at: f64, tip: f64| foot(at).is_some_and(|foot| tip >= foot);
        run.pieces(WALL, |at| WALL.lowest(12, |tip| clear(at, tip)), clear)
    }

    fn open() -> WallRun {
        WallRun { whole: Interval::new(0.0, 100.0), round: None }
    }

    /// Checks the range of a piece, to the precision of its ends.
    fn is_range(piece: &FlankPiece, ends: [f64; 2]) -> bool {
        let found = piece.range.ends();
        [0, 1].into_iter().all(|k| (found[k] - ends[k]).abs() < 1e-4)
    }

    #[test]
    fn a_free_wall_is_one_piece() {
        let whole = [FlankPiece { range: Interval::new(0.0, 100.0), tip: -2.0 }];
        assert_eq!(cut(open(), |_| Some(-5.0)), whole);
    }

    #[test]
    fn an_obstacle_leaves_a_piece_on_either_side() {
        let pieces = cut(open(), |at| (!(40.0..=55.0).contains(&at)).then_some(0.0));
        let [left, right] = &pieces[..] else { panic!("{pieces:?}") };
        assert!(is_range(left, [0.0, 40.0]) && is_range(right, [55.0, 100.0]), "{pieces:?}");
        assert!(pieces.iter().all(|piece| (0.0..0.01).contains(&piece.tip)), "{pieces:?}");
    }

    #[test]
    fn a_step_in_the_foot_gets_two_heights() {
        let pieces = cut(open(), |at| Some(if at < 30.0 { 12.0 } else { 0.0 }));
        assert_eq!(pieces.len(), 2, "{pieces:?}");
        let deep = pieces.iter().find(|piece| piece.tip < 1.0).expect("a deep piece");
        let high = pieces.iter().find(|piece| piece.tip > 11.0).expect("a high piece");
        assert!(is_range(deep, [30.0, 100.0]), "{deep:?}");
        assert!(high.range.encloses(Interval::new(0.0, 30.0)), "{high:?}");
    }

    #[test]
    fn a_closed_wall_is_cut_across_its_seam() {
        let run =
            WallRun { whole: Interval::new(0.0, 105.0), round: Some(Interval::new(0.0, 100.0)) };
        let barred = |at: f64| (30.0..=60.0).contains(&at.rem_euclid(100.0));
        let pieces = cut(run, |at| (!barred(at)).then_some(0.0));
        let [piece] = &pieces[..] else { panic!("{pieces:?}") };
        assert!(is_range(piece, [60.0, 130.0]), "{piece:?}");
        assert_eq!(cut(run, |_| Some(0.0))[0].range, run.whole);
    }

    #[test]
    fn a_wall_that_is_barred_all_along_has_no_piece() {
        assert_eq!(cut(open(), |_| None), []);
    }
}
