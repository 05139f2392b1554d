//! Stock from a box, a cylinder or a mesh.

use super::super::VerifyError;
use super::Stock;
use super::dexel::{Family, Lattice, Spans, across};
use crate::types::Mesh;
use nalgebra::{Point3, Vector3};

/// A solid, workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// A box parallel to the axes: lowest and highest corner \[mm\].
    Box {
        /// Lowest corner.
        low: Point3<f64>,
        /// Highest corner.
        high: Point3<f64>,
    },
    /// An upright cylinder \[mm\].
    Cylinder {
        /// Centre of the lower end.
        base: Point3<f64>,
        /// Radius.
        radius: f64,
        /// Height.
        height: f64,
    },
    /// What a closed mesh encloses.
    Mesh(Mesh),
}

impl Solid {
    /// Lowest and highest corner of its box; `None` for a mesh without a triangle.
    pub fn bounds(&self) -> Option<[Point3<f64>; 2]> {
        match self {
            Self::Box { low, high } => Some([*low, *high]),
            Self::Cylinder { base, radius, height } => {
                let side = Vector3::new(*radius, *radius, 0.0);
                Some([base - side, base + side + Vector3::z() * *height])
            }
            Self::Mesh(mesh) => {
                let corners = mesh.triangles.iter().flatten();
                let mut points = corners.filter_map(|&corner| mesh.vertices.get(corner as usize));
                let first = *points.next()?;
                Some(points.fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]))
            }
        }
    }
}

/// Rays are laid so that the outermost are half a cell inside the box.
pub(super) fn stock(solid: &Solid, cell: f64, most_rays: usize) -> Result<Stock, VerifyError> {
    if !(cell > 0.0 && cell.is_finite()) {
        let (name, must) = ("stock cell", "a length above 0");
        return Err(VerifyError::Option { name, value: cell, must });
    }
    let bounds = solid.bounds().filter(|[low, high]| {
        (0..3).all(|k| high[k] - low[k] > 0.0 && (high[k] - low[k]).is_finite())
    });
    let Some([low, high]) = bounds else {
        return Err(VerifyError::Stock { what: "has no volume".to_owned() });
    };
    let counts = [0, 1, 2].map(|k: usize| ((high[k] - low[k]) / cell).ceil().max(1.0));
    let rays = counts[0] * counts[1] + counts[1] * counts[2] + counts[2] * counts[0];
    if rays > most_rays as f64 {
        let what = format!("would have {rays:.0} rays, more than {most_rays}; use larger cells");
        return Err(VerifyError::Stock { what });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "fewer than rays")]
    let size = counts.map(|count| count as usize);
    let middle = nalgebra::center(&low, &high);
    let half = Vector3::from(counts) * (0.5 * cell) - Vector3::repeat(0.5 * cell);
    let lattice = Lattice { origin: middle - half, cell, size };
    let families = match solid {
        Solid::Mesh(mesh) => [0, 1, 2].map(|along| {
            let sorted = Sorted::new(mesh, along, &lattice);
            Family::new(&lattice, along, &|_, point| sorted.spans(point))
        }),
        plain => [0, 1, 2].map(|along| {
            Family::new(&lattice, along, &|along, point| plain_spans(plain, along, point))
        }),
    };
    Ok(Stock { lattice, families })
}

/// Material of a box or a cylinder along a ray.
fn plain_spans(solid: &Solid, along: usize, point: &Point3<f64>) -> Spans {
    let [a, b] = across(along);
    let span = match solid {
        Solid::Box { low, high } => {
            let within = |k: usize| (low[k]..=high[k]).contains(&point[k]);
            (within(a) && within(b)).then(|| [low[along], high[along]])
        }
        Solid::Cylinder { base, radius, height } if along == 2 => {
            let out = (point - base).xy().norm();
            (out < *radius).then(|| [base.z, base.z + height])
        }
        Solid::Cylinder { base, radius, height } => {
            let side = point[1 - along] - base[1 - along];
            let half = (radius * radius - side * side).max(0.0).sqrt();
            let within = (base.z..=base.z + height).contains(&point.z) && half > 0.0;
            within.then(|| [base[along] - half, base[along] + half])
        }
        Solid::Mesh(_) => None,
    };
    span.into_iter().collect()
}

/// Triangles by the rows of rays that may meet them.
struct Sorted<'a> {
    mesh: &'a Mesh,
    along: usize,
    /// By the first coordinate across.
    rows: Vec<Vec<u32>>,
    lattice: Lattice,
}

impl<'a> Sorted<'a> {
    fn new(mesh: &'a Mesh, along: usize, lattice: &Lattice) -> Self {
        let [a, _] = across(along);
        let mut rows = vec![Vec::new(); lattice.size[a]];
        for (index, triangle) in (0u32..).zip(&mesh.triangles) {
            let corners = triangle.iter().filter_map(|&c| mesh.vertices.get(c as usize));
            let [low, high] = corners.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
                [low.min(p[a]), high.max(p[a])]
            });
            let row = |x: f64| (x - lattice.origin[a]) / lattice.cell;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates"
            )]
            let (first, last) =
                (row(low).ceil().max(0.0) as usize, row(high).floor().max(-1.0) + 1.0);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates"
            )]
            let count = (last as usize).saturating_sub(first);
            rows.iter_mut().skip(first).take(count).for_each(|row| row.push(index));
        }
        Self { mesh, along, rows, lattice: *lattice }
    }

    /// Between crossings into the mesh and out of it.
    fn spans(&self, point: &Point3<f64>) -> Spans {
        let [a, b] = across(self.along);
        let row = ((point[a] - self.lattice.origin[a]) / self.lattice.cell).round().max(0.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let Some(row) = self.rows.get(row as usize) else { return Spans::new() };
        let mut crossings: Vec<(f64, i32)> = row
            .iter()
            .filter_map(|&index| {
                let triangle = self.mesh.triangles.get(index as usize)?;
                let [p, q, r] = triangle.map(|c| self.mesh.vertices.get(c as usize));
                crossing([p?, q?, r?], [a, b, self.along], point)
            })
            .collect();
        crossings.sort_by(|x, y| x.0.total_cmp(&y.0));
        let mut spans = Spans::new();
        let mut entered = None;
        let mut inside = 0;
        for (s, sense) in crossings {
            inside += sense;
            match (entered, inside > 0) {
                (None, true) => entered = Some(s),
                (Some(from), false) => {
                    if s > from {
                        spans.push([from, s]);
                    }
                    entered = None;
                }
                _ => {}
            }
        }
        spans
    }
}

/// Where a ray through `point` meets a triangle, and +1 where it goes in. A ray through an edge or a
/// corner counts for one of the triangles there: an edge is told by a strict sense on one side.
fn crossing(
    corners: [&Point3<f64>; 3],
    [a, b, along]: [usize; 3],
    point: &Point3<f64>,
) -> Option<(f64, i32)> {
    let side = |p: &Point3<f64>, q: &Point3<f64>| {
        // The same number for both triangles of an edge, whichever way they run through it.
        let (from, to, sign) = if (p[a], p[b], p[along]) <= (q[a], q[b], q[along]) {
            (p, q, 1.0)
        } else {
            (q, p, -1.0)
        };
        let [du, dv] = [to[a] - from[a], to[b] - from[b]];
        let turn = du * (point[b] - from[b]) - dv * (point[a] - from[a]);
        // On the line: as if the point lay a little aside.
        let turn = if turn == 0.0 {
            if du > 0.0 || (du == 0.0 && dv < 0.0) { 1.0 } else { -1.0 }
        } else {
            turn
        };
        sign * turn
    };
    let [p, q, r] = corners;
    let weights = [side(q, r), side(r, p), side(p, q)];
    let left = weights.iter().all(|&w| w > 0.0);
    let right = weights.iter().all(|&w| w < 0.0);
    if !left && !right {
        return None;
    }
    let total: f64 = weights.iter().sum();
    let s = (weights[0] * p[along] + weights[1] * q[along] + weights[2] * r[along]) / total;
    // Counter-clockwise seen against the ray's direction is an outer face looking along it: out.
    Some((s, if left { -1 } else { 1 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Mesh {
        let vertices = (0..8u32)
            .map(|k| Point3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
            .collect();
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh { vertices, triangles }
    }

    #[test]
    fn a_mesh_of_a_cube_is_a_box() {
        // 0.25: rays run exactly through no corner; 1/3: some run through the diagonals.
        for cell in [0.25, 1.0 / 3.0, 0.2] {
            let [low, high] = [Point3::origin(), Point3::new(1.0, 1.0, 1.0)];
            let plain = Stock::new(&Solid::Box { low, high }, cell, 1000).unwrap();
            let mesh = Stock::new(&Solid::Mesh(cube()), cell, 1000).unwrap();
            assert!((mesh.volume() - plain.volume()).abs() < 1e-12, "{cell}");
            assert!((plain.volume() - 1.0).abs() < 0.3);
        }
    }

    #[test]
    fn a_cylinder_has_its_volume() {
        let solid = Solid::Cylinder { base: Point3::new(1.0, 2.0, 3.0), radius: 5.0, height: 4.0 };
        let stock = Stock::new(&solid, 0.05, 1_000_000).unwrap();
        let exact = std::f64::consts::PI * 100.0;
        assert!((stock.volume() / exact - 1.0).abs() < 1e-3, "{} {exact}", stock.volume());
    }
}
