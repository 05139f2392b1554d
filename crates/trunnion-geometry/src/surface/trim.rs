//! Trim loops: closed chains of curves in u, v.

use super::crossing::crossing;
use super::error::{SurfaceError, SurfaceErrors};
use crate::math;
use crate::math::bspline::KnotVector;
use crate::math::bspline::LARGE;
use crate::math::bspline::SMALL;
use crate::types::Interval;
use crate::types::Uv;
use nalgebra::Vector3;

/// Below this share of its box a loop's area is rounding of its coordinates.
const FLAT: f64 = 1e-12;

/// Chords that stand for a loop in the search for crossings stay within this share of its box: a
/// tenth of one per cent of what [`crossing`] still lets pass.
const CHORDS: f64 = 1e-6;

/// A sum of a parameter and a period is right to this share of the period.
pub(crate) const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Halvings after which a piece is a straight line to the last bit, whatever its shape.
const HALVINGS: u32 = 60;

/// One piece of a loop: Bezier points `(w u, w v, w)`.
type TrimPiece = Vec<Vector3<f64>>;

/// A curve in u, v: Bezier pieces of equal degree, end to end.
#[derive(Debug, Clone, PartialEq)]
pub struct TrimCurve {
    pieces: Vec<TrimPiece>,
}

/// A closed chain of curves in u, v.
///
/// On a periodic surface a chain may also close after running round the period: see
/// [`TrimLoop::turns`].
#[derive(Debug, Clone, PartialEq)]
pub struct TrimLoop {
    pieces: Vec<TrimPiece>,
    /// Boxes of the pieces.
    boxes: Vec<[Interval; 2]>,
    bounds: [Interval; 2],
    /// `turns` periods, in u and v.
    advance: [f64; 2],
    turns: [i32; 2],
}

impl TrimCurve {
    /// Creates straight lines through `points`.
    ///
    /// # Errors
    ///
    /// Numbers that are not finite; fewer than two points.
    pub fn polyline(points: &[[f64; 2]]) -> Result<Self, SurfaceErrors> {
        let faults = point_faults(points, None);
        if !faults.is_empty() {
            return Err(faults.into());
        }
        if points.len() < 2 {
            let reason = "a trim polyline needs two points or more";
            return Err(vec![SurfaceError::DegenerateLoop { reason }].into());
        }
        let lift = |[u, v]: [f64; 2]| Vector3::new(u, v, 1.0);
        let pieces = points.windows(2).map(|pair| vec![lift(pair[0]), lift(pair[1])]).collect();
        Ok(Self { pieces })
    }

    /// Creates a B-spline curve, rational where `weights` are given, over its whole range of knots.
    ///
    /// # Errors
    ///
    /// All faults of knots, points and weights.
    pub fn spline(
        degree: usize,
        knots: Vec<f64>,
        points: &[[f64; 2]],
        weights: Option<&[f64]>,
    ) -> Result<Self, SurfaceErrors> {
        let mut faults = point_faults(points, weights);
        let knots = KnotVector::new(degree, points.len(), knots).map_err(|errors| {
            let named = |error| SurfaceError::Knots { direction: "curve", error };
            faults.extend(errors.into_iter().map(named));
        });
        let (Ok(knots), true) = (knots, faults.is_empty()) else { return Err(faults.into()) };
        let weight = |i: usize| weights.and_then(|all| all.get(i)).copied().unwrap_or(1.0);
        let lift = |(i, &[u, v]): (usize, &[f64; 2])| Vector3::new(u, v, 1.0) * weight(i);
        let net: Vec<Vector3<f64>> = points.iter().enumerate().map(lift).collect();
        let bezier = knots.bezier(&net);
        Ok(Self { pieces: bezier.chunks_exact(degree + 1).map(<[_]>::to_vec).collect() })
    }

    /// Returns the same curve run the other way.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.pieces.reverse();
        self.pieces.iter_mut().for_each(|piece| piece.reverse());
        self
    }

    /// Returns the first point.
    pub fn start(&self) -> Uv {
        cartesian(&self.pieces[0][0]).into()
    }

    /// Returns the last point.
    pub fn end(&self) -> Uv {
        let piece = &self.pieces[self.pieces.len() - 1];
        cartesian(&piece[piece.len() - 1]).into()
    }

    /// Moves the curve by `[du, dv]`.
    fn moved(mut self, [du, dv]: [f64; 2]) -> Self {
        move_pieces(&mut self.pieces, [du, dv]);
        self
    }
}

impl TrimLoop {
    /// Chains `curves` in order. Ends may lie apart by whole `periods`; then the curves are moved
    /// to meet. Gaps up to `tolerance` (in u, v) are closed by straight lines.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::OpenLoop`] for every larger gap, [`SurfaceError::DegenerateLoop`] for a
    /// loop without area, [`SurfaceError::CrossedLoop`] for one that crosses itself.
    pub fn new(
        curves: Vec<TrimCurve>,
        periods: [Option<f64>; 2],
        tolerance: f64,
    ) -> Result<Self, SurfaceErrors> {
        let count = curves.len();
        let Some(start) = curves.first().map(|curve| <[f64; 2]>::from(curve.start())) else {
            return Err(vec![SurfaceError::DegenerateLoop { reason: "it has no curves" }].into());
        };
        let mut faults = Vec::new();
        let mut gap_at = |curve: usize, at: [f64; 2], to: [f64; 2]| {
            let gap = math::hypot(to[0] - at[0], to[1] - at[1]);
            if gap > tolerance {
                let next = (curve + 1) % count;
                faults.push(SurfaceError::OpenLoop { curve, next, gap, at: at.into(), tolerance });
            }
        };
        let mut pieces: Vec<TrimPiece> = Vec::new();
        let mut end = start;
        for (index, curve) in curves.into_iter().enumerate() {
            // Ends whole periods apart are one point of the surface: the curve moves to the turn of
            // the last.
            let shift = whole_periods(curve.start().into(), end, periods);
            let curve = curve.moved(shift);
            if index > 0 {
                gap_at(index - 1, end, curve.start().into());
            }
            join(&mut pieces, end, curve.start().into());
            end = curve.end().into();
            pieces.extend(curve.pieces);
        }
        // Likewise the end of the loop may lie whole periods from its start: it runs round the
        // surface.
        let turn = whole_periods(start, end, periods);
        let goal = [start[0] + turn[0], start[1] + turn[1]];
        gap_at(count - 1, end, goal);
        if math::hypot(end[0] - goal[0], end[1] - goal[1])
            > ROUNDING * (turn[0].abs() + turn[1].abs())
        {
            join(&mut pieces, end, goal);
        }
        if !faults.is_empty() {
            return Err(faults.into());
        }
        let trim = Self::closed(pieces, turn, turns(turn, periods));
        trim.fault(tolerance).map_or(Ok(trim), |fault| Err(vec![fault].into()))
    }

    fn closed(mut pieces: Vec<TrimPiece>, advance: [f64; 2], turns: [i32; 2]) -> Self {
        unit_ends(&mut pieces);
        meet(&mut pieces, advance);
        let (boxes, bounds) = (boxes_of(&pieces), bounds_of(&pieces));
        Self { pieces, boxes, bounds, advance, turns }
    }

    /// Returns the reason for which the loop has no inside.
    fn fault(&self, tolerance: f64) -> Option<SurfaceError> {
        let [width, height] = self.bounds.map(|range| range.width());
        let fine = [CHORDS * width, CHORDS * height];
        if let Some(at) = crossing(&self.polyline(fine), tolerance) {
            return Some(SurfaceError::CrossedLoop { at: at.into() });
        }
        // Fine enough that no loop of nonzero area flattens to none.
        let tiny = [width / 64.0, height / 64.0];
        let area = shoelace(&self.polyline(tiny)).abs();
        let flat = self.turns == [0, 0] && (area.is_nan() || area <= FLAT * width * height);
        flat.then_some(SurfaceError::DegenerateLoop { reason: "it encloses no area" })
    }

    /// Returns `true` if the loop is made of straight lines.
    pub(crate) fn is_polygon(&self) -> bool {
        self.pieces.iter().all(|piece| piece.len() == 2)
    }

    /// Returns the box of the loop, `[[u low, u high], [v low, v high]]`: of control points, so
    /// that the loop itself may be a little smaller.
    pub fn bounds(&self) -> [Interval; 2] {
        self.bounds
    }

    /// Returns the number of periods by u and v between start and end of the loop: `[0, 0]` unless
    /// it runs round a periodic surface.
    pub fn turns(&self) -> [i32; 2] {
        self.turns
    }

    /// Returns the point in which the loop closes; on a periodic surface, the lower of its two
    /// ends.
    pub(crate) fn joint(&self) -> [f64; 2] {
        let start = cartesian(&self.pieces[0][0]);
        let last = &self.pieces[self.pieces.len() - 1];
        let end = cartesian(&last[last.len() - 1]);
        [start[0].min(end[0]), start[1].min(end[1])]
    }

    /// Returns the points of a polyline that stays within `tolerance` (by u and by v) of the loop;
    /// the last point joins the first (or lies [`TrimLoop::turns`] periods further).
    pub fn polyline(&self, tolerance: [f64; 2]) -> Vec<[f64; 2]> {
        let mut points = vec![cartesian(&self.pieces[0][0])];
        for piece in &self.pieces {
            flatten(piece, tolerance, 0, &mut points);
        }
        points
    }

    /// Moves the loop by `[du, dv]`.
    pub(crate) fn shift(&mut self, [du, dv]: [f64; 2]) {
        move_pieces(&mut self.pieces, [du, dv]);
        meet(&mut self.pieces, self.advance);
        (self.boxes, self.bounds) = (boxes_of(&self.pieces), bounds_of(&self.pieces));
    }

    /// Counts the crossings of the loop by the ray from `point` in the direction of growing u
    /// (`along = 0`) or v (1).
    pub(crate) fn crossings(&self, point: [f64; 2], along: usize) -> u32 {
        let count = |(piece, bounds): (&TrimPiece, &[Interval; 2])| {
            if passes_by(bounds, point, along) {
                0
            } else if piece.len() <= SMALL {
                crossings_of_ray::<SMALL>(piece, point, along)
            } else {
                crossings_of_ray::<LARGE>(piece, point, along)
            }
        };
        self.pieces.iter().zip(&self.boxes).map(count).sum()
    }
}

/// Returns true if the ray of [`TrimLoop::crossings`] passes by a box at a distance, or starts beyond it.
fn passes_by(bounds: &[Interval; 2], point: [f64; 2], along: usize) -> bool {
    let (Interval { low, high }, end) = (bounds[1 - along], bounds[along].high);
    // Control points are moved to the start of the ray with rounding: of a box that near, they decide themselves.
    let far = |from: f64, to: f64| to - from > ROUNDING * (from.abs() + to.abs());
    far(high, point[1 - along]) || far(point[1 - along], low) || far(end, point[along])
}

/// Counts the crossings of one piece, of at most `N` points, by the ray of [`TrimLoop::crossings`].
fn crossings_of_ray<const N: usize>(piece: &TrimPiece, point: [f64; 2], along: usize) -> u32 {
    // With the start of the ray at the origin and the ray along +x; weights stay.
    let (px, py) = (point[along], point[1 - along]);
    let mut local = [Vector3::zeros(); N];
    let local = &mut local[..piece.len()];
    for (to, from) in local.iter_mut().zip(piece) {
        let (x, y) = (from[along], from[1 - along]);
        *to = Vector3::new(x - px * from.z, y - py * from.z, from.z);
    }
    crossings::<N>(local, 0)
}

/// Counts crossings of a Bezier piece with the positive x axis: decided by its control points
/// where these lie on one side, else by halving. Ends count by the half-open rule `y >= 0`, so
/// that a crossing through a joint counts once.
fn crossings<const N: usize>(piece: &[Vector3<f64>], halvings: u32) -> u32 {
    let above = |point: &Vector3<f64>| point.y >= 0.0;
    let n = piece.len();
    let (first, last) = (&piece[0], &piece[n - 1]);
    let sides = piece.iter().filter(|point| above(point)).count();
    // The curve lies in the hull of its points: all above, below or behind the start, it does not
    // meet the ray.
    if sides == 0 || sides == n || piece.iter().all(|point| point.x < 0.0) {
        return 0;
    }
    // Wholly in front of the start, only the ends decide: other crossings come in pairs.
    if piece.iter().all(|point| point.x > 0.0) {
        return u32::from(above(first) != above(last));
    }
    if n == 2 || halvings == HALVINGS {
        // The chord meets the axis right of the origin: `x0 + (x1 - x0) y0 / (y0 - y1) > 0`.
        let (a, b) = (cartesian(first), cartesian(last));
        let right = (b[0] * a[1] - a[0] * b[1]) * (a[1] - b[1]).signum() > 0.0;
        return u32::from(above(first) != above(last) && right);
    }
    let mut left = [Vector3::zeros(); N];
    let mut right = [Vector3::zeros(); N];
    halve(piece, &mut left[..n], &mut right[..n]);
    crossings::<N>(&left[..n], halvings + 1) + crossings::<N>(&right[..n], halvings + 1)
}

/// Halves a piece by de Casteljau's algorithm.
fn halve(piece: &[Vector3<f64>], left: &mut [Vector3<f64>], right: &mut [Vector3<f64>]) {
    let n = piece.len();
    right.copy_from_slice(piece);
    for (k, start) in left.iter_mut().enumerate() {
        *start = right[0];
        for i in 0..n - 1 - k {
            right[i] = (right[i] + right[i + 1]) * 0.5;
        }
    }
}

/// Adds the end points of chords that stay within `tolerance` of `piece`.
fn flatten(piece: &[Vector3<f64>], tolerance: [f64; 2], halvings: u32, out: &mut Vec<[f64; 2]>) {
    let n = piece.len();
    let (a, b) = (cartesian(&piece[0]), cartesian(&piece[n - 1]));
    // Points of the chord at i / n are blended to points of the chord: the offsets of the control
    // points from them bound that of the curve.
    let near = piece.iter().enumerate().all(|(i, point)| {
        let t = i as f64 / (n - 1) as f64;
        let p = cartesian(point);
        (0..2).all(|k| (p[k] - (a[k] + t * (b[k] - a[k]))).abs() <= tolerance[k])
    });
    // 2^12 chords a piece are more than any picture needs; the bound holds zero tolerances back.
    if near || halvings == 12 {
        out.push(b);
        return;
    }
    let mut left = [Vector3::zeros(); LARGE];
    let mut right = [Vector3::zeros(); LARGE];
    halve(piece, &mut left[..n], &mut right[..n]);
    flatten(&left[..n], tolerance, halvings + 1, out);
    flatten(&right[..n], tolerance, halvings + 1, out);
}

fn cartesian(point: &Vector3<f64>) -> [f64; 2] {
    [point.x / point.z, point.y / point.z]
}

fn move_pieces(pieces: &mut [TrimPiece], [du, dv]: [f64; 2]) {
    for point in pieces.iter_mut().flatten() {
        point.x += du * point.z;
        point.y += dv * point.z;
    }
}

/// Adds a straight piece over a gap, if there is one.
fn join(pieces: &mut Vec<TrimPiece>, from: [f64; 2], to: [f64; 2]) {
    if from[0].total_cmp(&to[0]).is_ne() || from[1].total_cmp(&to[1]).is_ne() {
        pieces.push(vec![Vector3::new(from[0], from[1], 1.0), Vector3::new(to[0], to[1], 1.0)]);
    }
}

/// Makes the last point of a loop exactly `turn` from its first, added to the lower of the two: so
/// that a point's copies, found the same way, cross the joint once.
fn meet(pieces: &mut [TrimPiece], turn: [f64; 2]) {
    let Some(start) = pieces.first().map(|piece| cartesian(&piece[0])) else { return };
    let set = |point: &mut Vector3<f64>, [u, v]: [f64; 2]| {
        *point = Vector3::new(u * point.z, v * point.z, point.z);
    };
    let Some(end) = pieces.last().map(|piece| cartesian(&piece[piece.len() - 1])) else { return };
    if turn[0] + turn[1] >= 0.0 {
        if let Some(point) = pieces.last_mut().and_then(|piece| piece.last_mut()) {
            set(point, [start[0] + turn[0], start[1] + turn[1]]);
        }
    } else if let Some(point) = pieces.first_mut().and_then(|piece| piece.first_mut()) {
        set(point, [end[0] - turn[0], end[1] - turn[1]]);
    }
}

/// Makes the end weights of every piece 1 (a change of parameter, not of shape: weights times
/// `c^i`) and neighbouring ends equal to the last bit: the half-open rule needs both.
fn unit_ends(pieces: &mut [TrimPiece]) {
    let mut end: Option<Vector3<f64>> = None;
    for piece in pieces {
        let n = piece.len() - 1;
        let (first, last) = (piece[0].z, piece[n].z);
        // Weights times c^i with c^n = first / last, over the first weight: both ends become 1.
        let ratio = math::powf(first / last, 1.0 / n as f64);
        for (i, point) in piece.iter_mut().enumerate() {
            *point *= math::powf(ratio, i as f64) / first;
        }
        for k in [0, n] {
            let [u, v] = cartesian(&piece[k]);
            piece[k] = Vector3::new(u, v, 1.0);
        }
        if let Some(end) = end {
            piece[0] = end;
        }
        end = Some(piece[n]);
    }
}

fn boxes_of(pieces: &[TrimPiece]) -> Vec<[Interval; 2]> {
    pieces.iter().map(|piece| bounds_of(std::slice::from_ref(piece))).collect()
}

fn bounds_of(pieces: &[TrimPiece]) -> [Interval; 2] {
    let mut bounds = [Interval::new(f64::INFINITY, f64::NEG_INFINITY); 2];
    for point in pieces.iter().flatten().map(cartesian) {
        for (bound, x) in bounds.iter_mut().zip(point) {
            *bound = bound.hull(Interval::point(x));
        }
    }
    bounds
}

/// Returns the whole periods that bring `from` nearest to `to`.
fn whole_periods(from: [f64; 2], to: [f64; 2], periods: [Option<f64>; 2]) -> [f64; 2] {
    [0, 1].map(|k| periods[k].map_or(0.0, |period| period * ((to[k] - from[k]) / period).round()))
}

#[expect(clippy::cast_possible_truncation, reason = "a quotient of whole periods, saturating")]
fn turns(shift: [f64; 2], periods: [Option<f64>; 2]) -> [i32; 2] {
    [0, 1].map(|k| periods[k].map_or(0, |period| (shift[k] / period).round() as i32))
}

/// Returns twice the signed area.
fn shoelace(points: &[[f64; 2]]) -> f64 {
    let Some(&[u0, v0]) = points.first() else { return 0.0 };
    // Relative to the first point, so that large coordinates do not cancel.
    let cross = |pair: &[[f64; 2]]| {
        (pair[0][0] - u0) * (pair[1][1] - v0) - (pair[1][0] - u0) * (pair[0][1] - v0)
    };
    points.windows(2).map(cross).sum()
}

fn point_faults(points: &[[f64; 2]], weights: Option<&[f64]>) -> Vec<SurfaceError> {
    let mut faults = Vec::new();
    for (i, point) in points.iter().enumerate() {
        for &value in point.iter().filter(|value| !value.is_finite()) {
            faults.push(SurfaceError::NotFinite { what: format!("trim point {i}"), value });
        }
    }
    if let Some(weights) = weights {
        if weights.len() != points.len() {
            let (found, expected) = (weights.len(), points.len());
            faults.push(SurfaceError::RowLength { what: "weights", row: 0, found, expected });
        }
        for (i, &value) in weights.iter().enumerate() {
            if !(value.is_finite() && value > 0.0) {
                faults.push(SurfaceError::Weight { place: format!("trim point {i}"), value });
            }
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(radius: f64) -> TrimCurve {
        // Nine-point rational circle.
        let h = 0.5_f64.sqrt();
        let square = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]];
        let points = square.map(|p| p.map(|x| f64::from(x) * radius));
        let weights = [1.0, h, 1.0, h, 1.0, h, 1.0, h, 1.0];
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
        TrimCurve::spline(2, knots, &points, Some(&weights)).unwrap()
    }

    #[test]
    fn halving_keeps_the_curve() {
        let piece = [[0.0, 0.0], [1.0, 2.0], [3.0, -1.0]].map(|[x, y]| Vector3::new(x, y, 1.0));
        let (mut left, mut right) = ([Vector3::zeros(); 3], [Vector3::zeros(); 3]);
        halve(&piece, &mut left, &mut right);
        assert_eq!(left[1], Vector3::new(0.5, 1.0, 1.0));
        assert_eq!(left[2], right[0]);
        assert_eq!(right[0], Vector3::new(1.25, 0.75, 1.0));
        assert_eq!(right[1], Vector3::new(2.0, 0.5, 1.0));
        assert_eq!(right[2], piece[2]);
    }

    #[test]
    fn crossings_of_a_circle() {
        let circle = TrimLoop::new(vec![circle(2.0)], [None; 2], 1e-9).unwrap();
        for along in [0, 1] {
            for (point, count) in [
                ([0.0, 0.0], 1),
                ([1.99, 0.0], 1),
                ([2.01, 0.0], 0),
                ([-3.0, 0.1], if along == 0 { 2 } else { 0 }),
                ([1.41, 1.41], 1),
                ([1.42, 1.42], 0),
            ] {
                assert_eq!(circle.crossings(point, along), count, "{point:?} {along}");
            }
        }
    }

    #[test]
    fn bad_loops_are_refused() {
        let open = TrimCurve::polyline(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]).unwrap();
        let fault = TrimLoop::new(vec![open], [None; 2], 1e-6).unwrap_err();
        assert!(matches!(fault[0], SurfaceError::OpenLoop { curve: 0, next: 0, .. }));
        let flat = TrimCurve::polyline(&[[0.0, 0.0], [1.0, 0.7], [0.0, 0.0]]).unwrap();
        let fault = TrimLoop::new(vec![flat], [None; 2], 1e-6).unwrap_err();
        assert!(matches!(fault[0], SurfaceError::DegenerateLoop { .. }));
        let tie = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [0.0, 0.0]];
        let tie = TrimCurve::polyline(&tie).unwrap();
        let fault = TrimLoop::new(vec![tie], [None; 2], 1e-6).unwrap_err();
        assert!(matches!(fault[0], SurfaceError::CrossedLoop { at } if at == [1.0, 1.0].into()));
        assert!(TrimLoop::new(vec![], [None; 2], 1e-6).is_err());
        assert!(TrimCurve::polyline(&[[0.0, f64::NAN], [1.0, 0.0]]).is_err());
    }
}
