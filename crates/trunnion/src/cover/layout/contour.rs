//! Contours of a distance in the plane, found on a grid and followed to a tolerance.

use crate::math;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Point of a plane \[mm\].
pub(crate) type PlanePoint = [f64; 2];

/// Steps of a root search: the interval shrinks by half at least every second step.
const ROOT_STEPS: usize = 64;

/// Error of a guess at the contour, as a share of it.
const GUESSED: f64 = 0.03;

/// Sagitta over chord of a piece that is followed however short it is: at a corner it does not fall with the chord.
const BENT: f64 = 0.05;

/// Chords over a distance of the contour from them that are looked at: others are too short to be far off.
const LONG: f64 = 20.0;

/// Turn between two chords that is a corner: chords of a smooth piece turn by eight times [`BENT`] at most \[rad\].
const TURN: f64 = 0.6;

/// Square grid on which contours are sought.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LevelGrid {
    /// Lowest corner.
    pub(crate) low: PlanePoint,
    /// Side of a cell \[mm\].
    pub(crate) step: f64,
    /// Number of cells each way.
    pub(crate) counts: [usize; 2],
}

/// Polyline along which a distance is zero, the positive side on the left.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Contour {
    pub(crate) points: Vec<PlanePoint>,
    /// `true` if the last point joins the first, which is not repeated.
    pub(crate) closed: bool,
}

/// Tolerances of a followed contour.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContourTolerance {
    /// Largest distance of the contour from a chord \[mm\].
    pub(crate) sagitta: f64,
    /// Longest chord \[mm\].
    pub(crate) longest: f64,
    /// Chord below which a contour that still bends has a corner \[mm\].
    pub(crate) corner: f64,
}

/// Signed distance: the contour is where it is zero. Where it is negative it may be lower than it says.
#[derive(Clone, Copy)]
pub(crate) struct LevelField<'a> {
    pub(crate) distance: &'a (dyn Fn(PlanePoint) -> f64 + Sync),
    /// Distance up to which a point lies on the contour, and length at which its search ends \[mm\].
    pub(crate) root: f64,
}

impl LevelField<'_> {
    fn at(self, point: PlanePoint) -> f64 {
        (self.distance)(point)
    }

    /// Returns `true` where the tool may stand.
    pub(crate) fn is_free(self, point: PlanePoint) -> bool {
        self.at(point) > 0.0
    }

    /// Returns `true` at the contour. Of a negative value only the sign is certain: the field may be far lower.
    fn is_zero(self, value: f64) -> bool {
        (0.0..=self.root).contains(&value)
    }
}

impl LevelGrid {
    /// Returns a grid over a box, with cells of about `step`.
    pub(crate) fn over([low, high]: [PlanePoint; 2], step: f64) -> Self {
        // Sizes of parts over sizes of cutters: small positive numbers.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
        let counts = [0, 1].map(|k| ((high[k] - low[k]) / step).ceil().clamp(1.0, 1e6) as usize);
        Self { low, step, counts }
    }

    /// Returns the grid with each cell divided to so many each way.
    pub(crate) fn finer(&self, by: usize) -> Self {
        let counts = self.counts.map(|count| count.saturating_mul(by));
        Self { step: self.step / by as f64, counts, ..*self }
    }

    /// Returns the number of nodes.
    pub(crate) fn nodes(&self) -> usize {
        (self.counts[0] + 1).saturating_mul(self.counts[1] + 1)
    }

    fn node(&self, [i, j]: [usize; 2]) -> PlanePoint {
        [self.low[0] + self.step * i as f64, self.low[1] + self.step * j as f64]
    }

    /// Returns the number of the edge from a node to the next along `k`.
    fn edge(&self, [i, j]: [usize; 2], k: usize) -> usize {
        2 * (j * (self.counts[0] + 1) + i) + k
    }

    /// Finds the contours of a field by marching squares; the same field gives the same contours in the same order.
    pub(crate) fn contours(&self, field: LevelField<'_>) -> Vec<Contour> {
        let [nx, ny] = self.counts;
        let row =
            |j: usize| -> Vec<f64> { (0..=nx).map(|i| field.at(self.node([i, j]))).collect() };
        // Step 1: the signs at the nodes.
        let values: Vec<Vec<f64>> = (0..=ny).into_par_iter().map(row).collect();
        // Step 2: from each cell, which edge the contour enters by and which it leaves by.
        let mut next: BTreeMap<usize, usize> = BTreeMap::new();
        for j in 0..ny {
            for i in 0..nx {
                next.extend(self.cell([i, j], &values, field));
            }
        }
        // Step 3: the points on those edges.
        let mut edges: Vec<usize> = next.iter().flat_map(|(a, b)| [*a, *b]).collect();
        edges.sort_unstable();
        edges.dedup();
        let points: BTreeMap<usize, PlanePoint> =
            edges.into_par_iter().map(|edge| (edge, self.crossing(edge, field))).collect();
        chains(next)
            .into_iter()
            .map(|EdgeChain { edges, closed }| {
                let points = edges.iter().filter_map(|edge| points.get(edge).copied()).collect();
                Contour { points, closed }
            })
            .collect()
    }

    /// Returns the pieces of the contour in a cell, from edge to edge.
    fn cell(
        &self,
        [i, j]: [usize; 2],
        values: &[Vec<f64>],
        field: LevelField<'_>,
    ) -> Vec<(usize, usize)> {
        // Corners and edges counter-clockwise; edge k runs from corner k to the next.
        let positive = [values[j][i], values[j][i + 1], values[j + 1][i + 1], values[j + 1][i]]
            .map(|v| v > 0.0);
        let edges = [
            self.edge([i, j], 0),
            self.edge([i + 1, j], 1),
            self.edge([i, j + 1], 0),
            self.edge([i, j], 1),
        ];
        let leaves: Vec<usize> =
            (0..4).filter(|&k| positive[k] && !positive[(k + 1) % 4]).collect();
        let centre = || {
            let [x, y] = self.node([i, j]);
            field.is_free([x + 0.5 * self.step, y + 0.5 * self.step])
        };
        // Two positive corners across from each other are joined if the middle is positive as well.
        let joined = leaves.len() == 2 && centre();
        let returns = |k: usize| {
            let turns = [1, 2, 3]
                .map(|turn| if joined || leaves.len() == 1 { k + turn } else { k + 4 - turn });
            turns.into_iter().map(|at| at % 4).find(|&at| !positive[at] && positive[(at + 1) % 4])
        };
        leaves.iter().filter_map(|&k| Some((edges[k], edges[returns(k)?]))).collect()
    }

    /// Finds the point of an edge at which the field is zero.
    fn crossing(&self, edge: usize, field: LevelField<'_>) -> PlanePoint {
        let (node, k) = (edge / 2, edge % 2);
        let width = self.counts[0] + 1;
        let from = [node % width, node / width];
        let to = if k == 0 { [from[0] + 1, from[1]] } else { [from[0], from[1] + 1] };
        let [a, b] = [from, to].map(|at| self.node(at));
        zero_between(a, b, field)
    }
}

/// Finds the point between `a` and `b` at which a field of different signs there is zero.
pub(crate) fn zero_between(a: PlanePoint, b: PlanePoint, field: LevelField<'_>) -> PlanePoint {
    let value = field.at(a);
    if value > 0.0 {
        return border_from(a, value, b, field);
    }
    border_from(b, field.at(b), a, field)
}

/// Finds the border between a point where the field has a positive value and one where it has none.
fn border_from(
    mut free: PlanePoint,
    mut value: f64,
    mut barred: PlanePoint,
    field: LevelField<'_>,
) -> PlanePoint {
    for step in 0..ROOT_STEPS {
        let gap = apart(free, barred);
        if field.is_zero(value) || gap <= field.root {
            return free;
        }
        // A step by the distance stays on this side of the border, and ends near it where the border lies straight ahead.
        // With a bisection after each: the distance may be known as far as that only.
        let share = if step % 2 == 0 && value < gap { value / gap } else { 0.5 };
        let middle = between(free, barred, share);
        let ahead = field.at(middle);
        if ahead >= 0.0 {
            (free, value) = (middle, ahead);
        } else {
            barred = middle;
        }
    }
    free
}

pub(crate) fn between(a: PlanePoint, b: PlanePoint, share: f64) -> PlanePoint {
    [0, 1].map(|k| a[k] + share * (b[k] - a[k]))
}

pub(crate) fn apart(a: PlanePoint, b: PlanePoint) -> f64 {
    math::hypot(b[0] - a[0], b[1] - a[1])
}

/// Edges of the grid in the order in which a contour crosses them.
struct EdgeChain {
    edges: Vec<usize>,
    closed: bool,
}

/// Joins pieces to chains: open ones from their beginnings, then closed ones.
fn chains(mut next: BTreeMap<usize, usize>) -> Vec<EdgeChain> {
    let ends: std::collections::BTreeSet<usize> = next.values().copied().collect();
    let starts: Vec<usize> = next.keys().copied().filter(|edge| !ends.contains(edge)).collect();
    let mut chains = Vec::new();
    for start in starts {
        let mut edges = vec![start];
        while let Some(after) = edges.last().and_then(|edge| next.remove(edge)) {
            edges.push(after);
        }
        chains.push(EdgeChain { edges, closed: false });
    }
    while let Some((start, mut at)) = next.pop_first() {
        let mut edges = vec![start];
        while at != start {
            edges.push(at);
            match next.remove(&at) {
                Some(after) => at = after,
                None => break,
            }
        }
        chains.push(EdgeChain { edges, closed: true });
    }
    chains
}

impl Contour {
    /// Returns the distance of a point from the polyline \[mm\].
    pub(crate) fn distance(&self, point: PlanePoint) -> f64 {
        let closing = self.points.last().zip(self.points.first()).filter(|_| self.closed);
        let chords = self.points.windows(2).map(|pair| [pair[0], pair[1]]);
        let chords = chords.chain(closing.map(|(last, first)| [*last, *first]));
        chords.map(|chord| off_chord(chord, point)).fold(f64::INFINITY, f64::min)
    }

    /// Returns `true` if the contour is not within a distance \[mm\] of some chord that is much longer than that.
    pub(crate) fn strays(&self, field: LevelField<'_>, distance: f64) -> bool {
        self.points.par_windows(2).any(|pair| {
            let chord = [pair[0], pair[1]];
            let height = || height_over(chord, None, field);
            apart(chord[0], chord[1]) > LONG * distance
                && height().is_none_or(|height| height.abs() > distance)
        })
    }

    /// Returns the parts whose points are kept.
    pub(crate) fn parts(&self, keeps: impl Fn(&PlanePoint) -> bool) -> Vec<Self> {
        let kept: Vec<bool> = self.points.iter().map(keeps).collect();
        let Some(gap) = kept.iter().position(|keep| !keep) else { return vec![self.clone()] };
        let mut around: Vec<(PlanePoint, bool)> = self.points.iter().copied().zip(kept).collect();
        if self.closed {
            around.rotate_left(gap);
        }
        around
            .split(|(_, keep)| !keep)
            .filter(|part| part.len() > 1)
            .map(|part| Self { points: part.iter().map(|(p, _)| *p).collect(), closed: false })
            .collect()
    }

    /// Follows the field between the points to a tolerance, and divides the contour at its corners.
    pub(crate) fn followed(&self, field: LevelField<'_>, tolerance: ContourTolerance) -> Vec<Self> {
        let given = self.points.len();
        let pairs = if self.closed { given } else { given.saturating_sub(1) };
        // Step 1: points between the given ones, down to the corners.
        let pieces: Vec<Vec<PlanePoint>> = (0..pairs)
            .into_par_iter()
            .map(|i| {
                let mut found = Vec::new();
                let chord = [self.points[i], self.points[(i + 1) % given]];
                follow(chord, None, field, tolerance, &mut found);
                found
            })
            .collect();
        let mut points: Vec<PlanePoint> = pieces.into_iter().flatten().collect();
        if !self.closed {
            points.extend(self.points.last());
        }
        // Step 2: the corners, each the end of a piece and the beginning of the next.
        let count = points.len();
        let chords = if self.closed { count } else { count.saturating_sub(1) };
        let is_short =
            |i: usize| i < chords && apart(points[i], points[(i + 1) % count]) <= tolerance.corner;
        let turns = |i: usize| {
            let before = (i + count - 1) % count;
            let inner = self.closed || (i > 0 && i + 1 < count);
            inner && !is_short(before) && !is_short(i) && {
                turn([points[before], points[i], points[(i + 1) % count]]) > TURN
            }
        };
        let corners: Vec<[usize; 2]> = (0..count)
            .filter_map(|i| match (is_short(i), turns(i)) {
                (true, _) => Some([i, i + 1]),
                (false, true) => Some([i, i]),
                (false, false) => None,
            })
            .collect();
        // Step 3: the pieces between them, thinned.
        if corners.is_empty() {
            let mut thinned = if self.closed {
                thin(&[&points[..], &points[..1]].concat(), tolerance)
            } else {
                thin(&points, tolerance)
            };
            if self.closed {
                thinned.pop();
            }
            return vec![Self { points: thinned, closed: self.closed }];
        }
        let mut pieces = Vec::new();
        let mut add = |from: usize, to: usize| {
            // Indices beyond the last go round.
            let points: Vec<PlanePoint> = (from..=to).map(|i| points[i % count]).collect();
            if points.len() > 1 {
                pieces.push(Self { points: thin(&points, tolerance), closed: false });
            }
        };
        if !self.closed {
            add(0, corners[0][0]);
        }
        for pair in corners.windows(2) {
            add(pair[0][1], pair[1][0]);
        }
        if let Some(&[_, last]) = corners.last() {
            let end = if self.closed { corners[0][0] + count } else { count - 1 };
            if end >= last {
                add(last, end);
            }
        }
        pieces
    }
}

/// Adds the points of the contour from the beginning of a chord up to its end, without the end. `guess` is the expected height
/// of the contour over the chord.
fn follow(
    [a, b]: [PlanePoint; 2],
    guess: Option<f64>,
    field: LevelField<'_>,
    tolerance: ContourTolerance,
    found: &mut Vec<PlanePoint>,
) {
    let chord = apart(a, b);
    if chord > tolerance.corner
        && let Some(height) = height_over([a, b], guess, field)
        && (height.abs() > tolerance.sagitta.min(BENT * chord) || chord > tolerance.longest)
        // A contour whose middle is as far off as its ends is none that this chord stands for.
        && math::hypot(height, 0.5 * chord) < 0.9 * chord
    {
        let middle = over_middle([a, b], height);
        // Over half the chord an arc rises by a quarter.
        let guess = Some(0.25 * height);
        follow([a, middle], guess, field, tolerance, found);
        follow([middle, b], guess, field, tolerance, found);
    } else {
        found.push(a);
    }
}

/// Finds the point of the contour across from the middle of a chord.
pub(crate) fn on_contour(chord: [PlanePoint; 2], field: LevelField<'_>) -> Option<PlanePoint> {
    height_over(chord, None, field).map(|height| over_middle(chord, height))
}

/// Returns the point at a height over the middle of a chord, on its left.
fn over_middle([a, b]: [PlanePoint; 2], height: f64) -> PlanePoint {
    let (middle, share) = (between(a, b, 0.5), height / apart(a, b));
    [middle[0] - share * (b[1] - a[1]), middle[1] + share * (b[0] - a[0])]
}

/// Two heights over the middle of a chord, with the contour between them.
struct HeightBracket {
    free: f64,
    /// Value of the field at the free one.
    value: f64,
    barred: f64,
}

/// Finds the height of the contour over the middle of a chord, to the left; no higher than the chord is long.
fn height_over(chord: [PlanePoint; 2], guess: Option<f64>, field: LevelField<'_>) -> Option<f64> {
    let HeightBracket { free, value, barred } = bracket(chord, guess, field)?;
    let [free, barred] = [free, barred].map(|height| over_middle(chord, height));
    let [a, b] = chord;
    let border = border_from(free, value, barred, field);
    let (middle, length) = (between(a, b, 0.5), apart(a, b));
    let [out, along] = [[border[0] - middle[0], border[1] - middle[1]], [b[0] - a[0], b[1] - a[1]]];
    Some((along[0] * out[1] - along[1] * out[0]) / length)
}

/// Finds two heights over the middle of a chord about a guess, or from the chord on.
fn bracket(
    chord: [PlanePoint; 2],
    guess: Option<f64>,
    field: LevelField<'_>,
) -> Option<HeightBracket> {
    let length = apart(chord[0], chord[1]);
    let at = |height: f64| field.at(over_middle(chord, height));
    let from = guess.unwrap_or(0.0);
    let (mut last, mut value) = (from, at(from));
    // The free side is on the left of the chord: the contour lies lower than a free height, and higher than a barred one.
    let starts_free = value >= 0.0;
    let side = if starts_free { -1.0 } else { 1.0 };
    let mut step = GUESSED * from.abs() + field.root;
    while (last - from).abs() < length {
        let next = from + side * step;
        let ahead = at(next);
        match (starts_free, ahead >= 0.0) {
            (true, false) => return Some(HeightBracket { free: last, value, barred: next }),
            (false, true) => return Some(HeightBracket { free: next, value: ahead, barred: last }),
            _ => (last, value, step) = (next, ahead, 2.0 * step),
        }
    }
    None
}

/// Returns the turn between two chords.
fn turn([a, b, c]: [PlanePoint; 3]) -> f64 {
    let [x, y] = [[b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]];
    math::atan2(x[0] * y[1] - x[1] * y[0], x[0] * y[0] + x[1] * y[1]).abs()
}

/// Drops points that a chord represents.
fn thin(points: &[PlanePoint], tolerance: ContourTolerance) -> Vec<PlanePoint> {
    let mut kept = Vec::new();
    let mut at = 0;
    while let Some(&from) = points.get(at) {
        kept.push(from);
        if at + 1 == points.len() {
            break;
        }
        let holds = |to: usize| {
            apart(from, points[to]) <= tolerance.longest
                && points[at + 1..to]
                    .iter()
                    .all(|p| off_chord([from, points[to]], *p) <= tolerance.sagitta)
        };
        let mut to = at + 1;
        while to + 1 < points.len() && holds(to + 1) {
            to += 1;
        }
        at = to;
    }
    kept
}

/// Returns the distance of a point from a chord.
fn off_chord([a, b]: [PlanePoint; 2], p: PlanePoint) -> f64 {
    let [along, out] = [[b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]];
    let length = math::hypot(along[0], along[1]).max(f64::MIN_POSITIVE);
    let share = ((along[0] * out[0] + along[1] * out[1]) / (length * length)).clamp(0.0, 1.0);
    apart(between(a, b, share), p)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCE: ContourTolerance =
        ContourTolerance { sagitta: 1e-3, longest: 3.0, corner: 1e-4 };

    /// Distances that are known to rounding.
    fn exact(distance: &(dyn Fn(PlanePoint) -> f64 + Sync)) -> LevelField<'_> {
        LevelField { distance, root: 1e-7 }
    }

    fn grid() -> LevelGrid {
        LevelGrid::over([[-20.3, -20.1], [20.2, 20.4]], 2.5)
    }

    #[test]
    fn a_circle_is_followed_all_round_with_the_outside_on_the_left() {
        let field = |[x, y]: PlanePoint| x.hypot(y) - 12.0;
        let found = grid().contours(exact(&field));
        assert_eq!(found.len(), 1);
        let round = found[0].followed(exact(&field), TOLERANCE);
        assert!(round.len() == 1 && round[0].closed);
        let points = &round[0].points;
        let mut turned = 0.0;
        for (i, a) in points.iter().enumerate() {
            let b = points[(i + 1) % points.len()];
            assert!((a[0].hypot(a[1]) - 12.0).abs() < 1e-6);
            turned += (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
            // Chords keep the sagitta: c^2 / (8 r) at most.
            assert!(apart(*a, b) <= 1.02 * (8.0 * 12.0 * TOLERANCE.sagitta).sqrt());
        }
        // Clockwise: the positive outside is on the left.
        assert!((turned + std::f64::consts::TAU).abs() < 1e-9, "{turned}");
    }

    /// A field may end its search at the first point that is too near: below zero only its sign counts.
    #[test]
    fn a_field_that_is_shallow_below_zero_is_followed_all_the_same() {
        let field = |[x, y]: PlanePoint| {
            let distance = x.hypot(y) - 12.0;
            if distance < 0.0 { -1e-8 } else { distance.min(1e-4) }
        };
        let round = grid().contours(exact(&field))[0].followed(exact(&field), TOLERANCE);
        assert!(round.len() == 1 && round[0].closed);
        assert!(round[0].points.iter().all(|p| (p[0].hypot(p[1]) - 12.0).abs() < 1e-6));
    }

    /// A point of the tool's border costs a search over the faces at each evaluation.
    #[test]
    fn a_point_of_a_contour_takes_few_evaluations() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let count = AtomicUsize::new(0);
        // Known up to 1e-4 above the contour, and by its sign below, as distances of the tool are.
        let field = |[x, y]: PlanePoint| {
            count.fetch_add(1, Ordering::Relaxed);
            let distance = x.hypot(y) - 12.0;
            if distance < 0.0 { -1e-8 } else { distance.min(1e-4) }
        };
        let field = LevelField { distance: &field, root: 2e-5 };
        let found = grid().contours(field);
        count.store(0, Ordering::Relaxed);
        let round = found[0].followed(field, TOLERANCE);
        let points = round[0].points.len();
        let evaluations = count.load(Ordering::Relaxed);
        assert!(points >= 100 && evaluations <= 9 * points, "{evaluations} for {points}");
    }

    #[test]
    fn a_square_has_four_corners() {
        let field = |[x, y]: PlanePoint| 11.0 - x.abs().max(y.abs());
        let found = grid().contours(exact(&field));
        assert_eq!(found.len(), 1);
        let sides = found[0].followed(exact(&field), TOLERANCE);
        assert_eq!(sides.len(), 4);
        for side in &sides {
            let [Some(a), Some(b)] = [side.points.first(), side.points.last()] else { panic!() };
            for end in [a, b] {
                assert!((end[0].abs() - 11.0).abs() < 2e-4 && (end[1].abs() - 11.0).abs() < 2e-4);
            }
            // Straight: no more stations than the longest chord asks for.
            assert!(side.points.len() <= 12, "{}", side.points.len());
            // The inside on the left: counter-clockwise.
            assert!(a[0] * b[1] - a[1] * b[0] > 0.0);
        }
    }

    /// On cells wider than the ring contours run across it; on finer ones there are two.
    #[test]
    fn a_ring_narrower_than_a_cell_shows_by_contours_that_stray() {
        let ring = |[x, y]: PlanePoint| 0.9 - (x.hypot(y) - 16.0).abs();
        let followed = |grid: LevelGrid| -> Vec<Contour> {
            let contours = grid.contours(exact(&ring));
            contours.iter().flat_map(|one| one.followed(exact(&ring), TOLERANCE)).collect()
        };
        let strays =
            |contours: &[Contour]| contours.iter().any(|one| one.strays(exact(&ring), 0.05));
        assert!(strays(&followed(grid())));
        let fine = followed(grid().finer(4));
        assert!(!strays(&fine) && fine.len() == 2 && fine.iter().all(|contour| contour.closed));
        assert!(fine[0].distance([17.1, 0.0]).min(fine[1].distance([17.1, 0.0])) < 0.21);
    }

    #[test]
    fn contours_that_leave_the_grid_are_open() {
        let field = |[x, _]: PlanePoint| x - 3.0;
        let found = grid().contours(exact(&field));
        assert!(found.len() == 1 && !found[0].closed);
        assert!(found[0].points.iter().all(|p| (p[0] - 3.0).abs() < 1e-6));
    }

    #[test]
    fn two_islands_across_from_each_other_stay_apart() {
        // Equal signs on the diagonal of a cell, the middle decides.
        let field =
            |[x, y]: PlanePoint| 3.0 - (x - 2.0).hypot(y - 2.0).min((x + 2.2).hypot(y + 2.2));
        let found = LevelGrid::over([[-7.0, -7.0], [7.0, 7.0]], 1.0).contours(exact(&field));
        assert_eq!(found.len(), 1 + usize::from(field([-0.1, -0.1]) <= 0.0));
        assert!(found.iter().all(|contour| contour.closed));
    }
}
