//! The lowest point of a ray that the moving tool reaches.

use super::body::{Body, Ray};
use super::sweep::{Piece, Target};

/// The lowest entry found so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lowest {
    /// Where the ray enters the tool \[mm\]; the end of the search if nothing is `hit`.
    pub(super) s: f64,
    /// Line of the program that got there.
    pub(super) line: Option<u32>,
}

/// Depth at which an interval of time is 1e-9 of a piece: below all rounding.
const DEEPEST: u32 = 30;

impl Lowest {
    /// Lowers `s` to the lowest entry of the ray into `body` during `piece`, to within `tolerance`
    /// \[mm\].
    ///
    /// Branch and bound over time: an interval in which the tool cannot come lower by more than the
    /// tolerance is dropped, otherwise its middle is tried exactly and both halves are searched.
    /// A touch that cuts into the ray by less than a tenth of the tolerance may be dropped: without
    /// that a tool sliding along the ray would be searched for ever.
    #[inline]
    pub(super) fn search(&mut self, piece: &Piece, body: Body, ray: &Ray, tolerance: f64) {
        let graze = -0.1 * tolerance;
        let limit = self.s - tolerance;
        if limit <= -ray.below {
            return;
        }
        // Most pieces end here: one distance and its derivatives.
        let bound = piece.bound(piece.middle(), 1.0, &Target { body, ray, s: limit });
        if bound.low > graze {
            return;
        }
        self.refine(piece, body, ray, tolerance);
    }

    /// The search proper.
    fn refine(&mut self, piece: &Piece, body: Body, ray: &Ray, tolerance: f64) {
        let graze = -0.1 * tolerance;
        let mut open = [(0.0, 0u32); 2 * DEEPEST as usize];
        let mut count = 1usize;
        while let Some(&(u, depth)) = count.checked_sub(1).and_then(|last| open.get(last)) {
            count -= 1;
            let half = 0.5f64.powi(depth.cast_signed());
            let instant = piece.instant(u);
            let limit = self.s - tolerance;
            if limit <= -ray.below {
                return;
            }
            let bound = piece.bound(&instant, half, &Target { body, ray, s: limit });
            if bound.low > graze {
                continue;
            }
            if let Some(s) = body.entry(&instant.stand, ray, self.s, 1e-3 * tolerance) {
                *self = Self { s, line: Some(piece.line) };
            }
            if depth + 1 >= DEEPEST {
                continue;
            }
            // The half towards which the tool comes down is searched first: last in, first out.
            let step = 0.5 * half * if bound.drift > 0.0 { 1.0 } else { -1.0 };
            for next in [u + step, u - step] {
                if let Some(place) = open.get_mut(count) {
                    *place = (next, depth + 1);
                    count += 1;
                }
            }
        }
    }
}
