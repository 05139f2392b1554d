//! Intersection of an axis-parallel ray with a triangle.

use nalgebra::Point3;

/// Crossing of an axis-parallel ray and a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RayCrossing {
    /// Position along the ray \[mm\].
    pub(crate) s: f64,
    /// Side from which the ray comes: its contribution to the winding number, +1 or -1.
    pub(crate) winding: i32,
}

/// Returns the crossing of the axis-parallel ray through `point` with a triangle, if there is one.
///
/// A ray through an edge or a corner counts for exactly one of the triangles there: it is taken to run slightly aside, to
/// the same side for all of them.
pub(crate) fn crossing(
    corners: [&Point3<f64>; 3],
    [a, b, along]: [usize; 3],
    point: &Point3<f64>,
) -> Option<RayCrossing> {
    let side = |p: &Point3<f64>, q: &Point3<f64>| {
        // Both triangles of an edge get the same number, whichever way they run along it.
        let forward = (p[a], p[b], p[along]) <= (q[a], q[b], q[along]);
        let (from, to) = if forward { (p, q) } else { (q, p) };
        let [du, dv] = [to[a] - from[a], to[b] - from[b]];
        // Cross product of the edge and the vector to the point. Zero means that the point is on the edge;
        // the direction of the edge then decides.
        let turn = du * (point[b] - from[b]) - dv * (point[a] - from[a]);
        let left = turn > 0.0 || (turn == 0.0 && (du > 0.0 || (du == 0.0 && dv < 0.0)));
        (if forward { turn } else { -turn }, left == forward)
    };
    let [p, q, r] = corners;
    let sides = [side(q, r), side(r, p), side(p, q)];
    // The point is in the triangle if it is on the same side of all three edges.
    let left = sides.iter().all(|(_, left)| *left);
    if !left && sides.iter().any(|(_, left)| *left) {
        return None;
    }
    // The cross products are barycentric weights, up to their sum.
    let total: f64 = sides.iter().map(|(weight, _)| weight).sum();
    let weighted: f64 = sides.iter().zip(corners).map(|((weight, _), p)| weight * p[along]).sum();
    // A triangle seen edge-on has no weights; any of its points serves, so take a corner.
    let s = if total == 0.0 { p[along] } else { weighted / total };
    Some(RayCrossing { s, winding: if left { -1 } else { 1 } })
}
