//! Triangles over a face, for pictures.

use super::error::SurfaceError;
use super::face::Face;
use super::trim::TrimLoop;
use super::trimmed_grid::TrimmedGrid;
use crate::types::Interval;
use crate::types::{Mesh, Uv};
use nalgebra::UnitVector3;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Sampled lines by which the largest second derivatives are found.
const PROBES: u32 = 32;

/// Fewest and most cells by either parameter.
const CELLS: [f64; 2] = [8.0, 512.0];

/// Share of the chord tolerance by which the chords of trims may leave them.
const TRIM_SHARE: f64 = 0.25;

/// Triangles over a face with the parameters and normals of their corners.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMesh {
    /// Triangles, counter-clockwise seen from the cutter's side.
    pub mesh: Mesh,
    /// Parameters of each vertex.
    pub uv: Vec<Uv>,
    /// Unit normal on the cutter's side at each vertex.
    pub normals: Vec<UnitVector3<f64>>,
    /// Largest distance by u and by v between the trims and the chords that stand for them.
    pub trim_deviation: [f64; 2],
}

impl Face {
    /// Returns triangles within about `chord` \[mm\] of the surface: a grid in u and v as fine as
    /// the sampled second derivatives ask, at most 512 cells a parameter, cut along chords of the
    /// trims. Triangles that are neighbours share their edge.
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

/// Largest sampled derivatives of a face.
#[derive(Debug, Default)]
struct Derivatives {
    /// Lengths of the first derivatives, by u and by v \[mm\].
    first: [f64; 2],
    /// Normal parts of the second ones: `uu`, `uv`, `vv` \[mm\].
    second: [f64; 3],
}

impl Derivatives {
    fn of(face: &Face, [u, v]: [Interval; 2]) -> Self {
        let mut largest = Self::default();
        for i in 0..=PROBES {
            for j in 0..=PROBES {
                let at = |k: u32, Interval { low, high }: Interval| {
                    low + (high - low) * f64::from(k) / f64::from(PROBES)
                };
                let jet = face.surface.jet2(at(i, u), at(j, v));
                for (first, d) in largest.first.iter_mut().zip([jet.su, jet.sv]) {
                    *first = first.max(d.norm());
                }
                // Only the normal part of a second derivative takes the surface off its chords.
                let Some(n) = jet.normal() else { continue };
                for (second, d) in largest.second.iter_mut().zip([jet.suu, jet.suv, jet.svv]) {
                    *second = second.max(d.dot(&n).abs());
                }
            }
        }
        largest
    }

    /// Returns the numbers of cells for which neither the bend of a cell's edges nor its twist
    /// exceed half of `chord`: a parabola leaves its chord by `|S_uu| du^2 / 8`, a twisted cell its
    /// diagonal by `|S_uv| du dv / 4`.
    fn cells(&self, [u, v]: [Interval; 2], chord: f64) -> [u32; 2] {
        let (width, height) = (u.width(), v.width());
        // |S_uu| du^2 / 8 = chord / 2 gives du = sqrt(4 chord / |S_uu|).
        let count = |bend: f64, width: f64| (width * (bend / (4.0 * chord)).sqrt()).ceil();
        let [uu, uv, vv] = self.second;
        let mut counts = [count(uu, width), count(vv, height)];
        // |S_uv| du dv / 4 over chord / 2. Where it exceeds 1, both directions take the root of it.
        let twist = uv * width * height / (2.0 * chord * counts[0].max(1.0) * counts[1].max(1.0));
        counts = counts.map(|n| n.max(1.0) * twist.max(1.0).sqrt());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        counts.map(|n| n.clamp(CELLS[0], CELLS[1]).ceil() as u32)
    }

    /// Returns the steps by u and by v that together move a point by at most `distance` \[mm\].
    fn steps(&self, bounds: [Interval; 2], distance: f64) -> [f64; 2] {
        // Where nothing moves, any step within the bounds does.
        [0, 1].map(|k| (0.5 * distance / self.first[k]).min(bounds[k].width()))
    }
}

/// Order of parameters by their bits, for sets of vertices.
type Key = u64;

/// Returns a key that rises with the number.
fn key(x: f64) -> Key {
    // Equal numbers have equal bits but for the zeros; negative numbers fall with their bits.
    let bits = (x + 0.0).to_bits();
    if bits >> 63 == 0 { bits | (1 << 63) } else { !bits }
}

/// Triangles of the polygons into which the trims cut the cells.
struct FaceTessellation<'a> {
    face: &'a Face,
    grid: TrimmedGrid<'a>,
    polygons: Vec<Vec<[f64; 2]>>,
    /// Corners of all polygons on each line of equal u, and on each row line.
    on_columns: BTreeMap<Key, BTreeSet<Key>>,
    on_rows: BTreeMap<Key, BTreeSet<Key>>,
    /// Indices of the vertices made so far.
    known: BTreeMap<[Key; 2], u32>,
    out: FaceMesh,
}

impl<'a> FaceTessellation<'a> {
    fn new(face: &'a Face, chord: f64) -> Self {
        let bounds = face.bounds();
        let derivatives = Derivatives::of(face, bounds);
        let tolerance = derivatives.steps(bounds, TRIM_SHARE * chord);
        let grid = TrimmedGrid::new(face, derivatives.cells(bounds, chord), tolerance);
        let straight = face.loops.iter().all(TrimLoop::is_polygon);
        let out = FaceMesh {
            mesh: Mesh::default(),
            uv: Vec::new(),
            normals: Vec::new(),
            trim_deviation: if straight { [0.0; 2] } else { tolerance },
        };
        let mut work = Self {
            face,
            polygons: grid.cells().flat_map(|cell| grid.parts(cell)).collect(),
            grid,
            on_columns: BTreeMap::new(),
            on_rows: BTreeMap::new(),
            known: BTreeMap::new(),
            out,
        };
        work.enter_corners();
        work
    }

    fn enter_corners(&mut self) {
        for &[u, v] in self.polygons.iter().flatten() {
            self.on_columns.entry(key(u)).or_default().insert(key(v));
            if self.grid.is_row_line(v) {
                self.on_rows.entry(key(v)).or_default().insert(key(u));
            }
        }
    }

    fn run(mut self) -> FaceMesh {
        for polygon in std::mem::take(&mut self.polygons) {
            let outline = self.outline(&polygon);
            self.fan(&outline, &polygon);
        }
        self.out
    }

    /// Returns the corners of a polygon, and between them those of its neighbours on its sides.
    fn outline(&mut self, polygon: &[[f64; 2]]) -> Vec<u32> {
        let mut outline = Vec::new();
        for (at, &from) in polygon.iter().enumerate() {
            let to = polygon[(at + 1) % polygon.len()];
            outline.push(self.vertex(from));
            let between = self.between(from, to);
            outline.extend(between.into_iter().map(|uv| self.vertex(uv)));
        }
        outline
    }

    /// Returns the corners that lie on a side strictly between its ends, in order along it. Only sides along lines of
    /// the grid and of slabs have such.
    fn between(&self, from: [f64; 2], to: [f64; 2]) -> Vec<[f64; 2]> {
        let [[u0, v0], [u1, v1]] = [from, to].map(|[u, v]| [key(u), key(v)]);
        let (line, low, high) = if u0 == u1 {
            (self.on_columns.get(&u0), v0.min(v1), v0.max(v1))
        } else if v0 == v1 {
            (self.on_rows.get(&v0), u0.min(u1), u0.max(u1))
        } else {
            return Vec::new();
        };
        let inner = line.into_iter().flat_map(|line| line.range(low + 1..high));
        let place = |&k: &Key| if u0 == u1 { [from[0], number(k)] } else { [number(k), from[1]] };
        let mut inner: Vec<[f64; 2]> = inner.map(place).collect();
        if (v0, u0) > (v1, u1) {
            inner.reverse();
        }
        inner
    }

    fn vertex(&mut self, uv: [f64; 2]) -> u32 {
        let place = uv.map(key);
        if let Some(&index) = self.known.get(&place) {
            return index;
        }
        let index = self.new_vertex(uv);
        self.known.insert(place, index);
        index
    }

    fn new_vertex(&mut self, uv: [f64; 2]) -> u32 {
        let index = u32::try_from(self.out.uv.len()).unwrap_or(u32::MAX);
        self.out.mesh.vertices.push(self.face.point(uv[0], uv[1]));
        self.out.uv.push(uv.into());
        // At a singular point without a limit; vertices and normals have to stay in step.
        let fallback = Vector3::z_axis();
        self.out.normals.push(self.face.normal(uv[0], uv[1]).unwrap_or(fallback));
        index
    }

    /// Adds the triangles of a convex polygon: from a corner, or from its middle where sides have vertices between
    /// their ends, since some triangles from a corner would be flat.
    fn fan(&mut self, outline: &[u32], polygon: &[[f64; 2]]) {
        if outline.len() == polygon.len() {
            let [first, rest @ ..] = outline else { return };
            for pair in rest.windows(2) {
                self.add([*first, pair[0], pair[1]]);
            }
            return;
        }
        let share = 1.0 / polygon.len() as f64;
        let middle = [0, 1].map(|k| polygon.iter().map(|corner| share * corner[k]).sum());
        let middle = self.new_vertex(middle);
        for (at, &from) in outline.iter().enumerate() {
            self.add([middle, from, outline[(at + 1) % outline.len()]]);
        }
    }

    /// Adds a triangle, turned round if the cutter is on the other side.
    fn add(&mut self, [a, b, c]: [u32; 3]) {
        self.out.mesh.triangles.push(if self.face.flip { [a, c, b] } else { [a, b, c] });
    }
}

/// Returns the number of a key.
fn number(key: Key) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
}
