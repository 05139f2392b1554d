//! Bound on the distance between a face and its triangles.

use super::bounds::PatchCell;
use super::geometry::Surface;
use super::mesh::FaceMesh;
use super::nurbs::NurbsSurface;

impl FaceMesh {
    /// Returns an upper bound on the distance between each triangle and the part of `surface` that it stands for
    /// \[mm\]. `None` for surfaces without bounds of their second derivatives: swept ones, and splines that are
    /// degenerate somewhere.
    ///
    /// Over a triangle whose corners differ by at most `h` in u and `k` in v, linear interpolation leaves a surface
    /// by at most `(h² |S_uu| + 2 h k |S_uv| + k² |S_vv|) / 8`. Between a trim and its chords, at most `a` and `b` away
    /// by u and v, a point lies at most `a |S_u| + b |S_v|` from one over a triangle.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::{Point3, Vector3};
    /// use trunnion_geometry::surface::{Face, SphereSurface, Surface, SurfaceFrame};
    ///
    /// let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x())?;
    /// let ball = Face::new(1, Surface::Sphere(SphereSurface::new(frame, 10.0)?), vec![])?;
    /// let mesh = ball.tessellate(0.01)?;
    /// let bound = mesh.deviation_bound(&ball.surface).ok_or("no bound")?;
    /// assert!(bound < 0.02);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn deviation_bound(&self, surface: &Surface) -> Option<f64> {
        let [along_u, along_v, uu, uv, vv] = derivatives(surface)?;
        let trims = self.trim_deviation[0] * along_u + self.trim_deviation[1] * along_v;
        let mut worst = 0.0_f64;
        for triangle in &self.mesh.triangles {
            let corners = triangle.map(|at| self.uv.get(at as usize).copied());
            let [Some(a), Some(b), Some(c)] = corners else { return None };
            let extent = |x: [f64; 3]| {
                let (low, high) = (x[0].min(x[1]).min(x[2]), x[0].max(x[1]).max(x[2]));
                high - low
            };
            let (h, k) = (extent([a.u, b.u, c.u]), extent([a.v, b.v, c.v]));
            worst = worst.max((h * h * uu + 2.0 * h * k * uv + k * k * vv) / 8.0);
        }
        Some(worst + trims)
    }
}

/// Returns upper bounds of `|S_u|`, `|S_v|`, `|S_uu|`, `|S_uv|`, `|S_vv|` over a surface.
fn derivatives(surface: &Surface) -> Option<[f64; 5]> {
    match surface {
        Surface::Plane(_) => Some([1.0, 1.0, 0.0, 0.0, 0.0]),
        Surface::Cylinder(of) => Some([of.radius, 1.0, of.radius, 0.0, 0.0]),
        // The mixed derivative turns the radius by the sine of the latitude.
        Surface::Sphere(of) => Some([of.radius; 5]),
        Surface::Torus(of) => {
            let far = of.major + of.minor;
            Some([far, of.minor, far, of.minor, of.minor])
        }
        Surface::Nurbs(of) => of_spline(of),
        Surface::Cone(_) | Surface::Extrusion(_) | Surface::Revolution(_) => None,
    }
}

fn of_spline(surface: &NurbsSurface) -> Option<[f64; 5]> {
    let [columns, rows] = surface.patch_count();
    let mut most = [0.0_f64; 5];
    for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        let patch = surface.patch(i, j)?;
        let [u, v] = patch.bounds.map(|range| range.width());
        // The bounds are those over the unit square.
        let unit = PatchCell::of_patch(&patch, surface.degree()[1]).derivatives()?;
        for ((most, unit), scale) in most.iter_mut().zip(unit).zip([u, v, u * u, u * v, v * v]) {
            *most = most.max(unit / scale);
        }
    }
    Some(most)
}
