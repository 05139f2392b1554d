//! Triangles over a face, for pictures.

use super::error::SurfaceError;
use super::face::Face;
use crate::types::Interval;
use crate::types::{Mesh, Uv};
use nalgebra::UnitVector3;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Sampled lines by which the largest second derivatives are found.
const PROBES: u32 = 32;

/// Fewest and most cells by either parameter.
const CELLS: [f64; 2] = [8.0, 512.0];

/// Halvings that find a trim between two neighbouring grid points: far below a pixel.
const HALVINGS: u32 = 20;

/// Triangles over a face with the parameters and normals of their corners.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMesh {
    /// Triangles, counter-clockwise seen from the cutter's side.
    pub mesh: Mesh,
    /// Parameters of each vertex.
    pub uv: Vec<Uv>,
    /// Unit normal on the cutter's side at each vertex.
    pub normals: Vec<UnitVector3<f64>>,
}

impl Face {
    /// Returns triangles within about `chord` \[mm\] of the surface: a grid in u and v as fine as
    /// the sampled second derivatives ask, cut at the trims (marching squares). Trim details
    /// smaller than a cell may be lost; at most 512 cells a parameter.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::{Point3, Vector3};
    /// use trunnion_geometry::surface::{Face, SphereSurface, Surface, SurfaceFrame};
    ///
    /// let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x())?;
    /// let sphere = Surface::Sphere(SphereSurface::new(frame, 10.0)?);
    /// let mesh = Face::new(1, sphere, vec![])?.tessellate(0.1)?.mesh;
    /// assert!(mesh.vertices.iter().all(|p| (p.coords.norm() - 10.0).abs() < 1e-9));
    /// # Ok::<(), trunnion_geometry::surface::SurfaceError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] unless `chord` is positive.
    pub fn tessellate(&self, chord: f64) -> Result<FaceMesh, SurfaceError> {
        if !(chord > 0.0 && chord.is_finite()) {
            let need = "finite and above 0";
            return Err(SurfaceError::Size { what: "chord tolerance", value: chord, need });
        }
        Ok(FaceTessellation::new(self, chord).run())
    }
}

/// Work in progress.
struct FaceTessellation<'a> {
    face: &'a Face,
    bounds: [Interval; 2],
    cells: [u32; 2],
    inside: Vec<bool>,
    /// Indices of the vertices made so far.
    known: BTreeMap<VertexKey, u32>,
    out: FaceMesh,
}

/// Column and row of a point of the grid in u and v.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct GridPoint {
    i: u32,
    j: u32,
}

/// Place of a vertex: by this, neighbouring cells find the vertex they share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum VertexKey {
    /// At a point of the grid.
    Corner(GridPoint),
    /// At the cut of a trim through the edge along u that starts at the point.
    CutAlongU(GridPoint),
    /// At the cut of a trim through the edge along v that starts at the point.
    CutAlongV(GridPoint),
}

/// Returns the numbers of cells for which neither the bend of a cell's edges nor its twist exceed
/// half of `chord`: a parabola leaves its chord by `|S_uu| du^2 / 8`, a twisted cell its diagonal
/// by `|S_uv| du dv / 4`.
fn cells(face: &Face, [u, v]: [Interval; 2], chord: f64) -> [u32; 2] {
    let mut bend = [0.0_f64; 3];
    for i in 0..=PROBES {
        for j in 0..=PROBES {
            let at = |k: u32, Interval { low, high }: Interval| {
                low + (high - low) * f64::from(k) / f64::from(PROBES)
            };
            let jet = face.surface.jet2(at(i, u), at(j, v));
            // Only the normal part of a second derivative takes the surface off its chords.
            let Some(n) = jet.normal() else { continue };
            for (bend, d) in bend.iter_mut().zip([jet.suu, jet.suv, jet.svv]) {
                *bend = bend.max(d.dot(&n).abs());
            }
        }
    }
    let (width, height) = (u.high - u.low, v.high - v.low);
    // |S_uu| du^2 / 8 = chord / 2 gives du = sqrt(4 chord / |S_uu|).
    let count = |bend: f64, width: f64| (width * (bend / (4.0 * chord)).sqrt()).ceil();
    let mut counts = [count(bend[0], width), count(bend[2], height)];
    // |S_uv| du dv / 4 over chord / 2. Where it exceeds 1, both directions take the root of it.
    let twist = bend[1] * width * height / (2.0 * chord * counts[0].max(1.0) * counts[1].max(1.0));
    counts = counts.map(|n| n.max(1.0) * twist.max(1.0).sqrt());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    counts.map(|n| n.clamp(CELLS[0], CELLS[1]).ceil() as u32)
}

impl<'a> FaceTessellation<'a> {
    fn new(face: &'a Face, chord: f64) -> Self {
        let bounds = face.bounds();
        let cells = cells(face, bounds, chord);
        let mesh = FaceMesh { mesh: Mesh::default(), uv: Vec::new(), normals: Vec::new() };
        let (inside, known) = (Vec::new(), BTreeMap::new());
        let mut work = Self { face, bounds, cells, inside, known, out: mesh };
        for i in 0..=cells[0] {
            for j in 0..=cells[1] {
                let [u, v] = work.at(GridPoint { i, j });
                work.inside.push(face.contains(u, v));
            }
        }
        work
    }

    fn run(mut self) -> FaceMesh {
        for i in 0..self.cells[0] {
            for j in 0..self.cells[1] {
                for polygon in self.polygons(i, j) {
                    self.fan(&polygon);
                }
            }
        }
        self.out
    }

    /// Returns the parameters of a grid point.
    fn at(&self, point: GridPoint) -> [f64; 2] {
        let along = |k: usize, n: u32| {
            let Interval { low, high } = self.bounds[k];
            // The last line is the bound itself: a sum could be rounded to beyond the trims.
            if n == self.cells[k] {
                high
            } else {
                low + (high - low) * f64::from(n) / f64::from(self.cells[k])
            }
        };
        [along(0, point.i), along(1, point.j)]
    }

    fn is_inside(&self, point: GridPoint) -> bool {
        let at = point.i as usize * (self.cells[1] as usize + 1) + point.j as usize;
        self.inside.get(at).copied().unwrap_or(false)
    }

    /// Returns the part of a cell inside the trims, counter-clockwise in u, v; two parts where
    /// opposite corners are inside and the middle is not.
    fn polygons(&mut self, i: u32, j: u32) -> Vec<Vec<u32>> {
        let corners =
            [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| GridPoint { i, j });
        let inside = corners.map(|corner| self.is_inside(corner));
        if inside == [false; 4] {
            return Vec::new();
        }
        // Marching squares: inside corners, and cuts between unlike neighbours, in order round the
        // cell.
        let mut polygon = Vec::new();
        for k in 0..4 {
            let next = (k + 1) % 4;
            if inside[k] {
                polygon.push(self.corner(corners[k]));
            }
            if inside[k] != inside[next] {
                polygon.push(self.cut(corners[k], corners[next]));
            }
        }
        let opposite = inside[0] == inside[2] && inside[1] == inside[3] && inside[0] != inside[1];
        // The ambiguous case: the middle of the cell decides if the inside corners are connected.
        if opposite {
            let [a, b] = [self.at(corners[0]), self.at(corners[2])];
            if !self.face.contains(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])) {
                // Around each inside corner: the cut before it, the corner, the cut after it.
                if inside[0] {
                    polygon.rotate_right(1);
                }
                let second = polygon.split_off(3);
                return vec![polygon, second];
            }
        }
        vec![polygon]
    }

    fn corner(&mut self, point: GridPoint) -> u32 {
        let uv = self.at(point);
        self.vertex(VertexKey::Corner(point), uv)
    }

    /// Returns the vertex where a trim crosses the edge between an inside and an outside grid
    /// point.
    fn cut(&mut self, a: GridPoint, b: GridPoint) -> u32 {
        // Named by its lower grid point, an edge gives both cells beside it the same vertex.
        let first = a.min(b);
        let key =
            if a.i == b.i { VertexKey::CutAlongV(first) } else { VertexKey::CutAlongU(first) };
        let (mut inner, mut outer) =
            if self.is_inside(a) { (self.at(a), self.at(b)) } else { (self.at(b), self.at(a)) };
        if !self.known.contains_key(&key) {
            // Bisection; its inner end is taken, so that no vertex lies outside the trims.
            for _ in 0..HALVINGS {
                let middle = [0.5 * (inner[0] + outer[0]), 0.5 * (inner[1] + outer[1])];
                if self.face.contains(middle[0], middle[1]) {
                    inner = middle;
                } else {
                    outer = middle;
                }
            }
        }
        self.vertex(key, inner)
    }

    fn vertex(&mut self, key: VertexKey, uv: [f64; 2]) -> u32 {
        if let Some(&index) = self.known.get(&key) {
            return index;
        }
        let index = u32::try_from(self.out.uv.len()).unwrap_or(u32::MAX);
        self.out.mesh.vertices.push(self.face.point(uv[0], uv[1]));
        self.out.uv.push(uv.into());
        // At a singular point without a limit; vertices and normals have to stay in step.
        let fallback = Vector3::z_axis();
        self.out.normals.push(self.face.normal(uv[0], uv[1]).unwrap_or(fallback));
        self.known.insert(key, index);
        index
    }

    /// Adds the triangles of a convex polygon, turned round if the cutter is on the other side.
    fn fan(&mut self, polygon: &[u32]) {
        let [first, rest @ ..] = polygon else { return };
        for pair in rest.windows(2) {
            let [a, b] = if self.face.flip { [pair[1], pair[0]] } else { [pair[0], pair[1]] };
            self.out.mesh.triangles.push([*first, a, b]);
        }
    }
}
