//! Fills the rays of stock from a box, a cylinder or a mesh.

use super::solid::Solid;
use crate::types::Mesh;
use crate::verify::error::VerifyError;
use crate::verify::stock::dexel::{DexelGrid, RayFamily, RaySpans, across};
use crate::verify::stock::material::Stock;
use crate::verify::swept::crossing::{RayCrossing, crossing};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::sync::Arc;

impl Stock {
    /// Fills a solid with rays at most `cell` \[mm\] apart, which divide its box evenly.
    ///
    /// # Errors
    ///
    /// [`VerifyError::Option`] for a cell that is no length, [`VerifyError::Stock`] for a solid without
    /// volume, a mesh that is not closed, or more than `most_rays` rays.
    pub fn new(solid: &Solid, cell: f64, most_rays: usize) -> Result<Self, VerifyError> {
        stock(solid, cell, most_rays)
    }
}

fn stock(solid: &Solid, cell: f64, most_rays: usize) -> Result<Stock, VerifyError> {
    if !(cell > 0.0 && cell.is_finite()) {
        let (name, must) = ("stock cell", "a length above 0");
        return Err(VerifyError::Option { name, value: cell, must });
    }
    let lattice = lattice(solid, cell, most_rays)?;
    let families = match solid {
        Solid::Mesh(mesh) => {
            check_corners(mesh)?;
            let [x, y, z] = [0, 1, 2].map(|along| of_mesh(mesh, along, &lattice));
            [x?, y?, z?]
        }
        plain => [0, 1, 2].map(|along| {
            let [a, b] = across(along).map(|axis| lattice.size[axis]);
            let of = |i, j| plain_spans(plain, along, &lattice.ray(along, [i, j]));
            let row = |i| (0..b).map(|j| of(i, j)).collect();
            RayFamily::new(&lattice, along, (0..a).into_par_iter().map(row).collect())
        }),
    };
    Ok(Stock { lattice, families, uncut: Some(Arc::new(solid.clone())) })
}

fn lattice(solid: &Solid, cell: f64, most_rays: usize) -> Result<DexelGrid, VerifyError> {
    let bounds = solid.bounds().filter(|[low, high]| {
        (0..3).all(|k| high[k] - low[k] > 0.0 && (high[k] - low[k]).is_finite())
    });
    let Some([low, high]) = bounds else {
        return Err(VerifyError::Stock { what: "has no volume".to_owned() });
    };
    // A length that is a whole number of cells except for rounding gets that number.
    let cells = |length: f64| (length / cell * (1.0 - 8.0 * f64::EPSILON)).ceil().max(1.0);
    let counts = [0, 1, 2].map(|k: usize| cells(high[k] - low[k]));
    let rays = counts[0] * counts[1] + counts[1] * counts[2] + counts[2] * counts[0];
    if rays > most_rays as f64 {
        let what = format!("would have {rays:.0} rays, more than {most_rays}; use larger cells");
        return Err(VerifyError::Stock { what });
    }
    let cell = [0, 1, 2].map(|k: usize| (high[k] - low[k]) / counts[k]);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "fewer than rays")]
    let size = counts.map(|count| count as usize);
    Ok(DexelGrid { origin: low + Vector3::from(cell) * 0.5, cell, size })
}

/// Returns the material of a box or a cylinder along a ray.
fn plain_spans(solid: &Solid, along: usize, point: &Point3<f64>) -> RaySpans {
    let [a, b] = across(along);
    let mut spans = RaySpans::NONE;
    match solid {
        Solid::Box { low, high } => {
            // A ray meets the box if it is within both intervals across it.
            let within = |k: usize| (low[k]..=high[k]).contains(&point[k]);
            if within(a) && within(b) {
                spans.push([low[along], high[along]]);
            }
        }
        Solid::Cylinder { base, radius, height } if along == 2 => {
            // Along the axis: inside the circle the ray runs from end to end.
            if (point - base).xy().norm() < *radius {
                spans.push([base.z, base.z + height]);
            }
        }
        Solid::Cylinder { base, radius, height } => {
            let side = point[1 - along] - base[1 - along];
            // Half the chord of the circle at the distance of the ray from the axis.
            let half = (radius * radius - side * side).max(0.0).sqrt();
            if (base.z..=base.z + height).contains(&point.z) {
                spans.push([base[along] - half, base[along] + half]);
            }
        }
        Solid::Mesh(_) => {}
    }
    spans
}

fn check_corners(mesh: &Mesh) -> Result<(), VerifyError> {
    let missing = |corner: &u32| mesh.vertices.len() <= *corner as usize;
    if mesh.triangles.iter().flatten().any(missing) {
        return Err(VerifyError::Stock { what: "has a triangle without a corner".to_owned() });
    }
    Ok(())
}

/// Fills the rays of a mesh.
fn of_mesh(mesh: &Mesh, along: usize, lattice: &DexelGrid) -> Result<RayFamily, VerifyError> {
    let rows = TriangleRows::new(mesh, along, lattice);
    let all = |inside: fn(i32, usize) -> bool| -> (Vec<_>, Vec<_>) {
        (0..rows.triangles.len()).into_par_iter().map(|i| rows.spans(i, inside)).unzip()
    };
    let (mut spans, mut lost) = all(|wound, _| wound != 0);
    // If triangles are not oriented alike, the inside is behind an odd number of them.
    if lost.iter().any(Option::is_some) {
        (spans, lost) = all(|_, count| count % 2 == 1);
    }
    if let Some([i, j]) = lost.iter().enumerate().find_map(|(i, lost)| lost.map(|j| [i, j])) {
        let point = lattice.ray(along, [i, j]);
        let words = ["X", "Y", "Z"].iter().zip(point.iter()).enumerate();
        let words: Vec<String> = words
            .filter(|(axis, _)| *axis != along)
            .map(|(_, (name, value))| format!("{name} {value:.3}"))
            .collect();
        let what = format!(
            "is not closed: the ray through {} goes in and does not come out; heal it in the CAD \
             system and export it again",
            words.join(" ")
        );
        return Err(VerifyError::Stock { what });
    }
    Ok(RayFamily::new(lattice, along, spans))
}

/// Triangles by the rows of rays that may meet them.
struct TriangleRows<'a> {
    mesh: &'a Mesh,
    along: usize,
    /// Triangle numbers by the first coordinate across.
    triangles: Vec<Vec<u32>>,
    lattice: DexelGrid,
}

impl<'a> TriangleRows<'a> {
    fn new(mesh: &'a Mesh, along: usize, lattice: &DexelGrid) -> Self {
        let [a, _] = across(along);
        let mut triangles = vec![Vec::new(); lattice.size[a]];
        for (index, triangle) in (0u32..).zip(&mesh.triangles) {
            let [first, count] = lattice.nodes(a, extent(mesh, triangle, a));
            triangles.iter_mut().skip(first).take(count).for_each(|row| row.push(index));
        }
        Self { mesh, along, triangles, lattice: *lattice }
    }

    /// Returns the material of all rays of a row, and the number of a ray that ends inside, if any.
    ///
    /// `inside` decides by the winding number and by the number of crossings.
    fn spans(&self, row: usize, inside: fn(i32, usize) -> bool) -> (Vec<RaySpans>, Option<usize>) {
        let [a, b] = across(self.along);
        let count = self.lattice.size[b];
        let mut crossings: Vec<Vec<RayCrossing>> = vec![Vec::new(); count];
        for &index in self.triangles.get(row).into_iter().flatten() {
            let Some(triangle) = self.mesh.triangles.get(index as usize) else { continue };
            let [first, number] = self.lattice.nodes(b, extent(self.mesh, triangle, b));
            let [p, q, r] = triangle.map(|c| self.mesh.vertices.get(c as usize));
            let (Some(p), Some(q), Some(r)) = (p, q, r) else { continue };
            for (j, list) in crossings.iter_mut().enumerate().skip(first).take(number) {
                let ray = self.lattice.ray(self.along, [row, j]);
                list.extend(crossing([p, q, r], [a, b, self.along], &ray));
            }
        }
        // A ray that is still inside after its last crossing shows that the mesh is open.
        let ends = |all: &Vec<RayCrossing>| {
            inside(all.iter().map(|crossing| crossing.winding).sum(), all.len())
        };
        let lost = crossings.iter().position(ends);
        (crossings.into_iter().map(|all| enclosed(all, inside)).collect(), lost)
    }
}

fn extent(mesh: &Mesh, triangle: &[u32; 3], axis: usize) -> [f64; 2] {
    let corners = triangle.iter().filter_map(|&c| mesh.vertices.get(c as usize));
    corners.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
        [low.min(p[axis]), high.max(p[axis])]
    })
}

/// Returns the intervals that are inside after the crossings before them.
fn enclosed(mut crossings: Vec<RayCrossing>, inside: fn(i32, usize) -> bool) -> RaySpans {
    crossings.sort_by(|x, y| x.s.total_cmp(&y.s));
    let mut spans = RaySpans::NONE;
    let mut entered = None;
    let mut wound = 0;
    for (before, RayCrossing { s, winding }) in crossings.into_iter().enumerate() {
        // The state after each crossing decides if the interval up to the next one is material.
        wound += winding;
        match (entered, inside(wound, before + 1)) {
            (None, true) => entered = Some(s),
            (Some(from), false) => {
                spans.push([from, s]);
                entered = None;
            }
            _ => {}
        }
    }
    spans
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

    /// An octahedron, radius 1: rays run through its corners and edges.
    fn octahedron() -> Mesh {
        let vertices = (0..6)
            .map(|k| {
                let mut p = Point3::origin();
                p[k % 3] = if k < 3 { 1.0 } else { -1.0 };
                p
            })
            .collect();
        let mut triangles = Vec::new();
        for k in 0..8u32 {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(|sign| 3 * sign);
            let even = (k.count_ones() % 2) == 0;
            triangles.push(if even { [x, 1 + y, 2 + z] } else { [1 + y, x, 2 + z] });
        }
        Mesh { vertices, triangles }
    }

    #[test]
    fn a_mesh_of_a_cube_is_a_box() {
        // 0.25: rays run exactly through no corner; 1/3: some run through the diagonals.
        for cell in [0.25, 1.0 / 3.0, 0.2] {
            let [low, high] = [Point3::origin(), Point3::new(1.0, 1.0, 1.0)];
            let plain = Stock::new(&Solid::Box { low, high }, cell, 1000).unwrap();
            let mesh = Stock::new(&Solid::Mesh(cube()), cell, 1000).unwrap();
            assert_eq!(mesh.families, plain.families, "{cell}");
            assert!((plain.volume() - 1.0).abs() < 1e-12, "{cell}: {}", plain.volume());
        }
    }

    #[test]
    fn rays_through_corners_and_edges_cross_once() {
        // An odd number of cells: the middle rays run through corners, those of two rows along edges.
        let mesh = octahedron();
        for cells in [9.0, 10.0, 101.0] {
            let stock = Stock::new(&Solid::Mesh(mesh.clone()), 2.0 / cells, 100_000).unwrap();
            let error = stock.volume() / (4.0 / 3.0) - 1.0;
            assert!(error.abs() < 5.1 / (cells * cells), "{cells}: {error}");
            for family in &stock.families {
                let spans =
                    family.tiles.iter().flat_map(|tile| &tile.rays).flat_map(RaySpans::iter);
                for [low, high] in spans {
                    assert!((low + high).abs() < 1e-12, "{low} {high}");
                }
            }
        }
    }

    #[test]
    fn which_way_triangles_turn_does_not_matter_but_a_hole_does() {
        let mut mesh = octahedron();
        let plain = Stock::new(&Solid::Mesh(mesh.clone()), 0.1, 10_000).unwrap();
        for triangle in &mut mesh.triangles {
            triangle.swap(0, 1);
        }
        let other = Stock::new(&Solid::Mesh(mesh.clone()), 0.1, 10_000).unwrap();
        assert_eq!(other.families, plain.families);
        for triangle in mesh.triangles.iter_mut().step_by(3) {
            triangle.swap(0, 1);
        }
        let other = Stock::new(&Solid::Mesh(mesh.clone()), 0.1, 10_000).unwrap();
        assert_eq!(other.families, plain.families);
        mesh.triangles.pop();
        let error = Stock::new(&Solid::Mesh(mesh), 0.1, 10_000).unwrap_err().to_string();
        assert!(error.contains("not closed"), "{error}");
    }

    #[test]
    fn a_cylinder_has_its_volume() {
        let solid = Solid::Cylinder { base: Point3::new(1.0, 2.0, 3.0), radius: 5.0, height: 4.0 };
        let stock = Stock::new(&solid, 0.05, 1_000_000).unwrap();
        let exact = std::f64::consts::PI * 100.0;
        assert!((stock.volume() / exact - 1.0).abs() < 1e-3, "{} {exact}", stock.volume());
    }
}
