//! Self-crossings of a closed polyline.

use std::cmp::Ordering;

/// Both loops that a crossing makes must be larger than this share of the whole, by one of the
/// axes: smaller ones are what rounding leaves where neighbouring curves of a file overlap.
const LOBE: f64 = 1e-3;

/// Finds a point where the polyline through `points` (its last one joins the first plus `advance`)
/// crosses itself, with loops on both sides larger than rounding and than `tolerance` (in u, v).
pub(super) fn crossing(points: &[[f64; 2]], tolerance: f64) -> Option<[f64; 2]> {
    let count = points.len().saturating_sub(1);
    let low = |i: usize| points[i][0].min(points[i + 1][0]);
    let high = |i: usize| points[i][0].max(points[i + 1][0]);
    // Sweep along u: chords are compared only while their ranges of u overlap.
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| low(a).total_cmp(&low(b)));
    let whole = extent(points.iter());
    for (place, &i) in order.iter().enumerate() {
        for &j in order[place + 1..].iter().take_while(|&&j| low(j) <= high(i)) {
            let (first, second) = (i.min(j), i.max(j));
            let Some(at) = meet(chord(points, first), chord(points, second)) else { continue };
            // The crossing parts the loop in two: from it round to itself, and the rest.
            let inner = extent(points[first + 1..=second].iter().chain([&at]));
            let outer = points[..=first].iter().chain(&points[second + 1..]).chain([&at]);
            let lobes = [inner, extent(outer)];
            let large = |lobe: &[f64; 2]| (0..2).any(|k| lobe[k] > tolerance.max(LOBE * whole[k]));
            if lobes.iter().all(large) {
                return Some(at);
            }
        }
    }
    None
}

fn chord(points: &[[f64; 2]], i: usize) -> [[f64; 2]; 2] {
    [points[i], points[i + 1]]
}

/// Returns width and height of the box of `points`.
fn extent<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> [f64; 2] {
    let start = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    let bounds = points.fold(start, |bounds, point| {
        [0, 1].map(|k| [bounds[k][0].min(point[k]), bounds[k][1].max(point[k])])
    });
    bounds.map(|[low, high]| high - low)
}

/// Returns the point in which two chords cross; `None` if they only touch.
fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let apart = |k: usize| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k]);
    if apart(0) || apart(1) {
        return None;
    }
    // Twice the area of the triangle p, q, r: its sign is the side of line pq on which r is.
    let side = |[p, q]: [[f64; 2]; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let (to_c, to_d) = (side([a, b], c), side([a, b], d));
    let (to_a, to_b) = (side([c, d], a), side([c, d], b));
    // Strictly on both sides: a chord that ends on the other only touches it.
    let across = |x: f64, y: f64| {
        matches!(
            (x.total_cmp(&0.0), y.total_cmp(&0.0)),
            (Ordering::Less, Ordering::Greater) | (Ordering::Greater, Ordering::Less)
        ) && x != 0.0
            && y != 0.0
    };
    if !across(to_c, to_d) || !across(to_a, to_b) {
        return None;
    }
    // Areas over the same base are as the heights of a and b over line cd.
    let t = to_a / (to_a - to_b);
    Some([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bow_tie_crosses_in_its_middle() {
        let tie = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [0.0, 0.0]];
        let at = crossing(&tie, 1e-9).unwrap();
        assert!((at[0] - 1.0).abs() < 1e-15 && (at[1] - 1.0).abs() < 1e-15);
    }

    #[test]
    fn touching_sides_and_spikes_do_not_cross() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]];
        assert_eq!(crossing(&square, 1e-9), None);
        let touching =
            [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0], [0.0, 0.0]];
        assert_eq!(crossing(&touching, 1e-9), None);
        let spike = [[0.0, 0.0], [3.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]];
        assert_eq!(crossing(&spike, 1e-9), None);
    }

    #[test]
    fn an_overlap_of_rounding_size_is_let_pass() {
        // The last side starts a little beyond the first and crosses it near their common corner.
        let step = 1e-7;
        let hook = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [step, 2.0], [step, -step], [0.0, 0.0]];
        assert_eq!(crossing(&hook, 1e-9), None);
        let hook = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.5, 2.0], [0.5, -0.5], [0.0, 0.0]];
        assert_eq!(crossing(&hook, 1e-9), Some([0.5, 0.0]));
    }
}
