//! Control nets: their faults, and their Bezier patches.

use crate::math::bspline::KnotVector;
use crate::surface::error::SurfaceError;
use nalgebra::Point3;
use nalgebra::Rotation3;
use nalgebra::Vector4;

/// Lists the faults of the net's shape and numbers.
pub(super) fn net_faults(
    points: &[Vec<Point3<f64>>],
    weights: Option<&[Vec<f64>]>,
) -> Vec<SurfaceError> {
    let columns = points.first().map_or(0, Vec::len);
    let mut faults = Vec::new();
    for (row, line) in points.iter().enumerate() {
        if line.len() != columns {
            let (found, expected) = (line.len(), columns);
            faults.push(SurfaceError::RowLength { what: "points", row, found, expected });
        }
        for (j, point) in line.iter().enumerate() {
            for (axis, value) in point.iter().enumerate().filter(|(_, value)| !value.is_finite()) {
                let what = format!("points[{row}][{j}][{axis}]");
                faults.push(SurfaceError::NotFinite { what, value: *value });
            }
        }
    }
    if let Some(weights) = weights {
        faults.extend(weight_faults(points, weights));
    }
    faults
}

fn weight_faults(points: &[Vec<Point3<f64>>], weights: &[Vec<f64>]) -> Vec<SurfaceError> {
    let mut faults = Vec::new();
    for row in 0..points.len().max(weights.len()) {
        let found = weights.get(row).map_or(0, Vec::len);
        let expected = points.get(row).map_or(0, Vec::len);
        if found != expected {
            faults.push(SurfaceError::RowLength { what: "weights", row, found, expected });
        }
    }
    for (i, row) in weights.iter().enumerate() {
        for (j, &value) in row.iter().enumerate() {
            let place = format!("weights[{i}][{j}]");
            if !value.is_finite() {
                faults.push(SurfaceError::NotFinite { what: place, value });
            } else if value <= 0.0 {
                faults.push(SurfaceError::Weight { place, value });
            }
        }
    }
    faults
}

pub(super) fn all_equal(mut values: impl Iterator<Item = f64>) -> bool {
    let first = values.next();
    values.all(|value| Some(value) == first)
}

pub(super) fn homogeneous(
    points: &[Vec<Point3<f64>>],
    weights: Option<&[Vec<f64>]>,
) -> Vec<Vec<Vector4<f64>>> {
    let weight =
        |i: usize, j: usize| weights.and_then(|rows| rows.get(i)?.get(j)).copied().unwrap_or(1.0);
    // (w x, w y, w z, w): blending these is blending points by weight.
    let row = |(i, line): (usize, &Vec<Point3<f64>>)| {
        let lift = |(j, point): (usize, &Point3<f64>)| {
            let w = weight(i, j);
            (point.coords * w).push(w)
        };
        line.iter().enumerate().map(lift).collect()
    };
    points.iter().enumerate().map(row).collect()
}

/// Turns control points `(w x, w y, w z, w)` about the origin of space.
pub(in super::super) fn turn_net(net: &mut [Vector4<f64>], rotation: &Rotation3<f64>) {
    for point in net {
        *point = (rotation * point.xyz()).push(point.w);
    }
}

/// Converts a net to Bezier patches: along v every row, then along u every column of the result.
pub(super) fn bezier_patches(
    knots: &[&KnotVector; 2],
    net: &[Vec<Vector4<f64>>],
) -> Vec<Vector4<f64>> {
    let [u, v] = knots;
    // Knot insertion by one parameter does not depend on the other: rows first, then columns.
    let rows: Vec<Vec<Vector4<f64>>> = net.iter().map(|row| v.bezier(row)).collect();
    let across = rows.first().map_or(0, Vec::len);
    let columns: Vec<Vec<Vector4<f64>>> =
        (0..across).map(|j| u.bezier(&rows.iter().map(|row| row[j]).collect::<Vec<_>>())).collect();
    let [p, q] = [u.degree() + 1, v.degree() + 1];
    // All points of a patch side by side, so that evaluation reads one block of memory.
    let mut patches = Vec::with_capacity(columns.iter().map(Vec::len).sum());
    for i in 0..u.breaks().len() - 1 {
        for j in 0..v.breaks().len() - 1 {
            for k in 0..p {
                patches.extend((0..q).map(|l| columns[j * q + l][i * p + k]));
            }
        }
    }
    patches
}

/// Returns the diagonal of the box of the Cartesian control points.
pub(super) fn net_size(points: &[Vector4<f64>]) -> f64 {
    let cartesian = || points.iter().map(|point| point.xyz() / point.w);
    let low = cartesian().reduce(|a, b| a.inf(&b));
    let high = cartesian().reduce(|a, b| a.sup(&b));
    low.zip(high).map_or(0.0, |(low, high)| (high - low).norm())
}
