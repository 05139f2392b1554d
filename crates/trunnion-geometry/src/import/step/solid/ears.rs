//! Ear clipping: polygons with holes are cut into triangles at their corners.

use super::corner::MeshCorner;
use super::unroll::LoopPolygon;

/// A polygon in triangles, in a plane in which lengths by u and v are alike.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlanarTriangles {
    pub(super) corners: Vec<MeshCorner>,
    pub(super) flat: Vec<[f64; 2]>,
    pub(super) triangles: Vec<[usize; 3]>,
    /// Of u and v.
    pub(super) scale: [f64; 2],
}

/// Returns twice the area of a triangle, above 0 if it is counter-clockwise.
pub(super) fn turn([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Cuts a polygon into triangles; `None` if it crosses itself.
pub(super) fn cut(polygon: &LoopPolygon, scale: [f64; 2]) -> Option<PlanarTriangles> {
    let mut corners = polygon.outer.clone();
    let mut around: Vec<usize> = (0..corners.len()).collect();
    let mut holes: Vec<Vec<usize>> = Vec::new();
    for hole in &polygon.holes {
        holes.push((corners.len()..corners.len() + hole.len()).collect());
        corners.extend(hole);
    }
    let flat: Vec<[f64; 2]> =
        corners.iter().map(|c| [c.uv[0] * scale[0], c.uv[1] * scale[1]]).collect();
    // The hole farthest to the right first: it sees the outside, or one that is joined to it.
    let right = |hole: &[usize]| hole.iter().map(|&k| flat[k][0]).fold(f64::NEG_INFINITY, f64::max);
    holes.sort_by(|a, b| right(b).total_cmp(&right(a)));
    while !holes.is_empty() {
        let hole = holes.remove(0);
        around = joined(&flat, &around, &hole, &holes)?;
    }
    let triangles = clip(&flat, around)?;
    Some(PlanarTriangles { corners, flat, triangles, scale })
}

/// Joins a polygon and a hole by a bridge that crosses no side.
fn joined(
    flat: &[[f64; 2]],
    around: &[usize],
    hole: &[usize],
    others: &[Vec<usize>],
) -> Option<Vec<usize>> {
    let rightmost =
        (0..hole.len()).max_by(|&a, &b| flat[hole[a]][0].total_cmp(&flat[hole[b]][0]))?;
    let from = flat[hole[rightmost]];
    let away = |&k: &usize| {
        let [x, y] = flat[around[k]];
        (x - from[0]).powi(2) + (y - from[1]).powi(2)
    };
    let mut order: Vec<usize> = (0..around.len()).collect();
    // The nearest corner in sight makes the shortest bridge, and round triangles beside it.
    order.sort_by(|a, b| away(a).total_cmp(&away(b)));
    let sides = |ring: &[usize]| -> Vec<[[f64; 2]; 2]> {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(&a, &b)| [flat[a], flat[b]]).collect()
    };
    let walls: Vec<[[f64; 2]; 2]> = [around, hole]
        .into_iter()
        .chain(others.iter().map(Vec::as_slice))
        .flat_map(sides)
        .collect();
    let sees = |&k: &usize| {
        let to = flat[around[k]];
        opens(flat, around, k, from) && !walls.iter().any(|wall| cross([from, to], *wall))
    };
    let at = order.into_iter().find(sees)?;
    // The bridge is run along both ways: its two corners stand twice.
    let mut all = around[..=at].to_vec();
    all.extend(&hole[rightmost..]);
    all.extend(&hole[..=rightmost]);
    all.extend(&around[at..]);
    Some(all)
}

/// Returns `true` if a point is on the inner side of a corner.
fn opens(flat: &[[f64; 2]], around: &[usize], k: usize, point: [f64; 2]) -> bool {
    let count = around.len();
    let [before, at, after] = [k + count - 1, k, k + 1].map(|k| flat[around[k % count]]);
    let [left, right] = [turn([before, at, point]) > 0.0, turn([at, after, point]) > 0.0];
    // Inside a corner that turns left is left of both its sides, else left of either.
    if turn([before, at, after]) > 0.0 { left && right } else { left || right }
}

/// Returns `true` if two segments cross, or one ends on the other; ends they share do not count.
fn cross([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let same = |p: [f64; 2], q: [f64; 2]| {
        p[0].to_bits() == q[0].to_bits() && p[1].to_bits() == q[1].to_bits()
    };
    if [c, d].iter().any(|&end| same(a, end) || same(b, end)) {
        return false;
    }
    let apart = |p: f64, q: f64| (p > 0.0 && q > 0.0) || (p < 0.0 && q < 0.0);
    // Neither segment has both ends of the other strictly on one side.
    !apart(turn([a, b, c]), turn([a, b, d])) && !apart(turn([c, d, a]), turn([c, d, b]))
}

/// Cuts off ears, the roundest first.
fn clip(flat: &[[f64; 2]], mut around: Vec<usize>) -> Option<Vec<[usize; 3]>> {
    let mut triangles = Vec::with_capacity(around.len());
    let mut ears: Vec<f64> = (0..around.len()).map(|k| ear(flat, &around, k)).collect();
    let mut fresh = true;
    while around.len() > 3 {
        let best = (0..ears.len()).max_by(|&a, &b| ears[a].total_cmp(&ears[b]))?;
        if ears[best] <= 0.0 {
            // What was in the way of an ear may be gone.
            if fresh {
                break;
            }
            ears = (0..around.len()).map(|k| ear(flat, &around, k)).collect();
            fresh = true;
            continue;
        }
        let count = around.len();
        triangles.push([count - 1, 0, 1].map(|by| around[(best + by) % count]));
        around.remove(best);
        ears.remove(best);
        let count = around.len();
        // Only the corners beside the ear have a new triangle.
        for k in [best + count - 1, best] {
            ears[k % count] = ear(flat, &around, k % count);
        }
        fresh = false;
    }
    // What is left without an ear may be corners on a line, which rounding has put there.
    let [first, rest @ ..] = &around[..] else { return Some(triangles) };
    let fan = rest.windows(2).map(|pair| [*first, pair[0], pair[1]]);
    // Three corners left may be any triangle that does not turn right; more only a line.
    let least = if around.len() > 3 { -LINE..=LINE } else { -LINE..=f64::INFINITY };
    let fits = |triangle: [usize; 3]| least.contains(&roundness(triangle.map(|k| flat[k])));
    if !fan.clone().all(fits) {
        return None;
    }
    triangles.extend(fan);
    Some(triangles)
}

/// Returns the roundness of the triangle at a corner, if it may be cut off; else 0.
fn ear(flat: &[[f64; 2]], around: &[usize], k: usize) -> f64 {
    let count = around.len();
    let corners = [count - 1, 0, 1].map(|by| flat[around[(k + by) % count]]);
    let [a, b, c] = corners;
    let round = roundness(corners);
    if round <= FLAT {
        return 0.0;
    }
    // Points nearly on a side are in the way, too.
    let beside = -LINE * turn(corners) / round;
    let inside = |p: [f64; 2]| {
        !corners.contains(&p)
            && turn([a, b, p]) >= beside
            && turn([b, c, p]) >= beside
            && turn([c, a, p]) >= beside
    };
    if around.iter().any(|&other| inside(flat[other])) { 0.0 } else { round }
}

/// Returns twice the area of a triangle over the sum of the squares of its sides.
fn roundness([a, b, c]: [[f64; 2]; 3]) -> f64 {
    let square = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
    turn([a, b, c]) / (square(a, b) + square(b, c) + square(c, a)).max(f64::MIN_POSITIVE)
}

/// A triangle less round is rounding of one without area.
const FLAT: f64 = 1e-13;
/// By this share of its length points are off a straight side: closest points on a surface are.
const LINE: f64 = 1e-7;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn corners(points: &[[f64; 2]]) -> Vec<MeshCorner> {
        points.iter().map(|&uv| MeshCorner { uv, point: Point3::new(uv[0], uv[1], 0.0) }).collect()
    }

    #[test]
    fn triangles_of_a_polygon_with_holes_have_its_area() {
        let outer = corners(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [6.0, 0.0],
            [6.0, 5.0],
            [4.0, 5.0],
            [4.0, 4.5],
            [2.0, 4.5],
            [2.0, 5.0],
            [0.0, 5.0],
        ]);
        let square =
            |x: f64, y: f64| corners(&[[x, y], [x, y + 1.0], [x + 1.0, y + 1.0], [x + 1.0, y]]);
        let polygon = LoopPolygon {
            outer,
            holes: vec![square(1.0, 1.0), square(3.0, 1.0), square(3.0, 3.0)],
        };
        let plain = cut(&polygon, [1.0, 1.0]).unwrap();
        let areas: Vec<f64> =
            plain.triangles.iter().map(|t| 0.5 * turn(t.map(|k| plain.flat[k]))).collect();
        assert!(areas.iter().all(|area| *area > 0.0));
        assert!((areas.iter().sum::<f64>() - 26.0).abs() < 1e-12);
        // As many as corners, and two more for every hole, less two.
        assert_eq!(plain.triangles.len(), 9 + 12 + 6 - 2);
        let bow = LoopPolygon {
            outer: corners(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]),
            holes: vec![],
        };
        assert_eq!(cut(&bow, [1.0, 1.0]), None);
    }
}
