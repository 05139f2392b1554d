//! Reduction of points for a picture, without losing the worst.

use crate::data::{Budget, PathPiece, Surface};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Reduces a path to about `most` points; the ends of pieces stay.
pub(crate) fn thinned_path(path: &[PathPiece], most: usize) -> Cow<'_, [PathPiece]> {
    let total: usize = path.iter().map(|piece| piece.points.len()).sum();
    let stride = total.div_ceil(most.max(1)).max(1);
    if stride == 1 {
        return Cow::Borrowed(path);
    }
    let thin = |piece: &PathPiece| {
        let last = piece.points.len().saturating_sub(1);
        let kept =
            piece.points.iter().enumerate().filter(|(at, _)| at % stride == 0 || *at == last);
        PathPiece { points: kept.map(|(_, point)| *point).collect(), ..*piece }
    };
    Cow::Owned(path.iter().map(thin).collect())
}

/// Reduces a surface to at most `most` vertices: of each cell of a cubic grid, the vertex with the
/// worst deviation stays, at its measured position. Triangles follow their corners.
pub(crate) fn thinned_surface<'s>(
    full: &'s Surface,
    budget: &Budget,
    most: usize,
) -> Cow<'s, Surface> {
    if full.vertices.len() <= most {
        return Cow::Borrowed(full);
    }
    // Area over `most`, a little coarser at every attempt: the number of cells falls as 1/size².
    let mut size = (area(full) / most.max(1) as f64).sqrt().max(f64::MIN_POSITIVE);
    loop {
        let thin = clustered(full, budget, size);
        if thin.vertices.len() <= most {
            return Cow::Owned(thin);
        }
        size *= 1.25;
    }
}

fn area(surface: &Surface) -> f64 {
    let corner = |index: u32| surface.vertices.get(index as usize).copied().unwrap_or_default();
    let of = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(corner);
        let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        let cross =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        0.5 * cross.iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    surface.triangles.iter().map(of).sum()
}

fn clustered(full: &Surface, budget: &Budget, size: f64) -> Surface {
    #[expect(clippy::cast_possible_truncation, reason = "the cast saturates")]
    let cell = |vertex: &[f64; 3]| vertex.map(|value| (value / size).floor() as i64);
    let mut number: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let mut kept: Vec<usize> = Vec::new();
    let mut of_vertex: Vec<u32> = Vec::with_capacity(full.vertices.len());
    let severity = |at: usize| full.deviation.get(at).map_or(0.0, |d| severity(*d, budget));
    for (at, vertex) in full.vertices.iter().enumerate() {
        let next = u32::try_from(kept.len()).unwrap_or(u32::MAX);
        let cluster = *number.entry(cell(vertex)).or_insert(next);
        match kept.get_mut(cluster as usize) {
            Some(best) if severity(at) > severity(*best) => *best = at,
            Some(_) => {}
            None => kept.push(at),
        }
        of_vertex.push(cluster);
    }
    let follow = |corner: u32| of_vertex.get(corner as usize).copied();
    let triangles = full.triangles.iter().filter_map(|&[a, b, c]| {
        let [a, b, c] = [follow(a)?, follow(b)?, follow(c)?];
        // A triangle with two corners in one cell has collapsed.
        (a != b && b != c && c != a).then_some([a, b, c])
    });
    Surface {
        triangles: triangles.collect(),
        vertices: kept.iter().filter_map(|&at| full.vertices.get(at).copied()).collect(),
        deviation: kept.iter().filter_map(|&at| full.deviation.get(at).copied()).collect(),
    }
}

/// Returns a deviation as a fraction of its tolerance; an uncut point is the worst.
fn severity(deviation: Option<f64>, budget: &Budget) -> f64 {
    match deviation {
        None => f64::INFINITY,
        Some(d) if d < 0.0 => -d / budget.gouge.max(f64::MIN_POSITIVE),
        Some(d) => d / budget.total.max(f64::MIN_POSITIVE),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::SurfacePoint;

    #[test]
    fn thinning_keeps_the_deepest_gouge_and_the_bound() {
        let mut full = Surface::default();
        let columns = 60;
        let points: Vec<_> = (0..columns * columns)
            .map(|at| {
                let [x, y] = [at % columns, at / columns].map(|n| n as f64 * 0.1);
                let deviation = Some(if at == 1234 { -0.5 } else { 0.001 });
                Some(SurfacePoint { position: [x, y, 0.0], deviation })
            })
            .collect();
        full.add_grid(columns, &points);
        let budget = Budget { total: 0.02, gouge: 0.002, shares: Vec::new() };
        let thin = thinned_surface(&full, &budget, 400);
        assert!(thin.vertices.len() <= 400 && thin.vertices.len() > 100);
        assert!(thin.deviation.contains(&Some(-0.5)));
        let corners = thin.triangles.iter().flatten();
        assert!(corners.clone().count() > 300);
        assert!(corners.copied().all(|corner| (corner as usize) < thin.vertices.len()));
    }
}
