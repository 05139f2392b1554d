//! Boxes in which a body comes close to material, and the bodies before it.

use crate::verify::stock::broad_phase::BoundedPiece;
use crate::verify::stock::collision::CollisionKind;
use crate::verify::swept::bvh::BoundingBox;
use crate::verify::swept::tool::ConvexBody;

/// Largest growth in volume by merging two boxes.
const GAIN: f64 = 1.1;

/// Box in which a body comes close to material.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CloseBox {
    /// Number of the body's part, and of the first part of its move.
    pub(crate) part: usize,
    pub(crate) first: usize,
    pub(crate) bounds: BoundingBox,
    pub(crate) line: u32,
    pub(crate) kind: CollisionKind,
    /// Largest possible depth \[mm\].
    pub(crate) most: f64,
    /// Depth found on the rays for this line in this batch \[mm\].
    pub(crate) known: f64,
}

/// Body over a piece that may have removed material earlier.
#[derive(Debug, Clone, Copy)]
pub(super) struct EarlierBody {
    pub(super) number: usize,
    pub(super) harm: Option<CollisionKind>,
    pub(super) body: ConvexBody,
    pub(super) bounded: BoundedPiece,
}

/// Merges boxes of the same part that nearly coincide.
pub(crate) fn merge(mut all: Vec<CloseBox>) -> Vec<CloseBox> {
    all.sort_by_key(|close| close.part);
    let mut merged: Vec<CloseBox> = Vec::new();
    for next in all {
        let same = merged.iter_mut().rev().take_while(|close| close.part == next.part);
        // Merge only where the common box is hardly larger than both: a search over empty space costs more than two searches.
        let volume = |b: &BoundingBox| (b.high - b.low).product();
        let fits = |close: &&mut CloseBox| {
            let joined = close.bounds.join(&next.bounds);
            volume(&joined) <= GAIN * (volume(&close.bounds) + volume(&next.bounds))
        };
        match same.into_iter().find(fits) {
            Some(close) => close.bounds = close.bounds.join(&next.bounds),
            None => merged.push(next),
        }
    }
    merged
}

/// Splits boxes into halves by position.
pub(super) fn halves(mut close: Vec<CloseBox>) -> [Vec<CloseBox>; 2] {
    let all = close.iter().fold(BoundingBox::empty(), |all, close| all.join(&close.bounds));
    // Across the longest side, so that fewer earlier bodies come to each half.
    let axis = (all.high - all.low).imax();
    close.sort_by(|a, b| a.bounds.low[axis].total_cmp(&b.bounds.low[axis]));
    let upper = close.split_off(close.len() / 2);
    [close, upper]
}
